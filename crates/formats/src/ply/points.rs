//! Reading PLY with vertices and no faces: a point cloud.

use super::body::{Body, Row};
use super::header::{Element, Header, Property, parse};
use super::properties::{AttributeComponent, coordinate_properties};
use crate::cloud::CloudFile;
use crate::error::{FormatError, InFile};
use glam::DVec3;

/// The meaning of a vertex property.
#[derive(Clone, Copy)]
enum Role {
    Point(usize),
    Normal(usize),
    Colour { component: usize, scale: f64 },
    Other,
}

/// Reads the points of a file without faces. Returns `None` if there are faces.
pub(crate) fn read_points(bytes: &[u8], name: &str) -> Result<Option<CloudFile>, FormatError> {
    let file = InFile(name);
    let header = parse(bytes, file)?;
    let has_faces = |e: &Element| matches!(e.name.as_str(), "face" | "tristrips") && e.count > 0;
    let vertices = header.elements.iter().find(|e| e.name == "vertex");
    if header.elements.iter().any(has_faces) || vertices.is_none_or(|e| e.count == 0) {
        return Ok(None);
    }
    read_body(bytes, &header, file).map(Some)
}

/// Reads the elements up to the vertices.
fn read_body(bytes: &[u8], header: &Header, file: InFile) -> Result<CloudFile, FormatError> {
    let mut body = Body {
        bytes: &bytes[header.body..],
        encoding: header.encoding,
        file,
    };
    let mut out = CloudFile::default();
    for element in &header.elements {
        let row_size = element.min_row_size(header.encoding);
        if row_size == 0 {
            continue;
        }
        file.check_count(&element.name, element.count, row_size, body.bytes.len() + 1)?;
        if element.name != "vertex" {
            body.skip_element(element)?;
            if element.count > 0 {
                out.notes.push(format!(
                    "{} entries of {} were dropped.",
                    element.count, element.name
                ));
            }
            continue;
        }
        read_vertices(&mut body, element, &mut out)?;
        break;
    }
    Ok(out)
}

/// The meaning of a property other than a coordinate.
fn role(property: &Property) -> Role {
    if property.list.is_some() {
        return Role::Other;
    }
    let AttributeComponent {
        attribute,
        component,
        scale,
    } = AttributeComponent::from_property(property);
    match attribute.as_str() {
        "NORMAL" => Role::Normal(component),
        "COLOR_0" if component < 3 => Role::Colour { component, scale },
        _ => Role::Other,
    }
}

/// Reads the vertices as points.
fn read_vertices(
    body: &mut Body,
    element: &Element,
    out: &mut CloudFile,
) -> Result<(), FormatError> {
    let coordinates = coordinate_properties(element, body.file)?;
    let roles: Vec<Role> = (element.properties.iter().enumerate())
        .map(
            |(k, property)| match coordinates.iter().position(|&c| c == k) {
                Some(axis) => Role::Point(axis),
                None => role(property),
            },
        )
        .collect();
    let has = |is: fn(&Role, usize) -> bool| (0..3).all(|k| roles.iter().any(|r| is(r, k)));
    let has_normals = has(|r, k| matches!(r, Role::Normal(c) if *c == k));
    let has_colours = has(|r, k| matches!(r, Role::Colour { component, .. } if *component == k));
    for (property, role) in element.properties.iter().zip(&roles) {
        if matches!(role, Role::Other) {
            out.notes
                .push(format!("{} of the points was dropped.", property.name));
        }
    }
    for number in 0..element.count {
        let row = Row { element, number };
        let (mut point, mut normal, mut colour) = (DVec3::ZERO, DVec3::ZERO, [0; 3]);
        for (property, role) in element.properties.iter().zip(&roles) {
            if property.list.is_some() {
                body.skip(property, &row)?;
                continue;
            }
            let value = body.number(property.number_type, &row)?;
            match *role {
                Role::Point(k) => point[k] = value,
                Role::Normal(k) => normal[k] = value,
                Role::Colour { component, scale } => {
                    colour[component] = (value / scale * 255.0).round().clamp(0.0, 255.0) as u8;
                }
                Role::Other => {}
            }
        }
        out.cloud.points.push(point);
        if has_normals {
            out.cloud.normals.push(normal.normalize_or_zero());
        }
        if has_colours {
            out.cloud.colours.push(colour);
        }
    }
    Ok(())
}
