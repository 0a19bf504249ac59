//! Bonds linearised about a state, as gradients of opening and slip. A product with them is the change of a bond's opening
//! and slip by a small motion, and the forces that this causes. A matrix with a block for each pair of vertices would take
//! ten times as long to read.
//!
//! Of the second derivatives only the Gauss–Newton part is used, which is never negative: for each bond k u uᵀ + k′ w wᵀ
//! with the gradients u of its opening and w of its slip. Gradients are rounded to single precision; the operator is still
//! symmetric, never negative, and zero for translations.

use super::bonds::{BondBatch, BondTable, vectors};
use super::dispatch::for_each_level;
use super::lanes::{Lanes, PaddedPair, PaddedVec3, WIDTH, difference, dot};
use super::level::SimdLevel;
use super::places::Places;
use crate::parallel::join;

/// Batches that one task linearises.
const BATCHES_PER_TASK: usize = 256;

/// Gradients of eight bonds with respect to d and e, times the square roots of their stiffness.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct GradientBatch {
    /// Of the opening with respect to d: the unit vector across the edge.
    pub(super) opening: [[f32; WIDTH]; 3],
    /// Of the opening with respect to e, over that with respect to d.
    pub(super) opening_by_e: [f32; WIDTH],
    /// Of the slip with respect to d: the unit vector along the edge.
    pub(super) slip_by_d: [[f32; WIDTH]; 3],
    /// Of the slip with respect to e.
    pub(super) slip_by_e: [[f32; WIDTH]; 3],
}

impl GradientBatch {
    pub(crate) const ZERO: GradientBatch = GradientBatch {
        opening: [[0.0; WIDTH]; 3],
        opening_by_e: [0.0; WIDTH],
        slip_by_d: [[0.0; WIDTH]; 3],
        slip_by_e: [[0.0; WIDTH]; 3],
    };
}

/// One linearised bond: gradients with respect to its vertex x and to y₀ and y₁, times the square roots of their stiffness,
/// padded to four numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BondGradient {
    /// The vertices x, y₀ and y₁.
    pub vertices: [u32; 3],
    /// Gradients of its opening.
    pub opening: [[f64; 4]; 3],
    /// Gradients of its slip.
    pub slip: [[f64; 4]; 3],
}

impl BondTable {
    /// Linearises all bonds about `position`: sets `gradients`, one entry for each batch.
    pub(crate) fn linearise(
        &self,
        level: SimdLevel,
        places: &Places,
        gradients: &mut [GradientBatch],
    ) {
        self.check_places(places);
        assert!(gradients.len() == self.batches.len());
        linearise(level, places, &self.batches, gradients);
    }

    /// Computes the restoring forces of linearised bonds to the displacement `x`, to be gathered as those of
    /// [`BondTable::forces`].
    pub(crate) fn products(
        &self,
        level: SimdLevel,
        x: &[PaddedVec3],
        gradients: &[GradientBatch],
        force: &mut [PaddedVec3],
        sums: &mut [PaddedPair],
    ) {
        assert!(x.len() == self.vertices && gradients.len() == self.batches.len());
        self.for_each_task(force, sums, &|range, first, force, sums| {
            let (batches, gradients) = (&self.batches[range.clone()], &gradients[range]);
            // Safety: as for `bonds_at` in `BondTable::forces`; there are as many gradients as batches.
            unsafe { products_at(level, x, batches, gradients, first, force, sums) }
        });
    }

    /// Calls `work` for the bonds in `range` of the table that have stiffness.
    #[inline(always)]
    pub(crate) fn for_each_gradient(
        &self,
        gradients: &[GradientBatch],
        range: std::ops::Range<usize>,
        mut work: impl FnMut(&BondGradient),
    ) {
        for i in range {
            let (l, batch, s) = (i % WIDTH, &self.batches[i / WIDTH], &gradients[i / WIDTH]);
            if batch.closing[l] == 0.0 && batch.slip[l] == 0.0 {
                continue;
            }
            let lane = |v: &[[f32; WIDTH]; 3]| [v[0][l], v[1][l], v[2][l], 0.0].map(f64::from);
            let times = |v: [f64; 4], by: f64| v.map(|v| v * by);
            let (u, w, turn) = (lane(&s.opening), lane(&s.slip_by_d), lane(&s.slip_by_e));
            let (t, by_e) = (batch.t[l], f64::from(s.opening_by_e[l]));
            let (before, behind) = (times(w, t - 1.0), times(w, -t));
            let (x, y) = (batch.vertex[l], batch.edge[l]);
            work(&BondGradient {
                vertices: [x, y, y + 1],
                opening: [u, times(u, t - 1.0 - by_e), times(u, by_e - t)],
                slip: [
                    w,
                    [0, 1, 2, 3].map(|a| before[a] - turn[a]),
                    [0, 1, 2, 3].map(|a| behind[a] + turn[a]),
                ],
            });
        }
    }
}

fn linearise(
    level: SimdLevel,
    places: &Places,
    batches: &[BondBatch],
    gradients: &mut [GradientBatch],
) {
    if batches.len() > BATCHES_PER_TASK {
        let middle = batches.len() / 2;
        let ((e0, e1), (s0, s1)) = (batches.split_at(middle), gradients.split_at_mut(middle));
        join(
            || linearise(level, places, e0, s0),
            || linearise(level, places, e1, s1),
        );
    } else {
        // Safety: `BondTable::new` makes vertices, edges and the second vertices of edges less than the number of positions.
        unsafe { gradients_at(level, places, batches, gradients) }
    }
}

#[inline(always)]
unsafe fn gradients_of<L: Lanes>(
    places: &Places,
    batches: &[BondBatch],
    gradients: &mut [GradientBatch],
) {
    unsafe {
        for (batch, out) in batches.iter().zip(gradients) {
            let now = vectors::<L>(places, batch);
            let open = now.across.sub(L::load(batch.rest_opening.as_ptr()));
            let across = L::load(batch.opening.as_ptr())
                .where_positive(open, L::load(batch.closing.as_ptr()))
                .sqrt();
            let along = L::load(batch.slip.as_ptr()).sqrt();
            let by_e = L::splat(0.0).sub(now.along.mul(now.by_edge));
            by_e.store_single(out.opening_by_e.as_mut_ptr());
            let turned = along.mul(now.across).mul(now.by_edge);
            for k in 0..3 {
                let e = now.e[k].mul(now.by_edge);
                let normal = now.d[k].sub(e.mul(now.along)).mul(now.by_across);
                normal.mul(across).store_single(out.opening[k].as_mut_ptr());
                e.mul(along).store_single(out.slip_by_d[k].as_mut_ptr());
                normal
                    .mul(turned)
                    .store_single(out.slip_by_e[k].as_mut_ptr());
            }
        }
    }
}

for_each_level! {
    /// [`gradients_of`] at a level.
    gradients_at = gradients_of(places: &Places, batches: &[BondBatch], gradients: &mut [GradientBatch])
}

#[inline(always)]
pub(super) unsafe fn load_single3<L: Lanes>(from: &[[f32; WIDTH]; 3]) -> [L; 3] {
    unsafe {
        [
            L::load_single(from[0].as_ptr()),
            L::load_single(from[1].as_ptr()),
            L::load_single(from[2].as_ptr()),
        ]
    }
}

#[inline(always)]
unsafe fn products_of<L: Lanes>(
    x: &[PaddedVec3],
    batches: &[BondBatch],
    gradients: &[GradientBatch],
    first: u32,
    out: &mut [PaddedVec3],
    sums: &mut [PaddedPair],
) {
    unsafe {
        let x = x.as_ptr();
        let mut sum = L::splat(0.0);
        for (batch, gradient) in batches.iter().zip(gradients) {
            let (vertex, edge) = (batch.vertex.as_ptr(), batch.edge.as_ptr());
            let t = L::load(batch.t.as_ptr());
            let y0 = L::gather(x, edge);
            let (e, s) = (
                difference(L::gather(x.add(1), edge), y0),
                difference(L::gather(x, vertex), y0),
            );
            let d = [
                s[0].sub(e[0].mul(t)),
                s[1].sub(e[1].mul(t)),
                s[2].sub(e[2].mul(t)),
            ];
            let (u, w, turn) = (
                load_single3::<L>(&gradient.opening),
                load_single3::<L>(&gradient.slip_by_d),
                load_single3::<L>(&gradient.slip_by_e),
            );
            let by_e = L::load_single(gradient.opening_by_e.as_ptr());
            let opened = dot(u, d).add(dot(u, e).mul(by_e));
            let slipped = dot(w, d).add(dot(turn, e));
            let tilted = opened.mul(by_e);
            let (mut on_vertex, mut on_end) = ([t; 3], [t; 3]);
            for k in 0..3 {
                on_vertex[k] = u[k].mul(opened).add(w[k].mul(slipped));
                let turning = turn[k].mul(slipped).add(u[k].mul(tilted));
                on_end[k] = turning.sub(on_vertex[k].mul(t));
            }
            let pairs = L::pairs(on_vertex, on_end);
            for (k, pair) in pairs.into_iter().enumerate() {
                sum = sum.keep_if((batch.same_edge >> k) & 1).add(pair);
                let edge = (batch.edge[k] - first) as usize;
                sum.store(sums.as_mut_ptr().add(edge).cast());
                pair.store_low(out.as_mut_ptr().add(batch.slot[k] as usize).cast());
            }
        }
    }
}

for_each_level! {
    /// [`products_of`] at a level.
    products_at = products_of(
        x: &[PaddedVec3],
        batches: &[BondBatch],
        gradients: &[GradientBatch],
        first: u32,
        out: &mut [PaddedVec3],
        sums: &mut [PaddedPair],
    )
}
