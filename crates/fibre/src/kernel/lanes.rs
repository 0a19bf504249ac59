//! Eight numbers at once on AVX-512, AVX2 and plain processors, with the same bits on each: only additions,
//! multiplications, divisions and square roots, which IEEE 754 rounds alike, and nothing fused.
//!
//! The only module of the crate with `unsafe`: instructions that the processor must have, and reads and writes whose
//! bounds are checked once for a whole range instead of for every element.
#![allow(unsafe_code)]

/// Numbers in one [`Lanes`].
pub(crate) const WIDTH: usize = 8;

/// Eight numbers.
///
/// # Safety
/// Implementations use instructions of their [`Level`]; they may be used only where [`Level::best`] has found it.
/// Pointers must be good for eight numbers, and gathered indices below the length of what is gathered from.
pub(crate) trait Lanes: Copy {
    unsafe fn splat(v: f64) -> Self;
    unsafe fn load(from: *const f64) -> Self;
    unsafe fn store(self, to: *mut f64);
    unsafe fn gather(from: *const f64, indices: *const u32) -> Self;
    unsafe fn add(self, b: Self) -> Self;
    unsafe fn sub(self, b: Self) -> Self;
    unsafe fn mul(self, b: Self) -> Self;
    unsafe fn div(self, b: Self) -> Self;
    unsafe fn sqrt(self) -> Self;
    /// `self` where `mask` is above 0, else 0.
    unsafe fn where_positive(self, mask: Self) -> Self;
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
    unsafe fn gather(from: *const f64, indices: *const u32) -> Self {
        let mut made = [0.0; WIDTH];
        for (i, v) in made.iter_mut().enumerate() {
            *v = unsafe { *from.add(*indices.add(i) as usize) };
        }
        Plain(made)
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
    unsafe fn where_positive(self, mask: Self) -> Self {
        self.zip(mask, |a, m| if m > 0.0 { a } else { 0.0 })
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Lanes, WIDTH};
    use core::arch::x86_64::*;

    /// AVX-512F.
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
        unsafe fn gather(from: *const f64, indices: *const u32) -> Self {
            unsafe {
                Wide512(_mm512_i32gather_pd::<8>(
                    _mm256_loadu_si256(indices.cast()),
                    from,
                ))
            }
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
        unsafe fn where_positive(self, mask: Self) -> Self {
            unsafe {
                let m = _mm512_cmp_pd_mask::<_CMP_GT_OQ>(mask.0, _mm512_setzero_pd());
                Wide512(_mm512_maskz_mov_pd(m, self.0))
            }
        }
    }

    /// AVX2, in two halves.
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
        unsafe fn gather(from: *const f64, indices: *const u32) -> Self {
            unsafe {
                let low = _mm_loadu_si128(indices.cast());
                let high = _mm_loadu_si128(indices.add(WIDTH / 2).cast());
                Wide256(
                    _mm256_i32gather_pd::<8>(from, low),
                    _mm256_i32gather_pd::<8>(from, high),
                )
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
        unsafe fn where_positive(self, mask: Self) -> Self {
            unsafe {
                let zero = _mm256_setzero_pd();
                let low = _mm256_cmp_pd::<_CMP_GT_OQ>(mask.0, zero);
                let high = _mm256_cmp_pd::<_CMP_GT_OQ>(mask.1, zero);
                Wide256(_mm256_and_pd(low, self.0), _mm256_and_pd(high, self.1))
            }
        }
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

/// What the rod kernel reads: arrays that begin two entries before the first vertex and go on for at least ten behind
/// the last.
#[derive(Clone, Copy)]
pub(crate) struct RodInput<'a> {
    pub position: [&'a [f64]; 3],
    pub plastic_strain: &'a [f64],
    pub inverse_rest: &'a [f64],
    pub stretch: &'a [f64],
    /// |ē₋||ē₊| of each vertex.
    pub rest_product: &'a [f64],
    /// α/l of each vertex; 0 at ends.
    pub bend: &'a [f64],
}

/// Vertices that the rod kernel does in one go: what it keeps between its passes fits into the first cache.
pub(crate) const BLOCK: usize = 192;
/// Entries read before the first vertex of a block.
pub(crate) const BEFORE: usize = 2;
/// Entries read behind the last vertex of a block, rounding up to whole lanes included.
pub(crate) const BEHIND: usize = 2 + WIDTH;
/// Room for a block with all it reads.
pub(crate) const ROOM: usize = BLOCK + BEFORE + BEHIND + WIDTH;

/// Forces of a block, from the kernel.
pub(crate) type BlockForces = [[f64; ROOM]; 3];

/// What the rod kernel keeps between its passes. Entry k belongs to edge or vertex first − [`BEFORE`] + k.
pub(crate) struct Scratch {
    edge: [[f64; ROOM]; 3],
    pull: [f64; ROOM],
    before: [[f64; ROOM]; 3],
    after: [[f64; ROOM]; 3],
}

impl Scratch {
    pub(crate) const NEW: Scratch = Scratch {
        edge: [[0.0; ROOM]; 3],
        pull: [0.0; ROOM],
        before: [[0.0; ROOM]; 3],
        after: [[0.0; ROOM]; 3],
    };
}

// Functions, not closures: only what is always inlined may take part in a function with its own instructions.

#[inline(always)]
unsafe fn dot<L: Lanes>(u: [L; 3], v: [L; 3]) -> L {
    unsafe { u[0].mul(v[0]).add(u[1].mul(v[1])).add(u[2].mul(v[2])) }
}

#[inline(always)]
unsafe fn cross<L: Lanes>(u: [L; 3], v: [L; 3]) -> [L; 3] {
    unsafe {
        [
            u[1].mul(v[2]).sub(u[2].mul(v[1])),
            u[2].mul(v[0]).sub(u[0].mul(v[2])),
            u[0].mul(v[1]).sub(u[1].mul(v[0])),
        ]
    }
}

#[inline(always)]
unsafe fn scaled<L: Lanes>(u: [L; 3], by: L) -> [L; 3] {
    unsafe { [u[0].mul(by), u[1].mul(by), u[2].mul(by)] }
}

#[inline(always)]
unsafe fn row<L: Lanes>(from: &[f64; ROOM], k: usize) -> L {
    unsafe { L::load(from.as_ptr().add(k)) }
}

#[inline(always)]
unsafe fn rows3<L: Lanes>(from: &[[f64; ROOM]; 3], k: usize) -> [L; 3] {
    unsafe { [row(&from[0], k), row(&from[1], k), row(&from[2], k)] }
}

/// Stretch and bending forces of `count` vertices (at most [`BLOCK`]).
#[inline(always)]
unsafe fn rods<L: Lanes>(
    input: &RodInput,
    count: usize,
    scratch: &mut Scratch,
    out: &mut BlockForces,
) {
    let Scratch {
        edge,
        pull,
        before,
        after,
    } = scratch;
    unsafe {
        let (one, two) = (L::splat(1.0), L::splat(2.0));
        let tiny = L::splat(f64::MIN_POSITIVE);
        let mut k = 0;
        // Edges from two before the first vertex to one behind the last.
        while k < count + 4 {
            let mut e = [one; 3];
            let mut square = tiny;
            for a in 0..3 {
                let p = input.position[a].as_ptr().add(k);
                e[a] = L::load(p.add(1)).sub(L::load(p));
                e[a].store(edge[a].as_mut_ptr().add(k));
                square = square.add(e[a].mul(e[a]));
            }
            let length = square.sqrt();
            let strain = length
                .mul(L::load(input.inverse_rest.as_ptr().add(k)))
                .sub(one)
                .sub(L::load(input.plastic_strain.as_ptr().add(k)));
            let q = L::load(input.stretch.as_ptr().add(k))
                .mul(strain)
                .div(length);
            q.store(pull.as_mut_ptr().add(k));
            k += WIDTH;
        }
        // Bending at vertices from one before the first to one behind the last.
        k = 1;
        while k < count + 3 {
            let (a, b): ([L; 3], [L; 3]) = (rows3(edge, k - 1), rows3(edge, k));
            let c = L::load(input.bend.as_ptr().add(k));
            let denominator = L::load(input.rest_product.as_ptr().add(k)).add(dot(a, b));
            let twice = two.div(denominator);
            let kb = scaled(cross(a, b), twice);
            let square = dot(kb, kb);
            let f = twice.mul(c);
            let (bk, ak) = (cross(b, kb), cross(a, kb));
            for x in 0..3 {
                // The gradients by e₋ and, negated, by e₊.
                let ga = bk[x]
                    .mul(two)
                    .sub(b[x].mul(square))
                    .mul(f)
                    .where_positive(c);
                let gb = ak[x]
                    .mul(two)
                    .add(a[x].mul(square))
                    .mul(f)
                    .where_positive(c);
                ga.store(before[x].as_mut_ptr().add(k));
                gb.store(after[x].as_mut_ptr().add(k));
            }
            k += WIDTH;
        }
        k = BEFORE;
        while k < count + BEFORE {
            let (q1, q0) = (
                L::load(pull.as_ptr().add(k)),
                L::load(pull.as_ptr().add(k - 1)),
            );
            for x in 0..3 {
                let stretch = q1
                    .mul(row::<L>(&edge[x], k))
                    .sub(q0.mul(row::<L>(&edge[x], k - 1)));
                let own = row::<L>(&before[x], k).add(row(&after[x], k));
                let near = row::<L>(&before[x], k + 1).add(row(&after[x], k - 1));
                stretch
                    .add(near.sub(own))
                    .store(out[x].as_mut_ptr().add(k - BEFORE));
            }
            k += WIDTH;
        }
    }
}

/// What the bond kernel reads. All arrays of bonds are equally long, and their length is a multiple of [`WIDTH`].
#[derive(Clone, Copy)]
pub(crate) struct BondInput<'a> {
    pub position: [&'a [f64]; 3],
    pub vertex: &'a [u32],
    pub edge: &'a [u32],
    pub t: &'a [f64],
    pub inverse_distance: &'a [f64],
    pub rest_cosine: &'a [f64],
    pub transverse: &'a [f64],
    /// 2 S.
    pub shear: &'a [f64],
}

/// Forces of one bond on x (three numbers) and on y₁ (three numbers), and two unused: a line of cache.
pub(crate) type BondForce = [f64; 8];

/// Forces of bonds, which are those of `out` in `input`. Indices have been checked against `position`.
#[inline(always)]
unsafe fn bonds<L: Lanes>(input: &BondInput, out: &mut [BondForce]) {
    unsafe {
        let one = L::splat(1.0);
        let mut rows = [[0.0f64; WIDTH]; 6];
        let mut i = 0;
        while i < out.len() {
            let (vertex, first) = (input.vertex.as_ptr().add(i), input.edge.as_ptr().add(i));
            let t = L::load(input.t.as_ptr().add(i));
            let mut e = [one; 3];
            let mut d = [one; 3];
            for a in 0..3 {
                let p = input.position[a].as_ptr();
                let y = L::gather(p, first);
                e[a] = L::gather(p.add(1), first).sub(y);
                d[a] = L::gather(p, vertex).sub(y.add(e[a].mul(t)));
            }
            let (le, ld) = (dot(e, e).sqrt(), dot(d, d).sqrt());
            let inverse = one.div(le.mul(ld));
            let (ie, id) = (inverse.mul(ld), inverse.mul(le));
            let cosine = dot(e, d).mul(inverse);
            let shear = cosine
                .sub(L::load(input.rest_cosine.as_ptr().add(i)))
                .mul(L::load(input.shear.as_ptr().add(i)));
            let pull = ld
                .mul(L::load(input.inverse_distance.as_ptr().add(i)))
                .sub(one)
                .mul(L::load(input.transverse.as_ptr().add(i)));
            // F = B d − A e on x; turn = C e − A d; the force on y₁ is turn − t F.
            let a = shear.mul(inverse);
            let swing = shear.mul(cosine);
            let b = swing.mul(id).sub(pull).mul(id);
            let c = swing.mul(ie).mul(ie);
            for x in 0..3 {
                let on_vertex = d[x].mul(b).sub(e[x].mul(a));
                let turn = e[x].mul(c).sub(d[x].mul(a));
                on_vertex.store(rows[x].as_mut_ptr());
                turn.sub(on_vertex.mul(t)).store(rows[3 + x].as_mut_ptr());
            }
            for (l, force) in out[i..i + WIDTH].iter_mut().enumerate() {
                for (x, row) in rows.iter().enumerate() {
                    force[x] = row[l];
                }
            }
            i += WIDTH;
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2")]
unsafe fn rods_512(input: &RodInput, count: usize, scratch: &mut Scratch, out: &mut BlockForces) {
    unsafe { rods::<x86::Wide512>(input, count, scratch, out) }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn rods_256(input: &RodInput, count: usize, scratch: &mut Scratch, out: &mut BlockForces) {
    unsafe { rods::<x86::Wide256>(input, count, scratch, out) }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2")]
unsafe fn bonds_512(input: &BondInput, out: &mut [BondForce]) {
    unsafe { bonds::<x86::Wide512>(input, out) }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn bonds_256(input: &BondInput, out: &mut [BondForce]) {
    unsafe { bonds::<x86::Wide256>(input, out) }
}

/// Stretch and bending forces of `count` vertices.
pub(crate) fn rod_forces(
    level: Level,
    input: &RodInput,
    count: usize,
    scratch: &mut Scratch,
    out: &mut BlockForces,
) {
    let need = count.div_ceil(WIDTH) * WIDTH + BEFORE + BEHIND;
    let arrays = input.position.into_iter().chain([
        input.plastic_strain,
        input.inverse_rest,
        input.stretch,
        input.rest_product,
        input.bend,
    ]);
    assert!(count <= BLOCK && arrays.into_iter().all(|a| a.len() >= need));
    // Safety: every array holds all that is read, and `level` is no more than the processor has.
    unsafe {
        match level.min(Level::best()) {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => rods_512(input, count, scratch, out),
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => rods_256(input, count, scratch, out),
            _ => rods::<Plain>(input, count, scratch, out),
        }
    }
}

/// Forces of bonds.
pub(crate) fn bond_forces(level: Level, input: &BondInput, out: &mut [BondForce]) {
    let n = out.len();
    let arrays = [
        input.t,
        input.inverse_distance,
        input.rest_cosine,
        input.transverse,
        input.shear,
    ];
    assert!(n.is_multiple_of(WIDTH) && arrays.iter().all(|a| a.len() == n));
    assert!(input.vertex.len() == n && input.edge.len() == n);
    let vertices = input.position.iter().map(|p| p.len()).min().unwrap_or(0);
    let below =
        |indices: &[u32], bound: usize| indices.iter().fold(0, |a, &i| a.max(i as usize)) < bound;
    assert!(
        n == 0
            || (vertices <= i32::MAX as usize
                && below(input.vertex, vertices)
                && below(input.edge, vertices - 1))
    );
    // Safety: as above, and all indices are in range.
    unsafe {
        match level.min(Level::best()) {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => bonds_512(input, out),
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => bonds_256(input, out),
            _ => bonds::<Plain>(input, out),
        }
    }
}
