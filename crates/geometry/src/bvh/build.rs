//! Building the tree from the top down by binned surface-area splits (Wald 2007, On fast Construction of SAH-based
//! Bounding Volume Hierarchies), along the longest axis of the boxes' centres.

use super::{Aabb, Bvh, Node};

/// Most items in a leaf.
const LEAF: usize = 4;
/// Places tried for a split.
const BINS: usize = 16;
/// Below this depth items are halved by count, which bounds the depth for any input.
const BINNED_DEPTH: usize = 48;
/// No node lies deeper: halving ends after 32 levels for any number of items that `u32` counts.
pub(super) const DEPTH: usize = BINNED_DEPTH + 32;

/// What the build moves about: single precision is enough to choose a split, the tree's boxes are exact.
#[derive(Clone, Copy)]
struct Item {
    low: [f32; 3],
    high: [f32; 3],
    index: u32,
}

impl Item {
    /// Twice the centre.
    fn centre(&self, axis: usize) -> f32 {
        self.low[axis] + self.high[axis]
    }
}

/// A box in single precision that grows.
#[derive(Clone, Copy)]
struct Bounds {
    low: [f32; 3],
    high: [f32; 3],
}

impl Bounds {
    const EMPTY: Bounds = Bounds {
        low: [f32::INFINITY; 3],
        high: [f32::NEG_INFINITY; 3],
    };

    #[inline]
    fn add(&mut self, low: &[f32; 3], high: &[f32; 3]) {
        for k in 0..3 {
            self.low[k] = if low[k] < self.low[k] {
                low[k]
            } else {
                self.low[k]
            };
            self.high[k] = if high[k] > self.high[k] {
                high[k]
            } else {
                self.high[k]
            };
        }
    }

    fn surface(&self) -> f32 {
        let d = [0, 1, 2].map(|k| (self.high[k] - self.low[k]).max(0.0));
        d[0] * d[1] + d[1] * d[2] + d[2] * d[0]
    }
}

pub(super) fn build(boxes: &[Aabb]) -> Bvh {
    if boxes.is_empty() {
        return Bvh::default();
    }
    // What is not a box at all, by a coordinate that is not a number, would spread to every box above it.
    let boxes: Vec<Aabb> =
        boxes.iter().map(|b| if b.low.cmple(b.high).all() { *b } else { Aabb::EMPTY }).collect();
    let all = boxes.iter().fold(Aabb::EMPTY, |a, b| a.join(b));
    let middle = all.centre();
    let mut items: Vec<Item> = boxes
        .iter()
        .zip(0..)
        .map(|(b, index)| Item {
            // About the middle, so that a small mesh far from the origin keeps its digits.
            low: (b.low - middle).as_vec3().to_array(),
            high: (b.high - middle).as_vec3().to_array(),
            index,
        })
        .collect();
    let mut nodes = Vec::with_capacity(boxes.len());
    subdivide(&mut items, 0, 0, &mut nodes);
    let order: Vec<u32> = items.iter().map(|i| i.index).collect();
    let boxes: Vec<Aabb> = order.iter().map(|&i| boxes[i as usize]).collect();
    // Children come after their parent, so a backward pass finds them done.
    for at in (0..nodes.len()).rev() {
        let node: Node = nodes[at];
        nodes[at].bounds = if node.count > 0 {
            let items = &boxes[node.first as usize..(node.first + node.count) as usize];
            items.iter().fold(Aabb::EMPTY, |a, b| a.join(b))
        } else {
            nodes[at + 1]
                .bounds
                .join(&nodes[nodes[at + 1].end as usize].bounds)
        };
    }
    Bvh {
        nodes,
        order,
        boxes,
    }
}

fn subdivide(items: &mut [Item], first: u32, depth: usize, nodes: &mut Vec<Node>) {
    let at = nodes.len();
    let count = if items.len() <= LEAF {
        items.len() as u32
    } else {
        0
    };
    nodes.push(Node {
        bounds: Aabb::EMPTY,
        end: 0,
        first,
        count,
    });
    if count == 0 {
        let middle = split(items, depth);
        let (left, right) = items.split_at_mut(middle);
        subdivide(left, first, depth + 1, nodes);
        subdivide(right, first + middle as u32, depth + 1, nodes);
    }
    if let Some(node) = nodes.get_mut(at) {
        node.first = if count == 0 { 0 } else { first };
    }
    nodes[at].end = nodes.len() as u32;
}

/// Reorders the items and returns how many belong to the left child, at least one and not all.
fn split(items: &mut [Item], depth: usize) -> usize {
    let mut centres = Bounds::EMPTY;
    for item in items.iter() {
        let c = [0, 1, 2].map(|k| item.centre(k));
        centres.add(&c, &c);
    }
    let extent = [0, 1, 2].map(|k| centres.high[k] - centres.low[k]);
    let axis = (0..3)
        .max_by(|&a, &b| extent[a].total_cmp(&extent[b]))
        .unwrap_or(0);
    let scale = BINS as f32 * 0.999 / extent[axis];
    let half = items.len() / 2;
    if !(scale.is_finite() && extent[axis] > 0.0) {
        return half;
    }
    if items.len() <= 2 * LEAF || depth >= BINNED_DEPTH {
        items.select_nth_unstable_by(half, |a, b| {
            a.centre(axis)
                .total_cmp(&b.centre(axis))
                .then(a.index.cmp(&b.index))
        });
        return half;
    }
    let low = centres.low[axis];
    // The cast of what is not a number gives 0.
    let bin_of = |item: &Item| (((item.centre(axis) - low) * scale) as usize).min(BINS - 1);
    let mut bins = [(Bounds::EMPTY, 0usize); BINS];
    for item in items.iter() {
        let bin = &mut bins[bin_of(item)];
        bin.0.add(&item.low, &item.high);
        bin.1 += 1;
    }
    let cut = cheapest(&bins);
    let mut middle = 0;
    for i in 0..items.len() {
        if bin_of(&items[i]) < cut {
            items.swap(i, middle);
            middle += 1;
        }
    }
    if middle == 0 || middle == items.len() {
        half
    } else {
        middle
    }
}

/// The first bin of the right side for the least sum of surface × items.
fn cheapest(bins: &[(Bounds, usize); BINS]) -> usize {
    let mut right_cost = [0.0f32; BINS];
    let (mut bounds, mut count) = (Bounds::EMPTY, 0);
    for i in (1..BINS).rev() {
        bounds.add(&bins[i].0.low, &bins[i].0.high);
        count += bins[i].1;
        right_cost[i] = bounds.surface() * count as f32;
    }
    let (mut bounds, mut count) = (Bounds::EMPTY, 0);
    let mut best = (BINS / 2, f32::INFINITY);
    for i in 1..BINS {
        bounds.add(&bins[i - 1].0.low, &bins[i - 1].0.high);
        count += bins[i - 1].1;
        let cost = bounds.surface() * count as f32 + right_cost[i];
        if cost < best.1 {
            best = (i, cost);
        }
    }
    best.0
}
