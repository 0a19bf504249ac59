//! Annual rings by the published erosion of a section's bitmap (Forests 2023 §3.3).

mod both_sides;
mod front;
mod kernel;
mod kernel_list;
mod method;
mod passes;
mod schedule;

pub use both_sides::{ErodedPasses, PixelCircle, erode_from_both_sides};
pub use kernel::Kernel;
pub use kernel_list::KernelListError;
pub use method::{Erosion, ErosionFronts, ErosionSchedule, InnerCircleError};
pub use passes::{NOT_ERODED, erode, erosion_passes};
pub use schedule::{KernelSchedule, Pass, ScheduleError, ring_numbers};
