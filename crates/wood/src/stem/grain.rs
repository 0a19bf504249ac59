//! Grain space: the stem straightened, so that every line along the grain is parallel to the third axis.
//!
//! Coordinates are (x, y, s): metres across in the section of the break, and metres along the axis. Away from the
//! break a section is scaled with the stem's taper, as the grain follows the bark.

use super::Axis;
use glam::DVec3;

/// The map between the world and grain space.
#[derive(Debug, Clone, PartialEq)]
pub struct GrainSpace {
    axis: Axis,
    /// (length along the axis in m, size of the section relative to the one at the break), rising in length.
    taper: Vec<(f64, f64)>,
}

impl GrainSpace {
    /// Grain space about `axis`. `taper` gives (length in m, relative size > 0) rising in length; empty for none.
    pub fn new(axis: Axis, taper: Vec<(f64, f64)>) -> Self {
        GrainSpace { axis, taper }
    }

    /// The axis.
    pub fn axis(&self) -> &Axis {
        &self.axis
    }

    /// Size of the section at `s` (m) relative to the one at the break.
    pub fn scale(&self, s: f64) -> f64 {
        let k = self.taper.partition_point(|&(l, _)| l <= s);
        match (k.checked_sub(1).map(|i| self.taper[i]), self.taper.get(k)) {
            (Some((a, u)), Some(&(b, v))) => u + (v - u) * ((s - a) / (b - a)),
            (Some((_, u)), None) => u,
            (None, Some(&(_, v))) => v,
            (None, None) => 1.0,
        }
    }

    /// Grain space (x, y, s) to the world.
    pub fn to_world(&self, p: DVec3) -> DVec3 {
        let f = self.axis.frame(p.z);
        let k = self.scale(p.z);
        f.origin + f.x * (k * p.x) + f.y * (k * p.y)
    }

    /// The world to grain space (x, y, s).
    pub fn to_grain(&self, world: DVec3) -> DVec3 {
        self.in_section(world, self.axis.length_at(world))
    }

    /// [`GrainSpace::to_grain`] for a point whose length along the axis is about `guess` (m).
    pub fn to_grain_near(&self, world: DVec3, guess: f64) -> DVec3 {
        self.in_section(world, self.axis.length_near(world, guess))
    }

    fn in_section(&self, world: DVec3, s: f64) -> DVec3 {
        let f = self.axis.frame(s);
        let d = (world - f.origin) / self.scale(s);
        DVec3::new(d.dot(f.x), d.dot(f.y), s)
    }
}
