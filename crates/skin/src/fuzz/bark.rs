//! What hangs on at the torn edge of bark: strings and straps of inner bark, whose long fibres are the toughest of a stem, and flakes of
//! outer bark that were lifted off.

use super::draw::{Draw, between, of, root, size};
use super::face::Frame;
use super::strand::{Kink, Strand, StrandKind};
use glam::DVec2;

/// Share of them that are straps, of up to three laths; the others are strings.
const WIDE: f64 = 0.22;
/// Lengths and widths of both, m.
const STRAP_LENGTH: (f64, f64) = (3e-3, 9e-3);
const STRAP_WIDTH: (f64, f64) = (0.9e-3, 2.5e-3);
const STRING_LENGTH: (f64, f64) = (1.3e-3, 6.5e-3);
const STRING_WIDTH: (f64, f64) = (0.14e-3, 0.6e-3);
/// Thickness over width, and the range of the thickness, m: bast tears into flat layers.
const FLATNESS: f64 = 0.2;
const THICKNESS: (f64, f64) = (0.04e-3, 0.16e-3);
/// Depth of their roots in the bark, m.
const DEPTH: f64 = 0.4e-3;
/// Share that was folded outwards, so that it hangs, between which parts of its length, and by which angles, degrees.
const HANGING: f64 = 0.1;
const KINK_PLACES: (f64, f64) = (0.33, 0.63);
const KINKS: (f64, f64) = (20.0, 75.0);
/// Part of the distance from the pith at which the bast lies that a strap tore off with: it roots in the whole of the bark.
const INWARDS: f64 = 0.978;

/// Number of the tissue of bark.
pub(super) const BARK: usize = 4;

impl Draw<'_> {
    /// Returns the side to which bark at a place of the section (m from the pith) lifts: outwards, more or less.
    pub fn outwards(&self, from_pith: DVec2) -> DVec2 {
        let out = from_pith.normalize_or(DVec2::X);
        (out + out.perp() * (1.6 * (self.random(1) - 0.5))).normalize_or(out)
    }

    /// Returns the laths of a string or a strap of bark at its torn edge, but for those that would reach too far out of the stem.
    pub fn strap(&self, frame: &Frame) -> Vec<Strand> {
        let random = |k: i64| self.random(k);
        let (forward, size) = (self.forward(), size(self.options.stem));
        // Most hang on by the inner bark, which lies next to the wood.
        let rings = &self.options.stem.rings;
        let ring = |w: &[f64; 3]| rings.address(of(*w, frame.grain).truncate()).0;
        let choices = [2, 4, 6, 30, 32].map(|k| self.weights(k));
        let inner = |a: [f64; 3], b: [f64; 3]| if ring(&b) < ring(&a) { b } else { a };
        let weights = choices.into_iter().fold(choices[0], inner);
        let wide = random(8) < WIDE;
        let long = random(9);
        let (length, width) = match wide {
            true => (
                between(STRAP_LENGTH, long * long),
                between(STRAP_WIDTH, random(10)),
            ),
            false => (
                between(STRING_LENGTH, long * long * long),
                between(STRING_WIDTH, random(10) * random(10)),
            ),
        };
        let (length, width) = (length * size, width * size);
        let hangs = random(11) < HANGING;
        let kink = Kink {
            at: between(KINK_PLACES, random(12)),
            angle: between(KINKS, random(13)).to_radians(),
            toward: 1.4 * (random(14) - 0.5),
        };
        let [curl, sway] = self.together(of(weights, frame.grain), 3e-3 * size);
        let laths = if wide {
            1 + (2.99 * random(22)) as usize
        } else {
            1
        };
        let part = 1.0 / laths as f64;
        let lath = |k: usize| {
            let own = |n: i64| random(40 + 10 * k as i64 + n);
            let middle = (k as f64 + 0.5) * part - 0.5;
            let own_width = width * part * (0.8 + 0.35 * own(0));
            let mut root = root(frame, weights, forward);
            // It shows the bast that it was torn from.
            let pith = rings.pith();
            root.grain = (pith + (root.grain.truncate() - pith) * INWARDS).extend(root.grain.z);
            Strand {
                kind: StrandKind::Strap,
                root,
                beside: middle * width,
                sunk: DEPTH * size,
                kink: if hangs { kink } else { Kink::default() },
                forward,
                length: length * (1.0 - 0.45 * own(1)),
                width: own_width,
                thickness: (FLATNESS * own_width).clamp(THICKNESS.0 * size, THICKNESS.1 * size),
                roll: match frame.is_end {
                    true => self.along_ring(frame) + 0.5 * (random(15) - 0.5),
                    false => 0.6 * (random(15) - 0.5),
                },
                lift: 0.05 + 0.25 * random(16),
                curl: 0.2 + 0.35 * random(17) * random(17) + 0.3 * curl + 0.2 * own(2),
                sway: 0.6 * sway + 0.3 * middle + 0.2 * (own(3) - 0.5),
                ends: [4, 5, 6].map(|k| 1.0 - 0.3 * own(k)),
                ring: 0.0,
            }
        };
        (0..laths)
            .filter_map(|k| self.within(frame, lath(k)))
            .collect()
    }
}
