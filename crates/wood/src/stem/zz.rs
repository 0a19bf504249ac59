use super::polygon;
use super::shells;
use super::surface::Surface;
use glam::*;
#[path = "../../tests/support/mod.rs"]
mod support;
#[test]
fn probe() {
    let m = support::gltf("scans/homecart_cutting_board.gltf").unwrap();
    let p = shells::points(&m, 0.0);
    let s = shells::shells(0, &p);
    let f = Surface::new(&p, &s[0]);
    let k = super::seed::plank(&f).unwrap();
    println!("{k:?} {}", super::seed::is_board(&f, &k));
    for i in 0..21 {
        let c = super::trace::section(
            &f,
            k.end + k.direction * (k.size[0] * (i as f64 + 0.5) / 21.0),
            k.direction,
            k.size[1],
        );
        if let Some(c) = c {
            let (x, y) = super::trace::across(c.normal);
            let fl: Vec<DVec2> = c
                .points
                .iter()
                .map(|q| DVec2::new(q.dot(x), q.dot(y)))
                .collect();
            let r = polygon::smallest_rectangle(&fl).unwrap();
            println!(
                "{i} {} {:?} {} rivals {}",
                c.area,
                r,
                c.area / r.width / r.thickness,
                c.rivals
            );
        } else {
            println!("{i} none");
        }
    }
    let m = support::obj("scans/stump.obj").unwrap();
    let p = shells::points(&m, 0.0);
    let s = shells::shells(0, &p);
    let f = Surface::new(&p, &s[0]);
    for y in [0.05, 0.1, 0.15, 0.2] {
        let c = super::trace::settle(&f, DVec3::new(0.0, y, 0.0), DVec3::Y);
        println!("{y} {:?}", c.map(|c| (c.area, c.centre, c.normal)));
    }
    let t = super::seed::main_stem(&f).unwrap();
    println!("{} {:?} {:?}", t.volume(), t.ends, t.tips);
    for (c, s) in t.cuts.iter().zip(&t.states) {
        println!(
            "{:.3} {:.3} {:.3} {:.3} {s:?} {}",
            c.centre, c.normal, c.area, c.reach, c.rivals
        );
    }
}
