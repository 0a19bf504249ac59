//! A broken scene as the card draws it: one list of vertices, one of triangles, and batches of one material each.

use super::look::WoodLook;
use super::materials::{DecodedImages, Images, Opacity, Texture};
use super::wire;
use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use greenstick::geometry::mesh::NO_MATERIAL;
use greenstick::geometry::{Material, Mesh, Node, Pixels, Scene};
use greenstick::session::{Broken, NodeRole, PieceRole};
use greenstick::skin::materials::without_color;
use greenstick::wood::branch::BARK_MATERIAL_NAME;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

/// A vertex.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Vertex {
    /// From the scene's middle, m.
    pub position: [f32; 3],
    /// Unit normal; 0 for that of the triangle.
    pub normal: [f32; 3],
    /// Texture coordinates.
    pub uv: [f32; 2],
    /// Coordinates along the grain, m, and 1 where there are any.
    pub grain: [f32; 4],
    /// Tissue and piece.
    pub zone_piece: [f32; 2],
}

impl Vertex {
    /// Sets the coordinates along the grain, m; 0 for what does not lie on the stem.
    pub(super) fn set_grain(&mut self, grain: Vec3) {
        let on_stem = f32::from(u8::from(grain != Vec3::ZERO));
        self.grain = grain.extend(on_stem).to_array();
    }

    /// A vertex between three, with their weights; its tissue is that of the first.
    pub(super) fn blend(of: [Vertex; 3], weights: [f32; 3]) -> Vertex {
        fn blended<const N: usize>(values: [[f32; N]; 3], weights: [f32; 3]) -> [f32; N] {
            // What has no weight may have no value either.
            let term = |i: usize, c: usize| {
                if weights[i] == 0.0 {
                    0.0
                } else {
                    values[i][c] * weights[i]
                }
            };
            std::array::from_fn(|c| (0..3).map(|i| term(i, c)).sum())
        }
        let [x, y, z, _] = blended(of.map(|v| v.grain), weights);
        let mut vertex = Vertex {
            normal: blended(of.map(|v| v.normal), weights),
            uv: blended(of.map(|v| v.uv), weights),
            ..of[0]
        };
        vertex.set_grain(Vec3::new(x, y, z));
        vertex
    }
}

/// How a batch is shaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Shading {
    /// By its own material.
    Material,
    /// As wood inside the break of this number.
    Wood(usize),
    /// As the skin of the stem: bark, or sawn wood.
    Skin,
}

/// Triangles of one material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Batch {
    /// Number of its material in the scene.
    pub material: u32,
    /// First index.
    pub first: u32,
    /// Number of indices.
    pub count: u32,
    /// How it is shaded.
    pub shading: Shading,
    /// Linear colour.
    pub base: [f32; 4],
    /// Metalness and roughness.
    pub metal_rough: [f32; 2],
    /// The texture of its colour, among [`DrawnScene::images`].
    pub texture: Option<Texture>,
    /// The texture of its normals, among [`DrawnScene::reliefs`].
    pub relief: Option<Texture>,
    /// Where it is clear.
    pub opacity: Opacity,
}

impl Batch {
    /// Whether there may be holes in it. Wood and bark that Greenstick shades have none.
    pub fn has_holes(&self) -> bool {
        self.shading == Shading::Material && self.opacity != Opacity::Opaque
    }

    /// The wood that a section opens in the first break's stem; of no triangles yet.
    pub(crate) const OPENED_WOOD: Batch = Batch {
        material: 0,
        first: 0,
        count: 0,
        shading: Shading::Wood(0),
        base: [0.5, 0.35, 0.2, 1.0],
        metal_rough: [0.0, 0.8],
        texture: None,
        relief: None,
        opacity: Opacity::Opaque,
    };
}

/// A piece that is drawn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DrawnPiece {
    /// Its name.
    pub name: String,
    /// Its motion from where it was in the unbroken scene.
    #[serde(with = "wire::motion")]
    pub motion: DAffine3,
}

/// A box, by its least and its greatest corner.
pub(super) type Box3 = [[f32; 3]; 2];

/// Where a scene's triangles and faces are.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Survey {
    /// Boxes around its triangles, some to each, in their order.
    #[serde(with = "wire::plain")]
    pub(super) boxes: Vec<Box3>,
    /// Heights of the face below each break, as [`CrackFace`](super::crack_face::CrackFace) has them.
    pub(super) faces: Vec<Vec<f32>>,
}

/// A broken scene as the card draws it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct DrawnScene {
    /// Vertices.
    #[serde(with = "wire::plain")]
    pub vertices: Vec<Vertex>,
    /// Corners of triangles.
    #[serde(with = "wire::plain")]
    pub indices: Vec<u32>,
    /// Batches, which cover all indices.
    pub batches: Vec<Batch>,
    /// Pieces, by the number in their vertices.
    pub pieces: Vec<DrawnPiece>,
    /// Decoded textures of colours.
    #[serde(with = "wire::images")]
    pub images: Vec<Arc<Pixels>>,
    /// Decoded textures of normals.
    #[serde(with = "wire::images")]
    pub reliefs: Vec<Arc<Pixels>>,
    /// The wood inside each break.
    pub woods: Vec<WoodLook>,
    /// The middle, m: what is subtracted from positions.
    #[serde(with = "wire::point")]
    pub middle: DVec3,
    /// Radius of a sphere about the middle that holds all, m.
    pub radius: f64,
    /// Each break from the middle: where it is, along the stem, and how large the stem is there, m.
    pub breaks: Vec<DrawnBreak>,
    /// Where its triangles and faces are, once that was asked for ([`DrawnScene::surveyed`]).
    #[serde(with = "wire::once")]
    pub(super) survey: OnceLock<Survey>,
}

/// Where a break is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DrawnBreak {
    /// Its place from the middle, m.
    #[serde(with = "wire::vector")]
    pub place: Vec3,
    /// Unit direction of the stem.
    #[serde(with = "wire::vector")]
    pub along: Vec3,
    /// Unit direction across the stem from which angles are counted, and the one square to it.
    #[serde(with = "wire::vectors")]
    pub across: [Vec3; 2],
    /// Radius of the stem, m.
    pub radius: f32,
    /// Between which heights over the place most of the face lies, m: single splinters reach farther.
    pub heights: [f32; 2],
    /// Length along the grain, m.
    pub length: f32,
}

/// The number of what no break touched.
const UNTOUCHED: f32 = 0.0;

impl DrawnScene {
    /// A broken scene. `decoded` are the images of the scene that was broken, as far as they were needed before.
    pub fn new(broken: &Broken, decoded: &mut DecodedImages) -> Self {
        let scene = &broken.scene;
        let (low, high) = bounds(scene);
        let mut out = DrawnScene {
            middle: (low + high) * 0.5,
            radius: (0.5 * (high - low).length()).max(1e-6),
            woods: broken.woods.iter().map(WoodLook::new).collect(),
            ..DrawnScene::default()
        };
        let still = at_rest(broken);
        out.pieces.push(DrawnPiece {
            name: "untouched".to_owned(),
            motion: DAffine3::IDENTITY,
        });
        let mut by_material: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let mut upper = 0.0;
        for (node, role) in scene.nodes.iter().zip(&broken.roles) {
            let piece = match role {
                NodeRole::Piece(role) => {
                    let number = out.pieces.len() as f32;
                    out.pieces.push(DrawnPiece {
                        name: node.name.clone(),
                        motion: node.transform * still.inverse(),
                    });
                    if matches!(role, PieceRole::Upper | PieceRole::Segment(_)) {
                        upper = number;
                    }
                    number
                }
                // Pieces are the first nodes, and the first piece is what no break touched.
                NodeRole::Fuzz(_) => node.parent.map_or(UNTOUCHED, |at| (at + 1) as f32),
                NodeRole::Carried => upper,
                NodeRole::Untouched => UNTOUCHED,
            };
            out.push(node, piece, &mut by_material);
        }
        let woods: Vec<u32> = broken.woods.iter().map(|w| w.material).collect();
        out.add_batches(scene, &woods, by_material, decoded);
        out.breaks = breaks(broken, out.middle);
        out.place_limbs();
        out
    }

    /// A scene in which nothing is broken.
    pub fn unbroken(scene: &Scene) -> Self {
        let (low, high) = bounds(scene);
        let mut out = DrawnScene {
            middle: (low + high) * 0.5,
            radius: (0.5 * (high - low).length()).max(1e-6),
            woods: vec![WoodLook::default()],
            pieces: vec![DrawnPiece {
                name: "unbroken".to_owned(),
                motion: DAffine3::IDENTITY,
            }],
            ..DrawnScene::default()
        };
        let mut by_material = BTreeMap::new();
        for node in &scene.nodes {
            out.push(node, 0.0, &mut by_material);
        }
        out.add_batches(scene, &[], by_material, &mut DecodedImages::new());
        out.place_limbs();
        out
    }

    /// A scene that has moved since it was broken, drawn about `middle`; each wood inside its breaks has a material and a look.
    pub fn moved(
        scene: &Scene,
        woods: &[(u32, WoodLook)],
        middle: DVec3,
        decoded: &mut DecodedImages,
    ) -> Self {
        let (low, high) = bounds(scene);
        let far = (low - middle).abs().max((high - middle).abs());
        let mut looks: Vec<WoodLook> = woods.iter().map(|w| w.1.clone()).collect();
        if looks.is_empty() {
            looks.push(WoodLook::default());
        }
        let mut out = DrawnScene {
            middle,
            radius: far.length().max(1e-6),
            woods: looks,
            ..DrawnScene::default()
        };
        let mut by_material = BTreeMap::new();
        for (number, node) in scene.nodes.iter().enumerate() {
            out.pieces.push(DrawnPiece {
                name: node.name.clone(),
                motion: DAffine3::IDENTITY,
            });
            out.push(node, number as f32, &mut by_material);
        }
        let materials: Vec<u32> = woods.iter().map(|w| w.0).collect();
        out.add_batches(scene, &materials, by_material, decoded);
        out.place_limbs();
        out
    }

    /// The number of the piece that holds a length along the stem, m.
    fn piece_at(&self, length: f32) -> Option<usize> {
        let breaks_below = self.breaks.iter().filter(|b| b.length < length).count();
        let role = match (self.breaks.len(), breaks_below) {
            (1, 0) => PieceRole::Lower,
            (1, _) => PieceRole::Upper,
            (_, below) => PieceRole::Segment(below),
        };
        let name = role.name();
        self.pieces.iter().position(|p| p.name == name)
    }

    /// The number of the piece at the stem's far end.
    pub fn last_piece(&self) -> Option<usize> {
        self.piece_at(f32::INFINITY)
    }

    /// The number of the piece at the base.
    pub fn first_piece(&self) -> Option<usize> {
        self.piece_at(f32::NEG_INFINITY)
    }

    /// The number of the piece below a break.
    pub fn piece_below(&self, number: usize) -> Option<usize> {
        self.piece_at(self.breaks.get(number)?.length)
    }

    /// Where a point of the unbroken stem (m in the world) is drawn that lies at a length along it (m).
    pub fn moved_point(&self, world: DVec3, length: f32) -> Vec3 {
        let piece = self.piece_at(length).map(|i| &self.pieces[i]);
        let moved = piece.map_or(world, |p| p.motion.transform_point3(world));
        (moved - self.middle).as_vec3()
    }

    /// Where a break is, moved with the piece below it.
    pub fn break_place(&self, number: usize) -> Vec3 {
        let at = self.breaks[number];
        self.moved_point(at.place.as_dvec3() + self.middle, at.length)
    }

    /// Adds the vertices of a node, and its triangles to the lists of their materials.
    pub(super) fn push(
        &mut self,
        node: &Node,
        piece: f32,
        by_material: &mut BTreeMap<u32, Vec<u32>>,
    ) {
        let mesh = &node.mesh;
        let first = self.vertices.len() as u32;
        let turned = normal_map(&node.transform);
        for (mut vertex, &p) in drawn_vertices(mesh).zip(&mesh.positions) {
            let world = node.transform.transform_point3(p) - self.middle;
            vertex.position = world.as_vec3().to_array();
            let n = turned * Vec3::from_array(vertex.normal).as_dvec3();
            vertex.normal = n.normalize_or_zero().as_vec3().to_array();
            vertex.zone_piece[1] = piece;
            self.vertices.push(vertex);
        }
        let mirrored = node.transform.matrix3.determinant() < 0.0;
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let mut corners = corners.map(|c| c + first);
            if mirrored {
                corners.swap(1, 2);
            }
            let list = by_material.entry(mesh.material(t)).or_default();
            list.extend(corners);
        }
    }

    /// Makes batches of the triangles of each material; those of the wood inside breaks are `woods`.
    fn add_batches(
        &mut self,
        scene: &Scene,
        woods: &[u32],
        by_material: BTreeMap<u32, Vec<u32>>,
        decoded: &mut DecodedImages,
    ) {
        let blank = without_color(scene);
        let mut decoded_reliefs = decoded.clone();
        let mut images = Images::new(scene, decoded);
        let mut reliefs = Images::new(scene, &mut decoded_reliefs);
        for (number, corners) in by_material {
            let first = self.indices.len() as u32;
            let count = corners.len() as u32;
            self.indices.extend(corners);
            let material = scene.materials.get(number as usize);
            let wood = woods.iter().position(|w| *w == number);
            let texture = material.and_then(|m| images.texture(m.base_color_texture.as_ref()));
            // Vertices have the first coordinates alone.
            let relief = material.and_then(|m| m.normal_texture.as_ref());
            let relief = reliefs.texture(relief.filter(|r| r.coordinates == 0));
            let own_bark = material.is_some_and(|m| m.name == BARK_MATERIAL_NAME);
            let is_blank = blank.get(number as usize).copied().unwrap_or(true);
            let shading = match wood {
                Some(wood) => Shading::Wood(wood),
                None if own_bark || number == NO_MATERIAL || (is_blank && texture.is_none()) => {
                    Shading::Skin
                }
                None => Shading::Material,
            };
            let plain = Material::default();
            let m = material.unwrap_or(&plain);
            self.batches.push(Batch {
                material: number,
                first,
                count,
                shading,
                base: m.base_color,
                metal_rough: [m.metallic, m.roughness],
                texture,
                relief,
                opacity: Opacity::of(m),
            });
        }
        (self.images, self.reliefs) = (images.drawn, reliefs.drawn);
        decoded.extend(decoded_reliefs);
    }
}

/// Reads vertices of a mesh.
struct Reader<'a> {
    mesh: &'a Mesh,
}

/// The vertices of a mesh with its attributes, not yet in their places.
pub(super) fn drawn_vertices(mesh: &Mesh) -> impl Iterator<Item = Vertex> {
    let reader = Reader { mesh };
    (0..mesh.positions.len()).map(move |i| reader.vertex(i))
}

impl Reader<'_> {
    fn values<const N: usize>(&self, name: &str, i: usize) -> Option<[f32; N]> {
        let attribute = self.mesh.attributes.get(name)?;
        let start = i * attribute.width;
        let found = attribute.data.get(start..start + attribute.width.min(N))?;
        let mut values = [0.0; N];
        values[..found.len()].copy_from_slice(found);
        Some(values)
    }

    /// The attributes of vertex `i`.
    fn vertex(&self, i: usize) -> Vertex {
        let mut vertex = Vertex {
            position: [0.0; 3],
            normal: self.values("NORMAL", i).unwrap_or([0.0; 3]),
            uv: self.values("TEXCOORD_0", i).unwrap_or([0.0; 2]),
            grain: [0.0; 4],
            zone_piece: [self.values::<1>("_ZONE", i).unwrap_or([0.0])[0], 0.0],
        };
        vertex.set_grain(self.values("_GRAIN", i).unwrap_or([0.0; 3]).into());
        vertex
    }
}

/// How normals turn with a transform, with the direction of its inverse transpose.
pub(super) fn normal_map(transform: &DAffine3) -> DMat3 {
    let m = transform.matrix3;
    let cofactors = DMat3::from_cols(
        m.y_axis.cross(m.z_axis),
        m.z_axis.cross(m.x_axis),
        m.x_axis.cross(m.y_axis),
    );
    if m.determinant() < 0.0 {
        cofactors * -1.0
    } else {
        cofactors
    }
}

/// The transform of the stem's node before it was broken: that of the piece at the base.
fn at_rest(broken: &Broken) -> DAffine3 {
    let base = |role: &NodeRole| {
        matches!(
            role,
            NodeRole::Piece(PieceRole::Lower | PieceRole::Segment(0))
        )
    };
    let at = broken.roles.iter().position(base);
    at.map_or(DAffine3::IDENTITY, |i| broken.scene.nodes[i].transform)
}

fn bounds(scene: &Scene) -> (DVec3, DVec3) {
    let mut low = DVec3::splat(f64::INFINITY);
    let mut high = DVec3::splat(f64::NEG_INFINITY);
    for node in &scene.nodes {
        for &p in &node.mesh.positions {
            let p = node.transform.transform_point3(p);
            (low, high) = (low.min(p), high.max(p));
        }
    }
    if low.is_finite() && high.is_finite() {
        (low, high)
    } else {
        (DVec3::ZERO, DVec3::ZERO)
    }
}

/// Where the breaks are, of several the further ones without the height of their faces.
fn breaks(broken: &Broken, middle: DVec3) -> Vec<DrawnBreak> {
    let of = |(i, wood): (usize, &greenstick::session::BrokenWood)| {
        let stem = &wood.stem;
        let frame = stem.grain.axis().frame(stem.location);
        let report = &broken.report;
        let heights = match i {
            0 => report.face.percentiles_m,
            _ => report
                .further_breaks
                .get(i - 1)
                .map_or([0.0; 2], |b| b.face.percentiles_m),
        };
        DrawnBreak {
            place: (frame.origin - middle).as_vec3(),
            along: frame.tangent.as_vec3(),
            across: [frame.x, frame.y].map(|v| v.as_vec3()),
            radius: stem.radius as f32,
            heights: heights.map(|h| h as f32),
            length: stem.location as f32,
        }
    };
    broken.woods.iter().enumerate().map(of).collect()
}
