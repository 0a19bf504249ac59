//! The section's outline as Sutherland's thesis has it (2012 §5.1.1): the convex hull of the rods, some way outside.

use super::Wood;
use glam::DVec2;
use greenstick_fibre::placement::{VoronoiCell, voronoi_cells};

/// Corners of the circle about each rod that the hull goes around.
const ROUND: usize = 16;

/// The hull about the rods of `wood`, counter-clockwise, and their cells in it.
pub(super) fn hull(wood: &Wood) -> (Vec<DVec2>, Vec<VoronoiCell>) {
    let rods: Vec<DVec2> = wood.cells.iter().map(|c| c.centroid).collect();
    let area: f64 = wood.cells.iter().map(|c| c.area).sum();
    let margin = 0.5 * (area / rods.len().max(1) as f64).sqrt();
    let circle = |&p: &DVec2| {
        (0..ROUND).map(move |k| {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * k as f64 / ROUND as f64);
            p + margin * DVec2::new(cos, sin)
        })
    };
    let outline = convex(rods.iter().flat_map(circle).collect());
    let found = voronoi_cells(&outline, &rods);
    (outline, found)
}

/// The convex hull of places, counter-clockwise (Andrew's chains).
fn convex(mut places: Vec<DVec2>) -> Vec<DVec2> {
    places.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    places.dedup();
    let mut hull: Vec<DVec2> = Vec::new();
    for back in [false, true] {
        let start = hull.len() + 1;
        let mut add = |p: DVec2| {
            while hull.len() > start {
                let [.., a, b] = hull[..] else { break };
                if (b - a).perp_dot(p - a) > 0.0 {
                    break;
                }
                hull.pop();
            }
            hull.push(p);
        };
        if back {
            places.iter().rev().for_each(|&p| add(p));
        } else {
            places.iter().for_each(|&p| add(p));
        }
        hull.pop();
    }
    hull
}
