//! Edges between points with the triangles that use them.

use super::points::corner_points;

/// The use of an edge by a triangle: the edge's point with the higher number; three times the triangle, plus the number of the edge
/// in it. They are one number, which is sorted by sooner than two.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Use(u64);

impl Use {
    fn new(high: u32, half_edge: u32) -> Self {
        Use(u64::from(high) << 32 | u64::from(half_edge))
    }

    fn half_edge(self) -> u32 {
        self.0 as u32
    }

    /// The edge's point with the higher number.
    pub fn high(self) -> u32 {
        (self.0 >> 32) as u32
    }

    pub fn triangle(self) -> usize {
        (self.half_edge() / 3) as usize
    }

    /// The edge's number in the triangle: from corner `k` to corner `k + 1`.
    pub fn edge(self) -> usize {
        (self.half_edge() % 3) as usize
    }
}

/// All edges of a mesh, grouped by their point with the lower number.
pub(crate) struct Edges {
    /// Where the uses of each lower point start, and where those of the last one end.
    starts: Vec<u32>,
    uses: Vec<Use>,
}

impl Edges {
    /// Collects the edges of all triangles whose three corners lie at three points.
    pub fn new(triangles: &[[u32; 3]], points: &[u32], count: usize) -> Self {
        // A counting sort by the lower point; the few uses of each are then sorted by the higher.
        let mut starts = vec![0u32; count + 1];
        each_use(triangles, points, |low, _| starts[low as usize] += 1);
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        let mut uses = vec![Use(0); sum as usize];
        each_use(triangles, points, |low, used| {
            starts[low as usize] -= 1;
            uses[starts[low as usize] as usize] = used;
        });
        for pair in starts.windows(2) {
            uses[pair[0] as usize..pair[1] as usize].sort_unstable();
        }
        Edges { starts, uses }
    }

    /// Visits every edge: its lower point and its uses, which all have the same higher point.
    pub fn each(&self, mut visit: impl FnMut(u32, &[Use])) {
        for (low, pair) in self.starts.windows(2).enumerate() {
            let mut uses = &self.uses[pair[0] as usize..pair[1] as usize];
            while let Some(first) = uses.first() {
                let end = uses
                    .iter()
                    .position(|u| u.high() != first.high())
                    .unwrap_or(uses.len());
                visit(low as u32, &uses[..end]);
                uses = &uses[end..];
            }
        }
    }
}

/// Visits the edges of all triangles whose three corners lie at three points, each with its lower point.
fn each_use(triangles: &[[u32; 3]], points: &[u32], mut visit: impl FnMut(u32, Use)) {
    for (t, &triangle) in triangles.iter().enumerate() {
        let Some([a, b, c]) = corner_points(triangle, points) else {
            continue;
        };
        if a == b || b == c || c == a {
            continue;
        }
        for (k, (p, q)) in [(a, b), (b, c), (c, a)].into_iter().enumerate() {
            let half_edge = (3 * t + k) as u32;
            let high = p.max(q);
            visit(p.min(q), Use::new(high, half_edge));
        }
    }
}
