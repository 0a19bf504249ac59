//! Pairs of boxes that overlap, found by a grid whose cells have about the shape of the boxes.
//!
//! Triangles of a broken face are alike: long along the grain and narrow across it. A pass over cells a little larger than
//! they are costs far less than a tree does to build. Where cells would hold many boxes, a tree is used.

use crate::{Aabb, Bvh};
use glam::DVec3;

/// Size of a cell, mean sizes of boxes.
const CELL_SIZE: f64 = 2.0;
/// Most cells for each box; where there would be more, cells are larger.
const MAX_CELLS: f64 = 4.0;
/// Most cells that a box may cover on average; beyond, a tree is faster.
const MAX_CELLS_PER_BOX: usize = 8;
/// Most pairs in common cells for each box; beyond, a tree is faster.
const MAX_PAIRS_PER_BOX: usize = 128;

/// Visits every pair of different boxes that overlap once, the smaller index first, in no particular order. Boxes that are
/// empty or have a coordinate that is not a number overlap nothing.
pub(crate) fn overlapping_pairs(boxes: &[Aabb], visit: impl FnMut(usize, usize)) {
    match Grid::new(boxes) {
        Some(grid) => grid.pairs(boxes, visit),
        None => Bvh::new(boxes).self_pairs(visit),
    }
}

/// Boxes by the cells that they cover.
struct Grid {
    low: DVec3,
    /// Cells per unit of length.
    scale: DVec3,
    /// Cells along each axis.
    size: [usize; 3],
    /// Where the boxes of each cell start in `entries`, and where those of the last end.
    starts: Vec<u32>,
    entries: Vec<u32>,
}

impl Grid {
    /// Sorts boxes into cells, unless a tree would be faster.
    fn new(boxes: &[Aabb]) -> Option<Grid> {
        let all = boxes.iter().fold(Aabb::EMPTY, |a, b| a.join(b));
        let extent = all.high - all.low;
        let sum: DVec3 = boxes.iter().map(|b| b.high - b.low).sum();
        let mean = sum / boxes.len() as f64;
        if !(mean.is_finite() && extent.is_finite() && mean.min_element() > 0.0) {
            return None;
        }
        let mut cell = CELL_SIZE * mean;
        let sizes = |cell: DVec3| (extent / cell).max(DVec3::ONE).floor();
        while sizes(cell).element_product() > MAX_CELLS * boxes.len() as f64 {
            cell *= 1.25;
        }
        let size = sizes(cell);
        let mut grid = Grid {
            low: all.low,
            scale: size / extent,
            size: size.to_array().map(|s| s as usize),
            starts: Vec::new(),
            entries: Vec::new(),
        };
        grid.fill(boxes).then_some(grid)
    }

    /// Counts and places the boxes. Returns whether few enough share cells.
    fn fill(&mut self, boxes: &[Aabb]) -> bool {
        let mut starts = vec![0u32; self.size.iter().product::<usize>() + 1];
        let mut count = 0;
        for b in boxes {
            count += self.each_cell(b, |cell| starts[cell] += 1);
            if count > MAX_CELLS_PER_BOX * boxes.len() {
                return false;
            }
        }
        let pairs: usize = starts.iter().map(|&n| n as usize * n as usize / 2).sum();
        if pairs > MAX_PAIRS_PER_BOX * boxes.len() {
            return false;
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        let mut entries = vec![0; count];
        for (index, b) in boxes.iter().enumerate().rev() {
            self.each_cell(b, |cell| {
                starts[cell] -= 1;
                entries[starts[cell] as usize] = index as u32;
            });
        }
        (self.starts, self.entries) = (starts, entries);
        true
    }

    /// The cell of a point along each axis; that of the nearest cell for one outside or not a number.
    fn cell(&self, at: DVec3) -> [usize; 3] {
        let at = (at - self.low) * self.scale;
        [0, 1, 2].map(|k| (at[k] as usize).min(self.size[k] - 1))
    }

    fn number(&self, [i, j, k]: [usize; 3]) -> usize {
        (i * self.size[1] + j) * self.size[2] + k
    }

    /// Visits the cells that a box covers. Returns how many there are.
    fn each_cell(&self, b: &Aabb, mut visit: impl FnMut(usize)) -> usize {
        let (from, to) = (self.cell(b.low), self.cell(b.high));
        let mut count = 0;
        for i in from[0]..=to[0] {
            for j in from[1]..=to[1] {
                for k in from[2]..=to[2] {
                    visit(self.number([i, j, k]));
                    count += 1;
                }
            }
        }
        count
    }

    fn pairs(&self, boxes: &[Aabb], mut visit: impl FnMut(usize, usize)) {
        for (cell, pair) in self.starts.windows(2).enumerate() {
            let here = &self.entries[pair[0] as usize..pair[1] as usize];
            for (n, &a) in here.iter().enumerate() {
                let of_a = &boxes[a as usize];
                for &b in &here[n + 1..] {
                    let of_b = &boxes[b as usize];
                    // Both lie in all cells that they have in common; they are visited in the first.
                    if of_a.overlaps(of_b) && self.number(self.cell(of_a.low.max(of_b.low))) == cell
                    {
                        visit(a as usize, b as usize);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Repeatable numbers from 0 to 1.
    fn numbers() -> impl FnMut() -> f64 {
        let mut state = 7u64;
        move || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        }
    }

    fn boxes(count: usize, size: DVec3) -> Vec<Aabb> {
        let mut next = numbers();
        let mut point = || DVec3::new(next(), next(), next());
        (0..count)
            .map(|_| {
                let low = point();
                Aabb::around(&[low, low + point() * size])
            })
            .collect()
    }

    fn found(boxes: &[Aabb]) -> Vec<(usize, usize)> {
        let mut pairs = Vec::new();
        overlapping_pairs(boxes, |a, b| pairs.push((a, b)));
        pairs.sort_unstable();
        pairs
    }

    fn expected(boxes: &[Aabb]) -> Vec<(usize, usize)> {
        (0..boxes.len())
            .flat_map(|a| (a + 1..boxes.len()).map(move |b| (a, b)))
            .filter(|&(a, b)| boxes[a].overlaps(&boxes[b]))
            .collect()
    }

    #[test]
    fn pairs_are_those_of_all_against_all() {
        // Small ones alike, for which the grid is made, and ones that are large beside what holds them.
        for (size, in_grid) in [
            (DVec3::new(0.3, 0.06, 0.06), true),
            (DVec3::splat(2.0), false),
        ] {
            let boxes = boxes(2000, size);
            assert_eq!(Grid::new(&boxes).is_some(), in_grid, "{size}");
            let expected = expected(&boxes);
            assert!(expected.len() > 500);
            assert_eq!(found(&boxes), expected);
        }
    }

    #[test]
    fn boxes_without_extent_at_grid_lines_and_of_no_numbers_are_no_trouble() {
        let at = |y: f64, z: f64| DVec3::new(0.0, y, z);
        let mut boxes: Vec<Aabb> = (0..100)
            .map(|i| Aabb::around(&[at(f64::from(i % 10), f64::from(i / 10))]))
            .collect();
        boxes.extend(boxes.clone());
        assert_eq!(found(&boxes).len(), 100);
        boxes.push(Aabb::EMPTY);
        boxes.push(Aabb {
            low: DVec3::NAN,
            high: DVec3::NAN,
        });
        assert_eq!(found(&boxes).len(), 100);
        boxes.push(Aabb::around(&[at(1.0, f64::INFINITY)]));
        assert_eq!(found(&boxes).len(), 100);
        assert!(found(&[]).is_empty());
    }
}
