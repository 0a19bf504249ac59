//! Three-point bending of clear wood as in ASTM D143, on the fibre model with the quasi-static solver.
//!
//! The specimen is filled with rods whose vertices lie in common cross-sections. Supports and load act as in beam theory: on
//! the mean displacement of a cross-section, distributed over it by area, so that nothing is crushed under a roller and the
//! cross-section may turn. Deflection is that of the middle cross-section relative to the supports, as the standard's yoke
//! measures it.
//!
//! | module | content |
//! |---|---|
//! | `specimen` | [`BendTest`]: the specimen and the test |
//! | `parameters` | [`BendParameters`]: the specimen and the model as files and options give them |
//! | `rig` | the specimen on its supports |
//! | `run` | the test itself |
//! | `outcome` | [`BendOutcome`]: what a test returns, and its evaluation |

mod error;
mod outcome;
mod parameters;
mod rig;
mod run;
mod specimen;

pub use error::BendError;
pub use outcome::{BendEvent, BendOutcome, BendPoint};
pub use parameters::BendParameters;
pub use specimen::{BendSection, BendTest};
