//! Pairs of boxes that overlap, found in columns along the first axis.
//!
//! Triangles of a broken face are alike: long along the grain and narrow across it. Boxes are sorted along that axis once and
//! placed in the columns of a grid across it; within a column each is compared with those that begin before it ends, eight at a
//! time and in `f32`. That costs far less than a tree does to build. Where a column is crowded all along, a tree of its boxes is
//! used instead.

use crate::{Aabb, Bvh};
use glam::DVec3;

/// Size of a cell of the grid, mean sizes of boxes.
const CELL_SIZE: f64 = 2.5;
/// Most cells for each box; where there would be more, cells are larger.
const MAX_CELLS: f64 = 4.0;
/// Most cells that a box may cover on average; beyond, a tree is faster.
const MAX_CELLS_PER_BOX: usize = 8;
/// Most comparisons in a column for each of its boxes; beyond, a tree is faster.
const MAX_PAIRS_PER_BOX: usize = 128;
/// Boxes that are compared with one at a time: as many as compilers make vector instructions of.
const BLOCK: usize = 8;

/// Visits every pair of different boxes that overlap once, the smaller index first, in no particular order. Boxes that are
/// empty or have a coordinate that is not a number overlap nothing.
pub(crate) fn overlapping_pairs(boxes: &[Aabb], mut visit: impl FnMut(usize, usize)) {
    let Some(grid) = Grid::new(boxes) else {
        return Bvh::new(boxes).self_pairs(visit);
    };
    let mut column = Column::default();
    for (cell, pair) in grid.starts.windows(2).enumerate() {
        let members = &grid.entries[pair[0] as usize..pair[1] as usize];
        if members.len() < 2 {
            continue;
        }
        let check = |a: u32, b: u32| {
            let (a, b) = (a.min(b) as usize, a.max(b) as usize);
            let (of_a, of_b) = (&boxes[a], &boxes[b]);
            // Both lie in all cells that they have in common; they are visited in the first.
            if of_a.overlaps(of_b) && grid.number(grid.cell(of_a.low.max(of_b.low))) == cell {
                visit(a, b);
            }
        };
        column.take(members, boxes, grid.low);
        column.pairs(members, boxes, check);
    }
}

/// Boxes by the cells that they cover across the first axis, ascending along it in each.
struct Grid {
    low: DVec3,
    /// Cells per unit of length, along the second and the third axis.
    scale: [f64; 2],
    /// Cells along these axes.
    size: [usize; 2],
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
        while sizes(cell).y * sizes(cell).z > MAX_CELLS * boxes.len() as f64 {
            cell *= 1.25;
        }
        let size = sizes(cell);
        let mut grid = Grid {
            low: all.low,
            scale: [size.y / extent.y, size.z / extent.z],
            size: [size.y as usize, size.z as usize],
            starts: Vec::new(),
            entries: Vec::new(),
        };
        grid.fill(boxes).then_some(grid)
    }

    /// Counts and places the boxes. Returns whether they cover few enough cells.
    fn fill(&mut self, boxes: &[Aabb]) -> bool {
        let mut starts = vec![0u32; self.size.iter().product::<usize>() + 1];
        let mut count = 0;
        for b in boxes {
            count += self.each_cell(b, |cell| starts[cell] += 1);
            if count > MAX_CELLS_PER_BOX * boxes.len() {
                return false;
            }
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        // The bits of numbers that are not negative ascend as they do.
        let along = |b: &Aabb| (b.low.x - self.low.x) as f32 + 0.0;
        let order = (0u64..).zip(boxes);
        let mut order: Vec<u64> = order
            .map(|(i, b)| u64::from(along(b).to_bits()) << 32 | i)
            .collect();
        order.sort_unstable();
        let mut entries = vec![0; count];
        for index in order.into_iter().rev().map(|key| key as u32) {
            self.each_cell(&boxes[index as usize], |cell| {
                starts[cell] -= 1;
                entries[starts[cell] as usize] = index;
            });
        }
        (self.starts, self.entries) = (starts, entries);
        true
    }

    /// The cell of a point along the second and the third axis; that of the nearest cell for one outside or not a number.
    fn cell(&self, at: DVec3) -> [usize; 2] {
        let at = at - self.low;
        [
            ((at.y * self.scale[0]) as usize).min(self.size[0] - 1),
            ((at.z * self.scale[1]) as usize).min(self.size[1] - 1),
        ]
    }

    fn number(&self, [j, k]: [usize; 2]) -> usize {
        j * self.size[1] + k
    }

    /// Visits the cells that a box covers. Returns how many there are.
    fn each_cell(&self, b: &Aabb, mut visit: impl FnMut(usize)) -> usize {
        let (from, to) = (self.cell(b.low), self.cell(b.high));
        let mut count = 0;
        for j in from[0]..=to[0] {
            for k in from[1]..=to[1] {
                visit(self.number([j, k]));
                count += 1;
            }
        }
        count
    }
}

/// The boxes of one cell, ascending along the first axis, rounded to `f32`: rounding keeps the order of numbers, so that boxes that
/// overlap still do. Behind them lie [`BLOCK`] that overlap none.
#[derive(Default)]
struct Column {
    low: [Vec<f32>; 3],
    high: [Vec<f32>; 3],
}

impl Column {
    fn take(&mut self, members: &[u32], boxes: &[Aabb], origin: DVec3) {
        for k in 0..3 {
            let of = |at: DVec3| (at[k] - origin[k]) as f32;
            let members = || members.iter().map(|&i| &boxes[i as usize]);
            for (list, is_low) in [(&mut self.low[k], true), (&mut self.high[k], false)] {
                list.clear();
                list.extend(members().map(|b| of(if is_low { b.low } else { b.high })));
                list.extend([f32::NAN; BLOCK]);
            }
        }
    }

    /// Visits pairs of members, all among them that overlap.
    fn pairs(&self, members: &[u32], boxes: &[Aabb], mut visit: impl FnMut(u32, u32)) {
        if self.is_crowded(members.len()) {
            let boxes: Vec<Aabb> = members.iter().map(|&i| boxes[i as usize]).collect();
            return Bvh::new(&boxes).self_pairs(|a, b| visit(members[a], members[b]));
        }
        let [low, high] = [&self.low, &self.high];
        for a in 0..members.len() {
            let (from, to) = ([low[1][a], low[2][a]], [high[0][a], high[1][a], high[2][a]]);
            let mut start = a + 1;
            while low[0][start] <= to[0] {
                let block = start..start + BLOCK;
                let [x0, y0, z0] = [0, 1, 2].map(|k| &low[k][block.clone()]);
                let [y1, z1] = [1, 2].map(|k| &high[k][block.clone()]);
                let mut near = [0u8; BLOCK];
                for i in 0..BLOCK {
                    let overlaps = (x0[i] <= to[0])
                        & (y0[i] <= to[1])
                        & (z0[i] <= to[2])
                        & (from[0] <= y1[i])
                        & (from[1] <= z1[i]);
                    near[i] = u8::from(overlaps);
                }
                let mut near = u64::from_le_bytes(near);
                while near != 0 {
                    visit(members[a], members[start + near.trailing_zeros() as usize / 8]);
                    near &= near - 1;
                }
                start += BLOCK;
            }
        }
    }

    /// Whether too many boxes begin before others end.
    fn is_crowded(&self, count: usize) -> bool {
        // Fewer cannot be.
        if count <= 2 * MAX_PAIRS_PER_BOX {
            return false;
        }
        let begin = &self.low[0][..count];
        let after = |a: usize| begin.partition_point(|&x| x <= self.high[0][a]);
        let pairs: usize = (0..count).map(|a| after(a).saturating_sub(a + 1)).sum();
        pairs > MAX_PAIRS_PER_BOX * count
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
        // Small ones alike; ones as long as all together; ones that are large beside what holds them.
        for (size, in_columns) in [
            (DVec3::new(0.3, 0.06, 0.06), true),
            (DVec3::new(1.0, 0.1, 0.1), true),
            (DVec3::splat(2.0), false),
        ] {
            let boxes = boxes(2000, size);
            let grid = Grid::new(&boxes).unwrap();
            let crowded = grid.starts.windows(2).any(|cell| {
                let members = &grid.entries[cell[0] as usize..cell[1] as usize];
                let mut column = Column::default();
                column.take(members, &boxes, grid.low);
                column.is_crowded(members.len())
            });
            assert_eq!(crowded, !in_columns, "{size}");
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
