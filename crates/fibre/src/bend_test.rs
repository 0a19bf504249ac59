//! Three-point bending of clear wood as in ASTM D143, on the fibre model with the quasi-static solver.
//!
//! The specimen is filled with rods whose vertices lie in common sections. Supports and load act as beam theory has it:
//! on the mean displacement of a section, spread over it by area, so that nothing is crushed under a roller and the
//! section may turn. Deflection is that of the middle section against the supports, as the standard's yoke measures it.

use crate::event::{Event, EventKind};
use crate::failure::{BondCriterion, Failure};
use crate::loads::{Clamp, Motion};
use crate::placement::{HowMany, Placement, PlacementError, WoodMaterial, place};
use crate::solver::{NoContacts, World};
use crate::solvers::{Grip, QuasiStatic};
use crate::{Arrangement, SolverError};
use glam::DVec3;
use greenstick_geometry::{Cancelled, Context};
use greenstick_wood::primitive::{board, cylinder};
use greenstick_wood::species::nominal_bending_strength;
use greenstick_wood::stem::{Place, StemError, StemKind, StemOptions, find};
use serde::{Deserialize, Serialize};

/// The specimen's section.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BendSection {
    /// A rectangle; the load acts along its height.
    Rectangle {
        /// Width, m.
        width: f64,
        /// Height, m.
        height: f64,
    },
    /// A circle.
    Round {
        /// Diameter, m.
        diameter: f64,
    },
}

impl BendSection {
    /// Height along the load, m.
    pub fn height(self) -> f64 {
        match self {
            BendSection::Rectangle { height, .. } => height,
            BendSection::Round { diameter } => diameter,
        }
    }

    /// Area, m².
    pub fn area(self) -> f64 {
        match self {
            BendSection::Rectangle { width, height } => width * height,
            BendSection::Round { diameter } => 0.25 * std::f64::consts::PI * diameter * diameter,
        }
    }

    /// Second moment of area about the axis of bending, m⁴.
    pub fn inertia(self) -> f64 {
        match self {
            BendSection::Rectangle { width, height } => width * height.powi(3) / 12.0,
            BendSection::Round { diameter } => std::f64::consts::PI * diameter.powi(4) / 64.0,
        }
    }
}

/// A bending test. The default is ASTM D143's primary method: 50 mm × 50 mm × 760 mm on a span of 710 mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BendTest {
    /// Section.
    pub section: BendSection,
    /// Length of the specimen, m.
    pub length: f64,
    /// Distance of the supports, m.
    pub span: f64,
    /// Number of rods.
    pub rods: u32,
    /// Longest edge, m: half the span is divided into equal edges that are no longer.
    pub edge: f64,
    /// Seed of the rods' places and of scatter.
    pub seed: u64,
    /// Weibull modulus of the scatter of strength; infinite for none.
    pub weibull: f64,
    /// The test ends where the load has fallen to this part of the largest.
    pub end: f64,
}

impl Default for BendTest {
    fn default() -> Self {
        BendTest {
            section: BendSection::Rectangle {
                width: 0.05,
                height: 0.05,
            },
            length: 0.76,
            span: 0.71,
            rods: 49,
            edge: 0.01,
            seed: 1,
            weibull: f64::INFINITY,
            end: 0.5,
        }
    }
}

/// An equilibrium of the test.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BendPoint {
    /// Deflection of the middle against the supports, m.
    pub deflection: f64,
    /// Load, N.
    pub load: f64,
    /// Rods and bonds broken so far.
    pub broken: u32,
}

/// What a test returned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BendOutcome {
    /// Load against deflection, one point an equilibrium: two at a break, before and after.
    pub points: Vec<BendPoint>,
    /// Modulus of elasticity from the deflection, shear deflection and all, as in tables, Pa.
    pub modulus_of_elasticity: f64,
    /// Modulus of rupture from the largest load, Pa.
    pub modulus_of_rupture: f64,
    /// Work up to the largest load over the volume between the supports, J/m³.
    pub work_to_maximum_load: f64,
    /// Stress in the outermost fibre, as if linear, when the first rod or bond broke, Pa; `None` where nothing broke.
    pub stress_at_first_break: Option<f64>,
    /// What yielded and broke, in order. The time of an event is the ram's way in m.
    pub events: Vec<Event>,
    /// Whether the test ended because so much was broken that what was left had no equilibrium.
    pub came_apart: bool,
    /// Rods of the bundle.
    pub rods: usize,
    /// Length of its edges, m.
    pub edge: f64,
}

/// Why there is no outcome.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BendError {
    /// A number out of range.
    #[error("{what} is {value}, but it must be {right}")]
    Value {
        /// Which, with its unit.
        what: &'static str,
        /// The value found.
        value: f64,
        /// What would be right.
        right: &'static str,
    },
    /// The specimen has no stem.
    #[error(transparent)]
    Stem(#[from] StemError),
    /// The specimen cannot be filled.
    #[error(transparent)]
    Placement(#[from] PlacementError),
    /// No equilibrium.
    #[error(transparent)]
    Solver(#[from] SolverError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Load steps up to the deflection at which a linear beam would have the stress of rupture.
const STEPS: f64 = 10.0;
/// The modulus is taken where the outermost stress is below this part of the proportional limit's estimate.
const ELASTIC: f64 = 0.35;
/// The grips' springs over the specimen's stiffness.
const GRIP: f64 = 1e3;
/// The test ends where the deflection is this many times the linear beam's at rupture.
const LONGEST: f64 = 12.0;
/// Sides of a round specimen.
const AROUND: u32 = 72;

/// A specimen on its supports.
struct Rig {
    world: World,
    solver: QuasiStatic,
    edge: f64,
}

impl BendTest {
    fn check(&self) -> Result<(), BendError> {
        let height = self.section.height();
        let width = self.section.area() / height;
        let above = [
            ("the specimen's height or diameter (m)", height),
            ("the specimen's width (m)", width),
            ("the specimen's length (m)", self.length),
            ("the span (m)", self.span),
            ("the longest edge (m)", self.edge),
            ("the number of rods", f64::from(self.rods)),
        ];
        for (what, value) in above {
            if !(value > 0.0 && value.is_finite()) {
                return Err(BendError::Value {
                    what,
                    value,
                    right: "above 0 and finite",
                });
            }
        }
        let checks = [
            (
                "the span (m)",
                self.span,
                self.span < self.length,
                "shorter than the specimen",
            ),
            (
                "the span (m)",
                self.span,
                self.span >= 4.0 * height,
                "at least four times the height",
            ),
            (
                "the longest edge (m)",
                self.edge,
                self.edge <= self.span / 8.0,
                "at most an eighth of the span",
            ),
            (
                "the longest edge (m)",
                self.edge,
                self.edge >= self.span / 20_000.0,
                "at least a 20,000th of the span",
            ),
            (
                "the part of the load that ends the test",
                self.end,
                (0.0..1.0).contains(&self.end),
                "from 0 to below 1",
            ),
        ];
        for (what, value, good, right) in checks {
            if !good {
                return Err(BendError::Value { what, value, right });
            }
        }
        Ok(())
    }

    /// Runs the test on `wood`.
    ///
    /// # Errors
    /// [`BendError`].
    pub fn run(&self, wood: &WoodMaterial, context: &Context) -> Result<BendOutcome, BendError> {
        self.check()?;
        let mut rig = self.rig(wood, context)?;
        let (height, inertia) = (self.section.height(), self.section.inertia());
        let strength = nominal_bending_strength(wood.tension, wood.compression);
        let linear = strength * self.span * self.span / (6.0 * wood.longitudinal * height);
        let step = linear / STEPS;
        let mut points = vec![BendPoint {
            deflection: 0.0,
            load: 0.0,
            broken: 0,
        }];
        let (mut peak, mut came_apart) = (0.0f64, false);
        loop {
            context.step(
                "bending",
                (rig.world.state.time / (LONGEST * linear)).min(1.0),
            )?;
            let aim = rig.world.state.time + step;
            let next = rig
                .solver
                .next_equilibrium(&mut rig.world, &mut NoContacts, aim);
            match next {
                Ok(_) => {}
                // Parts that nothing holds any more have no equilibrium.
                Err(SolverError::NotConverged { .. }) if points.iter().any(|p| p.broken > 0) => {
                    came_apart = true;
                    break;
                }
                Err(other) => return Err(other.into()),
            }
            let load = rig.solver.grip_forces(&rig.world)[0];
            let moved = rig.solver.grip_displacements(&rig.world);
            let deflection = moved[0] - 0.5 * (moved[1] + moved[2]);
            let broken = rig
                .world
                .events
                .iter()
                .filter(|e| e.kind != EventKind::RodYielded)
                .count();
            points.push(BendPoint {
                deflection,
                load,
                broken: broken as u32,
            });
            peak = peak.max(load);
            if load < self.end * peak || deflection > LONGEST * linear {
                break;
            }
        }
        Ok(BendOutcome {
            came_apart,
            ..self.outcome(points, rig, inertia, strength)
        })
    }

    fn outcome(
        &self,
        points: Vec<BendPoint>,
        rig: Rig,
        inertia: f64,
        strength: f64,
    ) -> BendOutcome {
        let height = self.section.height();
        let stress = |load: f64| load * self.span * height / (8.0 * inertia);
        // The slope of the chord: below the proportional limit there is little to choose.
        let elastic = points
            .iter()
            .filter(|p| p.broken == 0 && stress(p.load) <= ELASTIC * strength)
            .fold((0.0, 0.0), |(a, b), p| {
                (a + p.load * p.deflection, b + p.deflection * p.deflection)
            });
        let slope = if elastic.1 > 0.0 {
            elastic.0 / elastic.1
        } else {
            points[1].load / points[1].deflection
        };
        let mut work = 0.0;
        let (mut best, mut work_at_best) = (0.0, 0.0);
        for pair in points.windows(2) {
            work += 0.5 * (pair[0].load + pair[1].load) * (pair[1].deflection - pair[0].deflection);
            if pair[1].load > best {
                (best, work_at_best) = (pair[1].load, work);
            }
        }
        let first = points
            .windows(2)
            .find(|p| p[1].broken > 0)
            .map(|p| stress(p[0].load));
        BendOutcome {
            modulus_of_elasticity: slope * self.span.powi(3) / (48.0 * inertia),
            modulus_of_rupture: stress(best),
            work_to_maximum_load: work_at_best / (self.section.area() * self.span),
            stress_at_first_break: first,
            rods: rig.world.bundle.first.len() - 1,
            events: rig.world.events,
            edge: rig.edge,
            points,
            came_apart: false,
        }
    }

    fn rig(&self, wood: &WoodMaterial, context: &Context) -> Result<Rig, BendError> {
        // Axes of the world: along the load, across it, and along the specimen.
        let (mesh, load, across, along, kind) = match self.section {
            BendSection::Rectangle { width, height } => {
                let mesh = board(self.length, width, height);
                (mesh, 1, 0, 2, StemKind::Board)
            }
            BendSection::Round { diameter } => {
                let mesh = cylinder(0.5 * diameter, self.length, AROUND);
                (mesh, 2, 0, 1, StemKind::Round)
            }
        };
        let options = StemOptions {
            kind: Some(kind),
            ..StemOptions::default()
        };
        let stem = find(&[mesh], &Place::Fraction(0.5), &options, context)?.stem;
        let half = (0.5 * self.span / self.edge - 1e-9).ceil().max(4.0);
        let edge = 0.5 * self.span / half;
        let over = (0.5 * (self.length - self.span) / edge + 1e-9)
            .floor()
            .max(1.0);
        let middle = 0.5 * stem.length;
        let reach = (half + over) * edge;
        let placement = Placement {
            seed: self.seed,
            arrangement: Arrangement::PoissonDisk,
            rods: HowMany::Number(self.rods),
            edges: (edge, edge),
            range: Some((middle - reach, middle + reach)),
            twisting: Some(false),
            weibull: self.weibull,
            ..Placement::default()
        };
        let bundle = place(&stem, wood, &placement)?.bundle;
        let (half, over) = (half as usize, over as usize);
        let section = |k: usize| -> Vec<u32> {
            (0..bundle.rods())
                .map(|r| (bundle.rod(r).start + k) as u32)
                .collect()
        };
        let [left, centre, right] = [over, over + half, over + 2 * half].map(section);
        let stiffness =
            GRIP * 48.0 * wood.longitudinal * self.section.inertia() / self.span.powi(3);
        let grip = |vertices: &Vec<u32>, axis: usize, speed: f64| Grip {
            vertices: vertices.clone(),
            weights: bundle.area.clone(),
            direction: -DVec3::AXES[axis],
            stiffness,
            speed,
        };
        let grips = vec![
            grip(&centre, load, 1.0),
            grip(&left, load, 0.0),
            grip(&right, load, 0.0),
            grip(&left, along, 0.0),
        ];
        let mut axes = [false; 3];
        axes[across] = true;
        // Sections at supports and load stay in their plane across: the specimen does not roll over.
        let clamps = [left, centre, right].map(|vertices| Clamp {
            axes,
            ..Clamp::of(&bundle, vertices, Motion::Fixed)
        });
        let mut world = World::new(bundle);
        world.loads.clamps = clamps.to_vec();
        world.failure = Failure {
            rods_break: true,
            rods_yield: true,
            bonds: BondCriterion::Stress,
            ..Failure::default()
        };
        let solver = QuasiStatic::new(None).with_grips(grips);
        Ok(Rig {
            world,
            solver,
            edge,
        })
    }
}
