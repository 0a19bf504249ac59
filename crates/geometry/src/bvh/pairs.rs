//! Pairs of items whose boxes meet, within a tree.

use super::tree::Bvh;
use std::cell::Cell;

impl Bvh {
    /// Visits every pair of different items whose boxes meet, each pair once, the item with the smaller index first.
    pub fn self_pairs(&self, mut visit: impl FnMut(usize, usize)) {
        self.self_pairs_while(|a, b| {
            visit(a, b);
            true
        });
    }

    /// As [`Bvh::self_pairs`], until `visit` returns false.
    pub fn self_pairs_while(&self, mut visit: impl FnMut(usize, usize) -> bool) {
        if self.nodes.is_empty() {
            return;
        }
        let wanted = Cell::new(true);
        let mut visit = |a, b| wanted.set(wanted.get() && visit(a, b));
        let mut stack = vec![(0usize, 0usize)];
        while let Some((a, b)) = stack.pop().filter(|_| wanted.get()) {
            let (na, nb) = (&self.nodes[a], &self.nodes[b]);
            if a == b {
                if na.count > 0 {
                    let items = na.first as usize..(na.first + na.count) as usize;
                    for i in items.clone() {
                        for j in i + 1..items.end {
                            self.report_if_overlapping(i, j, &mut |x, y| visit(x.min(y), x.max(y)));
                        }
                    }
                } else {
                    let right = self.nodes[a + 1].end as usize;
                    stack.extend([(a + 1, right), (right, right), (a + 1, a + 1)]);
                }
            } else if na.bounds.overlaps(&nb.bounds) {
                self.open_larger(a, b, &mut stack, &mut |x, y| visit(x.min(y), x.max(y)));
            }
        }
    }

    /// Opens the larger of two nodes, or compares the items of two leaves.
    fn open_larger(
        &self,
        a: usize,
        b: usize,
        stack: &mut Vec<(usize, usize)>,
        visit: &mut impl FnMut(usize, usize),
    ) {
        let (na, nb) = (&self.nodes[a], &self.nodes[b]);
        let open_first = nb.count > 0 || na.bounds.half_area() >= nb.bounds.half_area();
        if na.count > 0 && nb.count > 0 {
            for i in na.first as usize..(na.first + na.count) as usize {
                if self.boxes[i].overlaps(&nb.bounds) {
                    for j in nb.first as usize..(nb.first + nb.count) as usize {
                        self.report_if_overlapping(i, j, visit);
                    }
                }
            }
        } else if na.count == 0 && open_first {
            let right = self.nodes[a + 1].end as usize;
            stack.extend([(right, b), (a + 1, b)]);
        } else {
            let right = self.nodes[b + 1].end as usize;
            stack.extend([(a, right), (a, b + 1)]);
        }
    }

    /// Visits the items at places `i` and `j` of the order if their boxes overlap.
    fn report_if_overlapping(&self, i: usize, j: usize, visit: &mut impl FnMut(usize, usize)) {
        if self.boxes[i].overlaps(&self.boxes[j]) {
            visit(self.order[i] as usize, self.order[j] as usize);
        }
    }
}
