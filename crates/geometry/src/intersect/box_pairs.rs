//! Pairs of boxes that overlap, found in columns along the first axis.
//!
//! Triangles of a broken face are alike: long along the grain and narrow across it. Boxes are sorted along that axis once and
//! placed in the columns of a grid across it; within a column each is compared with those that begin before it ends, eight at a
//! time and in `f32`. That costs far less than a tree does to build. Where a column is crowded all along, a tree of its boxes is
//! used instead.

use crate::{Aabb, Bvh, Cancelled, Context};
use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

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
/// Least number of columns that a thread takes.
const COLUMNS: usize = 16;

/// Returns the pairs of different boxes that overlap, at least one of them among the first `chosen`, and that are `wanted`: called
/// once for each pair, the smaller index first. Pairs are ascending. Boxes that are empty or have a coordinate that is not a number
/// overlap nothing.
///
/// # Errors
/// [`Cancelled`] where the caller cancelled.
pub(crate) fn overlapping_pairs(
    boxes: &[Aabb],
    chosen: usize,
    wanted: impl Fn(usize, usize) -> bool + Sync,
    context: &Context,
) -> Result<Vec<[u32; 2]>, Cancelled> {
    let mut pairs = match Grid::new(boxes, context)? {
        Some(grid) => grid.pairs(boxes, chosen, wanted, context),
        None => {
            let mut pairs = Vec::new();
            Bvh::new(boxes).self_pairs_while(|a, b| {
                if a < chosen && wanted(a, b) {
                    pairs.push([a as u32, b as u32]);
                }
                context.check().is_ok()
            });
            pairs
        }
    };
    context.check()?;
    pairs.sort_unstable();
    Ok(pairs)
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
    fn new(boxes: &[Aabb], context: &Context) -> Result<Option<Grid>, Cancelled> {
        let all = boxes.iter().fold(Aabb::EMPTY, |a, b| a.join(b));
        let extent = all.high - all.low;
        let sum: DVec3 = boxes.iter().map(|b| b.high - b.low).sum();
        let mean = sum / boxes.len() as f64;
        if !(mean.is_finite() && extent.is_finite() && mean.min_element() > 0.0) {
            return Ok(None);
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
        Ok(grid.fill(boxes, context)?.then_some(grid))
    }

    /// Counts and places the boxes. Returns whether they cover few enough cells.
    fn fill(&mut self, boxes: &[Aabb], context: &Context) -> Result<bool, Cancelled> {
        let mut starts = vec![0u32; self.size.iter().product::<usize>() + 1];
        let mut count = 0;
        for b in boxes {
            count += self.each_cell(b, |cell| starts[cell] += 1);
            if count > MAX_CELLS_PER_BOX * boxes.len() {
                return Ok(false);
            }
        }
        context.check()?;
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
        context.check()?;
        let mut entries = vec![0; count];
        for index in order.into_iter().rev().map(|key| key as u32) {
            self.each_cell(&boxes[index as usize], |cell| {
                starts[cell] -= 1;
                entries[starts[cell] as usize] = index;
            });
        }
        (self.starts, self.entries) = (starts, entries);
        Ok(true)
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

    /// The pairs of [`overlapping_pairs`], in no particular order; only some of them where the caller cancelled.
    fn pairs(
        &self,
        boxes: &[Aabb],
        chosen: usize,
        wanted: impl Fn(usize, usize) -> bool + Sync,
        context: &Context,
    ) -> Vec<[u32; 2]> {
        let in_cell = |(mut column, mut pairs): (Column, Vec<[u32; 2]>), cell: usize| {
            if context.check().is_err() {
                return (column, pairs);
            }
            let members = &self.entries[self.starts[cell] as usize..self.starts[cell + 1] as usize];
            column.take(self, cell, (members, boxes), chosen);
            let visit = |a: u32, b: u32| {
                let (a, b) = (a.min(b), a.max(b));
                let [i, j] = [a, b].map(|i| i as usize);
                if boxes[i].overlaps(&boxes[j]) && wanted(i, j) {
                    pairs.push([a, b]);
                }
            };
            column.pairs((members, boxes), visit, context);
            (column, pairs)
        };
        let cells = (0..self.starts.len() - 1).into_par_iter();
        let found = cells
            .with_min_len(COLUMNS)
            .fold(<(Column, Vec<[u32; 2]>)>::default, in_cell);
        found
            .map(|(_, pairs)| pairs)
            .reduce(Vec::new, |mut all, mut more| {
                all.append(&mut more);
                all
            })
    }
}

/// The boxes of one cell, ascending along the first axis, rounded to `f32`: rounding keeps the order of numbers, so that boxes that
/// overlap still do. Behind them lie [`BLOCK`] that overlap none.
#[derive(Default)]
struct Column {
    low: [Vec<f32>; 3],
    high: [Vec<f32>; 3],
    /// Of each box, whether the cell is the first that it covers along each axis, and whether it is chosen. Two boxes lie in all
    /// cells that they have in common; they are looked at where their flags make up [`ALL_FLAGS`].
    flags: Vec<u8>,
    /// Places of the chosen boxes.
    chosen: Vec<u32>,
}

const FIRST: [u8; 2] = [1, 2];
const CHOSEN: u8 = 4;
const ALL_FLAGS: u8 = 7;

impl Column {
    /// Takes the members of a cell.
    fn take(
        &mut self,
        grid: &Grid,
        cell: usize,
        (members, boxes): (&[u32], &[Aabb]),
        chosen: usize,
    ) {
        self.chosen.clear();
        let places = (0u32..).zip(members);
        let is_chosen = |i: u32| (i as usize) < chosen;
        self.chosen.extend(
            places
                .filter(|(_, i)| is_chosen(**i))
                .map(|(place, _)| place),
        );
        if self.chosen.is_empty() {
            return;
        }
        let here = [cell / grid.size[1], cell % grid.size[1]];
        let members = || members.iter().map(|&i| (i, &boxes[i as usize]));
        for k in 0..3 {
            let of = |at: DVec3| (at[k] - grid.low[k]) as f32;
            self.low[k].clear();
            self.low[k].extend(members().map(|(_, b)| of(b.low)));
            self.high[k].clear();
            self.high[k].extend(members().map(|(_, b)| of(b.high)));
            for list in [&mut self.low[k], &mut self.high[k]] {
                list.extend([f32::NAN; BLOCK]);
            }
        }
        self.flags.clear();
        self.flags.extend(members().map(|(i, b)| {
            let from = grid.cell(b.low);
            let first = [0, 1].map(|k| if from[k] == here[k] { FIRST[k] } else { 0 });
            first[0] | first[1] | if is_chosen(i) { CHOSEN } else { 0 }
        }));
        self.flags.extend([0; BLOCK]);
    }

    /// Visits the pairs of members that overlap in `f32`, one of them chosen, of which this cell is the first in common, until the
    /// caller cancels.
    fn pairs(
        &self,
        (members, boxes): (&[u32], &[Aabb]),
        mut visit: impl FnMut(u32, u32),
        context: &Context,
    ) {
        if self.chosen.is_empty() || members.len() < 2 {
            return;
        }
        if self.is_crowded(members.len()) {
            let boxes: Vec<Aabb> = members.iter().map(|&i| boxes[i as usize]).collect();
            return Bvh::new(&boxes).self_pairs_while(|a, b| {
                if self.flags[a] | self.flags[b] == ALL_FLAGS {
                    visit(members[a], members[b]);
                }
                context.check().is_ok()
            });
        }
        let mut chosen = &self.chosen[..];
        for a in 0..members.len() {
            if context.check().is_err() {
                return;
            }
            let mut visit = |b: usize| visit(members[a], members[b]);
            if self.flags[a] & CHOSEN != 0 {
                self.after(a, visit);
                continue;
            }
            while let [first, rest @ ..] = chosen
                && *first as usize <= a
            {
                chosen = rest;
            }
            for &b in chosen {
                let b = b as usize;
                if self.low[0][b] > self.high[0][a] {
                    break;
                }
                if self.block(a, b) & 1 != 0 {
                    visit(b);
                }
            }
        }
    }

    /// Visits the places behind that of a box whose boxes overlap with it.
    fn after(&self, a: usize, mut visit: impl FnMut(usize)) {
        let mut start = a + 1;
        while self.low[0][start] <= self.high[0][a] {
            let mut near = self.block(a, start);
            while near != 0 {
                visit(start + near.trailing_zeros() as usize / 8);
                near &= near - 1;
            }
            start += BLOCK;
        }
    }

    /// Which of the boxes from place `start` are to be looked at beside that at `a`: a byte for each, 1 or 0.
    #[inline]
    fn block(&self, a: usize, start: usize) -> u64 {
        let [low, high] = [&self.low, &self.high];
        let (from, to) = ([low[1][a], low[2][a]], [high[0][a], high[1][a], high[2][a]]);
        let block = start..start + BLOCK;
        let [x0, y0, z0] = [0, 1, 2].map(|k| &low[k][block.clone()]);
        let [y1, z1] = [1, 2].map(|k| &high[k][block.clone()]);
        let flags = &self.flags[block];
        let mut near = [0u8; BLOCK];
        for i in 0..BLOCK {
            let overlaps = (x0[i] <= to[0])
                & (y0[i] <= to[1])
                & (z0[i] <= to[2])
                & (from[0] <= y1[i])
                & (from[1] <= z1[i]);
            near[i] = u8::from(overlaps & (flags[i] | self.flags[a] == ALL_FLAGS));
        }
        u64::from_le_bytes(near)
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

    fn found(boxes: &[Aabb], chosen: usize) -> Vec<[u32; 2]> {
        overlapping_pairs(boxes, chosen, |_, _| true, &Context::quiet()).unwrap()
    }

    fn expected(boxes: &[Aabb], chosen: usize) -> Vec<[u32; 2]> {
        (0..chosen)
            .flat_map(|a| (a + 1..boxes.len()).map(move |b| [a, b]))
            .filter(|&[a, b]| boxes[a].overlaps(&boxes[b]))
            .map(|pair| pair.map(|i| i as u32))
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
            let grid = Grid::new(&boxes, &Context::quiet()).unwrap().unwrap();
            let crowded = grid.starts.windows(2).any(|cell| {
                let members = &grid.entries[cell[0] as usize..cell[1] as usize];
                let mut column = Column::default();
                column.take(&grid, 0, (members, &boxes), boxes.len());
                column.is_crowded(members.len())
            });
            assert_eq!(crowded, !in_columns, "{size}");
            for chosen in [2000, 300] {
                let expected = expected(&boxes, chosen);
                assert!(expected.len() > chosen / 4);
                assert_eq!(found(&boxes, chosen), expected);
            }
        }
    }

    #[test]
    fn boxes_without_extent_at_grid_lines_and_of_no_numbers_are_no_trouble() {
        let at = |y: f64, z: f64| DVec3::new(0.0, y, z);
        let mut boxes: Vec<Aabb> = (0..100)
            .map(|i| Aabb::around(&[at(f64::from(i % 10), f64::from(i / 10))]))
            .collect();
        boxes.extend(boxes.clone());
        assert_eq!(found(&boxes, usize::MAX).len(), 100);
        boxes.push(Aabb::EMPTY);
        boxes.push(Aabb {
            low: DVec3::NAN,
            high: DVec3::NAN,
        });
        assert_eq!(found(&boxes, usize::MAX).len(), 100);
        boxes.push(Aabb::around(&[at(1.0, f64::INFINITY)]));
        assert_eq!(found(&boxes, usize::MAX).len(), 100);
        assert!(found(&[], 1).is_empty());
    }
}
