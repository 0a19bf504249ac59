//! Standard fracture tests of wood along the grain, on the fibre model with the quasi-static solver.
//!
//! Rods lie along the crack, which is in the middle plane between them, where bonds soften and break as they do in any
//! bundle ([`BondCriterion::Cohesive`](crate::BondCriterion)). All bonds may soften, not only those of the plane. The energy of
//! fracture that the specimen shows is measured as in a laboratory, from load, deflection and crack, and set beside the energy
//! that went into the bonds. It is found in two ways that use neither: by the work that is no longer stored over the area of the
//! crack, and by the change of the compliance, G = P²/(2B) dC/da (Irwin and Kies 1954). A single-edge notched beam breaks as a whole,
//! and only the work is measured.
//!
//! | module | content |
//! |---|---|
//! | `specimen` | [`FractureTest`]: the specimen and the test |
//! | `parameters` | [`FractureParameters`]: the specimen and the model as files and options give them |
//! | `section` | the cross-section as rods and facets |
//! | `bundle` | the specimen as a bundle of rods |
//! | `theory` | beam theory of the specimens |
//! | `rig` | the specimen on its supports; `supports`: these |
//! | `run` | the test itself |
//! | `outcome` | [`FractureOutcome`]: what a test returns, and its evaluation |
//! | `species` | [`fracture`]: the test of a species |
//! | `report` | [`FractureReport`]: what it returned, beside what went in |
//! | `tables` | points as text, and the curves |

mod bundle;
mod error;
mod outcome;
mod parameters;
mod report;
mod rig;
mod run;
mod section;
mod species;
mod specimen;
mod supports;
mod tables;
mod theory;

pub use error::FractureError;
pub use outcome::{FractureOutcome, FracturePoint, SteadyGrowth};
pub use parameters::FractureParameters;
pub use report::{Beside, FractureReport};
pub use species::{FractureRequest, FractureTested, fracture};
pub use specimen::{CrackSystem, FractureTest, FractureTestKind, RodArrangement};
