//! Bonds made linear about a state: what a small motion does to a bond's length and angle, and the forces that this
//! makes. A matrix of these, with a block for each pair of vertices, is ten times as long to go through as this is.
//!
//! Of the second derivatives only the part that is never negative is kept: for each bond k u uᵀ + 2 S w wᵀ with the
//! gradients u of its length and w of its cosine. Gradients are rounded to half the width: what is made of them is still
//! symmetric, never negative, and zero for whatever moves as a whole without turning.

use super::super::both;
use super::bonds::{BondTable, Eight, vectors};
use super::lanes::{Lanes, Level, Pair, Row, WIDTH, difference, dot, for_each_level};

/// Eights that one task makes linear.
const GRAIN: usize = 256;

/// Gradients of eight bonds by d and by e, times the roots of their stiffness.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Slopes {
    /// Of the length by d: the unit vector along it.
    pub(super) length: [[f32; WIDTH]; 3],
    /// Of the cosine.
    pub(super) by_d: [[f32; WIDTH]; 3],
    pub(super) by_e: [[f32; WIDTH]; 3],
}

impl Slopes {
    pub(crate) const NONE: Slopes = Slopes {
        length: [[0.0; WIDTH]; 3],
        by_d: [[0.0; WIDTH]; 3],
        by_e: [[0.0; WIDTH]; 3],
    };
}

/// One bond made linear: gradients by its vertex x and by y₀ and y₁, times the roots of their stiffness, in the first
/// three of four numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slope {
    /// x, y₀, y₁.
    pub nodes: [u32; 3],
    /// Of its length.
    pub length: [[f64; 4]; 3],
    /// Of its cosine.
    pub cosine: [[f64; 4]; 3],
}

impl BondTable {
    /// Makes all bonds linear about `position`: sets `slopes`, of which there is one for eight bonds.
    pub(crate) fn linearise(&self, level: Level, position: &[Row], slopes: &mut [Slopes]) {
        assert!(position.len() == self.vertices && slopes.len() == self.eights.len());
        linearise(level, position, &self.eights, slopes);
    }

    /// Forces that the motion `x` meets in linear bonds, to be gathered as those of [`BondTable::forces`].
    pub(crate) fn products(
        &self,
        level: Level,
        x: &[Row],
        slopes: &[Slopes],
        force: &mut [Row],
        sums: &mut [Pair],
    ) {
        assert!(x.len() == self.vertices && slopes.len() == self.eights.len());
        self.share(force, sums, &|range, first, force, sums| {
            let (eights, slopes) = (&self.eights[range.clone()], &slopes[range]);
            // Safety: as of `bonds_at` in `BondTable::forces`; there are as many slopes as eights.
            unsafe { products_at(level, x, eights, slopes, first, force, sums) }
        });
    }

    /// Bonds `range` of the table that have stiffness, one after another.
    #[inline(always)]
    pub(crate) fn each_slope(
        &self,
        slopes: &[Slopes],
        range: std::ops::Range<usize>,
        mut work: impl FnMut(&Slope),
    ) {
        for i in range {
            let (l, eight, s) = (i % WIDTH, &self.eights[i / WIDTH], &slopes[i / WIDTH]);
            if eight.transverse[l] == 0.0 && eight.shear[l] == 0.0 {
                continue;
            }
            let of = |v: &[[f32; WIDTH]; 3]| [v[0][l], v[1][l], v[2][l], 0.0].map(f64::from);
            let times = |v: [f64; 4], by: f64| v.map(|v| v * by);
            let (u, w, turn) = (of(&s.length), of(&s.by_d), of(&s.by_e));
            let t = eight.t[l];
            let (before, behind) = (times(w, t - 1.0), times(w, -t));
            let (x, y) = (eight.vertex[l], eight.edge[l]);
            work(&Slope {
                nodes: [x, y, y + 1],
                length: [u, times(u, t - 1.0), times(u, -t)],
                cosine: [
                    w,
                    [0, 1, 2, 3].map(|a| before[a] - turn[a]),
                    [0, 1, 2, 3].map(|a| behind[a] + turn[a]),
                ],
            });
        }
    }
}

fn linearise(level: Level, position: &[Row], eights: &[Eight], slopes: &mut [Slopes]) {
    if eights.len() > GRAIN {
        let middle = eights.len() / 2;
        let ((e0, e1), (s0, s1)) = (eights.split_at(middle), slopes.split_at_mut(middle));
        both(
            || linearise(level, position, e0, s0),
            || linearise(level, position, e1, s1),
        );
    } else {
        // Safety: vertices, edges and the vertices behind edges are below the number of places, by `BondTable::new`.
        unsafe { slopes_at(level, position, eights, slopes) }
    }
}

#[inline(always)]
unsafe fn slopes_of<L: Lanes>(position: &[Row], eights: &[Eight], slopes: &mut [Slopes]) {
    unsafe {
        for (eight, out) in eights.iter().zip(slopes) {
            let now = vectors::<L>(position.as_ptr(), eight);
            // One over the lengths of d and of e.
            let (by_d, by_e) = (now.inverse.mul(now.edge), now.inverse.mul(now.distance));
            let cosine = dot(now.e, now.d).mul(now.inverse);
            let stretch = L::load(eight.transverse.as_ptr())
                .mul(L::load(eight.inverse_distance.as_ptr()))
                .sqrt();
            let shear = L::load(eight.shear.as_ptr()).sqrt();
            let (on_d, on_e) = (shear.mul(by_d), shear.mul(by_e));
            for k in 0..3 {
                let (d, e) = (now.d[k].mul(by_d), now.e[k].mul(by_e));
                d.mul(stretch).store_single(out.length[k].as_mut_ptr());
                let w = e.sub(d.mul(cosine)).mul(on_d);
                w.store_single(out.by_d[k].as_mut_ptr());
                let turn = d.sub(e.mul(cosine)).mul(on_e);
                turn.store_single(out.by_e[k].as_mut_ptr());
            }
        }
    }
}

for_each_level! {
    /// [`slopes_of`] at a level.
    slopes_at = slopes_of(position: &[Row], eights: &[Eight], slopes: &mut [Slopes])
}

#[inline(always)]
pub(super) unsafe fn single3<L: Lanes>(from: &[[f32; WIDTH]; 3]) -> [L; 3] {
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
    x: &[Row],
    eights: &[Eight],
    slopes: &[Slopes],
    first: u32,
    out: &mut [Row],
    sums: &mut [Pair],
) {
    unsafe {
        let x = x.as_ptr();
        let mut sum = L::splat(0.0);
        for (eight, slope) in eights.iter().zip(slopes) {
            let (vertex, edge) = (eight.vertex.as_ptr(), eight.edge.as_ptr());
            let t = L::load(eight.t.as_ptr());
            let y0 = L::rows(x, edge);
            let (e, s) = (
                difference(L::rows(x.add(1), edge), y0),
                difference(L::rows(x, vertex), y0),
            );
            let d = [
                s[0].sub(e[0].mul(t)),
                s[1].sub(e[1].mul(t)),
                s[2].sub(e[2].mul(t)),
            ];
            let (u, w, turn) = (
                single3::<L>(&slope.length),
                single3::<L>(&slope.by_d),
                single3::<L>(&slope.by_e),
            );
            let longer = dot(u, d);
            let turned = dot(w, d).add(dot(turn, e));
            let (mut on_vertex, mut on_end) = ([t; 3], [t; 3]);
            for k in 0..3 {
                on_vertex[k] = u[k].mul(longer).add(w[k].mul(turned));
                on_end[k] = turn[k].mul(turned).sub(on_vertex[k].mul(t));
            }
            let pairs = L::pairs(on_vertex, on_end);
            for (k, pair) in pairs.into_iter().enumerate() {
                sum = sum.kept((eight.same >> k) & 1).add(pair);
                let place = (eight.edge[k] - first) as usize;
                sum.store(sums.as_mut_ptr().add(place).cast());
                pair.store_low(out.as_mut_ptr().add(eight.slot[k] as usize).cast());
            }
        }
    }
}

for_each_level! {
    /// [`products_of`] at a level.
    products_at = products_of(
        x: &[Row],
        eights: &[Eight],
        slopes: &[Slopes],
        first: u32,
        out: &mut [Row],
        sums: &mut [Pair],
    )
}
