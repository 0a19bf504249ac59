//! Demand over strength of bonds: a fast pass over all bonds that leaves few to check one by one.
//!
//! Every criterion is a sum of the squares of the bond's opening and of its slip, each times a factor of the bond.

use super::bonds::{BondBatch, BondTable, vectors};
use super::dispatch::for_each_level;
use super::lanes::{Lanes, WIDTH};
use super::level::SimdLevel;
use super::places::Places;
use crate::parallel::join;

/// Batches that one task checks.
const BATCHES_PER_TASK: usize = 512;

/// Factors of eight bonds on the squares of their opening and of their slip, 1/m².
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct DemandFactors {
    pub opening: [f64; WIDTH],
    pub shearing: [f64; WIDTH],
}

impl DemandFactors {
    pub(crate) const ZERO: DemandFactors = DemandFactors {
        opening: [0.0; WIDTH],
        shearing: [0.0; WIDTH],
    };
}

/// Demands of eight bonds.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Demands(pub [f64; WIDTH]);

impl BondTable {
    /// Sets `demands` of all bonds. `in_compression` is 1 where compression counts like tension, else 0.
    pub(crate) fn demands(
        &self,
        level: SimdLevel,
        places: &Places,
        factors: &[DemandFactors],
        in_compression: f64,
        demands: &mut [Demands],
    ) {
        self.check_places(places);
        assert!(factors.len() == self.batches.len() && demands.len() == self.batches.len());
        demands_of_part(
            level,
            places,
            &self.batches,
            factors,
            in_compression,
            demands,
        );
    }
}

fn demands_of_part(
    level: SimdLevel,
    places: &Places,
    batches: &[BondBatch],
    factors: &[DemandFactors],
    in_compression: f64,
    demands: &mut [Demands],
) {
    if batches.len() > BATCHES_PER_TASK {
        let middle = batches.len() / 2;
        let ((e0, e1), (l0, l1)) = (batches.split_at(middle), factors.split_at(middle));
        let (d0, d1) = demands.split_at_mut(middle);
        join(
            || demands_of_part(level, places, e0, l0, in_compression, d0),
            || demands_of_part(level, places, e1, l1, in_compression, d1),
        );
    } else {
        // Safety: `BondTable::new` makes vertices, edges and the second vertices of edges less than the number of positions.
        unsafe { demands_at(level, places, batches, factors, in_compression, demands) }
    }
}

#[inline(always)]
unsafe fn demands_of<L: Lanes>(
    places: &Places,
    batches: &[BondBatch],
    factors: &[DemandFactors],
    in_compression: f64,
    demands: &mut [Demands],
) {
    unsafe {
        let in_compression = L::splat(in_compression);
        for ((batch, factor), out) in batches.iter().zip(factors).zip(demands) {
            let now = vectors::<L>(places, batch);
            let open = now.across.sub(L::load(batch.rest_opening.as_ptr()));
            let slip = now.along.sub(L::load(batch.rest_slip.as_ptr()));
            let opening = open.mul(open).mul(L::load(factor.opening.as_ptr()));
            let opening = opening.where_positive(open, opening.mul(in_compression));
            let shearing = slip.mul(slip).mul(L::load(factor.shearing.as_ptr()));
            opening.add(shearing).store(out.0.as_mut_ptr());
        }
    }
}

for_each_level! {
    /// [`demands_of`] at a level.
    demands_at = demands_of(
        places: &Places,
        batches: &[BondBatch],
        factors: &[DemandFactors],
        in_compression: f64,
        demands: &mut [Demands],
    )
}
