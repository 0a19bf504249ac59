//! How a stem is filled with rods.

use crate::error::RodBundleError;
use greenstick_geometry::Cancelled;
use serde::{Deserialize, Serialize};

/// Area of the facets along which a crack runs between scattered rods, over that of its plane. A path along facets of all
/// directions is longer than the straight line by 4/π, the mean of |cos| + |sin|; Voronoi cells of scattered rods have 1.27 to
/// 1.32 (`greenstick fracture-test --arrangement scattered`).
const SCATTERED_ROUGHNESS: f64 = 4.0 / std::f64::consts::PI;

/// How rods are arranged in a cross-section.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Arrangement {
    /// A Poisson disk sample, as in the thesis.
    PoissonDisk,
    /// Bundles by ring and sector.
    Anatomy,
}

impl Arrangement {
    /// Returns the area of the facets along which a crack runs along the grain, over that of its plane. Planes along rings and
    /// rays are facets themselves.
    pub(crate) fn roughness(self) -> f64 {
        match self {
            Arrangement::PoissonDisk => SCATTERED_ROUGHNESS,
            Arrangement::Anatomy => 1.0,
        }
    }
}

/// Which rods are bonded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Neighbours {
    /// Rods whose cells meet in a facet.
    Facets,
    /// All rods within reach of each other, as in the thesis. A rod's bonds share the facets of its cell evenly.
    WithinReach,
}

/// The number of rods.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RodCount {
    /// This number in a cross-section.
    Number(u32),
    /// As many as fit with this distance (m) between them.
    Spacing(f64),
}

/// How a stem is filled with rods.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlacementOptions {
    /// Seed of everything random.
    pub seed: u64,
    /// Arrangement in the cross-section.
    pub arrangement: Arrangement,
    /// Number of rods.
    pub rods: RodCount,
    /// Length of edges, m.
    pub edges: EdgeLengths,
    /// Where edges are shorter; `None` for nowhere.
    pub fine: Option<FineEdges>,
    /// Range along the stem's axis, m; its usable part where `None`.
    pub range: Option<(f64, f64)>,
    /// Lengths along the stem's axis (m) at which clamps end. Where edges are equal one is centred on each, since the bending at
    /// a vertex is that of half of both edges beside it.
    pub clamp_ends: Vec<f64>,
    /// Reach of bonds, in mean distances of rods.
    pub reach: f64,
    /// Which rods within reach are bonded.
    pub neighbours: Neighbours,
    /// Lloyd iterations, which move rods to the centroids of their cells: they close the holes that thinning to a given
    /// number leaves. The thesis has none.
    pub lloyd: u32,
    /// Whether rods resist twist; `None` for only where they are curved.
    pub twisting: Option<bool>,
    /// Weibull modulus of the scatter of strength of rods and bonds; infinite for none.
    pub weibull: f64,
}

/// The range of edge lengths, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EdgeLengths {
    /// Shortest edge.
    pub least: f64,
    /// Longest edge; the same as the shortest for even vertices.
    pub greatest: f64,
}

/// A part of the stem in which edges are shorter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FineEdges {
    /// Range along the stem's axis, m.
    pub range: (f64, f64),
    /// How many times shorter, 1 or more.
    pub times: f64,
}

impl EdgeLengths {
    /// Returns edges of one length, m.
    pub fn even(length: f64) -> Self {
        EdgeLengths {
            least: length,
            greatest: length,
        }
    }
}

impl Default for PlacementOptions {
    /// The thesis's: 100 rods by Poisson disk with edges of 4 to 6 mm, without scatter.
    fn default() -> Self {
        PlacementOptions {
            seed: 1,
            arrangement: Arrangement::PoissonDisk,
            rods: RodCount::Number(100),
            edges: EdgeLengths {
                least: 4e-3,
                greatest: 6e-3,
            },
            fine: None,
            range: None,
            clamp_ends: Vec::new(),
            reach: 2.5,
            neighbours: Neighbours::Facets,
            lloyd: 3,
            twisting: None,
            weibull: f64::INFINITY,
        }
    }
}

/// Why a stem cannot be filled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlacementError {
    /// A number out of range.
    #[error("{what} is {value}, but it must be {right}")]
    Value {
        /// Which quantity, with its unit.
        what: &'static str,
        /// The value found.
        value: f64,
        /// The range that is valid.
        right: &'static str,
    },
    /// No cross-section to place rods in.
    #[error(
        "the stem has no cross-section with an area between {from} m and {to} m along its axis"
    )]
    NoSection {
        /// Start of the range, m.
        from: f64,
        /// End, m.
        to: f64,
    },
    /// Rods too far apart for the cross-section.
    #[error(
        "no rod fits: with {spacing} m between rods none lies in a cross-section of {area} m²; give a smaller spacing"
    )]
    NoRods {
        /// Spacing, m.
        spacing: f64,
        /// Area of the cross-section, m².
        area: f64,
    },
    /// The bundle cannot be built.
    #[error(transparent)]
    Bundle(#[from] RodBundleError),
    /// The caller cancelled the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl PlacementOptions {
    /// Checks that all numbers are in range.
    /// How many times shorter edges are at a length along the axis, m.
    pub(super) fn times_shorter(&self, along: f64) -> f64 {
        let fine = self
            .fine
            .filter(|f| (f.range.0..=f.range.1).contains(&along));
        fine.map_or(1.0, |f| f.times)
    }

    pub(super) fn check(&self) -> Result<(), PlacementError> {
        let EdgeLengths { least, greatest } = self.edges;
        let spacing = match self.rods {
            RodCount::Spacing(s) => s,
            RodCount::Number(n) => f64::from(n),
        };
        let positive = [
            ("the least edge (m)", least),
            ("the greatest edge (m)", greatest),
            ("the number or spacing of rods", spacing),
            ("the reach of bonds", self.reach),
        ];
        for (what, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return Err(PlacementError::Value {
                    what,
                    value,
                    right: "above 0 and finite",
                });
            }
        }
        if greatest < least {
            return Err(PlacementError::Value {
                what: "the greatest edge (m)",
                value: greatest,
                right: "no less than the least edge",
            });
        }
        if let Some(fine) = self
            .fine
            .filter(|f| !(f.times >= 1.0 && f.times.is_finite()))
        {
            return Err(PlacementError::Value {
                what: "how many times shorter edges are in a part",
                value: fine.times,
                right: "1 or more and finite",
            });
        }
        if self.weibull.is_nan() || self.weibull < 1.0 {
            return Err(PlacementError::Value {
                what: "the Weibull modulus",
                value: self.weibull,
                right: "1 or more",
            });
        }
        Ok(())
    }
}
