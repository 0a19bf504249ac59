//! Slicing a mesh square to the stem (Forests 2023 §3.1, where volumes of a whole model's box were cut along the world's
//! axes instead).
//!
//! Triangles that meet the plane come from a tree; their cuts are chained through the edges they share. Where the mesh has
//! a hole the ends of the line are joined straight across, the nearest first, and the length so bridged is recorded.

use super::outline::Outline;
use crate::polygon;
use crate::stem::Frame;
use glam::{DVec2, DVec3};
use greenstick_geometry::{Aabb, Bvh, Mesh};

/// Loops beside the stem's own that are larger than this part of it are another limb, not relief.
const MAX_RELIEF_AREA: f64 = 0.1;
/// How far from the centroid, in the loop's largest radii, relief may lie beside the stem's loop.
const MAX_RELIEF_DISTANCE: f64 = 1.2;
/// Loops smaller than this part of the largest are not the stem.
const MIN_MAIN_AREA: f64 = 0.01;
/// Most open pieces of a section's line; the shortest beyond it are left out, as a soup has no outline.
const MAX_OPEN_PIECES: usize = 256;

/// The part of a mesh that is cut into sections.
#[derive(Debug, Clone)]
pub(super) struct SectionSlicer {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    tree: Bvh,
    /// Whether all of it is one board rather than a stem and what grows beside it.
    board: bool,
}

/// A piece of a section's line.
struct Chain {
    points: Vec<DVec2>,
    closed: bool,
    /// Length across holes, m.
    bridged: f64,
}

/// A triangle's cut: the edges it runs between, and where.
struct Cut {
    edges: [u64; 2],
    at: [DVec2; 2],
}

impl SectionSlicer {
    /// The triangles numbered in `shell` of `mesh`, which is in world metres. Of a `board` all loops of a section are
    /// wood, of a round stem only one.
    pub fn new(mesh: &Mesh, shell: &[u32], board: bool) -> Self {
        let (numbers, count) = mesh.points();
        let mut points = vec![DVec3::ZERO; count];
        for (&n, &p) in numbers.iter().zip(&mesh.positions) {
            points[n as usize] = p;
        }
        let triangles: Vec<[u32; 3]> = shell
            .iter()
            .filter_map(|&t| mesh.triangles.get(t as usize))
            .map(|t| t.map(|v| numbers[v as usize]))
            .collect();
        let boxes: Vec<Aabb> = triangles
            .iter()
            .map(|t| Aabb::around(&t.map(|p| points[p as usize])))
            .collect();
        SectionSlicer {
            tree: Bvh::new(&boxes),
            points,
            triangles,
            board,
        }
    }

    /// The outline in the plane of `frame`: the loop that contains the frame's origin, or else the one nearest to it.
    pub fn outline(&self, frame: &Frame) -> Option<Outline> {
        let chains = close(chain(self.cuts(frame)));
        let areas: Vec<f64> = chains
            .iter()
            .map(|c| polygon::area_and_centroid(&c.points).0)
            .collect();
        let main = main_loop(&chains, &areas)?;
        let area = areas[main].abs();
        let (mut own, bridged) = (chains[main].points.clone(), chains[main].bridged);
        if areas[main] < 0.0 {
            own.reverse();
        }
        let (_, centroid) = polygon::area_and_centroid(&own);
        let girth = polygon::perimeter(&own);
        if !(area > 0.0 && girth > 0.0) {
            return None;
        }
        if self.board {
            return Some(board_outline(own, main, chains, centroid));
        }
        let radius = own.iter().map(|p| p.distance(centroid)).fold(0.0, f64::max);
        let mut loops = vec![own];
        for (k, other) in chains.into_iter().enumerate() {
            let Some(&first) = other.points.first() else {
                continue;
            };
            if k == main {
                continue;
            }
            let inside = polygon::contains(&loops[0], first);
            let beside = areas[k].abs() < MAX_RELIEF_AREA * area
                && first.distance(centroid) < MAX_RELIEF_DISTANCE * radius;
            if inside || beside {
                loops.push(other.points);
            }
        }
        Some(Outline {
            loops,
            own_loops: 1,
            area,
            centroid,
            girth,
            bridged: bridged / girth,
            smoothing_residual: 0.0,
        })
    }

    /// The cuts of all triangles that meet the plane of `frame`.
    fn cuts(&self, frame: &Frame) -> Vec<Cut> {
        let height = |p: u32| (self.points[p as usize] - frame.origin).dot(frame.tangent);
        let mut cuts = Vec::new();
        self.tree.straddling(frame.origin, frame.tangent, |t| {
            let corners = self.triangles[t];
            let heights = corners.map(height);
            // A corner in the plane counts as above it, so that every cut runs from edge to edge.
            let above = heights.map(|h| h >= 0.0);
            if above[0] == above[1] && above[1] == above[2] {
                return;
            }
            let mut ends = [(0, DVec2::ZERO); 2];
            let mut found = 0;
            for k in 0..3 {
                let (i, j) = (k, (k + 1) % 3);
                if above[i] == above[j] {
                    continue;
                }
                // Interpolated from the lower number to the higher: the neighbour gets the same point to the last bit.
                let (i, j) = if corners[i] < corners[j] {
                    (i, j)
                } else {
                    (j, i)
                };
                let (a, b) = (
                    self.points[corners[i] as usize],
                    self.points[corners[j] as usize],
                );
                let p = a.lerp(b, heights[i] / (heights[i] - heights[j])) - frame.origin;
                let key = u64::from(corners[i]) << 32 | u64::from(corners[j]);
                ends[found] = (key, DVec2::new(p.dot(frame.x), p.dot(frame.y)));
                found += 1;
            }
            cuts.push(Cut {
                edges: ends.map(|e| e.0),
                at: ends.map(|e| e.1),
            });
        });
        cuts
    }
}

/// Index of the stem's own loop: the largest that contains the origin, or else the one nearest to it.
fn main_loop(chains: &[Chain], areas: &[f64]) -> Option<usize> {
    let largest = areas.iter().map(|a| a.abs()).fold(0.0, f64::max);
    let rank = |k: &usize| {
        if polygon::contains(&chains[*k].points, DVec2::ZERO) {
            -areas[*k].abs()
        } else {
            polygon::distance(&chains[*k].points, DVec2::ZERO)
        }
    };
    (0..chains.len())
        .filter(|&k| areas[k].abs() > MIN_MAIN_AREA * largest)
        .min_by(|a, b| rank(a).total_cmp(&rank(b)))
}

/// The outline of all loops of a board's section, `own` being the loop `main`.
fn board_outline(own: Vec<DVec2>, main: usize, chains: Vec<Chain>, centroid: DVec2) -> Outline {
    let bridged: f64 = chains.iter().map(|c| c.bridged).sum();
    let mut loops: Vec<Vec<DVec2>> = chains.into_iter().map(|c| c.points).collect();
    loops[main] = own;
    loops.swap(0, main);
    loops.retain(|l| l.len() > 2);
    // What lies within an odd number of the others is a hollow.
    let hollow: Vec<bool> = (0..loops.len())
        .map(|k| {
            let around = |j: &usize| *j != k && polygon::contains(&loops[*j], loops[k][0]);
            (0..loops.len()).filter(around).count() % 2 == 1
        })
        .collect();
    let size = |l: &[DVec2]| polygon::area_and_centroid(l).0.abs();
    let mut area = 0.0;
    let (mut own, mut hollows) = (Vec::new(), Vec::new());
    for (l, hollow) in loops.into_iter().zip(hollow) {
        if hollow {
            area -= size(&l);
            hollows.push(l);
        } else {
            area += size(&l);
            own.push(l);
        }
    }
    let own_loops = own.len();
    let girth = own.iter().map(|l| polygon::perimeter(l)).sum();
    own.append(&mut hollows);
    Outline {
        loops: own,
        own_loops,
        area,
        centroid,
        girth,
        bridged: bridged / girth,
        smoothing_residual: 0.0,
    }
}

/// Chains cuts through shared edges: open lines first, from their ends, then what is left as closed ones.
fn chain(cuts: Vec<Cut>) -> Vec<Chain> {
    let mut ends: Vec<(u64, u32)> = cuts
        .iter()
        .enumerate()
        .flat_map(|(i, cut)| cut.edges.map(|e| (e, i as u32)))
        .collect();
    ends.sort_unstable();
    let range = |edge: u64| {
        let low = ends.partition_point(|e| e.0 < edge);
        low..low + ends[low..].iter().take_while(|e| e.0 == edge).count()
    };
    let mut starts: Vec<(u64, u32)> = Vec::new();
    let mut k = 0;
    while k < ends.len() {
        let all = range(ends[k].0);
        if all.len() % 2 == 1 {
            starts.push(ends[k]);
        }
        k = all.end;
    }
    let first_edges = cuts.iter().enumerate();
    starts.extend(first_edges.map(|(i, cut)| (cut.edges[0], i as u32)));
    let mut used = vec![false; cuts.len()];
    let mut chains = Vec::new();
    for (start, first) in starts {
        if used[first as usize] {
            continue;
        }
        let mut points = Vec::new();
        let (mut edge, mut next) = (start, Some(first));
        while let Some(i) = next {
            used[i as usize] = true;
            let cut = &cuts[i as usize];
            let side = usize::from(cut.edges[0] != edge);
            if points.is_empty() {
                points.push(cut.at[side]);
            }
            points.push(cut.at[1 - side]);
            edge = cut.edges[1 - side];
            next = ends[range(edge)]
                .iter()
                .map(|e| e.1)
                .find(|&i| !used[i as usize]);
        }
        let closed = edge == start && points.len() > 3;
        if closed {
            points.pop();
        }
        chains.push(Chain {
            points,
            closed,
            bridged: 0.0,
        });
    }
    chains
}

/// Joins the ends of open lines, the nearest first.
fn close(chains: Vec<Chain>) -> Vec<Chain> {
    let length = |c: &Chain| {
        c.points
            .windows(2)
            .map(|w| w[0].distance(w[1]))
            .sum::<f64>()
    };
    let (mut closed, mut open): (Vec<Chain>, Vec<Chain>) =
        chains.into_iter().partition(|c| c.closed);
    open.sort_by(|a, b| length(b).total_cmp(&length(a)));
    open.truncate(MAX_OPEN_PIECES);
    // Ends are numbered 2 · line for its first point and 2 · line + 1 for its last.
    let end = |e: usize| {
        let points = &open[e / 2].points;
        if e.is_multiple_of(2) {
            points[0]
        } else {
            points[points.len() - 1]
        }
    };
    let partner = nearest_partners(2 * open.len(), end);
    let mut taken = vec![false; open.len()];
    for line in 0..open.len() {
        let (mut points, mut bridged, mut from) = (Vec::new(), 0.0, 2 * line);
        while !taken[from / 2] {
            taken[from / 2] = true;
            let piece = &open[from / 2].points;
            if from.is_multiple_of(2) {
                points.extend(piece.iter().copied());
            } else {
                points.extend(piece.iter().rev().copied());
            }
            let to = from ^ 1;
            bridged += end(to).distance(end(partner[to]));
            from = partner[to];
        }
        if points.len() > 2 {
            closed.push(Chain {
                points,
                closed: true,
                bridged,
            });
        }
    }
    closed
}

/// Pairs `count` ends, the nearest two first; the partner of each.
fn nearest_partners(count: usize, end: impl Fn(usize) -> DVec2) -> Vec<usize> {
    let mut pairs: Vec<(f64, usize, usize)> = (0..count)
        .flat_map(|a| (a + 1..count).map(move |b| (a, b)))
        .map(|(a, b)| (end(a).distance(end(b)), a, b))
        .collect();
    pairs.sort_by(|p, q| p.0.total_cmp(&q.0).then((p.1, p.2).cmp(&(q.1, q.2))));
    let mut partner = vec![usize::MAX; count];
    for (_, a, b) in pairs {
        if partner[a] == usize::MAX && partner[b] == usize::MAX {
            (partner[a], partner[b]) = (b, a);
        }
    }
    partner
}
