//! Cracks measured on a photograph of a sawn end (the statistics that Yang 2019 §5 takes by hand for Fig. 21).
//!
//! The section is unrolled about its pith. Where a pixel is darker than what lies beside it along the ring, there is a
//! crack: rings differ from each other, but hardly along themselves. Runs of dark pixels are followed from ring to ring.
//! The opening along a crack is fitted with that of the model, which is widest in the middle or at the bark, so that its
//! ends are found although its tips are thinner than a pixel.

mod crack;
mod error;
mod fit;
mod groups;
mod section;
mod texture;
mod trace;
mod unrolled;

pub use crack::MeasuredCrack;
pub use error::MeasureError;
pub use groups::CrackStatistics;
pub use section::{PhotographedSection, SectionPhotograph};

use crate::parameters::{
    Crack, CrackEnd, CrackKind, CrackParameters, RadialCrack, TangentialCrack,
};
use serde::Serialize;

/// The cracks of a section.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasuredCracks {
    /// The section they were measured in.
    pub section: PhotographedSection,
    /// The cracks: radial ones by their angle, then those along rings.
    pub cracks: Vec<MeasuredCrack>,
    /// Statistics of the radial ones by size, the largest first.
    pub groups: Vec<CrackStatistics>,
    /// Number of dark lines along the radius that are no cracks: rays, rows of cells, grain or dirt.
    pub texture_lines: usize,
    /// Whether these are longer, taken together, than the cracks: the photograph shows texture, and of the cracks only those
    /// count that open more than any of these lines.
    pub is_texture: bool,
}

/// Cracks along a ring shorter than this are grain and dirt, radii.
const MIN_LENGTH: f64 = 0.05;

/// Measures the cracks of a section in a photograph.
///
/// # Errors
/// [`MeasureError`] where the section is too small or its outline does not go around the pith.
pub fn measure_cracks(
    photograph: &SectionPhotograph,
    section: &PhotographedSection,
) -> Result<MeasuredCracks, MeasureError> {
    let unrolled = unrolled::Unrolled::new(photograph, section)?;
    let mut radial = Vec::new();
    let mut cracks = Vec::new();
    for trace in trace::traces(&unrolled) {
        let Some(crack) = fit::fit(&trace, &unrolled) else {
            continue;
        };
        if !trace.along_ring {
            radial.push((trace, crack));
        } else if crack.length() >= MIN_LENGTH.max(texture::MIN_SLENDERNESS * crack.width) {
            cracks.push(crack);
        }
    }
    let sorted = texture::sort(radial);
    cracks.extend(sorted.cracks);
    let along_ring = |c: &MeasuredCrack| c.kind == CrackKind::Tangential;
    cracks.sort_by(|a, b| {
        along_ring(a)
            .cmp(&along_ring(b))
            .then(a.angle.total_cmp(&b.angle))
    });
    Ok(MeasuredCracks {
        groups: groups::groups(&cracks),
        section: section.clone(),
        cracks,
        texture_lines: sorted.others,
        is_texture: sorted.is_texture,
    })
}

/// A crack that is open at the bark ends there for the model.
const AT_BARK: f64 = 1.0;

impl MeasuredCracks {
    /// Returns parameters that draw each crack where it was measured, opened by the shrinkages along and across the rings.
    /// The depth, which no photograph shows, is that of a crack as deep as it is long.
    pub fn each(&self, shrinkage: (f64, f64)) -> CrackParameters {
        let mut parameters = self.parameters();
        // Of cracks that would cross, the later one is left out.
        let mut cracks: Vec<&MeasuredCrack> = self.cracks.iter().collect();
        cracks.sort_by(|a, b| b.length().total_cmp(&a.length()));
        parameters.cracks = (cracks.iter())
            .map(|c| match c.kind {
                CrackKind::Radial => Crack::Radial(RadialCrack {
                    angle: c.angle,
                    begin: c.begin,
                    end: if c.open_at_bark {
                        AT_BARK
                    } else {
                        c.end.min(0.99)
                    },
                    depth: c.length(),
                    range: (c.opening / shrinkage.0).to_degrees().clamp(0.1, 180.0),
                    shrinkage: None,
                }),
                CrackKind::Tangential => Crack::Tangential(TangentialCrack {
                    ring: c.begin,
                    begin: c.angle,
                    end: c.end,
                    depth: c.length(),
                    range: (c.opening / shrinkage.1).clamp(0.001, 1.0),
                    shrinkage: None,
                }),
            })
            .collect();
        parameters
    }

    /// Returns parameters that draw radial cracks at random with the statistics of the groups, as §5 does.
    pub fn alike(&self, shrinkage: (f64, f64)) -> CrackParameters {
        let mut parameters = self.parameters();
        let s = &mut parameters.settings;
        for (group, statistics) in [&mut s.large, &mut s.medium, &mut s.small]
            .into_iter()
            .zip(&self.groups)
        {
            *group = statistics.parameters(shrinkage.0);
        }
        parameters
    }

    fn parameters(&self) -> CrackParameters {
        let mut parameters = CrackParameters::default();
        parameters.settings.end = CrackEnd::Sawn;
        let wander = self.cracks.iter().map(|c| c.wander * c.wander).sum::<f64>();
        let wander = (wander / self.cracks.len().max(1) as f64).sqrt();
        // Noise of one octave and its halves has about half its amplitude as its root mean square.
        parameters.settings.distortion = (2.0 * wander).min(0.1);
        parameters
    }
}

#[cfg(test)]
mod tests;
