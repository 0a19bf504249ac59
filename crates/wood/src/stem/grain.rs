//! Grain space: the stem straightened, so that every line along the grain is parallel to the third axis.
//!
//! Coordinates are (x, y, s): metres across the stem, in the section of the break, and metres along the axis. Away from
//! the break a section is scaled with the stem's taper, as the grain follows the bark. The grain of sawn wood does not follow its
//! outline, and is not scaled.

use super::Axis;
use glam::DVec3;

/// The size of a stem at one length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TaperPoint {
    /// Length along the axis, m.
    pub length: f64,
    /// Size of the section relative to the one at the break, above 0.
    pub scale: f64,
}

/// The map between the world and grain space.
#[derive(Debug, Clone, PartialEq)]
pub struct GrainSpace {
    axis: Axis,
    /// Rising in length.
    taper: Vec<TaperPoint>,
}

impl GrainSpace {
    /// Grain space about `axis`. `taper` must rise in length; an empty one is no taper.
    pub fn new(axis: Axis, taper: Vec<TaperPoint>) -> Self {
        GrainSpace { axis, taper }
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

    /// Maps grain space (x, y, s) to the world.
    pub fn to_world(&self, p: DVec3) -> DVec3 {
        let f = self.axis.frame(p.z);
        let k = self.scale(p.z);
        f.origin + f.x * (k * p.x) + f.y * (k * p.y)
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
        let d = (world - f.origin) / self.scale(s);
        DVec3::new(d.dot(f.x), d.dot(f.y), s)
    }
}
