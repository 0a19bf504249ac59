//! Baking the appearance of the inner wood into textures for glTF: colour, normals and roughness.
//!
//! The image has two tiles side by side, in metres. **Left**, u 0 to W: the section (end grain), a square of side W about
//! the section's middle, x = u − W/2, y = v − W/2. **Right**, u from W on: the side grain, with the ring coordinate
//! ρ = ρ₀ + (u − W) / R across, from the least of the section to a little more than that of its outside, and the length along
//! the grain s = 2 v, which repeats in v: fibres are long, so texels may be longer than wide. R is the mean radius of ρ = 1.
//! Because the tile goes by the ring coordinate, a ring lies at the same u at every angle about an uneven section.
//!
//! In each tile the outermost columns beside u = W repeat their neighbour, so that filtering across the seam shows nothing
//! of the other tile.

mod error;
mod images;
mod inside;
mod outside;
mod square;

pub(crate) use error::MIN_WIDTH;
pub use error::TextureError;
pub use images::WoodTextures;
pub use inside::{SectionAddress, SectionPoint, TexturedWood, bake};
pub use outside::{bake_bark, bake_planed};
pub use square::{PlanedFaces, SectionSquare};
