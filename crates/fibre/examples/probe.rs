use greenstick_fibre::*;
use greenstick_geometry::Context;
use greenstick_wood::{moisture::Fallback, species::Species};
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let s = Species::find(&a[1]).unwrap();
    let wood = WoodMaterial::of(s, 12.0, Fallback::TwelvePercent).unwrap();
    let mut t = BendTest::default();
    if a.len() > 2 {
        t.rods = a[2].parse().unwrap();
    }
    if a.len() > 3 {
        t.edge = a[3].parse().unwrap();
    }
    if let Ok(e) = std::env::var("END") {
        t.end = e.parse().unwrap();
    }
    let begin = std::time::Instant::now();
    let o = t.run(&wood, &Context::quiet()).unwrap();
    if a.len() > 4 {
        for p in &o.points {
            println!("{:.5} {:.1} {}", p.deflection * 1e3, p.load, p.broken);
        }
    }
    let d = &s.dry;
    println!(
        "rods {} edge {:.4} E {:.3} MOR {:.3} first {:.3} work {:.1} vs {:.1} kJ/m3  {:.1} s, {} points",
        o.rods,
        o.edge,
        o.modulus_of_elasticity / d.modulus_of_elasticity.unwrap(),
        o.modulus_of_rupture / d.modulus_of_rupture.unwrap(),
        o.stress_at_first_break.unwrap_or(0.0) / d.modulus_of_rupture.unwrap(),
        o.work_to_maximum_load / 1e3,
        d.work_to_maximum_load.unwrap_or(0.0) / 1e3,
        begin.elapsed().as_secs_f64(),
        o.points.len()
    );
}
