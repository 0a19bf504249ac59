//! What is drawn of a change before its pieces are finished: the cut itself, in the scene of the answer before.
//!
//! To finish pieces – repairing what crosses, splinters that come loose, the report – takes many times as long as to cut them.
//! While only the face of a break changes, or how far its pieces are apart, everything else that is drawn is still that of the last
//! finished answer.

use super::early_faces::{Faces, Moved, Standing};
use super::meshes::{Batch, DrawnScene, Vertex, drawn_vertices};
use glam::{DAffine3, Vec3};
use greenstick::BreakRequest;
use greenstick::fracture::cut::Side;
use greenstick::fracture::height_grid::HeightGrid;
use greenstick::fracture::parameters::BreakParameters;
use greenstick::geometry::mesh::NO_MATERIAL;
use greenstick::geometry::{Mesh, Scene};
use greenstick::session::{BreakStages, Broken, NodeRole, PieceRole};
use greenstick::skin::broken::smooth_normals;
use greenstick::skin::prepared::PreparedStem;
use greenstick::wood::appearance::StemAppearance;
use greenstick::wood::tissue::Zone;
use std::collections::BTreeMap;
use std::sync::Arc;

/// How far below a face that changes a piece stays as it was, radii of the stem: farther than a triangle of the skin is long.
const KEPT: f64 = 0.3;

/// "Not drawn yet".
const NONE: u32 = u32::MAX;

/// What a finished answer draws but for the two pieces, and what their skin is made of.
#[derive(Debug)]
pub struct Surroundings {
    /// The request but for its face, and what wood and bark look like.
    request: BreakRequest,
    appearance: StemAppearance,
    stem: Arc<PreparedStem>,
    /// Everything that is not one of the two pieces; without indices.
    others: DrawnScene,
    /// Corners of the triangles of others, by material.
    corners: BTreeMap<u32, Vec<u32>>,
    /// A batch of each material, without triangles.
    batches: BTreeMap<u32, Batch>,
    /// The vertices of the mesh that is cut, in its own coordinates.
    skin: Vec<Vertex>,
    /// The material of triangles that came without.
    bark: u32,
    /// Both pieces, the lower one first.
    pieces: [Standing; 2],
    /// The number of the break among those of the request.
    number: usize,
    /// How far apart the pieces of the only break were to be, m; none where there are others.
    way: Option<f64>,
    /// The lower piece as it was, where another break ends it.
    ended: Option<EndedPiece>,
}

/// The piece below a break, which another break ends that is nearer to the base. Of it what lies far from the changing face stays.
#[derive(Debug)]
struct EndedPiece {
    /// Its triangles, whose vertices are among those of the others, and their materials.
    triangles: Vec<(u32, [u32; 3])>,
    /// The lowest point of the face that it had, m from the break along the grain.
    low: f64,
    /// Its motion from where it was in the unbroken scene.
    motion: DAffine3,
}

/// A finished answer with several breaks.
#[derive(Debug)]
pub struct FinishedBreaks {
    /// What was asked for.
    pub request: BreakRequest,
    /// The pieces.
    pub scene: Scene,
    /// What each node of the scene is.
    pub roles: Vec<NodeRole>,
    /// The scene as it was drawn.
    pub drawn: DrawnScene,
}

impl FinishedBreaks {
    /// The only break whose face is another in a request; `None` where more is another, or nothing.
    pub fn changed(&self, request: &BreakRequest) -> Option<usize> {
        let (before, after) = (&self.request.breaks, &request.breaks);
        let same = before.len() == after.len() && request.every.is_none();
        if !same || without_faces(request) != without_faces(&self.request) {
            return None;
        }
        let mut changed = (0..before.len()).filter(|&i| before[i] != after[i]);
        let first = changed.next()?;
        (changed.next().is_none() && after[first].triangles.is_none()).then_some(first)
    }
}

impl Surroundings {
    /// What a finished answer, drawn as `drawn`, leaves for the changes to come. `None` where the two pieces are not all that a
    /// change of the face changes.
    pub fn new(
        request: &BreakRequest,
        broken: &Broken,
        drawn: &DrawnScene,
        stages: &BreakStages,
    ) -> Option<Self> {
        let stem = &stages.stem.sound;
        let face = face_of(request, 0)?;
        if request.breaks.len() > 1 || changes_more_than_faces(face, stages) {
            return None;
        }
        let scene = &broken.scene;
        let mut others = DrawnScene {
            vertices: Vec::new(),
            indices: Vec::new(),
            batches: Vec::new(),
            ..drawn.clone()
        };
        let mut corners = BTreeMap::new();
        let mut pieces = [None; 2];
        let mut bark = NO_MATERIAL;
        let mut number = 0.0;
        for (node, role) in scene.nodes.iter().zip(&broken.roles) {
            match role {
                NodeRole::Piece(PieceRole::Segment(_)) => return None,
                NodeRole::Piece(role) => {
                    number += 1.0;
                    let half = match role {
                        PieceRole::Lower => 0,
                        PieceRole::Upper => 1,
                        // It is part of the face again until the answer is finished.
                        _ => continue,
                    };
                    pieces[half] = Some(Standing {
                        number,
                        transform: node.transform,
                    });
                    // The skin comes first in a piece.
                    bark = node.mesh.material(0);
                }
                // The strands of a face that is being changed are drawn when it is finished.
                NodeRole::Fuzz(_) => {}
                NodeRole::Carried => others.push(node, 2.0, &mut corners),
                NodeRole::Untouched => others.push(node, 0.0, &mut corners),
            }
        }
        let batches = drawn.batches.iter().map(|b| (b.material, b.clone()));
        let batches = batches.collect();
        let [Some(lower), Some(upper)] = pieces else {
            return None;
        };
        Some(Surroundings {
            request: without_way(without_face(request, 0)),
            way: Some(request.breaks[0].separation),
            appearance: appearance(request, 0, stages)?,
            skin: skin_vertices(stem),
            stem: stem.clone(),
            others,
            corners,
            batches,
            bark,
            pieces: [lower, upper],
            number: 0,
            ended: None,
        })
    }

    /// What a finished answer leaves for changes of one of its breaks, with the stages that this had. `None` where the pieces beside
    /// the break are not all that a change of its face changes.
    pub fn of_one(finished: &FinishedBreaks, number: usize, stages: &BreakStages) -> Option<Self> {
        let FinishedBreaks {
            request,
            scene,
            roles,
            drawn,
        } = finished;
        let stem = &stages.stem.sound;
        if changes_more_than_faces(face_of(request, number)?, stages) {
            return None;
        }
        let below = drawn.piece_below(number)?;
        let above = below + 1;
        // Pieces are the first nodes, and the first piece of what is drawn is what no break touched.
        let [lower, upper] = [below, above].map(|piece| {
            let node = scene.nodes.get(piece - 1)?;
            // Both have the face: on another limb, the piece below would be another one.
            let has_face = node.mesh.materials.contains(&stages.stem.inner_material);
            let is_segment = matches!(roles[piece - 1], NodeRole::Piece(PieceRole::Segment(_)));
            (has_face && is_segment).then_some(Standing {
                number: piece as f32,
                transform: node.transform,
            })
        });
        let is_last = matches!(roles[below - 1], NodeRole::Piece(PieceRole::Segment(0)));
        let mut corners: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let mut triangles = Vec::new();
        let pieces = piece_of_vertices(scene, roles);
        for batch in &drawn.batches {
            let range = batch.first as usize..(batch.first + batch.count) as usize;
            for t in drawn.indices[range].as_chunks::<3>().0 {
                // What lies between the stem and its limbs may have vertices after those of the nodes, though not three.
                let piece = t.iter().find_map(|&v| pieces.get(v as usize));
                match piece.copied().flatten() {
                    Some(piece) if piece == above => {}
                    Some(piece) if piece == below && is_last => {}
                    Some(piece) if piece == below => triangles.push((batch.material, *t)),
                    _ => corners.entry(batch.material).or_default().extend(t),
                }
            }
        }
        let batches = drawn.batches.iter().map(|b| (b.material, b.clone()));
        Some(Surroundings {
            request: without_face(request, number),
            way: None,
            appearance: appearance(request, number, stages)?,
            skin: skin_vertices(stem),
            stem: stem.clone(),
            corners,
            batches: batches.collect(),
            others: DrawnScene {
                indices: Vec::new(),
                batches: Vec::new(),
                ..drawn.clone()
            },
            bark: scene.nodes[below - 1].mesh.material(0),
            pieces: [lower?, upper?],
            number,
            ended: (!is_last).then(|| EndedPiece {
                triangles,
                low: stages.heights.heights.range.0,
                motion: drawn.pieces[below].motion,
            }),
        })
    }

    /// The number of the break whose face may change.
    pub fn number(&self) -> usize {
        self.number
    }

    /// Whether a request leaves all of this as it is, as far as that can be told without breaking anything.
    pub fn may_hold_for(&self, request: &BreakRequest) -> bool {
        let rest = without_face(request, self.number);
        let rest = match self.way {
            Some(_) => without_way(rest),
            None => rest,
        };
        face_of(request, self.number).is_some() && rest == self.request
    }

    /// Whether a request with these stages leaves all of this as it is.
    pub fn hold_for(&self, request: &BreakRequest, stages: &BreakStages) -> bool {
        let face = face_of(request, self.number);
        self.may_hold_for(request)
            && Arc::ptr_eq(&self.stem, &stages.stem.sound)
            && face.is_some_and(|face| !changes_more_than_faces(face, stages))
            && appearance(request, self.number, stages).as_ref() == Some(&self.appearance)
    }

    /// The plane below which the lower piece stays as it was, where another break ends it: a point and the direction upwards.
    fn bound(&self, stages: &BreakStages) -> Option<(Vec3, Vec3)> {
        let ended = self.ended.as_ref()?;
        let stem = &stages.stem.stem().found.stem;
        let low = ended.low.min(stages.heights.heights.range.0) - KEPT * stem.radius;
        let frame = stem.grain.axis().frame(stem.location + low);
        let point = ended.motion.transform_point3(frame.origin) - self.others.middle;
        let up = ended.motion.transform_vector3(frame.tangent);
        Some((point.as_vec3(), up.as_vec3()))
    }

    /// Where the pieces of a request stand, and the motion of the upper one where that is another than it was.
    fn standing(
        &self,
        request: &BreakRequest,
        stages: &BreakStages,
    ) -> ([Standing; 2], Option<DAffine3>) {
        let way = request.breaks.get(self.number).map(|one| one.separation);
        let mut pieces = self.pieces;
        if self.way.is_none() || way == self.way {
            return (pieces, None);
        }
        let motion = stages.motion_apart(way.unwrap_or_default());
        pieces[1].transform = motion * *stages.stem.stem().transform();
        (pieces, Some(motion))
    }

    /// The scene with the pieces of a request; `None` where it has a material that the scene had not.
    pub fn drawn(&self, request: &BreakRequest, stages: &BreakStages) -> Option<DrawnScene> {
        let inner = stages.inner_wood(&stages.stem.face);
        let addresses = stages.cut.face.addresses(&inner);
        let mut out = self.others.clone();
        let (pieces, motion) = self.standing(request, stages);
        if let (Some(motion), Some(upper)) = (motion, out.pieces.get_mut(pieces[1].number as usize))
        {
            upper.motion = motion;
        }
        let mut corners = self.corners.clone();
        let bound = self.bound(stages);
        if let (Some(ended), Some(bound)) = (&self.ended, bound) {
            for (material, t) in &ended.triangles {
                if t.iter()
                    .all(|&v| !is_above(bound, &out.vertices[v as usize]))
                {
                    corners.entry(*material).or_default().extend(t);
                }
            }
        }
        let (cut, wood) = (&stages.cut.face, stages.stem.inner_material);
        let skin = self.skin.len() + 2 * cut.patch.vertices.len();
        out.vertices.reserve(skin + 2 * cut.face.ids.len());
        for (half, piece) in pieces.into_iter().enumerate() {
            let mut builder = PieceBuilder::new(self, stages, piece, half == 1, &mut out);
            builder.bound = bound.filter(|_| half == 0);
            builder.skin(&mut corners);
        }
        let faces = Faces {
            stages,
            moved: pieces.map(|piece| Moved::new(piece, out.middle)),
            first: out.vertices.len() as u32,
        };
        faces.add_vertices(&addresses, &mut out.vertices);
        corners.entry(wood).or_default();
        let count = corners.values().map(Vec::len).sum::<usize>();
        (out.indices).reserve(count + 6 * cut.face.triangles.len());
        for (material, corners) in corners {
            let batch = self.batches.get(&material)?;
            let first = out.indices.len();
            out.indices.extend(corners);
            if material == wood {
                faces.add_corners(&mut out.indices);
            }
            out.batches.push(Batch {
                first: first as u32,
                count: (out.indices.len() - first) as u32,
                ..batch.clone()
            });
        }
        out.place_limbs();
        Some(out)
    }
}

/// The piece of the scene that is drawn that each vertex of it belongs to, strands included; none of what is no piece.
fn piece_of_vertices(scene: &Scene, roles: &[NodeRole]) -> Vec<Option<usize>> {
    let mut pieces = Vec::new();
    for (at, (node, role)) in scene.nodes.iter().zip(roles).enumerate() {
        let piece = match role {
            NodeRole::Piece(_) => Some(at + 1),
            NodeRole::Fuzz(_) => node.parent.map(|parent| parent + 1),
            NodeRole::Carried | NodeRole::Untouched => None,
        };
        pieces.resize(pieces.len() + node.mesh.positions.len(), piece);
    }
    pieces
}

/// Whether a vertex lies above a plane.
fn is_above((point, up): (Vec3, Vec3), vertex: &Vertex) -> bool {
    (Vec3::from_array(vertex.position) - point).dot(up) >= 0.0
}

/// The parameters of a face of a request whose breaks were listed one by one.
fn face_of(request: &BreakRequest, number: usize) -> Option<&BreakParameters> {
    let one = request.breaks.get(number)?;
    (request.every.is_none() && one.triangles.is_none()).then_some(&one.recipe.face)
}

/// A request without one of its faces.
fn without_face(request: &BreakRequest, number: usize) -> BreakRequest {
    let mut rest = request.clone();
    if let Some(one) = rest.breaks.get_mut(number) {
        one.recipe.face = BreakParameters::default();
        one.heights = HeightGrid::default();
    }
    rest
}

/// A request without how far the pieces of its first break are apart.
fn without_way(mut request: BreakRequest) -> BreakRequest {
    if let Some(one) = request.breaks.first_mut() {
        (one.separation, one.part_clear) = (0.0, false);
    }
    request
}

/// A request without any of its faces.
fn without_faces(request: &BreakRequest) -> BreakRequest {
    (0..request.breaks.len()).fold(request.clone(), |rest, i| without_face(&rest, i))
}

/// Whether such a break changes more of the stem than its two faces.
fn changes_more_than_faces(face: &BreakParameters, stages: &BreakStages) -> bool {
    face.hang > 0.0 || stages.cracks.is_some() || stages.stem.opened.is_some()
}

/// What the wood and the bark of a break look like; `None` where that cannot be told.
fn appearance(
    request: &BreakRequest,
    number: usize,
    stages: &BreakStages,
) -> Option<StemAppearance> {
    let recipe = &request.breaks.get(number)?.recipe;
    stages.stem.appearance(recipe).ok()
}

/// The vertices of the mesh that is cut, in its own coordinates, with what pieces get where it has nothing.
fn skin_vertices(stem: &PreparedStem) -> Vec<Vertex> {
    let mesh: &Mesh = &stem.node().mesh;
    let mut vertices: Vec<Vertex> = drawn_vertices(mesh).collect();
    if !mesh.attributes.contains_key("NORMAL") {
        let normals = smooth_normals(&mesh.positions, &mesh.triangles);
        for (vertex, normal) in vertices.iter_mut().zip(normals) {
            vertex.normal = normal;
        }
    }
    let has_zones = mesh.attributes.contains_key("_ZONE");
    let has_grain = mesh.attributes.contains_key("_GRAIN");
    for (vertex, &point) in vertices.iter_mut().zip(&stem.points) {
        let grain = stem.grain[point as usize];
        if !has_grain && grain.is_finite() {
            vertex.set_grain(grain.as_vec3());
        }
        if !has_zones {
            vertex.zone_piece[0] = f32::from(Zone::Bark.code());
        }
    }
    vertices
}

/// Draws one piece.
struct PieceBuilder<'a> {
    around: &'a Surroundings,
    stages: &'a BreakStages,
    upper: bool,
    out: &'a mut DrawnScene,
    /// Number of each vertex of the mesh that is cut and of the patch.
    known: Vec<u32>,
    moved: Moved,
    /// The plane above which the skin is drawn; none where all of it is.
    bound: Option<(Vec3, Vec3)>,
}

impl<'a> PieceBuilder<'a> {
    fn new(
        around: &'a Surroundings,
        stages: &'a BreakStages,
        piece: Standing,
        upper: bool,
        out: &'a mut DrawnScene,
    ) -> Self {
        let patch = &stages.cut.face.patch;
        PieceBuilder {
            around,
            stages,
            upper,
            known: vec![NONE; patch.first as usize + patch.vertices.len()],
            moved: Moved::new(piece, out.middle),
            bound: None,
            out,
        }
    }

    /// Draws the piece's share of the skin.
    fn skin(&mut self, corners: &mut BTreeMap<u32, Vec<u32>>) {
        let stages = self.stages;
        let (cut, patch) = (&stages.cut.face.cut, &stages.cut.face.patch);
        let stem = stages.stem.stem();
        let mesh = &stem.node().mesh;
        let mut list = (NO_MATERIAL, Vec::new());
        let mut add = |this: &mut Self, ids: [u32; 3], material: u32| {
            let material = match material {
                NO_MATERIAL => this.around.bark,
                known => known,
            };
            if list.0 != material {
                let before = std::mem::replace(&mut list, (material, Vec::new()));
                corners.entry(before.0).or_default().extend(before.1);
            }
            let ids = ids.map(|id| this.vertex(id));
            let above = |bound| {
                ids.iter()
                    .any(|&v| is_above(bound, &this.out.vertices[v as usize]))
            };
            if this.bound.is_none_or(above) {
                list.1.extend(ids);
            }
        };
        let side = if self.upper { Side::Upper } else { Side::Lower };
        for (t, &triangle) in mesh.triangles.iter().enumerate() {
            if cut.sides[t] == side {
                add(self, triangle, mesh.material(t));
            }
        }
        let half = usize::from(self.upper);
        for (&part, &t) in patch.parts[half].iter().zip(&patch.sources[half]) {
            add(self, part, mesh.material(t as usize));
        }
        corners.entry(list.0).or_default().extend(list.1);
        corners.retain(|_, list| !list.is_empty());
    }

    /// The number of a vertex of the mesh, or of the patch behind them, which is drawn once.
    fn vertex(&mut self, id: u32) -> u32 {
        let known = self.known[id as usize];
        if known != NONE {
            return known;
        }
        let patch = &self.stages.cut.face.patch;
        let vertex = match id.checked_sub(patch.first) {
            None => {
                let position = self.stages.stem.stem().node().mesh.positions[id as usize];
                self.moved.place(position, self.around.skin[id as usize])
            }
            Some(i) => {
                let made = &patch.vertices[i as usize];
                let [a, b, c] = made.vertices.map(|v| self.around.skin[v as usize]);
                self.moved
                    .place(made.position, Vertex::blend([a, b, c], made.weights))
            }
        };
        let number = self.out.vertices.len() as u32;
        self.out.vertices.push(vertex);
        self.known[id as usize] = number;
        number
    }
}
