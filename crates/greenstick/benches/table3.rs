//! How long a break takes after a change of its parameters, beside Table 3 of Yang 2019, and how long large meshes take.
//!
//! `cargo bench -p greenstick --bench table3`; one thread does all the work. Times are medians, in brackets the least:
//! on a machine that does other work too, the least is nearer to what the code needs. Names of cases after `--`, such as
//! `"200x200 fibrous"`, leave out the others and the large mesh.

use glam::DAffine3;
use greenstick::fracture::cut::{Cut, Ground, Skin, Solid, cut_again};
use greenstick::fracture::parameters::{BreakParameters, Surface};
use greenstick::fracture::{heights, layout};
use greenstick::geometry::{Context, Mesh, Node, Scene};
use greenstick::skin::{face, pieces};
use greenstick::wood::{primitive, stem};
use greenstick::{Prepared, formats, prepare};
use std::hint::black_box;
use std::time::Instant;

/// Resolution, the paper's ms (i7-6500U), and the goals for smooth and fibrous surfaces in ms.
const CASES: [(u32, f64, [f64; 2]); 3] = [
    (40, 18.0, [0.4, 1.6]),
    (100, 85.0, [2.5, 10.0]),
    (200, 354.0, [10.0, 40.0]),
];
const RUNS: usize = 25;

/// Median and least time of some runs, ms. The run's number is passed on, so that parameters can change.
fn time(runs: usize, mut run: impl FnMut(usize)) -> (f64, f64) {
    run(runs);
    let mut times: Vec<f64> = (0..runs)
        .map(|i| {
            let start = Instant::now();
            run(i);
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    (times[runs / 2], times[0])
}

/// As [`time`], with something made before each run that is not timed.
fn time_after<T>(runs: usize, before: impl Fn() -> T, run: impl Fn(T)) -> (f64, f64) {
    let mut times: Vec<f64> = (0..runs)
        .map(|_| {
            let given = before();
            let start = Instant::now();
            run(given);
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    (times[runs / 2], times[0])
}

fn scene(mesh: Mesh) -> Scene {
    Scene {
        nodes: vec![Node {
            name: "stem".into(),
            transform: DAffine3::IDENTITY,
            mesh: mesh.into(),
            parent: None,
        }],
        ..Scene::default()
    }
}

fn prepared(scene: Scene) -> Prepared {
    let place = stem::StemLocation::Fraction(0.5);
    prepare(scene, &place, &Default::default(), &Context::quiet())
        .expect("the built-in branch has a stem")
}

fn parameters(n: u32, surface: Surface, inclination: f64) -> BreakParameters {
    BreakParameters {
        rings: n,
        sectors: n,
        surface,
        inclination,
        ..Default::default()
    }
}

/// The case's name, where it was asked for.
fn wanted(n: u32, surface: Surface) -> Option<String> {
    let name = format!("{n}x{n} {surface:?}").to_lowercase();
    let mut asked = names();
    (asked.len() == 0 || asked.any(|a| a == name)).then_some(name)
}

/// Names of cases on the command line.
fn names() -> impl ExactSizeIterator<Item = String> {
    let given = std::env::args().skip(1);
    let names: Vec<String> = given.filter(|a| !a.starts_with('-')).collect();
    names.into_iter()
}

fn table(prepared: &Prepared) {
    println!(
        "Surface, cut, broken face and skin of both pieces, ready to be drawn: vertex positions, normals and"
    );
    println!(
        "texture coordinates and triangles of all that changes; the skin away from the break is the one already"
    );
    println!(
        "there, by range. `shape`: a parameter of the shape (the inclination) changes. `seed`: the layout of the bundles changes too"
    );
    println!(
        "(rings, sectors; the smooth one keeps its layout, so its resolution changes). `meshes`: both pieces as"
    );
    println!(
        "meshes of their own with all attributes, for export. ms, median (least) of {RUNS}.\n"
    );
    println!(
        "{:<16} {:>17} {:>17} {:>17} {:>7} {:>7} {:>12} {:>9}",
        "case", "shape", "seed", "meshes", "paper", "goal", "median/goal", "triangles"
    );
    for (n, paper, goals) in CASES {
        for (surface, goal) in [Surface::Smooth, Surface::Fibrous].into_iter().zip(goals) {
            let Some(name) = wanted(n, surface) else {
                continue;
            };
            let mut triangles = 0;
            let shape = time(RUNS, |i| {
                let p = parameters(n, surface, 5.0 + 0.01 * i as f64);
                let broken = prepared.drawn(&p, 1.0, 1).expect("breaks");
                triangles = broken.face.triangles.len();
                black_box(broken);
            });
            let seed = time(RUNS, |i| {
                let mut p = parameters(n, surface, 5.0);
                p.seed = i as u64;
                if surface == Surface::Smooth {
                    p.sectors = n + i as u32 % 2;
                }
                black_box(prepared.drawn(&p, 1.0, 1).expect("breaks"));
            });
            let meshes = time(RUNS / 3, |i| {
                let p = parameters(n, surface, 5.0 + 0.01 * i as f64);
                black_box(prepared.model(&p, 1.0, 1).expect("breaks"));
            });
            let show = |t: (f64, f64)| format!("{:.2} ({:.2})", t.0, t.1);
            println!(
                "{name:<16} {:>17} {:>17} {:>17} {paper:>7.0} {goal:>7.1} {:>12.2} {triangles:>9}",
                show(shape),
                show(seed),
                show(meshes),
                shape.0 / goal,
            );
        }
    }
}

/// The same by stages, each timed by itself.
fn stages(prepared: &Prepared) {
    let stem = &prepared.found.stem;
    let mesh = &prepared.scene.nodes[prepared.found.node].mesh;
    let solid = Solid {
        triangles: &prepared.corners,
        points: &prepared.grain,
        shell: &prepared.found.shell,
        limb: &prepared.found.limb,
    };
    let skin = Skin::new(&solid, stem.usable);
    let chart = stem::LayeredGrain::transformed(&prepared.layers, &prepared.transform().inverse());
    let levels: Vec<f64> = prepared.layers.levels().collect();
    let mut vertices = vec![0; solid.points.len()];
    for (vertex, &point) in prepared.points.iter().enumerate() {
        vertices[point as usize] = vertex as u32;
    }
    let source = pieces::Source {
        mesh,
        points: &prepared.points,
        vertices: &vertices,
        grain: &prepared.grain,
        chart: &chart,
    };
    println!(
        "\nBy stages; layout and its ground only where rings, sectors or seed change. `part`: absorbing chips and parting the"
    );
    println!("face at the levels of the grain. ms, least.\n");
    println!(
        "{:<16} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}",
        "case", "layout", "ground", "heights", "cut", "part", "face", "skin"
    );
    for (n, _, _) in CASES {
        for surface in [Surface::Smooth, Surface::Fibrous] {
            let Some(name) = wanted(n, surface) else {
                continue;
            };
            let p = parameters(n, surface, 5.0);
            let smooth = surface == Surface::Smooth;
            let options = layout::LayoutOptions {
                rings: n as usize,
                sectors: n as usize,
                reach: prepared.extent.reach,
                radius: prepared.extent.radius,
                arc: prepared.extent.arc,
                bark: Some(prepared.extent.bark),
                seed: p.seed,
            };
            let setting = heights::Setting {
                radius: stem.radius,
                place: stem.location,
                usable: stem.usable,
                pith: stem.rings.pith(),
                wedge: None,
                relief: 1.0,
            };
            let lay = || match smooth {
                true => layout::smooth(&stem.rings, &options),
                false => layout::fibrous(&stem.rings, &options),
            };
            let bundles = lay();
            let rise = || match smooth {
                true => heights::smooth(&bundles, &p, &setting),
                false => heights::fibrous(&bundles, &p, &setting),
            };
            let ground = Ground::new(&skin, &bundles.layout);
            let heights = rise();
            let sever = || cut_again(&solid, &skin, &ground, &heights.surface).expect("cuts");
            let part = |mut cut: Cut| {
                cut.absorb_chips_again(&solid, &skin);
                cut.part_at(&prepared.grain, &levels);
                cut
            };
            let cut = part(sever());
            let proportions = p.proportions();
            let inner = pieces::InnerWood {
                stem,
                bundles: &bundles,
                zone: &|rho| proportions.zone_at(rho, 0.0).code(),
                material: 1,
                square: (glam::DVec2::ZERO, 0.05),
                smooth,
            };
            let made = face::face(&source, &cut, &inner);
            let times = [
                time(RUNS, |_| drop(black_box(lay()))),
                time(RUNS, |_| {
                    black_box(Ground::new(&skin, &bundles.layout));
                }),
                time(RUNS, |_| drop(black_box(rise()))),
                time(RUNS, |_| drop(black_box(sever()))),
                time_after(RUNS, sever, |cut| drop(black_box(part(cut)))),
                time(RUNS, |_| {
                    black_box(face::face(&source, &cut, &inner));
                }),
                time(RUNS, |_| {
                    black_box(pieces::patch(&source, &cut, &skin, &made.places));
                }),
            ];
            let times: String = times.iter().map(|t| format!(" {:>8.3}", t.1)).collect();
            println!("{name:<16}{times}");
        }
    }
}

/// A mesh with every triangle parted in four until there are at least `least`.
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
        mesh.materials.clear();
    }
    mesh
}

/// Reading, breaking and writing a mesh of more than a million triangles.
fn million() {
    let mesh = subdivided(
        primitive::branch(&primitive::BranchOptions {
            around: 134,
            ..Default::default()
        }),
        1_000_000,
    );
    let count = mesh.triangles.len();
    let glb = |scene: &Scene| {
        let mut scene = scene.clone();
        scene.materials.push(Default::default());
        formats::write(formats::Format::Glb, &scene, "mesh.glb", Default::default())
            .expect("writes")
    };
    let file = glb(&scene(mesh));
    let start = Instant::now();
    let mut marks = Vec::new();
    let mut mark = |name: &'static str| marks.push((name, start.elapsed().as_secs_f64()));
    let none = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    let read = formats::read(
        formats::Format::Glb,
        &file[0].bytes,
        "mesh.glb",
        None,
        &none,
    );
    let read = read.expect("reads");
    mark("read");
    let prepared = prepared(read);
    mark("find the stem");
    let p = parameters(40, Surface::Fibrous, 5.0);
    let broken = prepared.drawn(&p, 1.0, 0).expect("breaks");
    mark("break");
    let pieces = [false, true].map(|upper| prepared.piece(&broken, upper));
    mark("make meshes");
    for piece in pieces {
        black_box(glb(&scene(piece)));
    }
    mark("write");
    println!(
        "\n{count} triangles read from GLB, broken (40x40 fibrous) and written as two GLB, s (goal 3 in all):"
    );
    let mut before = 0.0;
    for (name, at) in marks {
        println!("{name:<16} {:>7.2}", at - before);
        before = at;
    }
    println!("{:<16} {before:>7.2}", "in all");
    let again = time(5, |i| {
        let p = parameters(40, Surface::Fibrous, 5.0 + 0.1 * i as f64);
        black_box(prepared.drawn(&p, 1.0, 1).expect("breaks"));
    });
    println!("break again, ms  {:>7.2} ({:.2})", again.0, again.1);
}

fn main() {
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let prepared = prepared(scene(primitive::branch(&Default::default())));
    println!(
        "Built-in branch of {} triangles, one thread on a machine of {cores} cores.\n",
        prepared.corners.len()
    );
    table(&prepared);
    stages(&prepared);
    if names().len() == 0 {
        million();
    }
}
