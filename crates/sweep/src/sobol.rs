//! Sobol' points: a sequence in many dimensions that fills space more evenly than random points do.
//!
//! Direction numbers are those of S. Joe and F. Y. Kuo, *Constructing Sobol sequences with better two-dimensional projections*,
//! SIAM J. Sci. Comput. 30 (2008), table `new-joe-kuo-6`; points are in the order of Gray codes, as in Bratley and Fox 1988.

/// Most dimensions.
pub const MAX_DIMENSIONS: usize = 32;
/// Bits of a coordinate, and of the number of a point.
const BITS: u32 = 32;

/// Of each dimension after the first, the primitive polynomial and the initial direction numbers.
const DIRECTIONS: [(u32, &[u32]); MAX_DIMENSIONS - 1] = [
    (3, &[1]),
    (7, &[1, 3]),
    (11, &[1, 3, 1]),
    (13, &[1, 1, 1]),
    (19, &[1, 1, 3, 3]),
    (25, &[1, 3, 5, 13]),
    (37, &[1, 1, 5, 5, 17]),
    (41, &[1, 1, 5, 5, 5]),
    (47, &[1, 1, 7, 11, 19]),
    (55, &[1, 1, 5, 1, 1]),
    (59, &[1, 1, 1, 3, 11]),
    (61, &[1, 3, 5, 5, 31]),
    (67, &[1, 3, 3, 9, 7, 49]),
    (91, &[1, 1, 1, 15, 21, 21]),
    (97, &[1, 3, 1, 13, 27, 49]),
    (103, &[1, 1, 1, 15, 7, 5]),
    (109, &[1, 3, 1, 15, 13, 25]),
    (115, &[1, 1, 5, 5, 19, 61]),
    (131, &[1, 3, 7, 11, 23, 15, 103]),
    (137, &[1, 3, 7, 13, 13, 15, 69]),
    (143, &[1, 1, 3, 13, 7, 35, 63]),
    (145, &[1, 3, 5, 9, 1, 25, 53]),
    (157, &[1, 3, 1, 13, 9, 35, 107]),
    (167, &[1, 3, 1, 5, 27, 61, 31]),
    (171, &[1, 1, 5, 11, 19, 41, 61]),
    (185, &[1, 3, 5, 3, 3, 13, 69]),
    (191, &[1, 1, 7, 13, 1, 19, 1]),
    (193, &[1, 3, 7, 5, 13, 19, 59]),
    (203, &[1, 1, 3, 9, 25, 29, 41]),
    (211, &[1, 3, 5, 13, 23, 1, 55]),
    (213, &[1, 3, 7, 3, 13, 59, 17]),
];

/// The direction numbers of a dimension, the most significant bit first.
fn directions(dimension: usize) -> [u32; BITS as usize] {
    let mut v = [0; BITS as usize];
    let Some((polynomial, first)) = dimension.checked_sub(1).map(|d| DIRECTIONS[d]) else {
        // The van der Corput sequence.
        for (k, v) in v.iter_mut().enumerate() {
            *v = 1 << (BITS - 1 - k as u32);
        }
        return v;
    };
    let degree = first.len();
    for (k, m) in first.iter().enumerate() {
        v[k] = m << (BITS - 1 - k as u32);
    }
    for k in degree..BITS as usize {
        v[k] = v[k - degree] ^ (v[k - degree] >> degree);
        for j in 1..degree {
            if polynomial >> (degree - j) & 1 == 1 {
                v[k] ^= v[k - j];
            }
        }
    }
    v
}

/// Returns a coordinate of a point, as 32 bits after the binary point. Dimensions from [`MAX_DIMENSIONS`] on are those below it
/// again.
///
/// ```
/// use greenstick_sweep::sobol::coordinate;
///
/// assert_eq!(coordinate(2, 0), 3 << 30); // 0.75
/// assert_eq!(coordinate(2, 1), 1 << 30); // 0.25
/// ```
pub fn coordinate(number: u32, dimension: usize) -> u32 {
    let directions = directions(dimension % MAX_DIMENSIONS);
    let gray = number ^ (number >> 1);
    directions
        .iter()
        .enumerate()
        .filter(|(bit, _)| gray >> bit & 1 == 1)
        .fold(0, |x, (_, v)| x ^ v)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(number: u32, dimension: usize) -> f64 {
        f64::from(coordinate(number, dimension)) / 2.0_f64.powi(32)
    }

    /// What `scipy.stats.qmc.Sobol(d, scramble=False, bits=32)` of SciPy gives.
    #[test]
    fn points_are_those_of_scipy() {
        let first = [
            [0.0; 8],
            [0.5; 8],
            [0.75, 0.25, 0.25, 0.25, 0.75, 0.75, 0.25, 0.75],
            [0.25, 0.75, 0.75, 0.75, 0.25, 0.25, 0.75, 0.25],
            [0.375, 0.375, 0.625, 0.875, 0.375, 0.125, 0.375, 0.875],
            [0.875, 0.875, 0.125, 0.375, 0.875, 0.625, 0.875, 0.375],
            [0.625, 0.125, 0.875, 0.625, 0.625, 0.875, 0.125, 0.125],
            [0.125, 0.625, 0.375, 0.125, 0.125, 0.375, 0.625, 0.625],
        ];
        for (number, point) in first.iter().enumerate() {
            for (dimension, expected) in point.iter().enumerate() {
                assert_eq!(
                    at(number as u32, dimension),
                    *expected,
                    "{number} {dimension}"
                );
            }
        }
        let far = [
            (1023, 0, 0.0009765625),
            (1023, 1, 0.7529296875),
            (1023, 2, 0.6123046875),
            (1023, 7, 0.6181640625),
            (1023, 15, 0.4638671875),
            (1023, 31, 0.6142578125),
            (777, 5, 0.3564453125),
            (777, 20, 0.2373046875),
            (777, 31, 0.8994140625),
        ];
        for (number, dimension, expected) in far {
            assert_eq!(at(number, dimension), expected, "{number} {dimension}");
        }
    }

    #[test]
    fn every_interval_has_its_point() {
        for dimension in 0..MAX_DIMENSIONS {
            let mut cells: Vec<u32> = (0..256).map(|n| coordinate(n, dimension) >> 24).collect();
            cells.sort_unstable();
            assert_eq!(cells, (0..256).collect::<Vec<u32>>(), "{dimension}");
        }
    }
}
