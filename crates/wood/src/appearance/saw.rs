//! Marks of the saw on the ends of a stem: arcs that its teeth left, uneven in distance and depth, and scratches between them.

use super::mix::visible_detail;
use crate::noise::{gradient_3d, unit, value_1d};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Distance between arcs, m: a bow or chain saw advances by about that much with a stroke or a tooth.
const ARC_DISTANCE: f64 = 1.4e-3;
/// How much that distance wavers, in arcs, and over how many m.
const WAVER: f64 = 0.9;
const WAVER_LENGTH: f64 = 6e-3;
/// Radius of the arcs, m.
const ARC_RADIUS: f64 = 0.19;
/// Height of arcs and of scratches from the mean, m.
const ARC_RELIEF: f64 = 55e-6;
const SCRATCH_RELIEF: f64 = 18e-6;
/// Distance between scratches and their length, m.
const SCRATCH_SIZE: (f64, f64) = (0.3e-3, 11e-3);
/// Step over which the slope of the relief is measured, m.
const STEP: f64 = 8e-6;
/// How much paler the ridges are, where torn fibres stand: change of brightness for the relief of an arc.
const RIDGE_BRIGHTNESS: f64 = 0.07;

// Purpose in the hash.
const SAW: u64 = 0x5a;

/// The relief that the saw left at a point.
pub(super) struct SawMark {
    /// Factor on the brightness.
    pub brightness: f64,
    /// Relief, m.
    pub height: f64,
    /// Its slope in the section.
    pub slope: DVec2,
}

/// Returns the marks at a point of an end, `across` in m in the section.
pub(super) fn saw_mark(seed: u64, across: DVec2, footprint: f64) -> SawMark {
    let seed = seed ^ SAW;
    let turn = DVec2::from_angle(TAU * unit(seed, 0, 0, 0));
    let arcs = visible_detail(ARC_DISTANCE, footprint);
    let scratches = visible_detail(SCRATCH_SIZE.0, footprint);
    let relief = |p: DVec2| {
        let from = p - turn * ARC_RADIUS;
        let (out, around) = (from.length() - ARC_RADIUS, turn.perp_dot(from));
        let waver = WAVER * value_1d(seed ^ 1, out / WAVER_LENGTH);
        let strength = 0.55 + 0.45 * value_1d(seed ^ 2, out / (2.3 * ARC_DISTANCE));
        let arc = libm::sin(TAU * (out / ARC_DISTANCE + waver)) * strength;
        let place = DVec3::new(out / SCRATCH_SIZE.0, around / SCRATCH_SIZE.1, 0.5);
        let scratch = match scratches > 0.0 {
            true => gradient_3d(seed ^ 3, place, 0).0,
            false => 0.0,
        };
        (
            arc,
            ARC_RELIEF * arcs * arc + SCRATCH_RELIEF * scratches * scratch,
        )
    };
    let (arc, height) = relief(across);
    let slope = [DVec2::X, DVec2::Y].map(|d| (relief(across + d * STEP).1 - height) / STEP);
    SawMark {
        brightness: 1.0 + RIDGE_BRIGHTNESS * arcs * arc,
        height,
        slope: DVec2::from_array(slope),
    }
}
