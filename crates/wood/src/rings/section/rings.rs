//! The rings of a section, whichever method they come from.

use super::super::Erosion;
use super::super::field::RingField;
use super::super::pith::PITH_OFFSET_RMS;
use super::super::series::RingSeries;
use super::curves::{CURVE_POINTS, RingCurve, mean, radii};
use super::eroded::ErodedSection;
use super::error::SectionRingError;
use super::outline::SectionOutline;
use crate::polygon::area_and_centroid;
use glam::DVec2;
use greenstick_geometry::{Cancelled, Context};

/// Where the rings of a section come from.
#[derive(Debug, Clone, PartialEq)]
pub enum SectionRingMethod {
    /// The ring field, at the given rings.
    Field(RingSeries),
    /// Erosion of a bitmap.
    Erosion {
        /// Its schedule and inner circle.
        erosion: Erosion,
        /// Pixels along each side of the bitmap.
        resolution: usize,
    },
}

/// A section with its rings.
///
/// ```
/// use glam::DVec2;
/// use greenstick_geometry::Context;
/// use greenstick_wood::rings::{RingSeries, SectionOutline, SectionRingMethod, SectionRings};
/// use std::f64::consts::TAU;
///
/// let points = (0..90).map(|i| DVec2::from_angle(f64::from(i) * TAU / 90.0) * 40.0);
/// let outline = SectionOutline {
///     points: points.collect(),
///     pith: Some(DVec2::new(6.0, 0.0)),
///     y_up: false,
///     eccentricity_onset: None,
/// };
/// let method = SectionRingMethod::Field(RingSeries::Number(10));
/// let rings = SectionRings::new(outline, &method, &Context::quiet())?;
/// let curves = rings.curves(&Context::quiet())?;
/// assert_eq!(curves.len(), 10);
/// assert!(curves[4].mean_radius < curves[5].mean_radius);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SectionRings {
    pub(super) outline: SectionOutline,
    pub(super) field: RingField,
    pub(super) rings: Rings,
}

/// The rings of one method.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Rings {
    /// Ring coordinates, from the pith outwards.
    Field(Vec<f64>),
    Eroded(ErodedSection),
}

impl SectionRings {
    /// The rings of a section about its pith, which is estimated from the outline where it is not known. An erosion takes
    /// no notice of it but for an inner circle.
    ///
    /// # Errors
    /// [`SectionRingError`] where the rings do not fit into the outline, or no pass takes anything off.
    pub fn new(
        outline: SectionOutline,
        method: &SectionRingMethod,
        context: &Context,
    ) -> Result<Self, SectionRingError> {
        let field = outline.field()?;
        context.check()?;
        let rings = match method {
            SectionRingMethod::Field(series) => Rings::Field(field.coordinates(series)?),
            SectionRingMethod::Erosion {
                erosion,
                resolution,
            } => Rings::Eroded(ErodedSection::new(
                &outline,
                &field,
                erosion,
                *resolution,
                context,
            )?),
        };
        Ok(SectionRings {
            outline,
            field,
            rings,
        })
    }

    /// The section's outline.
    pub fn outline(&self) -> &SectionOutline {
        &self.outline
    }

    /// The pith.
    pub fn pith(&self) -> DVec2 {
        self.field.pith()
    }

    /// Whether the pith was estimated from the outline.
    pub fn is_pith_estimated(&self) -> bool {
        self.outline.pith.is_none()
    }

    /// Root mean square distance of the true pith from the one taken, in the section's unit; 0 where it was given.
    pub fn pith_uncertainty(&self) -> f64 {
        if !self.is_pith_estimated() {
            return 0.0;
        }
        let (area, _) = area_and_centroid(&self.outline.points);
        PITH_OFFSET_RMS * (area.abs() / std::f64::consts::PI).sqrt()
    }

    /// Mean radius of the outline about the pith.
    pub fn outline_mean_radius(&self) -> f64 {
        self.field.mean_radius(1.0)
    }

    /// Number of rings.
    pub fn ring_count(&self) -> usize {
        match &self.rings {
            Rings::Field(coordinates) => coordinates.len(),
            Rings::Eroded(eroded) => eroded.contours.len(),
        }
    }

    /// Number of passes of an erosion; none of the field.
    pub fn pass_count(&self) -> Option<usize> {
        match &self.rings {
            Rings::Field(_) => None,
            Rings::Eroded(eroded) => Some(eroded.parts.len()),
        }
    }

    /// The outer contours of the rings, from the pith outwards.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn curves(&self, context: &Context) -> Result<Vec<RingCurve>, Cancelled> {
        match &self.rings {
            Rings::Field(coordinates) => coordinates
                .iter()
                .map(|&ring| {
                    context.check()?;
                    Ok(RingCurve {
                        mean_radius: self.field.mean_radius(ring),
                        points: self.field.curve(ring, CURVE_POINTS),
                    })
                })
                .collect(),
            Rings::Eroded(eroded) => eroded
                .contours
                .iter()
                .map(|contour| {
                    context.check()?;
                    Ok(RingCurve {
                        mean_radius: mean(&radii(contour, self.pith())),
                        points: contour.clone(),
                    })
                })
                .collect(),
        }
    }
}
