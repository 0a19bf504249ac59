//! The interface between solvers and contacts: bodies that rods run into, and rods that run into each other.

use crate::bodies::state::ContactsState;
use crate::error::SolverError;
use crate::loads::Loads;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::vectors::Vectors;
use glam::DVec3;
use greenstick_geometry::{Cancelled, Context};

/// A contact as a penalty spring, for solvers that look for equilibrium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactSpring {
    /// The edge in contact.
    pub edge: u32,
    /// Parameter along it, 0 to 1.
    pub t: f64,
    /// The other edge and the parameter along it; `None` for a contact with a body.
    pub other: Option<(u32, f64)>,
    /// The body.
    pub body: Option<u32>,
    /// Point of contact, m.
    pub point: DVec3,
    /// Unit direction from the other edge or body to the edge.
    pub normal: DVec3,
    /// Force on the edge, N.
    pub force: DVec3,
    /// Stiffness along the normal, N/m.
    pub normal_stiffness: f64,
    /// Friction over the distance slid, N/m.
    pub tangential_stiffness: f64,
    /// Energy of the overlap, J.
    pub energy: f64,
    /// Energy that friction dissipates in the step, J.
    pub friction_loss: f64,
}

impl ContactSpring {
    /// Iterates over the vertices that the contact acts on, with their shares of the force.
    pub fn shares(&self) -> impl Iterator<Item = (usize, f64)> {
        let own = [(self.edge, 1.0 - self.t), (self.edge + 1, self.t)];
        let other = self.other.map(|(e, s)| [(e, s - 1.0), (e + 1, -s)]);
        own.into_iter()
            .chain(other.into_iter().flatten())
            .map(|(v, w)| (v as usize, w))
    }

    /// Returns the stiffness between the axes `row` and `column`, N/m.
    pub(crate) fn stiffness(&self, row: usize, column: usize) -> f64 {
        let along = self.normal[row] * self.normal[column];
        let same = f64::from(u8::from(row == column));
        self.normal_stiffness * along + self.tangential_stiffness * (same - along)
    }
}

/// Energy of contacts in a step, J.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ContactEnergy {
    /// Work of moved bodies.
    pub work: f64,
    /// Dissipated by friction.
    pub dissipated: f64,
    /// Stored in overlaps at the end of the step.
    pub stored: f64,
}

/// The step over which contacts are resolved: its state at the start, and its length.
#[derive(Debug, Clone, Copy)]
pub struct ContactStep<'a> {
    /// The bundle.
    pub bundle: &'a RodBundle,
    /// Its state at the start of the step.
    pub state: &'a State,
    /// Length of the step, s.
    pub length: f64,
}

/// The trial state of a solver that looks for equilibrium.
#[derive(Debug, Clone, Copy)]
pub struct ContactTrial<'a> {
    /// The bundle.
    pub bundle: &'a RodBundle,
    /// The trial state.
    pub state: &'a State,
    /// The state at the start of the step, from which contacts slide.
    pub start: &'a State,
    /// Time of the trial state, s.
    pub time: f64,
}

/// Bodies, and contacts between rods, as solvers see them.
pub trait Contacts: Send {
    /// Whether there is nothing to be in contact with, so that solvers need not ask.
    fn is_empty(&self) -> bool {
        false
    }

    /// Resolves the contacts of an explicit step by impulses. `velocity` are the velocities that vertices would have at its
    /// end without contact; they are changed before positions move on with them. Bodies move to the end of the step. Returns
    /// the energy that contacts give to rods and free bodies, J, or `None` without contact.
    ///
    /// # Errors
    /// [`SolverError::Cancelled`] where the caller cancels the work. Bodies and velocities are then of no use until
    /// [`Contacts::restore`].
    fn resolve(
        &mut self,
        step: &ContactStep,
        velocity: &mut Vectors,
        context: &Context,
    ) -> Result<Option<f64>, SolverError>;

    /// Sets `found` to the springs of all overlaps of a trial state.
    ///
    /// # Errors
    /// [`Cancelled`] where the caller cancels the work.
    fn find_springs(
        &mut self,
        trial: &ContactTrial,
        context: &Context,
        found: &mut Vec<ContactSpring>,
    ) -> Result<(), Cancelled>;

    /// Ends a step from `start` to `time` (s) whose contacts are `springs`.
    fn accept(&mut self, start: &State, time: f64, springs: &[ContactSpring]) -> ContactEnergy;

    /// Returns the energy stored in overlaps, J.
    fn stored_energy(&self) -> f64 {
        0.0
    }

    /// Follows a change of the bundle's numbering: vertex `i` was vertex `before[i]`.
    fn vertices_renumbered(&mut self, bundle: &RodBundle, before: &[u32]);

    /// Returns the energy of bodies, J.
    fn body_energy(&self) -> f64;

    /// Returns the state of all bodies, with what contacts have done to them.
    fn snapshot(&self) -> ContactsState;

    /// Returns to an earlier state, for a step that failed. `bundle` and `loads` are those of that state.
    fn restore(&mut self, saved: &ContactsState, bundle: &RodBundle, loads: &Loads);
}

/// No bodies and no contacts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct NoContacts;

impl Contacts for NoContacts {
    fn is_empty(&self) -> bool {
        true
    }

    fn resolve(
        &mut self,
        _: &ContactStep,
        _: &mut Vectors,
        _: &Context,
    ) -> Result<Option<f64>, SolverError> {
        Ok(None)
    }

    fn find_springs(
        &mut self,
        _: &ContactTrial,
        _: &Context,
        found: &mut Vec<ContactSpring>,
    ) -> Result<(), Cancelled> {
        found.clear();
        Ok(())
    }

    fn accept(&mut self, _: &State, _: f64, _: &[ContactSpring]) -> ContactEnergy {
        ContactEnergy::default()
    }

    fn vertices_renumbered(&mut self, _: &RodBundle, _: &[u32]) {}

    fn body_energy(&self) -> f64 {
        0.0
    }

    fn snapshot(&self) -> ContactsState {
        ContactsState::default()
    }

    fn restore(&mut self, _: &ContactsState, _: &RodBundle, _: &Loads) {}
}
