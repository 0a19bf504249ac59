//! The specimen on its supports.

use super::error::BendError;
use super::flaws::{Flaws, SpecimenPositions};
use super::outcome::{BendEvent, BendPoint};
use super::specimen::{BendSection, BendTest};
use crate::contact::NoContacts;
use crate::error::SolverError;
use crate::event::{Event, EventKind};
use crate::failure::{BondCriterion, FailureCriteria};
use crate::loads::{Clamp, Motion};
use crate::placement::{
    Arrangement, EdgeLengths, PlacementOptions, WoodMaterial, fill_stem, fill_structured_stem,
};
use crate::rod_bundle::RodBundle;
use crate::solvers::{Grip, QuasiStatic};
use crate::vectors::Vectors;
use crate::world::World;
use glam::DVec3;
use greenstick_geometry::{Context, Mesh};
use greenstick_wood::appearance::WoodAppearance;
use greenstick_wood::moisture::AIR_DRY_PERCENT;
use greenstick_wood::primitive::{board, cylinder};
use greenstick_wood::rings::StemRings;
use greenstick_wood::species::Species;
use greenstick_wood::stem::{Stem, StemKind, StemLocation, StemOptions, find_stem};
use greenstick_wood::structure::{TissueBoundaries, WoodStructure};
use greenstick_wood::tissue::{BARK_START, Proportions};

/// Stiffness of the grips' springs over that of the specimen.
const GRIP_STIFFNESS_RATIO: f64 = 1e3;
/// Sides of a round specimen's mesh.
const ROUND_SIDES: u32 = 72;

/// A specimen on its supports.
pub(super) struct Rig {
    pub world: World,
    pub solver: QuasiStatic,
    /// Length of edges, m.
    pub edge: f64,
    pub rods: usize,
    pub events: Vec<BendEvent>,
    /// Positions of the vertices before anything moved, and the middle of the specimen, m.
    rest: Vectors,
    middle: DVec3,
    axes: Axes,
}

/// Axes of the world: along the load, across it, and along the specimen.
#[derive(Debug, Clone, Copy)]
struct Axes {
    load: usize,
    across: usize,
    along: usize,
}

/// The cross-sections of a specimen that grips and clamps hold, as their vertices.
struct HeldSections {
    left: Vec<u32>,
    centre: Vec<u32>,
    right: Vec<u32>,
}

/// How a specimen is divided along its length.
struct Division {
    /// Length of an edge, m.
    edge: f64,
    /// Edges in half the span.
    half_span: usize,
    /// Edges beyond each support.
    overhang: usize,
}

impl Division {
    fn new(test: &BendTest) -> Self {
        let half_span = (0.5 * test.span / test.edge - 1e-9).ceil().max(4.0);
        let edge = 0.5 * test.span / half_span;
        let overhang = (0.5 * (test.length - test.span) / edge + 1e-9).floor();
        Division {
            edge,
            half_span: half_span as usize,
            overhang: overhang.max(1.0) as usize,
        }
    }

    /// Half of the length that is filled with rods, m.
    fn half_length(&self) -> f64 {
        (self.half_span as f64 + self.overhang as f64) * self.edge
    }

    fn sections(&self, bundle: &RodBundle) -> HeldSections {
        let section = |k: usize| -> Vec<u32> {
            (0..bundle.rods())
                .map(|r| (bundle.rod(r).start + k) as u32)
                .collect()
        };
        HeldSections {
            left: section(self.overhang),
            centre: section(self.overhang + self.half_span),
            right: section(self.overhang + 2 * self.half_span),
        }
    }
}

/// Returns the structure of clear wood: annual rings of mature sapwood, as test specimens are cut.
fn clear_wood(stem: &Stem, species: &Species, seed: u64) -> WoodStructure {
    let proportions = Proportions {
        pith: 0.0,
        heartwood: 0.0,
        phloem: 0.0,
    };
    let appearance = WoodAppearance::of_stem(stem, &proportions, seed, Some(species), BARK_START);
    let rings = StemRings::new(appearance.usual_rings().of_sapwood());
    WoodStructure::new(species, AIR_DRY_PERCENT, rings, TissueBoundaries::SAPWOOD).mature()
}

impl Rig {
    /// Fills the specimen of a test with rods, weakens them by flaws, and puts it on its supports.
    pub fn new(
        test: &BendTest,
        (wood, species): (&WoodMaterial, Option<&Species>),
        flaws: Option<&Flaws>,
        context: &Context,
    ) -> Result<Self, BendError> {
        let (mesh, axes, kind) = specimen_mesh(test);
        let options = StemOptions {
            kind: Some(kind),
            slope_of_grain: 0.0,
            ..StemOptions::default()
        };
        let stem = find_stem(&[mesh], &StemLocation::Fraction(0.5), &options, context)?.stem;
        let division = Division::new(test);
        let (middle, half) = (0.5 * stem.length, division.half_length());
        let placement = PlacementOptions {
            seed: test.seed,
            arrangement: Arrangement::PoissonDisk,
            rods: test.rods,
            edges: EdgeLengths::even(division.edge),
            range: Some((middle - half, middle + half)),
            twisting: Some(false),
            weibull: test.weibull,
            ..PlacementOptions::default()
        };
        let placed = match species {
            None => fill_stem(&stem, wood, &placement, context)?,
            Some(species) => {
                let structure = clear_wood(&stem, species, test.seed);
                fill_structured_stem(&stem, wood, &structure, &placement, context)?
            }
        };
        let mut bundle = placed.bundle;
        let held = division.sections(&bundle);
        let middle = centroid(&bundle, &held.centre);
        if let Some(flaws) = flaws {
            let offset = |v: usize| bundle.rest.get(v) - middle;
            let height = |&v: &u32| -offset(v as usize)[axes.load];
            let positions = SpecimenPositions {
                heights: held.centre.iter().map(height).collect(),
                along: (0..bundle.vertices())
                    .map(|v| offset(v)[axes.along])
                    .collect(),
            };
            flaws.weaken(&mut bundle, &positions, test);
        }
        let grips = grips(test, wood, &bundle, &held, axes);
        let mut held_axes = [false; 3];
        held_axes[axes.across] = true;
        // Cross-sections at supports and load stay in their plane across: the specimen does not roll over.
        let clamps = [held.left, held.centre, held.right].map(|vertices| Clamp {
            axes: held_axes,
            ..Clamp::new(&bundle, vertices, Motion::Fixed)
        });
        let (rest, rods) = (bundle.rest.clone(), bundle.rods());
        let mut world = World::new(bundle);
        world.loads.clamps = clamps.to_vec();
        world.failure = FailureCriteria {
            rods_break: true,
            rods_yield: true,
            bonds: BondCriterion::Stress,
            ..FailureCriteria::default()
        };
        Ok(Rig {
            world,
            solver: QuasiStatic::new(None).with_grips(grips),
            edge: division.edge,
            rods,
            events: Vec::new(),
            rest,
            middle,
            axes,
        })
    }

    /// Goes to the next equilibrium on the way to the time `target`. Returns the point there.
    pub fn advance(
        &mut self,
        last: &BendPoint,
        target: f64,
        context: &Context,
    ) -> Result<BendPoint, SolverError> {
        let Rig { world, solver, .. } = self;
        solver.next_equilibrium(world, &mut NoContacts, target, context)?;
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
            let event = self.specimen_event(&event, last);
            self.events.push(event);
        }
        Ok(point)
    }

    fn specimen_event(&self, event: &Event, last: &BendPoint) -> BendEvent {
        let v = event.vertex as usize;
        let position = match event.kind {
            EventKind::RodYielded => self.rest.get(v).midpoint(self.rest.get(v + 1)),
            _ => self.rest.get(v),
        } - self.middle;
        BendEvent {
            deflection: last.deflection,
            load: last.load,
            kind: event.kind,
            rod: event.rod,
            other: event.other,
            along: position[self.axes.along],
            height: position[self.axes.load],
            across: position[self.axes.across],
            cause: event.cause,
            demand: event.demand,
            energy: event.energy,
        }
    }
}

fn specimen_mesh(test: &BendTest) -> (Mesh, Axes, StemKind) {
    match test.section {
        BendSection::Rectangle { width, height } => {
            let axes = Axes {
                load: 1,
                across: 0,
                along: 2,
            };
            (board(test.length, width, height), axes, StemKind::Board)
        }
        BendSection::Round { diameter } => {
            let mesh = cylinder(0.5 * diameter, test.length, ROUND_SIDES);
            let axes = Axes {
                load: 2,
                across: 0,
                along: 1,
            };
            (mesh, axes, StemKind::Round)
        }
    }
}

/// Returns the mean position of a cross-section's vertices, weighted by area, m.
fn centroid(bundle: &RodBundle, section: &[u32]) -> DVec3 {
    let total: f64 = bundle.area.iter().sum();
    let weighted = section.iter().zip(&bundle.area);
    weighted.fold(DVec3::ZERO, |sum, (&v, a)| {
        sum + bundle.rest.get(v as usize) * (a / total)
    })
}

/// Returns the grips: the load, the two supports, and one against motion along the specimen.
fn grips(
    test: &BendTest,
    wood: &WoodMaterial,
    bundle: &RodBundle,
    held: &HeldSections,
    axes: Axes,
) -> Vec<Grip> {
    let stiffness = GRIP_STIFFNESS_RATIO * 48.0 * wood.longitudinal * test.section.inertia()
        / test.span.powi(3);
    let grip = |vertices: &Vec<u32>, axis: usize, speed: f64| {
        Grip::on_mean(vertices.clone(), &bundle.area, -DVec3::AXES[axis])
            .with_spring(stiffness, speed)
    };
    vec![
        grip(&held.centre, axes.load, 1.0),
        grip(&held.left, axes.load, 0.0),
        grip(&held.right, axes.load, 0.0),
        grip(&held.left, axes.along, 0.0),
    ]
}
