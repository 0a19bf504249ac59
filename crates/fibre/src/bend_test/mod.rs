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
//! | `species` | [`bend`]: the test of a species |
//! | `report` | [`BendReport`]: what it returned, beside the tables of species |
//! | `all_species` | [`bend_all`]: the test of every species |
//! | `specimens` | [`bend_specimens`]: the test of many specimens of a species |
//! | `variation` | the wood of single specimens |
//! | `flaws` | the weakest link of a specimen, and the effect of its size |
//! | `specimens_report` | [`SpecimensReport`]: what they returned, beside tables and measurements |
//! | `measured` | [`MeasuredSpecimens`]: specimens that somebody measured |
//! | `statistics` | mean, scatter and correlation with their confidence intervals |
//! | `tables` | points, events and species as text, and the curve |

mod all_species;
mod error;
mod flaws;
mod grain;
mod measured;
mod outcome;
mod parameters;
mod report;
mod rig;
mod run;
mod species;
mod specimen;
mod specimens;
mod specimens_report;
mod statistics;
mod tables;
mod variation;

pub use all_species::{BendRow, BendTable, Summary, bend_all};
pub use error::{BendError, BendingError};
pub use grain::SlopedGrain;
pub use measured::{MeasuredSpecimens, MeasuredSummary, TooFewSpecimens};
pub use outcome::{BendEvent, BendOutcome, BendPoint};
pub use parameters::{BendParameters, BendSettings};
pub(crate) use report::short;
pub use report::{BendReport, Compared, Failing, Phase};
pub use species::{BendRequest, Bent, bend};
pub use specimen::{BendSection, BendTest, END_AT_MAXIMUM};
pub(crate) use specimen::{MAX_MATRIX_GIGABYTES, matrix_gigabytes};
pub use specimens::{CLEAR_WOOD_WEIBULL_MODULUS, SpecimensRequest, bend_specimens};
pub use specimens_report::{
    ExpectedScatter, SpecimenResult, SpecimenRow, SpecimensReport, SpecimensSummary,
};
pub use statistics::{Correlation, Statistics};
