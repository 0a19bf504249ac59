//! From an address in a stem to a point of it (Forests 2023 §4): continuous, or by the nearest particle as published.
//!
//! Eqs. 2 and 3 take the height of a vertex of the broken face to a layer, k' = ⌊α_map · H⌋, and the vertex of ring i and
//! sector j to the particle P_ijk'. α_map must be layers per length for that; the paper's words make it the inverse.

use super::layers::{ParticleLayer, ParticleLayers};
use super::model::Anatomy;
use super::particles::Particle;
use super::springs::nearest_angle;
use glam::DVec3;

/// Ring coordinate, angle (rad) and length along the centreline (m) of a point in a stem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GrainAddress {
    /// Ring coordinate, 0 at the pith to 1 at the outside.
    pub rho: f64,
    /// Angle about the pith, rad.
    pub angle: f64,
    /// Length along the centreline, m.
    pub along: f64,
}

/// How an address becomes a point.
#[derive(Debug, Clone, Copy)]
pub enum AddressMapping<'a> {
    /// By the section at its length and the ring field there.
    Continuous(&'a Anatomy<'a>),
    /// By the particle of its layer, its ring and its sector: Eqs. 2 and 3.
    Discrete(&'a ParticleLayers),
}

impl AddressMapping<'_> {
    /// The point in the world, m; `None` where there is no section, or no particle in its layer.
    pub fn position(&self, at: &GrainAddress) -> Option<DVec3> {
        match self {
            AddressMapping::Continuous(anatomy) => {
                let section = anatomy.sections().section(at.along)?;
                Some(section.world(section.field.point(at.rho, at.angle)))
            }
            AddressMapping::Discrete(layers) => Some(layers.particle_at(at)?.position),
        }
    }
}

impl ParticleLayers {
    /// The particle of an address: of the layer that holds its length, of the ring whose outer contour is nearest, of the
    /// nearest sector. `None` beyond the layers.
    pub fn particle_at(&self, at: &GrainAddress) -> Option<&Particle> {
        let particles = &self.layer_at(at.along)?.particles;
        let nearer =
            |a: &Particle, b: &Particle| (a.rho - at.rho).abs().total_cmp(&(b.rho - at.rho).abs());
        let ring = particles.iter().min_by(|a, b| nearer(a, b))?.ring;
        let start = particles.partition_point(|p| p.ring < ring);
        let end = particles.partition_point(|p| p.ring <= ring);
        let ring = &particles[start..end];
        ring.get(nearest_angle(ring, at.angle)?)
    }

    /// The layer that holds a length, m: Eq. 2.
    fn layer_at(&self, along: f64) -> Option<&ParticleLayer> {
        let first = self.layers.first()?;
        let number = |layer: &ParticleLayer| layer.particles.first().map(|p| p.layer);
        let layers_per_metre = self.spacing.recip();
        // A layer's section lies in its middle.
        let base = first.section.length - (f64::from(number(first)?) + 0.5) * self.spacing;
        let k = (layers_per_metre * (along - base)).floor();
        let wanted = |layer: &&ParticleLayer| number(layer).is_some_and(|n| f64::from(n) == k);
        self.layers.iter().find(wanted)
    }
}
