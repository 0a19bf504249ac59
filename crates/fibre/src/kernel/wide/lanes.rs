//! Eight numbers at once on AVX-512, AVX2 and plain processors, with the same bits on each: only additions,
//! multiplications, divisions and square roots, which IEEE 754 rounds alike, and nothing fused.

/// Numbers in one [`Lanes`].
pub(crate) const WIDTH: usize = 8;
/// A vector in space with an unused fourth number: half a line of cache.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub(crate) struct Row(pub [f64; 4]);
/// Two vectors, each with an unused fourth number: a line of cache.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Pair(pub [f64; 8]);

/// Eight numbers.
///
/// # Safety
/// Implementations use instructions of their [`Level`]; they may be used only where [`Level::best`] has found it.
/// Pointers must be good for as many numbers as are read or written there: eight where nothing else is said.
pub(crate) trait Lanes: Copy {
    unsafe fn splat(v: f64) -> Self;
    unsafe fn load(from: *const f64) -> Self;
    unsafe fn store(self, to: *mut f64);
    /// Writes the first four.
    unsafe fn store_low(self, to: *mut f64);
    /// From numbers of half the width.
    unsafe fn load_single(from: *const f32) -> Self;
    /// Rounded to numbers of half the width.
    unsafe fn store_single(self, to: *mut f32);
    unsafe fn add(self, b: Self) -> Self;
    unsafe fn sub(self, b: Self) -> Self;
    unsafe fn mul(self, b: Self) -> Self;
    unsafe fn div(self, b: Self) -> Self;
    unsafe fn sqrt(self) -> Self;
    /// `self` where `mask` is above 0, else `other`.
    unsafe fn where_positive(self, mask: Self, other: Self) -> Self;
    /// `self` where `keep` is 1, zeros where it is 0.
    unsafe fn kept(self, keep: u8) -> Self;
    /// First, second and third numbers of eight rows, chosen by eight indices.
    unsafe fn rows(from: *const Row, indices: *const u32) -> [Self; 3];
    /// Pair k holds the k-th numbers of the first three, 0, those of the second three, 0.
    unsafe fn pairs(first: [Self; 3], second: [Self; 3]) -> [Self; WIDTH];
}

/// On every processor.
#[derive(Clone, Copy)]
pub(crate) struct Plain([f64; WIDTH]);

impl Plain {
    #[inline(always)]
    fn zip(self, b: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut made = [0.0; WIDTH];
        for ((made, a), b) in made.iter_mut().zip(self.0).zip(b.0) {
            *made = f(a, b);
        }
        Plain(made)
    }
}

impl Lanes for Plain {
    #[inline(always)]
    unsafe fn splat(v: f64) -> Self {
        Plain([v; WIDTH])
    }
    #[inline(always)]
    unsafe fn load(from: *const f64) -> Self {
        Plain(unsafe { from.cast::<[f64; WIDTH]>().read_unaligned() })
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
        Plain(unsafe { from.cast::<[f32; WIDTH]>().read_unaligned() }.map(f64::from))
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
        let mut made = other.0;
        for ((made, a), m) in made.iter_mut().zip(self.0).zip(mask.0) {
            if m > 0.0 {
                *made = a;
            }
        }
        Plain(made)
    }
    #[inline(always)]
    unsafe fn kept(self, keep: u8) -> Self {
        let mask = 0u64.wrapping_sub(keep.into());
        self.zip(self, |a, _| f64::from_bits(a.to_bits() & mask))
    }
    #[inline(always)]
    unsafe fn rows(from: *const Row, indices: *const u32) -> [Self; 3] {
        let mut made = [[0.0; WIDTH]; 3];
        for k in 0..WIDTH {
            let row = unsafe { &*from.add(*indices.add(k) as usize) };
            for (made, v) in made.iter_mut().zip(&row.0) {
                made[k] = *v;
            }
        }
        made.map(Plain)
    }
    #[inline(always)]
    unsafe fn pairs(first: [Self; 3], second: [Self; 3]) -> [Self; WIDTH] {
        let mut made = [Plain([0.0; WIDTH]); WIDTH];
        for (k, made) in made.iter_mut().enumerate() {
            for a in 0..3 {
                made.0[a] = first[a].0[k];
                made.0[4 + a] = second[a].0[k];
            }
        }
        made
    }
}

/// Which instructions are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Those that every processor of the target has.
    Plain,
    /// AVX2.
    Avx2,
    /// AVX-512F.
    Avx512,
}

impl Level {
    /// The widest that this processor has.
    pub fn best() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx2") {
                return Level::Avx512;
            }
            if is_x86_feature_detected!("avx2") {
                return Level::Avx2;
            }
        }
        Level::Plain
    }
}

// Functions, not closures: only what is always inlined may take part in a function with its own instructions.

#[inline(always)]
pub(crate) unsafe fn dot<L: Lanes>(u: [L; 3], v: [L; 3]) -> L {
    unsafe { u[0].mul(v[0]).add(u[1].mul(v[1])).add(u[2].mul(v[2])) }
}

#[inline(always)]
pub(crate) unsafe fn difference<L: Lanes>(u: [L; 3], v: [L; 3]) -> [L; 3] {
    unsafe { [u[0].sub(v[0]), u[1].sub(v[1]), u[2].sub(v[2])] }
}

/// Eight vectors from three arrays, from place `k` on.
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

/// Makes `$name`, which calls `$generic` with the widest instructions up to a level, from functions compiled for each.
macro_rules! for_each_level {
    ($(#[$doc:meta])* $name:ident = $generic:ident($($argument:ident: $type:ty),* $(,)?)) => {
        $(#[$doc])*
        ///
        /// # Safety
        /// As of the generic function; the level is never above what the processor has.
        unsafe fn $name(level: $crate::kernel::wide::lanes::Level, $($argument: $type),*) {
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx512f,avx2")]
            unsafe fn wide512($($argument: $type),*) {
                unsafe { $generic::<$crate::kernel::wide::x86::Wide512>($($argument),*) }
            }
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2")]
            unsafe fn wide256($($argument: $type),*) {
                unsafe { $generic::<$crate::kernel::wide::x86::Wide256>($($argument),*) }
            }
            use $crate::kernel::wide::lanes::{Level, Plain};
            unsafe {
                match level.min(Level::best()) {
                    #[cfg(target_arch = "x86_64")]
                    Level::Avx512 => wide512($($argument),*),
                    #[cfg(target_arch = "x86_64")]
                    Level::Avx2 => wide256($($argument),*),
                    _ => $generic::<Plain>($($argument),*),
                }
            }
        }
    };
}
pub(crate) use for_each_level;
