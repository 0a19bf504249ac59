//! Disjoint sets.

/// Disjoint sets of numbers that are joined step by step (union-find with path halving). The root of a set is its
/// smallest number, whatever the order of joining.
///
/// ```
/// use greenstick_geometry::Unions;
///
/// let mut sets = Unions::new(4);
/// assert!(sets.join(3, 1));
/// assert!(!sets.join(1, 3));
/// assert_eq!(sets.root(3), 1);
/// ```
#[derive(Debug, Clone)]
pub struct Unions {
    parents: Vec<u32>,
}

impl Unions {
    /// Creates `count` sets of one number each.
    pub fn new(count: usize) -> Self {
        Unions {
            parents: (0..count as u32).collect(),
        }
    }

    /// Returns the smallest number of the set that contains `i`.
    pub fn root(&mut self, mut i: u32) -> u32 {
        loop {
            let parent = self.parents[i as usize];
            if parent == i {
                return i;
            }
            let above = self.parents[parent as usize];
            self.parents[i as usize] = above;
            i = above;
        }
    }

    /// Joins the sets that contain `a` and `b`. Returns whether they were different sets.
    pub fn join(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
        a != b
    }

    /// Joins a number that is alone in its set to the smallest of another, which is smaller; both may be the same.
    pub fn attach(&mut self, alone: u32, smallest: u32) {
        debug_assert!(self.parents[alone as usize] == alone && smallest <= alone);
        debug_assert!(self.parents[smallest as usize] == smallest);
        self.parents[alone as usize] = smallest;
    }

    /// Joins the sets that contain the corners of a triangle.
    pub fn join_triangle(&mut self, [a, b, c]: [u32; 3]) {
        let parent = |i: u32| self.parents[i as usize];
        // Triangles that follow each other have corners that are mostly joined already.
        if parent(a) != parent(b) || parent(b) != parent(c) {
            self.join(a, b);
            self.join(b, c);
        }
    }
}
