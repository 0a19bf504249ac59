//! Validation of films before they are written.

use crate::check::{Surfaces, check_mesh, check_transform};
use crate::error::{FormatError, InFile};
use greenstick_geometry::Film;

/// Refuses invalid films, so that writers can index freely.
pub(super) fn check(film: &Film, file: InFile) -> Result<(), FormatError> {
    if let Some(fault) = film.fault() {
        return Err(file.unwritable(fault, "a valid film"));
    }
    for (p, piece) in film.pieces.iter().enumerate() {
        check_mesh(&piece.mesh, &|| format!("piece {p} ({})", piece.name), file)?;
    }
    let bodies = film.bodies.iter().map(|body| &body.node);
    for (b, node) in bodies.chain(&film.fixed).enumerate() {
        let place = || format!("body {b} ({})", node.name);
        check_mesh(&node.mesh, &place, file)?;
        check_transform(node, &place, file)?;
    }
    let bodies = film.bodies.iter().map(|body| &body.node);
    let nodes = bodies.chain(&film.fixed).map(|n| &*n.mesh);
    let meshes = nodes.chain(film.pieces.iter().map(|p| &p.mesh));
    Surfaces::from_film(film).check(meshes.clone(), file)?;
    if meshes.into_iter().all(|m| m.triangles.is_empty()) {
        return Err(file.unwritable("the film has no triangles", "at least one triangle"));
    }
    Ok(())
}
