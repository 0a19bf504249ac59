//! The appearance of wood and bark as pure functions of the address: colour, roughness and micro relief, evaluated both at
//! the pixels of pictures and for baked textures. A figure in the wood (a ring, a vessel, a ray) is a body in space, so
//! it runs on from one face of a splinter to the next.
//!
//! Shapes follow Hoadley, *Identifying Wood* (1990): rings with a dark outer edge, vessels and rays as lines or dots
//! according to how they are cut. Colours are those of air-dry wood under daylight. Detail finer than a given footprint is
//! averaged away.

mod bark;
mod bark_kinds;
mod bundles;
mod colours;
mod figures;
mod mix;
mod noises;
mod saw;
mod shading;
mod splits;
mod stem;
mod surface;
mod tints;
mod tissue_blend;
mod tissues;
mod wood;

pub use bark::{BarkAppearance, BarkPoint};
pub use bark_kinds::BarkKind;
pub use colours::{COLOUR, SrgbColour, SrgbColourError, WoodColours};
pub use shading::{OrientedSurface, SurfacePoint, faces_pith, planed, torn, weathered};
pub use stem::{EndSection, StemAppearance};
pub use surface::WoodSurface;
pub use wood::{WoodAppearance, WoodPoint};
