//! Building the tree from the top down by binned surface-area splits (Wald 2007, On fast Construction of SAH-based
//! Bounding Volume Hierarchies), along the longest axis of the boxes' centres.

use super::{Aabb, Bvh, Node};
use glam::{Vec3, Vec4};

/// Most items in a leaf.
const LEAF: usize = 4;
/// Places tried for a split.
const BINS: usize = 16;
/// Below this depth items are halved by count, which bounds the depth for any input.
const BINNED_DEPTH: usize = 48;
/// No node lies deeper: halving ends after 32 levels for any number of items that `u32` counts.
pub(super) const DEPTH: usize = BINNED_DEPTH + 32;

/// What the build moves about: single precision is enough to choose a split, the tree's boxes are exact. The index is
/// kept in the bits of the fourth coordinate, so that minima and maxima are one instruction for a whole corner.
#[derive(Clone, Copy)]
struct Item {
    low: Vec4,
    high: Vec4,
}

impl Item {
    fn index(&self) -> u32 {
        self.low.w.to_bits()
    }

    /// Twice the centre.
    fn centre(&self) -> Vec4 {
        self.low + self.high
    }
}

/// A box in single precision that grows. The fourth coordinate means nothing.
#[derive(Clone, Copy)]
struct Bounds {
    low: Vec4,
    high: Vec4,
}

impl Bounds {
    const EMPTY: Bounds = Bounds {
        low: Vec4::INFINITY,
        high: Vec4::NEG_INFINITY,
    };

    #[inline]
    fn add(&mut self, low: Vec4, high: Vec4) {
        self.low = self.low.min(low);
        self.high = self.high.max(high);
    }

    fn surface(&self) -> f32 {
        let d = (self.high - self.low).truncate().max(Vec3::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

pub(super) fn build(boxes: &[Aabb]) -> Bvh {
    // What is not a box, by a coordinate that is not a number, would spread to every box above it.
    let sound = |b: &Aabb| b.low.cmple(b.high).all();
    let all = boxes
        .iter()
        .filter(|b| sound(b))
        .fold(Aabb::EMPTY, |a, b| a.join(b));
    let middle = all.centre();
    let mut items: Vec<Item> = Vec::with_capacity(boxes.len());
    let mut centres = Bounds::EMPTY;
    for (b, index) in boxes.iter().zip(0..) {
        if sound(b) {
            // About the middle, so that a small mesh far from the origin keeps its digits.
            let low = (b.low - middle).as_vec3().extend(f32::from_bits(index));
            let item = Item {
                low,
                high: (b.high - middle).as_vec3().extend(0.0),
            };
            centres.add(item.centre(), item.centre());
            items.push(item);
        }
    }
    if items.is_empty() {
        return Bvh::default();
    }
    let mut nodes = Vec::with_capacity(items.len() * 3 / 4 + 1);
    subdivide(&mut items, centres, 0, 0, &mut nodes);
    let order: Vec<u32> = items.iter().map(|i| i.index()).collect();
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

/// Appends the subtree of `items`, the box around whose (doubled) centres is `centres`.
fn subdivide(items: &mut [Item], centres: Bounds, first: u32, depth: usize, nodes: &mut Vec<Node>) {
    let at = nodes.len();
    if items.len() <= LEAF {
        nodes.push(Node {
            bounds: Aabb::EMPTY,
            end: at as u32 + 1,
            first,
            count: items.len() as u32,
        });
        return;
    }
    nodes.push(Node {
        bounds: Aabb::EMPTY,
        end: 0,
        first: 0,
        count: 0,
    });
    let (middle, [low, high]) = split(items, centres, depth);
    let (left, right) = items.split_at_mut(middle);
    subdivide(left, low, first, depth + 1, nodes);
    subdivide(right, high, first + middle as u32, depth + 1, nodes);
    nodes[at].end = nodes.len() as u32;
}

/// Halves by count, along `axis` where there is an extent to halve.
fn halve(items: &mut [Item], axis: Option<usize>) -> (usize, [Bounds; 2]) {
    let half = items.len() / 2;
    if let Some(axis) = axis {
        items.select_nth_unstable_by(half, |a, b| {
            a.centre()[axis]
                .total_cmp(&b.centre()[axis])
                .then(a.index().cmp(&b.index()))
        });
    }
    let around = |items: &[Item]| {
        items.iter().fold(Bounds::EMPTY, |mut b, i| {
            b.add(i.centre(), i.centre());
            b
        })
    };
    (half, [around(&items[..half]), around(&items[half..])])
}

/// Reorders the items and returns how many belong to the left child, at least one and not all, with the boxes around
/// the centres of both children.
fn split(items: &mut [Item], centres: Bounds, depth: usize) -> (usize, [Bounds; 2]) {
    let extent = (centres.high - centres.low).truncate();
    let axis = (0..3)
        .max_by(|&a, &b| extent[a].total_cmp(&extent[b]))
        .unwrap_or(0);
    let scale = BINS as f32 * 0.999 / extent[axis];
    if !(scale.is_finite() && extent[axis] > 0.0) {
        return halve(items, None);
    }
    if items.len() <= 2 * LEAF || depth >= BINNED_DEPTH {
        return halve(items, Some(axis));
    }
    let low = centres.low[axis];
    // The cast of what is not a number gives 0.
    let bin_of = |item: &Item| (((item.centre()[axis] - low) * scale) as usize).min(BINS - 1);
    let mut bins = [(Bounds::EMPTY, 0u32); BINS];
    for item in items.iter() {
        let bin = &mut bins[bin_of(item)];
        bin.0.add(item.low, item.high);
        bin.1 += 1;
    }
    let cut = cheapest(&bins);
    let mut middle = 0;
    let mut sides = [Bounds::EMPTY; 2];
    for i in 0..items.len() {
        let item = items[i];
        let left = bin_of(&item) < cut;
        let side = &mut sides[usize::from(!left)];
        side.add(item.centre(), item.centre());
        if left {
            items.swap(i, middle);
            middle += 1;
        }
    }
    if middle == 0 || middle == items.len() {
        halve(items, Some(axis))
    } else {
        (middle, sides)
    }
}

/// The first bin of the right side for the least sum of surface × items.
fn cheapest(bins: &[(Bounds, u32); BINS]) -> usize {
    let mut right_cost = [0.0f32; BINS];
    let (mut bounds, mut count) = (Bounds::EMPTY, 0);
    for i in (1..BINS).rev() {
        bounds.add(bins[i].0.low, bins[i].0.high);
        count += bins[i].1;
        right_cost[i] = bounds.surface() * count as f32;
    }
    let (mut bounds, mut count) = (Bounds::EMPTY, 0);
    let mut best = (BINS / 2, f32::INFINITY);
    for i in 1..BINS {
        bounds.add(bins[i - 1].0.low, bins[i - 1].0.high);
        count += bins[i - 1].1;
        let cost = bounds.surface() * count as f32 + right_cost[i];
        if cost < best.1 {
            best = (i, cost);
        }
    }
    best.0
}
