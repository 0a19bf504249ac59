//! The force of two sides of wood that are pressed into each other across the grain.
//!
//! It grows in proportion to the overlap up to the crushing strength, then slowly while cells collapse, until their walls lie on
//! each other (Gibson and Ashby, *Cellular Solids*, 2nd edition, chapter 10: bending, collapse and densification). Without the
//! collapse a wedged splinter could carry a stem. Pressing sides apart again gives back what pressing them together took.

/// Crushing strength across the grain over that along it: 0.13 is the mean of the 112 species of the Wood Handbook (2010, Table
/// 5-3a, at 12 % moisture) that have both.
pub(super) const TRANSVERSE_STRENGTH_RATIO: f64 = 0.13;
/// Stiffness while cells collapse over that before: at a compression of 20 % the force is about twice that at the strength.
const COLLAPSE_STIFFNESS_RATIO: f64 = 0.06;

/// An overlap of two sides, or of a side with a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Overlap {
    /// Force that drives the sides apart, N.
    pub force: f64,
    /// Its derivative by the depth, N/m.
    pub stiffness: f64,
    /// Its potential, J.
    pub energy: f64,
}

impl Overlap {
    /// Returns the overlap `depth` (m) of sides with a stiffness (N/m) that are crushed at a force `strength` (N) and dense at an
    /// overlap `densification` (m).
    pub fn new(stiffness: f64, strength: f64, densification: f64, depth: f64) -> Self {
        let collapse = strength / stiffness;
        let densification = densification.max(collapse);
        let softer = COLLAPSE_STIFFNESS_RATIO * stiffness;
        let mut overlap = Overlap {
            force: 0.0,
            stiffness: 0.0,
            energy: 0.0,
        };
        let mut start = 0.0;
        for (end, stiffness) in [
            (collapse, stiffness),
            (densification, softer),
            (f64::INFINITY, stiffness),
        ] {
            if depth <= start && start > 0.0 {
                break;
            }
            let way = depth.min(end) - start;
            overlap.energy += way * (overlap.force + 0.5 * stiffness * way);
            overlap.force += stiffness * way;
            overlap.stiffness = stiffness;
            start = end;
        }
        overlap
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_are_slopes_of_the_energy_and_hardly_grow_while_cells_collapse() {
        let (stiffness, strength, dense) = (2e6, 30.0, 4e-4);
        let at = |depth: f64| Overlap::new(stiffness, strength, dense, depth);
        for depth in [2e-6, 1.4e-5, 1.6e-5, 1e-4, 3.9e-4, 4.1e-4, 9e-4] {
            let h = 1e-9;
            let (before, here, after) = (at(depth - h), at(depth), at(depth + h));
            let slope = (after.energy - before.energy) / (2.0 * h);
            assert!((slope / here.force - 1.0).abs() < 1e-6, "{depth}");
            let slope = (after.force - before.force) / (2.0 * h);
            assert!((slope / here.stiffness - 1.0).abs() < 1e-6, "{depth}");
        }
        assert_eq!(at(1e-5).force, 20.0);
        assert!((at(dense).force / strength - 2.54).abs() < 0.01);
        assert!(at(2.0 * dense).force > 20.0 * strength);
        // Wood without a limit is elastic at any depth.
        let elastic = Overlap::new(stiffness, f64::INFINITY, dense, 1e-3);
        assert!((elastic.force - 2e3).abs() < 1e-9 && (elastic.energy - 1.0).abs() < 1e-12);
    }
}
