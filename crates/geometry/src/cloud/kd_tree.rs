//! A k-d tree (Bentley 1975) whose nodes are ranges of one sorted list of points.

use crate::{Cancelled, Context};
use glam::DVec3;
use std::convert::Infallible;

/// Most points in a leaf.
const LEAF_SIZE: usize = 8;
/// Most points of a range that is split without asking whether to stop: about a millisecond.
const CHECKED_SIZE: usize = 1 << 16;

/// A k-d tree over points. Points at equal distances are ordered by their numbers, so that the answers are the same on
/// every machine.
///
/// ```
/// use glam::DVec3;
/// use greenstick_geometry::cloud::KdTree;
///
/// let points: Vec<DVec3> = (0..100).map(|i| DVec3::X * f64::from(i)).collect();
/// let tree = KdTree::new(&points);
/// let numbers: Vec<u32> = tree.nearest(DVec3::X * 7.2, 2).iter().map(|n| n.1).collect();
/// assert_eq!(numbers, [7, 8]);
/// ```
#[derive(Debug, Clone)]
pub struct KdTree {
    points: Vec<DVec3>,
    numbers: Vec<u32>,
    /// Axis along which the range with its middle here is split.
    axes: Vec<u8>,
}

impl KdTree {
    /// Builds the tree over points with finite coordinates.
    pub fn new(points: &[DVec3]) -> Self {
        match KdTree::build(points, &|| Ok::<(), Infallible>(())) {
            Ok(tree) => tree,
        }
    }

    /// Builds the tree as [`KdTree::new`] does, for as long as the caller does not ask to stop.
    ///
    /// # Errors
    /// [`Cancelled`] where the caller asked to stop.
    pub fn try_new(points: &[DVec3], context: &Context) -> Result<Self, Cancelled> {
        KdTree::build(points, &|| context.check())
    }

    fn build<E: Send>(
        points: &[DVec3],
        check: &(impl Fn() -> Result<(), E> + Sync),
    ) -> Result<Self, E> {
        let mut pairs: Vec<(DVec3, u32)> = points.iter().copied().zip(0..).collect();
        let mut axes = vec![0; points.len()];
        sort(&mut pairs, &mut axes, check)?;
        Ok(KdTree {
            points: pairs.iter().map(|p| p.0).collect(),
            numbers: pairs.iter().map(|p| p.1).collect(),
            axes,
        })
    }

    /// Finds the `k` points nearest to `at`, nearest first, as (squared distance, number).
    pub fn nearest(&self, at: DVec3, k: usize) -> Vec<(f64, u32)> {
        let mut found = Vec::with_capacity(k + 1);
        if k > 0 {
            self.nearest_in(0, self.points.len(), at, k, &mut found);
        }
        found
    }

    fn nearest_in(&self, low: usize, high: usize, at: DVec3, k: usize, out: &mut Vec<(f64, u32)>) {
        if high - low <= LEAF_SIZE {
            for i in low..high {
                self.offer(i, at, k, out);
            }
            return;
        }
        let middle = (low + high) / 2;
        let axis = usize::from(self.axes[middle]);
        let by = at[axis] - self.points[middle][axis];
        let (near, far) = if by < 0.0 {
            ((low, middle), (middle + 1, high))
        } else {
            ((middle + 1, high), (low, middle))
        };
        self.nearest_in(near.0, near.1, at, k, out);
        self.offer(middle, at, k, out);
        if out.len() < k || by * by <= out[out.len() - 1].0 {
            self.nearest_in(far.0, far.1, at, k, out);
        }
    }

    /// Inserts a point into the list of the `k` nearest if it belongs there.
    fn offer(&self, i: usize, at: DVec3, k: usize, out: &mut Vec<(f64, u32)>) {
        let this = (self.points[i].distance_squared(at), self.numbers[i]);
        let before = |a: &(f64, u32), b: &(f64, u32)| a.0 < b.0 || (a.0 == b.0 && a.1 < b.1);
        if out.len() == k && !before(&this, &out[k - 1]) {
            return;
        }
        let mut place = out.len();
        while place > 0 && before(&this, &out[place - 1]) {
            place -= 1;
        }
        out.insert(place, this);
        out.truncate(k);
    }

    /// Finds the points within `radius` of `at`, in ascending order of their numbers.
    pub fn within(&self, at: DVec3, radius: f64) -> Vec<u32> {
        let mut found = self.within_unordered(at, radius);
        found.sort_unstable();
        found
    }

    /// Finds what [`KdTree::within`] does, in the order of the tree, which is the same on every machine.
    pub fn within_unordered(&self, at: DVec3, radius: f64) -> Vec<u32> {
        let mut found = Vec::new();
        self.within_in(0, self.points.len(), at, radius, &mut found);
        found
    }

    fn within_in(&self, low: usize, high: usize, at: DVec3, radius: f64, out: &mut Vec<u32>) {
        let square = radius * radius;
        let mut offer = |i: usize| {
            if self.points[i].distance_squared(at) <= square {
                out.push(self.numbers[i]);
            }
        };
        if high - low <= LEAF_SIZE {
            (low..high).for_each(offer);
            return;
        }
        let middle = (low + high) / 2;
        offer(middle);
        let axis = usize::from(self.axes[middle]);
        let by = at[axis] - self.points[middle][axis];
        if by <= radius {
            self.within_in(low, middle, at, radius, out);
        }
        if by >= -radius {
            self.within_in(middle + 1, high, at, radius, out);
        }
    }
}

/// Sorts points, given with their numbers, into the order of the tree.
fn sort<E: Send>(
    pairs: &mut [(DVec3, u32)],
    axes: &mut [u8],
    check: &(impl Fn() -> Result<(), E> + Sync),
) -> Result<(), E> {
    if pairs.len() <= LEAF_SIZE {
        return Ok(());
    }
    if pairs.len() > CHECKED_SIZE {
        check()?;
    }
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (p, _) in pairs.iter() {
        (low, high) = (low.min(*p), high.max(*p));
    }
    let axis = (high - low).max_position();
    let middle = pairs.len() / 2;
    pairs.select_nth_unstable_by(middle, |a, b| {
        a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1))
    });
    axes[middle] = axis as u8;
    let (left, right) = pairs.split_at_mut(middle);
    let (left_axes, right_axes) = axes.split_at_mut(middle);
    let (left, right) = rayon::join(
        || sort(left, left_axes, check),
        || sort(&mut right[1..], &mut right_axes[1..], check),
    );
    left.and(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points on a coarse lattice, so that many distances are equal.
    fn points() -> Vec<DVec3> {
        let mut h = 1u64;
        let mut next = || {
            h = h
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            ((h >> 33) % 17) as f64
        };
        (0..700)
            .map(|_| DVec3::new(next(), next(), next() * 0.25))
            .collect()
    }

    #[test]
    fn queries_match_exhaustive_search() {
        let points = points();
        let tree = KdTree::new(&points);
        for i in (0..700).step_by(13) {
            let at = points[i] + DVec3::new(0.3, -0.1, 0.5) * (i % 3) as f64;
            let mut all: Vec<(f64, u32)> = points
                .iter()
                .zip(0..)
                .map(|(p, n)| (p.distance_squared(at), n))
                .collect();
            all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            assert_eq!(tree.nearest(at, 9), all[..9]);
            let mut near: Vec<u32> = all.iter().filter(|a| a.0 <= 9.0).map(|a| a.1).collect();
            near.sort_unstable();
            assert_eq!(tree.within(at, 3.0), near);
        }
    }
}
