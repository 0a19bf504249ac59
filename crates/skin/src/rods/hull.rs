//! The outline of a section as in Sutherland's thesis (2012 §5.1.1): the convex hull of the rods with a margin.

use super::wood::Wood;
use glam::DVec2;
use greenstick_fibre::placement::{VoronoiCell, voronoi_cells};

/// Corners of the circle about each rod that the hull encloses.
const CIRCLE_CORNERS: usize = 16;

/// Returns the hull about the rods of `wood`, counter-clockwise, and their cells in it.
pub(super) fn hull(wood: &Wood) -> (Vec<DVec2>, Vec<VoronoiCell>) {
    let rods: Vec<DVec2> = wood.cells.iter().map(|c| c.centroid).collect();
    let area: f64 = wood.cells.iter().map(|c| c.area).sum();
    let margin = 0.5 * (area / rods.len().max(1) as f64).sqrt();
    let circle = |&centre: &DVec2| {
        (0..CIRCLE_CORNERS).map(move |k| {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * k as f64 / CIRCLE_CORNERS as f64);
            centre + margin * DVec2::new(cos, sin)
        })
    };
    let outline = convex_hull(rods.iter().flat_map(circle).collect());
    let rod_cells = voronoi_cells(&outline, &rods);
    (outline, rod_cells)
}

/// Returns the convex hull of points, counter-clockwise (Andrew's monotone chain).
fn convex_hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let mut hull: Vec<DVec2> = Vec::new();
    for backwards in [false, true] {
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
        if backwards {
            points.iter().rev().for_each(|&p| add(p));
        } else {
            points.iter().for_each(|&p| add(p));
        }
        hull.pop();
    }
    hull
}
