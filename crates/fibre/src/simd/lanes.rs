//! Eight numbers at once, with the same bits on AVX-512, AVX2 and any other processor: only additions, multiplications,
//! divisions and square roots, which IEEE 754 rounds in one way, and no fused operations.

/// Numbers in one [`Lanes`].
pub(crate) const WIDTH: usize = 8;
/// A vector in space padded to four numbers: half a cache line.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub(crate) struct PaddedVec3(pub [f64; 4]);
impl PaddedVec3 {
    pub(crate) const ZERO: PaddedVec3 = PaddedVec3([0.0; 4]);
}

/// Two padded vectors: a cache line.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct PaddedPair(pub [f64; 8]);

/// Eight numbers.
///
/// # Safety
/// Implementations use the instructions of their level, and may be used only where `SimdLevel::best` has found them.
/// Pointers must be valid for all numbers that are read or written there: eight where nothing else is said.
pub(crate) trait Lanes: Copy {
    unsafe fn splat(v: f64) -> Self;
    unsafe fn load(from: *const f64) -> Self;
    unsafe fn store(self, to: *mut f64);
    /// Writes the first four numbers.
    unsafe fn store_low(self, to: *mut f64);
    /// Reads numbers in single precision.
    unsafe fn load_single(from: *const f32) -> Self;
    /// Writes numbers rounded to single precision.
    unsafe fn store_single(self, to: *mut f32);
    unsafe fn add(self, b: Self) -> Self;
    unsafe fn sub(self, b: Self) -> Self;
    unsafe fn mul(self, b: Self) -> Self;
    unsafe fn div(self, b: Self) -> Self;
    unsafe fn sqrt(self) -> Self;
    /// Selects `self` where `mask` is above 0, else `other`.
    unsafe fn where_positive(self, mask: Self, other: Self) -> Self;
    /// Returns `self` where `keep` is 1, and zeros where it is 0.
    unsafe fn keep_if(self, keep: u8) -> Self;
    /// Gathers the first, second and third numbers of eight vectors, chosen by eight indices.
    unsafe fn gather(from: *const PaddedVec3, indices: *const u32) -> [Self; 3];
    /// The same with their fourth numbers.
    unsafe fn gather4(from: *const PaddedVec3, indices: *const u32) -> [Self; 4];
    /// Transposes two triples into eight pairs: pair k is the k-th numbers of the first three, 0, those of the second three,
    /// 0.
    unsafe fn pairs(first: [Self; 3], second: [Self; 3]) -> [Self; WIDTH];
}

/// Eight numbers on any processor.
#[derive(Clone, Copy)]
pub(crate) struct Scalar([f64; WIDTH]);

impl Scalar {
    #[inline(always)]
    fn zip(self, b: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut made = [0.0; WIDTH];
        for ((made, a), b) in made.iter_mut().zip(self.0).zip(b.0) {
            *made = f(a, b);
        }
        Scalar(made)
    }
}

/// Returns the first coordinates of the vectors at [`WIDTH`] indices.
///
/// # Safety
/// As [`Lanes::gather`].
#[inline(always)]
unsafe fn gathered<const N: usize>(from: *const PaddedVec3, indices: *const u32) -> [Scalar; N] {
    let mut made = [[0.0; WIDTH]; N];
    for k in 0..WIDTH {
        let vector = unsafe { &*from.add(*indices.add(k) as usize) };
        for (made, v) in made.iter_mut().zip(&vector.0) {
            made[k] = *v;
        }
    }
    made.map(Scalar)
}

impl Lanes for Scalar {
    #[inline(always)]
    unsafe fn splat(v: f64) -> Self {
        Scalar([v; WIDTH])
    }
    #[inline(always)]
    unsafe fn load(from: *const f64) -> Self {
        Scalar(unsafe { from.cast::<[f64; WIDTH]>().read_unaligned() })
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut f64) {
        unsafe { to.cast::<[f64; WIDTH]>().write_unaligned(self.0) }
    }
    #[inline(always)]
    unsafe fn store_low(self, to: *mut f64) {
        let [a, b, c, d, ..] = self.0;
        unsafe { to.cast::<[f64; 4]>().write_unaligned([a, b, c, d]) }
    }
    #[inline(always)]
    unsafe fn load_single(from: *const f32) -> Self {
        Scalar(unsafe { from.cast::<[f32; WIDTH]>().read_unaligned() }.map(f64::from))
    }
    #[inline(always)]
    unsafe fn store_single(self, to: *mut f32) {
        unsafe {
            to.cast::<[f32; WIDTH]>()
                .write_unaligned(self.0.map(|v| v as f32))
        }
    }
    #[inline(always)]
    unsafe fn add(self, b: Self) -> Self {
        self.zip(b, |a, b| a + b)
    }
    #[inline(always)]
    unsafe fn sub(self, b: Self) -> Self {
        self.zip(b, |a, b| a - b)
    }
    #[inline(always)]
    unsafe fn mul(self, b: Self) -> Self {
        self.zip(b, |a, b| a * b)
    }
    #[inline(always)]
    unsafe fn div(self, b: Self) -> Self {
        self.zip(b, |a, b| a / b)
    }
    #[inline(always)]
    unsafe fn sqrt(self) -> Self {
        self.zip(self, |a, _| a.sqrt())
    }
    #[inline(always)]
    unsafe fn where_positive(self, mask: Self, other: Self) -> Self {
        let mut selected = other.0;
        for ((selected, a), m) in selected.iter_mut().zip(self.0).zip(mask.0) {
            if m > 0.0 {
                *selected = a;
            }
        }
        Scalar(selected)
    }
    #[inline(always)]
    unsafe fn keep_if(self, keep: u8) -> Self {
        let mask = 0u64.wrapping_sub(keep.into());
        self.zip(self, |a, _| f64::from_bits(a.to_bits() & mask))
    }
    #[inline(always)]
    unsafe fn gather(from: *const PaddedVec3, indices: *const u32) -> [Self; 3] {
        unsafe { gathered(from, indices) }
    }
    #[inline(always)]
    unsafe fn gather4(from: *const PaddedVec3, indices: *const u32) -> [Self; 4] {
        unsafe { gathered(from, indices) }
    }
    #[inline(always)]
    unsafe fn pairs(first: [Self; 3], second: [Self; 3]) -> [Self; WIDTH] {
        let mut made = [Scalar([0.0; WIDTH]); WIDTH];
        for (k, made) in made.iter_mut().enumerate() {
            for a in 0..3 {
                made.0[a] = first[a].0[k];
                made.0[4 + a] = second[a].0[k];
            }
        }
        made
    }
}

// Functions, not closures: a function compiled for other instructions can call only what is always inlined into it.

#[inline(always)]
pub(crate) unsafe fn dot<L: Lanes>(u: [L; 3], v: [L; 3]) -> L {
    unsafe { u[0].mul(v[0]).add(u[1].mul(v[1])).add(u[2].mul(v[2])) }
}

#[inline(always)]
pub(crate) unsafe fn difference<L: Lanes>(u: [L; 3], v: [L; 3]) -> [L; 3] {
    unsafe { [u[0].sub(v[0]), u[1].sub(v[1]), u[2].sub(v[2])] }
}

/// Loads eight vectors from three arrays, from entry `k` on.
#[inline(always)]
pub(crate) unsafe fn load3<L: Lanes>(from: [*const f64; 3], k: usize) -> [L; 3] {
    unsafe {
        [
            L::load(from[0].add(k)),
            L::load(from[1].add(k)),
            L::load(from[2].add(k)),
        ]
    }
}
