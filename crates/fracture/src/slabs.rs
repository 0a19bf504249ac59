//! Slabs and slivers: the coarse and the middle pieces of a torn face, parts of the section bounded by rings and rays.

use crate::layout::FibreBundle;
use glam::DVec2;
use greenstick_wood::noise;
use std::f64::consts::TAU;

/// A region of a section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Region {
    /// Ring coordinates between which it lies.
    pub rho: (f64, f64),
    /// Angles between which it lies, rad, counted from where the partition begins.
    pub phi: (f64, f64),
}

impl Region {
    fn area(&self) -> f64 {
        (self.rho.1 * self.rho.1 - self.rho.0 * self.rho.0) * (self.phi.1 - self.phi.0)
    }

    /// Returns the width along the ring and the thickness across it, in radii.
    pub fn size(&self) -> (f64, f64) {
        let width = (self.phi.1 - self.phi.0) * (self.rho.0 + self.rho.1) / 2.0;
        (width, self.rho.1 - self.rho.0)
    }
}

/// The extent of a section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionSpan {
    /// Ring coordinates.
    pub rho: (f64, f64),
    /// Angles, rad; `None` for all around.
    pub phi: Option<(f64, f64)>,
}

impl SectionSpan {
    /// A whole section: from the pith to the outside, all around.
    pub const WHOLE: SectionSpan = SectionSpan {
        rho: (0.0, 1.0),
        phi: None,
    };

    /// Returns its area, in squares of the unit of the ring coordinate.
    pub(crate) fn area(&self) -> f64 {
        let (low, high) = self.phi.unwrap_or((0.0, TAU));
        0.5 * (self.rho.1 * self.rho.1 - self.rho.0 * self.rho.0) * (high - low)
    }

    /// Returns the extent of the bundles of a layout.
    pub fn from_bundles(bundles: &[FibreBundle]) -> SectionSpan {
        let mut rho = (f64::INFINITY, 0.0f64);
        let mut phi = (f64::INFINITY, f64::NEG_INFINITY);
        for b in bundles {
            rho = (rho.0.min(b.rho), rho.1.max(b.rho.min(1.0)));
            phi = (
                phi.0.min(b.phi - b.half_width),
                phi.1.max(b.phi + b.half_width),
            );
        }
        // A board shows less than half a turn of its rings.
        if phi.1 - phi.0 > 0.5 * TAU || phi.0 > phi.1 {
            return SectionSpan::WHOLE;
        }
        SectionSpan {
            rho,
            phi: Some(phi),
        }
    }
}

/// A node of the tree that leads to the region at a point.
#[derive(Debug, Clone, Copy)]
enum Branch {
    Region(usize),
    /// A split at `at`, in the ring coordinate or in the angle.
    Cut {
        ring: bool,
        at: f64,
        below: usize,
        above: usize,
    },
}

/// Parts of a region at which it is split, and factors on its area by which the next one to be split is chosen.
const PARTS: (f64, f64) = (0.22, 0.78);
const WEIGHTS: (f64, f64) = (0.2, 2.2);

/// A section split by rings and rays.
#[derive(Debug, Clone)]
pub(crate) struct SectionPartition {
    regions: Vec<Region>,
    tree: Vec<Branch>,
    /// Where in the tree each region is.
    leaves: Vec<usize>,
    turn: f64,
    around: bool,
}

impl SectionPartition {
    /// Splits the section into `count` regions of many sizes, each at most `aspect` times as wide along the ring as it is thick
    /// across it.
    pub fn new(span: &SectionSpan, count: usize, aspect: f64, seed: u64) -> Self {
        let around = span.phi.is_none();
        let whole = SectionPartition {
            regions: vec![Region {
                rho: span.rho,
                phi: span.phi.unwrap_or((0.0, TAU)),
            }],
            tree: vec![Branch::Region(0)],
            leaves: vec![0],
            turn: if around {
                TAU * noise::unit(seed, 0, 9, 0)
            } else {
                0.0
            },
            around,
        };
        whole.split(count, aspect, seed, |_| 1.0)
    }

    /// Splits the regions until there are `count` of them, each at most `aspect` times as wide along the ring as it is thick across it.
    /// A region that has half the `fineness` is split into parts of twice the area.
    pub fn split(
        &self,
        count: usize,
        aspect: f64,
        seed: u64,
        fineness: impl Fn(usize) -> f64,
    ) -> Self {
        let mut made = self.clone();
        let random = |n: usize, what: i64| noise::unit(seed, n as i64, what, 0);
        // Of each part that of the region that it is of.
        let mut finenesses: Vec<f64> = (0..made.regions.len()).map(fineness).collect();
        let mut weights: Vec<f64> = (made.regions.iter().zip(&finenesses))
            .map(|(region, fine)| region.area() * fine)
            .collect();
        while made.regions.len() < count {
            let n = made.regions.len();
            let largest = (1..n).fold(0, |l, i| if weights[i] > weights[l] { i } else { l });
            let r = made.regions[largest];
            let part = PARTS.0 + (PARTS.1 - PARTS.0) * random(n, 0);
            let (width, thickness) = r.size();
            let ring = width <= aspect * thickness;
            let (low, high) = if ring { r.rho } else { r.phi };
            let at = low + (high - low) * part;
            let mut other = r;
            if ring {
                (made.regions[largest].rho.1, other.rho.0) = (at, at);
            } else {
                (made.regions[largest].phi.1, other.phi.0) = (at, at);
            }
            let below = made.tree.len();
            made.tree[made.leaves[largest]] = Branch::Cut {
                ring,
                at,
                below,
                above: below + 1,
            };
            (made.tree).extend([Branch::Region(largest), Branch::Region(n)]);
            made.leaves[largest] = below;
            made.leaves.push(below + 1);
            made.regions.push(other);
            // Many are split again and again, few stay broad.
            let fine = finenesses[largest];
            finenesses.push(fine);
            let weight = |random: f64| WEIGHTS.0 + (WEIGHTS.1 - WEIGHTS.0) * random * random;
            weights[largest] = made.regions[largest].area() * fine * weight(random(n, 1));
            weights.push(other.area() * fine * weight(random(n, 2)));
        }
        made
    }

    /// Returns an angle as the regions count it.
    fn region_angle(&self, phi: f64) -> f64 {
        if !self.around {
            return phi;
        }
        let place = (phi - self.turn) / TAU;
        // The floor, without the function call that it takes on older processors.
        let whole = place as i64;
        let whole = whole - i64::from(place < whole as f64);
        (place - whole as f64) * TAU
    }

    /// Returns the number of the region at a ring coordinate and an angle (rad).
    pub fn find(&self, rho: f64, phi: f64) -> usize {
        let phi = self.region_angle(phi);
        let mut branch = 0;
        loop {
            match self.tree[branch] {
                Branch::Region(region) => return region,
                Branch::Cut {
                    ring,
                    at,
                    below,
                    above,
                } => {
                    branch = if (if ring { rho } else { phi }) < at {
                        below
                    } else {
                        above
                    }
                }
            }
        }
    }

    /// Returns the number of regions.
    pub fn count(&self) -> usize {
        self.regions.len()
    }

    /// Returns a region.
    pub fn region(&self, number: usize) -> &Region {
        &self.regions[number]
    }

    /// Returns the ring coordinate and the angle (rad) of a region's middle.
    pub fn middle(&self, number: usize) -> (f64, f64) {
        let r = &self.regions[number];
        (
            (r.rho.0 + r.rho.1) / 2.0,
            (r.phi.0 + r.phi.1) / 2.0 + self.turn,
        )
    }

    /// Returns the coordinates of a point in a region: −1 to 1 along the ring, then −1 to 1 across it.
    pub fn within(&self, number: usize, rho: f64, phi: f64) -> DVec2 {
        let r = &self.regions[number];
        let half = ((r.phi.1 - r.phi.0) / 2.0).max(1e-9);
        let mut off = self.region_angle(phi) - (r.phi.0 + r.phi.1) / 2.0;
        if self.around {
            // Both angles are within a turn.
            off -= match off / TAU {
                turns if turns >= 0.5 => TAU,
                turns if turns <= -0.5 => -TAU,
                _ => 0.0,
            };
        }
        let thick = ((r.rho.1 - r.rho.0) / 2.0).max(1e-9);
        let across = (rho - (r.rho.0 + r.rho.1) / 2.0) / thick;
        DVec2::new(off / half, across).clamp(DVec2::NEG_ONE, DVec2::ONE)
    }
}

/// The shape of a slab, which all its bundles share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Slab {
    /// Height of its ridge, −1 to 1, mean about 0.
    pub height: f64,
    /// Slope across the section, per radius.
    pub slant: DVec2,
    /// Factor on the lengths of its slivers, about 1.
    pub splinters: f64,
    /// Position of the ridge, −1 to 1 along the ring and across it.
    ridge: DVec2,
    /// Drop from the ridge to the edges, as part of the height.
    fall: f64,
    /// How finely it is split into slivers against others.
    fineness: f64,
    /// How much its slivers have of one length, and of its height, 0 to 1.
    pub together: f64,
}

/// What becomes of a slab.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    /// The only one of a face.
    Single,
    /// One of a board or of brittle wood: they differ evenly.
    Even,
    /// It stands far out of the lower piece, or out of the upper one.
    Tongue { up: bool },
    /// It tore short.
    Short,
}

/// Share of the slabs that are tongues, and the fewest and the most of them, where there are as many slabs.
const TONGUES: f64 = 0.4;
const TONGUE_COUNTS: (usize, usize) = (2, 6);
/// Heights of tongues and of what tore short between them, factors on the lengths of their slivers, and drops of tongues from their
/// ridges: their sides are sheer, along the grain.
const TONGUE_HEIGHT: (f64, f64) = (0.7, 1.05);
const SHORT_HEIGHT: (f64, f64) = (0.08, 0.5);
const TONGUE_SPLINTERS: (f64, f64) = (0.9, 1.4);
const SHORT_SPLINTERS: (f64, f64) = (0.3, 0.9);
const TONGUE_FALL: (f64, f64) = (0.5, 0.9);
/// How finely tongues are split into slivers against what tore short.
const TONGUE_FINENESS: f64 = 0.2;
/// How much the slivers of a tongue have of one length.
const TONGUE_TOGETHER: f64 = 0.15;

/// Returns what becomes of each slab: few, most often large ones, are tongues of one piece and the other in turn.
fn kinds(parts: &SectionPartition, brittle: bool, seed: u64) -> Vec<Kind> {
    let count = parts.regions.len();
    if count == 1 {
        return vec![Kind::Single];
    }
    if !parts.around || brittle {
        return vec![Kind::Even; count];
    }
    let size = |n: usize| {
        let random = noise::unit(seed, n as i64, 18, 0);
        parts.regions[n].area().sqrt() * (0.3 + random)
    };
    let mut by_size: Vec<usize> = (0..count).collect();
    by_size.sort_by(|&a, &b| size(b).total_cmp(&size(a)));
    let tongues = (TONGUES * count as f64).round() as usize;
    let tongues = tongues.clamp(TONGUE_COUNTS.0, TONGUE_COUNTS.1).min(count);
    let first = noise::unit(seed, 0, 19, 0) < 0.5;
    let mut kinds = vec![Kind::Short; count];
    for (turn, &n) in by_size[..tongues].iter().enumerate() {
        kinds[n] = Kind::Tongue {
            up: (turn % 2 == 0) == first,
        };
    }
    kinds
}

/// The slabs of a section.
#[derive(Debug, Clone)]
pub(crate) struct Slabs {
    parts: SectionPartition,
    slabs: Vec<Slab>,
}

const SEED: u64 = 0x51ab;
/// Width of slabs over their thickness, at most.
const SLAB_ASPECT: f64 = 1.6;
/// Drop of a board's slab from its ridge to its farther edge over its height.
const BOARD_FALL: f64 = 1.3;

impl Slabs {
    /// Splits the section into `count` slabs. In brittle wood none stands out far.
    pub fn new(span: &SectionSpan, count: usize, brittle: bool, seed: u64) -> Self {
        let seed = seed ^ SEED << 20;
        let parts = SectionPartition::new(span, count, SLAB_ASPECT, seed);
        let kinds = kinds(&parts, brittle, seed);
        let slab = |(n, kind): (usize, &Kind)| {
            let unit = |what: i64| 2.0 * noise::unit(seed, n as i64, what, 0) - 1.0;
            let height = unit(11);
            let between = |(low, high): (f64, f64), at: f64| low + (high - low) * at;
            let (height, splinters, fall) = match kind {
                // Few slabs end in the middle: one piece or the other keeps them.
                Kind::Single => (0.0, 1.0 + 0.6 * unit(14), 1.0 + 0.5 * unit(17)),
                Kind::Even => (
                    (0.25 + 0.75 * height.abs()).copysign(height),
                    1.0 + 0.6 * unit(14),
                    1.0 + 0.5 * unit(17),
                ),
                Kind::Tongue { up } => (
                    between(TONGUE_HEIGHT, height.abs()) * if *up { 1.0 } else { -1.0 },
                    between(TONGUE_SPLINTERS, unit(14).abs()),
                    between(TONGUE_FALL, unit(17).abs()),
                ),
                Kind::Short => (
                    between(SHORT_HEIGHT, height * height).copysign(height),
                    between(SHORT_SPLINTERS, unit(14) * unit(14)),
                    1.0 + 0.5 * unit(17),
                ),
            };
            Slab {
                height,
                slant: DVec2::new(unit(12), unit(13)) * 0.45,
                splinters,
                ridge: DVec2::new(unit(15), unit(16)) * 0.7,
                fall,
                fineness: match kind {
                    Kind::Tongue { .. } => TONGUE_FINENESS,
                    _ => 1.0,
                },
                together: match kind {
                    Kind::Tongue { .. } => TONGUE_TOGETHER,
                    _ => 0.0,
                },
            }
        };
        let slabs = kinds.iter().enumerate().map(slab).collect();
        Slabs { parts, slabs }
    }

    /// Splits the slabs into `count` slivers, each at most `aspect` times as wide along the ring as it is thick across it: tongues
    /// into few broad ones, what tore short between them into many.
    pub fn split(&self, count: usize, aspect: f64, seed: u64) -> SectionPartition {
        (self.parts).split(count, aspect, seed, |n| self.slabs[n].fineness)
    }

    /// Returns the number of the slab at a ring coordinate and an angle (rad), and its height there. Slabs fall off from their
    /// ridges, so that they are no towers with square shoulders.
    pub fn at(&self, rho: f64, phi: f64) -> (usize, f64) {
        let number = self.parts.find(rho, phi);
        (number, self.height(number, rho, phi))
    }

    /// Returns the height of a slab at a ring coordinate and an angle (rad) in it or at its edge.
    pub fn height(&self, number: usize, rho: f64, phi: f64) -> f64 {
        let slab = &self.slabs[number];
        let off = self.parts.within(number, rho, phi) - slab.ridge;
        let far = off.abs() / (DVec2::ONE + slab.ridge.abs());
        let down = if self.parts.around {
            // A slab that runs all around has no edge to fall to.
            let (width, thickness) = self.parts.region(number).size();
            let narrow = (4.0 * thickness / width.max(1e-9)).min(1.0);
            slab.fall * (0.75 * far.x * far.x.sqrt() * narrow + 0.35 * far.y * far.y)
        } else {
            // A wedge that runs out to both edges of the board's slab, on one side over a longer way.
            let side = 1.0 - off.x.signum() * slab.ridge.x;
            let out = off.x.abs() / side;
            (0.5 + 0.5 * slab.fall) * (BOARD_FALL * out + 0.25 * far.y * far.y)
        };
        slab.height * (1.0 - down)
    }

    /// Returns the ring coordinate and the angle (rad) of a slab's middle.
    pub fn middle(&self, number: usize) -> (f64, f64) {
        self.parts.middle(number)
    }

    /// Returns a slab.
    pub fn slab(&self, number: usize) -> &Slab {
        &self.slabs[number]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_fill_the_section_and_a_point_lies_in_the_one_found() {
        for span in [
            SectionSpan {
                rho: (0.0, 1.0),
                phi: None,
            },
            SectionSpan {
                rho: (0.8, 1.0),
                phi: Some((1.1, 1.5)),
            },
        ] {
            let parts = SectionPartition::new(&span, 150, 4.0, 5);
            let whole = Region {
                rho: span.rho,
                phi: span.phi.unwrap_or((0.0, TAU)),
            };
            let sum: f64 = parts.regions.iter().map(Region::area).sum();
            assert!((sum / whole.area() - 1.0).abs() < 1e-12);
            for i in 0..2000 {
                let (s, t) = (f64::from(i) / 2000.0, f64::from(i * 37 % 2000) / 2000.0);
                let rho = span.rho.0 + (span.rho.1 - span.rho.0) * s;
                let (low, high) = span.phi.unwrap_or((-9.0, 9.0));
                let phi = low + (high - low) * t;
                let r = parts.region(parts.find(rho, phi));
                let turned = parts.region_angle(phi);
                assert!(r.rho.0 <= rho && rho <= r.rho.1, "{rho} in {r:?}");
                assert!(r.phi.0 <= turned && turned <= r.phi.1, "{turned} in {r:?}");
                let (ring, ray) = parts.middle(parts.find(rho, phi));
                assert_eq!(parts.find(ring, ray), parts.find(rho, phi));
            }
            // Wide along the ring, but for the few about the pith.
            let flat = parts
                .regions
                .iter()
                .filter(|r| r.size().0 > 1.5 * r.size().1);
            assert!(flat.count() > 100);
        }
    }

    #[test]
    fn few_regions_are_broad_and_many_are_small() {
        for seed in 1..6 {
            let parts = SectionPartition::new(&SectionSpan::WHOLE, 120, 4.0, seed);
            let mut areas: Vec<f64> = parts.regions.iter().map(Region::area).collect();
            areas.sort_unstable_by(f64::total_cmp);
            let of = |part: f64| areas[(part * (areas.len() - 1) as f64) as usize];
            assert!(of(0.95) > 6.0 * of(0.1), "{} {}", of(0.95), of(0.1));
            assert!(of(0.95) > 2.5 * of(0.5), "{} {}", of(0.95), of(0.5));
        }
    }

    /// Few slabs stand far out, of both pieces, and what lies between them tore short. Tongues split into broad slivers, the others into
    /// many small ones, so that slivers are of sizes far apart.
    #[test]
    fn few_tongues_stand_out_and_split_into_broad_slivers() {
        for seed in 1..9 {
            let slabs = Slabs::new(&SectionSpan::WHOLE, 7, false, seed);
            let is_tongue = |n: usize| slabs.slabs[n].height.abs() >= 0.7;
            let tongues: Vec<usize> = (0..7).filter(|&n| is_tongue(n)).collect();
            assert!((2..=4).contains(&tongues.len()), "{tongues:?}");
            let up = tongues.iter().filter(|&&n| slabs.slabs[n].height > 0.0);
            assert!((1..tongues.len()).contains(&up.count()));
            let short = (0..7).filter(|&n| !is_tongue(n));
            assert!({ short }.all(|n| slabs.slabs[n].height.abs() <= 0.5));
            let slivers = slabs.split(90, 4.0, seed);
            assert_eq!(slivers.count(), 90);
            let (mut broad, mut small, mut areas) = ((0.0, 0), (0.0, 0), Vec::new());
            for (n, region) in slivers.regions.iter().enumerate() {
                let (rho, phi) = slivers.middle(n);
                let (number, _) = slabs.at(rho, phi);
                let sum = if is_tongue(number) {
                    &mut broad
                } else {
                    &mut small
                };
                *sum = (sum.0 + region.area(), sum.1 + 1);
                areas.push(region.area());
                // A sliver lies within one slab.
                let ends = [region.phi.0, region.phi.1].map(|a| a + slivers.turn);
                let off = 1e-6 * (ends[1] - ends[0]);
                let at_ends = [ends[0] + off, ends[1] - off].map(|phi| slabs.at(rho, phi).0);
                assert_eq!(at_ends, [number; 2]);
            }
            let mean = |(sum, count): (f64, i32)| sum / f64::from(count);
            assert!(mean(broad) > 2.0 * mean(small), "{broad:?} {small:?}");
            areas.sort_by(f64::total_cmp);
            assert!(areas[88] > 15.0 * areas[2], "{} {}", areas[88], areas[2]);
        }
    }

    /// Clumps of brittle wood run through rings: they are thicker across them than they are wide along them.
    #[test]
    fn parts_run_across_rings_where_they_are_to_be_narrow() {
        for seed in 1..6 {
            let slabs = Slabs::new(&SectionSpan::WHOLE, 7, true, seed);
            let clumps = slabs.split(60, 0.7, seed);
            let across = |n: &usize| {
                let (width, thickness) = clumps.region(*n).size();
                thickness > width
            };
            let count = (0..60).filter(across).count();
            assert!(count > 35, "{count}");
        }
    }

    #[test]
    fn no_slab_of_brittle_wood_or_of_a_board_is_a_tongue() {
        let board = SectionSpan {
            rho: (0.8, 1.0),
            phi: Some((1.1, 1.5)),
        };
        for (span, brittle) in [(SectionSpan::WHOLE, true), (board, false)] {
            let slabs = Slabs::new(&span, 12, brittle, 3);
            assert!(
                slabs
                    .slabs
                    .iter()
                    .all(|s| s.fineness == 1.0 && s.together == 0.0)
            );
        }
    }
}
