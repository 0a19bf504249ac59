//! Annual rings of one section, from its outline alone (Forests 2023 §3.3): those of the ring field or of an erosion, their
//! curves, a comparison with rings that were annotated by hand, a picture, and the file that they are read from and written
//! to.

mod compare;
mod curves;
mod eroded;
mod error;
mod file;
mod file_error;
mod outline;
mod overlay;
mod paint;
mod rings;

pub use compare::{AnnotatedRing, RingComparison};
pub use curves::RingCurve;
pub use error::SectionRingError;
pub use file::{RingsFile, SectionFile};
pub use file_error::SectionFileError;
pub use outline::SectionOutline;
pub use rings::{SectionRingMethod, SectionRings};
