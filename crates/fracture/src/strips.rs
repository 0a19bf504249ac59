//! Strips of bark: bark tears along its furrows, each strip at a height of its own, some peeled back and some standing
//! over the wood as flaps.

use crate::layout::{BEYOND_BARK, FibreBundles};
use crate::parameters::BreakParameters;
use glam::DVec2;
use greenstick_wood::noise;
use std::f64::consts::TAU;

const SEED: u64 = 0xba4c;
/// Share of the strips that stand over the wood as flaps.
const FLAP_SHARE: f64 = 0.2;
/// Share of the strips that are peeled back from the wood.
const PEELED_SHARE: f64 = 0.2;

/// Strips around a stem.
#[derive(Debug, Clone)]
pub(crate) struct Strips {
    /// Angles (rad, ascending) at which they begin, then a turn after the first.
    walls: Vec<f64>,
    /// Height of each over the wood, in bark heights.
    heights: Vec<f64>,
    /// Angles (rad, ascending) between which furrows leave the plates of bark, over a turn.
    plates: Vec<f64>,
    /// Angles (rad, ascending) between which inner bark tears into strings, over a turn.
    strings: Vec<f64>,
    seed: u64,
}

/// Bundles beside each other in a string of inner bark, on average.
const STRING_BUNDLES: u32 = 3;

/// Plates of bark beside each other in a strip, on average.
const PLATES: usize = 3;
/// Bundles beside each other in a plate, on average, at least.
const PLATE_BUNDLES: u32 = 4;
/// Widths of the narrowest and of the broadest strips and plates, over some length.
const PART_WIDTHS: (f64, f64) = (0.25, 2.6);
/// How much of the outline of a strip a plate has from its middle: with more of it the rim would be a row of bricks.
const PLATE_SHARE: f64 = 0.15;
/// By how much the furrows between plates differ in height, by how much plates do that do not meet there, by how much one is higher on
/// one side than on the other, at most, and how much lower its edges are than its middle.
const PLATE_JOINED: f64 = 0.3;
const PLATE_STEP: f64 = 0.03;
const PLATE_SLANT: f64 = 0.2;
const PLATE_BOW: f64 = 0.03;
/// Greatest slope of torn bark outwards, and by how much that of single places differs.
const SLANT: f64 = 5.0;
const CRUMBS: f64 = 0.35;
/// Waves of that slope around a stem: how many over a radius, and its share. It changes evenly: a rim whose plates slant each to a side of
/// its own is a row of bricks.
const SLANT_WAVES: [(f64, f64); 2] = [(1.7, 1.6), (6.0, 0.8)];
/// Greatest distance from the wood, radii, at which bark is as much higher as its slope says: nodes beyond the skin of a section that is
/// not round lie far off.
const THICKEST: f64 = 0.2;

impl Strips {
    pub fn new(p: &BreakParameters) -> Strips {
        let seed = p.seed ^ SEED << 20;
        let count = p.bark_strips as usize;
        let random = |n: usize, what: i64| noise::unit(seed, n as i64, what, 0);
        let walls = uneven_parts(count, |n| random(n, 0));
        let height = |n: usize| {
            let (kind, extent) = (random(n, 1), random(n, 2));
            if kind < FLAP_SHARE {
                0.6 + 1.5 * extent * extent
            } else if kind > 1.0 - PEELED_SHARE {
                -0.5 - 1.2 * extent * extent
            } else {
                0.45 * (extent - 0.5)
            }
        };
        // With one plate for each bundle the rim would be a row of equal teeth.
        let total = (PLATES * count).min((p.sectors / PLATE_BUNDLES) as usize);
        let plates = uneven_parts(total.max(count), |n| noise::unit(seed, n as i64, 3, 2));
        Strips {
            walls,
            heights: (0..count).map(height).collect(),
            plates,
            strings: uneven_parts((p.sectors / STRING_BUNDLES).max(3) as usize, |n| {
                noise::unit(seed, n as i64, 4, 3)
            }),
            seed,
        }
    }

    /// Returns the number of strips.
    pub fn count(&self) -> usize {
        self.heights.len()
    }

    /// Returns the number of the strip at an angle (rad).
    pub fn find(&self, phi: f64) -> usize {
        part_at(&self.walls, phi).0
    }

    /// Returns the angle (rad) of a strip's middle.
    pub fn middle(&self, strip: usize) -> f64 {
        (self.walls[strip] + self.walls[strip + 1]) / 2.0
    }

    /// Returns the number of the plate at an angle (rad).
    pub fn plate(&self, phi: f64) -> usize {
        part_at(&self.plates, phi).0
    }

    /// Returns the number of the string of inner bark at an angle (rad), and the place across it, −1 to 1.
    pub fn string(&self, phi: f64) -> (usize, f64) {
        let (string, phi) = part_at(&self.strings, phi);
        let (from, to) = (self.strings[string], self.strings[string + 1]);
        let across = 2.0 * (phi - from) / (to - from).max(1e-9) - 1.0;
        (string, across.clamp(-1.0, 1.0))
    }

    /// Returns the height of the end of a strip at an angle on a plate, over the wood under its middle, in bark heights. The end
    /// is torn to one side or to a tongue, in steps from plate to plate, whose ends are blunt and ragged.
    pub fn edge(&self, (strip, plate): (usize, usize), phi: f64) -> f64 {
        let (from, to) = (self.plates[plate], self.plates[plate + 1]);
        let half_plate = ((to - from) / 2.0).max(1e-6);
        let off_plate = phi - (from + to) / 2.0;
        let off_plate = off_plate - TAU * (off_plate / TAU).round();
        let across = (off_plate / half_plate).clamp(-1.0, 1.0);
        let own = |what: i64| noise::unit(self.seed, plate as i64, what, 2);
        let half = ((self.walls[strip + 1] - self.walls[strip]) / 2.0).max(1e-6);
        let off = phi - self.middle(strip);
        let off = off - TAU * (off / TAU).round() - PLATE_SHARE * off_plate;
        let v = (off / half).clamp(-1.0, 1.0);
        let random = |what: i64| noise::unit(self.seed, strip as i64, what, 1);
        let height = self.heights[strip];
        // Longer strips narrow more.
        let torn = (0.25 + 0.5 * height.abs()) * (0.5 + random(3));
        let shape = torn_outline(random(4), v);
        let (sin, cos) = libm::sincos(phi);
        // The angle on a circle, so that the edge closes.
        let on = |scale: f64| DVec2::new(cos, sin) * scale;
        let ragged = 0.22 * noise::gradient_2d(self.seed + 1, on(5.0))
            + 0.1 * noise::gradient_2d(self.seed + 2, on(15.0))
            + 0.09 * noise::gradient_2d(self.seed + 3, on(37.0));
        // Plates meet at the furrows between them.
        let count = self.plates.len() - 1;
        let at_furrow = |n: usize| noise::unit(self.seed, (n % count) as i64, 5, 2) - 0.5;
        let (left, right) = (at_furrow(plate), at_furrow(plate + 1));
        let joined = left + (right - left) * (0.5 + 0.5 * across);
        let blunt = PLATE_JOINED * joined
            + PLATE_STEP * (own(0) - 0.5)
            + PLATE_SLANT * (own(1) - 0.5) * across
            - PLATE_BOW * across * across * across * across;
        height + torn * (shape - 0.5) + ragged + blunt
    }
}

/// Returns the angles (rad, ascending, then a turn after the first) at which parts of a turn begin, few of them broad and many narrow.
fn uneven_parts(count: usize, random: impl Fn(usize) -> f64) -> Vec<f64> {
    let width = |n: usize| {
        let (narrowest, broadest) = PART_WIDTHS;
        narrowest + (broadest - narrowest) * random(n) * random(n)
    };
    let total: f64 = (0..count).map(width).sum();
    let mut at = TAU * random(count);
    let mut walls = vec![at];
    for n in 0..count {
        at += TAU * width(n) / total;
        walls.push(at);
    }
    walls[count] = walls[0] + TAU;
    walls
}

/// Returns the number of the part of a turn at an angle (rad), and that angle as its walls (ascending over a turn) count it.
fn part_at(walls: &[f64], phi: f64) -> (usize, f64) {
    let place = (phi - walls[0]) / TAU;
    let phi = walls[0] + (place - place.floor()) * TAU;
    let after = walls.partition_point(|&w| w <= phi);
    (after.clamp(1, walls.len() - 1) - 1, phi)
}

/// Returns the outline of a torn end, 0 to 1, over its width (`v` from −1 to 1). `kind` (0 to 1) selects an end torn to one
/// side, to a point or to two prongs.
fn torn_outline(kind: f64, v: f64) -> f64 {
    let (choice, rest) = (kind * 4.0, kind * 4.0 - (kind * 4.0).floor());
    if choice < 1.2 {
        (1.0 + v) / 2.0
    } else if choice < 2.4 {
        (1.0 - v) / 2.0
    } else if choice < 3.5 {
        let peak = 1.2 * (rest - 0.5);
        1.0 - (v - peak).abs() / (1.0 + peak.abs())
    } else {
        let valley = 0.8 * (rest - 0.5);
        (v - valley).abs() / (1.0 + valley.abs())
    }
}

/// Returns how far each node beyond the bark lies outside of the wood, radii, as far as that counts, and 0 for all others.
pub(crate) fn thickness(bundles: &FibreBundles, (pith, radius): (DVec2, f64)) -> Vec<f64> {
    let layout = &bundles.layout;
    let mut thick = vec![0.0; layout.nodes.len()];
    let outermost = (bundles.addresses.iter()).fold(0.0, |most: f64, a| most.max(a.0));
    let beyond = outermost.min(BEYOND_BARK);
    let is_beyond = |n: u32| bundles.addresses[n as usize].0 >= beyond;
    let from_pith = |n: u32| layout.nodes[n as usize].distance(pith) / radius;
    for (facet, &cell) in layout.facets.iter().zip(&layout.cells) {
        if !bundles.bundles[cell as usize].bark {
            continue;
        }
        let inside = facet.iter().filter(|&&n| !is_beyond(n));
        let inside = inside.fold(0.0, |most: f64, &n| most.max(from_pith(n)));
        for &n in facet.iter().filter(|&&n| is_beyond(n) && inside > 0.0) {
            let from_wood = (from_pith(n) - inside).min(THICKEST);
            thick[n as usize] = from_wood.max(thick[n as usize]);
        }
    }
    // What lies farther out than the bark goes on as that ends.
    for (facet, &cell) in layout.facets.iter().zip(&layout.cells) {
        if bundles.bundles[cell as usize].bark && facet.iter().all(|&n| is_beyond(n)) {
            let at_bark = (facet.iter()).fold(0.0, |most: f64, &n| most.max(thick[n as usize]));
            for &n in facet {
                if bundles.addresses[n as usize].0 == outermost {
                    thick[n as usize] = at_bark;
                }
            }
        }
    }
    thick
}

/// Returns how much higher the torn bark is at a node `thick` (radii) outside of the wood, at an angle (rad), than next to the wood.
/// Bark breaks on the slant: one half shows its thickness, the other overhangs.
pub(crate) fn outward(seed: u64, (node, thick): (u32, f64), phi: f64) -> f64 {
    if thick == 0.0 {
        return 0.0;
    }
    let (sin, cos) = libm::sincos(phi);
    let waves = SLANT_WAVES.iter().zip(seed..);
    let slant = waves.fold(0.0, |sum, (&(per_radius, share), seed)| {
        sum + share * noise::gradient_2d(seed, DVec2::new(cos, sin) * per_radius)
    });
    let crumb = 2.0 * noise::unit(seed, i64::from(node), 2, 0) - 1.0;
    (SLANT * slant.clamp(-1.0, 1.0) + CRUMBS * crumb) * thick
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_angle_has_a_plate_and_plates_are_blunt_and_whole() {
        let strips = Strips::new(&BreakParameters::default());
        let (mut widths, mut jumps) = (vec![0.0; strips.plates.len() - 1], 0);
        const STEPS: i32 = 7200;
        let step = TAU / f64::from(STEPS);
        let at = |i: i32| {
            let phi = step * f64::from(i);
            let (strip, plate) = (strips.find(phi), strips.plate(phi));
            (strip, plate, strips.edge((strip, plate), phi))
        };
        for i in -STEPS / 2..STEPS / 2 {
            let ((strip, plate, height), (next_strip, next_plate, next)) = (at(i), at(i + 1));
            assert_eq!(at(i + STEPS).1, plate, "a turn farther");
            widths[plate] += step;
            let steepness = (next - height).abs() / step;
            if (strip, plate) == (next_strip, next_plate) {
                assert!(steepness < 60.0, "{i}: {steepness}");
            } else {
                jumps += usize::from((next - height).abs() > 0.02);
            }
        }
        for (plate, width) in widths.iter().enumerate() {
            let true_width = strips.plates[plate + 1] - strips.plates[plate];
            assert!((width - true_width).abs() < 2.0 * step, "{plate}");
        }
        assert!(jumps > strips.count(), "{jumps}");
    }

    /// Broad strips and plates lie beside narrow ones, and on a thick stem, too, a plate is several bundles wide: with one for each
    /// bundle the rim would be a row of equal teeth.
    #[test]
    fn strips_and_plates_are_of_many_widths() {
        for seed in 1..9 {
            let p = BreakParameters {
                seed,
                ..BreakParameters::default()
            };
            for p in [p.clone(), p.at_size(0.85)] {
                let strips = Strips::new(&p);
                assert_eq!(strips.count(), p.bark_strips as usize);
                for walls in [&strips.walls, &strips.plates, &strips.strings] {
                    let mut widths: Vec<f64> = walls.windows(2).map(|w| w[1] - w[0]).collect();
                    let sum: f64 = widths.iter().sum();
                    assert!((sum / TAU - 1.0).abs() < 1e-9, "{sum}");
                    widths.sort_by(f64::total_cmp);
                    let (narrow, broad) = (widths[widths.len() / 5], widths[widths.len() * 4 / 5]);
                    assert!(broad > 2.5 * narrow, "{narrow} {broad}");
                }
                let plates = strips.plates.len() - 1;
                assert!(plates >= strips.count() && 4 * plates <= p.sectors as usize);
            }
        }
    }

    /// The rim of torn bark climbs along slanted edges rather than in sheer steps from plate to plate, like bricks.
    #[test]
    fn bark_tears_on_the_slant() {
        let (mut sheer, mut slanted) = (0.0, 0.0);
        for seed in 0..20 {
            let strips = Strips::new(&BreakParameters {
                seed,
                ..BreakParameters::default()
            });
            const STEPS: i32 = 7200;
            let at = |i: i32| {
                let phi = TAU * f64::from(i) / f64::from(STEPS);
                let (strip, plate) = (strips.find(phi), strips.plate(phi));
                (strip, plate, strips.edge((strip, plate), phi))
            };
            for i in 0..STEPS {
                let ((strip, plate, height), (next_strip, next_plate, next)) = (at(i), at(i + 1));
                match (strip == next_strip, plate == next_plate) {
                    (true, true) => slanted += (next - height).abs(),
                    (true, false) => sheer += (next - height).abs(),
                    // Strips come off by themselves.
                    _ => (),
                }
            }
        }
        assert!(slanted > 2.65 * sheer, "{slanted} {sheer}");
    }
}
