//! The rods near each vertex of a film's pieces: what the wood's strain and damage are on the skin, and how well the skin follows
//! the rods.

use super::run::Run;
use crate::WoodField;
use glam::{DVec3, IVec3};
use greenstick_fibre::store::Frame;
use greenstick_geometry::{Attribute, Film, Mesh, Node};
use rustc_hash::FxHashMap;

/// Vertices of rods that count at one of the skin.
const MAX_NEARBY: usize = 6;
/// Distance across the rods over which their weight falls by e, in mean distances of rods.
const WIDTH: f64 = 0.6;
/// The skin is off where rods are farther from it than at rest by this share of the stem's radius.
const OFF: f64 = 0.2;
/// Vertices of a piece that are looked at for that.
const MAX_SAMPLES: usize = 4000;
/// Wood of which more than this share of the surface would not be where its rods are is split lengthwise, and shown by its rods …
const SPLIT_SHARE: f64 = 0.05;
/// … and the same where it is in two.
const SPLIT_IN_TWO: f64 = 0.1;

/// For each vertex of the pieces of a film, vertices of the unbroken rods near it at rest, with weights that add up to 1.
pub struct NearbyRods {
    pieces: Vec<Vec<[(u32, f32); MAX_NEARBY]>>,
}

/// The vertices of a bundle at rest in the film's coordinates, in cells of a grid.
struct RestGrid {
    cell: f64,
    cells: FxHashMap<IVec3, Vec<u32>>,
    /// Per vertex: its place, and the direction of its rod.
    vertices: Vec<(DVec3, DVec3)>,
    spacing: f64,
}

impl RestGrid {
    fn new(run: &Run) -> Self {
        let bundle = &run.wood.bundle;
        let placement = &run.placement;
        let mut vertices = Vec::with_capacity(bundle.vertices());
        let mut longest = 0.0f64;
        for rod in 0..bundle.rods() {
            let range = bundle.rod(rod);
            for v in range.clone() {
                let (before, after) = (v.max(range.start + 1) - 1, (v + 1).min(range.end - 1));
                let way = bundle.rest.get(after) - bundle.rest.get(before);
                let at = placement.point(bundle.rest.get(v));
                vertices.push((at, placement.direction(way.normalize_or_zero())));
                if v + 1 < range.end {
                    longest = longest.max(bundle.rest_length[v]);
                }
            }
        }
        let spacing = run.wood().spacing();
        let cell = longest.max(spacing);
        let mut cells: FxHashMap<IVec3, Vec<u32>> = FxHashMap::default();
        for (v, (at, _)) in vertices.iter().enumerate() {
            cells
                .entry((*at / cell).floor().as_ivec3())
                .or_default()
                .push(v as u32);
        }
        RestGrid {
            cell,
            cells,
            vertices,
            spacing,
        }
    }

    /// Returns the vertices that count most at a point.
    fn near(&self, point: DVec3) -> [(u32, f32); MAX_NEARBY] {
        let middle = (point / self.cell).floor().as_ivec3();
        let mut best = [(u32::MAX, f64::INFINITY); MAX_NEARBY];
        for k in 0..27 {
            let at = middle + IVec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
            for &v in self.cells.get(&at).into_iter().flatten() {
                let (place, direction) = self.vertices[v as usize];
                let way = point - place;
                let along = way.dot(direction);
                let across = (way - direction * along).length() / (WIDTH * self.spacing);
                let off = along / self.cell;
                let entry = (v, across * across + off * off);
                let to = best.partition_point(|b| (b.1, b.0) < (entry.1, v));
                if to < MAX_NEARBY {
                    best[to..].rotate_right(1);
                    best[to] = entry;
                }
            }
        }
        let found = best.iter().filter(|b| b.0 != u32::MAX);
        let weights = found.clone().map(|b| libm::exp(best[0].1 - b.1));
        let sum: f64 = weights.clone().sum();
        let mut near = [(0, 0.0); MAX_NEARBY];
        for ((to, (v, _)), weight) in near.iter_mut().zip(found).zip(weights) {
            *to = (*v, (weight / sum) as f32);
        }
        near
    }
}

impl NearbyRods {
    /// Sets a field, given at the vertices of the unbroken rods, at those of the film's pieces, which are the first of `nodes`.
    pub fn set_field(&self, field: WoodField, values: &[f64], nodes: &mut [Node]) {
        for (node, near) in nodes.iter_mut().zip(&self.pieces) {
            let value = |near: &[(u32, f32); MAX_NEARBY]| {
                let sum = near
                    .iter()
                    .map(|&(v, weight)| f64::from(weight) * values[v as usize]);
                sum.sum::<f64>() as f32
            };
            let attribute = Attribute {
                width: 1,
                data: near.iter().map(value).collect(),
            };
            let mesh: &mut Mesh = std::sync::Arc::make_mut(&mut node.mesh);
            mesh.attributes.insert(field.attribute().into(), attribute);
        }
    }
}

impl Run {
    /// Returns the rods near each vertex of a film's pieces.
    pub fn nearby_rods(&self, film: &Film) -> NearbyRods {
        let grid = RestGrid::new(self);
        let near = |mesh: &Mesh| mesh.positions.iter().map(|&p| grid.near(p)).collect();
        NearbyRods {
            pieces: film.pieces.iter().map(|piece| near(&piece.mesh)).collect(),
        }
    }

    /// Returns a field of the wood in a frame, at the vertices of the unbroken rods.
    pub fn field(&self, field: WoodField, frame: &Frame) -> Vec<f64> {
        match field {
            WoodField::Strain => self.strain_ratios(frame),
            WoodField::Damage => self.damage(frame),
        }
    }

    fn strain_ratios(&self, frame: &Frame) -> Vec<f64> {
        let bundle = &self.wood.bundle;
        let strains = self.rod_lines(frame).strains;
        let mut ratios = vec![0.0f64; bundle.vertices()];
        for (&origin, strain) in frame.origin.iter().zip(strains) {
            let v = origin as usize;
            let limit = if strain > 0.0 {
                bundle.tension_limit[v]
            } else {
                bundle.yield_strain[v]
            };
            let value = strain / limit;
            // Of the two ends of a broken rod the one that bears more.
            if limit > 0.0 && value.abs() > ratios[v].abs() {
                ratios[v] = value;
            }
        }
        ratios
    }

    fn damage(&self, frame: &Frame) -> Vec<f64> {
        let bundle = &self.wood.bundle;
        let count = |bonds: &mut dyn Iterator<Item = [u32; 2]>| {
            let mut counts = vec![0u32; bundle.vertices()];
            for [vertex, edge] in bonds {
                for v in [vertex, edge, edge + 1] {
                    if let Some(count) = counts.get_mut(v as usize) {
                        *count += 1;
                    }
                }
            }
            counts
        };
        let bonds = &bundle.bonds;
        let whole = count(&mut bonds.vertex.iter().zip(&bonds.edge).map(|(&v, &e)| [v, e]));
        let origin = |v: u32| frame.origin[v as usize];
        let held = count(&mut frame.bonds.iter().map(|&[v, e]| [origin(v), origin(e)]));
        let mut ends = vec![0u32; bundle.vertices()];
        frame.origin.iter().for_each(|&v| ends[v as usize] += 1);
        let damage = |v: usize| match (ends[v], whole[v]) {
            (0 | 1, 0) => 0.0,
            (0 | 1, all) => (1.0 - f64::from(held[v]) / f64::from(all)).max(0.0),
            _ => 1.0,
        };
        (0..bundle.vertices()).map(damage).collect()
    }

    /// Returns which share of the surface of the pieces, the first of `nodes`, is not where the rods are in the frame that `nodes`
    /// show: what is split lengthwise without a face between. It is that of some vertices, evenly chosen, of the wood that the rods
    /// fill: the rest of a tree goes with it as a whole.
    pub fn misplaced_share(&self, film: &Film, frame: &Frame, nodes: &[Node]) -> f64 {
        let grid = RestGrid::new(self);
        let mut shown = vec![Vec::new(); self.wood.bundle.vertices()];
        for (&origin, place) in frame.origin.iter().zip(&frame.position) {
            shown[origin as usize].push(
                self.placement
                    .point(DVec3::from_array(place.map(f64::from))),
            );
        }
        let limit = OFF * self.wood.stem.radius;
        // The skin of the rods is no farther from their vertices; beyond are other limbs of a tree.
        let beside = 0.5 * grid.cell + grid.spacing;
        let (mut off, mut all) = (0.0, 0.0);
        let shown_nodes = film.pieces.iter().zip(nodes);
        for (piece, node) in shown_nodes.filter(|(piece, _)| !piece.is_detail) {
            let mesh = &piece.mesh;
            let areas = vertex_areas(mesh);
            for i in (0..areas.len()).step_by(areas.len().div_ceil(MAX_SAMPLES).max(1)) {
                let (at_rest, now) = (mesh.positions[i], node.mesh.positions[i]);
                let near = grid.near(at_rest);
                let nearest = grid.vertices[near[0].0 as usize].0;
                if at_rest.distance(nearest) > beside {
                    continue;
                }
                let is_placed = near.iter().any(|&(v, weight)| {
                    let before = at_rest.distance(grid.vertices[v as usize].0);
                    let shown = &shown[v as usize];
                    weight > 0.0 && shown.iter().any(|p| now.distance(*p) < before + limit)
                });
                off += if is_placed { 0.0 } else { areas[i] };
                all += areas[i];
            }
        }
        off / f64::max(all, f64::MIN_POSITIVE)
    }
}

/// Whether drawn faces that misplace a share of the wood's surface show a run better than its rods do. Where the wood is in two the
/// faces are most of what there is to see, and a split that runs on beyond them is less; where it hangs together the split is what
/// happened.
pub fn shows_well(misplaced: f64, in_two: bool) -> bool {
    misplaced <= if in_two { SPLIT_IN_TWO } else { SPLIT_SHARE }
}

/// Returns the area of the triangles at each vertex of a mesh, m².
fn vertex_areas(mesh: &Mesh) -> Vec<f64> {
    let mut areas = vec![0.0; mesh.positions.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(t);
        let area = (b - a).cross(c - a).length();
        triangle.iter().for_each(|&v| areas[v as usize] += area);
    }
    areas
}
