//! Repair of meshes as they come, before they are cut.

use super::{close_seams, separate_sheets};
use crate::{Cancelled, Context, Mesh, Scene};

/// Closes the seams of all meshes of a scene ([`close_seams`]), and separates sheets that meet at edges of more than two triangles
/// ([`separate_sheets`]). Returns a note on each mesh that was changed.
///
/// # Errors
/// [`Cancelled`].
pub fn repair_scene(scene: &mut Scene, context: &Context) -> Result<Vec<String>, Cancelled> {
    let mut notes = Vec::new();
    for node in &mut scene.nodes {
        let mut mesh = Mesh::clone(&node.mesh);
        let seams = close_seams(&mut mesh, context)?;
        if seams.moved > 0 {
            let within = seams.tolerance * node.transform.matrix3.determinant().abs().cbrt();
            notes.push(format!(
                "sides of seams of \"{}\" lay apart: {} vertices were moved onto others within {within:.1e} m",
                node.name, seams.moved
            ));
        }
        let separated = if seams.is_crowded || seams.moved > 0 {
            separate_sheets(&mut mesh, context)?
        } else {
            0
        };
        if separated > 0 {
            let edges = if separated == 1 { "edge" } else { "edges" };
            notes.push(format!(
                "more than two triangles of \"{}\" shared {separated} {edges}: the sheets that met there were separated",
                node.name
            ));
        }
        if seams.moved + separated > 0 {
            node.mesh = mesh.into();
        }
    }
    Ok(notes)
}
