//! Vertex animation textures: where each vertex is in each frame, as pictures that a vertex shader reads, with the mesh at
//! rest that they move. For engines and crowds that have no skins of thousands of joints.
//!
//! Frames lie below each other, each of as many rows as its vertices need; texel `c` of a frame's row `r` is vertex
//! `r · width + c`. Red, green and blue, 16 bits each, are shares of the box of all positions; normals are halved and
//! moved to 0 to 1. The mesh has its texel of the first frame as second texture coordinates, at the texel's middle.

use super::{FilmError, Reel};
use crate::error::InFile;
use crate::{Encoded, Format, LengthUnit, stem};
use glam::{DAffine3, DVec3};
use greenstick_geometry::{
    Attribute, Binding, Context, Film, Motion, Node, RigidBody, Scene, SkinnedMesh,
};
use serde::Serialize;
use std::io::Write;
use std::sync::Arc;

/// Widest and highest picture that common graphics hardware reads.
pub const LARGEST_TEXTURE: usize = 16384;

/// What was written.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VertexTexture {
    /// The picture of positions.
    pub positions: String,
    /// The picture of normals, where all meshes have them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normals: Option<String>,
    /// The mesh at rest.
    pub mesh: String,
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Rows of a frame: what `v` grows by from frame to frame, times the height.
    pub rows_per_frame: usize,
    /// Vertices.
    pub vertices: usize,
    /// Frames.
    pub frames: usize,
    /// Frames shown in a second.
    pub frames_per_second: f64,
    /// When each frame is shown, s.
    pub times: Vec<f64>,
    /// The place of a texel of zeros, m, y up.
    pub low: [f64; 3],
    /// The place of a texel of largest values, m, y up.
    pub high: [f64; 3],
    /// Pieces and moving bodies with their first vertices.
    pub pieces: Vec<TexturePiece>,
}

/// Where a piece's vertices lie.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TexturePiece {
    /// Its name.
    pub name: String,
    /// Its first vertex.
    pub first_vertex: usize,
    /// How many there are.
    pub vertices: usize,
}

impl VertexTexture {
    /// Largest distance of a coordinate from where it should be, m: half a step of the 16 bits.
    pub fn error(&self) -> f64 {
        let sides = self.low.iter().zip(&self.high).map(|(l, h)| h - l);
        sides.fold(0.0, f64::max) / (2.0 * LEVELS)
    }
}

/// Steps of 16 bits.
const LEVELS: f64 = 65535.0;

/// The film as pictures of its vertices: `NAME.png` with positions, `NAME.normals.png`, `NAME.json` that says how to read
/// them, and `NAME.glb` with the pieces and moving bodies at rest and bodies that stand still. `name` is that of the
/// first; rows are at most `width` pixels wide.
///
/// Frames are asked for twice: for the box of all positions, and to write them. What is held is the packed pictures.
///
/// # Errors
/// As [`super::write_glb`]; [`FilmError::Format`] where the pictures would be larger than [`LARGEST_TEXTURE`].
pub fn write_vertex_texture<M: Motion>(
    film: &Film,
    motion: &mut M,
    name: &str,
    width: usize,
    context: &Context,
) -> Result<(VertexTexture, Vec<Encoded>), FilmError> {
    let mut reel = Reel::new(film, motion, name)?;
    let film = &with_bodies(film);
    let stem = stem(name);
    let mut about = layout(film, &reel, &stem, width)?;
    let mut placed = Placed::default();
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for frame in 0..about.frames {
        context.report(0.5 * frame as f64 / about.frames as f64)?;
        placed.at(film, &mut reel, frame)?;
        (low, high) =
            (placed.positions.iter()).fold((low, high), |(l, h), &p| (l.min(p), h.max(p)));
    }
    (about.low, about.high) = (low.to_array(), high.to_array());
    let size = high - low;
    // A side without width is all zeros.
    let scale = DVec3::select(size.cmpgt(DVec3::ZERO), 1.0 / size, DVec3::ZERO);
    let mut pictures = vec![Vec::new(); 1 + usize::from(about.normals.is_some())];
    {
        let mut headed = Vec::new();
        for bytes in &mut pictures {
            let png = png_writer(bytes, about.width, about.height);
            headed.push(png.map_err(|e| reel.failed(e.into()))?);
        }
        let mut writers = Vec::new();
        for png in &mut headed {
            writers.push(png.stream_writer().map_err(|e| reel.failed(e.into()))?);
        }
        let texels = about.width * about.rows_per_frame;
        let mut row = Vec::with_capacity(6 * texels);
        for frame in 0..about.frames {
            context.report(0.5 + 0.5 * frame as f64 / about.frames as f64)?;
            placed.at(film, &mut reel, frame)?;
            for (k, writer) in writers.iter_mut().enumerate() {
                row.clear();
                match k {
                    0 => placed
                        .positions
                        .iter()
                        .for_each(|&p| put(&mut row, (p - low) * scale)),
                    _ => placed
                        .normals
                        .iter()
                        .for_each(|&n| put(&mut row, 0.5 * n + 0.5)),
                }
                row.resize(6 * texels, 0);
                writer.write_all(&row).map_err(|e| reel.failed(e))?;
            }
        }
        for writer in writers {
            writer.finish().map_err(|e| reel.failed(e.into()))?;
        }
    }
    let scene = at_rest(film, &about);
    let names = std::iter::once(&about.positions).chain(&about.normals);
    let encoded = |(name, bytes): (&String, _)| Encoded {
        name: name.clone(),
        bytes,
    };
    let mut files: Vec<Encoded> = names.zip(pictures).map(encoded).collect();
    let json = serde_json::to_string_pretty(&about).map_err(|e| reel.failed(e.into()))? + "\n";
    files.push(Encoded {
        name: format!("{stem}.json"),
        bytes: json.into_bytes(),
    });
    let mesh = crate::write(Format::Glb, &scene, &about.mesh, LengthUnit::Metre)?;
    files.extend(mesh);
    Ok((about, files))
}

/// The film with bodies that move as pieces of one joint.
fn with_bodies(film: &Film) -> Film {
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

/// Sizes and names, without the box.
fn layout(film: &Film, reel: &Reel, stem: &str, width: usize) -> Result<VertexTexture, FilmError> {
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
    let file: InFile = reel.file();
    if vertices == 0 {
        return Err(file
            .unwritable("no vertex moves", "at least one piece")
            .into());
    }
    let width = vertices.min(width.clamp(1, LARGEST_TEXTURE));
    let rows_per_frame = vertices.div_ceil(width);
    let height = rows_per_frame * reel.frames();
    if height > LARGEST_TEXTURE {
        let found = format!(
            "{vertices} vertices in {} frames make {width} × {height} pixels",
            reel.frames()
        );
        let right =
            format!("at most {LARGEST_TEXTURE} rows: fewer frames, fewer vertices or wider rows");
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
        frames: reel.frames(),
        frames_per_second: film.frames_per_second,
        times: reel.times.clone(),
        low: [0.0; 3],
        high: [0.0; 3],
        pieces,
    })
}

/// All vertices of a frame.
#[derive(Default)]
struct Placed {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    maps: Vec<DAffine3>,
    piece: Vec<DVec3>,
}

impl Placed {
    fn at(&mut self, film: &Film, reel: &mut Reel, frame: usize) -> Result<(), FilmError> {
        film.joint_maps(reel.at(frame)?, &mut self.maps);
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

/// Three shares as 16 bits each, the high byte first, as PNG has them.
fn put(row: &mut Vec<u8>, shares: DVec3) {
    let levels = (shares.clamp(DVec3::ZERO, DVec3::ONE) * LEVELS).round();
    for level in levels.to_array() {
        row.extend((level as u16).to_be_bytes());
    }
}

fn png_writer(
    bytes: &mut Vec<u8>,
    width: usize,
    height: usize,
) -> Result<png::Writer<&mut Vec<u8>>, png::EncodingError> {
    let mut encoder = png::Encoder::new(bytes, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.set_compression(png::Compression::Fast);
    // Numbers, not colours: nobody may bend them by a curve.
    encoder.set_source_gamma(png::ScaledFloat::new(1.0));
    encoder.write_header()
}

/// The pieces at rest, each vertex with its texel of the first frame, and bodies that stand still.
fn at_rest(film: &Film, about: &VertexTexture) -> Scene {
    let texel = |vertex: usize| {
        let (row, column) = (vertex / about.width, vertex % about.width);
        let middle = |at: usize, of: usize| ((at as f64 + 0.5) / of as f64) as f32;
        [middle(column, about.width), middle(row, about.height)]
    };
    let nodes = film.pieces.iter().zip(&about.pieces).map(|(piece, its)| {
        let mut mesh = piece.mesh.clone();
        let all = its.first_vertex..its.first_vertex + its.vertices;
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
        }
    });
    Scene {
        nodes: nodes.chain(film.fixed.iter().cloned()).collect(),
        materials: film.materials.clone(),
        textures: film.textures.clone(),
        images: film.images.clone(),
        notes: Vec::new(),
    }
}
