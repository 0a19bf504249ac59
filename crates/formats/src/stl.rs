//! STL as text and binary: triangles without connectivity. Corners at bitwise equal positions become one vertex.

use crate::companions::Encoded;
use crate::error::{FormatError, InFile};
use crate::position::{in_world, to_f32};
use crate::text::{lines, number, quote, tokens};
use crate::unit::LengthUnit;
use glam::{DAffine3, DVec3};
use greenstick_geometry::{Mesh, Node, Scene};
use std::collections::HashMap;
use std::sync::Arc;

/// Size of the binary header with the number of facets.
const HEADER_SIZE: usize = 84;
/// Size of a binary facet.
const FACET_SIZE: usize = 50;

/// The number of facets in a binary header.
fn facet_count(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..HEADER_SIZE)?;
    Some(u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize)
}

/// Whether the length matches the number of facets in the header exactly.
pub(crate) fn is_binary(bytes: &[u8]) -> bool {
    facet_count(bytes)
        .is_some_and(|n| n.checked_mul(FACET_SIZE) == bytes.len().checked_sub(HEADER_SIZE))
}

/// Whether this is STL text. Binary files may start with `solid`, too, so that a further keyword is required.
pub(crate) fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    let head = start[..start.len().min(1000)].to_ascii_lowercase();
    if !head.starts_with(b"solid") || head.contains(&0) || is_binary(bytes) {
        return false;
    }
    let has = |word: &[u8]| head.windows(word.len()).any(|w| w == word);
    has(b"facet") || has(b"endsolid")
}

/// Merges equal corners.
#[derive(Default)]
struct Welder {
    mesh: Mesh,
    numbers: HashMap<[u32; 3], u32>,
}

impl Welder {
    /// Returns the vertex at a position.
    fn vertex(&mut self, p: [f32; 3]) -> u32 {
        // Adding zero turns −0 into 0, so that both are one point.
        let key = p.map(|v| (v + 0.0).to_bits());
        let next = self.mesh.positions.len() as u32;
        *self.numbers.entry(key).or_insert_with(|| {
            self.mesh
                .positions
                .push(DVec3::from_array(p.map(f64::from)));
            next
        })
    }
}

/// Reads an STL file.
pub(crate) fn read(bytes: &[u8], name: &str) -> Result<Scene, FormatError> {
    if is_text(bytes) {
        read_text(bytes, name)
    } else {
        read_binary(bytes, name)
    }
}

/// Reads binary STL.
fn read_binary(bytes: &[u8], name: &str) -> Result<Scene, FormatError> {
    let file = InFile(name);
    let Some(count) = facet_count(bytes) else {
        return Err(FormatError::NotThisFormat {
            file: name.to_owned(),
            format: "STL",
            found: format!("{} bytes beginning with {}", bytes.len(), quote(bytes)),
            right: "`solid` and facets, or a binary header of 84 bytes".to_owned(),
        });
    };
    let body = &bytes[HEADER_SIZE..];
    file.check_count("facets", count, FACET_SIZE, body.len())?;
    let mut scene = Scene::default();
    let extra = body.len() - count * FACET_SIZE;
    if extra > 0 {
        scene
            .notes
            .push(format!("{extra} bytes after the last facet were ignored."));
    }
    let mut welder = Welder::default();
    welder.mesh.triangles.reserve(count);
    welder.numbers.reserve(count / 2);
    for (face, facet) in body.chunks_exact(FACET_SIZE).take(count).enumerate() {
        let mut triangle = [0; 3];
        for (k, slot) in triangle.iter_mut().enumerate() {
            let p: [f32; 3] = std::array::from_fn(|axis| {
                let at = 12 + 12 * k + 4 * axis;
                f32::from_le_bytes([facet[at], facet[at + 1], facet[at + 2], facet[at + 3]])
            });
            check_corner(file, &format_args!("facet {face}"), k, p)?;
            *slot = welder.vertex(p);
        }
        welder.mesh.triangles.push(triangle);
    }
    scene.nodes.push(node(String::new(), welder));
    Ok(scene)
}

/// Refuses a corner that is not finite.
fn check_corner(
    file: InFile,
    place: &dyn std::fmt::Display,
    k: usize,
    p: [f32; 3],
) -> Result<(), FormatError> {
    match p.into_iter().find(|v| !v.is_finite()) {
        None => Ok(()),
        Some(value) => Err(FormatError::NotFinite {
            file: file.0.to_owned(),
            element: place.to_string(),
            vertex: k,
            value: value.into(),
        }),
    }
}

/// A node with the triangles so far.
fn node(name: String, welder: Welder) -> Node {
    Node {
        name,
        transform: DAffine3::IDENTITY,
        mesh: Arc::new(welder.mesh),
        parent: None,
        is_detail: false,
    }
}

/// Reads STL text.
fn read_text(bytes: &[u8], name: &str) -> Result<Scene, FormatError> {
    let file = InFile(name);
    let mut scene = Scene::default();
    let mut welder = Welder::default();
    let mut solid = String::new();
    let mut corners = Vec::new();
    let mut open_line = None;
    for (line_number, line) in lines(bytes) {
        let place = format_args!("line {line_number}");
        let mut words = tokens(line);
        let Some(keyword) = words.next() else {
            continue;
        };
        match keyword.to_ascii_lowercase().as_slice() {
            b"solid" => {
                let rest = line.trim_ascii_start()[5..].trim_ascii();
                solid = String::from_utf8_lossy(rest).into_owned();
            }
            b"facet" => {
                corners.clear();
                open_line = Some(line_number);
            }
            b"vertex" => {
                let mut p = [0.0; 3];
                for v in &mut p {
                    let token = words.next().unwrap_or_default();
                    *v = number(token).ok_or_else(|| {
                        file.malformed(place, quote(line), "`vertex` and three numbers")
                    })?;
                }
                check_corner(file, &place, corners.len(), p)?;
                corners.push(welder.vertex(p));
            }
            b"endfacet" => {
                let [a, b, c] = corners[..] else {
                    return Err(file.malformed(
                        place,
                        format!("a facet of {} vertices", corners.len()),
                        "three",
                    ));
                };
                welder.mesh.triangles.push([a, b, c]);
                corners.clear();
                open_line = None;
            }
            b"endsolid" => {
                scene.nodes.push(node(
                    std::mem::take(&mut solid),
                    std::mem::take(&mut welder),
                ));
            }
            b"outer" | b"endloop" => {}
            _ => {
                return Err(file.malformed(
                    place,
                    quote(line),
                    "solid, facet, outer loop, vertex, endloop, endfacet or endsolid",
                ));
            }
        }
    }
    if let Some(line) = open_line {
        return Err(file.truncated(
            format_args!("facet at line {line}"),
            format!("after {} vertices", corners.len()),
            "three vertices and `endfacet`",
        ));
    }
    if !welder.mesh.triangles.is_empty() {
        scene
            .notes
            .push("The last solid does not end with `endsolid`.".to_owned());
        scene.nodes.push(node(solid, welder));
    }
    scene.nodes.retain(|n| !n.mesh.triangles.is_empty());
    Ok(scene)
}

/// Writes binary STL with all nodes in world coordinates.
pub(crate) fn write(
    scene: &Scene,
    name: &str,
    unit: LengthUnit,
) -> Result<Vec<Encoded>, FormatError> {
    let file = InFile(name);
    let count: usize = scene.nodes.iter().map(|n| n.mesh.triangles.len()).sum();
    let count32 = u32::try_from(count)
        .map_err(|_| file.unwritable(format!("{count} triangles"), "fewer than 2^32 in STL"))?;
    let mut bytes = Vec::with_capacity(HEADER_SIZE + FACET_SIZE * count);
    let mut header = [b' '; 80];
    let text = format!("binary STL by Greenstick, in {unit}");
    header[..text.len()].copy_from_slice(text.as_bytes());
    bytes.extend_from_slice(&header);
    bytes.extend_from_slice(&count32.to_le_bytes());
    for node in &scene.nodes {
        let mesh = in_world(node, unit);
        let positions = mesh
            .positions
            .iter()
            .map(|&p| to_f32(p, file))
            .collect::<Result<Vec<_>, _>>()?;
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = mesh.corners(t);
            let normal = (b - a)
                .cross(c - a)
                .normalize_or_zero()
                .as_vec3()
                .to_array();
            let corners = triangle.iter().flat_map(|&i| positions[i as usize]);
            for value in normal.into_iter().chain(corners) {
                bytes.extend_from_slice(&value.to_le_bytes());
            }
            bytes.extend_from_slice(&[0, 0]);
        }
    }
    Ok(vec![Encoded {
        name: name.to_owned(),
        bytes,
    }])
}
