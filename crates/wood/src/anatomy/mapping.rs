//! From an address in a stem to a point of it (Forests 2023 §4): continuous, or by the nearest particle as published.
//!
//! Eqs. 2 and 3 take the height of a vertex of the broken face to a layer, k' = ⌊α_map · H⌋, and the vertex of ring i and
//! sector j to the particle P_ijk'. α_map must be layers per length for that; the paper's words make it the inverse.

use super::layers::{ParticleLayer, ParticleLayers};
use super::model::Anatomy;
use super::particles::Particle;
use super::springs::nearest_angle;
use glam::DVec3;
use greenstick_geometry::{Cancelled, Column, Context, Table, Values};
use std::f64::consts::TAU;
use std::fmt;

/// Addresses at which the two mappings are compared.
const ADDRESSES: u32 = 10_000;
/// Steps of the lattice that fills a cube evenly: powers of the inverse of the real root of x⁴ = x + 1, which is what the golden
/// ratio is in one dimension (Roberts 2018, *The unreasonable effectiveness of quasirandom sequences*).
const LATTICE: [f64; 3] = [
    0.819_172_513_396_164_4,
    0.671_043_606_703_789_3,
    0.549_700_477_901_970_3,
];

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

/// The two mappings of one address.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MappedAddress {
    /// The address.
    pub address: GrainAddress,
    /// Its point by [`AddressMapping::Continuous`], m.
    pub continuous: DVec3,
    /// Its point by [`AddressMapping::Discrete`], m.
    pub discrete: DVec3,
}

impl MappedAddress {
    /// How far the points are apart, m.
    pub fn distance(&self) -> f64 {
        self.continuous.distance(self.discrete)
    }
}

/// The discrete mapping beside the continuous one.
#[derive(Debug, Clone, PartialEq)]
pub struct MappingComparison {
    /// Addresses that fill the wood between the first and the last layer evenly.
    pub addresses: Vec<MappedAddress>,
}

impl MappingComparison {
    /// Compares the mappings at addresses that fill the wood evenly.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(
        anatomy: &Anatomy,
        layers: &ParticleLayers,
        context: &Context,
    ) -> Result<Self, Cancelled> {
        let (low, high) = anatomy.sections().whole;
        let mut addresses = Vec::with_capacity(ADDRESSES as usize);
        for k in 0..ADDRESSES {
            if k % 256 == 0 {
                context.check()?;
            }
            let [area, turn, along] = LATTICE.map(|step| (f64::from(k) * step + 0.5).fract());
            let address = GrainAddress {
                // As many addresses in equal areas.
                rho: area.sqrt(),
                angle: TAU * turn,
                along: low + (high - low) * along,
            };
            let continuous = AddressMapping::Continuous(anatomy).position(&address);
            let discrete = AddressMapping::Discrete(layers).position(&address);
            let both = continuous.zip(discrete);
            addresses.extend(both.map(|(continuous, discrete)| MappedAddress {
                address,
                continuous,
                discrete,
            }));
        }
        Ok(MappingComparison { addresses })
    }

    /// The addresses as a table.
    pub fn table(&self) -> Table {
        let column = |name: &str, unit: &str, meaning: &str, of: &dyn Fn(&MappedAddress) -> f64| {
            let values = self.addresses.iter().map(of).collect();
            Column::new(name, unit, meaning, Values::F64(values))
        };
        let discrete = "by the particle of its layer, ring and sector";
        let continuous = "by the section at its length";
        Table {
            columns: vec![
                column("rho", "", "ring coordinate", &|m| m.address.rho),
                column("phi", "rad", "angle about the pith", &|m| m.address.angle),
                column("s", "m", "along the stem's axis", &|m| m.address.along),
                column("x", "m", continuous, &|m| m.continuous.x),
                column("y", "m", continuous, &|m| m.continuous.y),
                column("z", "m", continuous, &|m| m.continuous.z),
                column("discrete_x", "m", discrete, &|m| m.discrete.x),
                column("discrete_y", "m", discrete, &|m| m.discrete.y),
                column("discrete_z", "m", discrete, &|m| m.discrete.z),
                column("distance", "m", "between the two points", &|m| m.distance()),
            ],
            ..Table::default()
        }
    }
}

impl fmt::Display for MappingComparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let distances = || self.addresses.iter().map(MappedAddress::distance);
        let count = self.addresses.len();
        let squares: f64 = distances().map(|d| d * d).sum();
        write!(
            f,
            "the discrete mapping (Eqs. 2 and 3 of Forests 2023) is {:.2} mm off the continuous one (root mean square of {count} \
             addresses), at most {:.2} mm",
            1e3 * (squares / count.max(1) as f64).sqrt(),
            1e3 * distances().fold(0.0, f64::max),
        )
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
