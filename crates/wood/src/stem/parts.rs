//! A model taken apart into its shells.

use super::shells::{Shell, WeldedMesh};
use super::surface::Surface;
use greenstick_geometry::{Cancelled, Context, Mesh};

/// The meshes of a model and their shells.
pub(super) struct Parts {
    /// One for each of the model's meshes.
    pub meshes: Vec<WeldedMesh>,
    pub shells: Vec<Shell>,
    /// Indices of the shells, the largest first.
    pub largest_first: Vec<usize>,
}

impl Parts {
    /// Welds vertices within `tolerance` (m; 0 for equal positions only) and splits meshes into shells.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(meshes: &[Mesh], tolerance: f64, context: &Context) -> Result<Self, Cancelled> {
        let meshes: Vec<WeldedMesh> = meshes
            .iter()
            .map(|mesh| WeldedMesh::new(mesh, tolerance, context))
            .collect::<Result<_, _>>()?;
        let mut shells: Vec<Shell> = Vec::new();
        for (node, mesh) in meshes.iter().enumerate() {
            shells.extend(mesh.shells(node, context)?);
        }
        let mut largest_first: Vec<usize> = (0..shells.len()).collect();
        largest_first.sort_by(|&a, &b| {
            shells[b]
                .diagonal()
                .total_cmp(&shells[a].diagonal())
                .then(a.cmp(&b))
        });
        Ok(Parts {
            meshes,
            shells,
            largest_first,
        })
    }

    /// The surface of a shell.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn surface(&self, shell: usize, context: &Context) -> Result<Surface<'_>, Cancelled> {
        let mesh = &self.meshes[self.shells[shell].node];
        Surface::new(mesh, &self.shells[shell], context)
    }

    /// Number of vertices that welding moved.
    pub fn moved_vertices(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.moved).sum()
    }
}
