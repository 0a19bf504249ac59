//! Reading PLY.
//!
//! Texture coordinates have their origin at the bottom, as Blender and MeshLab write them, and are turned over.

use super::header::{Element, Encoding, Kind, Property, parse};
use crate::assemble::{clean_attributes, extract};
use crate::error::{FormatError, InFile};
use crate::polygon::Triangulator;
use crate::text::{number, shown};
use glam::{DAffine3, DVec3};
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{Attribute, Material, Mesh, Node, Scene};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The body, number by number.
pub(super) struct Body<'a> {
    pub bytes: &'a [u8],
    pub encoding: Encoding,
    pub file: InFile<'a>,
}

impl<'a> Body<'a> {
    fn take<const N: usize>(&mut self, place: &Place) -> Result<[u8; N], FormatError> {
        match self.bytes.split_first_chunk::<N>() {
            Some((head, rest)) => {
                self.bytes = rest;
                let mut raw = *head;
                if self.encoding == Encoding::BigEndian {
                    raw.reverse();
                }
                Ok(raw)
            }
            None => Err(self.truncated(place)),
        }
    }

    fn truncated(&self, place: &Place) -> FormatError {
        let element = place.element;
        let found = format!("with {} bytes left in row {}", self.bytes.len(), place.row);
        self.file
            .truncated(&element.name, found, format!("{} rows", element.count))
    }

    fn token(&mut self, place: &Place) -> Result<&'a [u8], FormatError> {
        let rest = self.bytes.trim_ascii_start();
        if rest.is_empty() {
            return Err(self.truncated(place));
        }
        let length = rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(rest.len());
        let (token, rest) = rest.split_at(length);
        self.bytes = rest;
        Ok(token)
    }

    #[inline]
    pub fn scalar(&mut self, kind: Kind, place: &Place) -> Result<f64, FormatError> {
        if self.encoding == Encoding::Text {
            let token = self.token(place)?;
            return number(token).ok_or_else(|| {
                let place = format!("{}, row {}", place.element.name, place.row);
                self.file.malformed(place, shown(token), "a number")
            });
        }
        Ok(match kind {
            Kind::I8 => i8::from_le_bytes(self.take(place)?).into(),
            Kind::U8 => u8::from_le_bytes(self.take(place)?).into(),
            Kind::I16 => i16::from_le_bytes(self.take(place)?).into(),
            Kind::U16 => u16::from_le_bytes(self.take(place)?).into(),
            Kind::I32 => i32::from_le_bytes(self.take(place)?).into(),
            Kind::U32 => u32::from_le_bytes(self.take(place)?).into(),
            Kind::F32 => f32::from_le_bytes(self.take(place)?).into(),
            Kind::F64 => f64::from_le_bytes(self.take(place)?),
        })
    }

    /// The length of a list, refused where the rest of the body cannot hold it.
    fn length(&mut self, list: Kind, kind: Kind, place: &Place) -> Result<usize, FormatError> {
        let length = self.scalar(list, place)?;
        if length < 0.0 || length.fract() != 0.0 {
            let place = format!("{}, row {}", place.element.name, place.row);
            return Err(self.file.malformed(place, length, "the length of a list"));
        }
        let least = if self.encoding == Encoding::Text {
            2
        } else {
            kind.size()
        };
        if length as usize > (self.bytes.len() + 1) / least {
            let element = format!("the list in row {} of {}", place.row, place.element.name);
            self.file
                .check_count(&element, length as usize, least, self.bytes.len() + 1)?;
        }
        Ok(length as usize)
    }

    pub fn skip(&mut self, property: &Property, place: &Place) -> Result<(), FormatError> {
        let count = match property.list {
            Some(list) => self.length(list, property.kind, place)?,
            None => 1,
        };
        for _ in 0..count {
            self.scalar(property.kind, place)?;
        }
        Ok(())
    }
}

/// For messages: where the body is being read.
pub(super) struct Place<'a> {
    pub element: &'a Element,
    pub row: usize,
}

/// What a property of the faces is for.
#[derive(Clone, Copy, PartialEq)]
enum Role {
    Corners,
    Node,
    Material,
    Other,
}

/// Integer columns of the faces.
#[derive(Default)]
struct Faces {
    nodes: Vec<i64>,
    materials: Vec<i64>,
}

/// Reads a PLY file.
pub(crate) fn read(bytes: &[u8], name: &str) -> Result<Scene, FormatError> {
    let file = InFile(name);
    let header = parse(bytes, file)?;
    let mut body = Body {
        bytes: &bytes[header.body..],
        encoding: header.encoding,
        file,
    };
    let mut scene = Scene::default();
    let mut mesh = None;
    let mut faces = Faces::default();
    for element in &header.elements {
        let least = element.least_size(header.encoding);
        if least == 0 {
            continue;
        }
        file.check_count(&element.name, element.count, least, body.bytes.len() + 1)?;
        match (element.name.as_str(), &mut mesh) {
            ("vertex", None) => mesh = Some(read_vertices(&mut body, element, &mut scene.notes)?),
            ("face", Some(mesh)) => {
                faces = read_faces(&mut body, element, mesh, &mut scene.notes)?;
            }
            ("face", None) => {
                let found = "faces before the vertices";
                return Err(file.malformed("header", found, "element vertex first"));
            }
            ("tristrips", _) => {
                return Err(file.unsupported("triangle strips", "save it with single faces"));
            }
            _ => {
                scene.notes.push(format!(
                    "{} entries of {} were dropped.",
                    element.count, element.name
                ));
                for row in 0..element.count {
                    for property in &element.properties {
                        body.skip(property, &Place { element, row })?;
                    }
                }
            }
        }
    }
    let Some(mut mesh) = mesh else {
        return Err(file.malformed("header", "no vertices", "`element vertex` with x, y and z"));
    };
    if mesh.triangles.is_empty() && !mesh.positions.is_empty() {
        return Err(FormatError::PointCloud {
            file: name.to_owned(),
            points: mesh.positions.len(),
        });
    }
    clean_attributes(&mut mesh, &mut scene.notes);
    place(mesh, &faces, &header.comments, &mut scene);
    Ok(scene)
}

/// Attribute, component and divisor of a vertex property that is not a coordinate.
pub(super) fn attribute_of(property: &Property) -> (String, usize, f64) {
    let (name, component) = match property.name.as_str() {
        "nx" => ("NORMAL", 0),
        "ny" => ("NORMAL", 1),
        "nz" => ("NORMAL", 2),
        "s" | "u" | "texture_u" | "texture_s" => ("TEXCOORD_0", 0),
        "t" | "v" | "texture_v" | "texture_t" => ("TEXCOORD_0", 1),
        "red" | "r" | "diffuse_red" => ("COLOR_0", 0),
        "green" | "g" | "diffuse_green" => ("COLOR_0", 1),
        "blue" | "b" | "diffuse_blue" => ("COLOR_0", 2),
        "alpha" | "a" | "diffuse_alpha" => ("COLOR_0", 3),
        other => {
            let bare = other.trim_start_matches('_').to_ascii_uppercase();
            return (format!("_{bare}"), 0, 1.0);
        }
    };
    let divisor = if name == "COLOR_0" {
        property.kind.full()
    } else {
        1.0
    };
    (name.to_owned(), component, divisor)
}

fn read_vertices(
    body: &mut Body,
    element: &Element,
    notes: &mut Vec<String>,
) -> Result<Mesh, FormatError> {
    let file = body.file;
    let axis = |name: &str| {
        let found = element
            .properties
            .iter()
            .position(|p| p.name == name && p.list.is_none());
        found.ok_or_else(|| file.malformed("vertex", format!("no {name}"), "x, y and z"))
    };
    let axes = [axis("x")?, axis("y")?, axis("z")?];
    let mut mesh = Mesh {
        positions: Vec::with_capacity(element.count),
        ..Mesh::default()
    };
    let mut columns: Vec<Vec<f32>> = element
        .properties
        .iter()
        .enumerate()
        .map(|(k, p)| {
            let kept = p.list.is_none() && !axes.contains(&k);
            Vec::with_capacity(if kept { element.count } else { 0 })
        })
        .collect();
    let divisors: Vec<f64> = element
        .properties
        .iter()
        .map(|p| attribute_of(p).2)
        .collect();
    let places: Vec<Option<usize>> = (0..element.properties.len())
        .map(|k| axes.iter().position(|&a| a == k))
        .collect();
    for row in 0..element.count {
        let place = Place { element, row };
        let mut position = DVec3::ZERO;
        for (k, property) in element.properties.iter().enumerate() {
            if property.list.is_some() {
                body.skip(property, &place)?;
                continue;
            }
            let value = body.scalar(property.kind, &place)?;
            match places[k] {
                Some(axis) => position[axis] = value,
                None => columns[k].push((value / divisors[k]) as f32),
            }
        }
        mesh.positions.push(position);
    }
    file.check_finite(|| "vertex".to_owned(), &mesh.positions)?;
    let mut groups: BTreeMap<String, [Option<usize>; 4]> = BTreeMap::new();
    for (k, property) in element.properties.iter().enumerate() {
        if property.list.is_some() {
            notes.push(format!(
                "The list {} of the vertices was dropped.",
                property.name
            ));
        } else if !axes.contains(&k) {
            let (name, component, _) = attribute_of(property);
            groups.entry(name).or_default()[component].get_or_insert(k);
        }
    }
    for (name, components) in groups {
        let width = components
            .iter()
            .rposition(Option::is_some)
            .map_or(0, |k| k + 1);
        let complete = components[..width].iter().all(Option::is_some);
        let right = match name.as_str() {
            "NORMAL" => width == 3,
            "TEXCOORD_0" => width == 2,
            "COLOR_0" => width >= 3,
            _ => true,
        };
        if !complete || !right {
            notes.push(format!("{name} lacks a component and was dropped."));
            continue;
        }
        let parts: Vec<&Vec<f32>> = components.iter().flatten().map(|&k| &columns[k]).collect();
        let mut data = Vec::with_capacity(width * element.count);
        for row in 0..element.count {
            data.extend(parts.iter().map(|column| column[row]));
        }
        if name == "TEXCOORD_0" {
            data.iter_mut()
                .skip(1)
                .step_by(2)
                .for_each(|v| *v = 1.0 - *v);
        }
        mesh.attributes.insert(name, Attribute { width, data });
    }
    Ok(mesh)
}

fn read_faces(
    body: &mut Body,
    element: &Element,
    mesh: &mut Mesh,
    notes: &mut Vec<String>,
) -> Result<Faces, FormatError> {
    let file = body.file;
    let is_corners = |p: &Property| {
        p.list.is_some() && matches!(p.name.as_str(), "vertex_indices" | "vertex_index")
    };
    if element.count > 0 && !element.properties.iter().any(is_corners) {
        let found = "no list vertex_indices";
        return Err(file.malformed("face", found, "`property list uchar int vertex_indices`"));
    }
    for property in element.properties.iter().filter(|p| !is_corners(p)) {
        if !matches!(property.name.as_str(), "node" | "material") || property.list.is_some() {
            notes.push(format!("{} of the faces was dropped.", property.name));
        }
    }
    let mut faces = Faces::default();
    let has = |name: &str| {
        element
            .properties
            .iter()
            .any(|p| p.name == name && p.list.is_none())
    };
    let (has_node, has_material) = (has("node"), has("material"));
    // Comparing names again for each face would take most of the time.
    let role_of = |p: &Property| match p.name.as_str() {
        _ if is_corners(p) => Role::Corners,
        "node" => Role::Node,
        "material" => Role::Material,
        _ => Role::Other,
    };
    let roles: Vec<Role> = element.properties.iter().map(role_of).collect();
    let vertices = mesh.positions.len();
    let mut triangulator = Triangulator::default();
    let (mut corners, mut points) = (Vec::new(), Vec::new());
    let (mut polygons, mut thin) = (0, 0);
    mesh.triangles.reserve(element.count);
    for row in 0..element.count {
        let place = Place { element, row };
        let (mut node, mut material) = (0, 0);
        corners.clear();
        for (property, &role) in element.properties.iter().zip(&roles) {
            match property.list {
                Some(list) if role == Role::Corners => {
                    for _ in 0..body.length(list, property.kind, &place)? {
                        let index = body.scalar(property.kind, &place)?;
                        if !(index >= 0.0 && index < vertices as f64) {
                            return Err(FormatError::IndexOutOfRange {
                                file: file.0.to_owned(),
                                element: "face (vertices counted from 0)".to_owned(),
                                face: row,
                                index: index as i64,
                                count: vertices,
                            });
                        }
                        corners.push(index as u32);
                    }
                }
                None if role == Role::Node => {
                    node = body.scalar(property.kind, &place)? as i64;
                }
                None if role == Role::Material => {
                    material = body.scalar(property.kind, &place)? as i64;
                }
                _ => body.skip(property, &place)?,
            }
        }
        let before = mesh.triangles.len();
        if let [a, b, c] = corners[..] {
            mesh.triangles.push([a, b, c]);
        } else {
            polygons += usize::from(corners.len() > 3);
            thin += usize::from(corners.len() < 3);
            points.clear();
            points.extend(corners.iter().map(|&i| mesh.positions[i as usize]));
            let triangles = triangulator.triangulate(&points);
            mesh.triangles
                .extend(triangles.iter().map(|t| t.map(|k| corners[k as usize])));
        }
        let added = mesh.triangles.len() - before;
        if has_node {
            faces.nodes.extend(std::iter::repeat_n(node, added));
        }
        if has_material {
            faces.materials.extend(std::iter::repeat_n(material, added));
        }
    }
    if polygons > 0 {
        notes.push(format!("{polygons} polygons were triangulated."));
    }
    if thin > 0 {
        notes.push(format!(
            "{thin} faces with fewer than three corners were dropped."
        ));
    }
    Ok(faces)
}

/// Puts the mesh into the scene: split by the faces' `node`, with materials named by the comments that
/// [`super::write`] leaves.
fn place(mut mesh: Mesh, faces: &Faces, comments: &[String], scene: &mut Scene) {
    let name_of = |kind: &str, number: i64| {
        let prefix = format!("greenstick {kind} {number} ");
        comments
            .iter()
            .find_map(|c| c.strip_prefix(&prefix))
            .unwrap_or_default()
            .to_owned()
    };
    let materials: BTreeSet<i64> = faces
        .materials
        .iter()
        .copied()
        .filter(|&m| m >= 0)
        .collect();
    if !materials.is_empty() {
        let numbers: BTreeMap<i64, u32> = materials.iter().copied().zip(0..).collect();
        scene.materials.extend(materials.iter().map(|&m| Material {
            name: name_of("material", m),
            ..Material::default()
        }));
        mesh.materials = faces
            .materials
            .iter()
            .map(|m| numbers.get(m).copied().unwrap_or(NO_MATERIAL))
            .collect();
    }
    let mut parts: BTreeMap<i64, Vec<u32>> = BTreeMap::new();
    for (t, &node) in faces.nodes.iter().enumerate() {
        parts.entry(node).or_default().push(t as u32);
    }
    let node = |name, mesh| Node {
        name,
        transform: DAffine3::IDENTITY,
        mesh: Arc::new(mesh),
        parent: None,
    };
    if parts.len() < 2 {
        let number = parts.keys().next().copied().unwrap_or(0);
        scene.nodes.push(node(name_of("node", number), mesh));
        return;
    }
    let mut slots = vec![u32::MAX; mesh.positions.len()];
    for (number, triangles) in parts {
        let part = extract(&mesh, &triangles, &mut slots);
        scene.nodes.push(node(name_of("node", number), part));
    }
}
