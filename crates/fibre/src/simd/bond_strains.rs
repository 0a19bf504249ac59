//! Openings and slips of all bonds, with the bits of [`BondSpring::strain`](crate::energy::bond::BondSpring::strain).

use super::bonds::{BondBatch, BondTable};
use super::dispatch::for_each_level;
use super::lanes::{Lanes, WIDTH, difference, dot};
use super::level::SimdLevel;
use super::places::Places;
use crate::energy::bond::BondStrain;

/// Openings and slips of eight bonds, m.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct StrainBatch {
    opening: [f64; WIDTH],
    slip: [f64; WIDTH],
}

impl StrainBatch {
    pub(crate) const ZERO: StrainBatch = StrainBatch {
        opening: [0.0; WIDTH],
        slip: [0.0; WIDTH],
    };
}

impl BondTable {
    /// Sets `strains`, one entry for each batch.
    pub(crate) fn strains(&self, level: SimdLevel, places: &Places, strains: &mut [StrainBatch]) {
        self.check_places(places);
        assert!(strains.len() == self.batches.len());
        // Safety: `BondTable::new` makes vertices, edges and the second vertices of edges less than the number of positions.
        unsafe { strains_at(level, places, &self.batches, strains) }
    }

    /// Returns that of one of the bundle's bonds.
    pub(crate) fn strain(&self, strains: &[StrainBatch], bond: usize) -> BondStrain {
        let entry = self.entry(bond);
        let (batch, lane) = (&strains[entry / WIDTH], entry % WIDTH);
        BondStrain {
            opening: batch.opening[lane],
            slip: batch.slip[lane],
        }
    }
}

#[inline(always)]
unsafe fn strains_of<L: Lanes>(
    places: &Places,
    batches: &[BondBatch],
    strains: &mut [StrainBatch],
) {
    unsafe {
        let (position, edges) = (places.position.as_ptr(), places.edge.as_ptr());
        for (batch, out) in batches.iter().zip(strains) {
            let (vertex, edge) = (batch.vertex.as_ptr(), batch.edge.as_ptr());
            let t = L::load(batch.t.as_ptr());
            let (x, y0) = (L::gather(position, vertex), L::gather(position, edge));
            let e = L::gather(edges, edge);
            let c = [
                y0[0].add(e[0].mul(t)),
                y0[1].add(e[1].mul(t)),
                y0[2].add(e[2].mul(t)),
            ];
            let d = difference(x, c);
            let along = dot(e, d).div(dot(e, e).sqrt());
            let across = dot(d, d).sub(along.mul(along));
            let across = across.where_positive(across, L::splat(0.0)).sqrt();
            let opening = across.sub(L::load(batch.rest_opening.as_ptr()));
            let slip = along.sub(L::load(batch.rest_slip.as_ptr()));
            opening.store(out.opening.as_mut_ptr());
            slip.store(out.slip.as_mut_ptr());
        }
    }
}

for_each_level! {
    /// [`strains_of`] at a level.
    strains_at = strains_of(places: &Places, batches: &[BondBatch], strains: &mut [StrainBatch])
}
