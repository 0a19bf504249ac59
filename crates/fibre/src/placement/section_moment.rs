//! The bending moment that a section of rods bears: section analysis of rods that are linear in tension and yield in
//! compression, while plane sections stay plane.

use glam::DVec2;
use std::f64::consts::{PI, TAU};

/// A rod in a section that is bent.
#[derive(Debug, Clone, Copy)]
pub(super) struct Element {
    /// Where it is, m.
    pub position: DVec2,
    /// Area, m².
    pub area: f64,
    /// Modulus along the grain, Pa.
    pub modulus: f64,
    /// Tensile strength, Pa.
    pub tension: f64,
    /// Crushing strength, Pa.
    pub compression: f64,
}

/// Directions of bending whose mean counts.
const DIRECTIONS: usize = 8;
/// Bisections of the curvature and of the neutral axis.
const BISECTIONS: usize = 50;

/// Returns the moment (N m) at which the first rod breaks in tension on its surface, the mean over all directions.
pub(super) fn moment_capacity(elements: &[Element]) -> f64 {
    let directions = (0..DIRECTIONS).map(|k| TAU * k as f64 / DIRECTIONS as f64);
    let sum: f64 = directions
        .map(|angle| Bent::new(elements, DVec2::from_angle(angle)).capacity())
        .sum();
    sum / DIRECTIONS as f64
}

/// A section bent about one axis: per rod its height towards the side in tension.
struct Bent<'a> {
    elements: &'a [Element],
    heights: Vec<f64>,
    low: f64,
    high: f64,
}

impl<'a> Bent<'a> {
    fn new(elements: &'a [Element], direction: DVec2) -> Self {
        let heights: Vec<f64> = elements.iter().map(|e| e.position.dot(direction)).collect();
        let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Bent {
            elements,
            heights,
            low,
            high,
        }
    }

    /// Returns the stress (Pa) of a rod under a strain.
    fn stress(element: &Element, strain: f64) -> f64 {
        (element.modulus * strain).max(-element.compression)
    }

    /// Returns the height of the neutral axis at a curvature (1/m), m.
    fn neutral_axis(&self, curvature: f64) -> f64 {
        // Beyond the section on the side in tension, where a section that has yielded throughout would have it.
        let (mut low, mut high) = (self.low, 2.0 * self.high - self.low);
        for _ in 0..BISECTIONS {
            let axis = 0.5 * (low + high);
            let pairs = self.elements.iter().zip(&self.heights);
            let force: f64 = pairs
                .map(|(e, y)| e.area * Self::stress(e, curvature * (y - axis)))
                .sum();
            if force > 0.0 {
                low = axis;
            } else {
                high = axis;
            }
        }
        0.5 * (low + high)
    }

    /// Returns the largest demand: strain on a rod's surface over that at which it breaks.
    fn demand(&self, curvature: f64, axis: f64) -> f64 {
        let pairs = self.elements.iter().zip(&self.heights);
        pairs.fold(0.0, |most, (e, y)| {
            let radius = (e.area / PI).sqrt();
            let strain = curvature * (y - axis + radius);
            most.max(strain * e.modulus / e.tension)
        })
    }

    /// Returns the moment at the first break, N m.
    fn capacity(&self) -> f64 {
        let depth = (self.high - self.low).max(f64::MIN_POSITIVE);
        let strongest = self
            .elements
            .iter()
            .fold(0.0, |m: f64, e| m.max(e.tension / e.modulus));
        let (mut low, mut high) = (0.0, 64.0 * strongest / depth);
        for _ in 0..BISECTIONS {
            let curvature = 0.5 * (low + high);
            if self.demand(curvature, self.neutral_axis(curvature)) < 1.0 {
                low = curvature;
            } else {
                high = curvature;
            }
        }
        let axis = self.neutral_axis(low);
        let pairs = self.elements.iter().zip(&self.heights);
        pairs
            .map(|(e, y)| {
                let own = e.area * e.area / (4.0 * PI);
                let stress = Self::stress(e, low * (y - axis));
                e.area * stress * (y - axis) + e.modulus * own * low
            })
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick_wood::species::nominal_bending_strength;

    #[test]
    fn a_rectangle_of_many_rods_bears_what_section_analysis_says() {
        let (width, height, n) = (0.02, 0.04, 200);
        let (tension, compression, modulus) = (100e6, 50e6, 12e9);
        let rod = |k: usize| Element {
            position: DVec2::new(0.0, height * ((k as f64 + 0.5) / n as f64 - 0.5)),
            area: width * height / n as f64,
            modulus,
            tension,
            compression,
        };
        let elements: Vec<Element> = (0..n).map(rod).collect();
        let bent = Bent::new(&elements, DVec2::Y).capacity();
        let exact = nominal_bending_strength(tension, compression) * width * height * height / 6.0;
        // Rods break on their surface, whose radius is 2.8 % of the height here.
        assert!((bent / exact - 1.0).abs() < 0.04, "{}", bent / exact);
    }

    #[test]
    fn strength_scales_the_moment() {
        let ring = |k: usize, factor: f64| Element {
            position: DVec2::from_angle(k as f64) * (0.3 + 0.01 * k as f64),
            area: 1e-3,
            modulus: 10e9 * (1.0 + 0.02 * k as f64),
            tension: factor * 90e6,
            compression: factor * 40e6,
        };
        let [one, two] = [1.0, 2.0].map(|f| {
            let elements: Vec<Element> = (0..40).map(|k| ring(k, f)).collect();
            moment_capacity(&elements)
        });
        assert!((two / one - 2.0).abs() < 1e-9, "{}", two / one);
    }
}
