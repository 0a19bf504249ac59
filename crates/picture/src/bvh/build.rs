//! Builds the hierarchy: binned surface-area splits (Wald 2007), whose binary tree is then collapsed to four children per
//! node.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::bounds::{Bounds, greater, lesser};

/// Most triangles in a leaf.
pub(super) const LEAF_SIZE: usize = 4;
/// Marks the number of a leaf among those of nodes.
pub(super) const LEAF: u32 = 1 << 31;
/// Bins per axis. More of them hardly improve the tree; fewer make rays slower.
const BINS: usize = 16;
/// Nodes with fewer triangles try splits along all axes, larger ones only along the widest, which is nearly always best
/// there.
const MAX_ALL_AXES: usize = 16_384;
/// Fewest triangles of a subtree that is built in parallel.
const MIN_PARALLEL: usize = 16_384;
/// Beyond this depth nodes are halved by count, which bounds the depth and with it the stack of a traversal.
const MAX_BINNED_DEPTH: usize = 32;

/// The nodes of the hierarchy, the root first, and the triangles in the order of its leaves.
pub(super) struct Tree {
    pub nodes: Vec<Node>,
    /// The first and the number of the triangles of each leaf.
    pub leaves: Vec<(u32, u32)>,
    /// Index in the original list of each triangle.
    pub order: Vec<u32>,
}

/// A triangle while the hierarchy is built.
#[derive(Clone, Copy)]
struct Reference {
    bounds: Bounds,
    triangle: u32,
}

/// A node of the binary tree, in preorder: the left child follows its parent, the right child is `right` nodes after it.
/// Leaves have `count` > 0 triangles from `start` on.
struct BinaryNode {
    bounds: Bounds,
    right: u32,
    start: u32,
    count: u32,
}

/// A node with four children: other nodes, or leaves, marked by [`LEAF`]. Absent children have empty boxes, which no ray hits.
#[derive(Clone, Copy)]
pub(super) struct Node {
    pub low: [Vec4; 3],
    pub high: [Vec4; 3],
    pub child: [u32; 4],
}

/// Builds the hierarchy. Corners must be finite.
pub(super) fn build(triangles: &[[Vec3; 3]]) -> Tree {
    let mut references: Vec<Reference> = triangles
        .par_iter()
        .enumerate()
        .map(|(i, [a, b, c])| Reference {
            bounds: Bounds {
                low: a.min(*b).min(*c).to_array(),
                high: a.max(*b).max(*c).to_array(),
            },
            triangle: i as u32,
        })
        .collect();
    let mut bounds = Bounds::EMPTY;
    references.iter().for_each(|r| bounds.join(&r.bounds));
    let binary = subtree(&mut references, 0, bounds, 0);
    let mut tree = Tree {
        nodes: Vec::with_capacity(binary.len() / 3 + 1),
        leaves: Vec::with_capacity(binary.len() / 2 + 1),
        order: references.iter().map(|r| r.triangle).collect(),
    };
    tree.collapse(&binary, 0);
    tree
}

/// Builds the subtree of a range of triangles, which starts at `start` of the whole list.
fn subtree(
    references: &mut [Reference],
    start: u32,
    bounds: Bounds,
    depth: usize,
) -> Vec<BinaryNode> {
    let mut out = Vec::with_capacity(references.len());
    append_subtree(references, start, bounds, depth, &mut out);
    out
}

/// Appends the subtree of a range of triangles.
fn append_subtree(
    references: &mut [Reference],
    start: u32,
    bounds: Bounds,
    depth: usize,
    out: &mut Vec<BinaryNode>,
) {
    let count = references.len();
    let at = out.len();
    out.push(BinaryNode {
        bounds,
        right: 0,
        start,
        count: count as u32,
    });
    if count <= LEAF_SIZE {
        return;
    }
    let Division {
        middle,
        left,
        right,
    } = divide(references, depth);
    out[at].count = 0;
    let (first, second) = references.split_at_mut(middle);
    let second_start = start + middle as u32;
    if count > MIN_PARALLEL {
        let (a, b) = rayon::join(
            || subtree(first, start, left, depth + 1),
            || subtree(second, second_start, right, depth + 1),
        );
        out.extend(a);
        out[at].right = (out.len() - at) as u32;
        out.extend(b);
    } else {
        append_subtree(first, start, left, depth + 1, out);
        out[at].right = (out.len() - at) as u32;
        append_subtree(second, second_start, right, depth + 1, out);
    }
}

/// The division of a node into two children.
struct Division {
    /// Number of triangles of the left child.
    middle: usize,
    left: Bounds,
    right: Bounds,
}

/// Reorders the triangles of a node into those of its two children.
fn divide(references: &mut [Reference], depth: usize) -> Division {
    let mut middles = Bounds::EMPTY;
    for r in references.iter() {
        for a in 0..3 {
            let m = r.bounds.centre(a);
            middles.low[a] = lesser(m, middles.low[a]);
            middles.high[a] = greater(m, middles.high[a]);
        }
    }
    if depth < MAX_BINNED_DEPTH
        && let Some(plane) = best_plane(references, &middles)
    {
        let binning = Binning::new(&middles, plane.axis);
        let (mut i, mut j) = (0, references.len());
        while i < j {
            if binning.bin(&references[i]) <= plane.bin {
                i += 1;
            } else {
                j -= 1;
                references.swap(i, j);
            }
        }
        return Division {
            middle: i,
            left: plane.left,
            right: plane.right,
        };
    }
    let middle = references.len() / 2;
    let bounds = |part: &[Reference]| {
        part.iter().fold(Bounds::EMPTY, |mut b, r| {
            b.join(&r.bounds);
            b
        })
    };
    Division {
        middle,
        left: bounds(&references[..middle]),
        right: bounds(&references[middle..]),
    }
}

/// The bins along an axis.
struct Binning {
    axis: usize,
    low: f32,
    scale: f32,
}

impl Binning {
    fn new(middles: &Bounds, axis: usize) -> Binning {
        let (low, high) = (middles.low[axis], middles.high[axis]);
        Binning {
            axis,
            low,
            scale: BINS as f32 / (high - low),
        }
    }

    /// The bin of a triangle.
    fn bin(&self, reference: &Reference) -> usize {
        (((reference.bounds.centre(self.axis) - self.low) * self.scale) as usize).min(BINS - 1)
    }
}

/// A plane that splits a node.
struct Plane {
    cost: f32,
    axis: usize,
    /// Last bin of the left child.
    bin: usize,
    left: Bounds,
    right: Bounds,
}

/// Finds the plane of least cost. Returns `None` if all centres coincide.
fn best_plane(references: &[Reference], middles: &Bounds) -> Option<Plane> {
    let extent = |a: usize| middles.high[a] - middles.low[a];
    let widest = (1..3).fold(0, |m, a| if extent(a) > extent(m) { a } else { m });
    let mut best: Option<Plane> = None;
    for axis in 0..3 {
        let binning = Binning::new(middles, axis);
        let skipped = references.len() >= MAX_ALL_AXES && axis != widest;
        if skipped || !binning.scale.is_finite() {
            continue;
        }
        let mut bins = [(Bounds::EMPTY, 0u32); BINS];
        for r in references {
            let bin = &mut bins[binning.bin(r)];
            bin.0.join(&r.bounds);
            bin.1 += 1;
        }
        let mut rights = [(Bounds::EMPTY, 0u32); BINS];
        let mut sum = (Bounds::EMPTY, 0u32);
        for i in (1..BINS).rev() {
            sum.0.join(&bins[i].0);
            sum.1 += bins[i].1;
            rights[i - 1] = sum;
        }
        let mut left = (Bounds::EMPTY, 0u32);
        for i in 0..BINS - 1 {
            left.0.join(&bins[i].0);
            left.1 += bins[i].1;
            let (right, number) = rights[i];
            if left.1 == 0 || number == 0 {
                continue;
            }
            // A leaf tests as many triangles at once as it holds.
            let groups = |count: u32| count.div_ceil(LEAF_SIZE as u32) as f32;
            let cost = left.0.half_area() * groups(left.1) + right.half_area() * groups(number);
            if best.as_ref().is_none_or(|b| cost < b.cost) {
                best = Some(Plane {
                    cost,
                    axis,
                    bin: i,
                    left: left.0,
                    right,
                });
            }
        }
    }
    best
}

impl Tree {
    /// Collapses the binary subtree at `root` into nodes with four children. Returns the index of its root.
    fn collapse(&mut self, binary: &[BinaryNode], root: usize) -> u32 {
        let mut children = [usize::MAX; 4];
        let mut number = 1;
        children[0] = root;
        while number < 4 {
            // Open the largest inner child.
            let largest = (0..number)
                .filter(|&c| binary[children[c]].count == 0)
                .max_by(|&a, &b| {
                    let area = |c: usize| binary[children[c]].bounds.half_area();
                    area(a).total_cmp(&area(b))
                });
            let Some(largest) = largest else { break };
            let opened = children[largest];
            children[largest] = opened + 1;
            children[number] = opened + binary[opened].right as usize;
            number += 1;
        }
        let at = self.nodes.len();
        self.nodes.push(Node {
            low: [Vec4::INFINITY; 3],
            high: [Vec4::NEG_INFINITY; 3],
            child: [0; 4],
        });
        for (c, &child) in children[..number].iter().enumerate() {
            let from = &binary[child];
            let below = if from.count > 0 {
                self.leaves.push((from.start, from.count));
                (self.leaves.len() - 1) as u32 | LEAF
            } else {
                self.collapse(binary, child)
            };
            let node = &mut self.nodes[at];
            node.child[c] = below;
            for a in 0..3 {
                node.low[a][c] = from.bounds.low[a];
                node.high[a][c] = from.bounds.high[a];
            }
        }
        at as u32
    }
}
