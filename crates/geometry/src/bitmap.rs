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
}
