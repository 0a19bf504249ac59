//! The specimen on its supports.

use super::bundle::{ACROSS, Division, test_bundle};
use super::error::FractureError;
use super::outcome::FracturePoint;
use super::section::TestSection;
use super::specimen::{FractureTest, FractureTestKind, RodArrangement};
use super::supports::grips;
use super::theory::BeamTheory;
use crate::contact::NoContacts;
use crate::energy::energies;
use crate::error::SolverError;
use crate::failure::cohesion::Softening;
use crate::failure::demand::largest_demand;
use crate::failure::{BondCriterion, FailureCriteria};
use crate::loads::{Clamp, Motion};
use crate::placement::WoodMaterial;
use crate::solvers::QuasiStatic;
use crate::world::World;
use greenstick_geometry::Context;

/// Stiffness of the grips' springs over that of the specimen.
const GRIP_STIFFNESS_RATIO: f64 = 1e3;

/// A specimen on its supports.
pub(super) struct Rig {
    pub world: World,
    pub section: TestSection,
    pub division: Division,
    solver: QuasiStatic,
    kind: FractureTestKind,
    /// Width of the specimen over that of what is tested.
    slices: f64,
}

/// Where the crack is.
#[derive(Debug, Clone, Copy, PartialEq)]
struct CrackFront {
    /// Length to where bonds hold nothing any more, m.
    crack: f64,
    /// Length to where they begin to soften, m.
    zone_end: f64,
}

impl Rig {
    pub fn new(
        test: &FractureTest,
        wood: &WoodMaterial,
        context: &Context,
    ) -> Result<Self, FractureError> {
        let division = Division::new(test);
        let section = TestSection::new(test, context)?;
        let bundle = test_bundle(test, &section, &division, wood)?;
        let slices = test.width / section.width;
        let theory = BeamTheory::new(test, wood);
        let stiffness = GRIP_STIFFNESS_RATIO / (theory.compliance(test.crack) * slices);
        let grips = grips(test, &section, &division, stiffness);
        let held = match test.arrangement {
            RodArrangement::Layers => (0..bundle.vertices() as u32).collect(),
            RodArrangement::Scattered => {
                let rods: Vec<usize> = (0..section.rods.len()).collect();
                let sections = [0, division.edges / 2, division.edges];
                let vertices = sections.map(|k| division.vertices(&rods, k));
                vertices.concat()
            }
        };
        let mut axes = [false; 3];
        axes[ACROSS] = true;
        let clamp = Clamp {
            axes,
            ..Clamp::new(&bundle, held, Motion::Fixed)
        };
        let mut world = World::new(bundle);
        world.loads.clamps = vec![clamp];
        // Arms are to stay whole: what they would bear is reported.
        world.failure = FailureCriteria {
            bonds: BondCriterion::Cohesive,
            ..FailureCriteria::default()
        };
        Ok(Rig {
            world,
            section,
            division,
            solver: QuasiStatic::new(None).with_grips(grips),
            kind: test.kind,
            slices,
        })
    }

    /// Goes to the next equilibrium on the way to the deflection `target` (m). Returns the point there.
    pub fn advance(
        &mut self,
        last: &FracturePoint,
        target: f64,
        context: &Context,
    ) -> Result<FracturePoint, SolverError> {
        let Rig { world, solver, .. } = self;
        solver.next_equilibrium(world, &mut NoContacts, target, context)?;
        let moved = solver.grip_displacements(world);
        let forces = solver.grip_forces(world);
        let broken = std::mem::take(&mut world.events).len() as u32;
        let (deflection, force) = match self.kind {
            FractureTestKind::DoubleCantileverBeam => {
                (moved[0] + moved[1], 0.5 * (forces[0] + forces[1]))
            }
            FractureTestKind::EndNotchedFlexure => {
                let notched = 0.5 * (moved[1] + moved[2]);
                (moved[0] - 0.5 * (notched + moved[3]), forces[0])
            }
            FractureTestKind::SingleEdgeNotchedBeam => {
                (moved[0] - 0.5 * (moved[1] + moved[2]), forces[0])
            }
        };
        let load = force * self.slices;
        let CrackFront { crack, zone_end } = self.front();
        let World { bundle, state, .. } = &self.world;
        let rods = FailureCriteria {
            rods_break: true,
            ..FailureCriteria::default()
        };
        Ok(FracturePoint {
            deflection,
            load,
            crack: crack.max(last.crack),
            zone_end: zone_end.max(last.zone_end),
            work: last.work + 0.5 * (last.load + load) * (deflection - last.deflection),
            stored: energies(bundle, state).potential() * self.slices,
            dissipated_by_bonds: self.world.fracture_loss * self.slices,
            bonds_broken: last.bonds_broken + broken,
            rod_demand: largest_demand(&rods, bundle, state),
        })
    }

    /// Returns the rods that a bond joins, the lower number first.
    fn rods_of(&self, bond: usize) -> [usize; 2] {
        let bundle = &self.world.bundle;
        let rod = |vertex: u32| bundle.rod_of(vertex as usize);
        let [a, b] = [bundle.bonds.vertex[bond], bundle.bonds.edge[bond]].map(rod);
        [a.min(b), a.max(b)]
    }

    /// Finds where the crack is: the mean of all facets along which it runs, by their width.
    fn front(&self) -> CrackFront {
        let bundle = &self.world.bundle;
        let crossed: Vec<_> = (self.section.facets.iter())
            .filter(|f| self.section.is_crossed(f.rods))
            .collect();
        let mut facets = vec![FacetDamage::new(&self.division); crossed.len()];
        for bond in 0..bundle.bonds.len() {
            let rods = self.rods_of(bond);
            if let Some(number) = crossed.iter().position(|f| f.rods == rods) {
                let vertex = bundle.bonds.vertex[bond] as usize;
                let section = vertex - bundle.rod(bundle.rod_of(vertex)).start;
                let softening = Softening::new(bundle, &self.world.state, bond);
                let way = softening.strain / softening.end;
                facets[number].add(section, way, bundle.bonds.damage[bond]);
            }
        }
        let (mut width, mut crack, mut zone_end) = (0.0, 0.0, 0.0);
        for (facet, damage) in crossed.iter().zip(&facets) {
            let front = damage.front(&self.division);
            width += facet.width;
            crack += facet.width * front.crack;
            zone_end += facet.width * front.zone_end;
        }
        CrackFront {
            crack: crack / width,
            zone_end: zone_end / width,
        }
    }

    /// Returns the energy that bonds beside the crack's plane have dissipated, J.
    pub fn dissipated_beside(&self) -> f64 {
        let World { bundle, state, .. } = &self.world;
        let beside = (0..bundle.bonds.len()).filter(|&b| !self.section.is_crossed(self.rods_of(b)));
        let dissipated =
            beside.map(|b| Softening::new(bundle, state, b).dissipated(bundle.bonds.damage[b]));
        dissipated.sum::<f64>() * self.slices
    }
}

/// How far the bonds of a facet have softened.
#[derive(Debug, Clone)]
struct FacetDamage {
    /// Per cross-section: opening and slip over those at the end of softening; infinite where the bonds are gone.
    way: Vec<f64>,
    /// The last cross-section at which a bond is damaged.
    last_damaged: usize,
}

impl FacetDamage {
    fn new(division: &Division) -> Self {
        FacetDamage {
            way: vec![f64::INFINITY; division.edges + 1],
            last_damaged: 0,
        }
    }

    fn add(&mut self, section: usize, way: f64, damage: f64) {
        let known = self.way[section];
        self.way[section] = if known.is_finite() {
            known.max(way)
        } else {
            way
        };
        if damage > 0.0 {
            self.last_damaged = self.last_damaged.max(section);
        }
    }

    /// Finds where the bonds hold nothing any more, between cross-sections along a straight line.
    fn front(&self, division: &Division) -> CrackFront {
        let last = self.way.len() - 1;
        let first = self.way.iter().position(|w| *w < 1.0).unwrap_or(last);
        let (here, next) = (self.way[first], self.way[(first + 1).min(last)]);
        let back = if here > next {
            ((1.0 - here) / (here - next)).clamp(0.0, 1.0)
        } else {
            1.0
        };
        let crack = ((first as f64 - back) * division.edge).max(division.crack());
        CrackFront {
            crack,
            zone_end: (self.last_damaged as f64 * division.edge).max(crack),
        }
    }
}
