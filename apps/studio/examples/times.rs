//! Prints how long each kind of change takes until there is something new to draw: in a drag, where the next change comes at once, and
//! after the last answer was finished; and until its own answer is finished, for faces of several finenesses.

use greenstick::RequestFile;
use greenstick::geometry::Context;
use greenstick_studio::model::engine::{Engine, Haste, Job};
use greenstick_studio::model::input::Input;
use std::time::Instant;

/// Repetitions, of which the fastest counts.
const REPEATED: usize = 5;
/// Changes of a drag, of which the middle one counts.
const DRAGGED: usize = 15;
/// The slider of the viewport moves pieces as far as it says, with straight splinters.
const AS_THE_SLIDER: [&str; 3] = [
    "part_clear=false",
    "break.splinter_lean=0",
    "break.splinter_snap=0",
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("face       change        from     dragged ms  drawn ms  finished ms  triangles");
    for n in [40, 100, 200] {
        let fineness = [format!("break.rings={n}"), format!("break.sectors={n}")];
        let fineness = [fineness[0].as_str(), fineness[1].as_str()];
        let mut engine = Engine::default();
        let changes: [(&str, [&str; 2]); 7] = [
            ("height", ["break.slab_height=0.9", "break.slab_height=1.0"]),
            (
                "inclination",
                ["break.inclination=3", "break.inclination=4"],
            ),
            ("seed", ["break.seed=2", "break.seed=3"]),
            ("part", ["part=1cm", "part=2cm"]),
            ("apart", ["part=1cm", "part=2cm"]),
            ("place", ["at=0.45", "at=0.55"]),
            ("species", ["species=white oak", "species=Sitka spruce"]),
        ];
        for (name, settings) in changes {
            let (mut best, mut from, mut triangles) = ([f64::INFINITY; 2], String::new(), 0);
            let mut dragged = Vec::new();
            for i in 0..REPEATED + DRAGGED {
                let is_dragged = i >= REPEATED;
                let setting = settings[i % 2];
                let mut settings = vec![fineness[0], fineness[1], setting];
                if name == "apart" {
                    settings.extend(AS_THE_SLIDER);
                }
                let file = RequestFile::resolve(&[], None, &settings)?;
                let input = Input::built_in();
                let job = Job {
                    input,
                    file,
                    haste: match is_dragged {
                        true => Haste::Drawn,
                        false => Haste::Whole,
                    },
                    sections_of: None,
                };
                let start = Instant::now();
                let mut drawn = f64::INFINITY;
                let mut early = |_| drawn = start.elapsed().as_secs_f64();
                let shown = engine.work(&job, &mut early, &Context::quiet())?;
                let time = start.elapsed().as_secs_f64();
                if is_dragged {
                    dragged.push(drawn.min(time));
                    continue;
                }
                let shown = shown.ok_or("nothing is shown")?;
                if i > 0 {
                    best = [best[0].min(drawn.min(time)), best[1].min(time)];
                    from = format!("{:?}", shown.started_at.ok_or("nothing changed")?);
                    triangles = shown.drawn.indices.len() / 3;
                }
            }
            dragged.sort_by(f64::total_cmp);
            println!(
                "{n:3} × {n:3}  {name:12}  {from:8}  {:10.1}  {:8.1}  {:11.0}  {triangles:9}",
                1e3 * dragged[DRAGGED / 2],
                1e3 * best[0],
                1e3 * best[1]
            );
        }
    }
    Ok(())
}
