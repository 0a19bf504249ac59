//! Fitting the model's opening to a trace: where a crack begins and ends, and how wide it is.

use super::crack::MeasuredCrack;
use super::trace::{Trace, TracePoint};
use super::unrolled::Unrolled;
use crate::cracks::profile::relative_opening;
use crate::parameters::CrackKind;

/// How far beyond the trace an end may lie, as a share of the trace, and the steps in which it is looked for.
const REACH: f64 = 0.4;
const STEPS: usize = 24;
/// Share of the darkest places that are black: their darkness stands for a crack that fills its pixels.
const BLACK: f64 = 0.1;

/// Openings along a crack: (position, opening).
struct Profile(Vec<(f64, f64)>);

/// An opening of the model: from, to, the greatest, and the root mean square difference.
#[derive(Clone, Copy)]
struct Fitted {
    from: f64,
    to: f64,
    most: f64,
    off: f64,
}

/// Returns the crack of a trace; `None` where the trace is a dot.
pub(super) fn fit(trace: &Trace, unrolled: &Unrolled) -> Option<MeasuredCrack> {
    let full = full_darkness(unrolled);
    let points = &trace.points;
    let width = |p: &TracePoint| p.sum / full;
    let (first, last) = (points.get(trace.seen.0)?, points.get(trace.seen.1)?);
    if trace.along_ring {
        let profile = Profile(points.iter().map(|p| (p.phi, width(p))).collect());
        let fitted = profile.fit(
            false,
            (first.phi, last.phi),
            (f64::NEG_INFINITY, f64::INFINITY),
        )?;
        let ring = first.rho;
        return Some(MeasuredCrack {
            kind: CrackKind::Tangential,
            angle: fitted.from.to_degrees().rem_euclid(360.0),
            begin: ring,
            end: fitted.to.to_degrees().rem_euclid(360.0),
            open_at_bark: false,
            width: fitted.most,
            opening: fitted.most,
            wander: 0.0,
            residual: fitted.off / fitted.most,
        });
    }
    // The opening of a radial crack over the distance from the pith.
    let profile = Profile(points.iter().map(|p| (p.rho, width(p) / p.rho)).collect());
    let closed = profile.fit(false, (first.rho, last.rho), (0.0, 1.0))?;
    let open = trace
        .at_bark
        .then(|| profile.fit(true, (first.rho, 1.0), (0.0, 1.0)));
    let open = open.flatten().filter(|o| o.off < closed.off);
    let fitted = open.unwrap_or(closed);
    let weight: f64 = points.iter().map(|p| p.sum).sum();
    let phi = points.iter().map(|p| p.phi * p.sum).sum::<f64>() / weight;
    let at = |rho: f64| {
        let t = (rho - fitted.from) / (fitted.to - fitted.from);
        fitted.most * rho * relative_opening(t, open.is_some())
    };
    let steps = (0..=100).map(|i| fitted.from + (fitted.to - fitted.from) * f64::from(i) / 100.0);
    Some(MeasuredCrack {
        kind: CrackKind::Radial,
        angle: phi.to_degrees().rem_euclid(360.0),
        begin: fitted.from,
        end: fitted.to,
        open_at_bark: open.is_some(),
        width: steps.map(at).fold(0.0, f64::max),
        opening: fitted.most,
        wander: spread(points.iter().map(|p| (p.phi - phi) * p.rho)),
        residual: fitted.off / fitted.most,
    })
}

/// Root mean square.
fn spread(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(s, n), v| (s + v * v, n + 1));
    (sum / f64::from(count.max(1))).sqrt()
}

/// The darkness of a place that a crack fills.
fn full_darkness(unrolled: &Unrolled) -> f64 {
    let mut dark: Vec<f32> = unrolled
        .darkness
        .iter()
        .copied()
        .filter(|d| *d > 0.4)
        .collect();
    if dark.is_empty() {
        return 1.0;
    }
    let k = ((1.0 - BLACK) * (dark.len() - 1) as f64) as usize;
    f64::from(*dark.select_nth_unstable_by(k, f32::total_cmp).1)
}

impl Profile {
    /// Fits the opening of a crack that is widest in its middle, or at its `open` end, which then stays where it is. `seen`
    /// are the ends of the trace, `within` the limits of its ends.
    fn fit(&self, open: bool, seen: (f64, f64), within: (f64, f64)) -> Option<Fitted> {
        let length = seen.1 - seen.0;
        if length <= 0.0 {
            return None;
        }
        let place = |k: usize| (k as f64 / STEPS as f64 - 0.15) * REACH * length;
        let ends = if open { 0..=0 } else { 0..=STEPS };
        let mut best: Option<Fitted> = None;
        for to in ends {
            for from in 0..=STEPS {
                let from = (seen.0 - place(from)).max(within.0);
                let to = if open {
                    seen.1
                } else {
                    (seen.1 + place(to)).min(within.1)
                };
                if to - from <= 0.0 {
                    continue;
                }
                let fitted = self.with_ends(open, from, to);
                if best.is_none_or(|b| fitted.off < b.off) {
                    best = Some(fitted);
                }
            }
        }
        best.filter(|b| b.most > 0.0)
    }

    fn with_ends(&self, open: bool, from: f64, to: f64) -> Fitted {
        let shape = |x: f64| relative_opening((x - from) / (to - from), open);
        let (mut sum, mut square) = (0.0, 0.0);
        for &(x, w) in &self.0 {
            sum += shape(x) * w;
            square += shape(x) * shape(x);
        }
        let most = sum / square.max(1e-12);
        let off = spread(self.0.iter().map(|&(x, w)| w - most * shape(x)));
        Fitted {
            from,
            to,
            most,
            off,
        }
    }
}
