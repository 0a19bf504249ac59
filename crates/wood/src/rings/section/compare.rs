//! Rings of a section beside those that were annotated by hand.

use super::curves::{CURVE_POINTS, mean, radii};
use super::rings::{Rings, SectionRings};
use glam::DVec2;
use greenstick_geometry::{Cancelled, Context};
use rayon::prelude::*;
use serde::Serialize;

/// A ring that was annotated by hand, in the section's unit.
#[derive(Debug, Clone, PartialEq)]
pub struct AnnotatedRing {
    /// Its label.
    pub label: String,
    /// Its points; the last is joined to the first.
    pub points: Vec<DVec2>,
}

/// How far one annotated ring is from the model's ring of the same mean radius.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RingComparison {
    /// Its label.
    pub label: String,
    /// Its mean radius about the pith, in the section's unit.
    pub mean_radius: f64,
    /// Root mean square of the radial distances over the mean radius, %.
    pub model_percent: f64,
    /// The same for the outline scaled down.
    pub outline_percent: f64,
    /// The same for a circle about the pith.
    pub circle_percent: f64,
}

impl SectionRings {
    /// Annotated rings, each beside the model's ring of the same mean radius; of an erosion beside what is left after the
    /// pass whose mean radius is nearest.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn compare(
        &self,
        annotated: &[AnnotatedRing],
        context: &Context,
    ) -> Result<Vec<RingComparison>, Cancelled> {
        let pith = self.pith();
        let outline = radii(&self.outline.points, pith);
        let fronts = self.front_radii(context)?;
        annotated
            .iter()
            .map(|ring| {
                context.check()?;
                let real = radii(&ring.points, pith);
                let mean_radius = mean(&real);
                let model = self.model_radii(mean_radius, &fronts);
                Ok(RingComparison {
                    label: ring.label.clone(),
                    mean_radius,
                    model_percent: deviation_percent(&model, &real),
                    outline_percent: deviation_percent(&outline, &real),
                    circle_percent: deviation_percent(&[1.0; CURVE_POINTS], &real),
                })
            })
            .collect()
    }

    /// The radii of what is left after each pass of an erosion, as far as the pith is in it; none of the field.
    fn front_radii(&self, context: &Context) -> Result<Vec<Vec<f64>>, Cancelled> {
        let Rings::Eroded(eroded) = &self.rings else {
            return Ok(Vec::new());
        };
        let all: Vec<Vec<f64>> = (0..eroded.parts.len())
            .into_par_iter()
            .map(|passes| {
                context.check()?;
                Ok(radii(&eroded.contour_after(passes), self.pith()))
            })
            .collect::<Result<_, Cancelled>>()?;
        let surrounds_pith = |radii: &Vec<f64>| radii.iter().all(|r| *r > 0.0);
        Ok(all.into_iter().filter(surrounds_pith).collect())
    }

    /// The radii of the model's ring of a mean radius.
    fn model_radii(&self, mean_radius: f64, fronts: &[Vec<f64>]) -> Vec<f64> {
        if matches!(self.rings, Rings::Eroded(_)) {
            let distance = |radii: &Vec<f64>| (mean(radii) - mean_radius).abs();
            return fronts
                .iter()
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))
                .cloned()
                .unwrap_or_else(|| vec![mean_radius; CURVE_POINTS]);
        }
        let ring = self.field.ring_of_mean_radius(mean_radius);
        let curve = self.field.curve(ring, CURVE_POINTS);
        curve.iter().map(|p| p.distance(self.pith())).collect()
    }
}

/// Root mean square of the distances of a model ring, scaled to the real one's mean, from it; % of that mean.
fn deviation_percent(model: &[f64], real: &[f64]) -> f64 {
    let mean_radius = mean(real);
    let scale = mean_radius / mean(model);
    let squares = model
        .iter()
        .zip(real)
        .map(|(m, r)| (m * scale - r) * (m * scale - r));
    (squares.sum::<f64>() / real.len() as f64).sqrt() / mean_radius * 100.0
}
