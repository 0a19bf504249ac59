//! The vertices of a PLY mesh.

use super::body::{Body, Row};
use super::header::Element;
use super::properties::{AttributeComponent, coordinate_properties};
use crate::error::FormatError;
use glam::DVec3;
use greenstick_geometry::{Attribute, Mesh};
use std::collections::BTreeMap;

/// Reads the vertices as a mesh without triangles.
pub(super) fn read_vertices(
    body: &mut Body,
    element: &Element,
    notes: &mut Vec<String>,
) -> Result<Mesh, FormatError> {
    let coordinates = coordinate_properties(element, body.file)?;
    let mut mesh = Mesh {
        positions: Vec::with_capacity(element.count),
        ..Mesh::default()
    };
    let mut columns = columns(element, coordinates);
    for number in 0..element.count {
        let row = Row { element, number };
        let mut position = DVec3::ZERO;
        for (property, column) in element.properties.iter().zip(&mut columns) {
            if property.list.is_some() {
                body.skip(property, &row)?;
                continue;
            }
            let value = body.number(property.number_type, &row)?;
            match column.axis {
                Some(axis) => position[axis] = value,
                None => column.values.push((value / column.meaning.scale) as f32),
            }
        }
        mesh.positions.push(position);
    }
    body.file
        .check_finite(|| "vertex".to_owned(), &mesh.positions)?;
    mesh.attributes = attributes(element, &columns, notes);
    Ok(mesh)
}

/// The values of a vertex property.
struct Column {
    meaning: AttributeComponent,
    /// The axis of a coordinate.
    axis: Option<usize>,
    values: Vec<f32>,
}

/// A column without values for each property.
fn columns(element: &Element, coordinates: [usize; 3]) -> Vec<Column> {
    element
        .properties
        .iter()
        .enumerate()
        .map(|(k, property)| {
            let axis = coordinates.iter().position(|&c| c == k);
            let has_values = property.list.is_none() && axis.is_none();
            Column {
                meaning: AttributeComponent::from_property(property),
                axis,
                values: Vec::with_capacity(if has_values { element.count } else { 0 }),
            }
        })
        .collect()
}

/// Joins columns to attributes.
fn attributes(
    element: &Element,
    columns: &[Column],
    notes: &mut Vec<String>,
) -> BTreeMap<String, Attribute> {
    let mut groups: BTreeMap<&str, [Option<usize>; 4]> = BTreeMap::new();
    for (k, (property, column)) in element.properties.iter().zip(columns).enumerate() {
        if property.list.is_some() {
            notes.push(format!(
                "The list {} of the vertices was dropped.",
                property.name
            ));
        } else if column.axis.is_none() {
            let AttributeComponent {
                attribute,
                component,
                ..
            } = &column.meaning;
            groups.entry(attribute).or_default()[*component].get_or_insert(k);
        }
    }
    let mut attributes = BTreeMap::new();
    for (name, components) in groups {
        let width = components
            .iter()
            .rposition(Option::is_some)
            .map_or(0, |k| k + 1);
        let is_complete = components[..width].iter().all(Option::is_some);
        let is_valid = match name {
            "NORMAL" => width == 3,
            "TEXCOORD_0" => width == 2,
            "COLOR_0" => width >= 3,
            _ => true,
        };
        if !is_complete || !is_valid {
            notes.push(format!("{name} lacks a component and was dropped."));
            continue;
        }
        let parts: Vec<&Vec<f32>> = components
            .iter()
            .flatten()
            .map(|&k| &columns[k].values)
            .collect();
        let mut data = Vec::with_capacity(width * element.count);
        for row in 0..element.count {
            data.extend(parts.iter().map(|column| column[row]));
        }
        if name == "TEXCOORD_0" {
            let v = data.iter_mut().skip(1).step_by(2);
            v.for_each(|v| *v = 1.0 - *v);
        }
        attributes.insert(name.to_owned(), Attribute { width, data });
    }
    attributes
}
