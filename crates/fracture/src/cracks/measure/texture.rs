//! What tells a crack from texture: from rays, cells, pores, grain and dirt, which are dark and run along the radius too.
//!
//! A crack is a gap. It is dark all along but at its tips, it is many times as long as wide, it runs straight, and its opening
//! rises and falls as one. A line that was joined from cells is dark here and there only and jumps from one to the next.

use super::crack::MeasuredCrack;
use super::trace::{DARKEST, Trace};

/// Share of the length of a line, its tips left out, in which a crack is dark throughout.
const MIN_DARK_SHARE: f64 = 0.5;
/// Share of the length at each end that counts as a tip.
const TIP: f64 = 0.1;
/// Least length of a crack, radii and widths.
const MIN_LENGTH: f64 = 0.05;
pub(super) const MIN_SLENDERNESS: f64 = 4.0;
/// Root mean square distance of a crack from a straight line, over its length.
const MAX_BEND: f64 = 0.05;
/// Root mean square difference of its opening from one that rises and falls once, over the greatest.
const MAX_UNEVENNESS: f64 = 0.4;
/// Share of the length of all dark lines from which on they are taken for texture where they are no cracks.
const TEXTURE_SHARE: f64 = 0.5;

/// Returns whether the line that a radial crack was fitted to is one.
fn is_crack(trace: &Trace, crack: &MeasuredCrack) -> bool {
    crack.length() >= MIN_LENGTH
        && crack.length() >= MIN_SLENDERNESS * crack.width
        && crack.residual <= MAX_UNEVENNESS
        && dark_share(trace) >= MIN_DARK_SHARE
        && bend(trace) <= MAX_BEND * crack.length()
}

/// Returns the share of a line, without its tips, in which it is as dark as the darkest place of a crack must be. Places at which
/// it was lost count as light.
fn dark_share(trace: &Trace) -> f64 {
    let (first, last) = (
        trace.points[0].rho,
        trace.points[trace.points.len() - 1].rho,
    );
    let tip = TIP * (last - first);
    let inner = |rho: f64| rho >= first + tip && rho <= last - tip;
    let inside: Vec<_> = trace.points.iter().filter(|p| inner(p.rho)).collect();
    let Some((a, b)) = inside.first().zip(inside.last()) else {
        return 0.0;
    };
    // Rows are evenly spaced; those at which the line was lost have no place.
    let step = (trace.points.windows(2))
        .map(|w| w[1].rho - w[0].rho)
        .fold(f64::INFINITY, f64::min);
    let rows = ((b.rho - a.rho) / step).round() + 1.0;
    let dark = inside.iter().filter(|p| p.darkest >= DARKEST).count();
    dark as f64 / rows
}

/// Returns the root mean square distance of a line from a straight one across the ring, radii.
fn bend(trace: &Trace) -> f64 {
    let n = trace.points.len() as f64;
    let (mut x, mut y, mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let about = trace.points[0].phi;
    for p in &trace.points {
        let off = (p.phi - about) * p.rho;
        x += p.rho / n;
        y += off / n;
        xx += p.rho * p.rho / n;
        xy += p.rho * off / n;
        yy += off * off / n;
    }
    let (vx, vxy, vy) = (xx - x * x, xy - x * y, yy - y * y);
    if vx <= 0.0 {
        return f64::INFINITY;
    }
    (vy - vxy * vxy / vx).max(0.0).sqrt()
}

/// Radial lines of a section, sorted into cracks and others.
#[derive(Debug, Clone, Default)]
pub(super) struct Sorted {
    /// Those that are cracks.
    pub cracks: Vec<MeasuredCrack>,
    /// Number of the others that are no shorter than a crack may be.
    pub others: usize,
    /// Whether the others are longer, taken together.
    pub is_texture: bool,
}

/// Sorts lines that were fitted as radial cracks. Among lines that are texture for the most part a few look like cracks by chance:
/// there a crack also opens more than every line that is none.
pub(super) fn sort(lines: Vec<(Trace, MeasuredCrack)>) -> Sorted {
    let (cracks, others): (Vec<_>, Vec<_>) =
        (lines.into_iter()).partition(|(trace, crack)| is_crack(trace, crack));
    let mut cracks: Vec<MeasuredCrack> = cracks.into_iter().map(|line| line.1).collect();
    let others = others.into_iter().map(|line| line.1);
    let others: Vec<MeasuredCrack> = others.filter(|c| c.length() >= MIN_LENGTH).collect();
    let length = |lines: &[MeasuredCrack]| lines.iter().map(MeasuredCrack::length).sum::<f64>();
    let (of_cracks, of_others) = (length(&cracks), length(&others));
    let is_texture = of_others > TEXTURE_SHARE * (of_cracks + of_others);
    let mut by_chance = 0;
    if is_texture {
        let opened = |c: &MeasuredCrack| c.length() * c.width;
        let most = others.iter().map(opened).fold(0.0, f64::max);
        let before = cracks.len();
        cracks.retain(|c| opened(c) > most);
        by_chance = before - cracks.len();
    }
    Sorted {
        cracks,
        others: others.len() + by_chance,
        is_texture,
    }
}
