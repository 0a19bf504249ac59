//! Loads and supports of a specimen, as grips whose time is the opening or deflection, m.
//!
//! They act on the mean displacement of the cross-section of an arm or of the whole, as in beam theory. In end-notched flexure a
//! support of its own holds each arm, so that they pass each other without friction. The arms of a single-edge notched beam are
//! glued to the outer faces of its upright block and stiff against it: each support acts on its face by its force, evenly
//! distributed, and by the moment of that, as stress that is linear over the height.

use super::bundle::{ALONG, Division, UP};
use super::section::TestSection;
use super::specimen::{FractureTest, FractureTestKind};
use crate::solvers::Grip;
use glam::DVec3;

/// Half of the width over which a notched beam is loaded, over its height.
const PAD_RATIO: f64 = 0.125;

/// Returns the grips of a test, whose springs have this stiffness (N/m).
pub(super) fn grips(
    test: &FractureTest,
    section: &TestSection,
    division: &Division,
    stiffness: f64,
) -> Vec<Grip> {
    let on = |rods: &[usize], at: usize, direction: DVec3| {
        let areas: Vec<f64> = rods.iter().map(|&r| section.rods[r].area).collect();
        Grip::on_mean(division.vertices(rods, at), &areas, direction)
    };
    let (above, below) = (section.arm(true), section.arm(false));
    let all: Vec<usize> = (0..section.rods.len()).collect();
    let (up, along) = (DVec3::AXES[UP], DVec3::AXES[ALONG]);
    let end = division.edges;
    let held = |grip: Grip| grip.with_spring(stiffness, 0.0);
    match test.kind {
        FractureTestKind::DoubleCantileverBeam => vec![
            on(&above, 0, up).with_spring(stiffness, 0.5),
            on(&below, 0, -up).with_spring(stiffness, 0.5),
            held(on(&all, end, up)),
            held(on(&all, end, along)),
        ],
        FractureTestKind::EndNotchedFlexure => vec![
            on(&all, end / 2, -up).with_spring(stiffness, 1.0),
            held(on(&above, 0, -up)),
            held(on(&below, 0, -up)),
            held(on(&all, end, -up)),
            held(on(&all, end, along)),
        ],
        FractureTestKind::SingleEdgeNotchedBeam => {
            let pad = PAD_RATIO * test.height;
            let loaded = rods_at(section, |y| y.abs() <= pad.max(0.75 * test.spacing));
            vec![
                on(&loaded, end, -along).with_spring(stiffness, 1.0),
                held(arm(test, section, division, -1.0)),
                held(arm(test, section, division, 1.0)),
                // Nothing pulls it to a side, as both halves are alike.
                held(on(&loaded, end, up)),
            ]
        }
    }
}

/// Returns the rods at some distances from the crack's plane.
fn rods_at(section: &TestSection, chosen: impl Fn(f64) -> bool) -> Vec<usize> {
    let rods = 0..section.rods.len();
    rods.filter(|&r| chosen(section.rods[r].position.y))
        .collect()
}

/// Returns the grip of a support at the end of a stiff arm, which acts on the outer face of the block on one side.
fn arm(test: &FractureTest, section: &TestSection, division: &Division, side: f64) -> Grip {
    let face = rods_at(section, |y| side * y > test.arm() - test.spacing);
    // Length of the face that each vertex stands for, and its place along it.
    let length = |k: usize| {
        let at_end = k == 0 || k == division.edges;
        division.edge * if at_end { 0.5 } else { 1.0 }
    };
    let (mut vertices, mut areas, mut places) = (Vec::new(), Vec::new(), Vec::new());
    for &rod in &face {
        for k in 0..=division.edges {
            vertices.extend(division.vertices(&[rod], k));
            areas.push(section.rods[rod].area * length(k));
            places.push((section.rods[rod].position.y, k as f64 * division.edge));
        }
    }
    let total: f64 = areas.iter().sum();
    let mean = |value: &dyn Fn(usize) -> f64| {
        let sum: f64 = areas.iter().enumerate().map(|(i, a)| a * value(i)).sum();
        sum / total
    };
    let centre = (mean(&|i| places[i].0), mean(&|i| places[i].1));
    let inertia = mean(&|i| (places[i].1 - centre.1).powi(2));
    let lever = side * 0.5 * test.length - centre.0;
    // The support's way down, with the face turned as a whole.
    let weight = |i: usize| {
        let turn = lever * (places[i].1 - centre.1) / inertia;
        (DVec3::AXES[UP] * turn - DVec3::AXES[ALONG]) * (areas[i] / total)
    };
    Grip {
        weights: (0..vertices.len()).map(weight).collect(),
        vertices,
        stiffness: 0.0,
        speed: 0.0,
    }
}
