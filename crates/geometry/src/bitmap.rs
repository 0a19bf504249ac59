//! Pictures of one bit a pixel: sections of solids, a row in whole 64-bit words.

/// A picture of `width` × `height` bits. Bit `x % 64` of word `x / 64` of row `y` is pixel (x, y); the bits beyond
/// `width` in a row's last word are always 0.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Bitmap {
    width: usize,
    height: usize,
    words: Vec<u64>,
}

impl Bitmap {
    /// A picture of zeros.
    pub fn new(width: usize, height: usize) -> Self {
        Bitmap {
            width,
            height,
            words: vec![0; width.div_ceil(64) * height],
        }
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Words in a row.
    pub fn stride(&self) -> usize {
        self.width.div_ceil(64)
    }

    /// Pixel (x, y), which must lie in the picture.
    pub fn get(&self, x: usize, y: usize) -> bool {
        debug_assert!(x < self.width);
        self.words[y * self.stride() + x / 64] >> (x % 64) & 1 == 1
    }

    /// Sets pixel (x, y), which must lie in the picture.
    pub fn set(&mut self, x: usize, y: usize, value: bool) {
        debug_assert!(x < self.width);
        let stride = self.stride();
        let word = &mut self.words[y * stride + x / 64];
        let bit = 1 << (x % 64);
        *word = if value { *word | bit } else { *word & !bit };
    }

    /// The words of row `y`.
    pub fn row(&self, y: usize) -> &[u64] {
        &self.words[y * self.stride()..][..self.stride()]
    }

    /// The words of row `y`; the bits beyond the width must stay 0.
    pub fn row_mut(&mut self, y: usize) -> &mut [u64] {
        let stride = self.stride();
        &mut self.words[y * stride..][..stride]
    }

    /// Number of pixels that are set.
    pub fn count(&self) -> usize {
        self.words.iter().map(|w| w.count_ones() as usize).sum()
    }

    /// The borders of what is set, along the pixels' edges: closed walks through pixel corners, each a step from the one
    /// before, set pixels on their left where y points up. Pixel (x, y) has the corners (x, y) to (x + 1, y + 1). Pixels
    /// that share no more than a corner are apart.
    pub fn borders(&self) -> Vec<Vec<[usize; 2]>> {
        let at = |x: i64, y: i64| {
            let inside = x >= 0 && y >= 0 && x < self.width as i64 && y < self.height as i64;
            inside && self.get(x as usize, y as usize)
        };
        // Whether the border leaves corner (x, y) along +x, +y, −x, −y: the pixel on the left is set, that on the right not.
        let leaves = |x: i64, y: i64, way: usize| {
            let around = [at(x, y), at(x - 1, y), at(x - 1, y - 1), at(x, y - 1)];
            around[way] && !around[(way + 3) % 4]
        };
        const STEPS: [(i64, i64); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];
        // Every walk has a step along +x.
        let mut walked = Bitmap::new(self.width, self.height + 1);
        let mut borders = Vec::new();
        for y in 0..self.height as i64 {
            for x in 0..self.width as i64 {
                if !leaves(x, y, 0) || walked.get(x as usize, y as usize) {
                    continue;
                }
                let mut border = Vec::new();
                let (mut p, mut way) = ((x, y), 0);
                loop {
                    border.push([p.0 as usize, p.1 as usize]);
                    if way == 0 {
                        walked.set(p.0 as usize, p.1 as usize, true);
                    }
                    p = (p.0 + STEPS[way].0, p.1 + STEPS[way].1);
                    // To the left first, which stays with the pixel.
                    way = [1, 0, 3]
                        .map(|turn| (way + turn) % 4)
                        .into_iter()
                        .find(|w| leaves(p.0, p.1, *w))
                        .unwrap_or(way);
                    if p == (x, y) && way == 0 {
                        break;
                    }
                }
                borders.push(border);
            }
        }
        borders
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_kept_apart_across_words() {
        let mut map = Bitmap::new(130, 3);
        let set = [(0, 0), (63, 1), (64, 1), (129, 2)];
        for (x, y) in set {
            map.set(x, y, true);
        }
        let found: Vec<_> = (0..3)
            .flat_map(|y| (0..130).map(move |x| (x, y)))
            .filter(|&(x, y)| map.get(x, y))
            .collect();
        assert_eq!(found, set);
        map.set(63, 1, false);
        assert_eq!(map.count(), 3);
    }

    #[test]
    fn borders_hold_the_pixels_and_their_holes() {
        // Pixels by a simple generator, so that they touch at corners, too.
        let mut map = Bitmap::new(70, 40);
        let mut state = 1u32;
        for y in 0..40 {
            for x in 0..70 {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                map.set(x, y, state >> 30 != 0);
            }
        }
        let borders = map.borders();
        let mut twice = 0;
        let mut length = 0;
        for border in &borders {
            for (i, [x, y]) in border.iter().enumerate() {
                let [u, v] = border[(i + 1) % border.len()];
                assert_eq!(x.abs_diff(u) + y.abs_diff(v), 1);
                twice += (x * v) as i64 - (u * y) as i64;
            }
            length += border.len();
        }
        // The area within is the number of pixels, and every edge between a pixel and none is walked once.
        assert_eq!(twice, 2 * map.count() as i64);
        let get = |x: usize, y: usize| x < 70 && y < 40 && map.get(x, y);
        let mut edges = 0;
        for y in 0..41 {
            for x in 0..71 {
                let here = get(x, y);
                edges += usize::from(here != (x > 0 && get(x - 1, y)));
                edges += usize::from(here != (y > 0 && get(x, y - 1)));
            }
        }
        assert_eq!(length, edges);
        let mut ring = Bitmap::new(3, 3);
        for (x, y) in [
            (0, 0),
            (1, 0),
            (2, 0),
            (0, 1),
            (2, 1),
            (0, 2),
            (1, 2),
            (2, 2),
        ] {
            ring.set(x, y, true);
        }
        let mut lengths: Vec<usize> = ring.borders().iter().map(Vec::len).collect();
        lengths.sort_unstable();
        assert_eq!(lengths, [4, 12]);
    }
}
