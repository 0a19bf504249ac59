//! Measures of a section and of its rings.

use super::model::Anatomy;
use super::particles::Particle;
use super::sections::TransverseSection;
use crate::stem::Frame;
use crate::tissue::Zone;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Directions over which a ring's radius is averaged.
const DIRECTIONS: usize = 72;

/// Sizes of a section's rings, each from the pith outwards.
#[derive(Debug, Clone, PartialEq)]
pub struct RingMeasures {
    /// Mean distance of each ring's outer contour from the pith, m; of eroded rings the radius of the circle of equal area.
    pub radii: Vec<f64>,
    /// Mean widths, m.
    pub widths: Vec<f64>,
    /// Areas within the section, m²: those of the rings' particles.
    pub areas: Vec<f64>,
    /// Tissues.
    pub tissues: Vec<Zone>,
}

/// Measures of a section.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionMeasures {
    /// Length along the centreline, m.
    pub length: f64,
    /// Its frame.
    pub frame: Frame,
    /// The pith in the world, m.
    pub pith: DVec3,
    /// Area, m².
    pub area: f64,
    /// Girth, m.
    pub girth: f64,
    /// Part of the girth that was bridged across holes of the mesh, 0 to 1.
    pub bridged: f64,
    /// Root mean square distance by which the outline was smoothed, m.
    pub smoothing_residual: f64,
    /// Its rings.
    pub rings: RingMeasures,
}

impl Anatomy<'_> {
    /// Measures a section, given its particles.
    pub(super) fn measure(
        &self,
        section: &TransverseSection,
        particles: &[Particle],
    ) -> SectionMeasures {
        SectionMeasures {
            length: section.length,
            frame: section.frame,
            pith: section.world(section.field.pith()),
            area: section.outline.area,
            girth: section.outline.girth,
            bridged: section.outline.bridged,
            smoothing_residual: section.outline.smoothing_residual,
            rings: self.measure_rings(section, particles),
        }
    }

    fn measure_rings(&self, section: &TransverseSection, particles: &[Particle]) -> RingMeasures {
        let rings = self.ring_count();
        let mut areas = vec![0.0; rings.into()];
        let mut tissues = self.rings().tissues().to_vec();
        for p in particles {
            let ring = usize::from(p.ring) - 1;
            areas[ring] += p.area;
            tissues[ring] = p.tissue;
        }
        let radii: Vec<f64> = if self.is_eroded() {
            let mut sum = 0.0;
            let equal_circles = areas.iter().map(|area| {
                sum += area;
                (sum / PI).sqrt()
            });
            std::iter::once(0.0).chain(equal_circles).collect()
        } else {
            let edges = &self.rings().edges()[..rings.into()];
            std::iter::once(&0.0)
                .chain(edges)
                .map(|&rho| mean_radius(section, rho))
                .collect()
        };
        RingMeasures {
            widths: radii.windows(2).map(|w| w[1] - w[0]).collect(),
            radii: radii[1..].to_vec(),
            areas,
            tissues,
        }
    }
}

/// Mean distance from the pith of the curve at a ring coordinate, m.
fn mean_radius(section: &TransverseSection, rho: f64) -> f64 {
    let pith = section.field.pith();
    let sum: f64 = (0..DIRECTIONS)
        .map(|j| TAU * j as f64 / DIRECTIONS as f64)
        .map(|angle| section.field.point(rho, angle).distance(pith))
        .sum();
    sum / DIRECTIONS as f64
}
