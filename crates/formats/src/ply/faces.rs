//! The faces of a PLY mesh.

use super::body::{Body, Row};
use super::header::{Element, Property};
use crate::error::{FormatError, InFile};
use crate::polygon::{FaceStatistics, Triangulator};
use greenstick_geometry::Mesh;

/// Integer properties of the faces, by triangle; empty if there is no such property.
#[derive(Default)]
pub(super) struct FaceColumns {
    pub nodes: Vec<i64>,
    pub materials: Vec<i64>,
}

/// The meaning of a property of the faces.
#[derive(Clone, Copy, PartialEq)]
enum Role {
    Corners,
    Node,
    Material,
    Other,
}

impl Role {
    fn from_property(property: &Property) -> Self {
        match (property.name.as_str(), property.list) {
            ("vertex_indices" | "vertex_index", Some(_)) => Role::Corners,
            ("node", None) => Role::Node,
            ("material", None) => Role::Material,
            _ => Role::Other,
        }
    }
}

/// Reads the faces and adds their triangles to the mesh.
pub(super) fn read_faces(
    body: &mut Body,
    element: &Element,
    mesh: &mut Mesh,
    notes: &mut Vec<String>,
) -> Result<FaceColumns, FormatError> {
    // Comparing names again for each face would take most of the time.
    let roles: Vec<Role> = element.properties.iter().map(Role::from_property).collect();
    check_properties(element, &roles, notes, body.file)?;
    let has = |role| roles.contains(&role);
    let (has_node, has_material) = (has(Role::Node), has(Role::Material));
    let mut columns = FaceColumns::default();
    let mut triangulator = Triangulator::default();
    let mut face = Face::default();
    let mut points = Vec::new();
    let mut statistics = FaceStatistics::default();
    mesh.triangles.reserve(element.count);
    for number in 0..element.count {
        let row = Row { element, number };
        face.read(body, &roles, &row, mesh.positions.len())?;
        let before = mesh.triangles.len();
        if let [a, b, c] = face.corners[..] {
            mesh.triangles.push([a, b, c]);
        } else {
            statistics.count(face.corners.len());
            points.clear();
            points.extend(face.corners.iter().map(|&i| mesh.positions[i as usize]));
            let triangles = triangulator.triangulate(&points);
            mesh.triangles.extend(
                triangles
                    .iter()
                    .map(|t| t.map(|k| face.corners[k as usize])),
            );
        }
        let added = mesh.triangles.len() - before;
        if has_node {
            columns.nodes.extend(std::iter::repeat_n(face.node, added));
        }
        if has_material {
            columns
                .materials
                .extend(std::iter::repeat_n(face.material, added));
        }
    }
    statistics.add_notes(notes);
    Ok(columns)
}

/// Refuses faces without corners, and notes the properties that are dropped.
fn check_properties(
    element: &Element,
    roles: &[Role],
    notes: &mut Vec<String>,
    file: InFile,
) -> Result<(), FormatError> {
    if element.count > 0 && !roles.contains(&Role::Corners) {
        let found = "no list vertex_indices";
        return Err(file.malformed("face", found, "`property list uchar int vertex_indices`"));
    }
    for (property, _) in (element.properties.iter().zip(roles)).filter(|(_, r)| **r == Role::Other)
    {
        notes.push(format!("{} of the faces was dropped.", property.name));
    }
    Ok(())
}

/// One face.
#[derive(Default)]
struct Face {
    corners: Vec<u32>,
    node: i64,
    material: i64,
}

impl Face {
    /// Reads the face, for a mesh with `vertices` vertices.
    fn read(
        &mut self,
        body: &mut Body,
        roles: &[Role],
        row: &Row,
        vertices: usize,
    ) -> Result<(), FormatError> {
        self.corners.clear();
        (self.node, self.material) = (0, 0);
        for (property, role) in row.element.properties.iter().zip(roles) {
            match (role, property.list) {
                (Role::Corners, Some(list)) => {
                    for _ in 0..body.list_length(list, property.number_type, row)? {
                        let index = body.number(property.number_type, row)?;
                        if !(index >= 0.0 && index < vertices as f64) {
                            return Err(FormatError::IndexOutOfRange {
                                file: body.file.0.to_owned(),
                                element: "face (vertices counted from 0)".to_owned(),
                                face: row.number,
                                index: index as i64,
                                count: vertices,
                            });
                        }
                        self.corners.push(index as u32);
                    }
                }
                (Role::Node, _) => self.node = body.number(property.number_type, row)? as i64,
                (Role::Material, _) => {
                    self.material = body.number(property.number_type, row)? as i64;
                }
                _ => body.skip(property, row)?,
            }
        }
        Ok(())
    }
}
