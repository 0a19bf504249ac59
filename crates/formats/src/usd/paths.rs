//! The table of paths of a binary layer.

/// The paths of a layer in depth-first order.
#[derive(Default)]
pub(super) struct PathTable {
    /// Numbers of the paths.
    pub paths: Vec<i32>,
    /// Tokens of their last elements, negative for properties.
    pub tokens: Vec<i32>,
    /// For each path the distance to its next sibling if it has children and a sibling, 0 if it has only a sibling, −1 if
    /// it has only children, and −2 if it has neither.
    pub jumps: Vec<i32>,
}

impl PathTable {
    /// Number of paths.
    pub fn len(&self) -> usize {
        self.paths.len()
    }

    /// Adds a path with a number of children; `has_sibling` says whether a sibling follows.
    pub fn add(&mut self, token: i32, children: usize, has_sibling: bool) {
        self.paths.push(self.paths.len() as i32);
        self.tokens.push(token);
        self.jumps.push(match (children > 0, has_sibling) {
            (true, _) => -1,
            (false, true) => 0,
            (false, false) => -2,
        });
    }

    /// Sets the distance of a path with children from its next sibling, which follows the last path so far.
    pub fn set_subtree_size(&mut self, path: usize) {
        self.jumps[path] = (self.len() - path) as i32;
    }
}
