//! Which bonds may fail: a pass over all bonds that leaves few to look at one by one.
//!
//! Every criterion is a sum of a square of the bond's opening and a square of its shear, each times a number of the
//! bond's own.

use super::super::both;
use super::bonds::{BondTable, Eight, vectors};
use super::lanes::{Lanes, Level, Row, WIDTH, dot, for_each_level};

/// Eights that one task looks at.
const GRAIN: usize = 512;

/// What the squares of eight bonds' strain and of the change of their cosine are multiplied by.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Limits {
    pub opening: [f64; WIDTH],
    pub shearing: [f64; WIDTH],
}

impl Limits {
    pub(crate) const NONE: Limits = Limits {
        opening: [0.0; WIDTH],
        shearing: [0.0; WIDTH],
    };
}

/// Demands of eight bonds.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Demands(pub [f64; WIDTH]);

impl BondTable {
    /// Sets `demands` of all bonds; `pressed` is 1 where pressure counts like tension, else 0.
    pub(crate) fn demands(
        &self,
        level: Level,
        position: &[Row],
        limits: &[Limits],
        pressed: f64,
        demands: &mut [Demands],
    ) {
        assert!(position.len() == self.vertices);
        assert!(limits.len() == self.eights.len() && demands.len() == self.eights.len());
        share(level, position, &self.eights, limits, pressed, demands);
    }
}

fn share(
    level: Level,
    position: &[Row],
    eights: &[Eight],
    limits: &[Limits],
    pressed: f64,
    demands: &mut [Demands],
) {
    if eights.len() > GRAIN {
        let middle = eights.len() / 2;
        let ((e0, e1), (l0, l1)) = (eights.split_at(middle), limits.split_at(middle));
        let (d0, d1) = demands.split_at_mut(middle);
        both(
            || share(level, position, e0, l0, pressed, d0),
            || share(level, position, e1, l1, pressed, d1),
        );
    } else {
        // Safety: vertices, edges and the vertices behind edges are below the number of places, by `BondTable::new`.
        unsafe { demands_at(level, position, eights, limits, pressed, demands) }
    }
}

#[inline(always)]
unsafe fn demands_of<L: Lanes>(
    position: &[Row],
    eights: &[Eight],
    limits: &[Limits],
    pressed: f64,
    demands: &mut [Demands],
) {
    unsafe {
        let (one, pressed) = (L::splat(1.0), L::splat(pressed));
        for ((eight, limit), out) in eights.iter().zip(limits).zip(demands) {
            let now = vectors::<L>(position.as_ptr(), eight);
            let strain = now
                .distance
                .mul(L::load(eight.inverse_distance.as_ptr()))
                .sub(one);
            let off = dot(now.e, now.d)
                .mul(now.inverse)
                .sub(L::load(eight.rest_cosine.as_ptr()));
            let opening = strain.mul(strain).mul(L::load(limit.opening.as_ptr()));
            let opening = opening.where_positive(strain, opening.mul(pressed));
            let shearing = off.mul(off).mul(L::load(limit.shearing.as_ptr()));
            opening.add(shearing).store(out.0.as_mut_ptr());
        }
    }
}

for_each_level! {
    /// [`demands_of`] at a level.
    demands_at = demands_of(
        position: &[Row],
        eights: &[Eight],
        limits: &[Limits],
        pressed: f64,
        demands: &mut [Demands],
    )
}
