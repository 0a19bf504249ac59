//! The specimen and the test.

use super::error::FractureError;
use crate::bend_test::{MAX_MATRIX_GIGABYTES, matrix_gigabytes};
use crate::placement::Arrangement;
use serde::{Deserialize, Serialize};

greenstick_schema::choices! {
    /// A standard fracture test.
    pub enum FractureTestKind {
        /// Two arms are pulled apart: opening along the grain, mode I.
        DoubleCantileverBeam = "double-cantilever-beam",
        /// A beam with a crack in its middle plane is bent over two supports: sliding along the grain, mode II.
        EndNotchedFlexure = "end-notched-flexure",
    }
    /// The system of a crack along the grain: the direction of its normal, and L, in which it runs.
    pub enum CrackSystem {
        /// The normal is radial: the crack lies in an annual ring.
        Rl = "rl",
        /// The normal is tangential: the crack crosses the rings.
        Tl = "tl",
    }
    /// How rods are arranged in the section.
    pub enum RodArrangement {
        /// In layers, so that the plane of the crack is flat. One rod of each layer stands for the whole width.
        Layers = "layers",
        /// At random, as in scenes: the crack follows the facets of their cells, whose area is larger than that of the plane.
        Scattered = "scattered",
    }
}

impl RodArrangement {
    /// Returns the area of the facets along which the crack runs over that of its plane, as bonds are made for it.
    pub(super) fn roughness(self) -> f64 {
        match self {
            RodArrangement::Layers => 1.0,
            RodArrangement::Scattered => Arrangement::PoissonDisk.roughness(),
        }
    }
}

impl CrackSystem {
    /// Returns the part of a facet's normal that is radial, from 0 to 1. `upright` is the square of the cosine of its angle to
    /// that of the crack.
    pub(super) fn radial_part(self, upright: f64) -> f64 {
        match self {
            CrackSystem::Rl => upright,
            CrackSystem::Tl => 1.0 - upright,
        }
    }
}

/// Least crack of end-notched flexure over half the span. It grows stably from 1/∛3 on (Carlsson, Gillespie and Pipes 1986,
/// *Journal of Composite Materials* 20).
pub(super) const MIN_SLIDING_CRACK_RATIO: f64 = 0.7;

/// A fracture test of a specimen whose crack lies in its middle plane along the grain. The default is that of
/// [`super::FractureParameters`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FractureTest {
    /// Which test.
    pub kind: FractureTestKind,
    /// Width B, m.
    pub width: f64,
    /// Height of the specimen, twice that of an arm, m.
    pub height: f64,
    /// Length from the line of the load (double cantilever beam) or the support at the crack (end-notched flexure) to the other
    /// end or support, m.
    pub length: f64,
    /// Length of the crack at the start from the same line, m.
    pub crack: f64,
    /// The test ends when the crack has grown by this much, m.
    pub growth: f64,
    /// Normal of the crack.
    pub system: CrackSystem,
    /// Arrangement of rods.
    pub arrangement: RodArrangement,
    /// Distance between rods, m. An arm is divided into equal layers of about this height.
    pub spacing: f64,
    /// Longest edge, m.
    pub edge: f64,
    /// Seed of the positions of scattered rods.
    pub seed: u64,
}

/// A quantity, its value, whether that is valid, and what would be.
type Check = (&'static str, f64, bool, &'static str);

impl FractureTest {
    /// Returns the height of an arm, m.
    pub(super) fn arm(&self) -> f64 {
        0.5 * self.height
    }

    /// Returns the length to which the crack may grow, m: the end, or the load in the middle, beyond which it slides the other
    /// way.
    pub(super) fn farthest_crack(&self) -> f64 {
        match self.kind {
            FractureTestKind::DoubleCantileverBeam => self.length,
            FractureTestKind::EndNotchedFlexure => 0.5 * self.length,
        }
    }

    /// Checks the specimen.
    ///
    /// # Errors
    /// [`FractureError::Value`] or [`FractureError::TooFine`] for the first number out of range.
    pub fn check(&self) -> Result<(), FractureError> {
        for (what, value, valid, right) in self.positive().into_iter().chain(self.relations()) {
            if !valid {
                return Err(FractureError::Value { what, value, right });
            }
        }
        let across = match self.arrangement {
            RodArrangement::Layers => self.spacing,
            RodArrangement::Scattered => self.width,
        };
        let rods = self.height * across / (self.spacing * self.spacing);
        let sections = self.length / self.edge;
        let gigabytes = matrix_gigabytes(rods, sections);
        if gigabytes > MAX_MATRIX_GIGABYTES {
            return Err(FractureError::TooFine {
                rods,
                sections,
                gigabytes,
                most: MAX_MATRIX_GIGABYTES,
            });
        }
        Ok(())
    }

    /// Values that must be positive.
    fn positive(&self) -> [Check; 7] {
        [
            ("the specimen's width (m)", self.width),
            ("the specimen's height (m)", self.height),
            ("the specimen's length (m)", self.length),
            ("the crack's length (m)", self.crack),
            ("the crack's growth (m)", self.growth),
            ("the distance between rods (m)", self.spacing),
            ("the longest edge (m)", self.edge),
        ]
        .map(|(what, value)| {
            let valid = value > 0.0 && value.is_finite();
            (what, value, valid, "above 0 and finite")
        })
    }

    /// Relations between values.
    fn relations(&self) -> [Check; 6] {
        let slides = self.kind == FractureTestKind::EndNotchedFlexure;
        let least = MIN_SLIDING_CRACK_RATIO * 0.5 * self.length * (1.0 - 1e-9);
        let end = self.crack + self.growth;
        let smallest = match self.arrangement {
            RodArrangement::Layers => self.arm(),
            RodArrangement::Scattered => self.arm().min(self.width),
        };
        [
            (
                "the crack's length (m)",
                self.crack,
                self.crack >= self.height,
                "at least the specimen's height",
            ),
            (
                "the crack's length (m)",
                self.crack,
                !slides || self.crack >= least,
                "at least 0.7 of half the span, below which it runs by itself",
            ),
            (
                "the crack's length at the end of the test (m)",
                end,
                end <= self.farthest_crack() - self.arm(),
                if slides {
                    "at least half the specimen's height before the load in the middle"
                } else {
                    "at least half the specimen's height before the specimen's end"
                },
            ),
            (
                "the distance between rods (m)",
                self.spacing,
                self.spacing <= smallest,
                "at most the width and half the height",
            ),
            (
                "the longest edge (m)",
                self.edge,
                self.edge <= 0.25 * self.growth,
                "at most a quarter of the crack's growth",
            ),
            (
                "the longest edge (m)",
                self.edge,
                self.edge >= self.length / 20_000.0,
                "at least a 20,000th of the length",
            ),
        ]
    }
}
