//! Stateless low-discrepancy samples: Sobol' points with hash-based Owen scrambling (Burley 2020), seeded by the pixel, so
//! that a picture has the same bits with any number of threads.

use glam::DVec3;

/// A well-mixed hash of two numbers.
pub(crate) fn hash(a: u32, b: u32) -> u32 {
    let mut h = a.wrapping_mul(0x9e37_79b9) ^ b.wrapping_add(0x7f4a_7c15).wrapping_mul(0x85eb_ca6b);
    h ^= h >> 16;
    h = h.wrapping_mul(0x7feb_352d);
    h ^= h >> 15;
    h = h.wrapping_mul(0x846c_a68b);
    h ^ (h >> 16)
}

/// Scrambles the binary digits of `x` from the most significant on, as a random binary tree does (Laine and Karras 2011).
fn scramble(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits();
    x = x.wrapping_add(seed);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x.reverse_bits()
}

/// The second Sobol' dimension; the first one is the bit-reversed index.
fn sobol_second(index: u32) -> u32 {
    let (mut result, mut direction, mut i) = (0, 1u32 << 31, index);
    while i != 0 {
        if i & 1 != 0 {
            result ^= direction;
        }
        direction ^= direction >> 1;
        i >>= 1;
    }
    result
}

/// The random numbers of one sample of a pixel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sampler {
    pub pixel: u32,
    pub index: u32,
    /// Binary digits of indices.
    pub digits: u32,
}

impl Sampler {
    /// A point in the unit square. Every purpose has its own shuffled sequence.
    pub fn square(&self, purpose: u32) -> [f64; 2] {
        let seed = hash(self.pixel, purpose);
        let spare = 32 - self.digits;
        let index = scramble(self.index << spare, seed) >> spare;
        let x = scramble(index.reverse_bits(), hash(seed, 1));
        let y = scramble(sobol_second(index), hash(seed, 2));
        [f64::from(x), f64::from(y)].map(|v| (v + 0.5) / 4_294_967_296.0)
    }
}

/// Sine and cosine on [−π/4, π/4] by Taylor polynomials (error below 1e-8), with the same bits on every machine.
fn sine_cosine(x: f64) -> (f64, f64) {
    let q = x * x;
    let sine = x * (1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0 * (1.0 - q / 72.0))));
    let cosine =
        1.0 - q / 2.0 * (1.0 - q / 12.0 * (1.0 - q / 30.0 * (1.0 - q / 56.0 * (1.0 - q / 90.0))));
    (sine, cosine)
}

/// Maps the unit square to the unit disc, preserving relative areas and neighbourhoods (Shirley and Chiu 1997).
pub(crate) fn disc(square: [f64; 2]) -> [f64; 2] {
    let [x, y] = square.map(|v| 2.0 * v - 1.0);
    let quarter = std::f64::consts::FRAC_PI_4;
    if x == 0.0 && y == 0.0 {
        [0.0, 0.0]
    } else if x.abs() > y.abs() {
        let (s, c) = sine_cosine(quarter * y / x);
        [x * c, x * s]
    } else {
        let (s, c) = sine_cosine(quarter * x / y);
        [y * s, y * c]
    }
}

/// Two unit vectors that form a right-handed frame with the unit vector `n` (Duff et al. 2017).
pub(crate) fn frame(n: DVec3) -> (DVec3, DVec3) {
    let sign = if n.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (
        DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        DVec3::new(b, sign + n.y * n.y * a, -n.y),
    )
}

/// A direction around `n` with the density cosine / π.
pub(crate) fn cosine_direction(n: DVec3, square: [f64; 2]) -> DVec3 {
    let [x, y] = disc(square);
    let (t, b) = frame(n);
    (t * x + b * y + n * (1.0 - x * x - y * y).max(0.0).sqrt()).normalize()
}

/// A direction distributed uniformly over the cone around `axis` whose half angle has the cosine `cosine`.
pub(crate) fn cone_direction(axis: DVec3, cosine: f64, square: [f64; 2]) -> DVec3 {
    let [x, y] = disc(square);
    let q = x * x + y * y;
    let c = 1.0 - q * (1.0 - cosine);
    // The radius √q on the disc becomes the sine of the angle from the axis.
    let stretch = if q > 0.0 {
        ((1.0 - c * c) / q).max(0.0).sqrt()
    } else {
        0.0
    };
    let (t, b) = frame(axis);
    ((t * x + b * y) * stretch + axis * c).normalize()
}
