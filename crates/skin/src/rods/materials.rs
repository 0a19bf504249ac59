//! The materials of a skin.

use crate::texture::SectionSquare;

/// The materials of a skin's faces.
#[derive(Clone, Copy)]
pub struct Materials<'a> {
    /// Material of the wood inside.
    pub inner: u32,
    /// Material of bark that has none of its own.
    pub bark: u32,
    /// Number that is added to the material numbers of the bark's mesh.
    pub bark_mesh_offset: u32,
    /// The square of the section that the wood's texture covers.
    pub square: SectionSquare,
    /// Code of the tissue zone at a ring coordinate.
    pub zone: &'a dyn Fn(f64) -> u8,
}
