//! Following dark runs from ring to ring.

use super::unrolled::Unrolled;
use crate::layout::wrap_angle;
use std::f64::consts::TAU;

/// Darkness from which on a place belongs to a crack, and which one of its places has at least.
const DARK: f32 = 0.22;
pub(super) const DARKEST: f32 = 0.4;
/// The same for cracks along rings, which latewood that wanders off its ring must not look like.
const DARK_RING: f32 = 0.35;
const DARKEST_RING: f32 = 0.6;
/// Arc of a run, radii, from which on it lies along the ring.
const LONG_ARC: f64 = 0.12;
/// Ring coordinates that are searched: the pith is dark itself, and so is the edge of the bark.
const SEARCHED: (f64, f64) = (0.03, 0.985);
/// Ring coordinate over which a crack may be hidden, and the arc by which it may be off then, radii.
const MAX_GAP: f64 = 0.03;
const MAX_STEP: f64 = 0.02;
/// Ring coordinates by which the parts of a crack along a ring may lie apart.
const RING_SPREAD: f64 = 0.03;
/// Least number of rows beside a crack along a ring that it is compared with.
const MIN_SIDE_ROWS: usize = 4;
/// Share of its length by which a crack along a ring is looked at beyond what is surely a crack.
const MARGIN_ALONG: f64 = 0.8;

/// A place of a crack.
#[derive(Debug, Clone, Copy)]
pub(super) struct TracePoint {
    /// Ring coordinate.
    pub rho: f64,
    /// Angle, rad; they follow each other without jumps.
    pub phi: f64,
    /// Darkness summed up across the crack, radii.
    pub sum: f64,
    /// Darkness of the darkest place across it.
    pub darkest: f32,
}

/// A crack as a line of places.
#[derive(Debug, Clone)]
pub(super) struct Trace {
    pub points: Vec<TracePoint>,
    /// The first and the last of the places that are surely a crack's; those of a radial one all are.
    pub seen: (usize, usize),
    pub along_ring: bool,
    pub darkest: f32,
    /// Whether it reaches the outermost row that is searched.
    pub at_bark: bool,
}

/// A run of dark places in a row.
struct Run {
    phi: f64,
    /// Half its arc, rad.
    half: f64,
    sum: f64,
    darkest: f32,
    columns: (usize, usize),
}

/// Returns the cracks of a section.
pub(super) fn traces(unrolled: &Unrolled) -> Vec<Trace> {
    let rows = unrolled.rows as f64;
    let (first, last) = ((SEARCHED.0 * rows) as usize, (SEARCHED.1 * rows) as usize);
    let mut open: Vec<Trace> = Vec::new();
    let mut done: Vec<Trace> = Vec::new();
    let mut long = Vec::new();
    for row in (first..last).rev() {
        let rho = unrolled.rho(row);
        let is_long = |run: &Run| 2.0 * run.half * rho > LONG_ARC;
        let mut runs = runs(unrolled, row, false);
        runs.retain(|run| !is_long(run));
        let against_ring = self::runs(unrolled, row, true);
        long.extend(
            against_ring
                .iter()
                .filter(|r| is_long(r))
                .map(|r| (row, r.columns)),
        );
        let mut taken = vec![false; runs.len()];
        // The strongest goes on where several meet.
        open.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
        for trace in &mut open {
            let at = trace.points[trace.points.len() - 1];
            let off = |run: &Run| (wrap_angle(run.phi - at.phi).abs() - run.half).max(0.0) * rho;
            let near = (0..runs.len()).filter(|&i| !taken[i] && off(&runs[i]) < MAX_STEP);
            let distance = |i: usize| wrap_angle(runs[i].phi - at.phi).abs();
            if let Some(i) = near.min_by(|&a, &b| distance(a).total_cmp(&distance(b))) {
                taken[i] = true;
                trace.darkest = trace.darkest.max(runs[i].darkest);
                trace.points.push(TracePoint {
                    rho,
                    phi: at.phi + wrap_angle(runs[i].phi - at.phi),
                    sum: runs[i].sum,
                    darkest: runs[i].darkest,
                });
            }
        }
        let (on, over): (Vec<Trace>, Vec<Trace>) =
            (open.into_iter()).partition(|t| t.points[t.points.len() - 1].rho - rho < MAX_GAP);
        done.extend(over);
        open = on;
        let new = runs.iter().zip(&taken).filter(|(_, taken)| !**taken);
        open.extend(new.map(|(run, _)| Trace {
            seen: (0, 0),
            points: vec![TracePoint {
                rho,
                phi: run.phi,
                sum: run.sum,
                darkest: run.darkest,
            }],
            along_ring: false,
            darkest: run.darkest,
            at_bark: rho > SEARCHED.1 - MAX_GAP,
        }));
    }
    done.extend(open);
    done.extend(along_rings(unrolled, &long));
    done.retain(|trace| {
        let darkest = if trace.along_ring {
            DARKEST_RING
        } else {
            DARKEST
        };
        trace.darkest >= darkest && trace.points.len() > 2
    });
    for trace in done.iter_mut().filter(|t| !t.along_ring) {
        trace.points.reverse();
        trace.seen = (0, trace.points.len() - 1);
    }
    done
}

fn strength(trace: &Trace) -> f64 {
    trace.points.iter().map(|p| p.sum).sum()
}

/// Returns the runs of a row, which are darker than what is beside them, or than most of the ring.
fn runs(unrolled: &Unrolled, row: usize, against_ring: bool) -> Vec<Run> {
    let columns = unrolled.columns;
    let at = |column: usize| unrolled.at(row, column, against_ring);
    let least = if against_ring { DARK_RING } else { DARK };
    let dark = |column: usize| at(column) >= least;
    let Some(start) = (0..columns).find(|&c| !dark(c)) else {
        return Vec::new();
    };
    let (rho, step) = (unrolled.rho(row), unrolled.step());
    let mut runs = Vec::new();
    let mut column = start;
    while column < start + columns {
        if !dark(column) {
            column += 1;
            continue;
        }
        let from = column;
        while dark(column) {
            column += 1;
        }
        let values = (from..column).map(|c| (c, at(c)));
        let (mut sum, mut moment, mut darkest) = (0.0, 0.0, 0.0f32);
        for (c, value) in values {
            sum += f64::from(value);
            moment += f64::from(value) * c as f64;
            darkest = darkest.max(value);
        }
        // What is lighter at both edges belongs to the crack too.
        let edges = [from + columns - 1, column].map(|c| f64::from(at(c)));
        runs.push(Run {
            phi: wrap_angle(moment / sum * step),
            half: 0.5 * (column - from) as f64 * step,
            sum: (sum + edges[0] + edges[1]) * step * rho,
            darkest,
            columns: (from, column),
        });
    }
    runs
}

/// Returns the cracks along rings: runs of neighbouring rows that lie over each other, by columns.
fn along_rings(unrolled: &Unrolled, long: &[(usize, (usize, usize))]) -> Vec<Trace> {
    let columns = unrolled.columns;
    let mut parts: Vec<Vec<(usize, (usize, usize))>> = Vec::new();
    let overlap = |a: (usize, usize), b: (usize, usize)| {
        [0, columns].iter().any(|turn| {
            a.0 < b.1 + turn && b.0 + turn < a.1 || b.0 < a.1 + turn && a.0 + turn < b.1
        })
    };
    let near = (RING_SPREAD * unrolled.rows as f64) as usize + 1;
    for &(row, run) in long {
        let touching = |part: &Vec<(usize, (usize, usize))>| {
            part.iter()
                .any(|&(r, other)| r.abs_diff(row) <= near && overlap(run, other))
        };
        let (joined, apart): (Vec<_>, Vec<_>) = parts.into_iter().partition(touching);
        parts = apart;
        let mut part: Vec<_> = joined.into_iter().flatten().collect();
        part.push((row, run));
        parts.push(part);
    }
    parts
        .iter()
        .filter_map(|part| along_ring(unrolled, part))
        .collect()
}

fn along_ring(unrolled: &Unrolled, part: &[(usize, (usize, usize))]) -> Option<Trace> {
    let columns = unrolled.columns;
    let rows = part.iter().map(|p| p.0);
    let margin = 2;
    let low = rows.clone().min()?.saturating_sub(margin);
    let high = (rows.max()? + margin).min(unrolled.rows - 1);
    let mut covered = vec![false; columns];
    part.iter()
        .flat_map(|p| p.1.0..p.1.1)
        .for_each(|c| covered[c % columns] = true);
    let start = (0..columns).find(|&c| covered[c] && !covered[(c + columns - 1) % columns])?;
    let length = covered.iter().filter(|c| **c).count();
    let columns_of_part: Vec<usize> = (0..columns).filter(|&c| covered[c]).collect();
    if !has_two_sides(unrolled, (low, high), &columns_of_part) {
        return None;
    }
    // Thin ends are lost among the grain; places beyond them tell how dark that is, and where the crack has ended.
    let beyond = ((MARGIN_ALONG * length as f64) as usize).min((columns - length) / 2);
    let mut darkest = 0.0f32;
    let mut sums = Vec::with_capacity(length + 2 * beyond);
    let (mut moment, mut weight) = (0.0, 0.0);
    for k in 0..length + 2 * beyond {
        let column = start + columns + k - beyond;
        let (mut sum, mut across) = (0.0, 0.0f32);
        for row in low..=high {
            let value = unrolled.at(row, column, true);
            sum += f64::from(value);
            across = across.max(value);
            if (beyond..beyond + length).contains(&k) {
                darkest = darkest.max(value);
                moment += f64::from(value) * unrolled.rho(row);
                weight += f64::from(value);
            }
        }
        sums.push((sum, across));
    }
    let outside = sums[..beyond / 2]
        .iter()
        .chain(&sums[length + 2 * beyond - beyond / 2..]);
    let grain = outside.map(|s| s.0).sum::<f64>() / (2 * (beyond / 2)).max(1) as f64;
    let points = sums
        .iter()
        .enumerate()
        .map(|(k, (sum, across))| TracePoint {
            rho: moment / weight,
            phi: (start as f64 + k as f64 - beyond as f64) / columns as f64 * TAU,
            sum: (sum - grain) / unrolled.rows as f64,
            darkest: *across,
        });
    let points: Vec<TracePoint> = points.collect();
    Some(Trace {
        seen: (beyond, beyond + length - 1),
        points,
        along_ring: true,
        darkest,
        at_bark: false,
    })
}

/// Returns whether what lies within and beyond a dark band of rows is lighter than the darkest place between, over most of its
/// columns: bark is as dark as the rim of the wood is, and no crack.
fn has_two_sides(unrolled: &Unrolled, (low, high): (usize, usize), columns: &[usize]) -> bool {
    let reach = (high - low + 1).max(MIN_SIDE_ROWS);
    let bright = |row: usize, column: usize| unrolled.brightness[row * unrolled.columns + column];
    let lightest = |rows: std::ops::Range<usize>, column: usize| {
        rows.map(|row| bright(row, column)).fold(0.0, f32::max)
    };
    let beyond = (high + 1)..(high + 1 + reach).min(unrolled.rows);
    let within = low.saturating_sub(reach)..low;
    let is_crack = |column: &&usize| {
        let darkest = (low..=high)
            .map(|row| bright(row, **column))
            .fold(f32::INFINITY, f32::min);
        let sides = [beyond.clone(), within.clone()].map(|rows| lightest(rows, **column));
        darkest < (1.0 - DARK_RING) * sides[0].min(sides[1])
    };
    2 * columns.iter().filter(is_crack).count() > columns.len()
}
