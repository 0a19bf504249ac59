//! The outlines of the ends of splinters.
//!
//! A tear runs out along the grain on the slant: most ends taper to one side or to a point off their middle, along edges that bow,
//! few are broken off across.

use greenstick_wood::noise;

/// Shares of the ends of a kind of splinters that are broken off blunt, torn to one side, torn off on one side only, and pointed;
/// the rest is frayed into prongs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ends {
    blunt: f64,
    oblique: f64,
    shouldered: f64,
    pointed: f64,
}

/// The ends of slivers, and of the parts that they split into.
pub(crate) const SLIVERS: Ends = Ends {
    blunt: 0.1,
    oblique: 0.34,
    shouldered: 0.16,
    pointed: 0.14,
};
/// The ends of single bundles: fibres that broke off beside each other.
pub(crate) const BUNDLES: Ends = Ends {
    blunt: 0.24,
    oblique: 0.34,
    shouldered: 0.08,
    pointed: 0.2,
};
/// Height of the shoulder of a lath that was torn off on one side, and the widths over which it is, half the lath's being 1.
const SHOULDER: f64 = 0.3;
const SHOULDER_WIDTH: (f64, f64) = (0.3, 1.1);
/// Least and greatest drop across a blunt end.
const BLUNT_DROP: (f64, f64) = (0.15, 0.5);
/// How far the edges of a taper bow: 1 not at all, 2 to twice the height at the middle over that of a straight one.
const BOW: f64 = 0.34;
/// Greatest distance of a point from the middle of an end, half of its width being 1.
const OFF_MIDDLE: f64 = 0.75;

impl Ends {
    /// Returns the outline of a splinter's end, 0 to 1, over its width (`v` from −1 to 1). `kind` (0 to 1) selects the end.
    pub fn outline(&self, kind: f64, v: f64) -> f64 {
        let mut rest = kind;
        let mut is_next = |share: f64| {
            let inside = rest < share;
            if !inside {
                rest -= share;
            }
            inside.then_some(rest / share)
        };
        if let Some(k) = is_next(self.blunt) {
            let (least, most) = BLUNT_DROP;
            let drop = least + (most - least) * (2.0 * k - 1.0).abs();
            1.0 - drop * (1.0 + if k < 0.5 { v } else { -v }) / 2.0
        } else if let Some(k) = is_next(self.oblique) {
            let (side, bowed) = if k < 0.5 {
                (v, 2.0 * k)
            } else {
                (-v, 2.0 * k - 1.0)
            };
            bow((1.0 + side) / 2.0, bowed)
        } else if let Some(k) = is_next(self.shouldered) {
            let (side, place) = if k < 0.5 {
                (v, 2.0 * k)
            } else {
                (-v, 2.0 * k - 1.0)
            };
            let (least, most) = SHOULDER_WIDTH;
            let width = least + (most - least) * place;
            let from = (place - 0.5) * (2.0 - width) - width / 2.0;
            SHOULDER + (1.0 - SHOULDER) * ((side - from) / width).clamp(0.0, 1.0)
        } else if let Some(k) = is_next(self.pointed) {
            // One side hollow, the other full: a blade that bends to a side.
            let peak = 2.0 * OFF_MIDDLE * (k - 0.5);
            let off = v - peak;
            let part = if off < 0.0 { 1.0 + peak } else { 1.0 - peak };
            let bowed = fraction(8.0 * k);
            bow(
                1.0 - off.abs() / part,
                if off < 0.0 { bowed } else { 1.0 - bowed },
            )
        } else {
            // Two or three prongs of different lengths.
            let k = rest / (1.0 - self.blunt - self.oblique - self.shouldered - self.pointed);
            let place = (1.0 + k) * (v + 1.0);
            let prong = place.floor();
            let random = |n: i64| noise::unit(n as u64, prong as i64, (k * 1e6) as i64, 0);
            let peak = 0.2 + 0.6 * random(1);
            let off = place - prong - peak;
            let part = if off < 0.0 { peak } else { 1.0 - peak };
            let high = 0.4 + 0.6 * random(0);
            0.12 + 0.88 * high * (1.0 - off.abs() / part)
        }
    }
}

fn fraction(x: f64) -> f64 {
    x - x.floor()
}

/// Bends a slope from (0, 0) to (1, 1) up or down: straight where `bowed` is ½, hollow below and full above.
fn bow(t: f64, bowed: f64) -> f64 {
    let middle = 0.5 + BOW * (2.0 * bowed - 1.0) * 0.75;
    t / ((1.0 / middle - 2.0) * (1.0 - t) + 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const KINDS: i32 = 4000;

    /// The outline of the ends of one kind after another, each at 101 places.
    fn outlines(ends: &Ends) -> impl Iterator<Item = Vec<f64>> {
        (0..KINDS).map(|i| {
            let kind = (f64::from(i) + 0.5) / f64::from(KINDS);
            (-50..=50)
                .map(|j| ends.outline(kind, f64::from(j) / 50.0))
                .collect()
        })
    }

    #[test]
    fn ends_of_splinters_run_out_on_the_slant_and_few_are_flat() {
        for ends in [SLIVERS, BUNDLES] {
            let (mut flat, mut slanted, mut leaning) = (0, 0, 0.0);
            for outline in outlines(&ends) {
                let low = outline.iter().copied().fold(1.0, f64::min);
                let high = outline.iter().copied().fold(0.0, f64::max);
                assert!(low >= 0.0 && high <= 1.0 + 1e-12, "{low} to {high}");
                // A top that is level over most of its width is that of a peg.
                let level = outline.iter().filter(|&&h| h > high - 0.08).count();
                flat += i32::from(level > 60);
                slanted += i32::from(high - low > 0.6 && level < 30);
                // Height of one half over that of the other.
                let half = |at: &[f64]| at.iter().sum::<f64>() / 51.0;
                leaning += (half(&outline[50..]) - half(&outline[..51])).abs();
            }
            let share = |n: i32| f64::from(n) / f64::from(KINDS);
            assert!(share(flat) < 0.08, "{}", share(flat));
            assert!(share(slanted) > 0.55, "{}", share(slanted));
            assert!(leaning / f64::from(KINDS) > 0.22, "{leaning}");
        }
    }

    #[test]
    fn edges_bow_to_both_sides_and_no_edge_within_a_tapered_end_is_sheer() {
        let (mut hollow, mut full) = (0, 0);
        for (i, outline) in (0..).zip(outlines(&SLIVERS)) {
            let kind = f64::from(i) / f64::from(KINDS);
            let prongs = kind > 0.74;
            let steepest = outline
                .windows(2)
                .map(|w| (w[1] - w[0]).abs())
                .fold(0.0, f64::max);
            assert!(
                steepest < if prongs { 1.0 } else { 0.2 },
                "{kind}: {steepest}"
            );
            if (0.11..0.43).contains(&kind) {
                hollow += i32::from(outline[50] < 0.4);
                full += i32::from(outline[50] > 0.6);
            }
        }
        assert!(hollow > KINDS / 20 && full > KINDS / 20, "{hollow} {full}");
    }

    #[test]
    fn a_quarter_of_the_splinters_ends_in_several_tips_with_deep_clefts_between() {
        const DEEP: f64 = 0.33;
        let forked = |outline: &Vec<f64>| {
            let (mut tips, mut rising, mut extreme) = (0, true, outline[0]);
            for &h in outline {
                extreme = if rising {
                    extreme.max(h)
                } else {
                    extreme.min(h)
                };
                if (h - extreme).abs() > DEEP {
                    (tips, extreme) = (tips + i32::from(rising), h);
                    rising = !rising;
                }
            }
            tips + i32::from(rising) > 1
        };
        let count = outlines(&SLIVERS).filter(forked).count();
        let share = count as f64 / f64::from(KINDS);
        assert!((0.15..0.4).contains(&share), "{share}");
    }
}
