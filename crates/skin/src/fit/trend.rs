//! Trends in the heights of a break: an inclined plane, layers at a height of their own, and the shelf of what was crushed.

use super::breaks::AddressedBreak;
use super::sector_search::{SectionAddress, SectorContents, best_sector};
use super::statistics::{Weighted, quantile, weighted_sum};
use glam::{DMat2, DVec2};
use greenstick_fracture::parameters::Sector;

/// Fewest breaks that decide a plane.
const MIN_PLANE_BREAKS: usize = 6;
/// Least determinant of the second moments of the breaks, as part of their squared trace: less is a line.
const MIN_PLANE_AREA: f64 = 1e-6;
/// Part of the variance that a layer must explain.
const MIN_LAYER_EXPLAINED: f64 = 0.2;
/// Least height of a layer's step, in standard errors: it is the best one of many sectors.
const LAYER_STANDARD_ERRORS: f64 = 4.0;
/// Fewest breaks in a layer, and outside of it: of many sectors some hold a few high ones by chance.
const MIN_LAYER_BREAKS: usize = 5;
/// Explained parts of the variance that differ by less are equal.
const EQUAL_EXPLAINED: f64 = 1e-9;

/// Breaks of the section with their heights, radii.
#[derive(Clone, Copy)]
pub(super) struct HeightSample<'a> {
    pub breaks: &'a [AddressedBreak],
    pub heights: &'a [f64],
}

/// A plane through heights.
pub(super) struct FittedPlane {
    /// Slope, height per radius.
    pub slope: DVec2,
    /// Variance that it leaves.
    pub residual: f64,
}

/// A sector at a height of its own.
pub(super) struct Layer {
    pub sector: Sector,
    /// Height over the rest, radii.
    pub step: f64,
    /// Part of the variance that it explains.
    pub explained: f64,
    /// Number of breaks in it.
    pub count: usize,
}

/// On which side of the rest a layer is to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LayerSide {
    Above,
    Below,
    Either,
}

/// A line across the section with compression on one side and tension on the other.
pub(super) struct ShelfLine {
    /// Part of the section on the compression side, 0 to 1.
    pub part: f64,
    /// Part of the area that it classifies rightly.
    pub right: f64,
}

/// Returns where breaks lie in the section.
pub(super) fn addresses(breaks: &[AddressedBreak]) -> Vec<SectionAddress> {
    let address = |b: &AddressedBreak| SectionAddress {
        angle: b.angle,
        ring: b.ring,
    };
    breaks.iter().map(address).collect()
}

impl HeightSample<'_> {
    /// Heights with the weights of their breaks.
    pub fn weighted(&self) -> Vec<Weighted> {
        let all = self.heights.iter().zip(self.breaks);
        all.map(|(&value, b)| Weighted {
            value,
            weight: b.weight,
        })
        .collect()
    }

    fn mean(&self) -> f64 {
        weighted_sum(&self.weighted())
    }

    /// The variance of the heights.
    pub fn variance(&self) -> f64 {
        let mean = self.mean();
        let square = |v: &Weighted| (v.value - mean) * (v.value - mean) * v.weight;
        self.weighted().iter().map(square).sum()
    }

    /// The plane nearest to the heights by least squares; `None` where there are too few, or all lie on a line.
    pub fn plane(&self) -> Option<FittedPlane> {
        if self.breaks.len() < MIN_PLANE_BREAKS {
            return None;
        }
        let middle: DVec2 = self.breaks.iter().map(|b| b.across * b.weight).sum();
        let mean = self.mean();
        let (mut square, mut with_height) = (DMat2::ZERO, DVec2::ZERO);
        for (b, height) in self.breaks.iter().zip(self.heights) {
            let d = b.across - middle;
            square += DMat2::from_cols(d * d.x, d * d.y) * b.weight;
            with_height += d * ((height - mean) * b.weight);
        }
        let trace = square.x_axis.x + square.y_axis.y;
        if square.determinant() <= MIN_PLANE_AREA * trace * trace {
            return None;
        }
        let slope = square.inverse() * with_height;
        let residuals = self.breaks.iter().zip(self.heights).map(|(b, height)| {
            let off = height - mean - slope.dot(b.across - middle);
            off * off * b.weight
        });
        Some(FittedPlane {
            slope,
            residual: residuals.sum(),
        })
    }

    /// The sector on `side` of the rest that explains most of the variance, where it surely differs from the rest: by
    /// more than `edge`, the precision of heights in radii.
    pub fn layer(&self, side: LayerSide, edge: f64) -> Option<Layer> {
        let signs: &[f64] = match side {
            LayerSide::Above => &[1.0],
            LayerSide::Below => &[-1.0],
            LayerSide::Either => &[1.0, -1.0],
        };
        let mut best: Option<(Layer, f64)> = None;
        for &sign in signs {
            let Some((layer, weight)) = self.layer_of_sign(sign, edge) else {
                continue;
            };
            // A high sector and the low rest explain the same: the smaller one is the layer.
            let better = best.as_ref().is_none_or(|(known, known_weight)| {
                layer.explained > known.explained + EQUAL_EXPLAINED
                    || (layer.explained > known.explained - EQUAL_EXPLAINED
                        && weight < *known_weight)
            });
            if better {
                best = Some((layer, weight));
            }
        }
        best.map(|(layer, _)| layer)
    }

    /// The best layer above (`sign` 1) or below (−1) the rest, with its weight.
    fn layer_of_sign(&self, sign: f64, edge: f64) -> Option<(Layer, f64)> {
        let points = addresses(self.breaks);
        let mean = self.mean();
        let variance = self.variance();
        let all = self.breaks.iter().zip(self.heights);
        let values: Vec<Weighted> = all
            .map(|(b, h)| Weighted {
                value: h - mean,
                weight: b.weight,
            })
            .collect();
        let explained = |c: &SectorContents| {
            let too_few = c.count.min(self.breaks.len() - c.count) < MIN_LAYER_BREAKS;
            if too_few || c.sum * sign <= 0.0 || c.weight >= 1.0 {
                return 0.0;
            }
            c.sum * c.sum / (c.weight * (1.0 - c.weight)) / variance
        };
        let sector = best_sector(&points, &values, explained)?;
        let contents = SectorContents::of(&sector, &points, &values);
        let explained = explained(&contents);
        let median = |inside: bool| {
            let of = points.iter().zip(&values);
            let of = of.filter(|(p, _)| sector.contains(p.angle, p.ring) == inside);
            quantile(&of.map(|(_, v)| *v).collect::<Vec<_>>(), 0.5)
        };
        let step = median(true) - median(false);
        let (n, m) = (
            contents.count as f64,
            (self.breaks.len() - contents.count) as f64,
        );
        let error = ((1.0 - explained).max(0.0) * variance * (1.0 / n + 1.0 / m)).sqrt();
        let sure = step * sign > edge.max(LAYER_STANDARD_ERRORS * error)
            && explained >= MIN_LAYER_EXPLAINED;
        let layer = Layer {
            sector,
            step,
            explained,
            count: contents.count,
        };
        sure.then_some((layer, contents.weight))
    }
}

/// Returns the line across the direction `tension` that divides best what broke in compression from the rest.
pub(super) fn shelf_line(breaks: &[AddressedBreak], tension: DVec2) -> ShelfLine {
    // Weights below zero are those of breaks in tension.
    let mut across: Vec<Weighted> = breaks
        .iter()
        .map(|b| Weighted {
            value: b.shelf.dot(tension),
            weight: if b.in_tension { -b.weight } else { b.weight },
        })
        .collect();
    across.sort_by(|a, b| a.value.total_cmp(&b.value));
    // With nothing on the shelf what broke in tension is right.
    let in_tension = breaks.iter().filter(|b| b.in_tension);
    let mut right: f64 = in_tension.map(|b| b.weight).sum();
    let first = across.first().map_or(-1.0, |a| a.value);
    let (mut best, mut at) = (right, 0.5 * (first - 1.0));
    for (i, v) in across.iter().enumerate() {
        right += v.weight;
        if right > best {
            best = right;
            at = 0.5 * (v.value + across.get(i + 1).map_or(1.0, |next| next.value));
        }
    }
    ShelfLine {
        part: 0.5 * (at + 1.0),
        right: best,
    }
}
