//! The inside of a stem as data: voxels, rings and particles (Xu et al., *Forests* 2023, §3).
//!
//! A stem that was found in a mesh is cut into sections square to its centreline ([`Anatomy::section`]); each becomes
//! a bitmap and a number of passes for every pixel, and so many particles. Sections do not depend on each other, so a
//! caller may make them on as many threads as there are, and need not hold more of them than it wants.

mod fill;
mod outline;
mod particles;
mod rings;
mod sections;
mod surface;

pub use fill::{Grid, fill};
pub use outline::{Outline, Slicer};
pub use particles::{Bundles, Layout, Particle, field_particles, pixel_particles};
pub use rings::{LATEWOOD, RingNumbers, field_passes};
pub use sections::{Anatomy, AnatomyError, AnatomyOptions, RESOLUTIONS, Section, Segment};
pub use surface::{SurfaceColours, rebuilt_surface};
