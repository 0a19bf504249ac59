//! Positions as they are written to files.

use crate::error::{FormatError, InFile};
use crate::unit::LengthUnit;
use glam::{DAffine3, DVec3};
use greenstick_geometry::{Mesh, Node};
use std::borrow::Cow;

/// Returns the mesh of a node in world coordinates, in `unit`.
pub(crate) fn in_world(node: &Node, unit: LengthUnit) -> Cow<'_, Mesh> {
    let map = DAffine3::from_scale(DVec3::splat(unit.per_metre())) * node.transform;
    // A file in millimetres that is written in millimetres keeps its numbers: 0.001 · 1000 may differ from 1 by an ulp.
    if map.abs_diff_eq(DAffine3::IDENTITY, 1e-14) {
        Cow::Borrowed(&node.mesh)
    } else {
        Cow::Owned(node.mesh.transformed(&map))
    }
}

/// Converts a position to single precision.
pub(crate) fn to_f32(p: DVec3, file: InFile) -> Result<[f32; 3], FormatError> {
    let q = p.as_vec3();
    if q.is_finite() {
        return Ok(q.to_array());
    }
    Err(file.unwritable(
        format!("a vertex lies at {p}"),
        "coordinates within the range of 32-bit floating-point numbers",
    ))
}
