//! What rods do not fill of the meshes that a stem was found in: cut off where the rods end, and carried by the rods that it
//! hangs on, each part rigidly.
//!
//! [`CarriedParts::find`] lists the parts beside a [`crate::rods::RodSkin`], and [`CarriedParts::add_to_film`] adds them to a
//! film of it. Their joints are [`Follower`]s of the rods' joints.

mod attach;
mod carried;
mod follower;
mod plane_cut;
mod sides;
mod split;
mod tangents;

pub use carried::{CarriedPart, CarriedParts, Carrier};
pub use follower::{Follower, pose_followers};
pub use split::StemMesh;
pub(crate) use tangents::add_tangents;
