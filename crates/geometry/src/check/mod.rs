//! Whether a mesh is sound: closed, oriented, manifold, without degenerate, duplicate or crossing triangles.

mod closed_volume;
mod examine;
mod report;
mod text;

pub use report::{CheckOptions, MAX_CONTACTS, Report, SelfIntersections};

use crate::Mesh;

impl Mesh {
    /// Checks everything about the soundness of the mesh. Any mesh can be checked, however broken.
    ///
    /// ```
    /// use glam::DVec3;
    /// use greenstick_geometry::Mesh;
    ///
    /// let tetrahedron = Mesh {
    ///     positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
    ///     triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    ///     ..Mesh::default()
    /// };
    /// let report = tetrahedron.check();
    /// assert!(report.is_solid());
    /// assert_eq!(report.volume_m3, Some(1.0 / 6.0));
    /// ```
    pub fn check(&self) -> Report {
        self.check_with(CheckOptions::default())
    }

    /// Checks the mesh as [`Mesh::check`] does, limited to what `options` selects.
    pub fn check_with(&self, options: CheckOptions) -> Report {
        examine::examine(self, options)
    }
}

#[cfg(test)]
mod tests;
