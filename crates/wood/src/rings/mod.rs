//! Annual rings of one section: the published erosion of its picture, and the continuous field that everything
//! downstream is written in (`model.md` §1; Forests 2023 §3.3).

pub mod erosion;
mod field;
mod kernel;
mod kernels;
mod pith;
mod schedule;
mod series;

pub use erosion::{Circle, NEVER, TwoSided, erode, passes, passes_of_all, two_sided};
pub use field::RingField;
pub use kernel::Kernel;
pub use kernels::KernelsError;
pub use pith::estimate_pith;
pub use schedule::{Kind, Pass, Schedule, ScheduleError, rings_of};
pub use series::{RingError, RingList};
