//! What a forester measures on a stem: diameters, girth, ovality and pith along it, its volume over and under bark,
//! diameter at breast height, logs by Smalian's rule, age and mass.

mod age;
mod logs;
mod mass;
mod measurement_errors;
mod parameters;
mod profile;
mod report;
mod section_size;
mod stem_measures;
mod table;

pub use logs::{Log, LogOptions, LogReport};
pub use mass::{MassReport, WoodMass};
pub use measurement_errors::MeasurementErrors;
pub use parameters::MensurationParameters;
pub use report::{BreastHeightReport, MensurationReport};
pub use section_size::SectionSize;
pub use stem_measures::StemMeasures;
