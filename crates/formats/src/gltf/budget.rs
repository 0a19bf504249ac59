//! How large a document may become in memory. References are short: a few bytes of JSON may stand for all vertices of a file
//! once more. What the meshes would take is therefore summed up before anything is decoded, and held against the data.

use super::accessor::{MAX_ZERO_ELEMENTS, Source};
use super::schema::{Accessor, BufferView, Compressed, Document, Primitive};
use crate::error::{FormatError, InFile};
use std::collections::{BTreeMap, BTreeSet};

/// Bytes decoded of a byte of data. Indices of one byte become a triangle's share of five, positions of two bytes the eight of
/// double precision; the rest is for vertices that several meshes share.
const DECODED_PER_BYTE: usize = 6;
/// What any file may take besides: small ones may well be made of references.
const FREE_SIZE: usize = 64 << 20;
/// Bytes that a packed byte of a meshopt stream counts for at most; its own floor is a sixty-fourth.
const UNPACKED_PER_BYTE: usize = 8;
/// Bytes of memory of the largest object of the schema, and of a number in an unknown list.
const OBJECT_SIZE: usize = 512;
const LIST_ENTRY_SIZE: usize = 24;
/// Bytes of objects and lists of a byte of JSON. Exporters write 50 and more bytes for an object.
const PARSED_PER_BYTE: usize = 12;

/// Refuses JSON that would take many times its own size: `{},{},{}` as a list of nodes takes a hundred times.
pub(super) fn check_json(json: &[u8], file: InFile) -> Result<(), FormatError> {
    let size = |byte: &u8| match byte {
        b'{' => OBJECT_SIZE,
        b',' => LIST_ENTRY_SIZE,
        _ => 0,
    };
    let parsed: usize = json.iter().map(size).sum();
    let most = PARSED_PER_BYTE
        .saturating_mul(json.len())
        .saturating_add(FREE_SIZE);
    if parsed <= most {
        return Ok(());
    }
    let objects = json.iter().filter(|b| **b == b'{').count();
    let found = format!(
        "{objects} objects in {} bytes, {parsed} bytes of memory",
        json.len()
    );
    Err(file.malformed("JSON", found, format!("{most} bytes of memory at most")))
}

/// Refuses documents whose meshes would take too much memory for the data that they are read from.
pub(super) fn check(source: &Source, file_size: usize) -> Result<(), FormatError> {
    let document = source.document;
    let data = data_size(document, file_size);
    let most = DECODED_PER_BYTE
        .saturating_mul(data)
        .saturating_add(FREE_SIZE);
    let used: BTreeSet<usize> = document.nodes.iter().filter_map(|n| n.mesh).collect();
    let (mut total, mut largest) = (0_usize, (0, 0));
    for index in used {
        let Some(mesh) = document.meshes.get(index) else {
            continue;
        };
        let size = mesh_size(document, &mesh.primitives);
        total = total.saturating_add(size);
        if size > largest.0 {
            largest = (size, index);
        }
    }
    if total <= most {
        return Ok(());
    }
    let found = format!(
        "all meshes would take {total} bytes once decoded, this one {}, from {data} bytes of data",
        largest.0
    );
    let place = format!("meshes[{}]", largest.1);
    Err(source
        .file
        .malformed(place, found, format!("{most} bytes at most")))
}

/// Bytes of data: the file, the buffers beside it, each file once, and what its compressed parts reasonably hold.
fn data_size(document: &Document, file_size: usize) -> usize {
    let beside = document.buffers.iter().filter_map(|buffer| {
        let uri = buffer.uri.as_deref().filter(|u| !u.starts_with("data:"))?;
        Some((uri, buffer.byte_length))
    });
    // Buffers shorter than they claim are refused when they are read, before anything of them is decoded.
    let beside: BTreeMap<&str, usize> = beside.collect();
    let unpacked = document.buffer_views.iter().filter_map(|view| {
        let packed = packed(view)?;
        let most = packed.byte_length.min(file_size.max(longest(document)));
        let most = UNPACKED_PER_BYTE.saturating_mul(most);
        Some(packed.count.saturating_mul(packed.byte_stride).min(most))
    });
    beside
        .into_values()
        .chain(unpacked)
        .fold(file_size, usize::saturating_add)
}

/// Bytes of the longest buffer.
fn longest(document: &Document) -> usize {
    let lengths = document.buffers.iter().map(|b| b.byte_length);
    lengths.max().unwrap_or(0)
}

/// Bytes of a mesh of these primitives, as `primitive::read_mesh` joins them.
fn mesh_size(document: &Document, primitives: &[Primitive]) -> usize {
    let accessor = |i: &usize| document.accessors.get(*i);
    let mut read: BTreeSet<&BTreeMap<String, usize>> = BTreeSet::new();
    let mut widths: BTreeMap<&str, usize> = BTreeMap::new();
    let (mut vertices, mut triangles) = (0_usize, 0_usize);
    for primitive in primitives {
        let mode = primitive.mode.unwrap_or(4);
        let Some(positions) = primitive.attributes.get("POSITION").and_then(accessor) else {
            continue;
        };
        if mode < 4 {
            continue;
        }
        if read.insert(&primitive.attributes) {
            vertices = vertices.saturating_add(possible(document, positions));
            for (name, i) in &primitive.attributes {
                let dropped = ["POSITION", "JOINTS_", "WEIGHTS_"];
                if dropped.iter().any(|d| name.starts_with(d)) {
                    continue;
                }
                let width = widths.entry(name).or_default();
                *width = (*width).max(accessor(i).map_or(0, components));
            }
        }
        let indices = primitive.indices.as_ref().and_then(accessor);
        let corners = possible(document, indices.unwrap_or(positions));
        let added = if mode == 4 { corners / 3 } else { corners };
        triangles = triangles.saturating_add(added);
    }
    let width: usize = widths.values().sum();
    let vertex = size_of::<glam::DVec3>() + size_of::<f32>() * width;
    let triangle = size_of::<[u32; 3]>() + size_of::<u32>();
    vertices
        .saturating_mul(vertex)
        .saturating_add(triangles.saturating_mul(triangle))
}

/// The number of elements of an accessor, as far as it can be true. Larger ones are refused when they are read.
fn possible(document: &Document, accessor: &Accessor) -> usize {
    let view = accessor.buffer_view.map(|v| document.buffer_views.get(v));
    let most = match view {
        None => MAX_ZERO_ELEMENTS,
        Some(None) => 0,
        Some(Some(view)) => {
            packed(view).map_or(view.byte_length, |p| p.count.saturating_mul(p.byte_stride))
        }
    };
    accessor.count.min(most)
}

/// What the meshopt extension says of a buffer view.
fn packed(view: &BufferView) -> Option<Compressed> {
    let extension = ["EXT_meshopt_compression", "KHR_meshopt_compression"]
        .into_iter()
        .find_map(|name| view.extensions.get(name))?;
    serde_json::from_value(extension.clone()).ok()
}

/// Components of an element.
fn components(accessor: &Accessor) -> usize {
    match accessor.shape.as_str() {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "MAT3" => 9,
        "MAT4" => 16,
        _ => 4,
    }
}
