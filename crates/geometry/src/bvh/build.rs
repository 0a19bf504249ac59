//! Top-down construction by binned surface-area splits (Wald 2007, On fast Construction of SAH-based Bounding Volume
//! Hierarchies) along the longest axis of the boxes' centres.

use super::Aabb;
use super::tree::{Bvh, Node};
use glam::{Vec3, Vec4};

/// Most items in a leaf.
const LEAF_SIZE: usize = 4;
/// Bins along an axis: the planes between them are the splits that are tried.
const BINS: usize = 16;
/// Beyond this depth items are halved by count, which bounds the depth for any input.
const MAX_BINNED_DEPTH: usize = 48;
/// No node lies deeper: halving ends after 32 levels for any number of items that `u32` can count.
pub(super) const MAX_DEPTH: usize = MAX_BINNED_DEPTH + 32;

/// A box while the tree is built. Single precision is enough to choose a split; the boxes of the tree are exact. The
/// index is stored in the bits of the fourth coordinate, so that minima and maxima are one instruction for a corner.
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

/// A growing box in single precision. The fourth coordinate is meaningless.
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

/// The items of one bin.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    count: u32,
}

impl Bin {
    const EMPTY: Bin = Bin {
        bounds: Bounds::EMPTY,
        count: 0,
    };
}

impl Bvh {
    /// Builds the tree over `boxes`. Empty boxes and boxes with a coordinate that is not a number are never found.
    pub fn new(boxes: &[Aabb]) -> Self {
        build(boxes)
    }
}

fn build(boxes: &[Aabb]) -> Bvh {
    // A coordinate that is not a number would spread to every box above it.
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
            // Relative to the middle, so that a small mesh far from the origin keeps its digits.
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
    // Children come after their parent, so a backward pass finds their boxes complete.
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

/// Appends the subtree of `items`; `centres` is the box around their doubled centres.
fn subdivide(items: &mut [Item], centres: Bounds, first: u32, depth: usize, nodes: &mut Vec<Node>) {
    let at = nodes.len();
    if items.len() <= LEAF_SIZE {
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

/// Halves the items by count, along `axis` if their centres extend along one.
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

/// Reorders the items. Returns how many belong to the left child, at least one and not all, and the boxes around the
/// doubled centres of both children.
fn split(items: &mut [Item], centres: Bounds, depth: usize) -> (usize, [Bounds; 2]) {
    let extent = (centres.high - centres.low).truncate();
    let axis = (0..3)
        .max_by(|&a, &b| extent[a].total_cmp(&extent[b]))
        .unwrap_or(0);
    let scale = BINS as f32 * 0.999 / extent[axis];
    if !(scale.is_finite() && extent[axis] > 0.0) {
        return halve(items, None);
    }
    if items.len() <= 2 * LEAF_SIZE || depth >= MAX_BINNED_DEPTH {
        return halve(items, Some(axis));
    }
    let low = centres.low[axis];
    // Casting NaN gives 0.
    let bin_of = |item: &Item| (((item.centre()[axis] - low) * scale) as usize).min(BINS - 1);
    let mut bins = [Bin::EMPTY; BINS];
    for item in items.iter() {
        let bin = &mut bins[bin_of(item)];
        bin.bounds.add(item.low, item.high);
        bin.count += 1;
    }
    let cut = cheapest_split(&bins);
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

/// Returns the first bin of the right child for which the sum of surface × items over both children is least.
fn cheapest_split(bins: &[Bin; BINS]) -> usize {
    let mut right_cost = [0.0f32; BINS];
    let (mut bounds, mut count) = (Bounds::EMPTY, 0);
    for i in (1..BINS).rev() {
        bounds.add(bins[i].bounds.low, bins[i].bounds.high);
        count += bins[i].count;
        right_cost[i] = bounds.surface() * count as f32;
    }
    let (mut bounds, mut count) = (Bounds::EMPTY, 0);
    let mut best = (BINS / 2, f32::INFINITY);
    for i in 1..BINS {
        bounds.add(bins[i - 1].bounds.low, bins[i - 1].bounds.high);
        count += bins[i - 1].count;
        let cost = bounds.surface() * count as f32 + right_cost[i];
        if cost < best.1 {
            best = (i, cost);
        }
    }
    best.0
}
