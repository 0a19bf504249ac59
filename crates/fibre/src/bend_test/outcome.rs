//! What a bending test returns, and its evaluation.

use super::specimen::BendTest;
use crate::event::{Cause, EventKind};
use serde::{Deserialize, Serialize};

/// An equilibrium of the test.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct BendPoint {
    /// Deflection of the middle relative to the supports, m.
    pub deflection: f64,
    /// Load, N.
    pub load: f64,
    /// Edges of rods that have yielded in compression so far.
    pub yielded: u32,
    /// Number of breaks of rods so far.
    pub rods_broken: u32,
    /// Bonds broken so far.
    pub bonds_broken: u32,
}

impl BendPoint {
    /// Returns the number of breaks of rods and bonds so far.
    pub fn broken(&self) -> u32 {
        self.rods_broken + self.bonds_broken
    }
}

/// A failure, and its position in the specimen before it was bent.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BendEvent {
    /// Deflection of the last equilibrium before, m.
    pub deflection: f64,
    /// Its load, N.
    pub load: f64,
    /// What happened.
    pub kind: EventKind,
    /// Rod of the unbroken bundle; for a bond the rod of its vertex.
    pub rod: u32,
    /// The other rod of a bond.
    pub other: Option<u32>,
    /// Position along the specimen from its middle, m.
    pub along: f64,
    /// Position from the axis towards the load, m: above 0 on the side in compression.
    pub height: f64,
    /// Position from the axis across, m.
    pub across: f64,
    /// The criterion that was exceeded.
    pub cause: Cause,
    /// Demand over strength.
    pub demand: f64,
    /// Energy that is no longer stored, J.
    pub energy: f64,
}

/// What a test returns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BendOutcome {
    /// Load against deflection, one point for each equilibrium: two at a break, before and after.
    pub points: Vec<BendPoint>,
    /// Modulus of elasticity from the deflection, which includes that of shear as in tables, Pa.
    pub modulus_of_elasticity: f64,
    /// Modulus of rupture from the largest load, Pa.
    pub modulus_of_rupture: f64,
    /// Work up to the largest load over the volume between the supports, J/m³.
    pub work_to_maximum_load: f64,
    /// Stress in the outermost fibre, as if linear, when the first rod or bond broke, Pa; `None` where nothing broke.
    pub stress_at_first_break: Option<f64>,
    /// The point of the largest load.
    pub maximum: BendPoint,
    /// What yielded and broke, in order.
    pub events: Vec<BendEvent>,
    /// Whether the test ended because no equilibrium was found after a break.
    pub came_apart: bool,
    /// Number of rods in the bundle.
    pub rods: usize,
    /// Length of its edges, m.
    pub edge: f64,
}

/// The modulus is taken where the stress in the outermost fibre is below this fraction of the estimated strength.
const ELASTIC_FRACTION: f64 = 0.35;

/// The curve of a test.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Evaluation {
    pub modulus_of_elasticity: f64,
    pub modulus_of_rupture: f64,
    pub work_to_maximum_load: f64,
    pub stress_at_first_break: Option<f64>,
    pub maximum: BendPoint,
}

impl Evaluation {
    /// Evaluates the points of a test; `strength` is the expected modulus of rupture, Pa.
    pub fn new(test: &BendTest, points: &[BendPoint], strength: f64) -> Self {
        let inertia = test.section.inertia();
        let stress = |load| test.fibre_stress(load);
        // The least-squares slope through the origin: below the proportional limit the choice hardly matters.
        let elastic = points
            .iter()
            .filter(|p| p.broken() == 0 && stress(p.load) <= ELASTIC_FRACTION * strength)
            .fold((0.0, 0.0), |(a, b), p| {
                (a + p.load * p.deflection, b + p.deflection * p.deflection)
            });
        let slope = if elastic.1 > 0.0 {
            elastic.0 / elastic.1
        } else {
            points[1].load / points[1].deflection
        };
        let mut work = 0.0;
        let (mut maximum, mut work_to_maximum) = (points[0], 0.0);
        for pair in points.windows(2) {
            work += 0.5 * (pair[0].load + pair[1].load) * (pair[1].deflection - pair[0].deflection);
            if pair[1].load > maximum.load {
                (maximum, work_to_maximum) = (pair[1], work);
            }
        }
        let first_break = points.windows(2).find(|p| p[1].broken() > 0);
        Evaluation {
            modulus_of_elasticity: slope * test.span.powi(3) / (48.0 * inertia),
            modulus_of_rupture: stress(maximum.load),
            work_to_maximum_load: work_to_maximum / (test.section.area() * test.span),
            stress_at_first_break: first_break.map(|p| stress(p[0].load)),
            maximum,
        }
    }
}
