//! From a simulated break to the parameters of a drawn one (Yang 2019 §3), so that an artist can go on from physics.
//!
//! Every rod that broke gives an address in the section, a height along the grain, and tension or compression as the
//! cause. From these come the ductile zone, the inclination, the layers, the thorns of both zones and the relief, which is
//! scaled until the drawn face is as high as the simulated one from the 5th to the 95th percentile.

mod breaks;
mod face_shape;
mod fitting;
mod parameters;
mod report;
mod sector_search;
mod statistics;
mod trend;

pub(crate) use breaks::{BreakOnStem, LengthRange, MAX_GAP, main_range, mean_edge_length};
pub use fitting::{BreakFit, FaceFit};
pub use parameters::{FittedValue, UnfittedKeys};
pub use report::{FitReport, TissueBreaks};
pub(crate) use statistics::{Weighted, quantile};
