//! Three-point bending of clear wood as in ASTM D143, on the fibre model with the quasi-static solver.
//!
//! The specimen is filled with rods whose vertices lie in common sections. Supports and load act as beam theory has it:
//! on the mean displacement of a section, spread over it by area, so that nothing is crushed under a roller and the
//! section may turn. Deflection is that of the middle section against the supports, as the standard's yoke measures it.

use crate::event::{Cause, Event, EventKind};
use crate::failure::{BondCriterion, Failure};
use crate::loads::{Clamp, Motion};
use crate::placement::{HowMany, Placement, PlacementError, WoodMaterial, place};
use crate::solver::{NoContacts, World};
use crate::solvers::{Grip, QuasiStatic};
use crate::vectors::Vectors;
use crate::{Arrangement, SolverError};
use glam::DVec3;
use greenstick_geometry::{Cancelled, Context};
use greenstick_wood::primitive::{board, cylinder};
use greenstick_wood::species::nominal_bending_strength;
use greenstick_wood::stem::{StemError, StemKind, StemLocation, StemOptions, find_stem};
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

/// A bending test. The default is ASTM D143's primary method: 50 mm × 50 mm × 760 mm on a span of 710 mm, its middle
/// loaded until the load has fallen to half.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BendTest {
    /// Section.
    pub section: BendSection,
    /// Length of the specimen, m.
    pub length: f64,
    /// Distance of the supports, m.
    pub span: f64,
    /// How many rods, or how far apart.
    pub rods: HowMany,
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
            rods: HowMany::Number(25),
            edge: 0.02,
            seed: 1,
            weibull: f64::INFINITY,
            end: 0.5,
        }
    }
}

/// An equilibrium of the test.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct BendPoint {
    /// Deflection of the middle against the supports, m.
    pub deflection: f64,
    /// Load, N.
    pub load: f64,
    /// Edges of rods that have yielded in compression so far.
    pub yielded: u32,
    /// Places at which rods have broken so far.
    pub rods_broken: u32,
    /// Bonds broken so far.
    pub bonds_broken: u32,
}

impl BendPoint {
    /// Rods and bonds broken so far.
    pub fn broken(&self) -> u32 {
        self.rods_broken + self.bonds_broken
    }
}

/// Something that failed, and where in the specimen before it was bent.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BendEvent {
    /// Deflection of the last equilibrium before, m.
    pub deflection: f64,
    /// Load then, N.
    pub load: f64,
    /// What happened.
    pub kind: EventKind,
    /// Rod of the unbroken bundle; of a bond the one whose vertex it holds.
    pub rod: u32,
    /// The other rod of a bond.
    pub other: Option<u32>,
    /// Along the specimen from its middle, m.
    pub along: f64,
    /// From the axis towards the load, m: above 0 is the side in compression.
    pub height: f64,
    /// From the axis across, m.
    pub across: f64,
    /// Why.
    pub cause: Cause,
    /// How far the criterion was passed: demand over strength.
    pub demand: f64,
    /// Energy that is no longer stored, J.
    pub energy: f64,
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
    /// The point at the largest load.
    pub maximum: BendPoint,
    /// What yielded and broke, in order.
    pub events: Vec<BendEvent>,
    /// Whether the test ended because after a break no equilibrium was found.
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
    /// More unknowns than memory is sensibly given.
    #[error(
        "{rods:.0} rods of {sections:.0} sections need a matrix of about {gigabytes:.0} GB, but at most {most:.0} GB are \
         taken; give fewer rods or longer edges"
    )]
    TooFine {
        /// Rods, about.
        rods: f64,
        /// Sections along the specimen, about.
        sections: f64,
        /// Size of the matrix, GB.
        gigabytes: f64,
        /// The largest, GB.
        most: f64,
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

/// Largest matrix, GB.
const MOST_GIGABYTES: f64 = 4.0;
/// Part of the work that is done at the first break, for want of a better guess.
const TO_THE_BREAK: f64 = 0.5;

/// A specimen on its supports.
struct Rig {
    world: World,
    solver: QuasiStatic,
    edge: f64,
    rods: usize,
    /// The vertices before anything moved, and the middle of the specimen, m.
    rest: Vectors,
    middle: DVec3,
    /// Axes along the load, across it, and along the specimen.
    axes: [usize; 3],
    events: Vec<BendEvent>,
}

impl Rig {
    /// Goes to the next equilibrium on the way to `aim`; the point there.
    fn advance(&mut self, last: &BendPoint, aim: f64) -> Result<BendPoint, SolverError> {
        let Rig { world, solver, .. } = self;
        solver.next_equilibrium(world, &mut NoContacts, aim)?;
        let moved = solver.grip_displacements(world);
        let mut point = BendPoint {
            deflection: moved[0] - 0.5 * (moved[1] + moved[2]),
            load: solver.grip_forces(world)[0],
            ..*last
        };
        for event in std::mem::take(&mut world.events) {
            match event.kind {
                EventKind::RodYielded => point.yielded += 1,
                EventKind::RodBroke => point.rods_broken += 1,
                EventKind::BondBroke => point.bonds_broken += 1,
            }
            let told = self.told(&event, last);
            self.events.push(told);
        }
        Ok(point)
    }

    fn told(&self, event: &Event, last: &BendPoint) -> BendEvent {
        let v = event.vertex as usize;
        let place = match event.kind {
            EventKind::RodYielded => self.rest.get(v).midpoint(self.rest.get(v + 1)),
            _ => self.rest.get(v),
        };
        let [load, across, along] = self.axes.map(|a| (place - self.middle)[a]);
        BendEvent {
            deflection: last.deflection,
            load: last.load,
            kind: event.kind,
            rod: event.rod,
            other: event.other,
            along,
            height: load,
            across,
            cause: event.cause,
            demand: event.demand,
            energy: event.energy,
        }
    }
}

impl BendTest {
    /// Checks the specimen.
    ///
    /// # Errors
    /// [`BendError::Value`] or [`BendError::TooFine`] for the first number that is out of range.
    pub fn check(&self) -> Result<(), BendError> {
        let height = self.section.height();
        let width = self.section.area() / height;
        let (what, rods) = match self.rods {
            HowMany::Number(n) => ("the number of rods", f64::from(n)),
            HowMany::Spacing(s) => ("the distance between rods (m)", s),
        };
        let above = [
            ("the specimen's height or diameter (m)", height),
            ("the specimen's width (m)", width),
            ("the specimen's length (m)", self.length),
            ("the span (m)", self.span),
            ("the longest edge (m)", self.edge),
            (what, rods),
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
        let one = matches!(self.rods, HowMany::Spacing(s) if s > height.min(width));
        let scatter = (
            "the Weibull modulus of the scatter",
            self.weibull,
            self.weibull >= 1.0,
            "1 or more",
        );
        let spacing = (what, rods, !one, "at most the height and the width");
        for (what, value, good, right) in checks.into_iter().chain([scatter, spacing]) {
            if !good {
                return Err(BendError::Value { what, value, right });
            }
        }
        let rods = match self.rods {
            HowMany::Number(n) => f64::from(n),
            HowMany::Spacing(s) => self.section.area() / (s * s),
        };
        let sections = self.length / self.edge;
        // Three unknowns a vertex, each with those of its section and the one before; matrix and factor.
        let gigabytes = 2.0 * 8e-9 * (3.0 * rods * sections) * (4.5 * rods);
        if gigabytes > MOST_GIGABYTES {
            return Err(BendError::TooFine {
                rods,
                sections,
                gigabytes,
                most: MOST_GIGABYTES,
            });
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
        let mut points = vec![BendPoint::default()];
        let (mut last, mut peak, mut came_apart) = (points[0], 0.0f64, false);
        let expected = expected_deflection(wood, linear);
        let mut done = 0.0f64;
        loop {
            let part = if last.broken() == 0 {
                TO_THE_BREAK * (last.deflection / expected).min(1.0)
            } else {
                let fallen = (1.0 - last.load / peak) / (1.0 - self.end);
                TO_THE_BREAK + (1.0 - TO_THE_BREAK) * fallen.clamp(0.0, 1.0)
            };
            done = done.max(part);
            context.report(done)?;
            let aim = rig.world.state.time + step;
            last = match rig.advance(&last, aim) {
                Ok(point) => point,
                // Parts that nothing holds any more have no equilibrium, or none that can be found.
                Err(SolverError::NotConverged { .. }) if last.broken() > 0 => {
                    came_apart = true;
                    break;
                }
                Err(other) => return Err(other.into()),
            };
            points.push(last);
            peak = peak.max(last.load);
            if last.load < self.end * peak || last.deflection > LONGEST * linear {
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
            .filter(|p| p.broken() == 0 && stress(p.load) <= ELASTIC * strength)
            .fold((0.0, 0.0), |(a, b), p| {
                (a + p.load * p.deflection, b + p.deflection * p.deflection)
            });
        let slope = if elastic.1 > 0.0 {
            elastic.0 / elastic.1
        } else {
            points[1].load / points[1].deflection
        };
        let mut work = 0.0;
        let (mut best, mut work_at_best) = (points[0], 0.0);
        for pair in points.windows(2) {
            work += 0.5 * (pair[0].load + pair[1].load) * (pair[1].deflection - pair[0].deflection);
            if pair[1].load > best.load {
                (best, work_at_best) = (pair[1], work);
            }
        }
        let first = points
            .windows(2)
            .find(|p| p[1].broken() > 0)
            .map(|p| stress(p[0].load));
        BendOutcome {
            modulus_of_elasticity: slope * self.span.powi(3) / (48.0 * inertia),
            modulus_of_rupture: stress(best.load),
            work_to_maximum_load: work_at_best / (self.section.area() * self.span),
            stress_at_first_break: first,
            maximum: best,
            rods: rig.rods,
            events: rig.events,
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
        let stem = find_stem(&[mesh], &StemLocation::Fraction(0.5), &options, context)?.stem;
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
            rods: self.rods,
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
        let total: f64 = bundle.area.iter().sum();
        let middle = centre
            .iter()
            .zip(&bundle.area)
            .fold(DVec3::ZERO, |sum, (&v, a)| {
                sum + bundle.rest.get(v as usize) * (a / total)
            });
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
        let (rest, rods) = (bundle.rest.clone(), bundle.rods());
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
            rods,
            rest,
            middle,
            axes: [load, across, along],
            events: Vec::new(),
        })
    }
}

/// About the deflection at the first break, of that of a linear beam at rupture: by the curvatures at the middle of the
/// span, of which the yielded part is a third. For the time left only.
fn expected_deflection(wood: &WoodMaterial, linear: f64) -> f64 {
    const YIELDED: f64 = 1.0 / 3.0;
    let m = (wood.tension / wood.compression).max(1.0);
    // Curvature at rupture, f_t/(E x_t) with x_t = 2 m h/(m + 1)², over that of the linear beam, 2 MOR/(E h).
    let last = wood.compression * (m + 1.0) * (m + 1.0) / 2.0;
    let even = 2.0 * nominal_bending_strength(wood.tension, wood.compression);
    linear * (1.0 + YIELDED * (last / even - 1.0).max(0.0))
}
