//! Rings whose edges follow the ring coordinate: as many as wanted of even width, or those of a series.

use super::address::StemAddress;
use super::source::{RingPart, RingPosition, RingSource};
use super::years::grown_edges;
use crate::tissue::{Proportions, Zone};

/// Part of a ring's width that is latewood.
pub const LATEWOOD_FRACTION: f64 = 0.3;

/// Rings whose edges lie at given ring coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct ConcentricRings {
    /// Ring coordinate of the outer edge of each ring, rising; the last is 1 or, for a year that is not over, the ring
    /// beyond it.
    edges: Vec<f64>,
    /// Tissue of each ring.
    tissues: Vec<Zone>,
    /// Number of rings that are complete.
    complete: usize,
    /// The one, counted from 0, that stands for wood whose years are not known.
    unfinished: Option<usize>,
    /// Part of each ring's width that is latewood.
    latewood: f64,
}

impl ConcentricRings {
    /// `rings` of even width, at least one, with tissues by their `proportions`.
    pub fn even(rings: u16, proportions: &Proportions) -> Self {
        let rings = rings.max(1);
        let tissue = |ring: u16| proportions.zone_of_ring(ring.into(), rings.into());
        ConcentricRings {
            edges: (1..=rings)
                .map(|ring| f64::from(ring) / f64::from(rings))
                .collect(),
            tissues: (1..=rings).map(tissue).collect(),
            complete: rings.into(),
            unfinished: None,
            latewood: LATEWOOD_FRACTION,
        }
    }

    /// As many rings as in a tree that grew: wider near the pith and different from year to year, as the seed has it.
    pub fn grown(rings: u16, seed: u64, proportions: &Proportions) -> Self {
        ConcentricRings::with_edges(grown_edges(rings, seed), proportions)
    }

    /// The same in a board, which is sawn from the sapwood.
    #[must_use]
    pub fn of_sapwood(mut self) -> Self {
        self.tissues.fill(Zone::Sapwood);
        self
    }

    /// Rings with outer edges at these ring coordinates, rising and at most 1, as [`super::RingField::coordinates`] gives
    /// them. Where the last is below 1, the rest is the ring of a year that is not over.
    pub fn with_edges(mut edges: Vec<f64>, proportions: &Proportions) -> Self {
        let complete = edges.len();
        if edges.last().is_none_or(|&last| last < 1.0) {
            edges.push(1.0);
        }
        let tissues = edges.iter().map(|&edge| proportions.zone_at(edge, 0.0));
        ConcentricRings {
            tissues: tissues.collect(),
            edges,
            complete,
            unfinished: None,
            latewood: LATEWOOD_FRACTION,
        }
    }

    /// The same with another part of each ring's width as latewood, 0 to 1.
    #[must_use]
    pub fn with_latewood(mut self, fraction: f64) -> Self {
        self.latewood = fraction.clamp(0.0, 1.0);
        self
    }

    /// The same where one of them, counted from 0, is not an annual ring but wood whose years are not known.
    #[must_use]
    pub fn with_unfinished(mut self, ring: Option<usize>) -> Self {
        self.unfinished = ring;
        self
    }

    /// The one of them, counted from 0, that stands for wood whose years are not known: outside the last ring that was
    /// measured, below the bark.
    pub fn unfinished(&self) -> Option<usize> {
        self.unfinished
    }

    /// Ring coordinates of the outer edge of each ring, from the pith.
    pub fn edges(&self) -> &[f64] {
        &self.edges
    }

    /// Tissue of each ring, from the pith.
    pub fn tissues(&self) -> &[Zone] {
        &self.tissues
    }

    /// Inner and outer edge of ring number `index`, counted from 0 at the pith, and where its latewood begins.
    pub fn ring(&self, index: usize) -> RingEdges {
        let inner = if index == 0 {
            0.0
        } else {
            self.edges[index - 1]
        };
        let outer = self.edges[index];
        RingEdges {
            inner,
            latewood: outer - self.latewood * (outer - inner),
            outer,
        }
    }
}

/// The ring coordinates between which a ring lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingEdges {
    /// Where it begins.
    pub inner: f64,
    /// Where its latewood begins.
    pub latewood: f64,
    /// Where it ends.
    pub outer: f64,
}

impl RingSource for ConcentricRings {
    fn edges(&self) -> &[f64] {
        &self.edges
    }

    fn ring_count(&self) -> usize {
        self.complete
    }

    fn ring_at(&self, at: &StemAddress) -> Option<RingPosition> {
        let index = self.edges.partition_point(|&edge| edge < at.rho);
        let index = index.min(self.edges.len() - 1);
        let RingEdges { inner, outer, .. } = self.ring(index);
        let width = outer - inner;
        let fraction = ((at.rho - inner) / width.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let part = if fraction > 1.0 - self.latewood {
            RingPart::Latewood
        } else {
            RingPart::Earlywood
        };
        Some(RingPosition {
            ring: index as i64 + 1,
            fraction,
            width,
            part,
            tissue: self.tissues[index],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    const TISSUE: Proportions = Proportions {
        pith: 0.1,
        heartwood: 0.4,
        phloem: 0.1,
    };

    fn at(rho: f64) -> StemAddress {
        StemAddress {
            rho,
            angle: 0.0,
            across: DVec2::new(rho, 0.0),
            along: 0.0,
        }
    }

    #[test]
    fn even_rings_divide_the_ring_coordinate_evenly() {
        let rings = ConcentricRings::even(10, &TISSUE);
        assert_eq!(rings.ring_count(), 10);
        for k in 0..1000 {
            let rho = (f64::from(k) + 0.5) / 1000.0;
            let found = rings.ring_at(&at(rho)).unwrap();
            let t = 10.0 * rho;
            assert_eq!(found.ring, t.ceil() as i64);
            assert!((found.fraction - t.fract()).abs() < 1e-9);
            assert_eq!(found.part == RingPart::Latewood, t.fract() > 0.7, "{rho}");
            assert_eq!(found.tissue, TISSUE.zone_of_ring(found.ring as u32, 10));
        }
        // Relief beyond the outermost ring belongs to it.
        let beyond = rings.ring_at(&at(1.3)).unwrap();
        assert_eq!((beyond.ring, beyond.fraction), (10, 1.0));
        assert_eq!(beyond.tissue, Zone::Bark);
    }

    #[test]
    fn a_series_that_ends_inside_leaves_a_year_that_is_not_over() {
        let rings = ConcentricRings::with_edges(vec![0.25, 0.75], &TISSUE).with_latewood(0.5);
        assert_eq!(
            (rings.ring_count(), rings.edges()),
            (2, &[0.25, 0.75, 1.0][..])
        );
        let found = |rho| rings.ring_at(&at(rho)).unwrap();
        assert_eq!((found(0.5).ring, found(0.5).fraction), (2, 0.5));
        assert_eq!((found(0.9).ring, found(0.9).part), (3, RingPart::Latewood));
        let board = ConcentricRings::even(4, &TISSUE).of_sapwood();
        assert!(board.tissues().iter().all(|t| *t == Zone::Sapwood));
    }
}
