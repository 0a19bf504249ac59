//! The items of a scene.

use crate::shader::Shader;
use glam::DAffine3;
use greenstick_geometry::Mesh;

/// A mesh in the scene with its appearance.
#[derive(Clone, Copy)]
pub struct Item<'a> {
    /// The mesh in local coordinates.
    pub mesh: &'a Mesh,
    /// Local coordinates to world coordinates, m.
    pub transform: DAffine3,
    /// Provides the appearance of the surface.
    pub shader: &'a (dyn Shader + Sync),
}
