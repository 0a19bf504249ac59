//! Grain space: the stem straightened, so that every line along the grain is parallel to the third axis.
//!
//! Coordinates are (x, y, s): metres across the stem, in the section of the break, and metres along the axis. Away from
//! the break a section is scaled with the stem's taper, as the grain follows the bark. The grain of sawn wood does not follow its
//! outline: it is not scaled, and runs at a slope to the edges.

use super::Axis;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// The size of a stem at one length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TaperPoint {
    /// Length along the axis, m.
    pub length: f64,
    /// Size of the section relative to the one at the break, above 0.
    pub scale: f64,
}

/// Wavelengths (m) of the waves in which the grain of sawn wood deviates from its mean slope, as logs are never quite straight.
const WAVELENGTHS: [f64; 2] = [0.53, 0.19];
/// Greatest slope of each wave, as a share of the mean slope.
const WAVE_SLOPES: [f64; 2] = [0.7, 0.35];

/// How the grain of sawn wood runs at a slope to its edges (Wood Handbook, chapter 5, "Slope of grain"), with waves about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlopeOfGrain {
    /// Direction across the section in which fibres run out (unit).
    pub direction: DVec2,
    /// Way along it per length, averaged over the stem.
    pub slope: f64,
    /// Length along the axis at which the grain passes through its place in the section, m.
    pub reference: f64,
    /// Decides where the waves are.
    pub seed: u64,
}

impl SlopeOfGrain {
    /// Returns how far (m) a fibre lies at `s` (m) from its place in the section at `reference`.
    pub fn offset(&self, s: f64) -> DVec2 {
        self.direction * (self.way(s) - self.way(self.reference))
    }

    /// Returns the way of a fibre across the stem at `s`, m.
    fn way(&self, s: f64) -> f64 {
        let wave = |(number, (length, share)): (i64, (f64, f64))| {
            let phase = crate::noise::unit(self.seed, number, 0, 0);
            share * length / TAU * libm::sin(TAU * (s / length + phase))
        };
        let waves = WAVELENGTHS.into_iter().zip(WAVE_SLOPES);
        self.slope * (s + (0..).zip(waves).map(wave).sum::<f64>())
    }
}

/// The map between the world and grain space.
#[derive(Debug, Clone, PartialEq)]
pub struct GrainSpace {
    axis: Axis,
    /// Rising in length.
    taper: Vec<TaperPoint>,
    slope: Option<SlopeOfGrain>,
}

impl GrainSpace {
    /// Grain space about `axis`. `taper` must rise in length; an empty one is no taper.
    pub fn new(axis: Axis, taper: Vec<TaperPoint>) -> Self {
        GrainSpace {
            axis,
            taper,
            slope: None,
        }
    }

    /// Returns the space with grain that runs at a slope to the axis.
    pub fn with_slope(self, slope: Option<SlopeOfGrain>) -> Self {
        GrainSpace { slope, ..self }
    }

    /// The axis.
    pub fn axis(&self) -> &Axis {
        &self.axis
    }

    /// Size of the section at `s` (m) relative to the one at the break.
    pub fn scale(&self, s: f64) -> f64 {
        let k = self.taper.partition_point(|p| p.length <= s);
        match (k.checked_sub(1).map(|i| self.taper[i]), self.taper.get(k)) {
            (Some(a), Some(b)) => {
                a.scale + (b.scale - a.scale) * ((s - a.length) / (b.length - a.length))
            }
            (Some(a), None) => a.scale,
            (None, Some(b)) => b.scale,
            (None, None) => 1.0,
        }
    }

    /// Whether the grain runs at a slope to the axis.
    pub fn is_sloped(&self) -> bool {
        self.slope.is_some()
    }

    /// Returns how far (m) the grain at `s` (m) lies beside its place in the section at the break.
    pub fn offset(&self, s: f64) -> DVec2 {
        self.slope.map_or(DVec2::ZERO, |slope| slope.offset(s))
    }

    /// Maps a point of grain space at length `s` (m) to its place (m) in the section across the axis there.
    pub fn to_section(&self, grain: DVec2, s: f64) -> DVec2 {
        grain * self.scale(s) + self.offset(s)
    }

    /// Maps a place (m) in the section across the axis at length `s` (m) to grain space.
    pub fn from_section(&self, place: DVec2, s: f64) -> DVec2 {
        (place - self.offset(s)) / self.scale(s)
    }

    /// Maps grain space (x, y, s) to the world.
    pub fn to_world(&self, p: DVec3) -> DVec3 {
        let f = self.axis.frame(p.z);
        let place = self.to_section(p.truncate(), p.z);
        f.origin + f.x * place.x + f.y * place.y
    }

    /// Maps the world to grain space (x, y, s).
    pub fn to_grain(&self, world: DVec3) -> DVec3 {
        self.in_section(world, self.axis.length_at(world))
    }

    /// [`GrainSpace::to_grain`] for a point whose length along the axis is about `guess` (m).
    pub fn to_grain_near(&self, world: DVec3, guess: f64) -> DVec3 {
        self.in_section(world, self.axis.length_near(world, guess))
    }

    fn in_section(&self, world: DVec3, s: f64) -> DVec3 {
        let f = self.axis.frame(s);
        let k = self.scale(s);
        let d = (world - f.origin) / k;
        (DVec2::new(d.dot(f.x), d.dot(f.y)) - self.offset(s) / k).extend(s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sloping_grain_runs_out_as_it_should_and_inverts() {
        let axis = Axis::new(&[DVec3::ZERO, DVec3::X * 3.0], Some(DVec3::Y));
        let slope = SlopeOfGrain {
            direction: DVec2::new(0.6, 0.8),
            slope: 0.03,
            reference: 1.2,
            seed: 7,
        };
        let straight = GrainSpace::new(axis.expect("two points"), Vec::new());
        let grain = straight.clone().with_slope(Some(slope));
        let fibre = DVec2::new(0.01, -0.02);
        let section = |s: f64| {
            straight
                .to_grain(grain.to_world(fibre.extend(s)))
                .truncate()
        };
        assert!(section(slope.reference).distance(fibre) < 1e-15);
        for k in 0..60 {
            let s = 0.05 * f64::from(k);
            let place = section(s);
            // Across the stem a fibre moves along the direction, by the slope and waves of a few millimetres.
            let moved = place - fibre;
            assert!(moved.perp_dot(slope.direction).abs() < 1e-15);
            let mean = slope.slope * (s - slope.reference);
            let waves = moved.dot(slope.direction) - mean;
            assert!(waves.abs() < 5e-3, "{waves}");
            // It never turns back.
            assert!((section(s + 1e-3) - place).dot(slope.direction) > -2e-6);
            let back = grain.to_grain(grain.to_world(fibre.extend(s)));
            assert!(back.distance(fibre.extend(s)) < 1e-14);
            assert!(grain.from_section(place, s).distance(fibre) < 1e-15);
        }
    }
}
