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
        /// A beam whose middle block stands upright is notched from below and bent over two supports until it is broken through:
        /// opening along the grain, mode I.
        SingleEdgeNotchedBeam = "single-edge-notched-beam",
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

/// Least and greatest notch of a single-edge notched beam over its height: a shorter crack runs by itself, a longer one leaves no
/// ligament in which it could grow.
const NOTCH_RATIOS: (f64, f64) = (0.5, 0.8);

/// A fracture test of a specimen whose crack lies in its middle plane along the grain. The default is that of
/// [`super::FractureParameters`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FractureTest {
    /// Which test.
    pub kind: FractureTestKind,
    /// Width B, m.
    pub width: f64,
    /// Height of the specimen, twice that of an arm, m. The upright block of a single-edge notched beam is as long as high.
    pub height: f64,
    /// Length from the line of the load (double cantilever beam) to the other end, or from support to support, m.
    pub length: f64,
    /// Length of the crack at the start from the line of the load, from the support at the crack (end-notched flexure) or from below
    /// (single-edge notched beam), m.
    pub crack: f64,
    /// The test ends when the crack has grown by this much, m: in a single-edge notched beam through the whole ligament.
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

    /// Returns the length of rods, m.
    pub(super) fn grain_length(&self) -> f64 {
        match self.kind {
            FractureTestKind::SingleEdgeNotchedBeam => self.height,
            _ => self.length,
        }
    }

    /// Returns the length to which the crack may grow, m: the end, or the load in the middle, beyond which it slides the other
    /// way.
    pub(super) fn farthest_crack(&self) -> f64 {
        match self.kind {
            FractureTestKind::DoubleCantileverBeam => self.length,
            FractureTestKind::EndNotchedFlexure => 0.5 * self.length,
            FractureTestKind::SingleEdgeNotchedBeam => self.height,
        }
    }

    /// Checks the specimen.
    ///
    /// # Errors
    /// [`FractureError::Value`] or [`FractureError::TooFine`] for the first number out of range.
    pub fn check(&self) -> Result<(), FractureError> {
        let relations = match self.kind {
            FractureTestKind::SingleEdgeNotchedBeam => self.notch_relations().to_vec(),
            _ => self.crack_relations().to_vec(),
        };
        let all = (self.positive().into_iter().chain(relations)).chain(self.model_relations());
        for (what, value, valid, right) in all {
            if !valid {
                return Err(FractureError::Value { what, value, right });
            }
        }
        let across = match self.arrangement {
            RodArrangement::Layers => self.spacing,
            RodArrangement::Scattered => self.width,
        };
        let rods = self.height * across / (self.spacing * self.spacing);
        let sections = self.grain_length() / self.edge;
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

    /// Relations between the lengths of a specimen whose crack runs along it.
    fn crack_relations(&self) -> [Check; 3] {
        let slides = self.kind == FractureTestKind::EndNotchedFlexure;
        let least = MIN_SLIDING_CRACK_RATIO * 0.5 * self.length * (1.0 - 1e-9);
        let end = self.crack + self.growth;
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
        ]
    }

    /// Relations between the lengths of a notched beam.
    fn notch_relations(&self) -> [Check; 3] {
        let (least, most) = NOTCH_RATIOS;
        let notch = self.crack / self.height;
        [
            (
                "the distance of the supports (m)",
                self.length,
                self.length >= 2.0 * self.height,
                "at least twice the specimen's height, as long as which its upright block is",
            ),
            (
                "the notch (m)",
                self.crack,
                (least - 1e-9..=most + 1e-9).contains(&notch),
                "0.5 to 0.8 of the specimen's height",
            ),
            (
                "the crack's growth (m)",
                self.growth,
                (self.crack + self.growth - self.height).abs() <= 1e-9 * self.height,
                "the specimen's height less the notch: the beam breaks as a whole",
            ),
        ]
    }

    /// Relations between the model and the specimen.
    fn model_relations(&self) -> [Check; 3] {
        let smallest = match self.arrangement {
            RodArrangement::Layers => self.arm(),
            RodArrangement::Scattered => self.arm().min(self.width),
        };
        [
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
                self.edge >= self.grain_length() / 20_000.0,
                "at least a 20,000th of the length along the grain",
            ),
        ]
    }
}
