//! Collision shapes of a film's pieces: convex shapes at rest, named so that engines find them by name.

use glam::DAffine3;
use greenstick_geometry::{
    Cancelled, Context, ConvexOptions, ConvexParts, Film, Node, Scene, SkinnedMesh, convex_parts,
};
use rayon::prelude::*;
use serde::Serialize;

/// The collision shapes of one piece.
#[derive(Debug, Clone, Serialize, PartialEq)]
pub struct CollisionPiece {
    /// Its name.
    pub name: String,
    /// Number of convex shapes.
    pub shapes: usize,
    /// Most vertices of a shape.
    pub vertices: usize,
    /// Largest distance of one of the piece's vertices from the nearest shape, m; 0 where all lie in one.
    pub uncovered_m: f64,
    /// Sum of the shapes' volumes over the piece's.
    pub volume_ratio: f64,
}

/// Collision shapes of all pieces.
#[derive(Debug, Clone, PartialEq)]
pub struct Collision {
    /// A node for each shape, `UCX_`, the piece's name and the shape's number in two digits or more: the names by which
    /// Unreal takes a shape for that of the mesh. Without materials.
    pub scene: Scene,
    /// The pieces, in the film's order.
    pub pieces: Vec<CollisionPiece>,
}

/// Makes convex shapes of the pieces of a film at rest.
///
/// # Errors
/// [`Cancelled`].
pub fn collision(
    film: &Film,
    options: &ConvexOptions,
    context: &Context,
) -> Result<Collision, Cancelled> {
    context.report(0.0)?;
    let solids: Vec<&SkinnedMesh> = film.pieces.iter().filter(|p| !p.is_detail).collect();
    let made: Vec<ConvexParts> = (solids.par_iter())
        .map(|piece| convex_parts(&piece.mesh, options, &context.silenced()))
        .collect::<Result<_, _>>()?;
    let mut scene = Scene::default();
    let mut pieces = Vec::with_capacity(made.len());
    for (piece, parts) in solids.into_iter().zip(made) {
        let corners = parts.shapes.iter().map(|s| s.positions.len());
        pieces.push(CollisionPiece {
            name: piece.name.clone(),
            shapes: parts.shapes.len(),
            vertices: corners.max().unwrap_or(0),
            uncovered_m: parts.uncovered,
            volume_ratio: parts.volume_ratio,
        });
        let shapes = parts.shapes.into_iter().enumerate();
        scene.nodes.extend(shapes.map(|(number, mesh)| Node {
            name: format!("UCX_{}_{number:02}", piece.name),
            transform: DAffine3::IDENTITY,
            mesh: mesh.into(),
            parent: None,
            is_detail: false,
        }));
    }
    Ok(Collision { scene, pieces })
}
