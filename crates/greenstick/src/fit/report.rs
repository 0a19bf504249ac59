//! What was fitted, and from how much.

use super::heights;
use super::places::{Place, quantile, spread};
use super::shape::Shape;
use super::sheet::{FittedValue, Untold};
use greenstick_skin::rods::Wood;
use greenstick_wood::stem::{self, Stem};
use greenstick_wood::tissue::Zone;
use serde::Serialize;
use std::fmt;

/// The breaks in a tissue.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TissueBreaks {
    /// The tissue, where the section has the proportions that are usual.
    pub tissue: Zone,
    /// Rods that broke in it.
    pub breaks: usize,
    /// Median height over the place of the break, radii.
    pub height: f64,
    /// Height from the 5th to the 95th hundredth, radii.
    pub spread: f64,
    /// Thorns.
    pub thorns: usize,
}

/// What was fitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FitReport {
    /// Rods of the wood.
    pub rods: usize,
    /// Rods that broke, one break of each.
    pub broken: usize,
    /// Those in tension.
    pub tension: usize,
    /// Further breaks of the same rods, farther from the others, that were left out.
    pub breaks_again: usize,
    /// Breaks at other places of the stem, that were left out.
    pub breaks_elsewhere: usize,
    /// Part of the section's area that broke.
    pub area: f64,
    /// The place as `--at` takes it.
    pub at: String,
    /// Length along the stem's axis to the break, m.
    pub length_m: f64,
    /// Radius of the stem there, m.
    pub radius_m: f64,
    /// Mean length of the edges of rods, m: no height is known better.
    pub edge_m: f64,
    /// Lowest and highest break over the place, m.
    pub range_m: [f64; 2],
    /// Height from the 5th to the 95th hundredth of the section, with what is whole at the place, m.
    pub relief_m: f64,
    /// The same of the face that the parameters draw, m.
    pub face_m: f64,
    /// `smooth` or `fibrous`.
    pub surface: String,
    /// Layers, 1 to 3.
    pub layers: usize,
    /// Thorns that stand up and those that stand down; a drawn face has thorns that stand up.
    pub thorns: [usize; 2],
    /// Breaks by tissue.
    pub tissues: Vec<TissueBreaks>,
    /// The parameters that the run told.
    pub values: Vec<FittedValue>,
    /// Those that stay as they are.
    pub untold: Vec<Untold>,
}

impl FitReport {
    pub(super) fn of(
        wood: &Wood,
        places: &[Place],
        shape: &Shape,
        stem: &Stem,
        at: &stem::StemLocation,
    ) -> Self {
        let section: f64 = wood.cells.iter().map(|c| c.area).sum();
        let broken: f64 = places.iter().map(|p| wood.cells[p.rod as usize].area).sum();
        let (range_m, _) = heights(places, stem.radius);
        let tissues = Zone::ALL.into_iter().filter_map(|tissue| {
            let of: Vec<usize> = (0..places.len())
                .filter(|&i| places[i].zone == tissue)
                .collect();
            let all: Vec<(f64, f64)> = of
                .iter()
                .map(|&i| (places[i].height, places[i].weight))
                .collect();
            (!of.is_empty()).then(|| TissueBreaks {
                tissue,
                breaks: of.len(),
                height: quantile(&all, 0.5),
                spread: spread(&all),
                thorns: of.iter().filter(|&&i| shape.thorn[i]).count(),
            })
        });
        FitReport {
            rods: wood.bundle.rods(),
            broken: places.len(),
            tension: places.iter().filter(|p| p.tension).count(),
            breaks_again: 0,
            breaks_elsewhere: 0,
            area: broken / section,
            at: at.to_string(),
            length_m: stem.location,
            radius_m: stem.radius,
            edge_m: 0.0,
            range_m,
            relief_m: 0.0,
            face_m: 0.0,
            surface: format!("{:?}", shape.sheet.face.surface).to_lowercase(),
            layers: shape.layers,
            thorns: shape.thorns,
            tissues: tissues.collect(),
            values: Vec::new(),
            untold: Vec::new(),
        }
    }
}

impl fmt::Display for FitReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
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
            (self.breaks_elsewhere, "breaks at other places of the stem"),
        ] {
            if count > 0 {
                writeln!(f, "note     {count} {which} are left out")?;
            }
        }
        if self.broken < self.rods {
            writeln!(
                f,
                "note     {} rods are whole there, but a drawn break parts all of the section; --hang lets the upper piece hang on",
                self.rods - self.broken
            )?;
        }
        writeln!(
            f,
            "place    --at {}, {:.2} cm along the stem, radius {:.2} cm; edges of rods {:.2} mm",
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
            "relief   {:.2} mm from the 5th to the 95th hundredth of the section; the drawn face has {:.2} mm",
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
        for u in &self.untold {
            writeln!(f, "default  {}: {}", u.keys, u.why)?;
        }
        Ok(())
    }
}
