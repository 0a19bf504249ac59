//! Annual rings: the shape of rings in a section ([`RingField`]), and the sources that divide it into years
//! ([`RingSource`]).

mod address;
mod concentric;
mod division;
mod eccentricity;
mod erosion;
mod field;
mod onset;
mod pith;
mod section;
mod series;
mod source;
mod years;

pub use address::StemAddress;
pub use concentric::{ConcentricRings, LATEWOOD_FRACTION, RingEdges};
pub use division::{RingDivision, RingSeriesParameters, StemRings};
pub use erosion::{
    ErodedPasses, Erosion, ErosionFronts, ErosionSchedule, InnerCircleError, Kernel,
    KernelListError, KernelSchedule, NOT_ERODED, Pass, PixelCircle, ScheduleError, erode,
    erode_from_both_sides, erosion_passes, ring_numbers,
};
pub(crate) use field::FieldRay;
pub use field::RingField;
pub use onset::ONSET_RANGE;
pub use pith::{PITH_OFFSET_RMS, estimate_pith};
pub use section::{
    AnnotatedRing, RingComparison, RingCurve, RingsFile, SectionFile, SectionFileError,
    SectionOutline, SectionRingError, SectionRingMethod, SectionRings,
};
pub use series::{MAX_RINGS, RingError, RingSeries};
pub use source::{RingPart, RingPosition, RingSource};
pub(crate) use years::{latewood_strength, periodic_cells};
