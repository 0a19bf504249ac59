//! All that is measured along a stem.

use super::super::model::Anatomy;
use super::age::years_along;
use super::logs::{LogReport, cut_into_logs};
use super::mass::{MassReport, WoodMass};
use super::measurement_errors::{ErrorsAt, MeasurementErrors};
use super::parameters::MensurationParameters;
use super::profile::{Part, PartEdges, StemProfile};
use super::report::{BreastHeightReport, MensurationReport};
use super::section_size::SectionSize;
use crate::rings::PITH_OFFSET_RMS;
use greenstick_geometry::{Cancelled, Context};

/// Least number of rows where their distance is not given.
const MIN_ROWS: f64 = 20.0;
/// Most rows of the table.
const MAX_ROWS: f64 = 100_000.0;
/// Slices of the profile, at least, and for each row.
const MIN_SLICES: usize = 200;
const SLICES_PER_ROW: usize = 4;
/// Most slices.
const MAX_SLICES: usize = 4000;

/// The measures along a stem.
#[derive(Debug, Clone)]
pub struct StemMeasures {
    /// Sections at equal distances from the butt.
    pub rows: Vec<SectionSize>,
    /// The section at breast height, where the stem is as long.
    pub breast_height: Option<SectionSize>,
    /// Annual rings in each of these sections; none where rings have no widths, as in boards.
    pub years: Vec<u32>,
    /// Ring coordinates at which tissues end.
    edges: PartEdges,
    parameters: MensurationParameters,
    profile: StemProfile,
    errors: Option<MeasurementErrors>,
    pith_is_known: bool,
}

impl StemMeasures {
    /// Measures a stem. `errors` are those of the scan that it comes from.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(
        anatomy: &Anatomy,
        parameters: &MensurationParameters,
        errors: Option<MeasurementErrors>,
        pith_is_known: bool,
        context: &Context,
    ) -> Result<Self, Cancelled> {
        let sections = anatomy.sections();
        let edges = PartEdges {
            heartwood: anatomy.heartwood_edge(),
            cambium: anatomy.cambium(),
        };
        let (low, high) = sections.whole;
        let length = sections.length();
        let wanted = parameters
            .row_spacing
            .unwrap_or_else(|| round_spacing(length / MIN_ROWS));
        let spacing = wanted.max(length / MAX_ROWS);
        let lengths: Vec<f64> = (1..=(length / spacing) as usize)
            .map(|k| k as f64 * spacing)
            .filter(|s| (low..=high).contains(s) && *s < length)
            .collect();
        context.report(0.0)?;
        let size = |section: &_| SectionSize::new(section, edges.cambium);
        let rows = sections.sections_at(&lengths, context)?;
        let rows: Vec<SectionSize> = rows.iter().map(size).collect();
        context.report(0.4)?;
        let breast_height = (low..=high)
            .contains(&parameters.breast_height)
            .then(|| sections.section(parameters.breast_height))
            .flatten();
        let slices = (SLICES_PER_ROW * lengths.len()).clamp(MIN_SLICES, MAX_SLICES);
        Ok(StemMeasures {
            years: years(anatomy, &rows),
            rows,
            breast_height: breast_height.as_ref().map(size),
            edges,
            parameters: parameters.clone(),
            profile: StemProfile::new(sections, slices, edges, context)?,
            errors,
            pith_is_known,
        })
    }

    /// Volume from the butt to a length (m) over and under bark, m³.
    pub fn volumes(&self, length: f64) -> [f64; 2] {
        [Part::OverBark, Part::UnderBark].map(|part| self.profile.volume(length, part))
    }

    /// Volume over bark between two lengths (m), m³.
    pub fn volume_between(&self, from: f64, to: f64) -> f64 {
        self.volumes(to)[0] - self.volumes(from)[0]
    }

    /// Standard errors of these volumes, m³; `None` where the stem is no scan's. Diameters err alike along the stem, as it has
    /// the same side unseen, so that their errors add up.
    pub fn volume_errors(&self, length: f64) -> Option<[f64; 2]> {
        let errors = self.errors.as_ref()?;
        let mut sums = [0.0; 2];
        let mut below = 0.0;
        for row in &self.rows {
            let to = row.length.min(length);
            let relative = errors.at(row.centroid)?.relative;
            self.add_errors(&mut sums, below, to, relative);
            below = to;
        }
        let last = self.rows.last()?;
        let relative = errors.at(last.centroid)?.relative;
        self.add_errors(&mut sums, below, length, relative);
        Some(sums)
    }

    /// Adds the errors of the volumes between two lengths.
    fn add_errors(&self, sums: &mut [f64; 2], from: f64, to: f64, relative: f64) {
        if to > from {
            let (low, high) = (self.volumes(from), self.volumes(to));
            for (sum, (a, b)) in sums.iter_mut().zip(low.into_iter().zip(high)) {
                *sum += 2.0 * relative * (b - a);
            }
        }
    }

    /// Standard errors of a section; `None` where the stem is no scan's.
    pub(super) fn errors_at(&self, size: &SectionSize) -> Option<ErrorsAt> {
        self.errors.as_ref()?.at(size.centroid)
    }

    /// Standard error of the pith's place in a section, m: that of a guess unless it was given.
    pub(super) fn pith_error(&self, size: &SectionSize) -> f64 {
        if self.pith_is_known {
            0.0
        } else {
            PITH_OFFSET_RMS * 0.5 * size.diameter_by_area()
        }
    }

    /// The logs of the stem.
    pub fn logs(&self) -> LogReport {
        let relative = |length: f64| {
            let distance = |row: &&SectionSize| (row.length - length).abs();
            let nearest = self
                .rows
                .iter()
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
            Some(self.errors_at(nearest)?.relative)
        };
        cut_into_logs(&self.profile, &self.parameters.log_options(), &relative)
    }

    /// Returns what the wood of the stem weighs.
    pub fn mass(&self, wood: &WoodMass) -> MassReport {
        let volume = |part| self.profile.volume(self.profile.length(), part);
        let heartwood = volume(Part::Heartwood);
        wood.report([heartwood, volume(Part::UnderBark) - heartwood])
    }

    /// Returns the numbers that stand in the report.
    pub fn report(&self) -> MensurationReport {
        let length = self.profile.length();
        let [over, under] = self.volumes(length);
        let errors = self.volume_errors(length);
        MensurationReport {
            breast_height_m: self.parameters.breast_height,
            at_breast_height: self.breast_height.as_ref().map(|size| {
                let errors = self.errors_at(size);
                BreastHeightReport::new(size, errors)
            }),
            volume_over_bark_m3: over,
            volume_over_bark_error_m3: errors.map(|e| e[0]),
            volume_under_bark_m3: under,
            volume_under_bark_error_m3: errors.map(|e| e[1]),
            bark_share: 1.0 - self.edges.cambium,
            length_error_m: self.errors.as_ref().map(|e| e.length),
            rings_at_butt: self.years.first().copied(),
            logs: self.logs(),
        }
    }
}

/// Annual rings in sections from the butt on, whose wood has as many as the model has at the butt.
fn years(anatomy: &Anatomy, rows: &[SectionSize]) -> Vec<u32> {
    let wood_radius = |size: &SectionSize| 0.5 * size.diameter_under_bark();
    let (false, Some(butt)) = (anatomy.is_board() || anatomy.is_eroded(), rows.first()) else {
        return Vec::new();
    };
    let cambium = anatomy.cambium();
    let edges = anatomy.rings().edges().iter();
    let of_wood = edges.filter(|edge| **edge <= cambium);
    let radii: Vec<f64> = of_wood
        .map(|edge| edge / cambium * wood_radius(butt))
        .collect();
    years_along(&radii, rows.iter().map(wood_radius))
}

/// The greatest of 1, 2 and 5 times a power of ten that is not above `most`, or hardly.
fn round_spacing(most: f64) -> f64 {
    let power = libm::pow(10.0, libm::log10(1.01 * most).floor());
    // A stem of 3.9999 m has the rows of one of 4 m.
    let fits = |factor: &f64| factor * power <= 1.01 * most;
    let factor = [5.0, 2.0, 1.0].into_iter().find(fits).unwrap_or(1.0);
    factor * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_a_round_length_apart() {
        for (most, spacing) in [
            (0.37, 0.2),
            (0.1, 0.1),
            (0.0999, 0.1),
            (0.09, 0.05),
            (7.0, 5.0),
            (0.03, 0.02),
        ] {
            assert!(
                (round_spacing(most) / spacing - 1.0).abs() < 1e-12,
                "{most}"
            );
        }
    }
}
