//! Files of all formats, sound and damaged.

mod bad_input;
mod clouds;
mod common;
mod film_glb;
mod gltf_budget;
mod mutation;
mod real_files;
mod round_trip;
#[cfg(feature = "usd")]
mod usd;
mod vertex_texture;
mod vtk_lines;
