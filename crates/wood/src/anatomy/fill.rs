//! Filling outlines on a grid of pixels, a row at a time: what lies within is found from crossings of the rows' middles.

use glam::DVec2;
use greenstick_geometry::Bitmap;
use std::ops::Range;

/// A square picture over a section: `count` × `count` pixels, the middle of it at the section's origin. Row 0 is that
/// of the lowest y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Pixels along a side.
    pub count: usize,
    /// Side of a pixel, m.
    pub pixel: f64,
}

impl Grid {
    /// Middle of a pixel, m.
    pub fn middle(&self, x: usize, y: usize) -> DVec2 {
        let half = 0.5 * self.count as f64;
        DVec2::new(x as f64 + 0.5 - half, y as f64 + 0.5 - half) * self.pixel
    }

    fn place(&self, p: DVec2) -> DVec2 {
        p / self.pixel + 0.5 * self.count as f64
    }
}

/// Rows' crossings with outlines; kept from one outline to the next for its memory.
#[derive(Debug, Default)]
pub(crate) struct Scan {
    rows: Vec<Vec<(f64, i32)>>,
}

impl Scan {
    /// Calls `span` with the row and pixels of every run of pixels whose middles lie within `outline` (m), which may
    /// cross itself: what it winds about is within.
    pub fn spans(
        &mut self,
        grid: &Grid,
        outline: &[DVec2],
        mut span: impl FnMut(usize, Range<usize>),
    ) {
        let count = grid.count;
        self.rows.resize_with(count, Vec::new);
        let Some(&last) = outline.last() else {
            return;
        };
        // The first pixel or row whose middle is not below a coordinate.
        let first = |v: f64| (v - 0.5).ceil().clamp(0.0, count as f64) as usize;
        let mut from = grid.place(last);
        let (mut low, mut high) = (count, 0);
        for &p in outline {
            let to = grid.place(p);
            let (a, b, turn) = if from.y < to.y {
                (from, to, 1)
            } else {
                (to, from, -1)
            };
            from = to;
            let rows = first(a.y)..first(b.y);
            if rows.is_empty() {
                continue;
            }
            (low, high) = (low.min(rows.start), high.max(rows.end));
            let slope = (b.x - a.x) / (b.y - a.y);
            for y in rows {
                let x = a.x + (y as f64 + 0.5 - a.y) * slope;
                self.rows[y].push((x, turn));
            }
        }
        for y in low..high {
            let row = &mut self.rows[y];
            row.sort_unstable_by(|p, q| p.0.total_cmp(&q.0));
            let (mut winding, mut start) = (0, 0.0);
            for &(x, turn) in row.iter() {
                if winding == 0 {
                    start = x;
                }
                winding += turn;
                if winding == 0 {
                    let pixels = first(start)..first(x);
                    if !pixels.is_empty() {
                        span(y, pixels);
                    }
                }
            }
            row.clear();
        }
    }
}

/// The pixels within loops; a loop within another is a hollow in it.
pub fn fill(grid: &Grid, loops: &[Vec<DVec2>]) -> Bitmap {
    let mut map = Bitmap::new(grid.count, grid.count);
    let mut scan = Scan::default();
    for outline in loops {
        scan.spans(grid, outline, |y, pixels| flip(map.row_mut(y), pixels));
    }
    map
}

/// Turns over the bits of a row from `pixels.start` to before `pixels.end`.
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
    fn pixels_are_those_that_the_outline_winds_about() {
        let ring = |radius: f64, lobes: f64, turn: f64| -> Vec<DVec2> {
            (0..97)
                .map(|i| turn * f64::from(i) * std::f64::consts::TAU / 97.0)
                .map(|a| DVec2::from_angle(a) * radius * (1.0 + 0.4 * (lobes * a).sin()) + 0.013)
                .collect()
        };
        // A lobed outline that crosses the picture's edge, a hollow in it, and a pentagram, which crosses itself.
        let star = (0..5)
            .map(|i| DVec2::from_angle(f64::from(i) * 2.513_274) * 0.2 - 0.3)
            .collect();
        let loops = [ring(0.5, 5.0, 1.0), ring(0.15, 3.0, -1.0), star];
        for count in [64, 130] {
            let grid = Grid {
                count,
                pixel: 1.1 / count as f64,
            };
            let map = fill(&grid, &loops);
            for y in 0..count {
                for x in 0..count {
                    assert_eq!(
                        map.get(x, y),
                        within(&loops, grid.middle(x, y)),
                        "{x} {y} of {count}"
                    );
                }
            }
        }
    }
}
