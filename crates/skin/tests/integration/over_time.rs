//! A film of the skin: cracks are closed until they open.

use crate::common::{Grown, MATERIALS, grown, wood};
use glam::{DAffine3, DVec3};
use greenstick_fibre::Loads;
use greenstick_fibre::RodBundle;
use greenstick_fibre::State;
use greenstick_fibre::store::Frame;
use greenstick_fibre::topology::break_up;
use greenstick_geometry::{Film, Joint};
use greenstick_skin::rods::{
    BreakHistory, CrackOpening, FractureState, RodSkin, RodSkinOptions, frame_poses, rod_skin,
    rod_skin_over_time,
};
use greenstick_wood::noise::unit;
use greenstick_wood::primitive;
use std::collections::BTreeMap;

/// An arc in a plane of the stem's axis that grows with `part`, with some wriggling of each rod by itself where it is
/// broken off.
fn bent(bundle: &RodBundle, state: &mut State, part: f64) {
    let low = bundle.rest.iter().fold(DVec3::INFINITY, DVec3::min);
    let high = bundle.rest.iter().fold(DVec3::NEG_INFINITY, DVec3::max);
    let extent = (high - low).to_array();
    let axis = (0..3)
        .max_by(|&a, &b| extent[a].total_cmp(&extent[b]))
        .unwrap();
    let across = (axis + 1) % 3;
    let (middle, radius) = (0.5 * (low + high), 0.3 / part);
    for rod in 0..bundle.rods() {
        let turn = 0.002 * part * unit(7, rod as i64, 0, 0);
        for i in bundle.rod(rod) {
            let mut p = bundle.rest.get(i) - middle;
            let (s, y) = (p[axis], p[across]);
            p[axis] = (radius - y) * (s / radius).sin();
            p[across] = radius - (radius - y) * (s / radius).cos() + turn;
            state.position.set(i, p + middle);
        }
    }
    state.transport_frames(bundle);
}

/// Frames of a bundle that bends and breaks: at first whole, then some rods and bonds, then bonds only.
fn frames(grown: &Grown) -> Vec<Frame> {
    let mut bundle = grown.placed.bundle.clone();
    let mut state = State::at_rest(&bundle);
    let mut frames = Vec::new();
    for round in 0..5i64 {
        let chosen = |what: u64, n: usize, part: f64| -> Vec<u32> {
            let chosen = |i: &u32| unit(what, i64::from(*i), round, 0) < part;
            (0..n as u32).filter(chosen).collect()
        };
        if round > 0 {
            let bonds = chosen(0xb0, bundle.bonds.len(), 0.2);
            let splits = chosen(0x0d, bundle.vertices(), if round == 1 { 0.03 } else { 0.0 });
            let mut loads = Loads::default();
            break_up(&mut bundle, &mut state, &mut loads, &bonds, &splits);
        }
        bent(&bundle, &mut state, 0.2 * (round + 1) as f64);
        let mut frame = Frame::capture(&bundle, &state, &[]);
        frame.time = round as f64;
        frames.push(frame);
    }
    frames
}

fn over_time(grown: &Grown, frames: &[Frame], options: &RodSkinOptions) -> RodSkin {
    let wood = wood(grown);
    let mut history = BreakHistory::new(&wood);
    for frame in frames {
        history.push_frame(&wood, frame, &BTreeMap::new()).unwrap();
    }
    rod_skin_over_time(&wood, &history, &MATERIALS, options).unwrap()
}

/// Where each vertex rests in a frame, and where it is.
fn placed(skin: &RodSkin, number: usize, frame: &Frame) -> Vec<(DVec3, DVec3)> {
    let joint = |&rest| Joint {
        name: String::new(),
        rest,
    };
    let film = Film {
        joints: skin.joints.rest.iter().map(joint).collect(),
        pieces: skin.pieces.clone(),
        frames_per_second: 1.0,
        ..Film::default()
    };
    assert_eq!(film.fault(), None);
    let mut maps: Vec<DAffine3> = Vec::new();
    film.joint_maps(&frame_poses(&skin.joints, frame), &mut maps);
    let (mut all, mut out) = (Vec::new(), Vec::new());
    for (k, piece) in film.pieces.iter().enumerate() {
        film.deform_positions_at(number, k, &maps, &mut out);
        let mut rest = piece.mesh.positions.clone();
        for (change, v) in piece.earlier.active_at(number) {
            rest[v] = piece.earlier.rest[change];
        }
        all.extend(rest.into_iter().zip(out.iter().copied()));
    }
    all
}

/// How many vertices of `of` rest where none of `film` does, and the largest distance of the others from one that rests
/// there.
fn apart(of: &[(DVec3, DVec3)], film: &[(DVec3, DVec3)], near: f64) -> (usize, f64) {
    let (mut alone, mut most) = (0, 0.0f64);
    for (rest, place) in of {
        let there = film.iter().filter(|f| f.0.distance(*rest) <= near);
        let distance = (there.map(|f| f.1.distance(*place))).fold(f64::INFINITY, f64::min);
        if distance.is_finite() {
            most = most.max(distance);
        } else {
            alone += 1;
        }
    }
    (alone, most)
}

#[test]
fn cracks_are_closed_until_they_open() {
    for fibres in [1, 3] {
        let grown = grown(primitive::cylinder(0.01, 0.12, 32), 12);
        let wood = wood(&grown);
        let options = RodSkinOptions {
            fibres,
            ..RodSkinOptions::default()
        };
        let frames = frames(&grown);
        let film = over_time(&grown, &frames, &options);
        // Before the first event the outside is that of the uncut skin, and whatever rests at one place is at one place.
        let first = placed(&film, 0, &frames[0]);
        let uncut = rod_skin(&wood, &FractureState::unbroken(&wood), &MATERIALS, &options).unwrap();
        let (alone, off) = apart(&placed(&uncut, 0, &frames[0]), &first, 1e-12);
        assert!(alone == 0 && off < 1e-12, "{fibres}: {alone} {off}");
        let mut known: BTreeMap<[u64; 3], DVec3> = BTreeMap::new();
        let mut together = 0;
        for (rest, place) in &first {
            let bits = rest.to_array().map(f64::to_bits);
            let other = *known.entry(bits).or_insert(*place);
            together += usize::from(other != *place);
            assert!(other.distance(*place) < 1e-12, "{fibres}: {rest}");
        }
        assert!(
            known.len() * 3 < first.len() * 2,
            "{} {together}",
            known.len()
        );
        // After the last event it is the still.
        let last = frames.last().unwrap();
        let state = FractureState::from_frame(&wood, last, &BTreeMap::new()).unwrap();
        let still = rod_skin(&wood, &state, &MATERIALS, &options).unwrap();
        let end = frames.len() - 1;
        assert_eq!(placed(&still, end, last), placed(&film, end, last));
        // In between it is the still of the frame, as far as cracks are open then: their kerf is 2e-4 of a bundle's width.
        let kerf = 4e-4 * 0.01 * (std::f64::consts::PI / 12.0).sqrt();
        for (number, frame) in frames.iter().enumerate().take(end).skip(1) {
            let state = FractureState::from_frame(&wood, frame, &BTreeMap::new()).unwrap();
            let still = rod_skin(&wood, &state, &MATERIALS, &options).unwrap();
            let still = placed(&still, number, frame);
            let (alone, off) = apart(&still, &placed(&film, number, frame), kerf);
            println!("{fibres}, {number}: {alone} of {}, {off}", still.len());
            // Edges in which several sheets meet are others then, and so are the vertices in their middle.
            assert!(alone * 50 < still.len(), "{fibres}, {number}: {alone}");
            assert!(off < kerf, "{fibres}, {number}: {off}");
        }
        // Fixed weights gape.
        let mut most = vec![CrackOpening::default(); film.pieces.len()];
        for (number, frame) in frames.iter().enumerate() {
            film.closed_cracks
                .measure(&film.joints, number as u32, frame, &mut most);
        }
        let most = most.iter().map(|g| g.distance).fold(0.0, f64::max);
        println!(
            "{fibres}: gape {most} of {} pairs",
            film.closed_cracks.count()
        );
        assert!(most > 10.0 * kerf && most < 0.01, "{most}");
    }
}
