//! The skin of a bundle of rods: closed meshes that follow the rods, split where they broke (Sutherland 2012 §5).
//!
//! The wood is split into **prisms**: columns in the section (the rods' Voronoi cells, each of several fibre bundles)
//! times slabs along the grain. Two prisms that meet are joined where a bond holds their rods together, or where they
//! belong to one rod that is whole there. The skin is every face between prisms that are not joined. So it is closed
//! and oriented whatever breaks, faces inside whole wood are not made at all, and the two sides of a break are the same
//! faces. Pieces are what bonds hold together: the connected components of the bond graph.
//!
//! A vertex follows the rods of all prisms that are joined around it, each at the vertex's place along it: the thesis's
//! associations (vertex–edge with λ, vertex–vertex where λ is 0), of which the mean is what its averaging iterations
//! tend to. It is linear in the rods' frames, so the skin is linear blend skinning with one joint for each vertex of a
//! rod. An association goes with its bond, as the prisms then are no longer joined.

mod bark;
mod broken_end;
mod closed_cracks;
mod columns;
mod crack_gap;
mod error;
mod fracture_state;
mod history;
mod hull;
mod joints;
mod manifold;
mod materials;
mod open_faces;
mod options;
mod piece_mesh;
mod prisms;
mod skin;
mod weight_history;
mod wood;

pub use closed_cracks::{ClosedCracks, CrackOpening};
pub use columns::{BondedRods, Column, Columns, columns};
pub use error::RodSkinError;
pub use fracture_state::{FractureState, Pieces, RodBreak, RodPart};
pub use history::BreakHistory;
pub use joints::{Joints, frame_poses};
pub use manifold::NonmanifoldSplits;
pub use materials::Materials;
pub use options::{Outline, RodSkinOptions};
pub use skin::{RodSkin, rod_skin, rod_skin_over_time};
pub use wood::Wood;
