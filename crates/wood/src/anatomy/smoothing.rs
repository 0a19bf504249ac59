//! Smoothing of outlines. A sparse scan's bark has few cells around, and a section of it is a polygon whose corners are
//! the cells' and not the tree's.
//!
//! The outline is sampled at equal distances along it and its waves are damped, wave k by exp(−(k/c)²): that is a Gaussian mean along
//! the outline. The cut-off c is the lowest that leaves the outline within a distance of its own; the area stays.

use crate::polygon;
use glam::DVec2;
use std::f64::consts::TAU;

/// Points of a smoothed outline.
const POINTS: usize = 256;
/// Cut-offs that are tried, from an oval on. The last leaves all waves that so many points can have.
const CUT_OFFS: [f64; 9] = [3.0, 4.5, 6.5, 9.0, 13.0, 18.0, 26.0, 40.0, 64.0];

/// A smoothed outline.
pub(super) struct SmoothedOutline {
    /// Its points.
    pub points: Vec<DVec2>,
    /// Root mean square distance of the outline's points from where they were, m.
    pub residual: f64,
}

/// Smooths a closed outline (m), so that the root mean square distance from it is `tolerance` m at most. `None` where that is
/// not possible with any cut-off, or the outline has no area.
pub(super) fn smooth(outline: &[DVec2], tolerance: f64) -> Option<SmoothedOutline> {
    let points = resample(outline)?;
    let waves = Waves::of(&points);
    let (area, centroid) = polygon::area_and_centroid(outline);
    CUT_OFFS.iter().find_map(|&cut_off| {
        let mut smooth = waves.damped(cut_off);
        let (own_area, own_centroid) = polygon::area_and_centroid(&smooth);
        // Damping shrinks.
        let scale = (area / own_area).sqrt();
        if !scale.is_finite() {
            return None;
        }
        for p in &mut smooth {
            *p = centroid + (*p - own_centroid) * scale;
        }
        let squares: f64 = (smooth.iter().zip(&points))
            .map(|(a, b)| a.distance_squared(*b))
            .sum();
        let residual = (squares / POINTS as f64).sqrt();
        (residual <= tolerance).then_some(SmoothedOutline {
            points: smooth,
            residual,
        })
    })
}

/// Points at equal distances along a closed outline.
fn resample(outline: &[DVec2]) -> Option<Vec<DVec2>> {
    let girth = polygon::perimeter(outline);
    if outline.len() < 3 || !(girth > 0.0 && girth.is_finite()) {
        return None;
    }
    let step = girth / POINTS as f64;
    let mut points = Vec::with_capacity(POINTS);
    let mut behind = 0.0;
    for (i, &a) in outline.iter().enumerate() {
        let b = outline[(i + 1) % outline.len()];
        let length = a.distance(b);
        while points.len() < POINTS && points.len() as f64 * step < behind + length {
            let t = (points.len() as f64 * step - behind) / length;
            points.push(a.lerp(b, t));
        }
        behind += length;
    }
    // Rounding may leave out the last.
    points.resize(POINTS, outline[0]);
    Some(points)
}

/// The waves of a closed outline as a complex signal: wave k, from −N/2 on, at index k modulo N.
struct Waves {
    parts: Vec<DVec2>,
    circle: Vec<DVec2>,
}

impl Waves {
    fn of(points: &[DVec2]) -> Self {
        let circle: Vec<DVec2> = (0..POINTS)
            .map(|j| {
                let (sin, cos) = libm::sincos(TAU * j as f64 / POINTS as f64);
                DVec2::new(cos, sin)
            })
            .collect();
        let part = |k: usize| {
            let sum: DVec2 = (points.iter().enumerate())
                .map(|(j, p)| {
                    let turn = circle[j * k % POINTS];
                    DVec2::new(turn.x, -turn.y).rotate(*p)
                })
                .sum();
            sum / POINTS as f64
        };
        Waves {
            parts: (0..POINTS).map(part).collect(),
            circle,
        }
    }

    /// The outline with its waves damped.
    fn damped(&self, cut_off: f64) -> Vec<DVec2> {
        let weight = |k: usize| {
            let wave = k.min(POINTS - k) as f64 / cut_off;
            libm::exp(-wave * wave)
        };
        // Waves ±1 are the circle itself, which is not damped.
        let damping = weight(1);
        let kept: Vec<(usize, DVec2)> = (0..POINTS)
            .map(|k| (k, self.parts[k] * (weight(k) / damping).min(1.0)))
            .filter(|(k, part)| part.length() * weight(*k) > 0.0 && weight(*k) > 1e-9)
            .collect();
        (0..POINTS)
            .map(|j| {
                kept.iter()
                    .map(|(k, part)| self.circle[j * k % POINTS].rotate(*part))
                    .sum()
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An oval with three lobes, as a tree has it, 10 cm in radius.
    fn tree(angle: f64) -> DVec2 {
        let radius = 0.1 * (1.0 + 0.05 * (2.0 * angle).cos() + 0.03 * (3.0 * angle + 1.0).sin());
        DVec2::from_angle(angle) * radius
    }

    #[test]
    fn a_polygon_of_sixteen_sides_comes_nearer_to_the_section_it_was_measured_on() {
        let polygon: Vec<DVec2> = (0..16).map(|k| tree(TAU * f64::from(k) / 16.0)).collect();
        let smoothed = smooth(&polygon, 1.5e-3).unwrap();
        assert!(smoothed.residual <= 1.5e-3 && smoothed.residual > 1e-4);
        let area = |o: &[DVec2]| polygon::area_and_centroid(o).0;
        assert!((area(&smoothed.points) / area(&polygon) - 1.0).abs() < 1e-12);
        // The greatest turn between sides, relative to that of as many sides of a circle.
        let sharpest = |o: &[DVec2]| {
            let n = o.len();
            let side = |i: usize| o[(i + 1) % n] - o[i % n];
            let turn = (0..n)
                .map(|i| side(i).angle_to(side(i + 1)).abs())
                .fold(0.0, f64::max);
            turn * n as f64 / TAU
        };
        let own = sharpest(&smoothed.points);
        // 1.6 is that of the section itself.
        let truth: Vec<DVec2> = (0..POINTS)
            .map(|k| tree(TAU * k as f64 / POINTS as f64))
            .collect();
        assert!(own < 1.5 * sharpest(&truth), "{own} {}", sharpest(&truth));
        // Of a polygon that is sampled as finely, the corners of 16 sides turn by 16 times as much.
        let fine = resample(&polygon).unwrap();
        assert!(sharpest(&fine) > 10.0, "{}", sharpest(&fine));
    }

    #[test]
    fn a_square_stays_within_the_tolerance_or_as_it_is() {
        let square = [(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)].map(DVec2::from);
        for tolerance in [1e-2, 3e-3, 1e-3] {
            let smoothed = smooth(&square, tolerance).unwrap();
            assert!(smoothed.residual <= tolerance, "{}", smoothed.residual);
        }
        assert!(smooth(&square, 1e-7).is_none());
        assert!(smooth(&[DVec2::ZERO; 4], 1.0).is_none());
    }
}
