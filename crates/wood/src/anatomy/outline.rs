//! Outlines of a mesh's sections, square to the stem (forests-2023 §3.1, where volumes of a whole model's box were cut
//! by the world's axes instead).
//!
//! Triangles that meet the plane come from a tree; their cuts are joined through the edges they share. Where the mesh has
//! a hole the ends of the line are joined straight across, the nearest first, and the length so guessed is told.

use crate::polygon;
use crate::stem::Frame;
use glam::{DVec2, DVec3};
use greenstick_geometry::{Aabb, Bvh, Mesh};

/// The part of a mesh that is cut into sections.
#[derive(Debug, Clone)]
pub struct Slicer {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    tree: Bvh,
    /// Whether all of it is one board rather than a stem and what grows beside it.
    board: bool,
}

/// A section's outline in a frame's (x, y), m.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// Closed loops: the stem's own first, counter-clockwise; then hollows in it and small parts of relief beside it.
    pub loops: Vec<Vec<DVec2>>,
    /// How many loops from the first on are the stem's own: one but for a board with slots, which may fall into several.
    pub parts: usize,
    /// Area within the stem's own loops, m²; of a board without its hollows.
    pub area: f64,
    /// Centroid of the first loop, m.
    pub centroid: DVec2,
    /// Length of the stem's own loops, m.
    pub girth: f64,
    /// Part of the girth that was guessed across holes of the mesh, 0 to 1.
    pub guessed: f64,
}

/// Loops beside the stem's own that are larger than this part of it are another limb, not relief.
const RELIEF: f64 = 0.1;
/// How far from the centroid, in the loop's largest radii, relief may lie beside the stem's loop.
const BESIDE: f64 = 1.2;
/// Open pieces of a section's line beyond this number are left out, the shortest first: a soup has no outline.
const MOST_PIECES: usize = 256;

/// A piece of a section's line.
struct Chain {
    points: Vec<DVec2>,
    closed: bool,
    guessed: f64,
}

/// A triangle's cut: the edges it runs between, and where.
struct Piece {
    edges: [u64; 2],
    at: [DVec2; 2],
}

impl Outline {
    /// The points of the stem's own loops.
    pub fn points(&self) -> impl Iterator<Item = DVec2> {
        self.loops[..self.parts].iter().flatten().copied()
    }

    /// Whether one of the stem's own loops holds `p`.
    pub fn holds(&self, p: DVec2) -> bool {
        self.loops[..self.parts]
            .iter()
            .any(|l| polygon::contains(l, p))
    }
}

impl Slicer {
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
        Slicer {
            tree: Bvh::new(&boxes),
            points,
            triangles,
            board,
        }
    }

    /// The outline in the plane of `frame`: the loop that holds the frame's origin, or else the one nearest to it.
    pub fn outline(&self, frame: &Frame) -> Option<Outline> {
        let chains = close(chain(self.pieces(frame)));
        let areas: Vec<f64> = chains
            .iter()
            .map(|c| polygon::area_and_centroid(&c.points).0)
            .collect();
        let largest = areas.iter().map(|a| a.abs()).fold(0.0, f64::max);
        let rank = |k: &usize| {
            if polygon::contains(&chains[*k].points, DVec2::ZERO) {
                // Within: the largest comes first.
                -areas[*k].abs()
            } else {
                polygon::distance(&chains[*k].points, DVec2::ZERO)
            }
        };
        let main = (0..chains.len())
            .filter(|&k| areas[k].abs() > 0.01 * largest)
            .min_by(|a, b| rank(a).total_cmp(&rank(b)))?;
        let area = areas[main].abs();
        let (mut own, gap) = (chains[main].points.clone(), chains[main].guessed);
        if areas[main] < 0.0 {
            own.reverse();
        }
        let (_, centroid) = polygon::area_and_centroid(&own);
        let radius = own.iter().map(|p| p.distance(centroid)).fold(0.0, f64::max);
        let girth = polygon::perimeter(&own);
        if !(area > 0.0 && girth > 0.0) {
            return None;
        }
        if self.board {
            return Some(whole(own, main, chains, centroid));
        }
        let mut loops = vec![own];
        for (k, other) in chains.into_iter().enumerate() {
            let Some(&first) = other.points.first() else {
                continue;
            };
            if k == main {
                continue;
            }
            let within = polygon::contains(&loops[0], first);
            let beside =
                areas[k].abs() < RELIEF * area && first.distance(centroid) < BESIDE * radius;
            if within || beside {
                loops.push(other.points);
            }
        }
        let guessed = gap / girth;
        Some(Outline {
            loops,
            parts: 1,
            area,
            centroid,
            girth,
            guessed,
        })
    }

    fn pieces(&self, frame: &Frame) -> Vec<Piece> {
        let height = |p: u32| (self.points[p as usize] - frame.origin).dot(frame.tangent);
        let mut pieces = Vec::new();
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
                // Taken from the lower number to the higher: the neighbour gets the same point to the last bit.
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
            pieces.push(Piece {
                edges: ends.map(|e| e.0),
                at: ends.map(|e| e.1),
            });
        });
        pieces
    }
}

/// The outline of all loops of a board's section, `own` standing for the loop `main`.
fn whole(own: Vec<DVec2>, main: usize, chains: Vec<Chain>, centroid: DVec2) -> Outline {
    let guessed: f64 = chains.iter().map(|c| c.guessed).sum();
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
    let (parts, girth) = (own.len(), own.iter().map(|l| polygon::perimeter(l)).sum());
    own.append(&mut hollows);
    Outline {
        loops: own,
        parts,
        area,
        centroid,
        girth,
        guessed: guessed / girth,
    }
}

/// Joins cuts through shared edges: open lines first, from their ends, then what is left as closed ones.
fn chain(pieces: Vec<Piece>) -> Vec<Chain> {
    let mut ends: Vec<(u64, u32)> = pieces
        .iter()
        .enumerate()
        .flat_map(|(i, p)| p.edges.map(|e| (e, i as u32)))
        .collect();
    ends.sort_unstable();
    let range = |edge: u64| {
        let low = ends.partition_point(|e| e.0 < edge);
        low..low + ends[low..].iter().take_while(|e| e.0 == edge).count()
    };
    let mut used = vec![false; pieces.len()];
    let mut starts: Vec<(u64, u32)> = Vec::new();
    let mut k = 0;
    while k < ends.len() {
        let all = range(ends[k].0);
        if all.len() % 2 == 1 {
            starts.push(ends[k]);
        }
        k = all.end;
    }
    starts.extend(
        pieces
            .iter()
            .enumerate()
            .map(|(i, p)| (p.edges[0], i as u32)),
    );
    let mut chains = Vec::new();
    for (start, first) in starts {
        if used[first as usize] {
            continue;
        }
        let mut points = Vec::new();
        let (mut edge, mut next) = (start, Some(first));
        while let Some(i) = next {
            used[i as usize] = true;
            let piece = &pieces[i as usize];
            let side = usize::from(piece.edges[0] != edge);
            if points.is_empty() {
                points.push(piece.at[side]);
            }
            points.push(piece.at[1 - side]);
            edge = piece.edges[1 - side];
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
            guessed: 0.0,
        });
    }
    chains
}

/// Joins the ends of open lines, the nearest first.
fn close(mut chains: Vec<Chain>) -> Vec<Chain> {
    let length = |c: &Chain| {
        c.points
            .windows(2)
            .map(|w| w[0].distance(w[1]))
            .sum::<f64>()
    };
    let (mut done, mut open): (Vec<Chain>, Vec<Chain>) = chains.drain(..).partition(|c| c.closed);
    open.sort_by(|a, b| length(b).total_cmp(&length(a)));
    open.truncate(MOST_PIECES);
    // Ends are numbered 2·line for its first point and 2·line + 1 for its last.
    let end = |e: usize| {
        let points = &open[e / 2].points;
        if e.is_multiple_of(2) {
            points[0]
        } else {
            points[points.len() - 1]
        }
    };
    let count = 2 * open.len();
    let mut pairs: Vec<(f64, usize, usize)> = (0..count)
        .flat_map(|a| (a + 1..count).map(move |b| (a, b)))
        .map(|(a, b)| (end(a).distance(end(b)), a, b))
        .collect();
    pairs.sort_by(|p, q| p.0.total_cmp(&q.0).then((p.1, p.2).cmp(&(q.1, q.2))));
    let mut partner = vec![usize::MAX; count];
    for &(_, a, b) in &pairs {
        if partner[a] == usize::MAX && partner[b] == usize::MAX {
            (partner[a], partner[b]) = (b, a);
        }
    }
    let mut taken = vec![false; open.len()];
    for line in 0..open.len() {
        let (mut points, mut guessed, mut from) = (Vec::new(), 0.0, 2 * line);
        while !taken[from / 2] {
            taken[from / 2] = true;
            let piece = &open[from / 2].points;
            if from.is_multiple_of(2) {
                points.extend(piece.iter().copied());
            } else {
                points.extend(piece.iter().rev().copied());
            }
            let to = from ^ 1;
            guessed += end(to).distance(end(partner[to]));
            from = partner[to];
        }
        if points.len() > 2 {
            done.push(Chain {
                points,
                closed: true,
                guessed,
            });
        }
    }
    done
}
