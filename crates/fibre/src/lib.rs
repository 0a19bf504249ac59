//! Wood that moves and breaks: rods along the grain, bonded to each other (Sutherland 2012, corrected in `model.md` §3;
//! natural curvature and twist after Bergou 2008 and 2010).
//!
//! | module | what is in it |
//! |---|---|
//! | [`placement`] | from a stem and a species to a bundle: points, cells, rods, bonds, strengths |
//! | [`bundle`] | [`Bundle`]: rods as arrays, their material and masses |
//! | [`bodies`] | [`Bodies`]: rigid bodies, contacts with them and between rods |
//! | [`bonds`] | [`Bonds`]: what joins a vertex to another rod's edge, and who gathers which force |
//! | [`state`] | [`State`]: places, velocities, frames, permanent strain; apart from the bundle, so that solvers share it |
//! | [`frames`] | parallel transport, curvature, twist |
//! | [`energy`] | energies by kind, forces, and Hessians of single elements |
//! | [`loads`] | [`Loads`]: clamps, forces, moments, gravity, damping, wind, snow |
//! | [`failure`] | when rods and bonds fail; [`topology`]: what is left then |
//! | [`event`] | [`Event`]: what happened when and where |
//! | [`scene`] | [`Scene`]: a TOML file of all this, and those that come with the program |
//! | [`solver`] | [`Solver`], [`World`], [`Contacts`]: the interface of all solvers |
//! | [`explicit`] | symplectic Euler, the reference solver; [`stability`] finds its step |
//! | [`kernel`] | [`Evaluator`]: the forces of whole bundles on wide registers and several threads |
//! | [`store`] | frames, tables and checkpoints as bytes |
//! | [`error`] | what can go wrong |
#![deny(missing_docs)]
// Loops over vertices and edges index several arrays alike.
#![allow(clippy::needless_range_loop)]

pub mod bend_test;
pub mod bodies;
pub mod bonds;
pub mod bundle;
pub mod energy;
pub mod error;
pub mod event;
pub mod explicit;
pub mod failure;
pub mod frames;
pub mod kernel;
pub mod loads;
pub mod placement;
pub mod scene;
pub mod solver;
pub mod solvers;
pub mod stability;
pub mod state;
pub mod store;
pub mod topology;
pub mod vectors;

pub use bend_test::{BendError, BendEvent, BendOutcome, BendPoint, BendSection, BendTest};
pub use bodies::{
    Bodies, BodiesState, Body, BodyError, BodyMotion, BodyState, ContactLedger, ContactOptions,
    Shape,
};
pub use bonds::{Bond, Bonds, Incidence};
pub use bundle::{Bundle, Rod, RodMaterial};
pub use error::{BundleError, LoadError, SolverError};
pub use event::{Cause, Event, EventKind};
pub use explicit::Explicit;
pub use failure::{BondCriterion, Failure};
pub use kernel::{Evaluator, Level};
pub use loads::{Clamp, Loads, Moment, Motion, PointForce, Pose, Ramp, Wind};
pub use placement::{Arrangement, HowMany, Placed, Placement, PlacementError, WoodMaterial};
pub use scene::{Scene, SceneError};
pub use solver::{Advance, ContactBook, Contacts, KnownLimit, NoContacts, Solver, Touch, World};
pub use solvers::{Grip, Implicit, Interactive, QuasiStatic};
pub use state::State;
pub use vectors::Vectors;
