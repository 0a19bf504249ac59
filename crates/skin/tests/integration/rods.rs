//! The skin of rods: sound, full of wood and in the right pieces whatever breaks, and where the rods are.

use crate::common::{Grown, MATERIALS, grown, wood};
use glam::{DAffine3, DQuat, DVec3};
use greenstick_fibre::Cause;
use greenstick_fibre::Loads;
use greenstick_fibre::State;
use greenstick_fibre::store::Frame;
use greenstick_fibre::topology::break_up;
use greenstick_geometry::check::CheckOptions;
use greenstick_geometry::{Film, Joint, Mesh};
use greenstick_skin::rods::{
    FractureState, NonmanifoldSplits, Outline, RodSkin, RodSkinError, RodSkinOptions, Wood,
    columns, frame_poses, rod_skin,
};
use greenstick_wood::noise::unit;
use greenstick_wood::primitive::{self, BranchOptions};
use std::collections::BTreeMap;

fn skin(wood: &Wood, state: &FractureState, options: &RodSkinOptions) -> RodSkin {
    rod_skin(wood, state, &MATERIALS, options).unwrap()
}

/// Breaks some rods and bonds, by the fibre model's own means; the frame then, unmoved.
fn broken(grown: &Grown, seed: u64, rods: f64, bonds: f64) -> Frame {
    let mut bundle = grown.placed.bundle.clone();
    let mut state = State::at_rest(&bundle);
    for round in 0..3 {
        let chosen = |what: u64, n: usize, part: f64| -> Vec<u32> {
            let chosen = |i: &u32| unit(seed ^ what, i64::from(*i), round, 0) < part / 3.0;
            (0..n as u32).filter(chosen).collect()
        };
        let bonds = chosen(0xb0, bundle.bonds.len(), bonds);
        let splits = chosen(0x0d, bundle.vertices(), rods);
        let mut loads = Loads::default();
        break_up(&mut bundle, &mut state, &mut loads, &bonds, &splits);
    }
    Frame::capture(&bundle, &state, &[])
}

/// The pieces that bonds leave, counted by flooding.
fn bonded_pieces(frame: &Frame) -> usize {
    let rods = frame.parent.len();
    let rod_of = |v: u32| (0..rods).find(|&r| v < frame.rod_offsets[r + 1]).unwrap();
    let mut beside = vec![Vec::new(); rods];
    for &[v, e] in &frame.bonds {
        let (a, b) = (rod_of(v), rod_of(e));
        beside[a].push(b);
        beside[b].push(a);
    }
    let mut seen = vec![false; rods];
    let mut count = 0;
    for start in 0..rods {
        count += usize::from(!seen[start]);
        let mut left = vec![start];
        while let Some(rod) = left.pop() {
            if !std::mem::replace(&mut seen[rod], true) {
                left.extend(&beside[rod]);
            }
        }
    }
    count
}

#[test]
fn rods_of_a_board_show_the_rings_of_its_log() {
    let grown = grown(primitive::board(0.3, 0.06, 0.04), 40);
    let wood = wood(&grown);
    let options = RodSkinOptions::default();
    let made = skin(&wood, &FractureState::unbroken(&wood), &options);
    let (mut least, mut most) = (1.0f64, 0.0f64);
    for piece in &made.pieces {
        let rings = piece.mesh.attributes.get("_RING").unwrap();
        for (v, &p) in piece.mesh.positions.iter().enumerate() {
            let across = grown.stem.grain.to_grain(p).truncate();
            let rho = f64::from(rings.at(v)[0]);
            let distance = across.distance(grown.stem.rings.pith());
            let wanted = distance / grown.stem.rings.outer_radius(0.0);
            assert!((rho - wanted).abs() < 1e-5, "{rho} for {wanted}");
            (least, most) = (least.min(rho), most.max(rho));
        }
    }
    // From the face towards the pith, 45 mm below the middle, to the far corners.
    assert!(
        (0.3..0.45).contains(&least) && most > 0.99,
        "{least} {most}"
    );
}

#[test]
fn whole_wood_has_one_skin_around_all_of_it() {
    for fibres in [1, 5] {
        let grown = grown(primitive::cylinder(0.02, 0.3, 64), 40);
        let wood = wood(&grown);
        let options = RodSkinOptions {
            fibres,
            ..RodSkinOptions::default()
        };
        let made = skin(&wood, &FractureState::unbroken(&wood), &options);
        assert_eq!(
            (made.pieces.len(), made.nonmanifold_splits),
            (1, NonmanifoldSplits::default())
        );
        let mesh = &made.pieces[0].mesh;
        let report = mesh.check();
        assert!(report.is_solid() && report.components == 1, "{report}");
        let outline = &grown.placed.outline;
        let sides = outline.iter().zip(outline.iter().cycle().skip(1));
        let area = 0.5 * sides.map(|(a, b)| a.perp_dot(*b)).sum::<f64>();
        let along = &grown.placed.along;
        let length = along.iter().copied().fold(0.0, f64::max)
            - along.iter().copied().fold(f64::INFINITY, f64::min);
        let volume = report.volume_m3.unwrap();
        // Corners that lie close to each other are one, which takes a little off the outline.
        let part = volume / (area * length);
        assert!((part - 1.0).abs() < 1e-3, "{part}");
        // The outside alone: two triangles for each side of a column that lies there and slab, and a fan at each end.
        let section = columns(
            wood.cells,
            wood.outline,
            &wood.bonded_rods(),
            fibres,
            wood.stem.rings.pith(),
            options.seed,
        );
        let sides = section.columns.iter().flat_map(|c| &c.beyond);
        let outside = sides.filter(|&&beyond| beyond == u32::MAX).count();
        let fans: usize = section.columns.iter().map(|c| 2 * c.corners.len()).sum();
        let walls = mesh.triangles.len() - fans;
        let slabs = walls / (2 * outside);
        assert_eq!(walls, 2 * outside * slabs, "{fibres}: {outside}");
        assert!(slabs > 30, "{slabs}");
    }
}

#[test]
fn whatever_breaks_pieces_are_solids_that_fill_the_wood() {
    let whole = grown(primitive::branch(&BranchOptions::default()), 30);
    let wood = wood(&whole);
    let all = skin(
        &wood,
        &FractureState::unbroken(&wood),
        &RodSkinOptions::default(),
    );
    let volume = all.pieces[0].mesh.volume();
    for seed in 0..12 {
        let (rods, bonds) = [(0.02, 0.2), (0.1, 0.6), (0.3, 0.95), (0.0, 0.9)][seed as usize % 4];
        let frame = broken(&whole, seed, rods, bonds);
        // Every other break was one in compression.
        let vertices = 0..wood.bundle.vertices() as u32;
        let causes: BTreeMap<u32, Cause> = vertices
            .step_by(2)
            .map(|v| (v, Cause::Compression))
            .collect();
        let state = FractureState::from_frame(&wood, &frame, &causes).unwrap();
        let options = RodSkinOptions {
            seed,
            fibres: 1 + seed as u32 % 5,
            ..RodSkinOptions::default()
        };
        let made = skin(&wood, &state, &options);
        let mut sum = 0.0;
        let (mut crossing, mut triangles) = (0, 0);
        for piece in &made.pieces {
            let report = piece.mesh.check();
            let case = format!("seed {seed}, {}: {report}", piece.name);
            assert!(report.closed && report.oriented, "{case}");
            let own = report.self_intersections.as_ref().map_or(0, |s| s.crossing);
            // A crack's sides lie a hair apart, and where many sheets meet in a vertex some still pass through each other; what
            // came off, down to slivers of a few hundred triangles, is sound.
            let is_largest = piece.name == made.pieces[0].name;
            assert!(is_largest || own == 0, "{case}");
            crossing += own;
            triangles += piece.mesh.triangles.len();
            sum += report.volume_m3.unwrap();
        }
        assert!(
            crossing * 30 < triangles,
            "seed {seed}: {crossing} pairs of {triangles} triangles cross"
        );
        // What is lost is the kerf of cracks.
        assert!(
            sum < volume && sum > 0.998 * volume,
            "seed {seed}: {sum} of {volume}"
        );
        assert_eq!(made.pieces.len(), bonded_pieces(&frame), "seed {seed}");
        assert_eq!(made, skin(&wood, &state, &options), "seed {seed}");
    }
}

#[test]
fn the_hull_is_convex_and_holds_all_rods() {
    let grown = grown(primitive::cylinder(0.02, 0.3, 64), 40);
    let wood = wood(&grown);
    let options = RodSkinOptions {
        outline: Outline::Hull,
        ..RodSkinOptions::default()
    };
    let made = skin(&wood, &FractureState::unbroken(&wood), &options);
    let report = made.pieces[0].mesh.check();
    assert!(report.is_solid(), "{report}");
    // Its volume is that of the hull of circles about the rods, found here by its width in all directions: the area of a
    // convex section is the half of ∫ (w² − w'²) for the support w.
    let spacing = (wood.cells.iter().map(|c| c.area).sum::<f64>() / 40.0).sqrt();
    let steps = 20_000;
    let support = |k: usize| {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / f64::from(steps)).sin_cos();
        let far = wood
            .cells
            .iter()
            .map(|c| c.centroid.x * cos + c.centroid.y * sin);
        far.fold(f64::NEG_INFINITY, f64::max) + 0.5 * spacing
    };
    let step = std::f64::consts::TAU / f64::from(steps);
    let area: f64 = (0..steps as usize)
        .map(|k| {
            let (here, next) = (support(k), support(k + 1));
            0.5 * (here * here - ((next - here) / step).powi(2)) * step
        })
        .sum();
    let along = &grown.placed.along;
    let length = along.iter().copied().fold(0.0, f64::max)
        - along.iter().copied().fold(f64::INFINITY, f64::min);
    let part = made.pieces[0].mesh.volume() / (area * length);
    // Circles of 16 corners take a little off.
    assert!((0.985..1.0).contains(&part), "{part}");
}

#[test]
fn rods_whose_faces_are_kept_are_closed_one_by_one() {
    let grown = grown(primitive::cylinder(0.02, 0.3, 64), 20);
    let wood = wood(&grown);
    let options = RodSkinOptions {
        fibres: 1,
        keep_inner: true,
        ..RodSkinOptions::default()
    };
    let made = skin(&wood, &FractureState::unbroken(&wood), &options);
    assert_eq!(made.pieces.len(), 1);
    let quick = CheckOptions {
        self_intersections: false,
    };
    let report = made.pieces[0].mesh.check_with(quick);
    assert!(report.closed && report.oriented, "{report}");
    assert_eq!(report.components, 20, "{report}");
    let options = RodSkinOptions {
        keep_inner: false,
        ..options
    };
    let whole = skin(&wood, &FractureState::unbroken(&wood), &options);
    let volumes = [&made, &whole].map(|s| s.pieces[0].mesh.volume());
    assert!((volumes[0] / volumes[1] - 1.0).abs() < 1e-3, "{volumes:?}");
}

/// The skin where the joints are in `frame`.
fn posed(made: &RodSkin, frame: &Frame) -> Vec<Vec<DVec3>> {
    let joint = |&rest| Joint {
        name: String::new(),
        rest,
    };
    let film = Film {
        joints: made.joints.rest.iter().map(joint).collect(),
        pieces: made.pieces.clone(),
        frames_per_second: 1.0,
        ..Film::default()
    };
    assert_eq!(film.fault(), None);
    let poses = frame_poses(&made.joints, frame);
    let piece = |piece| {
        let mut out = Vec::new();
        film.pose_piece(piece, &poses, &mut out);
        out
    };
    (0..film.pieces.len()).map(piece).collect()
}

#[test]
fn the_skin_goes_where_the_rods_go() {
    let grown = grown(primitive::branch(&BranchOptions::default()), 30);
    let wood = wood(&grown);
    let rest = broken(&grown, 5, 0.1, 0.6);
    let state = FractureState::from_frame(&wood, &rest, &BTreeMap::new()).unwrap();
    let made = skin(&wood, &state, &RodSkinOptions::default());
    // Where nothing has moved, the skin is at rest, to the frames' single precision.
    for (piece, places) in made.pieces.iter().zip(posed(&made, &rest)) {
        for (a, b) in piece.mesh.positions.iter().zip(places) {
            assert!(a.distance(b) < 2e-6, "{a} {b}");
        }
    }
    // A rigid movement of all rods is one of the skin.
    let turn = DQuat::from_rotation_x(0.7) * DQuat::from_rotation_z(-1.9);
    let map = DAffine3::from_rotation_translation(turn, DVec3::new(0.3, -0.2, 0.1));
    let mut moved = rest.clone();
    let single = |v: DVec3| v.as_vec3().to_array();
    let double = |v: &[f32; 3]| DVec3::from_array(v.map(f64::from));
    for p in &mut moved.position {
        *p = single(map.transform_point3(double(p)));
    }
    for d in &mut moved.director {
        *d = single(turn * double(d));
    }
    for (piece, places) in made.pieces.iter().zip(posed(&made, &moved)) {
        for (a, b) in piece.mesh.positions.iter().zip(places) {
            assert!(map.transform_point3(*a).distance(b) < 5e-6);
        }
    }
}

#[test]
fn a_bent_bundle_keeps_its_bonded_rods_together() {
    let grown = grown(primitive::cylinder(0.01, 0.3, 64), 40);
    let wood = wood(&grown);
    let made = skin(
        &wood,
        &FractureState::unbroken(&wood),
        &RodSkinOptions::default(),
    );
    // An arc in a plane of the stem's axis, every section square to it, in steps so that frames are carried along.
    let bundle = &grown.placed.bundle;
    let mut state = State::at_rest(bundle);
    let low = bundle.rest.iter().fold(DVec3::INFINITY, DVec3::min);
    let high = bundle.rest.iter().fold(DVec3::NEG_INFINITY, DVec3::max);
    let extent = (high - low).to_array();
    let axis = (0..3)
        .max_by(|&a, &b| extent[a].total_cmp(&extent[b]))
        .unwrap();
    let (across, beside) = ((axis + 1) % 3, (axis + 2) % 3);
    let (middle, radius) = (0.5 * (low + high), 0.4);
    for part in 1..=20 {
        let radius = radius * 20.0 / f64::from(part);
        for i in 0..bundle.vertices() {
            let mut p = bundle.rest.get(i) - middle;
            let (s, y) = (p[axis], p[across]);
            p[axis] = (radius - y) * (s / radius).sin();
            p[across] = radius - (radius - y) * (s / radius).cos();
            state.position.set(i, p + middle);
        }
        state.transport_frames(bundle);
    }
    let places = posed(&made, &Frame::capture(bundle, &state, &[]));
    let mesh = Mesh {
        positions: places[0].clone(),
        ..made.pieces[0].mesh.clone()
    };
    let report = mesh.check();
    assert!(report.is_solid(), "{report}");
    // Pappus: the volume of a bent bar is its section times the length of its middle.
    let volume = mesh.volume() / made.pieces[0].mesh.volume();
    assert!((volume - 1.0).abs() < 2e-3, "{volume}");
    // All of it lies in the bent cylinder, but for the chords of edges of 12 mm and the joints at the ends, which have one
    // edge to be square to: half an edge's turn off.
    let off = 0.012 * 0.012 / (8.0 * radius) + 0.01 * 0.006 / radius;
    let far = |p: &DVec3| {
        let p = *p - middle;
        (radius - p[axis].hypot(p[across] - radius)).hypot(p[beside])
    };
    let most = places[0].iter().map(far).fold(0.0, f64::max);
    assert!((0.0099..0.01 + off).contains(&most), "{most}");
}

#[test]
fn frames_of_other_wood_are_refused() {
    let grown = grown(primitive::cylinder(0.02, 0.3, 64), 10);
    let wood = wood(&grown);
    let whole = broken(&grown, 1, 0.1, 0.3);
    type Change = (&'static str, fn(&mut Frame));
    let changes: [Change; 6] = [
        ("a rod", |f| f.parent[1] = 77),
        ("list of rods", |f| f.rod_offsets[1] = 1),
        ("list of rods", |f| f.rod_offsets[1] = u32::MAX - 1),
        ("number of vertices", |f| {
            let last = f.rod_offsets.len() - 2;
            f.parent.truncate(last);
            f.rod_offsets.truncate(last + 1);
            f.origin.truncate(f.rod_offsets[last] as usize);
        }),
        ("a bond", |f| f.bonds[0] = [u32::MAX; 2]),
        ("a position", |f| f.position[3][1] = f32::NAN),
    ];
    for (says, change) in changes {
        let mut frame = whole.clone();
        change(&mut frame);
        let refused = FractureState::from_frame(&wood, &frame, &BTreeMap::new());
        let Err(error @ RodSkinError::OtherBundle { .. }) = refused else {
            panic!("{says}: {refused:?}");
        };
        assert!(error.to_string().contains(says), "{says}: {error}");
    }
    let options = RodSkinOptions {
        slabs: f64::NAN,
        ..RodSkinOptions::default()
    };
    let refused = rod_skin(&wood, &FractureState::unbroken(&wood), &MATERIALS, &options);
    assert!(matches!(refused, Err(RodSkinError::Option(_))));
}
