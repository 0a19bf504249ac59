//! Stateless low-discrepancy samples: one Sobol' sequence with hash-based Owen scrambling (Burley 2020) for the whole picture,
//! whose numbers run along a Z-order curve through the pixels (Ahmed and Wonka 2020). Neighbouring pixels share a well
//! distributed set of samples, so that a filter over them finds little noise; a pixel's samples depend on its place alone, so
//! that a picture has the same bits with any number of threads.

use glam::Vec3;

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

/// The second Sobol' dimension; the first one is the bit-reversed index. Its matrix is Pascal's triangle modulo 2, the
/// fivefold Kronecker power of a 2 × 2 matrix, and is applied factor by factor.
fn sobol_second(index: u32) -> u32 {
    let mut x = index;
    x ^= (x & 0xaaaa_aaaa) >> 1;
    x ^= (x & 0xcccc_cccc) >> 2;
    x ^= (x & 0xf0f0_f0f0) >> 4;
    x ^= (x & 0xff00_ff00) >> 8;
    x ^= (x & 0xffff_0000) >> 16;
    x.reverse_bits()
}

/// The place of a pixel along the Z-order curve: the interleaved bits of its coordinates, each below 65536.
fn z_order(x: u32, y: u32) -> u32 {
    let spread = |v: u32| {
        let mut v = v & 0xffff;
        v = (v | v << 8) & 0x00ff_00ff;
        v = (v | v << 4) & 0x0f0f_0f0f;
        v = (v | v << 2) & 0x3333_3333;
        (v | v << 1) & 0x5555_5555
    };
    spread(x) | spread(y) << 1
}

/// What random numbers are drawn for. Every purpose has its own shuffled sequence.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Purpose {
    /// The place in the pixel.
    Pixel = 1,
    /// The direction to the key light.
    KeyLight = 2,
    /// The direction to the rim light.
    RimLight = 3,
    /// The direction of indirect light.
    Indirect = 4,
    /// The direction to a light from a surface that indirect light comes from.
    Bounce = 5,
    /// Which light that is.
    BounceLight = 6,
}

/// The random numbers of the samples of a pixel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sampler {
    first: u32,
}

impl Sampler {
    /// The sampler of a pixel that takes up to `count` samples for each purpose.
    pub fn new([x, y]: [usize; 2], count: u32) -> Sampler {
        // Beyond 2³² numbers repeat, which changes nothing nearby.
        Sampler {
            first: z_order(x as u32, y as u32).wrapping_mul(count),
        }
    }

    /// The sampler of one of the samples of a pixel that takes further `count` samples itself.
    pub fn of_sample(pixel: &Sampler, index: u32, count: u32) -> Sampler {
        Sampler {
            first: pixel.first.wrapping_add(index).wrapping_mul(count),
        }
    }

    /// The point of a sample in the unit square.
    pub fn square(&self, index: u32, purpose: Purpose) -> [f32; 2] {
        let seed = hash(0x5b1c, purpose as u32);
        let number = scramble(self.first.wrapping_add(index), seed);
        let x = scramble(number.reverse_bits(), hash(seed, 1));
        let y = scramble(sobol_second(number), hash(seed, 2));
        // 24 bits are what an f32 holds.
        [x, y].map(|v| ((v >> 8) as f32 + 0.5) / 16_777_216.0)
    }
}

/// Sine and cosine on [−π/4, π/4] by Taylor polynomials (error below 1e-7), with the same bits on every machine.
fn sine_cosine(x: f32) -> (f32, f32) {
    // Factors and not divisors, which take many times as long.
    const S: [f32; 4] = [1.0 / 6.0, 1.0 / 20.0, 1.0 / 42.0, 1.0 / 72.0];
    const C: [f32; 5] = [0.5, 1.0 / 12.0, 1.0 / 30.0, 1.0 / 56.0, 1.0 / 90.0];
    let q = x * x;
    let series = |factors: &[f32]| factors.iter().rev().fold(1.0, |sum, f| 1.0 - q * f * sum);
    (x * series(&S), series(&C))
}

/// Maps the unit square to the unit disc, preserving relative areas and neighbourhoods (Shirley and Chiu 1997).
pub(crate) fn disc(square: [f32; 2]) -> [f32; 2] {
    let [x, y] = square.map(|v| 2.0 * v - 1.0);
    let quarter = std::f32::consts::FRAC_PI_4;
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
pub(crate) fn frame(n: Vec3) -> (Vec3, Vec3) {
    let sign = if n.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (
        Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        Vec3::new(b, sign + n.y * n.y * a, -n.y),
    )
}

/// A direction around `n` with the density cosine / π.
pub(crate) fn cosine_direction(n: Vec3, square: [f32; 2]) -> Vec3 {
    let [x, y] = disc(square);
    let (t, b) = frame(n);
    (t * x + b * y + n * (1.0 - x * x - y * y).max(0.0).sqrt()).normalize()
}

/// A direction distributed uniformly over the cone around `axis` whose half angle has the cosine `cosine`.
pub(crate) fn cone_direction(axis: Vec3, cosine: f32, square: [f32; 2]) -> Vec3 {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_pixels_of_four_samples_share_a_net_of_sixteen() {
        // Each of the 16 elementary intervals of every shape holds one of the samples of an aligned block.
        for origin in [[0, 0], [6, 2], [1000, 30]] {
            let points: Vec<[f32; 2]> = (0..4)
                .flat_map(|p| {
                    let sampler = Sampler::new([origin[0] + p % 2, origin[1] + p / 2], 4);
                    (0..4).map(move |i| sampler.square(i, Purpose::KeyLight))
                })
                .collect();
            for columns in [1, 2, 4, 8, 16] {
                let rows = 16 / columns;
                let mut taken = [0; 16];
                for [x, y] in &points {
                    let (c, r) = ((x * columns as f32) as usize, (y * rows as f32) as usize);
                    taken[c + columns * r] += 1;
                }
                assert_eq!(taken, [1; 16], "{columns} × {rows} at {origin:?}");
            }
        }
    }
}
