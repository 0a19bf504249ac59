//! [`Lanes`] on the wide registers of x86-64.

use super::lanes::{Lanes, PaddedVec3, WIDTH};
use core::arch::x86_64::*;

/// AVX-512F: one register.
#[derive(Clone, Copy)]
pub(crate) struct Wide512(__m512d);

impl Lanes for Wide512 {
    #[inline(always)]
    unsafe fn splat(v: f64) -> Self {
        unsafe { Wide512(_mm512_set1_pd(v)) }
    }
    #[inline(always)]
    unsafe fn load(from: *const f64) -> Self {
        unsafe { Wide512(_mm512_loadu_pd(from)) }
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut f64) {
        unsafe { _mm512_storeu_pd(to, self.0) }
    }
    #[inline(always)]
    unsafe fn store_low(self, to: *mut f64) {
        unsafe { _mm256_storeu_pd(to, _mm512_castpd512_pd256(self.0)) }
    }
    #[inline(always)]
    unsafe fn load_single(from: *const f32) -> Self {
        unsafe { Wide512(_mm512_cvtps_pd(_mm256_loadu_ps(from))) }
    }
    #[inline(always)]
    unsafe fn store_single(self, to: *mut f32) {
        unsafe { _mm256_storeu_ps(to, _mm512_cvtpd_ps(self.0)) }
    }
    #[inline(always)]
    unsafe fn add(self, b: Self) -> Self {
        unsafe { Wide512(_mm512_add_pd(self.0, b.0)) }
    }
    #[inline(always)]
    unsafe fn sub(self, b: Self) -> Self {
        unsafe { Wide512(_mm512_sub_pd(self.0, b.0)) }
    }
    #[inline(always)]
    unsafe fn mul(self, b: Self) -> Self {
        unsafe { Wide512(_mm512_mul_pd(self.0, b.0)) }
    }
    #[inline(always)]
    unsafe fn div(self, b: Self) -> Self {
        unsafe { Wide512(_mm512_div_pd(self.0, b.0)) }
    }
    #[inline(always)]
    unsafe fn sqrt(self) -> Self {
        unsafe { Wide512(_mm512_sqrt_pd(self.0)) }
    }
    #[inline(always)]
    unsafe fn where_positive(self, mask: Self, other: Self) -> Self {
        unsafe {
            let m = _mm512_cmp_pd_mask::<_CMP_GT_OQ>(mask.0, _mm512_setzero_pd());
            Wide512(_mm512_mask_mov_pd(other.0, m, self.0))
        }
    }
    #[inline(always)]
    unsafe fn keep_if(self, keep: u8) -> Self {
        unsafe { Wide512(_mm512_maskz_mov_pd(0u8.wrapping_sub(keep), self.0)) }
    }
    #[inline(always)]
    unsafe fn gather(from: *const PaddedVec3, indices: *const u32) -> [Self; 3] {
        unsafe {
            let [x, y, z, _] = gather512(from, indices);
            [Wide512(x), Wide512(y), Wide512(z)]
        }
    }
    #[inline(always)]
    unsafe fn gather4(from: *const PaddedVec3, indices: *const u32) -> [Self; 4] {
        unsafe {
            let [x, y, z, w] = gather512(from, indices);
            [Wide512(x), Wide512(y), Wide512(z), Wide512(w)]
        }
    }
    #[inline(always)]
    unsafe fn pairs([x, y, z]: [Self; 3], [u, v, w]: [Self; 3]) -> [Self; WIDTH] {
        unsafe {
            let [a, b, c, d, e, f, g, h] = pairs512([x.0, y.0, z.0], [u.0, v.0, w.0]);
            [
                Wide512(a),
                Wide512(b),
                Wide512(c),
                Wide512(d),
                Wide512(e),
                Wide512(f),
                Wide512(g),
                Wide512(h),
            ]
        }
    }
}

#[inline]
#[target_feature(enable = "avx512f,avx2")]
unsafe fn vector(from: *const PaddedVec3, indices: *const u32, k: usize) -> __m256d {
    unsafe { _mm256_loadu_pd(from.add(*indices.add(k) as usize).cast()) }
}

/// Vectors k and k + 4.
#[inline]
#[target_feature(enable = "avx512f,avx2")]
unsafe fn two_vectors(from: *const PaddedVec3, indices: *const u32, k: usize) -> __m512d {
    unsafe {
        let low = _mm512_castpd256_pd512(vector(from, indices, k));
        _mm512_insertf64x4::<1>(low, vector(from, indices, k + 4))
    }
}

#[inline]
#[target_feature(enable = "avx512f,avx2")]
unsafe fn gather512(from: *const PaddedVec3, indices: *const u32) -> [__m512d; 4] {
    let [a, b, c, d] = unsafe {
        [
            two_vectors(from, indices, 0),
            two_vectors(from, indices, 1),
            two_vectors(from, indices, 2),
            two_vectors(from, indices, 3),
        ]
    };
    let (xz, zx) = (_mm512_unpacklo_pd(a, b), _mm512_unpacklo_pd(c, d));
    let (yw, wy) = (_mm512_unpackhi_pd(a, b), _mm512_unpackhi_pd(c, d));
    let low = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
    let high = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
    [
        _mm512_permutex2var_pd(xz, low, zx),
        _mm512_permutex2var_pd(yw, low, wy),
        _mm512_permutex2var_pd(xz, high, zx),
        _mm512_permutex2var_pd(yw, high, wy),
    ]
}

#[inline]
#[target_feature(enable = "avx512f,avx2")]
fn pairs512([x, y, z]: [__m512d; 3], [u, v, w]: [__m512d; 3]) -> [__m512d; 8] {
    let zero = _mm512_setzero_pd();
    // Quarter q of each belongs to pair 2q, or 2q + 1.
    let [a, c, e, g] = transposed_quarters([
        _mm512_unpacklo_pd(x, y),
        _mm512_unpacklo_pd(z, zero),
        _mm512_unpacklo_pd(u, v),
        _mm512_unpacklo_pd(w, zero),
    ]);
    let [b, d, f, h] = transposed_quarters([
        _mm512_unpackhi_pd(x, y),
        _mm512_unpackhi_pd(z, zero),
        _mm512_unpackhi_pd(u, v),
        _mm512_unpackhi_pd(w, zero),
    ]);
    [a, b, c, d, e, f, g, h]
}

/// Transposes four registers of four quarters.
#[inline]
#[target_feature(enable = "avx512f,avx2")]
fn transposed_quarters([a, b, c, d]: [__m512d; 4]) -> [__m512d; 4] {
    let (ab0, ab1) = (
        _mm512_shuffle_f64x2::<0b01_00_01_00>(a, b),
        _mm512_shuffle_f64x2::<0b11_10_11_10>(a, b),
    );
    let (cd0, cd1) = (
        _mm512_shuffle_f64x2::<0b01_00_01_00>(c, d),
        _mm512_shuffle_f64x2::<0b11_10_11_10>(c, d),
    );
    [
        _mm512_shuffle_f64x2::<0b10_00_10_00>(ab0, cd0),
        _mm512_shuffle_f64x2::<0b11_01_11_01>(ab0, cd0),
        _mm512_shuffle_f64x2::<0b10_00_10_00>(ab1, cd1),
        _mm512_shuffle_f64x2::<0b11_01_11_01>(ab1, cd1),
    ]
}

/// AVX2: two registers of four numbers.
#[derive(Clone, Copy)]
pub(crate) struct Wide256(__m256d, __m256d);

impl Lanes for Wide256 {
    #[inline(always)]
    unsafe fn splat(v: f64) -> Self {
        unsafe { Wide256(_mm256_set1_pd(v), _mm256_set1_pd(v)) }
    }
    #[inline(always)]
    unsafe fn load(from: *const f64) -> Self {
        unsafe { Wide256(_mm256_loadu_pd(from), _mm256_loadu_pd(from.add(WIDTH / 2))) }
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut f64) {
        unsafe {
            _mm256_storeu_pd(to, self.0);
            _mm256_storeu_pd(to.add(WIDTH / 2), self.1);
        }
    }
    #[inline(always)]
    unsafe fn store_low(self, to: *mut f64) {
        unsafe { _mm256_storeu_pd(to, self.0) }
    }
    #[inline(always)]
    unsafe fn load_single(from: *const f32) -> Self {
        unsafe {
            let high = from.add(WIDTH / 2);
            Wide256(
                _mm256_cvtps_pd(_mm_loadu_ps(from)),
                _mm256_cvtps_pd(_mm_loadu_ps(high)),
            )
        }
    }
    #[inline(always)]
    unsafe fn store_single(self, to: *mut f32) {
        unsafe {
            _mm_storeu_ps(to, _mm256_cvtpd_ps(self.0));
            _mm_storeu_ps(to.add(WIDTH / 2), _mm256_cvtpd_ps(self.1));
        }
    }
    #[inline(always)]
    unsafe fn add(self, b: Self) -> Self {
        unsafe { Wide256(_mm256_add_pd(self.0, b.0), _mm256_add_pd(self.1, b.1)) }
    }
    #[inline(always)]
    unsafe fn sub(self, b: Self) -> Self {
        unsafe { Wide256(_mm256_sub_pd(self.0, b.0), _mm256_sub_pd(self.1, b.1)) }
    }
    #[inline(always)]
    unsafe fn mul(self, b: Self) -> Self {
        unsafe { Wide256(_mm256_mul_pd(self.0, b.0), _mm256_mul_pd(self.1, b.1)) }
    }
    #[inline(always)]
    unsafe fn div(self, b: Self) -> Self {
        unsafe { Wide256(_mm256_div_pd(self.0, b.0), _mm256_div_pd(self.1, b.1)) }
    }
    #[inline(always)]
    unsafe fn sqrt(self) -> Self {
        unsafe { Wide256(_mm256_sqrt_pd(self.0), _mm256_sqrt_pd(self.1)) }
    }
    #[inline(always)]
    unsafe fn where_positive(self, mask: Self, other: Self) -> Self {
        unsafe {
            let zero = _mm256_setzero_pd();
            let low = _mm256_cmp_pd::<_CMP_GT_OQ>(mask.0, zero);
            let high = _mm256_cmp_pd::<_CMP_GT_OQ>(mask.1, zero);
            Wide256(
                _mm256_blendv_pd(other.0, self.0, low),
                _mm256_blendv_pd(other.1, self.1, high),
            )
        }
    }
    #[inline(always)]
    unsafe fn keep_if(self, keep: u8) -> Self {
        unsafe {
            let mask = _mm256_castsi256_pd(_mm256_set1_epi64x(-i64::from(keep)));
            Wide256(_mm256_and_pd(self.0, mask), _mm256_and_pd(self.1, mask))
        }
    }
    #[inline(always)]
    unsafe fn gather(from: *const PaddedVec3, indices: *const u32) -> [Self; 3] {
        unsafe {
            let ([x0, y0, z0, _], [x1, y1, z1, _]) = (
                four_vectors(from, indices),
                four_vectors(from, indices.add(4)),
            );
            [Wide256(x0, x1), Wide256(y0, y1), Wide256(z0, z1)]
        }
    }
    #[inline(always)]
    unsafe fn gather4(from: *const PaddedVec3, indices: *const u32) -> [Self; 4] {
        unsafe {
            let ([x0, y0, z0, w0], [x1, y1, z1, w1]) = (
                four_vectors(from, indices),
                four_vectors(from, indices.add(4)),
            );
            [
                Wide256(x0, x1),
                Wide256(y0, y1),
                Wide256(z0, z1),
                Wide256(w0, w1),
            ]
        }
    }
    #[inline(always)]
    unsafe fn pairs(first: [Self; 3], second: [Self; 3]) -> [Self; WIDTH] {
        unsafe {
            let zero = _mm256_setzero_pd();
            let ([x, y, z], [u, v, w]) = (first, second);
            let (a, b) = (
                transposed([x.0, y.0, z.0, zero]),
                transposed([u.0, v.0, w.0, zero]),
            );
            let (c, d) = (
                transposed([x.1, y.1, z.1, zero]),
                transposed([u.1, v.1, w.1, zero]),
            );
            [
                Wide256(a[0], b[0]),
                Wide256(a[1], b[1]),
                Wide256(a[2], b[2]),
                Wide256(a[3], b[3]),
                Wide256(c[0], d[0]),
                Wide256(c[1], d[1]),
                Wide256(c[2], d[2]),
                Wide256(c[3], d[3]),
            ]
        }
    }
}

#[inline]
#[target_feature(enable = "avx2")]
unsafe fn four_vectors(from: *const PaddedVec3, indices: *const u32) -> [__m256d; 4] {
    unsafe {
        transposed([
            _mm256_loadu_pd(from.add(*indices as usize).cast()),
            _mm256_loadu_pd(from.add(*indices.add(1) as usize).cast()),
            _mm256_loadu_pd(from.add(*indices.add(2) as usize).cast()),
            _mm256_loadu_pd(from.add(*indices.add(3) as usize).cast()),
        ])
    }
}

/// Transposes four registers of four numbers.
#[inline]
#[target_feature(enable = "avx2")]
fn transposed([a, b, c, d]: [__m256d; 4]) -> [__m256d; 4] {
    let (ab, ba) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
    let (cd, dc) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
    [
        _mm256_permute2f128_pd::<0x20>(ab, cd),
        _mm256_permute2f128_pd::<0x20>(ba, dc),
        _mm256_permute2f128_pd::<0x31>(ab, cd),
        _mm256_permute2f128_pd::<0x31>(ba, dc),
    ]
}
