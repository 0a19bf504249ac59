//! The film of wood that has not broken: the mesh that was simulated as it is, which bends as the rods do.

use super::lengths::lengths_along;
use super::make_film::DrawnScene;
use crate::film::error::FilmError;
use crate::film::options::FilmOptions;
use crate::film::run::Run;
use crate::film::skinned_film::SkinnedFilm;
use crate::finish::{NodeRole, PieceRole};
use glam::DVec3;
use greenstick_geometry::mesh::{Attribute, NO_MATERIAL};
use greenstick_geometry::{Context, Mesh, Scene};

impl Run {
    /// Returns a film of the mesh that was simulated, whole. It shows every frame before the first break, those included that are
    /// recorded after it was made: only the first frame must be there. Of the options only bodies count. No material is that of the wood
    /// inside.
    ///
    /// # Errors
    /// [`FilmError`] where there is no frame, it cannot be read, or the caller cancelled.
    pub fn film_of_whole(
        &mut self,
        options: &FilmOptions,
        context: &Context,
    ) -> Result<SkinnedFilm, FilmError> {
        let scene = self.whole_scene();
        let role = |node: usize| match node == self.wood.node {
            true => NodeRole::Piece(PieceRole::Lower),
            false => NodeRole::Untouched,
        };
        let roles: Vec<NodeRole> = (0..scene.nodes.len()).map(role).collect();
        let drawn = DrawnScene {
            inner: scene.materials.len() as u32,
            scene: &scene,
            roles: &roles,
            fractures: &[],
            observed: &self.observed(0)?,
        };
        self.film_that_bends(0..1, &drawn, options, context)
    }

    /// The input, whose stem has the coordinates along its grain that pictures need.
    fn whole_scene(&self) -> Scene {
        let mut scene = self.input().clone();
        let listed = scene.materials.len();
        for node in &mut scene.nodes {
            // Built-in stems split their triangles by materials that no scene lists.
            if node.mesh.materials.iter().any(|m| *m as usize >= listed) {
                let materials = node.mesh_mut().materials.iter_mut();
                let unlisted = materials.filter(|m| **m as usize >= listed);
                unlisted.for_each(|m| *m = NO_MATERIAL);
            }
        }
        let node = &mut scene.nodes[self.wood.node];
        let world = node.mesh.transformed(&node.transform);
        let grain = self.grain_of_shell(&world);
        let data = grain.iter().flat_map(|g| g.as_vec3().to_array()).collect();
        let attributes = &mut node.mesh_mut().attributes;
        attributes.insert("_GRAIN".to_owned(), Attribute { width: 3, data });
        scene
    }

    /// The coordinates along the grain (m) of the vertices that bound the stem, 0 of all others; `mesh` is in the stem's world.
    fn grain_of_shell(&self, mesh: &Mesh) -> Vec<DVec3> {
        let stem = self.stem();
        let lengths = lengths_along(mesh, stem);
        let mut grain = vec![DVec3::ZERO; mesh.positions.len()];
        for &triangle in &self.wood.shell {
            for v in mesh.triangles[triangle as usize] {
                let v = v as usize;
                grain[v] = stem.grain.to_grain_near(mesh.positions[v], lengths[v]);
            }
        }
        grain
    }
}
