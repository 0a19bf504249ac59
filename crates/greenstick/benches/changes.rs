//! How long a break takes after a change, beside Table 3 of Yang 2019, and how long large meshes take.
//!
//! `cargo bench -p greenstick --bench changes` prints all of it; `-- table`, `-- parameters`, `-- million` or `-- tube`
//! print one part. All work but that of the last part is done by one thread. Times are medians, in brackets the least: on
//! a machine that does other work too, the least is nearer to what the code needs.

use glam::DAffine3;
use greenstick::formats::{self, Format};
use greenstick::fracture::presets::Preset;
use greenstick::fracture::recipe::Recipe;
use greenstick::fracture::recipe::apply_setting;
use greenstick::geometry::{CancelToken, Context, Mesh, Node, Scene};
use greenstick::schema::{Kind, ParameterInfo, Parameters, Value};
use greenstick::wood::primitive;
use greenstick::{Break, BreakRequest, BreakSession, BreakStage};
use std::hint::black_box;
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// Resolution, the paper's ms (i7-6500U), and the goals for smooth and fibrous surfaces in ms.
const CASES: [(u32, f64, [f64; 2]); 3] = [
    (40, 18.0, [0.4, 1.6]),
    (100, 85.0, [2.5, 10.0]),
    (200, 354.0, [10.0, 40.0]),
];
const STYLES: [&str; 2] = ["smooth", "fibrous"];
const RUNS: usize = 25;
/// Time of a change to any one parameter, s, above which it is measured once.
const LONG: f64 = 0.1;

/// Median and least of some times, ms.
#[derive(Clone, Copy)]
struct Times {
    median: f64,
    least: f64,
}

impl std::fmt::Display for Times {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(&format!("{:.2} ({:.2})", self.median, self.least))
    }
}

/// Times of some runs. The run's number is passed on, so that parameters can change.
fn time(runs: usize, mut run: impl FnMut(usize)) -> Times {
    run(runs);
    let mut times: Vec<f64> = (0..runs)
        .map(|i| {
            let start = Instant::now();
            run(i);
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    Times {
        median: times[runs / 2],
        least: times[0],
    }
}

fn scene(mesh: Mesh) -> Scene {
    Scene {
        nodes: vec![Node::new("stem", DAffine3::IDENTITY, mesh)],
        ..Scene::default()
    }
}

/// A break of the middle of a stem.
fn request(n: u32, style: &str) -> BreakRequest {
    let mut recipe = Recipe::default();
    let (rings, sectors) = (format!("rings={n}"), format!("sectors={n}"));
    for setting in [
        &*rings,
        &*sectors,
        &*format!("surface={style}"),
        "inclination=5",
    ] {
        apply_setting(&mut recipe, setting).expect("a parameter");
    }
    BreakRequest {
        texture_width: 256,
        ..BreakRequest::single(Break {
            recipe,
            ..Break::default()
        })
    }
}

fn face(request: &mut BreakRequest) -> &mut greenstick::fracture::parameters::BreakParameters {
    &mut request.breaks[0].recipe.face
}

/// The table of Yang 2019 beside ours.
fn table(branch: &BreakSession) {
    println!(
        "`shape`: a parameter of the heights (the inclination) changes, up to what is drawn: vertex positions, normals and\n\
         texture coordinates and triangles of all that changes; the skin away from the break is the one already there, by\n\
         range. `layout`: the seed of the bundles changes (of a smooth surface, which keeps its layout, the sectors).\n\
         `stem`: the place changes. `meshes`: as `shape`, up to pieces as meshes of their own at the precision of files;\n\
         `files`: up to the bytes of a GLB with textures 256 pixels wide. ms, median (least) of {RUNS}.\n"
    );
    println!(
        "{:<16} {:>15} {:>6} {:>5} {:>6} {:>17} {:>17} {:>17} {:>17} {:>9}",
        "case", "shape", "paper", "goal", "/goal", "layout", "stem", "meshes", "files", "triangles"
    );
    let context = Context::quiet();
    for (n, paper, goals) in CASES {
        for (style, goal) in STYLES.into_iter().zip(goals) {
            let mut session = branch.fork();
            let asked = request(n, style);
            let tilted = |i: usize| {
                let mut asked = asked.clone();
                face(&mut asked).inclination = 5.0 + 0.01 * i as f64;
                asked
            };
            let mut triangles = 0;
            let shape = time(RUNS, |i| {
                let stages = session.stages(&tilted(i), &context).expect("breaks");
                triangles = stages.cut.face.face.triangles.len();
                black_box(stages);
            });
            let layout = time(RUNS, |i| {
                let mut asked = asked.clone();
                face(&mut asked).seed = i as u64;
                if style == "smooth" {
                    face(&mut asked).sectors = n + i as u32 % 2;
                }
                black_box(session.stages(&asked, &context).expect("breaks"));
            });
            let stem = time(3, |i| {
                let mut asked = asked.clone();
                asked.breaks[0].place = format!("{}", 0.5 + 0.001 * i as f64)
                    .parse()
                    .expect("a place");
                black_box(session.stages(&asked, &context).expect("breaks"));
            });
            let meshes = time(RUNS / 3, |i| {
                black_box(session.pieces(&tilted(i), &context).expect("breaks"));
            });
            let files = time(RUNS / 3, |i| {
                let broken = session.broken(&tilted(i), &context).expect("breaks");
                black_box(glb(&broken.scene));
            });
            let name = format!("{n}x{n} {style}");
            println!(
                "{name:<16} {shape:>15} {paper:>6.0} {goal:>5.1} {:>6.2} {layout:>17} {stem:>17} {meshes:>17} {files:>17} \
                 {triangles:>9}",
                shape.median / goal
            );
        }
    }
}

fn glb(scene: &Scene) -> usize {
    let files = formats::write(Format::Glb, scene, "mesh.glb", Default::default());
    files.expect("writes").iter().map(|f| f.bytes.len()).sum()
}

/// A value of a parameter a little off its own; `None` for a list that has nothing in it.
fn changed(info: &ParameterInfo) -> Option<Value> {
    match info.kind {
        Kind::Text { .. } if info.key == "at" => Some(Value::from("0.501")),
        Kind::Text { .. } if info.key.ends_with("_color") => Some(Value::from("#c08040")),
        Kind::Text { .. } => Some(Value::from("Oak, white")),
        _ if info.key == "triangles" => Some(Value::Integer(20_000)),
        _ => info.neighbour(),
    }
}

/// Every parameter of the face, and what else a break may have.
fn parameters(branch: &BreakSession) {
    println!(
        "The stage at which a change starts, and the time of the change up to what is drawn (finish: up to meshes), ms, least\n\
         of 5 (of 1 above 100 ms), by resolution and style. Each change is made to the break of the row above the first change, or of defaults.\n"
    );
    print!("{:<34} {:<8}", "change", "stage");
    for (n, ..) in CASES {
        print!(
            " {:>12} {:>12}",
            format!("{n} smooth"),
            format!("{n} fibrous")
        );
    }
    println!();
    type Change = Box<dyn Fn(&mut BreakRequest)>;
    let mut changes: Vec<(String, Change)> = Vec::new();
    for info in Break::table() {
        let Some(value) = changed(&info) else {
            continue;
        };
        let key = info.key.clone();
        let set = move |r: &mut BreakRequest| r.breaks[0].set(&key, &value).expect("in range");
        changes.push((info.key, Box::new(set)));
    }
    let preset = |name: &'static str| -> Change {
        Box::new(move |r| {
            let recipe = &mut r.breaks[0].recipe;
            let mut face = recipe.face.clone();
            let preset = Preset::find(name).expect("a preset");
            preset.apply(&mut face, &mut recipe.cracks).expect("fits");
            (face.rings, face.sectors) = (recipe.face.rings, recipe.face.sectors);
            face.surface = recipe.face.surface;
            recipe.face = face;
        })
    };
    for name in ["fig17", "fig20", "twist", "green-stick"] {
        changes.push((format!("preset {name}"), preset(name)));
    }
    for (name, change) in &changes {
        let mut stage = None;
        let mut columns = String::new();
        for (n, ..) in CASES {
            for style in STYLES {
                let (started, least) = change_time(branch, n, style, change);
                stage = stage.max(started);
                columns += &format!(" {least:>12.2}");
            }
        }
        let stage = stage.map_or("-", BreakStage::name);
        println!("{name:<34} {stage:<8}{columns}");
    }
}

/// The stage at which a change starts and its least time, ms.
fn change_time(
    branch: &BreakSession,
    n: u32,
    style: &str,
    change: &dyn Fn(&mut BreakRequest),
) -> (Option<BreakStage>, f64) {
    let context = Context::quiet();
    let plain = request(n, style);
    let mut asked = plain.clone();
    change(&mut asked);
    let (mut least, mut started) = (f64::INFINITY, None);
    for _ in 0..5 {
        let mut session = branch.fork();
        session.stages(&plain, &context).expect("breaks");
        let start = Instant::now();
        black_box(session.stages(&asked, &context).expect("breaks"));
        let mut stage = session.started_at();
        if stage.is_none() {
            black_box(session.pieces(&asked, &context).expect("breaks"));
            stage = session.started_at();
        }
        let seconds = start.elapsed().as_secs_f64();
        least = least.min(seconds * 1e3);
        started = stage;
        if seconds > LONG {
            break;
        }
    }
    (started, least)
}

/// A mesh with every triangle split in four until there are at least `least`.
fn subdivided(mut mesh: Mesh, least: usize) -> Mesh {
    while mesh.triangles.len() < least {
        let mut middles = std::collections::HashMap::new();
        let mut triangles = Vec::with_capacity(mesh.triangles.len() * 4);
        for t in std::mem::take(&mut mesh.triangles) {
            let m = [0, 1, 2].map(|k| {
                let (a, b) = (t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3]));
                *middles.entry((a, b)).or_insert_with(|| {
                    let (a, b) = (a as usize, b as usize);
                    mesh.positions
                        .push((mesh.positions[a] + mesh.positions[b]) / 2.0);
                    for attribute in mesh.attributes.values_mut() {
                        for c in 0..attribute.width {
                            let mean = (attribute.at(a)[c] + attribute.at(b)[c]) / 2.0;
                            attribute.data.push(mean);
                        }
                    }
                    mesh.positions.len() as u32 - 1
                })
            });
            triangles.extend([
                [t[0], m[0], m[2]],
                [m[0], t[1], m[1]],
                [m[2], m[1], t[2]],
                m,
            ]);
        }
        mesh.triangles = triangles;
    }
    mesh
}

/// Reading, breaking and writing a mesh of more than a million triangles.
fn million() {
    let options = primitive::BranchOptions {
        around: 134,
        ..Default::default()
    };
    let mesh = subdivided(primitive::branch(&options), 1_000_000);
    let count = mesh.triangles.len();
    let asked = request(40, "fibrous");
    println!("{count} triangles, a bent branch, one thread, s:");
    stages_of(mesh, &asked);
}

/// A closed smooth tube, 10 cm wide and 1 m long, of 1,000 quadrilaterals around and 500 along.
fn tube() {
    let mesh = primitive::cylinder_of(0.05, 1.0, 1000, 500);
    let count = mesh.triangles.len();
    let asked = BreakRequest::default();
    println!(
        "{count} triangles, a smooth tube with the defaults, all threads, s (goal 2.5 in all):"
    );
    stages_of(mesh, &asked);
}

/// Prints the times of the stages of a break of one mesh from a GLB to a GLB.
fn stages_of(mesh: Mesh, asked: &BreakRequest) {
    let files = formats::write(Format::Glb, &scene(mesh), "mesh.glb", Default::default());
    let file = files.expect("writes").swap_remove(0).bytes;
    let start = Instant::now();
    let none = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    let read = formats::read(Format::Glb, &file, "mesh.glb", None, &none).expect("reads");
    let marks = Arc::new(Mutex::new(vec![("read", start.elapsed().as_secs_f64())]));
    let seen = marks.clone();
    let context = Context::new(CancelToken::default(), move |progress| {
        let mut marks = seen.lock().expect("no panic");
        let (name, now) = (progress.stage.name(), start.elapsed().as_secs_f64());
        match marks.last_mut() {
            Some(last) if last.0 == name => last.1 = now,
            Some(last) => {
                last.1 = now;
                marks.push((name, now));
            }
            None => {}
        }
    });
    let broken = BreakSession::new(read).broken(asked, &context);
    let broken = broken.expect("breaks");
    let done = start.elapsed().as_secs_f64();
    black_box(glb(&broken.scene));
    let written = start.elapsed().as_secs_f64();
    let mut marks = marks.lock().expect("no panic");
    if let Some(last) = marks.last_mut() {
        last.1 = done;
    }
    let mut before = 0.0;
    for (name, at) in marks.iter() {
        println!("{name:<16} {:>7.2}", at - before);
        before = *at;
    }
    println!("{:<16} {:>7.2}", "write", written - done);
    println!("{:<16} {written:>7.2}\n", "in all");
}

fn main() {
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let mut branch = BreakSession::new(scene(primitive::branch(&Default::default())));
    let stem = branch.stem(&request(40, "smooth"), &Context::quiet());
    println!(
        "Built-in branch of {} triangles, a machine of {cores} cores.\n",
        stem.expect("has a stem").stem().corners.len()
    );
    let parts: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .collect();
    let wanted = |part: &str| parts.is_empty() || parts.iter().any(|p| p == part);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let one = one.expect("a thread");
    if wanted("table") {
        one.install(|| table(&branch));
    }
    if wanted("parameters") {
        one.install(|| parameters(&branch));
    }
    if wanted("million") {
        one.install(million);
    }
    if wanted("tube") {
        tube();
    }
}
