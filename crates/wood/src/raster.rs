//! Filling outlines on a grid of pixels, a row at a time: the inside is found from crossings of the rows' middles.

use glam::DVec2;
use greenstick_geometry::Bitmap;
use std::ops::Range;

/// A square grid of pixels over a section: `count` × `count` pixels about the section's origin. Row 0 has the lowest y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelGrid {
    /// Pixels along a side.
    pub count: usize,
    /// Side of a pixel, m.
    pub pixel: f64,
}

impl PixelGrid {
    /// Centre of a pixel, m.
    pub fn pixel_centre(&self, x: usize, y: usize) -> DVec2 {
        let half = 0.5 * self.count as f64;
        DVec2::new(x as f64 + 0.5 - half, y as f64 + 0.5 - half) * self.pixel
    }

    /// A point (m) in pixels from the grid's corner.
    pub(crate) fn to_pixels(self, p: DVec2) -> DVec2 {
        p / self.pixel + 0.5 * self.count as f64
    }

    /// A point (m) in pixels from the centre of pixel (0, 0).
    pub(crate) fn to_pixel_centres(self, p: DVec2) -> DVec2 {
        p / self.pixel + DVec2::splat(0.5 * self.count as f64 - 0.5)
    }

    /// Side of the grid, m.
    pub fn side(&self) -> f64 {
        self.pixel * self.count as f64
    }

    /// A grid of `count` × `count` pixels over the same square.
    #[must_use]
    pub fn resampled(&self, count: usize) -> Self {
        PixelGrid {
            count,
            pixel: self.side() / count as f64,
        }
    }
}

/// Scan conversion of outlines. It holds the crossings of rows, and is reused from one outline to the next for its memory.
#[derive(Debug, Default)]
pub(crate) struct ScanConverter {
    /// Crossings in the order of the outline.
    crossings: Vec<(u32, Crossing)>,
    /// The same row by row, and where each row's end.
    by_row: Vec<Crossing>,
    ends: Vec<usize>,
}

/// Where an outline crosses the middle of a row.
#[derive(Debug, Clone, Copy, Default)]
struct Crossing {
    /// In pixels from the grid's corner.
    x: f64,
    /// 1 where the outline rises, -1 where it falls.
    turn: i32,
}

impl ScanConverter {
    /// Visits the row and pixels of every run of pixels whose centres lie within `outline` (m). It may cross itself: where its
    /// winding number is not 0 is inside.
    pub fn spans(
        &mut self,
        grid: &PixelGrid,
        outline: &[DVec2],
        mut visit: impl FnMut(usize, Range<usize>),
    ) {
        let count = grid.count as u32;
        let Some(&last) = outline.last() else {
            return;
        };
        self.crossings.clear();
        self.ends.clear();
        self.ends.resize(grid.count, 0);
        let mut from = grid.to_pixels(last);
        for &p in outline {
            let to = grid.to_pixels(p);
            let (a, b, turn) = if from.y < to.y {
                (from, to, 1)
            } else {
                (to, from, -1)
            };
            from = to;
            let rows = first_middle(a.y, count)..first_middle(b.y, count);
            if rows.is_empty() {
                continue;
            }
            let slope = (b.x - a.x) / (b.y - a.y);
            for y in rows {
                let x = a.x + (f64::from(y) + 0.5 - a.y) * slope;
                self.crossings.push((y, Crossing { x, turn }));
                self.ends[y as usize] += 1;
            }
        }
        self.sort_by_row();
        let mut start = 0;
        for (y, &end) in self.ends.iter().enumerate() {
            let row = &mut self.by_row[start..end];
            start = end;
            row.sort_unstable_by(|p, q| p.x.total_cmp(&q.x));
            let (mut winding, mut left) = (0, 0.0);
            for crossing in row {
                if winding == 0 {
                    left = crossing.x;
                }
                winding += crossing.turn;
                if winding == 0 {
                    let pixels = first_middle(left, count)..first_middle(crossing.x, count);
                    if !pixels.is_empty() {
                        visit(y, pixels.start as usize..pixels.end as usize);
                    }
                }
            }
        }
    }

    /// Puts the crossings row by row; `ends` holds the number of each row's before, and where they end after.
    fn sort_by_row(&mut self) {
        let mut start = 0;
        for end in &mut self.ends {
            (*end, start) = (start, start + *end);
        }
        self.by_row.resize(start, Crossing::default());
        for &(y, crossing) in &self.crossings {
            let end = &mut self.ends[y as usize];
            self.by_row[*end] = crossing;
            *end += 1;
        }
    }
}

/// The first pixel or row, of `count`, whose middle is not below a coordinate in pixels.
fn first_middle(v: f64, count: u32) -> u32 {
    // Rounded up without a call of `ceil`, for which not every processor has an instruction.
    let v = (v - 0.5).clamp(0.0, f64::from(count));
    let whole = v as u32;
    whole + u32::from(v > f64::from(whole))
}

/// Returns the pixels within loops (m); a loop within another is a hollow in it.
pub fn fill_loops(grid: &PixelGrid, loops: &[Vec<DVec2>]) -> Bitmap {
    let mut map = Bitmap::new(grid.count, grid.count);
    let mut converter = ScanConverter::default();
    for outline in loops {
        converter.spans(grid, outline, |y, pixels| flip(map.row_mut(y), pixels));
    }
    map
}

/// Inverts the bits of a row from `pixels.start` to before `pixels.end`.
fn flip(row: &mut [u64], pixels: Range<usize>) {
    let (first, last) = (pixels.start / 64, (pixels.end - 1) / 64);
    let low = u64::MAX << (pixels.start % 64);
    let high = u64::MAX >> (63 - (pixels.end - 1) % 64);
    if first == last {
        row[first] ^= low & high;
        return;
    }
    row[first] ^= low;
    row[first + 1..last].iter_mut().for_each(|w| *w = !*w);
    row[last] ^= high;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether `p` lies within an odd number of the loops, each by the winding of its edges as seen from `p`.
    fn within(loops: &[Vec<DVec2>], p: DVec2) -> bool {
        let winds = |l: &Vec<DVec2>| {
            let turn: f64 = (0..l.len())
                .map(|i| {
                    let (a, b) = (l[i] - p, l[(i + 1) % l.len()] - p);
                    a.perp_dot(b).atan2(a.dot(b))
                })
                .sum();
            turn.abs() > 3.0
        };
        loops.iter().filter(|l| winds(l)).count() % 2 == 1
    }

    #[test]
    fn pixels_inside_have_a_winding_number() {
        let ring = |radius: f64, lobes: f64, turn: f64| -> Vec<DVec2> {
            (0..97)
                .map(|i| turn * f64::from(i) * std::f64::consts::TAU / 97.0)
                .map(|a| DVec2::from_angle(a) * radius * (1.0 + 0.4 * (lobes * a).sin()) + 0.013)
                .collect()
        };
        // A lobed outline that crosses the grid's edge, a hollow in it, and a pentagram, which crosses itself.
        let star = (0..5)
            .map(|i| DVec2::from_angle(f64::from(i) * 2.513_274) * 0.2 - 0.3)
            .collect();
        let loops = [ring(0.5, 5.0, 1.0), ring(0.15, 3.0, -1.0), star];
        for count in [64, 130] {
            let grid = PixelGrid {
                count,
                pixel: 1.1 / count as f64,
            };
            let map = fill_loops(&grid, &loops);
            for y in 0..count {
                for x in 0..count {
                    assert_eq!(
                        map.get(x, y),
                        within(&loops, grid.pixel_centre(x, y)),
                        "{x} {y} of {count}"
                    );
                }
            }
        }
    }
}
