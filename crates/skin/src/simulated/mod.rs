//! Broken faces that a run decided: where every rod parted, and why, becomes heights over the section and the way in which
//! the wood failed there. The procedural model draws the face in them, in bundles finer than rods, and cuts the mesh that was
//! simulated along it.
//!
//! [`SimulatedFracture::find`] says where a run parted the stem; [`SimulatedFracture::face`] is the face there.

mod drawable;
mod face;
mod fractures;
mod observed;
mod report;
mod section_field;
mod splits;

pub use drawable::{PartlyBroken, WoodHolds};
pub use face::SimulatedFace;
pub use fractures::SimulatedFracture;
pub(crate) use fractures::main_pieces;
pub use observed::ObservedRun;
pub use report::{ModeShare, SimulatedFaceReport};
