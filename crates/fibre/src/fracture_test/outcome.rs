//! What a fracture test returns, and its evaluation.

use super::error::FractureError;
use super::specimen::{FractureTest, FractureTestKind};
use super::theory::BeamTheory;
use serde::{Deserialize, Serialize};

/// The first part of the crack's growth is left out of the evaluation: the process zone grows to its full length.
const START_FRACTION: f64 = 0.2;
/// The rest must span this part of the growth, with so many points.
const MIN_SPAN_FRACTION: f64 = 0.3;
const MIN_POINTS: usize = 4;

/// An equilibrium of the test.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct FracturePoint {
    /// Opening between the loads, or deflection of the middle relative to the supports, m.
    pub deflection: f64,
    /// Load, N.
    pub load: f64,
    /// Length of the crack, to where bonds hold nothing any more, m.
    pub crack: f64,
    /// Length to the end of the process zone, where bonds begin to soften, m.
    pub zone_end: f64,
    /// Work of the load so far, J.
    pub work: f64,
    /// Energy that is stored, J.
    pub stored: f64,
    /// Energy that bonds have dissipated so far by their law, J.
    pub dissipated_by_bonds: f64,
    /// Bonds broken so far, of what was tested.
    pub bonds_broken: u32,
    /// The largest demand on a rod over its strength.
    pub rod_demand: f64,
}

impl FracturePoint {
    /// Returns the work that is no longer stored, J.
    pub fn dissipated(&self) -> f64 {
        self.work - self.stored
    }
}

/// What a test returns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FractureOutcome {
    /// Load against deflection, one point for each equilibrium.
    pub points: Vec<FracturePoint>,
    /// Energy of fracture of the wood in the mode of the test, which went into the bonds, J/m².
    pub put_in: f64,
    /// Area of the facets along which the crack runs over that of its plane.
    pub roughness: f64,
    /// Energy of fracture by dissipated work over the area of the crack's plane, of a single-edge notched beam over that of its
    /// ligament, J/m².
    pub energy_by_work: f64,
    /// Measures that a crack gives that grows steadily, as in no single-edge notched beam.
    pub steady: Option<SteadyGrowth>,
    /// Compliance at the start, m/N.
    pub compliance: f64,
    /// The point of the largest load.
    pub maximum: FracturePoint,
    /// Mean length of the process zone, m; of a single-edge notched beam that when the crack begins to grow.
    pub process_zone: f64,
    /// Energy that bonds beside the crack's plane dissipated over that of all bonds.
    pub dissipated_beside: f64,
    /// Number of rods of what was tested.
    pub rods: usize,
    /// Width of what was tested, m.
    pub slice: f64,
    /// Length of edges, m.
    pub edge: f64,
}

/// Energies of fracture by the steady growth of a crack, J/m².
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SteadyGrowth {
    /// By the change of the compliance, P²/(2B) dC/da.
    pub by_compliance: f64,
    /// By beam theory from load and crack, with its correction of the root.
    pub by_beam_theory: f64,
    /// From load and the crack that the compliance tells.
    pub by_equivalent_crack: f64,
}

/// The evaluation of a test's points.
pub(super) struct Evaluation {
    pub energy_by_work: f64,
    pub steady: Option<SteadyGrowth>,
    pub compliance: f64,
    pub maximum: FracturePoint,
    pub process_zone: f64,
}

impl Evaluation {
    /// Evaluates the points of a test whose crack began at `start` (m).
    ///
    /// # Errors
    /// [`FractureError::LittleGrowth`] where the crack did not grow enough, [`FractureError::Whole`] where a beam that should have
    /// did not break through.
    pub fn new(
        test: &FractureTest,
        theory: &BeamTheory,
        points: &[FracturePoint],
        start: f64,
    ) -> Result<Self, FractureError> {
        match test.kind {
            FractureTestKind::SingleEdgeNotchedBeam => {
                Evaluation::broken_through(test, points, start)
            }
            _ => Evaluation::grown(test, theory, points, start),
        }
    }

    /// Evaluates a beam that broke through, by its work over the area of its ligament.
    fn broken_through(
        test: &FractureTest,
        points: &[FracturePoint],
        start: f64,
    ) -> Result<Self, FractureError> {
        let maximum = largest(points);
        let last = points.last().copied().unwrap_or_default();
        if !test.is_over(&last, &maximum, start) {
            return Err(FractureError::Whole {
                load: last.load,
                maximum: maximum.load,
                deflection: last.deflection,
            });
        }
        // Later it reaches the compressed side.
        let zone = points.iter().find(|p| p.crack > start);
        Ok(Evaluation {
            energy_by_work: last.dissipated() / (test.width * (test.height - start)),
            steady: None,
            compliance: compliance(points),
            maximum,
            process_zone: zone.map_or(0.0, |p| p.zone_end - start),
        })
    }

    /// Evaluates the growth of a crack.
    fn grown(
        test: &FractureTest,
        theory: &BeamTheory,
        points: &[FracturePoint],
        start: f64,
    ) -> Result<Self, FractureError> {
        let from = start + START_FRACTION * test.growth;
        let grown: Vec<FracturePoint> = (points.iter().copied())
            .filter(|p| p.crack >= from && p.zone_end < test.farthest_crack())
            .collect();
        let to = grown.last().map_or(from, |p| p.crack);
        let needed = MIN_SPAN_FRACTION * test.growth;
        if grown.len() < MIN_POINTS || to - from < needed {
            return Err(FractureError::LittleGrowth {
                from,
                to,
                points: grown.len(),
                needed,
            });
        }
        let mean = |value: &dyn Fn(&FracturePoint) -> f64| {
            grown.iter().map(value).sum::<f64>() / grown.len() as f64
        };
        let softening = Parabola::fitted(&grown, |p| p.deflection / p.load);
        let dissipated = Parabola::fitted(&grown, FracturePoint::dissipated);
        Ok(Evaluation {
            energy_by_work: mean(&|p| dissipated.slope(p.crack)) / test.width,
            steady: Some(SteadyGrowth {
                by_compliance: mean(&|p| {
                    p.load * p.load * softening.slope(p.crack) / (2.0 * test.width)
                }),
                by_beam_theory: mean(&|p| theory.energy_release_rate(p.load, p.crack)),
                by_equivalent_crack: mean(&|p| {
                    theory.energy_release_rate_by_compliance(p.load, p.deflection / p.load)
                }),
            }),
            compliance: compliance(points),
            maximum: largest(points),
            process_zone: mean(&|p| p.zone_end - p.crack),
        })
    }
}

/// Returns the compliance at the first load, m/N.
fn compliance(points: &[FracturePoint]) -> f64 {
    let elastic = points.iter().find(|p| p.load > 0.0);
    elastic.map_or(0.0, |p| p.deflection / p.load)
}

/// Returns the point of the largest load.
fn largest(points: &[FracturePoint]) -> FracturePoint {
    let larger = |a: FracturePoint, &b: &FracturePoint| if b.load > a.load { b } else { a };
    points.iter().fold(FracturePoint::default(), larger)
}

/// A parabola through points by least squares.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Parabola {
    centre: f64,
    /// Slope and half of the second derivative at the centre.
    slope: f64,
    bend: f64,
}

impl Parabola {
    /// Fits a value over the crack's length.
    fn fitted(points: &[FracturePoint], value: impl Fn(&FracturePoint) -> f64) -> Self {
        let count = points.len() as f64;
        let mean = |f: &dyn Fn(&FracturePoint) -> f64| points.iter().map(f).sum::<f64>() / count;
        let centre = mean(&|p| p.crack);
        let middle = mean(&|p| value(p));
        let power = |n: i32| mean(&|p| (p.crack - centre).powi(n));
        let (second, third, fourth) = (power(2), power(3), power(4));
        let first_moment = mean(&|p| (p.crack - centre) * (value(p) - middle));
        let second_moment = mean(&|p| ((p.crack - centre).powi(2) - second) * (value(p) - middle));
        let spread = fourth - second * second;
        let determinant = second * spread - third * third;
        Parabola {
            centre,
            slope: (first_moment * spread - second_moment * third) / determinant,
            bend: (second_moment * second - first_moment * third) / determinant,
        }
    }

    fn slope(&self, crack: f64) -> f64 {
        self.slope + 2.0 * self.bend * (crack - self.centre)
    }
}
