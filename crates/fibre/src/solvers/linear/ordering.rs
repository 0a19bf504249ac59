//! The numbering of matrix rows: reverse Cuthill–McKee (Cuthill and McKee 1969; George 1971).

use std::collections::VecDeque;

/// Breadth-first walks from which the start of the numbering is found: each starts where the last one ended, far away.
const WALKS: usize = 3;

/// Returns nodes in the order in which they are numbered, from their neighbours (each pair once or twice).
pub(super) fn reverse_cuthill_mckee(nodes: usize, pairs: &[(u32, u32)]) -> Vec<u32> {
    let graph = Graph::new(nodes, pairs);
    let mut order = Vec::with_capacity(nodes);
    let mut visited = Visited {
        walk_of: vec![u32::MAX; nodes],
        walks: 0,
    };
    for v in 0..nodes as u32 {
        if visited.walk_of[v as usize] != u32::MAX {
            continue;
        }
        let mut start = v;
        let mut found = Vec::new();
        for _ in 0..WALKS {
            found.clear();
            graph.walk(start, &mut visited, &mut found);
            start = found.last().copied().unwrap_or(v);
        }
        order.append(&mut found);
    }
    order.reverse();
    order
}

/// Neighbours of nodes, as lists in compressed form.
struct Graph {
    offsets: Vec<usize>,
    neighbours: Vec<u32>,
}

/// The last walk that visited each node.
struct Visited {
    walk_of: Vec<u32>,
    walks: u32,
}

impl Graph {
    fn new(nodes: usize, pairs: &[(u32, u32)]) -> Self {
        let mut offsets = vec![0usize; nodes + 1];
        for &(a, b) in pairs {
            offsets[a as usize + 1] += 1;
            offsets[b as usize + 1] += 1;
        }
        for i in 0..nodes {
            offsets[i + 1] += offsets[i];
        }
        let mut next = offsets.clone();
        let mut neighbours = vec![0u32; 2 * pairs.len()];
        for &(a, b) in pairs {
            for (from, to) in [(a, b), (b, a)] {
                neighbours[next[from as usize]] = to;
                next[from as usize] += 1;
            }
        }
        Graph {
            offsets,
            neighbours,
        }
    }

    fn neighbours(&self, v: u32) -> &[u32] {
        &self.neighbours[self.offsets[v as usize]..self.offsets[v as usize + 1]]
    }

    /// Appends the nodes connected with `start` to `out`, in order of distance, then of degree. The last is far from the first.
    fn walk(&self, start: u32, visited: &mut Visited, out: &mut Vec<u32>) {
        let mark = visited.walks;
        visited.walks += 1;
        let mut queue = VecDeque::from([start]);
        visited.walk_of[start as usize] = mark;
        while let Some(v) = queue.pop_front() {
            out.push(v);
            let from = queue.len();
            for &w in self.neighbours(v) {
                if visited.walk_of[w as usize] != mark {
                    visited.walk_of[w as usize] = mark;
                    queue.push_back(w);
                }
            }
            queue.make_contiguous()[from..].sort_by_key(|&w| (self.neighbours(w).len(), w));
        }
    }
}
