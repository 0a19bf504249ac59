//! Films of faces that a run decided: the pieces of the mesh that was simulated, cut along those faces, that move as the
//! rods do.
//!
//! A piece bends as a beam: across it, it follows the mean motion of the rods that are part of it there
//! (`sections`), so that what rods do one by one does not distort it. Until the first rod breaks in a face, both sides follow
//! all rods: the film shows the whole wood. Where it is not broken through, they follow the rods that hold, and stay together
//! there: a hinge. Where pieces reach into each other they keep together sideways, and slide (`section_joints`).
//!
//! | module | content |
//! |---|---|
//! | `sections` | joints along each piece, and the rods that each follows |
//! | `section_joints` | where those joints are in a frame |
//! | `membership` | which piece each part of a rod belongs to |
//! | `rod_faces` | faces as rods meet them |
//! | `strands` | the rods that a piece follows where it is split lengthwise |
//! | `held` | how far whole rods beside a face decide where a piece goes |
//! | `edge_graph` | ways along the edges of a mesh |
//! | `lengths` | which length of the stem every vertex of a piece belongs to |
//! | `whole` | wood before its first break |
//! | `faces` | vertices on both sides of a face, and how far they gape before it opens |

mod edge_graph;
mod faces;
mod held;
mod lengths;
mod make_film;
mod membership;
mod rod_faces;
mod section_joints;
mod sections;
mod strands;
mod whole;

pub use make_film::DrawnScene;
pub(in crate::film) use section_joints::SectionJoints;
