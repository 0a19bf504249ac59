//! Smooth noise without state: gradient noise (Perlin 2002, Improving Noise) over an integer hash, with its exact
//! derivative, from additions and multiplications only, so that it has the same bits on every machine.

use glam::DVec3;

/// A well-mixed hash of a point of an integer lattice.
#[inline]
pub fn hash(seed: u64, x: i64, y: i64, z: i64) -> u64 {
    let mut h = seed
        ^ (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f)
        ^ (z as u64).wrapping_mul(0x1656_67b1_9e37_79f9);
    h = (h ^ (h >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93);
    h = (h ^ (h >> 29)).wrapping_mul(0xff51_afd7_ed55_8ccd);
    h ^ (h >> 32)
}

/// Splits a number into the largest integer not above it and the rest, 0 to 1. Without a call into the mathematics library:
/// the basic instruction sets of most processors have no such operation.
#[inline]
fn split(x: f64) -> (i64, f64) {
    let whole = x as i64;
    let whole = whole - i64::from(x < whole as f64);
    (whole, x - whole as f64)
}

/// A uniform number from 0 to 1 for a point of an integer lattice.
///
/// ```
/// use greenstick_wood::noise::unit;
///
/// let numbers: Vec<f64> = (0..3).map(|i| unit(7, i, 0, 0)).collect();
/// assert!(numbers.iter().all(|x| (0.0..1.0).contains(x)));
/// assert_eq!(numbers[1], unit(7, 1, 0, 0)); // the same on every machine
/// ```
#[inline]
pub fn unit(seed: u64, x: i64, y: i64, z: i64) -> f64 {
    (hash(seed, x, y, z) >> 11) as f64 / 9_007_199_254_740_992.0
}

/// 3t² − 2t³ between two edges.
#[inline]
pub fn smoothstep(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Value noise of one number: −1 to 1, with features as wide as 1.
pub fn value_1d(seed: u64, x: f64) -> f64 {
    let (cell, f) = split(x);
    let s = f * f * (3.0 - 2.0 * f);
    let [a, b] = [0, 1].map(|i| unit(seed, cell + i, 0, 0) * 2.0 - 1.0);
    a + (b - a) * s
}

/// The largest integer not above `v`, without a call into the mathematics library.
fn whole(v: f64) -> i64 {
    let cut = v as i64;
    cut - i64::from(v < cut as f64)
}

/// Gradient noise in space: its value (about −1 to 1, mean 0) and gradient. Features are as wide as 1. With `period` > 0
/// it repeats along z after that many cells.
pub fn gradient_3d(seed: u64, p: DVec3, period: i64) -> (f64, DVec3) {
    let cell = p.to_array().map(whole);
    blend_corners(&corner_gradients(seed, cell, period), cell, p)
}

/// Gradients at the corners of a cell of the lattice; bit 0 of the index counts along x, bit 1 along y, bit 2 along z.
#[inline]
fn corner_gradients(seed: u64, [x, y, z]: [i64; 3], period: i64) -> [DVec3; 8] {
    let (z0, z1) = if period > 0 {
        (z.rem_euclid(period), (z + 1).rem_euclid(period))
    } else {
        (z, z + 1)
    };
    let part = |i: i64, factor: u64| (i as u64).wrapping_mul(factor);
    let xs = [x, x + 1].map(|i| seed ^ part(i, 0x9e37_79b9_7f4a_7c15));
    let ys = [y, y + 1].map(|i| part(i, 0xc2b2_ae3d_27d4_eb4f));
    let zs = [z0, z1].map(|i| part(i, 0x1656_67b1_9e37_79f9));
    std::array::from_fn(|corner| {
        let h = xs[corner & 1] ^ ys[corner >> 1 & 1] ^ zs[corner >> 2];
        let h = (h ^ (h >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93);
        let h = (h ^ (h >> 29)).wrapping_mul(0xff51_afd7_ed55_8ccd);
        // The upper bits are mixed best.
        let part = |shift: u32| f64::from((h >> shift) as u16) * (2.0 / 65_535.0) - 1.0;
        DVec3::new(part(16), part(32), part(48))
    })
}

/// Value and gradient of the noise at a point of a cell.
#[inline]
fn blend_corners(gradients: &[DVec3; 8], [x, y, z]: [i64; 3], p: DVec3) -> (f64, DVec3) {
    let f = p - DVec3::new(x as f64, y as f64, z as f64);
    // Quintic fade: second derivatives are continuous, so relief shows no lattice.
    let s = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let ds = f * f * (f * (f - 2.0) + 1.0) * 30.0;
    let corner = |i: usize, j: usize, k: usize| {
        let g = gradients[i | j << 1 | k << 2];
        (g, g.dot(f - DVec3::new(i as f64, j as f64, k as f64)))
    };
    let mix = |(ga, a): (DVec3, f64), (gb, b): (DVec3, f64), axis: usize| {
        let mut g = ga + (gb - ga) * s[axis];
        g[axis] += (b - a) * ds[axis];
        (g, a + (b - a) * s[axis])
    };
    let plane = |k: usize| {
        let low = mix(corner(0, 0, k), corner(1, 0, k), 0);
        let high = mix(corner(0, 1, k), corner(1, 1, k), 0);
        mix(low, high, 1)
    };
    let (gradient, value) = mix(plane(0), plane(1), 2);
    // Gradients fill a cube, so values seldom exceed 0.8.
    (value * 1.25, gradient * 1.25)
}

/// Several gradient noises in space, each known by its number, for points that are visited one after another.
pub(crate) trait Noises {
    /// What [`gradient_3d`] gives, for noise number `number` (below [`NoiseMemory::NOISES`]).
    fn gradient(&mut self, number: usize, seed: u64, p: DVec3, period: i64) -> (f64, DVec3);
}

/// Noises that remember nothing: points that lie anywhere.
pub(crate) struct Forgetful;

impl Noises for Forgetful {
    #[inline]
    fn gradient(&mut self, _: usize, seed: u64, p: DVec3, period: i64) -> (f64, DVec3) {
        gradient_3d(seed, p, period)
    }
}

/// The cell of the lattice that each of several noises was last in: neighbours in the rows of a texture mostly share it. The
/// values are those of [`gradient_3d`], bit for bit.
#[derive(Debug, Clone, Default)]
pub struct NoiseMemory {
    cells: [Option<NoiseCell>; NoiseMemory::NOISES],
}

#[derive(Debug, Clone)]
struct NoiseCell {
    key: (u64, [i64; 3], i64),
    gradients: [DVec3; 8],
}

impl NoiseCell {
    /// Whether it has a key. Number by number, in registers: a comparison of both as a whole would wait until the key is in memory.
    #[inline(always)]
    fn is(&self, (seed, [x, y, z], period): (u64, [i64; 3], i64)) -> bool {
        let (own_seed, own, own_period) = self.key;
        let other = (own[0] ^ x) | (own[1] ^ y) | (own[2] ^ z) | (own_period ^ period);
        (own_seed ^ seed) | other as u64 == 0
    }
}

impl NoiseMemory {
    /// Noises that are told apart.
    const NOISES: usize = 18;
}

impl Noises for NoiseMemory {
    #[inline]
    fn gradient(&mut self, number: usize, seed: u64, p: DVec3, period: i64) -> (f64, DVec3) {
        let cell = p.to_array().map(whole);
        let key = (seed, cell, period);
        let known = &mut self.cells[number];
        if !matches!(known, Some(last) if last.is(key)) {
            *known = None;
        }
        let known = known.get_or_insert_with(|| NoiseCell {
            key,
            gradients: corner_gradients(seed, cell, period),
        });
        blend_corners(&known.gradients, cell, p)
    }
}

/// Gradient noise in the plane: about −1 to 1, mean 0, features as wide as 1.
pub fn gradient_2d(seed: u64, p: glam::DVec2) -> f64 {
    GradientNoise2d::new(seed).at(p)
}

/// [`gradient_2d`] at one point after another: points in one cell of the lattice share its gradients.
#[derive(Debug, Clone)]
pub struct GradientNoise2d {
    seed: u64,
    cell: (i64, i64),
    /// Gradients at the cell's corners, the lower row first.
    gradients: [(f64, f64); 4],
}

impl GradientNoise2d {
    /// The noise of a seed.
    #[inline]
    pub fn new(seed: u64) -> Self {
        // Gradients that are NaN mean that no cell has been entered.
        GradientNoise2d {
            seed,
            cell: (0, 0),
            gradients: [(f64::NAN, f64::NAN); 4],
        }
    }

    #[inline]
    fn enter(&mut self, x: i64, y: i64) {
        let gradient = |i: i64, j: i64| {
            let h = hash(self.seed, x.wrapping_add(i), y.wrapping_add(j), 0);
            let part =
                |shift: u32| ((h >> shift) & 0xffff_ffff) as f64 * (2.0 / 4_294_967_295.0) - 1.0;
            (part(0), part(32))
        };
        self.gradients = [
            gradient(0, 0),
            gradient(1, 0),
            gradient(0, 1),
            gradient(1, 1),
        ];
        self.cell = (x, y);
    }

    /// Its value at a point.
    #[inline]
    pub fn at(&mut self, p: glam::DVec2) -> f64 {
        let ((x, u), (y, v)) = (split(p.x), split(p.y));
        if self.cell != (x, y) || self.gradients[0].0.is_nan() {
            self.enter(x, y);
        }
        let f = glam::DVec2::new(u, v);
        let s = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
        let corner = |n: usize, i: f64, j: f64| {
            self.gradients[n].0 * (f.x - i) + self.gradients[n].1 * (f.y - j)
        };
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let low = mix(corner(0, 0.0, 0.0), corner(1, 1.0, 0.0), s.x);
        let high = mix(corner(2, 0.0, 1.0), corner(3, 1.0, 1.0), s.x);
        // Gradients fill a square, so values seldom exceed 0.7.
        mix(low, high, s.y) * 1.4
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gradient_is_the_slope_and_the_noise_is_smooth_across_cells() {
        let step = 1e-5;
        for i in 0..200 {
            let t = f64::from(i);
            // Every fourth point lies on a lattice plane.
            let x = if i % 4 == 0 { t.floor() } else { t * 0.737 };
            let p = DVec3::new(x, t * 1.31 - 70.0, t * 0.29);
            let (_, gradient) = gradient_3d(5, p, 0);
            for a in 0..3 {
                let e = DVec3::AXES[a] * step;
                let slope =
                    (gradient_3d(5, p + e, 0).0 - gradient_3d(5, p - e, 0).0) / (2.0 * step);
                assert!(
                    (slope - gradient[a]).abs() < 1e-4,
                    "{slope} is not {} at {p}",
                    gradient[a]
                );
            }
        }
    }

    #[test]
    fn values_have_mean_zero_and_stay_in_range() {
        let (mut sum, mut squares, mut most) = (0.0, 0.0, 0.0f64);
        let number = 20_000;
        for i in 0..number {
            let t = f64::from(i);
            let (v, _) = gradient_3d(11, DVec3::new(t * 0.613, t * 0.377, t * 0.219), 0);
            sum += v;
            squares += v * v;
            most = most.max(v.abs());
        }
        let mean = sum / f64::from(number);
        assert!(
            mean.abs() < 0.02 && most < 1.2,
            "mean {mean}, largest {most}"
        );
        assert!((0.04..0.2).contains(&(squares / f64::from(number))));
    }

    #[test]
    fn a_period_repeats() {
        for i in 0..50 {
            let p = DVec3::new(f64::from(i) * 0.3, 0.7, f64::from(i) * 0.23 - 4.0);
            let (a, b) = (gradient_3d(3, p, 6), gradient_3d(3, p + DVec3::Z * 6.0, 6));
            assert!((a.0 - b.0).abs() < 1e-12 && (a.1 - b.1).length() < 1e-12);
        }
    }
}
