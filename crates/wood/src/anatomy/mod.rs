//! The inside of a stem as data: sections, rings, voxels and particles (Xu et al., *Forests* 2023, §3).
//!
//! A stem that was found in a mesh is cut into sections square to its centreline ([`StemSections`]). [`Anatomy`] gives
//! each of them rings, from the ring field or by erosion, and from there come pixels ([`Anatomy::rasterize`]), voxels
//! ([`Anatomy::voxel_slice`]), particles ([`ParticleLayers`]) and pictures ([`Anatomy::paint_section`],
//! [`Anatomy::paint_longitudinal`]). Sections do not depend on each other, so a caller may make them on as many threads
//! as there are, and need not hold more of them than it wants.
//!
//! ```
//! use greenstick_geometry::Context;
//! use greenstick_wood::anatomy::{Anatomy, AnatomyOptions, LayerOptions, ParticleLayers};
//! use greenstick_wood::appearance::WoodAppearance;
//! use greenstick_wood::rings::RingDivision;
//! use greenstick_wood::primitive::{BranchOptions, branch};
//! use greenstick_wood::stem::{StemLocation, StemOptions, find_stem};
//!
//! let context = Context::quiet();
//! let meshes = [branch(&BranchOptions::default())];
//! let found = find_stem(&meshes, &StemLocation::Fraction(0.5), &StemOptions::default(), &context)?;
//! let options = AnatomyOptions { resolution: 64, division: RingDivision::Even(12), ..AnatomyOptions::default() };
//! let anatomy = Anatomy::new(&found, &meshes[0], &options, WoodAppearance::softwood(), &context)?;
//!
//! let layers = LayerOptions { sectors: 24, layers: Some(4), ..LayerOptions::default() };
//! let layers = ParticleLayers::sample(&anatomy, &layers, &context)?;
//! assert_eq!(layers.particles().count(), 12 * 24 * 4);
//!
//! let middle = 0.5 * anatomy.sections().length();
//! let slice = anatomy.voxel_slice(middle, &context)?;
//! let outermost = slice.rings.iter().max();
//! assert_eq!(outermost, Some(&12));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod board_elements;
mod cores;
mod elements;
mod error;
mod hexahedra;
mod layers;
mod limb_report;
mod limits;
mod longitudinal;
mod mapping;
mod measures;
mod mensuration;
mod model;
mod other_rings;
mod outline;
mod painting;
mod palette;
mod parameters;
mod particles;
mod passes;
mod pictured_sections;
mod report;
mod request;
mod section_raster;
mod section_rings;
mod sections;
mod sectors;
mod segment_report;
mod slicer;
mod smoothing;
mod solid;
mod springs;
mod stem_rings;
mod stems;
mod surface;
mod voxels;

pub use cores::{Core, core_table};
pub use error::AnatomyError;
pub use hexahedra::{ElementError, StemElement, StemElements};
pub use layers::{BundleSpread, LayerOptions, ParticleLayer, ParticleLayers};
pub use limb_report::{LimbReport, limb_table};
pub use limits::{MAX_PARTICLES, RESOLUTION_RANGE};
pub use mapping::{AddressMapping, GrainAddress, MappedAddress, MappingComparison};
pub use measures::{RingMeasures, SectionMeasures};
pub use mensuration::{
    BreastHeightReport, Log, LogOptions, LogReport, MassReport, MeasurementErrors,
    MensurationParameters, MensurationReport, SectionSize, StemMeasures, WoodMass,
};
pub use model::{Anatomy, AnatomyOptions, RingMethod};
pub use other_rings::{OtherRings, OtherRingsError};
pub use outline::Outline;
pub use painting::{ScaledImage, SectionPictures};
pub use palette::RingColouring;
pub use parameters::{KERNELS, RingMethodChoice, RingParameters, ScheduleChoice};
pub use particles::{Particle, particles_from_field, particles_from_raster};
pub use passes::{PassLegend, PassMeaning, passes_of_rings};
pub use pictured_sections::PicturedSection;
pub use report::{AnatomyFindings, AnatomyReport, ElementsReport, RingRows, SectionReport};
pub use request::{AnatomyOutput, AnatomyRequest, CoordinateChoice};
pub use section_raster::SectionRaster;
pub use section_rings::SectionRingSettings;
pub use sections::{Segment, StemSections, TransverseSection};
pub use sectors::{SectorDivision, SectorLayout};
pub use segment_report::{SegmentReport, SliceMeasures};
pub use solid::ElasticWood;
pub use springs::{Spring, SpringDirection};
pub use stem_rings::BreakRingParameters;
pub use stems::{StemOutcome, stems_table};
pub use surface::SurfaceColouring;
pub use voxels::{NO_TISSUE, VoxelSlice};
