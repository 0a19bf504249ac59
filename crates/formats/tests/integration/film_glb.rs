//! GLB films, read by an independent small reader and evaluated with the formulas of the glTF specification.

use crate::common::bundle::{Bend, film};
use glam::{DAffine3, DMat4, DQuat, DVec3};
use greenstick_formats::film::{FilmError, FilmReport, GlbOptions, write_glb};
use greenstick_geometry::{Context, Film, Mesh, Motion, Pose, RigidBody};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{Cursor, Seek, SeekFrom};

fn written(film: &Film, motion: &mut Bend, options: GlbOptions) -> (Vec<u8>, FilmReport) {
    let mut out = Cursor::new(Vec::new());
    let report = write_glb(
        film,
        motion,
        "film.glb",
        &options,
        &mut out,
        &Context::quiet(),
    )
    .unwrap();
    assert_eq!(report.bytes, out.get_ref().len() as u64);
    (out.into_inner(), report)
}

/// A parsed GLB.
struct Glb {
    json: Value,
    binary: Vec<u8>,
}

impl Glb {
    fn new(bytes: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&bytes[..4], word(8)), (&b"glTF"[..], bytes.len()));
        let json = word(12);
        assert_eq!(word(20 + json), bytes.len() - 28 - json);
        Glb {
            json: serde_json::from_slice(&bytes[20..20 + json]).unwrap(),
            binary: bytes[28 + json..].to_vec(),
        }
    }

    fn list(&self, key: &str) -> &[Value] {
        self.json[key].as_array().map_or(&[], Vec::as_slice)
    }

    fn numbers(&self, accessor: &Value) -> Vec<Vec<f64>> {
        let accessor = &self.list("accessors")[index(accessor)];
        let view = &self.list("bufferViews")[index(&accessor["bufferView"])];
        let start =
            index(&view["byteOffset"]) + accessor["byteOffset"].as_u64().unwrap_or(0) as usize;
        let width = match accessor["type"].as_str().unwrap() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let (size, code) = match index(&accessor["componentType"]) {
            5121 => (1, 'b'),
            5123 => (2, 's'),
            5125 => (4, 'i'),
            _ => (4, 'f'),
        };
        let count = index(&accessor["count"]);
        let end = start + count * width * size;
        assert!(end <= index(&view["byteOffset"]) + index(&view["byteLength"]));
        let numbers: Vec<f64> = self.binary[start..end]
            .chunks_exact(size)
            .map(|b| match code {
                'b' => f64::from(b[0]),
                's' => f64::from(u16::from_le_bytes([b[0], b[1]])),
                'i' => f64::from(u32::from_le_bytes(b.try_into().unwrap())),
                _ => f64::from(f32::from_le_bytes(b.try_into().unwrap())),
            })
            .collect();
        numbers.chunks_exact(width).map(<[f64]>::to_vec).collect()
    }

    fn node(&self, name: &str) -> usize {
        let found = self.list("nodes").iter().position(|n| n["name"] == name);
        found.unwrap_or_else(|| panic!("no node {name}"))
    }

    /// The transform of each node to the world at `time`, which must be a key.
    fn world(&self, time: f64) -> Vec<DAffine3> {
        let vector = |v: &Value| -> Option<Vec<f64>> {
            Some(v.as_array()?.iter().map(|n| n.as_f64().unwrap()).collect())
        };
        let nodes = self.list("nodes");
        let mut parts: Vec<(DVec3, DQuat, DVec3)> = nodes
            .iter()
            .map(|n| {
                assert!(n["matrix"].is_null());
                let t = vector(&n["translation"]).map_or(DVec3::ZERO, |v| DVec3::from_slice(&v));
                let r = vector(&n["rotation"]).map_or(DQuat::IDENTITY, |v| DQuat::from_slice(&v));
                let s = vector(&n["scale"]).map_or(DVec3::ONE, |v| DVec3::from_slice(&v));
                (t, r, s)
            })
            .collect();
        for animation in self.list("animations") {
            for channel in animation["channels"].as_array().unwrap() {
                let sampler = &animation["samplers"][index(&channel["sampler"])];
                let times = self.numbers(&sampler["input"]).concat();
                let key = times.iter().rposition(|&t| t <= time + 1e-6).unwrap();
                let value = &self.numbers(&sampler["output"])[key];
                let part = &mut parts[index(&channel["target"]["node"])];
                match channel["target"]["path"].as_str().unwrap() {
                    "translation" => part.0 = DVec3::from_slice(value),
                    _ => part.1 = DQuat::from_slice(value),
                }
            }
        }
        let local = |(t, r, s): (DVec3, DQuat, DVec3)| {
            DAffine3::from_scale_rotation_translation(s, r.normalize(), t)
        };
        let mut world: Vec<DAffine3> = parts.into_iter().map(local).collect();
        for (n, node) in nodes.iter().enumerate() {
            for child in node["children"].as_array().unwrap_or(&Vec::new()) {
                // In these files parents follow their children, and are not animated.
                assert_eq!(world[n], DAffine3::IDENTITY);
                world[index(child)] = world[n] * world[index(child)];
            }
        }
        world
    }

    /// The positions of the vertices of a node at `time`, by primitive.
    fn play(&self, node: usize, time: f64) -> Vec<Vec<DVec3>> {
        let world = self.world(time);
        let json = &self.list("nodes")[node];
        let mesh = &self.list("meshes")[index(&json["mesh"])];
        let joints: Option<Vec<DMat4>> = json["skin"].as_u64().map(|s| {
            let skin = &self.list("skins")[s as usize];
            let inverse = self.numbers(&skin["inverseBindMatrices"]);
            let nodes = skin["joints"].as_array().unwrap().iter().map(index);
            let both = nodes.zip(inverse);
            both.map(|(n, m)| {
                DMat4::from(world[n]) * DMat4::from_cols_array(&m.try_into().unwrap())
            })
            .collect()
        });
        let primitives = mesh["primitives"].as_array().unwrap().iter();
        primitives
            .map(|p| {
                let attributes = &p["attributes"];
                let rest = self.numbers(&attributes["POSITION"]);
                let rest = rest.iter().map(|p| DVec3::from_slice(p));
                let Some(joints) = &joints else {
                    return rest.map(|p| world[node].transform_point3(p)).collect();
                };
                let mut sums = vec![DVec3::ZERO; rest.len()];
                for set in 0.. {
                    let key = format!("JOINTS_{set}");
                    if attributes[&key].is_null() {
                        break;
                    }
                    let follows = self.numbers(&attributes[&key]);
                    let weights = self.numbers(&attributes[format!("WEIGHTS_{set}")]);
                    for (v, p) in rest.clone().enumerate() {
                        for (j, w) in follows[v].iter().zip(&weights[v]) {
                            sums[v] += joints[*j as usize].transform_point3(p) * *w;
                        }
                    }
                }
                sums
            })
            .collect()
    }
}

fn index(value: &Value) -> usize {
    value.as_u64().unwrap() as usize
}

/// Positions in the order of a file: for each material, in order of first use, those of its triangles.
fn by_material(mesh: &Mesh, places: &[DVec3]) -> Vec<Vec<DVec3>> {
    let mut parts: Vec<(u32, Vec<u32>)> = Vec::new();
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let material = mesh.material(t);
        match parts.iter_mut().find(|p| p.0 == material) {
            Some(part) => part.1.extend(triangle),
            None => parts.push((material, triangle.to_vec())),
        }
    }
    let places = |mut used: Vec<u32>| {
        used.sort_unstable();
        used.dedup();
        used.into_iter().map(|v| places[v as usize]).collect()
    };
    parts.into_iter().map(|p| places(p.1)).collect()
}

/// The largest difference between the file and the film, over all pieces and some frames.
fn largest_error(film: &Film, motion: &mut Bend, glb: &Glb) -> f64 {
    let mut poses = vec![Pose::IDENTITY; film.joints.len()];
    let mut places = Vec::new();
    let mut worst: f64 = 0.0;
    for frame in [0, 1, motion.frames / 2, motion.frames - 1] {
        motion.poses(frame, &mut poses).unwrap();
        for (p, piece) in film.pieces.iter().enumerate() {
            film.pose_piece(p, &poses, &mut places);
            let right = by_material(&piece.mesh, &places).concat();
            let played = glb.play(glb.node(&piece.name), motion.time(frame)).concat();
            assert_eq!(right.len(), played.len());
            let away = right.iter().zip(&played).map(|(a, b)| a.distance(*b));
            worst = away.fold(worst, f64::max);
        }
        for RigidBody { node, joint } in &film.bodies {
            let joint = *joint as usize;
            let map = poses[joint].affine() * film.joints[joint].rest.inverse() * node.transform;
            let places: Vec<DVec3> = node
                .mesh
                .positions
                .iter()
                .map(|p| map.transform_point3(*p))
                .collect();
            let right = by_material(&node.mesh, &places).concat();
            // The joint has no node of its own, because nothing else follows it.
            let played = glb.play(glb.node(&node.name), motion.time(frame)).concat();
            let away = right.iter().zip(&played).map(|(a, b)| a.distance(*b));
            worst = away.fold(worst, f64::max);
        }
    }
    worst
}

#[test]
fn a_file_reproduces_the_film() {
    for influences in [2, 4, 7] {
        let film = film(30, 40, influences);
        let mut motion = Bend::new(&film, 50);
        let (bytes, report) = written(&film, &mut motion, GlbOptions::default());
        let glb = Glb::new(&bytes);
        let worst = largest_error(&film, &mut motion, &glb);
        // Half a unit in the last place of 1 m is 6e-8; several rounding errors add up.
        assert!(worst < 5e-7, "{influences}: {worst}");
        assert_eq!((report.skinned, report.rigid, report.joints), (1, 2, 30));
        assert_eq!(report.reductions, []);
        // The first joint of the stick does not move, and the hammer does not rotate.
        assert_eq!((report.channels, report.constant), (64, 3));
        let sets = if influences > 4 { 2 } else { 1 };
        let attributes = &glb.list("meshes")[1]["primitives"][0]["attributes"];
        assert_eq!(attributes["JOINTS_1"].is_null(), sets == 1);
        assert_eq!(glb.list("nodes")[glb.node("stick")]["extras"]["rods"], 7);
    }
}

#[test]
fn rotations_keep_their_sign() {
    let film = film(3, 4, 2);
    let (bytes, _) = written(&film, &mut Bend::new(&film, 90), GlbOptions::default());
    let glb = Glb::new(&bytes);
    let samplers = glb.list("animations")[0]["samplers"].as_array().unwrap();
    let mut steps = 0;
    for output in samplers.iter().map(|s| glb.numbers(&s["output"])) {
        for pair in output.windows(2).filter(|p| p[0].len() == 4) {
            let dot: f64 = pair[0].iter().zip(&pair[1]).map(|(a, b)| a * b).sum();
            assert!(dot > 0.9, "{pair:?}");
            steps += 1;
        }
    }
    assert_eq!(steps, 3 * 89);
}

#[test]
fn the_reported_error_is_the_actual_error() {
    let film = film(30, 40, 8);
    let exact = film.pieces[0].binding.influences(100).count();
    assert_eq!(exact, 8);
    let limits = [(Some(12), 8), (Some(5), 8), (Some(1), 8), (Some(30), 4)];
    let mut before = 0.0;
    for (max_joints, max_influences) in limits {
        let options = GlbOptions {
            max_joints,
            max_influences,
        };
        // More frames than those in which joints are compared.
        let mut motion = Bend::new(&film, 40);
        let (bytes, report) = written(&film, &mut motion, options);
        let glb = Glb::new(&bytes);
        let [stick] = report.reductions.as_slice() else {
            panic!("{:?}", report.reductions);
        };
        assert_eq!(stick.joints, [30, max_joints.unwrap()]);
        assert!(
            glb.list("skins")
                .iter()
                .all(|s| { s["joints"].as_array().unwrap().len() <= max_joints.unwrap() })
        );
        // The curvature grows, so that the last frame has the largest error.
        assert_eq!(stick.frame, 39);
        let found = largest_error(&film, &mut motion, &glb);
        assert!((found - stick.error).abs() < 5e-7, "{found} {stick:?}");
        if max_influences == 8 {
            assert!(stick.error > before, "fewer joints cannot be more exact");
            before = stick.error;
        }
    }
}

#[test]
fn joints_that_move_alike_are_merged() {
    /// Two groups of joints, each of which moves as a rigid body.
    struct Groups(Film);
    impl Motion for Groups {
        type Error = std::convert::Infallible;
        fn frames(&self) -> usize {
            9
        }
        fn time(&self, frame: usize) -> f64 {
            frame as f64
        }
        fn poses(&mut self, frame: usize, poses: &mut [Pose]) -> Result<(), Self::Error> {
            for (k, (pose, joint)) in poses.iter_mut().zip(&self.0.joints).enumerate() {
                let side = if k < 17 { 0.3 } else { -0.2 };
                let turn = DQuat::from_rotation_x(side * frame as f64);
                *pose = Pose {
                    translation: turn * joint.rest.translation + DVec3::X * side,
                    rotation: turn * joint.rest.rotation,
                };
            }
            Ok(())
        }
    }
    let film = film(30, 40, 5);
    for (most, exact) in [(2, true), (1, false)] {
        let options = GlbOptions {
            max_joints: Some(most),
            ..GlbOptions::default()
        };
        let mut out = Cursor::new(Vec::new());
        let mut motion = Groups(film.clone());
        let context = Context::quiet();
        let report = write_glb(&film, &mut motion, "x", &options, &mut out, &context).unwrap();
        assert_eq!(report.reductions[0].joints, [30, most]);
        // Weights are rounded to single precision.
        assert_eq!(report.error() < 1e-6, exact, "{}", report.error());
    }
}

#[test]
fn long_films_are_written_in_blocks() {
    // More poses than fit into a block.
    let film = film(700, 20, 3);
    let mut motion = Bend::new(&film, 1000);
    let (bytes, _) = written(&film, &mut motion, GlbOptions::default());
    let glb = Glb::new(&bytes);
    let mut poses = vec![Pose::IDENTITY; film.joints.len()];
    let half = glb.node("half");
    for frame in [0, 427, 428, 429, 999] {
        motion.poses(frame, &mut poses).unwrap();
        let world = glb.world(motion.time(frame))[half];
        assert!(world.abs_diff_eq(poses[700].affine(), 3e-5), "{frame}");
    }
}

#[test]
fn a_film_may_start_within_a_file() {
    let film = film(3, 4, 2);
    let alone = written(&film, &mut Bend::new(&film, 9), GlbOptions::default()).0;
    let mut out = Cursor::new(vec![7; 5]);
    out.seek(SeekFrom::End(0)).unwrap();
    let options = GlbOptions::default();
    let mut motion = Bend::new(&film, 9);
    write_glb(
        &film,
        &mut motion,
        "x",
        &options,
        &mut out,
        &Context::quiet(),
    )
    .unwrap();
    assert_eq!(out.position(), alone.len() as u64 + 5);
    assert_eq!(out.into_inner()[5..], alone);
}

/// A motion with a fault.
struct Broken {
    good: Bend,
    time: fn(usize) -> f64,
    change: fn(usize, &mut [Pose]),
    fails: bool,
}

impl Motion for Broken {
    type Error = std::io::Error;

    fn frames(&self) -> usize {
        self.good.frames
    }

    fn time(&self, frame: usize) -> f64 {
        (self.time)(frame)
    }

    fn poses(&mut self, frame: usize, poses: &mut [Pose]) -> Result<(), Self::Error> {
        if self.fails && frame == 3 {
            return Err(std::io::Error::other("the store ends"));
        }
        let _ = self.good.poses(frame, poses);
        (self.change)(frame, poses);
        Ok(())
    }
}

#[test]
fn invalid_films_are_refused() {
    let good = film(3, 4, 2);
    let valid = Case {
        message: "",
        frames: 5,
        time: |f| f as f64,
        change: |_, _| {},
        fails: false,
        options: GlbOptions::default(),
    };
    let nan_in_frame_2: fn(usize, &mut [Pose]) = |f, p| {
        if f == 2 {
            p[1].translation.x = f64::NAN;
        }
    };
    let with_time = |message, time| Case {
        message,
        time,
        ..valid
    };
    let with_poses = |message, change| Case {
        message,
        change,
        ..valid
    };
    let cases = [
        Case {
            message: "no frames",
            frames: 0,
            ..valid
        },
        with_time("frame 1 has the time 0 s", |_| 0.0),
        with_time("frame 0 has the time -1 s", |f| f as f64 - 1.0),
        with_time("NaN s", |_| f64::NAN),
        with_poses("in frame 2", nan_in_frame_2),
        with_poses("joint 0 has the pose", |_, p| p[0].translation.y = 1e300),
        Case {
            message: "frame 3 are not available: the store ends",
            fails: true,
            ..valid
        },
        Case {
            message: "0 joints for a skin",
            options: GlbOptions {
                max_joints: Some(0),
                ..GlbOptions::default()
            },
            ..valid
        },
    ];
    for case in cases {
        let mut motion = Broken {
            good: Bend::new(&good, case.frames),
            time: case.time,
            change: case.change,
            fails: case.fails,
        };
        let mut out = Cursor::new(Vec::new());
        let quiet = Context::quiet();
        let error = write_glb(&good, &mut motion, "x.glb", &case.options, &mut out, &quiet);
        let error = error.unwrap_err();
        let message = case.message;
        assert!(error.to_string().contains(message), "{message}: {error}");
        assert_eq!(matches!(error, FilmError::Motion { .. }), case.fails);
    }
}

/// A fault of a film, and the message that it gives.
#[derive(Clone, Copy)]
struct Case {
    message: &'static str,
    frames: usize,
    time: fn(usize) -> f64,
    change: fn(usize, &mut [Pose]),
    fails: bool,
    options: GlbOptions,
}

#[test]
fn films_without_motion_or_shape_are_written() {
    let mut still = film(3, 4, 2);
    still.pieces.clear();
    still.bodies.clear();
    let (bytes, report) = written(&still, &mut Bend::new(&still, 9), GlbOptions::default());
    assert!(Glb::new(&bytes).json["animations"].is_null());
    assert_eq!((report.rigid, report.skinned, report.channels), (0, 0, 0));
    still.fixed.clear();
    let mut out = Cursor::new(Vec::new());
    let mut motion = Bend::new(&still, 9);
    let options = GlbOptions::default();
    let error = write_glb(
        &still,
        &mut motion,
        "x",
        &options,
        &mut out,
        &Context::quiet(),
    );
    assert!(error.unwrap_err().to_string().contains("no triangles"));
    let names: BTreeMap<_, _> = still.joints.iter().map(|j| (&j.name, ())).collect();
    assert_eq!(names.len(), 6);
}
