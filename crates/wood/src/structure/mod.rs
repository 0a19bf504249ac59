//! Structure sets strength: density, stiffness and strength of the wood at every place of a section, relative to the means
//! that a species' table has.
//!
//! | module | content |
//! |---|---|
//! | `density` | [`RingDensity`]: earlywood and latewood, by ring character and ring width |
//! | `juvenile` | [`JuvenileWood`]: the wood of the first years |
//! | `bark` | [`BarkTissue`]: phloem and outer bark, which are no wood |
//! | `grain` | [`GrainAngles`]: spiral, wavy and interlocked grain; [`hankinson`]'s formula |
//! | `local` | [`WoodStructure`]: all of it at a place |
//!
//! Tables have the mean of clear wood, so that everything here is relative. Whoever fills a section scales the wood in it
//! to the table's means. Numbers in the modules are rounded; measured ones scatter by a tenth to a quarter from tree to tree.

mod bark;
mod density;
mod grain;
mod juvenile;
mod local;

pub use bark::BarkTissue;
pub use density::RingDensity;
pub use grain::{
    BENDING_EXPONENTS, COMPRESSION_EXPONENT, GrainAngles, MODULUS_EXPONENT, TENSION_EXPONENT,
    hankinson,
};
pub use juvenile::JuvenileWood;
pub use local::{LocalWood, TissueBoundaries, WoodStructure};
