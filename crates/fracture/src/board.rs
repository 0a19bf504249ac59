//! The section of a board, whose pith lies outside of it.

use crate::layout::FibreBundles;
use crate::surface::NONE;
use glam::DVec2;

/// The section of a board: about a rectangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoardSection {
    /// Its middle, m.
    middle: DVec2,
    /// Unit direction through its thickness.
    thin: DVec2,
    /// Half its width and half its thickness, m.
    half_width: f64,
    half_thickness: f64,
}

impl BoardSection {
    /// The section that bundles fill.
    pub fn new(bundles: &FibreBundles) -> Self {
        let known = bundles.tips.iter().filter(|&&t| t != NONE);
        let tips: Vec<DVec2> = known.map(|&t| bundles.layout.nodes[t as usize]).collect();
        BoardSection::about(&tips)
    }

    /// The section about points that fill it.
    fn about(points: &[DVec2]) -> Self {
        let none = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let (low, high) = (points.iter()).fold(none, |(l, h), &p| (l.min(p), h.max(p)));
        let mean = points.iter().sum::<DVec2>() / points.len().max(1) as f64;
        // Its width is the principal axis of the points.
        let (mut even, mut mixed) = (0.0, 0.0);
        for off in points.iter().map(|&p| p - mean) {
            even += off.x * off.x - off.y * off.y;
            mixed += 2.0 * off.x * off.y;
        }
        let (sin, cos) = libm::sincos(0.5 * libm::atan2(mixed, even));
        let thin = DVec2::new(-sin, cos);
        let (from, to) = (points.iter().map(|p| p.dot(thin)))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), d| {
                (l.min(d), h.max(d))
            });
        let middle = (low + high) / 2.0;
        BoardSection {
            middle: middle + thin * (0.5 * (from + to) - middle.dot(thin)),
            thin,
            half_width: ((high - low).max_element() / 2.0).max(1e-9),
            half_thickness: (0.5 * (to - from)).max(1e-9),
        }
    }

    /// Returns a point (m) from the middle, in halves of the width.
    pub fn across_width(&self, at: DVec2) -> DVec2 {
        (at - self.middle) / self.half_width
    }

    /// Returns how far a point (m) lies through the thickness: −1 on one face, 1 on the one that `tension` points to.
    pub fn through(&self, at: DVec2, tension: DVec2) -> f64 {
        let through = (at - self.middle).dot(self.thin) / self.half_thickness;
        if self.thin.dot(tension) < 0.0 {
            -through
        } else {
            through
        }
    }
}

/// Returns how many radii are in a unit of the ring coordinate of a board, whose rings are arcs about `pith` (m).
pub(crate) fn ring_unit(bundles: &FibreBundles, (radius, pith): (f64, DVec2)) -> f64 {
    let nodes = bundles.layout.nodes.iter().zip(&bundles.addresses);
    // Those beyond the skin lie farther out than their coordinates say.
    let near = nodes.min_by(|a, b| a.1.0.total_cmp(&b.1.0));
    near.map_or(1.0, |(node, address)| {
        node.distance(pith) / (radius * address.0.max(1e-9))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_board_is_bent_through_its_thickness() {
        let turn = DVec2::from_angle(0.4);
        let place = DVec2::new(0.2, -0.1);
        let at = |x: f64, y: f64| place + turn.rotate(DVec2::new(0.15 * x, 0.01 * y));
        let grid = (-20..=20).flat_map(|i| (-3..=3).map(move |j| (i, j)));
        let points: Vec<DVec2> = grid
            .map(|(i, j)| at(f64::from(i) / 20.0, f64::from(j) / 3.0))
            .collect();
        let board = BoardSection::about(&points);
        let up = turn.rotate(DVec2::Y);
        for (tension, sign) in [(up, 1.0), (-up, -1.0)] {
            for (x, y) in [(0.9, 1.0), (-0.9, 1.0), (0.1, 0.0), (0.5, -1.0)] {
                let through = board.through(at(x, y), tension);
                assert!((through - sign * y).abs() < 1e-9, "{x} {y}: {through}");
            }
        }
    }
}
