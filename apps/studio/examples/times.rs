//! Prints how long each kind of change takes until there is something new to draw, for faces of several finenesses.

use greenstick::RequestFile;
use greenstick::geometry::Context;
use greenstick_studio::model::engine::{Engine, Job};
use greenstick_studio::model::input::Input;
use std::time::Instant;

/// Repetitions, of which the fastest counts.
const REPEATED: usize = 5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("face       change        from      ms  triangles");
    for n in [40, 100, 200] {
        let fineness = [format!("break.rings={n}"), format!("break.sectors={n}")];
        let fineness = [fineness[0].as_str(), fineness[1].as_str()];
        let mut engine = Engine::default();
        let changes: [(&str, [&str; 2]); 6] = [
            ("height", ["break.slab_height=0.9", "break.slab_height=1.0"]),
            (
                "inclination",
                ["break.inclination=3", "break.inclination=4"],
            ),
            ("seed", ["break.seed=2", "break.seed=3"]),
            ("apart", ["part=1cm", "part=2cm"]),
            ("place", ["at=0.45", "at=0.55"]),
            ("species", ["species=white oak", "species=Sitka spruce"]),
        ];
        for (name, settings) in changes {
            let (mut best, mut from, mut triangles) = (f64::INFINITY, String::new(), 0);
            for i in 0..REPEATED {
                let setting = settings[i % 2];
                let file = RequestFile::resolve(&[], None, &[fineness[0], fineness[1], setting])?;
                let input = Input::built_in();
                let job = Job {
                    input,
                    file,
                    coarse: false,
                };
                let start = Instant::now();
                let shown = engine.work(&job, &Context::quiet())?;
                let time = start.elapsed().as_secs_f64();
                if i > 0 && time < best {
                    best = time;
                    from = format!("{:?}", shown.started_at.ok_or("nothing changed")?);
                    triangles = shown.drawn.indices.len() / 3;
                }
            }
            println!(
                "{n:3} × {n:3}  {name:12}  {from:8} {:5.0}  {triangles:9}",
                1e3 * best
            );
        }
    }
    Ok(())
}
