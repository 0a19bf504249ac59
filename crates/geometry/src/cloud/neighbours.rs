//! Nearest neighbours: a k-d tree (Bentley 1975) whose nodes are ranges of one sorted list of points.

use glam::DVec3;

/// Points in a leaf.
const LEAF: usize = 8;

/// A k-d tree over points. Equal distances are told apart by the points' numbers, so that answers are the same on every
/// machine.
#[derive(Debug, Clone)]
pub struct Neighbours {
    points: Vec<DVec3>,
    numbers: Vec<u32>,
    /// Axis that the range whose middle is here was split along.
    axes: Vec<u8>,
}

impl Neighbours {
    /// The tree of finite points.
    pub fn new(points: &[DVec3]) -> Self {
        let mut pairs: Vec<(DVec3, u32)> = points.iter().copied().zip(0..).collect();
        let mut axes = vec![0; points.len()];
        build(&mut pairs, &mut axes);
        Neighbours {
            points: pairs.iter().map(|p| p.0).collect(),
            numbers: pairs.iter().map(|p| p.1).collect(),
            axes,
        }
    }

    /// The `k` points nearest to `at`, nearest first, as (square of the distance, number).
    pub fn nearest(&self, at: DVec3, k: usize) -> Vec<(f64, u32)> {
        let mut found = Vec::with_capacity(k + 1);
        if k > 0 {
            self.nearest_in(0, self.points.len(), at, k, &mut found);
        }
        found
    }

    fn nearest_in(&self, low: usize, high: usize, at: DVec3, k: usize, out: &mut Vec<(f64, u32)>) {
        if high - low <= LEAF {
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

    /// The points within `radius` of `at`, in ascending order of their numbers.
    pub fn within(&self, at: DVec3, radius: f64) -> Vec<u32> {
        let mut found = self.around(at, radius);
        found.sort_unstable();
        found
    }

    /// [`Neighbours::within`] in the tree's own order, which is the same on every machine.
    pub fn around(&self, at: DVec3, radius: f64) -> Vec<u32> {
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
        if high - low <= LEAF {
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

fn build(pairs: &mut [(DVec3, u32)], axes: &mut [u8]) {
    if pairs.len() <= LEAF {
        return;
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
    rayon::join(
        || build(left, left_axes),
        || build(&mut right[1..], &mut right_axes[1..]),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a coarse lattice, so that many distances are equal.
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
    fn answers_are_those_of_looking_at_every_point() {
        let points = points();
        let tree = Neighbours::new(&points);
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
