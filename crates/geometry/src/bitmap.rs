//! Bitmaps with one bit per pixel, such as sections of solids. Rows are whole 64-bit words.

/// A bitmap of `width` × `height` pixels. Bit `x % 64` of word `x / 64` of row `y` is pixel (x, y); the bits beyond
/// `width` in a row's last word are always 0.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Bitmap {
    width: usize,
    height: usize,
    words: Vec<u64>,
}

impl Bitmap {
    /// Creates a bitmap of zeros.
    pub fn new(width: usize, height: usize) -> Self {
        Bitmap {
            width,
            height,
            words: vec![0; width.div_ceil(64) * height],
        }
    }

    /// Number of pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Number of words in a row.
    pub fn stride(&self) -> usize {
        self.width.div_ceil(64)
    }

    /// Pixel (x, y), which must lie in the bitmap.
    pub fn get(&self, x: usize, y: usize) -> bool {
        debug_assert!(x < self.width);
        self.words[y * self.stride() + x / 64] >> (x % 64) & 1 == 1
    }

    /// Sets pixel (x, y), which must lie in the bitmap.
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

    /// Number of set pixels.
    pub fn count(&self) -> usize {
        self.words.iter().map(|w| w.count_ones() as usize).sum()
    }

    /// Traces the borders of the set pixels along pixel edges: closed paths through pixel corners with set pixels on their
    /// left where y points up. Pixel (x, y) has the corners (x, y) to (x + 1, y + 1). Pixels that share only a corner are
    /// not connected.
    pub fn borders(&self) -> Vec<Vec<[usize; 2]>> {
        let at = |x: i64, y: i64| {
            let inside = x >= 0 && y >= 0 && x < self.width as i64 && y < self.height as i64;
            inside && self.get(x as usize, y as usize)
        };
        // Whether a border leaves corner (x, y) along +x, +y, −x, −y: the pixel on the left is set, that on the right not.
        let leaves = |x: i64, y: i64, direction: usize| {
            let around = [at(x, y), at(x - 1, y), at(x - 1, y - 1), at(x, y - 1)];
            around[direction] && !around[(direction + 3) % 4]
        };
        const STEPS: [(i64, i64); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];
        // Every border has a step along +x.
        let mut visited = Bitmap::new(self.width, self.height + 1);
        let mut borders = Vec::new();
        for y in 0..self.height as i64 {
            for x in 0..self.width as i64 {
                if !leaves(x, y, 0) || visited.get(x as usize, y as usize) {
                    continue;
                }
                let mut border = Vec::new();
                let (mut p, mut direction) = ((x, y), 0);
                loop {
                    border.push([p.0 as usize, p.1 as usize]);
                    if direction == 0 {
                        visited.set(p.0 as usize, p.1 as usize, true);
                    }
                    p = (p.0 + STEPS[direction].0, p.1 + STEPS[direction].1);
                    // Left first, which keeps to the same pixel.
                    direction = [1, 0, 3]
                        .map(|turn| (direction + turn) % 4)
                        .into_iter()
                        .find(|d| leaves(p.0, p.1, *d))
                        .unwrap_or(direction);
                    if p == (x, y) && direction == 0 {
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
    fn pixels_are_independent_across_words() {
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
    fn borders_enclose_the_pixels_and_their_holes() {
        // Pseudo-random pixels, some of which touch only at corners.
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
        // The enclosed area is the number of pixels, and every edge between a set and an unset pixel occurs once.
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
