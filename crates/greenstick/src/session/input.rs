//! The input of a session.

use greenstick_geometry::Scene;
use greenstick_skin::prepared::volume_scale;

/// The scene that is broken, and what reports say of it.
#[derive(Debug)]
pub(super) struct Input {
    pub scene: Scene,
    pub triangles: usize,
    pub area_m2: f64,
}

impl Input {
    /// Measures a scene.
    pub fn new(scene: Scene) -> Self {
        let triangles = scene.nodes.iter().map(|n| n.mesh.triangles.len()).sum();
        let area_m2 = scene
            .nodes
            .iter()
            .map(|n| n.mesh.area() * volume_scale(n).cbrt().powi(2))
            .sum();
        Input {
            scene,
            triangles,
            area_m2,
        }
    }
}
