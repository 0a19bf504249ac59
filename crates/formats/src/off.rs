//! OFF as text: `OFF`, `COFF`, `NOFF`, `STOFF` and their combinations.

use crate::attribute::clean_attributes;
use crate::companions::Encoded;
use crate::error::{FormatError, InFile};
use crate::polygon::{FaceStatistics, Triangulator};
use crate::position::{in_world, to_f32};
use crate::text::{lines, number, push_integer, push_number, quote, tokens};
use crate::unit::LengthUnit;
use glam::{DAffine3, DVec3};
use greenstick_geometry::{Attribute, Mesh, Node, Scene};
use std::sync::Arc;

/// The data of vertices besides positions, as the header declares them.
#[derive(Clone, Copy, Default)]
struct Columns {
    texture: bool,
    color: bool,
    normal: bool,
}

/// Parses the first word of a file.
fn header(token: &[u8]) -> Option<Columns> {
    let mut rest = token.strip_suffix(b"OFF")?;
    let mut columns = Columns::default();
    let mut take = |prefix: &[u8]| match rest.strip_prefix(prefix) {
        Some(r) => {
            rest = r;
            true
        }
        None => false,
    };
    columns.texture = take(b"ST");
    columns.color = take(b"C");
    columns.normal = take(b"N");
    rest.is_empty().then_some(columns)
}

/// Whether the first word is an OFF header.
pub(crate) fn is_off(text: &[u8]) -> bool {
    lines(text)
        .map(|(_, line)| content(line))
        .find_map(|line| tokens(line).next())
        .is_some_and(|word| header(word).is_some())
}

/// A line without its comment.
fn content(line: &[u8]) -> &[u8] {
    line.split(|&b| b == b'#')
        .next()
        .unwrap_or_default()
        .trim_ascii()
}

/// Reads an OFF file.
pub(crate) fn read(bytes: &[u8], name: &str) -> Result<Scene, FormatError> {
    let file = InFile(name);
    let mut rows = lines(bytes)
        .map(|(n, line)| (n, content(line)))
        .filter(|(_, line)| !line.is_empty());
    let (mut at, first) = rows.next().unwrap_or((1, b""));
    let mut words = tokens(first);
    let Some(columns) = header(words.next().unwrap_or_default()) else {
        return Err(FormatError::NotThisFormat {
            file: name.to_owned(),
            format: "OFF",
            found: format!("it starts with {}", quote(first)),
            right: "OFF, COFF, NOFF or STOFF as the first word".to_owned(),
        });
    };
    let mut counts: Vec<&[u8]> = words.collect();
    if counts.first() == Some(&b"BINARY".as_slice()) {
        return Err(file.unsupported("binary OFF", "save it as text or as PLY"));
    }
    if counts.is_empty() {
        let (n, line) = rows
            .next()
            .ok_or_else(|| file.truncated("header", "no counts", "three counts"))?;
        at = n;
        counts = tokens(line).collect();
    }
    let count = |k: usize| {
        counts
            .get(k)
            .copied()
            .and_then(number::<usize>)
            .ok_or_else(|| {
                file.malformed(
                    format_args!("line {at}"),
                    counts.first().map_or("nothing".to_owned(), |t| quote(t)),
                    "the numbers of vertices, faces and edges",
                )
            })
    };
    let (vertices, faces) = (count(0)?, count(1)?);
    // The shortest vertex is `0 0 0` and the shortest face `0`, each with a line ending.
    file.check_count("vertices", vertices, 6, bytes.len() + 1)?;
    file.check_count("faces", faces, 2, bytes.len() + 1)?;
    if faces == 0 && vertices > 0 {
        return Err(FormatError::PointCloud {
            file: name.to_owned(),
            points: vertices,
        });
    }
    let mut mesh = read_vertices(&mut rows, vertices, columns, file)?;
    let mut notes = Vec::new();
    read_faces(&mut rows, faces, &mut mesh, &mut notes, file)?;
    clean_attributes(&mut mesh, &mut notes);
    let node = Node {
        name: String::new(),
        transform: DAffine3::IDENTITY,
        mesh: Arc::new(mesh),
        parent: None,
        is_detail: false,
    };
    Ok(Scene {
        nodes: vec![node],
        notes,
        ..Scene::default()
    })
}

/// Reads the vertices.
fn read_vertices<'a>(
    rows: &mut impl Iterator<Item = (usize, &'a [u8])>,
    count: usize,
    columns: Columns,
    file: InFile,
) -> Result<Mesh, FormatError> {
    let mut mesh = Mesh {
        positions: Vec::with_capacity(count),
        ..Mesh::default()
    };
    let (mut normals, mut colors, mut coordinates) = (Vec::new(), Vec::new(), Vec::new());
    let mut values: Vec<f64> = Vec::new();
    for vertex in 0..count {
        let (at, line) = rows.next().ok_or_else(|| {
            file.truncated(
                "vertices",
                format!("after {vertex}"),
                format!("{count} of them"),
            )
        })?;
        values.clear();
        let mut are_integers = true;
        for token in tokens(line) {
            let value = number(token).ok_or_else(|| {
                file.malformed(
                    format_args!("line {at}, vertex {vertex}"),
                    quote(token),
                    "a number",
                )
            })?;
            // Colours that are integers range from 0 to 255. Positions and normals come first and do not count.
            if values.len() >= 3 + 3 * usize::from(columns.normal) {
                are_integers &= token.iter().all(u8::is_ascii_digit);
            }
            values.push(value);
        }
        let mut rest = values.as_slice();
        let mut take = |n: usize| match rest.split_at_checked(n) {
            Some((head, tail)) => {
                rest = tail;
                Ok(head)
            }
            None => Err(file.malformed(
                format_args!("line {at}, vertex {vertex}"),
                quote(line),
                "a position and the data that the header declares",
            )),
        };
        mesh.positions.push(DVec3::from_slice(take(3)?));
        if columns.normal {
            normals.extend(take(3)?.iter().map(|&v| v as f32));
        }
        if columns.color {
            let after = 2 * usize::from(columns.texture);
            let n = values
                .len()
                .saturating_sub(3 + 3 * usize::from(columns.normal) + after);
            let color = take(n.clamp(3, 4))?;
            let scale = if are_integers { 255.0 } else { 1.0 };
            colors.extend((0..4).map(|k| color.get(k).map_or(1.0, |&v| (v / scale) as f32)));
        }
        if columns.texture {
            let uv = take(2)?;
            coordinates.extend([uv[0] as f32, (1.0 - uv[1]) as f32]);
        }
    }
    file.check_finite(|| "vertices".to_owned(), &mesh.positions)?;
    for (key, width, data) in [
        ("NORMAL", 3, normals),
        ("COLOR_0", 4, colors),
        ("TEXCOORD_0", 2, coordinates),
    ] {
        if !data.is_empty() {
            mesh.attributes
                .insert(key.to_owned(), Attribute { width, data });
        }
    }
    Ok(mesh)
}

/// Reads the faces.
fn read_faces<'a>(
    rows: &mut impl Iterator<Item = (usize, &'a [u8])>,
    count: usize,
    mesh: &mut Mesh,
    notes: &mut Vec<String>,
    file: InFile,
) -> Result<(), FormatError> {
    let vertices = mesh.positions.len();
    let mut triangulator = Triangulator::default();
    let (mut corners, mut points) = (Vec::new(), Vec::new());
    let mut statistics = FaceStatistics::default();
    let mut has_colours = false;
    for face in 0..count {
        let (at, line) = rows.next().ok_or_else(|| {
            file.truncated("faces", format!("after {face}"), format!("{count} of them"))
        })?;
        let place = || format!("line {at}, face {face}");
        let mut words = tokens(line);
        let n: usize = words
            .next()
            .and_then(number)
            .ok_or_else(|| file.malformed(place(), quote(line), "the number of corners"))?;
        corners.clear();
        for _ in 0..n {
            let index: i64 = words.next().and_then(number).ok_or_else(|| {
                file.malformed(
                    place(),
                    quote(line),
                    "the number of corners, followed by that many indices",
                )
            })?;
            match usize::try_from(index) {
                Ok(i) if i < vertices => corners.push(i as u32),
                _ => {
                    return Err(FormatError::IndexOutOfRange {
                        file: file.0.to_owned(),
                        element: format!("line {at} (counted from 0)"),
                        face,
                        index,
                        count: vertices,
                    });
                }
            }
        }
        has_colours |= words.next().is_some();
        statistics.count(n);
        points.clear();
        points.extend(corners.iter().map(|&i| mesh.positions[i as usize]));
        let triangles = triangulator.triangulate(&points);
        mesh.triangles
            .extend(triangles.iter().map(|t| t.map(|k| corners[k as usize])));
    }
    statistics.add_notes(notes);
    if has_colours {
        notes.push("Colours of faces were dropped.".to_owned());
    }
    Ok(())
}

/// Writes OFF, or COFF if every node has colours, with all nodes in world coordinates.
pub(crate) fn write(
    scene: &Scene,
    name: &str,
    unit: LengthUnit,
) -> Result<Vec<Encoded>, FormatError> {
    let file = InFile(name);
    let total = |count: fn(&Mesh) -> usize| scene.nodes.iter().map(|n| count(&n.mesh)).sum();
    let vertices: usize = total(|m| m.positions.len());
    let faces: usize = total(|m| m.triangles.len());
    let colored = scene.nodes.iter().all(|n| {
        n.mesh
            .attributes
            .get("COLOR_0")
            .is_some_and(|c| matches!(c.width, 3 | 4))
    });
    let mut out = Vec::with_capacity(40 * vertices + 24 * faces);
    out.extend_from_slice(if colored { b"COFF\n" } else { b"OFF\n" });
    out.extend_from_slice(format!("# in {unit}\n{vertices} {faces} 0\n").as_bytes());
    let mut buffer = zmij::Buffer::new();
    let mut triangles = Vec::with_capacity(24 * faces);
    let mut base = 0;
    for node in &scene.nodes {
        let mesh = in_world(node, unit);
        for (i, &p) in mesh.positions.iter().enumerate() {
            for (axis, value) in to_f32(p, file)?.into_iter().enumerate() {
                if axis > 0 {
                    out.push(b' ');
                }
                push_number(&mut out, &mut buffer, value);
            }
            if colored {
                let color = mesh.attributes["COLOR_0"].at(i);
                for k in 0..4 {
                    let value = color.get(k).copied().unwrap_or(1.0);
                    out.push(b' ');
                    // With a decimal point, because integers range from 0 to 255.
                    out.extend_from_slice(buffer.format(value).as_bytes());
                }
            }
            out.push(b'\n');
        }
        for t in &mesh.triangles {
            triangles.push(b'3');
            for &i in t {
                triangles.push(b' ');
                push_integer(&mut triangles, base + u64::from(i));
            }
            triangles.push(b'\n');
        }
        base += mesh.positions.len() as u64;
    }
    out.append(&mut triangles);
    Ok(vec![Encoded {
        name: name.to_owned(),
        bytes: out,
    }])
}
