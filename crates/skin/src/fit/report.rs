//! What was fitted, and from how many breaks.

use super::breaks::AddressedBreak;
use super::face_shape::FaceShape;
use super::parameters::{FittedValue, UnfittedKeys};
use super::statistics::{Weighted, quantile, spread};
use crate::rods::Wood;
use greenstick_wood::stem::{Stem, StemLocation};
use greenstick_wood::tissue::Zone;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The breaks in a tissue.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TissueBreaks {
    /// The tissue, where the section has the default proportions.
    pub tissue: Zone,
    /// Number of rods that broke in it.
    pub breaks: usize,
    /// Median height over the location of the break, radii.
    pub height: f64,
    /// Height from the 5th to the 95th percentile, radii.
    pub spread: f64,
    /// Number of thorns.
    pub thorns: usize,
}

/// What was fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FitReport {
    /// Number of rods of the wood.
    pub rods: usize,
    /// Number of rods that broke, one break of each.
    pub broken: usize,
    /// Number of those that broke in tension.
    pub tension: usize,
    /// Number of further breaks of the same rods, farther from the others, that are left out.
    pub breaks_again: usize,
    /// Number of breaks elsewhere along the stem that are left out.
    pub breaks_elsewhere: usize,
    /// Part of the section's area that broke.
    pub area: f64,
    /// The location along the stem, in the form that [`StemLocation::parse`] reads.
    pub at: String,
    /// Length along the stem's axis to the break, m.
    pub length_m: f64,
    /// Radius of the stem there, m.
    pub radius_m: f64,
    /// Mean length of the edges of rods, m: heights are no more precise than that.
    pub edge_m: f64,
    /// Lowest and highest break over the location, m.
    pub range_m: [f64; 2],
    /// Height from the 5th to the 95th percentile of the section, whole wood at the location included, m.
    pub relief_m: f64,
    /// The same height of the face that the parameters draw, m.
    pub face_m: f64,
    /// `smooth` or `fibrous`.
    pub surface: String,
    /// Number of layers, 1 to 3.
    pub layers: usize,
    /// Number of thorns that stand up and of those that stand down; a drawn face has thorns that stand up.
    pub thorns: [usize; 2],
    /// Breaks by tissue.
    pub tissues: Vec<TissueBreaks>,
    /// The fitted parameters.
    pub values: Vec<FittedValue>,
    /// The parameters that keep their defaults.
    #[serde(rename = "untold")]
    pub unfitted: Vec<UnfittedKeys>,
}

/// The heights of breaks, m.
pub(super) struct HeightSummary {
    /// Lowest and highest.
    pub range: [f64; 2],
    /// From the 5th to the 95th percentile.
    pub spread: f64,
}

impl HeightSummary {
    /// The heights of breaks on a stem of a radius, m.
    pub fn new(breaks: &[AddressedBreak], radius: f64) -> HeightSummary {
        let height = |b: &AddressedBreak| Weighted {
            value: b.height * radius,
            weight: b.weight,
        };
        let all: Vec<Weighted> = breaks.iter().map(height).collect();
        let values = all.iter().map(|h| h.value);
        HeightSummary {
            range: [
                values.clone().fold(f64::INFINITY, f64::min),
                values.fold(f64::NEG_INFINITY, f64::max),
            ],
            spread: spread(&all),
        }
    }
}

impl FitReport {
    pub(super) fn new(
        wood: &Wood,
        breaks: &[AddressedBreak],
        shape: &FaceShape,
        stem: &Stem,
        location: &StemLocation,
    ) -> Self {
        let section: f64 = wood.cells.iter().map(|c| c.area).sum();
        let broken: f64 = breaks.iter().map(|b| wood.cells[b.rod as usize].area).sum();
        let tissues = Zone::ALL.into_iter();
        FitReport {
            rods: wood.bundle.rods(),
            broken: breaks.len(),
            tension: breaks.iter().filter(|b| b.in_tension).count(),
            breaks_again: 0,
            breaks_elsewhere: 0,
            area: broken / section,
            at: location.to_string(),
            length_m: stem.location,
            radius_m: stem.radius,
            edge_m: 0.0,
            range_m: HeightSummary::new(breaks, stem.radius).range,
            relief_m: 0.0,
            face_m: 0.0,
            surface: format!("{:?}", shape.parameters.face.surface).to_lowercase(),
            layers: shape.layers,
            thorns: shape.thorns,
            tissues: tissues
                .filter_map(|tissue| TissueBreaks::new(tissue, breaks, &shape.is_thorn))
                .collect(),
            values: Vec::new(),
            unfitted: Vec::new(),
        }
    }
}

impl TissueBreaks {
    /// The breaks in a tissue; `None` where there are none.
    fn new(tissue: Zone, breaks: &[AddressedBreak], is_thorn: &[bool]) -> Option<Self> {
        let all = breaks.iter().zip(is_thorn);
        let of: Vec<_> = all.filter(|(b, _)| b.zone == tissue).collect();
        let height = |(b, _): &(&AddressedBreak, &bool)| Weighted {
            value: b.height,
            weight: b.weight,
        };
        let heights: Vec<Weighted> = of.iter().map(height).collect();
        (!of.is_empty()).then(|| TissueBreaks {
            tissue,
            breaks: of.len(),
            height: quantile(&heights, 0.5),
            spread: spread(&heights),
            thorns: of.iter().filter(|(_, thorn)| **thorn).count(),
        })
    }
}

impl fmt::Display for FitReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fmt_breaks(f)?;
        writeln!(
            f,
            "place    {}: {:.2} cm along the stem, radius {:.2} cm; edges of rods {:.2} mm",
            self.at,
            self.length_m * 1e2,
            self.radius_m * 1e2,
            self.edge_m * 1e3
        )?;
        writeln!(
            f,
            "face     {}, {} layer{}, thorns {} up and {} down, from {:.2} to {:.2} mm",
            self.surface,
            self.layers,
            if self.layers == 1 { "" } else { "s" },
            self.thorns[0],
            self.thorns[1],
            self.range_m[0] * 1e3,
            self.range_m[1] * 1e3
        )?;
        writeln!(
            f,
            "relief   {:.2} mm from the 5th to the 95th percentile of the section; the drawn face has {:.2} mm",
            self.relief_m * 1e3,
            self.face_m * 1e3
        )?;
        for t in &self.tissues {
            writeln!(
                f,
                "tissue   {}: {} breaks, at {:+.2} radii, spread over {:.2}, {} thorns",
                t.tissue, t.breaks, t.height, t.spread, t.thorns
            )?;
        }
        for v in &self.values {
            writeln!(
                f,
                "set      {} = {} from {} breaks: {}",
                v.key, v.value, v.breaks, v.basis
            )?;
        }
        for u in &self.unfitted {
            writeln!(f, "default  {}: {}", u.keys, u.why)?;
        }
        Ok(())
    }
}

impl FitReport {
    /// Writes how much broke, and notes on what is left out.
    fn fmt_breaks(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "broken   {} of {} rods, {:.0} % of the section: {} in tension, {} in compression",
            self.broken,
            self.rods,
            100.0 * self.area,
            self.tension,
            self.broken - self.tension
        )?;
        for (count, which) in [
            (self.breaks_again, "further breaks of the same rods"),
            (self.breaks_elsewhere, "breaks elsewhere along the stem"),
        ] {
            if count > 0 {
                writeln!(f, "note     {count} {which} are left out")?;
            }
        }
        if self.broken < self.rods {
            writeln!(
                f,
                "note     {} rods are whole there, but a drawn break divides the whole section; the parameter hang lets \
                 the upper piece hang on",
                self.rods - self.broken
            )?;
        }
        Ok(())
    }
}
