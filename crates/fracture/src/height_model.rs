//! The published model of heights (Yang 2019 §3): inclination, layers, noise and thorns at one place of the section.
//!
//! All heights are ratios to the stem's radius.

use crate::parameters::{BreakParameters, Sector, ZoneParameters};
use crate::surface::FractureSurface;
use crate::wedge::Wedge;
use glam::DVec2;
use greenstick_wood::noise;
use greenstick_wood::tissue::Zone;

/// Seeds of independent random numbers.
pub(crate) mod purpose {
    pub const PERLIN: u64 = 0x9e11;
    pub const WHITE: u64 = 0x3417e;
    pub const THORN: u64 = 0x7402;
    pub const ZONE_THORN: u64 = 0x7403;
    pub const LENGTH: u64 = 0x1e46;
    pub const SHAFT: u64 = 0x54af;
    pub const SLIVER: u64 = 0x511f;
    pub const GROUP: u64 = 0x6409;
    pub const FORK: u64 = 0xf042;
    pub const ROUGH: u64 = 0x4056;
    pub const FIBRE: u64 = 0xf1b3;
    pub const STEP: u64 = 0x57e9;
    pub const BARK: u64 = 0xba4c;
    pub const BARK_SLANT: u64 = 0xba51;
    pub const SHELF: u64 = 0x54e1;
    pub const WANDER: u64 = 0x3a4d;
    pub const PLATE: u64 = 0x71a7;
    pub const SHARD: u64 = 0x54a7;
}

/// The stem that heights are made for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BreakSite {
    /// Radius of the stem at the break, m.
    pub radius: f64,
    /// Length along the axis of the break, m.
    pub place: f64,
    /// Lengths along the axis that the surface must keep within, m.
    pub usable: (f64, f64),
    /// Pith of the section, m from the axis; it may lie outside of it.
    pub pith: DVec2,
    /// The wedge that the face keeps within, where a piece is to hang on.
    pub wedge: Option<Wedge>,
    /// Factor on the relief (not on inclination, layers or thorns of given length) that a species calls for.
    pub relief: f64,
}

/// A surface with what had to be done to fit it into the stem.
#[derive(Debug, Clone)]
pub struct Heights {
    /// The surface.
    pub surface: FractureSurface,
    /// How many facet corners are higher or lower than in proportion to the rest, so that they do not leave the stem.
    pub limited: usize,
    /// Factors on heights below and above the place, under 1 where those as drawn had no room.
    pub scales: (f64, f64),
    /// How far the face was moved up along the stem to have more room, m.
    pub moved: f64,
    /// Lowest and highest height before limiting, m from the place of the break.
    pub wanted: (f64, f64),
    /// Lowest and highest height as it is, m from the place of the break.
    pub range: (f64, f64),
    /// Thorns on the face.
    pub thorns: Vec<Thorn>,
}

/// A bundle that stands out as a thorn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thorn {
    /// Its bundle.
    pub bundle: u32,
    /// Height over the bundle's own, m.
    pub length: f64,
}

/// Everything a height is worked out from.
pub(crate) struct HeightModel<'a> {
    pub p: &'a BreakParameters,
    pub site: &'a BreakSite,
    /// Unit direction of the tension side.
    pub tension: DVec2,
    /// Slope of the face.
    pub tilt: DVec2,
    pub noise_radius: f64,
    high: Sector,
    low: Sector,
    ductile: Sector,
}

/// Noise of a surface at one place after another.
pub(crate) struct NoiseSamplers {
    /// Perlin noise, by octave.
    octaves: Vec<noise::GradientNoise2d>,
    /// What rays wander by.
    pub wander: noise::GradientNoise2d,
    /// How ragged the edge of the compression shelf is.
    pub shelf: noise::GradientNoise2d,
}

impl NoiseSamplers {
    pub fn new(maker: &HeightModel) -> Self {
        let p = maker.p;
        let zones = [&p.pith, &p.heartwood, &p.sapwood, &p.phloem, &p.bark];
        let most = zones.iter().map(|z| z.perlin_octaves).max().unwrap_or(0);
        let seed = maker.seed(purpose::PERLIN);
        NoiseSamplers {
            octaves: (0..most)
                .map(|octave| noise::GradientNoise2d::new(seed + u64::from(octave)))
                .collect(),
            wander: noise::GradientNoise2d::new(maker.seed(purpose::WANDER)),
            shelf: noise::GradientNoise2d::new(maker.seed(purpose::SHELF)),
        }
    }
}

pub(crate) fn unit(rho: f64, phi: f64) -> DVec2 {
    let (sin, cos) = libm::sincos(phi);
    DVec2::new(cos, sin) * rho
}

impl<'a> HeightModel<'a> {
    pub fn new(p: &'a BreakParameters, site: &'a BreakSite) -> Self {
        let direction = |degrees: f64| unit(1.0, degrees.to_radians());
        // A plane along the grain has no height over the section; what is past the stem is limited later.
        let steepness = libm::tan(p.inclination.min(89.5).to_radians());
        HeightModel {
            p,
            site,
            tension: direction(p.ductile.direction),
            tilt: direction(p.inclination_direction) * steepness,
            noise_radius: p.noise_diameter(2.0 * site.radius) / 2.0,
            high: p.high.sector(),
            low: p.low.sector(),
            ductile: p.ductile.sector(),
        }
    }

    pub fn seed(&self, purpose: u64) -> u64 {
        self.p.seed ^ purpose << 20
    }

    /// Inclination and layers at a place `across` (radii) of the pith, whose ring coordinate is `rho`.
    pub fn stepped(&self, across: DVec2, rho: f64, phi: f64) -> f64 {
        across.dot(self.tilt) + self.layers(rho, phi)
    }

    /// [`HeightModel::stepped`] where the layers tear off along the grain: near their borders wood stands at heights between, and a
    /// layer runs out into the next with a rounded root. `off` moves the borders inwards, and `root` is the distance from them over
    /// which layers run out, radii.
    pub fn stepped_torn(
        &self,
        across: DVec2,
        (rho, phi): (f64, f64),
        (off, root): (f64, f64),
    ) -> f64 {
        let degrees = phi.to_degrees();
        let share = |sector: &Sector| {
            let place = (sector.depth(degrees, rho) - off) / root;
            0.5 + 0.5 * place / (1.0 + place * place).sqrt()
        };
        let mut height = across.dot(self.tilt);
        for (layer, sector) in [
            (self.p.high.height, &self.high),
            (self.p.low.height, &self.low),
        ] {
            if layer != 0.0 && sector.angle > 0.0 && sector.rings > 0.0 {
                height += layer * share(sector);
            }
        }
        height
    }

    fn layers(&self, rho: f64, phi: f64) -> f64 {
        let degrees = phi.to_degrees();
        let mut height = 0.0;
        if self.high.contains(degrees, rho) {
            height += self.p.high.height;
        }
        if self.low.contains(degrees, rho) {
            height += self.p.low.height;
        }
        height
    }

    /// Perlin and white noise: Eqs. 1 to 5. `unit` is in ring coordinates.
    pub fn noise(
        &self,
        walks: &mut NoiseSamplers,
        unit: DVec2,
        zone: &ZoneParameters,
        key: i64,
    ) -> f64 {
        let (mut amplitude, mut frequency) = (zone.perlin_amplitude, zone.perlin_frequency);
        let mut height = 0.0;
        if amplitude > 0.0 {
            for octave in walks.octaves.iter_mut().take(zone.perlin_octaves as usize) {
                let n = octave.at(unit * (self.noise_radius * frequency));
                height += amplitude * (0.5 + 0.5 * n).clamp(0.0, 1.0);
                (amplitude, frequency) = (amplitude / 2.0, frequency * 2.0);
            }
        }
        let mut white = zone.white_noise_amplitude;
        if white > 0.0 {
            for octave in 0..zone.white_noise_octaves {
                height += white * noise::unit(self.seed(purpose::WHITE), key, i64::from(octave), 0);
                white /= 2.0;
            }
        }
        height
    }

    /// [`HeightModel::noise`] about its mean. Eq. 1 lifts a tissue by half its amplitude on average: with the amplitudes of
    /// Fig. 18, 1 in the wood and 0.05 in the phloem, the bark would be a smooth collar about a deep disc of spines.
    pub fn noise_about_mean(
        &self,
        walks: &mut NoiseSamplers,
        unit: DVec2,
        zone: &ZoneParameters,
        key: i64,
    ) -> f64 {
        let sum = |amplitude: f64, octaves: u32| {
            (0..octaves).fold(0.0, |sum, k| sum + amplitude / f64::from(1u32 << k))
        };
        let most = sum(zone.perlin_amplitude, zone.perlin_octaves)
            + sum(zone.white_noise_amplitude, zone.white_noise_octaves);
        self.noise(walks, unit, zone, key) - 0.5 * most
    }

    /// Whether a thorn can stand anywhere.
    pub fn has_thorns(&self) -> bool {
        let p = self.p;
        let zones = [&p.pith, &p.heartwood, &p.sapwood, &p.phloem, &p.bark];
        let zones = zones.map(|z| (z.thorn_length, z.thorn_probability));
        [
            (p.ductile.thorn_length, p.ductile.thorn_probability),
            (p.brittle.thorn_length, p.brittle.thorn_probability),
        ]
        .iter()
        .chain(&zones)
        .any(|&(length, probability)| length > 0.0 && probability > 0.0)
    }

    /// Length of the thorn at a place, 0 for none: Eq. 8 with P the probability of a thorn. `draw` draws it by its purpose,
    /// the greatest length and the probability.
    pub fn thorn(
        &self,
        rho: f64,
        phi: f64,
        zone: Zone,
        draw: impl Fn(u64, f64, f64) -> f64,
    ) -> f64 {
        let (length, probability) = if self.ductile.contains(phi.to_degrees(), rho) {
            (
                self.p.ductile.thorn_length,
                self.p.ductile.thorn_probability,
            )
        } else {
            (
                self.p.brittle.thorn_length,
                self.p.brittle.thorn_probability,
            )
        };
        let tissue = self.p.zone(zone);
        draw(purpose::THORN, length, probability).max(draw(
            purpose::ZONE_THORN,
            tissue.thorn_length,
            tissue.thorn_probability,
        ))
    }

    pub fn drawn_thorn(&self, key: i64, purpose: u64, length: f64, probability: f64) -> f64 {
        if noise::unit(self.seed(purpose), key, 0, 0) < probability {
            length * noise::unit(self.seed(purpose::LENGTH), key, purpose as i64, 0)
        } else {
            0.0
        }
    }
}
