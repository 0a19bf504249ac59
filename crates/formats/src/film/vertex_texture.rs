//! Vertex animation textures: the position of each vertex in each frame as images for a vertex shader, with the mesh at
//! rest. They serve engines and crowds that cannot use skins with thousands of joints.
//!
//! Frames are stacked vertically, each with as many rows as its vertices need; texel `c` of row `r` of a frame is vertex
//! `r · width + c`. Red, green and blue, 16 bits each, are fractions of the bounding box of all positions; normals are
//! mapped from −1…1 to 0…1. The second texture coordinates of the mesh are the centre of the vertex's texel in the first
//! frame.

use super::error::FilmError;
use super::frames::Frames;
use crate::companions::{Encoded, stem};
use crate::error::InFile;
use crate::format::Format;
use crate::unit::LengthUnit;
use glam::{DAffine3, DVec3};
use greenstick_geometry::{
    Attribute, Binding, Context, Film, Motion, Node, RigidBody, Scene, SkinnedMesh,
};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::Write;
use std::sync::Arc;

/// Largest width and height of textures that common graphics hardware supports, pixels.
pub const MAX_TEXTURE_SIZE: usize = 16384;

/// Description of the textures, as written to the `.json` file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VertexTexture {
    /// File name of the texture of positions.
    pub positions: String,
    /// File name of the texture of normals, if all meshes have normals.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normals: Option<String>,
    /// File name of the mesh at rest.
    pub mesh: String,
    /// Width, pixels.
    pub width: usize,
    /// Height, pixels.
    pub height: usize,
    /// Rows of a frame: from frame to frame, `v` grows by this over the height.
    pub rows_per_frame: usize,
    /// Number of vertices.
    pub vertices: usize,
    /// Number of frames.
    pub frames: usize,
    /// Frame rate, 1/s.
    pub frames_per_second: f64,
    /// Time of each frame, s.
    pub times: Vec<f64>,
    /// Position for a texel of zeros, m, y up.
    pub low: [f64; 3],
    /// Position for a texel of the largest values, m, y up.
    pub high: [f64; 3],
    /// Pieces and moving bodies with their vertices.
    pub pieces: Vec<TexturePiece>,
    /// Where the film comes from, by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub metadata: BTreeMap<String, String>,
}

/// The range of a piece's vertices.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TexturePiece {
    /// Name of the piece.
    pub name: String,
    /// Its first vertex.
    pub first_vertex: usize,
    /// Number of vertices.
    pub vertices: usize,
}

impl VertexTexture {
    /// Largest error of a coordinate, m: half a step of the 16 bits.
    pub fn error(&self) -> f64 {
        let sides = self.low.iter().zip(&self.high).map(|(l, h)| h - l);
        sides.fold(0.0, f64::max) / (2.0 * MAX_LEVEL)
    }
}

/// Largest value of 16 bits.
const MAX_LEVEL: f64 = 65535.0;

/// Writes a film as vertex animation textures: `NAME.png` with positions, `NAME.normals.png`, `NAME.json` with a
/// description, and `NAME.glb` with the pieces and moving bodies at rest and the bodies that do not move. `name` is the name
/// of the first file; rows are at most `width` pixels wide.
///
/// Frames are requested twice: for the bounding box of all positions, and to write them. The compressed images stay in
/// memory.
///
/// # Errors
/// As [`super::write_glb`], and [`FilmError::Format`] if the textures would exceed [`MAX_TEXTURE_SIZE`].
pub fn write_vertex_texture<M: Motion>(
    film: &Film,
    motion: &mut M,
    name: &str,
    width: usize,
    context: &Context,
) -> Result<(VertexTexture, Vec<Encoded>), FilmError> {
    let mut frames = Frames::new(film, motion, name)?;
    let film = &with_bodies_as_pieces(film);
    let stem = stem(name);
    let mut description = describe(film, &frames, &stem, width)?;
    let mut vertices = FrameVertices::default();
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for frame in 0..description.frames {
        context.report(0.5 * frame as f64 / description.frames as f64)?;
        vertices.compute(film, &mut frames, frame)?;
        for &p in &vertices.positions {
            (low, high) = (low.min(p), high.max(p));
        }
    }
    (description.low, description.high) = (low.to_array(), high.to_array());
    let images = encode(
        film,
        &mut frames,
        &description,
        &mut vertices,
        &context.part(0.5, 1.0),
    )?;
    let scene = at_rest(film, &description);
    let names = std::iter::once(&description.positions).chain(&description.normals);
    let encoded = |(name, bytes): (&String, _)| Encoded {
        name: name.clone(),
        bytes,
    };
    let mut files: Vec<Encoded> = names.zip(images).map(encoded).collect();
    let json =
        serde_json::to_string_pretty(&description).map_err(|e| frames.write_error(e.into()))?;
    files.push(Encoded {
        name: format!("{stem}.json"),
        bytes: (json + "\n").into_bytes(),
    });
    let mesh = crate::mesh::write(Format::Glb, &scene, &description.mesh, LengthUnit::Metre)?;
    files.extend(mesh);
    Ok((description, files))
}

/// Encodes all frames as PNG: the positions and, where there are any, the normals.
fn encode(
    film: &Film,
    frames: &mut Frames,
    description: &VertexTexture,
    vertices: &mut FrameVertices,
    context: &Context,
) -> Result<Vec<Vec<u8>>, FilmError> {
    let low = DVec3::from_array(description.low);
    let size = DVec3::from_array(description.high) - low;
    // All values along a side without extent are 0.
    let scale = DVec3::select(size.cmpgt(DVec3::ZERO), 1.0 / size, DVec3::ZERO);
    let mut images = vec![Vec::new(); 1 + usize::from(description.normals.is_some())];
    let mut encoders = Vec::new();
    for bytes in &mut images {
        let png = png_writer(bytes, description.width, description.height);
        encoders.push(png.map_err(|e| frames.write_error(e.into()))?);
    }
    let mut writers = Vec::new();
    for png in &mut encoders {
        let writer = png.stream_writer();
        writers.push(writer.map_err(|e| frames.write_error(e.into()))?);
    }
    let texels = description.width * description.rows_per_frame;
    let mut rows = Vec::with_capacity(6 * texels);
    for frame in 0..description.frames {
        context.report(frame as f64 / description.frames as f64)?;
        vertices.compute(film, frames, frame)?;
        for (k, writer) in writers.iter_mut().enumerate() {
            rows.clear();
            if k == 0 {
                for &p in &vertices.positions {
                    push_texel(&mut rows, (p - low) * scale);
                }
            } else {
                for &n in &vertices.normals {
                    push_texel(&mut rows, 0.5 * n + 0.5);
                }
            }
            rows.resize(6 * texels, 0);
            writer.write_all(&rows).map_err(|e| frames.write_error(e))?;
        }
    }
    for writer in writers {
        let done = writer.finish();
        done.map_err(|e| frames.write_error(e.into()))?;
    }
    drop(encoders);
    Ok(images)
}

/// Turns bodies that move into pieces that follow one joint.
fn with_bodies_as_pieces(film: &Film) -> Film {
    let mut film = film.clone();
    for RigidBody { node, joint } in std::mem::take(&mut film.bodies) {
        film.pieces.push(SkinnedMesh {
            binding: Binding::rigid(node.mesh.positions.len(), joint),
            mesh: node.mesh.transformed(&node.transform),
            name: node.name,
            ..SkinnedMesh::default()
        });
    }
    film
}

/// Sizes and names, without the bounding box.
fn describe(
    film: &Film,
    frames: &Frames,
    stem: &str,
    width: usize,
) -> Result<VertexTexture, FilmError> {
    let mut pieces = Vec::with_capacity(film.pieces.len());
    let mut vertices = 0;
    for piece in &film.pieces {
        pieces.push(TexturePiece {
            name: piece.name.clone(),
            first_vertex: vertices,
            vertices: piece.mesh.positions.len(),
        });
        vertices += piece.mesh.positions.len();
    }
    let file: InFile = frames.file();
    if vertices == 0 {
        return Err(file
            .unwritable("no vertex moves", "at least one piece")
            .into());
    }
    let width = vertices.min(width.clamp(1, MAX_TEXTURE_SIZE));
    let rows_per_frame = vertices.div_ceil(width);
    let height = rows_per_frame * frames.count();
    if height > MAX_TEXTURE_SIZE {
        let found = format!(
            "{vertices} vertices in {} frames make {width} × {height} pixels",
            frames.count()
        );
        let right =
            format!("at most {MAX_TEXTURE_SIZE} rows: fewer frames, fewer vertices, or wider rows");
        return Err(file.unwritable(found, right).into());
    }
    let has_normals = |p: &SkinnedMesh| {
        p.mesh
            .attributes
            .get("NORMAL")
            .is_some_and(|a| a.width == 3)
    };
    let all = film.pieces.iter().all(has_normals);
    Ok(VertexTexture {
        positions: format!("{stem}.png"),
        normals: all.then(|| format!("{stem}.normals.png")),
        mesh: format!("{stem}.glb"),
        width,
        height,
        rows_per_frame,
        vertices,
        frames: frames.count(),
        frames_per_second: film.frames_per_second,
        times: frames.times.clone(),
        low: [0.0; 3],
        high: [0.0; 3],
        pieces,
        metadata: (film.metadata.entries.iter())
            .map(|entry| (entry.name.clone(), entry.text.clone()))
            .collect(),
    })
}

/// The vertices of all pieces in a frame.
#[derive(Default)]
struct FrameVertices {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    maps: Vec<DAffine3>,
    /// Working memory for one piece.
    piece: Vec<DVec3>,
}

impl FrameVertices {
    /// Computes the vertices in a frame.
    fn compute(&mut self, film: &Film, frames: &mut Frames, frame: usize) -> Result<(), FilmError> {
        film.joint_maps(frames.poses(frame)?, &mut self.maps);
        self.positions.clear();
        self.normals.clear();
        for piece in 0..film.pieces.len() {
            film.deform_positions_at(frame, piece, &self.maps, &mut self.piece);
            self.positions.extend(&self.piece);
            film.deform_normals_at(frame, piece, &self.maps, &mut self.piece);
            self.normals.extend(&self.piece);
        }
        Ok(())
    }
}

/// Appends three fractions as 16 bits each, the high byte first, as in PNG.
fn push_texel(row: &mut Vec<u8>, fractions: DVec3) {
    let levels = (fractions.clamp(DVec3::ZERO, DVec3::ONE) * MAX_LEVEL).round();
    for level in levels.to_array() {
        row.extend((level as u16).to_be_bytes());
    }
}

/// Starts a PNG file with 16 bits per channel.
fn png_writer(
    bytes: &mut Vec<u8>,
    width: usize,
    height: usize,
) -> Result<png::Writer<&mut Vec<u8>>, png::EncodingError> {
    let mut encoder = png::Encoder::new(bytes, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.set_compression(png::Compression::Fast);
    // The values are numbers, not colours: no transfer curve applies.
    encoder.set_source_gamma(png::ScaledFloat::new(1.0));
    encoder.write_header()
}

/// The pieces at rest, each vertex with its texel of the first frame, and the bodies that do not move.
fn at_rest(film: &Film, description: &VertexTexture) -> Scene {
    let texel = |vertex: usize| {
        let (row, column) = (vertex / description.width, vertex % description.width);
        let middle = |at: usize, of: usize| ((at as f64 + 0.5) / of as f64) as f32;
        [
            middle(column, description.width),
            middle(row, description.height),
        ]
    };
    let nodes = film
        .pieces
        .iter()
        .zip(&description.pieces)
        .map(|(piece, range)| {
            let mut mesh = piece.mesh.clone();
            let all = range.first_vertex..range.first_vertex + range.vertices;
            let attribute = Attribute {
                width: 2,
                data: all.flat_map(texel).collect(),
            };
            mesh.attributes.insert("TEXCOORD_1".into(), attribute);
            Node {
                name: piece.name.clone(),
                transform: DAffine3::IDENTITY,
                mesh: Arc::new(mesh),
                parent: None,
                is_detail: false,
            }
        });
    Scene {
        nodes: nodes.chain(film.fixed.iter().cloned()).collect(),
        materials: film.materials.clone(),
        textures: film.textures.clone(),
        images: film.images.clone(),
        metadata: film.metadata.clone(),
        ..Scene::default()
    }
}
