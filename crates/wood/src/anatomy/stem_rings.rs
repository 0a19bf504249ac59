//! The annual rings that a stem shows wherever it breaks, the same that [`super::Anatomy`] has there.

use super::error::AnatomyError;
use super::limits::RESOLUTION_RANGE;
use super::model::{Anatomy, AnatomyOptions, RingMethod};
use super::palette::RingColouring;
use super::parameters::RingParameters;
use super::section_raster::SectionRaster;
use crate::appearance::WoodAppearance;
use crate::rings::{RingDivision, RingSeriesParameters, StemRings};
use crate::stem::FoundStem;
use crate::tissue::Proportions;
use greenstick_geometry::{Context, Mesh};
use greenstick_schema::{count, parameters};
use std::borrow::Cow;

parameters! {
    /// The annual rings of a stem that is broken or simulated.
    pub struct BreakRingParameters {
        "Annual rings", "layout" {
            /// Annual rings of even width; "auto" makes as many as usual, of widths that differ from year to year. An erosion
            /// makes its own.
            annual_rings: Option<u16> = None, count(1, 1000).auto();
            /// Pixels along each side of the section in which rings are eroded.
            ring_resolution: usize = 128, count(*RESOLUTION_RANGE.start() as i128, *RESOLUTION_RANGE.end() as i128);
        }
    }
    include {
        /// Rings that were measured.
        series: RingSeriesParameters = RingSeriesParameters::default();
        /// Where rings come from.
        ring_source: RingParameters = RingParameters::default();
    }
    check |p| {
        p.ring_source
            .check_alone(p.annual_rings.map(|_| "annual_rings"), &p.series)
    };
}

/// How the years divide a radius: by a series, a number of even rings, or else as many as the wood usually has.
pub(super) fn ring_division(
    count: Option<u16>,
    series: &RingSeriesParameters,
    wood: &WoodAppearance,
) -> RingDivision {
    match (series.series(), count) {
        (Some(series), _) => RingDivision::Series(series),
        (None, Some(count)) => RingDivision::Even(count),
        (None, None) => RingDivision::Grown {
            count: wood.rings.round() as u16,
            seed: wood.seed,
        },
    }
}

impl BreakRingParameters {
    /// The rings of a stem found in `mesh`, which is in world metres, at its location. `wood` gives their usual number and
    /// the seed of their widths.
    ///
    /// # Errors
    /// [`AnatomyError`] where they do not fit the section, or cannot be made.
    pub fn rings(
        &self,
        found: &FoundStem,
        mesh: impl FnOnce() -> Mesh,
        (wood, proportions): (&WoodAppearance, Proportions),
        context: &Context,
    ) -> Result<StemRings, AnatomyError> {
        let division = ring_division(self.annual_rings, &self.series, wood);
        let RingMethod::Erosion(erosion) = self.ring_source.method() else {
            let board = found.stem.kind.is_sawn();
            let rings = division.rings(&found.stem.rings, &proportions, board)?;
            return Ok(StemRings::new(rings));
        };
        let options = AnatomyOptions {
            resolution: self.ring_resolution,
            rings: RingMethod::Erosion(erosion),
            division,
            colouring: RingColouring::Wood,
            proportions,
            smoothing: None,
        };
        let mesh = mesh();
        let anatomy = Anatomy::new(found, &mesh, &options, wood.clone(), context)?;
        let section = anatomy.sections().section(found.stem.location);
        let section = section.ok_or(AnatomyError::NoSections(1))?;
        let raster = anatomy.rasterize(&section, &anatomy.sections().grid, context)?;
        Ok(StemRings::new(SectionRaster {
            legend: Cow::Owned(raster.legend.into_owned()),
            palette: Cow::Owned(raster.palette.into_owned()),
            ..raster
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick_schema::Parameters;

    #[test]
    fn rings_are_asked_for_in_one_way() {
        let checked = |settings: &[(&str, &str)]| {
            let mut parameters = BreakRingParameters::default();
            for (key, value) in settings {
                parameters.set_text(key, value).unwrap();
            }
            parameters.check().map_err(|e| e.to_string())
        };
        let widths = ("ring_widths", "1 mm, 2 mm");
        assert!(checked(&[widths]).is_ok() && checked(&[("annual_rings", "5")]).is_ok());
        for settings in [
            [widths, ("annual_rings", "5")],
            [widths, ("ring_shares", "0.5")],
            [widths, ("rings_by", "erosion")],
            [("annual_rings", "5"), ("rings_by", "erosion")],
        ] {
            let refused = checked(&settings).unwrap_err();
            assert!(refused.contains("expected"), "{settings:?}: {refused}");
        }
    }
}
