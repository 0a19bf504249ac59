//! PLY with vertices and no faces: a point cloud.

use super::header::{Header, parse};
use super::read::{Body, Place, attribute_of};
use crate::cloud::CloudFile;
use crate::error::{FormatError, InFile};
use glam::DVec3;

/// What a column of the vertices is for.
#[derive(Clone, Copy)]
enum Role {
    Point(usize),
    Normal(usize),
    Colour(usize, f64),
    Other,
}

/// The points of a file without faces; `None` where there are faces.
pub(crate) fn read_points(bytes: &[u8], name: &str) -> Result<Option<CloudFile>, FormatError> {
    let file = InFile(name);
    let header = parse(bytes, file)?;
    let has_faces =
        |e: &super::header::Element| matches!(e.name.as_str(), "face" | "tristrips") && e.count > 0;
    let vertices = header.elements.iter().find(|e| e.name == "vertex");
    if header.elements.iter().any(has_faces) || vertices.is_none_or(|e| e.count == 0) {
        return Ok(None);
    }
    read_body(bytes, &header, file).map(Some)
}

fn read_body(bytes: &[u8], header: &Header, file: InFile) -> Result<CloudFile, FormatError> {
    let mut body = Body {
        bytes: &bytes[header.body..],
        encoding: header.encoding,
        file,
    };
    let mut out = CloudFile::default();
    for element in &header.elements {
        let least = element.least_size(header.encoding);
        if least == 0 {
            continue;
        }
        file.check_count(&element.name, element.count, least, body.bytes.len() + 1)?;
        if element.name != "vertex" {
            for row in 0..element.count {
                for property in &element.properties {
                    body.skip(property, &Place { element, row })?;
                }
            }
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

fn read_vertices(
    body: &mut Body,
    element: &super::header::Element,
    out: &mut CloudFile,
) -> Result<(), FormatError> {
    let role = |p: &super::header::Property| {
        if p.list.is_some() {
            return Role::Other;
        }
        if let Some(axis) = ["x", "y", "z"].iter().position(|n| *n == p.name) {
            return Role::Point(axis);
        }
        match attribute_of(p) {
            (name, k, _) if name == "NORMAL" => Role::Normal(k),
            (name, k, full) if name == "COLOR_0" && k < 3 => Role::Colour(k, full),
            _ => Role::Other,
        }
    };
    let roles: Vec<Role> = element.properties.iter().map(role).collect();
    let has =
        |test: fn(Role) -> Option<usize>| (0..3).all(|k| roles.iter().any(|r| test(*r) == Some(k)));
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let there = |r: &Role| matches!(r, Role::Point(k) if *k == axis);
        if !roles.iter().any(there) {
            return Err(body
                .file
                .malformed("vertex", format!("no {name}"), "x, y and z"));
        }
    }
    let normals = has(|r| match r {
        Role::Normal(k) => Some(k),
        _ => None,
    });
    let colours = has(|r| match r {
        Role::Colour(k, _) => Some(k),
        _ => None,
    });
    for (property, role) in element.properties.iter().zip(&roles) {
        if matches!(role, Role::Other) {
            out.notes
                .push(format!("{} of the points was dropped.", property.name));
        }
    }
    for row in 0..element.count {
        let place = Place { element, row };
        let (mut point, mut normal, mut colour) = (DVec3::ZERO, DVec3::ZERO, [0; 3]);
        for (property, role) in element.properties.iter().zip(&roles) {
            if property.list.is_some() {
                body.skip(property, &place)?;
                continue;
            }
            let value = body.scalar(property.kind, &place)?;
            match *role {
                Role::Point(k) => point[k] = value,
                Role::Normal(k) => normal[k] = value,
                Role::Colour(k, full) => {
                    colour[k] = (value / full * 255.0).round().clamp(0.0, 255.0) as u8;
                }
                Role::Other => {}
            }
        }
        out.cloud.points.push(point);
        if normals {
            out.cloud.normals.push(normal.normalize_or_zero());
        }
        if colours {
            out.cloud.colours.push(colour);
        }
    }
    Ok(())
}
