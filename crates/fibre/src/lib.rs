//! Wood that moves and breaks: rods along the grain, bonded to each other (Sutherland 2012, corrected where the modules say
//! so; natural curvature and twist after Bergou 2008 and 2010).
//!
//! | module | content |
//! |---|---|
//! | [`placement`] | from a stem and a species to a bundle: points, cells, rods, bonds, strengths |
//! | [`RodBundle`], [`Bonds`] | rods and bonds as arrays, with their material and masses |
//! | [`State`] | positions, velocities, frames and plastic strain, apart from the bundle |
//! | [`energy`] | energies by kind, their forces, and Hessians of single elements |
//! | [`ForceEvaluator`] | the forces of whole bundles on wide registers and several threads |
//! | [`Loads`] | clamps, forces, moments, gravity, damping, wind |
//! | [`FailureCriteria`] | when rods and bonds fail; [`topology`]: what is left then |
//! | [`bodies`] | rigid bodies, contacts with them and between rods |
//! | [`solvers`] | methods that move a [`World`] through time |
//! | [`scene`] | a TOML file of all this, and the built-in scenes |
//! | [`store`] | frames, tables and checkpoints as bytes |
//! | [`simulate`] | a scene simulated from its meshes to its records |
//! | [`outcome`] | what became of the wood: whether and how it parted |
//! | [`bend_test`] | three-point bending of clear wood |
//! | [`fracture_test`] | standard fracture tests along the grain |
#![deny(missing_docs)]
// Loops over vertices and edges index several arrays alike.
#![allow(clippy::needless_range_loop)]

// Unit tests share the bundles of the integration tests.
#[cfg(test)]
extern crate self as greenstick_fibre;
#[cfg(test)]
#[path = "../tests/support/mod.rs"]
mod support;

pub mod bend_test;
pub mod bodies;
mod bonds;
mod contact;
mod curve;
pub mod energy;
mod error;
mod evaluator;
mod event;
mod failure;
mod forces;
pub mod fracture_test;
mod loads;
pub mod material_frame;
pub mod outcome;
mod parallel;
pub mod placement;
mod reactions;
mod rod_bundle;
mod rotation;
pub mod scene;
mod simd;
pub mod simulate;
pub mod solvers;
mod state;
pub mod store;
pub mod topology;
mod vectors;
mod world;

pub use bend_test::{
    BendError, BendEvent, BendOutcome, BendParameters, BendPoint, BendSection, BendTest,
};
pub use bodies::{
    Bodies, BodiesState, Body, BodyError, BodyMotion, BodyState, ContactLedger, ContactOptions,
    ContactsState, Shape,
};
pub use bonds::{Bond, Bonds, Incidence};
pub use contact::{ContactEnergy, ContactSpring, ContactStep, ContactTrial, Contacts, NoContacts};
pub use curve::Curve;
pub use error::{LoadError, RodBundleError, SolverError};
pub use evaluator::ForceEvaluator;
pub use event::{Cause, Event, EventKind};
pub use failure::{BondCriterion, FailureCriteria};
pub use forces::Forces;
pub use loads::{Clamp, ClampForce, Keyframe, Loads, Moment, Motion, PointForce, Pose, Ramp, Wind};
pub use placement::{
    Arrangement, EdgeLengths, FineEdges, PlacedRods, PlacementError, PlacementOptions, RodCount,
    WoodMaterial,
};
pub use rod_bundle::{Rod, RodBundle, RodMaterial};
pub use scene::{Scene, SceneError};
pub use simd::SimdLevel;
pub use solvers::{AdvanceReport, Buckling, Explicit, Implicit, Interactive, QuasiStatic, Solver};
pub use state::State;
pub use vectors::Vectors;
pub use world::{Onset, StabilityLimit, World};
