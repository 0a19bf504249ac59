//! Options of stills and films.

use crate::rods::RodSkinOptions;

/// How a skin is made.
#[derive(Debug, Clone, PartialEq)]
pub struct FilmOptions {
    /// The skin.
    pub skin: RodSkinOptions,
    /// Width of the baked textures, pixels (even); 0 for none.
    pub texture_width: u32,
    /// Whether the bodies that act on the wood are shown.
    pub bodies: bool,
    /// Whether the rest of the input is carried along: what lies beyond the rods' ends and what hangs on them.
    pub rest: bool,
}
