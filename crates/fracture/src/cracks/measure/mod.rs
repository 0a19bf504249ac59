//! Cracks measured on a photograph of a sawn end (the statistics that Yang 2019 §5 takes by hand for Fig. 21).
//!
//! The section is unrolled about its pith. Where a pixel is darker than what lies beside it along the ring, there is a
//! crack: rings differ from each other, but hardly along themselves. Runs of dark pixels are followed from ring to ring.
//! The opening along a crack is fitted with that of the model, which is widest in the middle or at the bark, so that its
//! ends are found although its tips are thinner than a pixel.

mod fit;
mod groups;
mod section;
mod trace;
mod unrolled;

pub use groups::CrackStatistics;
pub use section::{PhotographedSection, SectionPhotograph};

use crate::parameters::{
    Crack, CrackEnd, CrackKind, CrackParameters, RadialCrack, TangentialCrack,
};
use serde::Serialize;

/// Why cracks cannot be measured.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeasureError {
    /// The pixels are not as many as the size says.
    #[error("a photograph of {width} × {height} pixels has {found} values, expected {}", width * height)]
    Size {
        /// Width, pixels.
        width: usize,
        /// Height, pixels.
        height: usize,
        /// Values found.
        found: usize,
    },
    /// The section does not stand out from its background.
    #[error(
        "no section was found in the photograph: {problem}; give its outline, or the pith and a radius around it"
    )]
    NoSection {
        /// What was found instead.
        problem: String,
    },
    /// The outline makes no section.
    #[error(
        "{problem}; expected an outline around the pith ({x:.1}, {y:.1}), within the photograph"
    )]
    Outline {
        /// What is wrong.
        problem: String,
        /// Pith, pixels from the left.
        x: f64,
        /// Pith, pixels from the top.
        y: f64,
    },
    /// The section has too few pixels.
    #[error(
        "the section is {radius:.0} pixels in radius; at least {} are needed for cracks to be seen",
        section::MIN_RADIUS
    )]
    Small {
        /// Mean radius, pixels.
        radius: f64,
    },
}

/// A crack as it was measured. Widths are in radii of the section, as everything but angles.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasuredCrack {
    /// Its kind.
    pub kind: CrackKind,
    /// Direction about the pith, degrees counter-clockwise from the right of the photograph; for a crack along a ring that of
    /// its beginning.
    pub angle: f64,
    /// Ring coordinate at which a radial crack begins; that of a crack along a ring.
    pub begin: f64,
    /// Ring coordinate at which a radial crack ends, 1 where it is open at the bark; for a crack along a ring the direction
    /// of its end, degrees.
    pub end: f64,
    /// Whether a radial crack is widest at the bark, instead of in its middle.
    pub open_at_bark: bool,
    /// Greatest opening along its course.
    pub width: f64,
    /// Opening over the distance from the pith where that is greatest: shrinkage times range of a radial crack (rad); the
    /// greatest opening of a crack along a ring.
    pub opening: f64,
    /// Root mean square distance of a radial crack from a straight line.
    pub wander: f64,
    /// Root mean square difference of its opening from the model's, over the greatest.
    pub residual: f64,
}

/// The cracks of a section.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasuredCracks {
    /// The section they were measured in.
    pub section: PhotographedSection,
    /// The cracks: radial ones by their angle, then those along rings.
    pub cracks: Vec<MeasuredCrack>,
    /// Statistics of the radial ones by size, the largest first.
    pub groups: Vec<CrackStatistics>,
}

/// Cracks shorter than this are grain and dirt, radii.
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
    let mut cracks: Vec<MeasuredCrack> = trace::traces(&unrolled)
        .iter()
        .filter_map(|trace| fit::fit(trace, &unrolled))
        .filter(|crack| crack.length() >= MIN_LENGTH)
        .collect();
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
    })
}

impl MeasuredCrack {
    /// Returns its length, radii.
    pub fn length(&self) -> f64 {
        match self.kind {
            CrackKind::Radial => self.end - self.begin,
            CrackKind::Tangential => {
                (self.end - self.angle).rem_euclid(360.0).to_radians() * self.begin
            }
        }
    }
}

/// A crack that is open at the bark ends there for the model.
const AT_BARK: f64 = 1.0;

impl MeasuredCracks {
    /// Returns parameters that draw each crack where it was measured, opened by the shrinkages along and across the rings.
    /// The depth, which no photograph shows, is that of a crack as deep as it is long.
    pub fn each(&self, shrinkage: (f64, f64)) -> CrackParameters {
        let mut parameters = self.parameters();
        parameters.cracks = (self.cracks.iter())
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
