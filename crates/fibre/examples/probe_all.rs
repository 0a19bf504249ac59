use greenstick_fibre::*;
use greenstick_geometry::Context;
use greenstick_wood::{moisture::Fallback, species::Species};
use rayon::prelude::*;
fn main() {
    let t = BendTest {
        rods: 25,
        edge: 0.02,
        end: 0.96,
        ..BendTest::default()
    };
    let begin = std::time::Instant::now();
    let _: Vec<()> = Species::all()[..112]
        .par_iter()
        .enumerate()
        .map(|(i, s)| {
            let d = &s.dry;
            if std::env::var("MISSING").is_ok()
                && d.tension_perpendicular.is_some()
                && d.shear_parallel.is_some()
            {
                return;
            }
            let wood = match WoodMaterial::of(s, 12.0, Fallback::TwelvePercent) {
                Ok(w) => w,
                Err(e) => {
                    println!("{i} {} ERR {e}", s.name);
                    return;
                }
            };
            match t.run(&wood, &Context::quiet()) {
                Ok(o) => println!(
                    "{i} {} | {:.4} {:.4} {:.4} work {:.1} {:.1} | {} pts",
                    s.name,
                    o.modulus_of_elasticity / d.modulus_of_elasticity.unwrap(),
                    o.modulus_of_rupture / d.modulus_of_rupture.unwrap(),
                    o.stress_at_first_break.unwrap_or(0.0) / d.modulus_of_rupture.unwrap(),
                    o.work_to_maximum_load / 1e3,
                    d.work_to_maximum_load.unwrap_or(f64::NAN) / 1e3,
                    o.points.len()
                ),
                Err(e) => println!("{i} {} FAIL {e}", s.name),
            }
        })
        .collect();
    println!("{:.1} s", begin.elapsed().as_secs_f64());
}
