//! Grain space: the stem straightened, so that every line along the grain is parallel to the third axis.
//!
//! Coordinates are (x, y, s): metres across in the section of the break, and metres along the axis. Away from the
//! break a section is scaled with the stem's taper, as the grain follows the bark.

use super::Axis;
use glam::{DAffine3, DVec2, DVec3};

/// The map between the world and grain space.
#[derive(Debug, Clone, PartialEq)]
pub struct GrainSpace {
    axis: Axis,
    /// (length along the axis in m, size of the section relative to the one at the break), rising in length.
    taper: Vec<(f64, f64)>,
    /// Turn of the grain about the axis, rad per m, and the length (m) at which it is none.
    spiral: (f64, f64),
}

impl GrainSpace {
    /// Grain space about `axis`. `taper` gives (length in m, relative size > 0) rising in length; empty for none.
    pub fn new(axis: Axis, taper: Vec<(f64, f64)>) -> Self {
        GrainSpace {
            axis,
            taper,
            spiral: (0.0, 0.0),
        }
    }

    /// The same with grain that winds about the axis by `turn` rad per m, in its place at length `from` (m).
    pub fn with_spiral(mut self, turn: f64, from: f64) -> Self {
        self.spiral = (turn, from);
        self
    }

    /// Cosine and sine of the grain's turn at `s`.
    fn turn(&self, s: f64) -> DVec2 {
        if self.spiral.0 == 0.0 {
            return DVec2::X;
        }
        let (sin, cos) = libm::sincos(self.spiral.0 * (s - self.spiral.1));
        DVec2::new(cos, sin)
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
        let q = self.turn(p.z).rotate(p.truncate());
        f.origin + f.x * (k * q.x) + f.y * (k * q.y)
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
        let turn = self.turn(s);
        DVec2::new(turn.x, -turn.y)
            .rotate(DVec2::new(d.dot(f.x), d.dot(f.y)))
            .extend(s)
    }
}

/// Grain space in tabulated form, for placing many points: from grain coordinates through the world to any other
/// coordinates.
#[derive(Debug, Clone, Default)]
pub struct Chart {
    low: f64,
    /// Rows per metre.
    scale: f64,
    /// Place of the axis, and what a metre across along either direction amounts to.
    rows: Vec<[DVec3; 3]>,
}

impl Chart {
    /// A table between lengths `range` (m) of the world's place mapped by `map`. Within `radius` m about the axis it is off
    /// by no more than `tolerance` m, as far as a table of some ten thousand rows can be.
    pub fn new(
        space: &GrainSpace,
        map: &DAffine3,
        range: (f64, f64),
        (radius, tolerance): (f64, f64),
    ) -> Self {
        const MOST: usize = 1 << 14;
        let (low, high) = (range.0, range.1.max(range.0 + 1e-9));
        let mut steps = 64;
        loop {
            let step = (high - low) / steps as f64;
            let row = |s: f64| {
                let f = space.axis.frame(s);
                let (k, turn) = (space.scale(s), space.turn(s));
                let x = (f.x * turn.x + f.y * turn.y) * k;
                let y = (f.y * turn.x - f.x * turn.y) * k;
                [
                    map.transform_point3(f.origin),
                    map.transform_vector3(x),
                    map.transform_vector3(y),
                ]
            };
            let rows: Vec<[DVec3; 3]> = (0..=steps).map(|i| row(low + step * i as f64)).collect();
            let off = (0..steps)
                .map(|i| {
                    let middle = row(low + step * (i as f64 + 0.5));
                    let miss =
                        |k: usize| (rows[i][k] + rows[i + 1][k]).distance(middle[k] * 2.0) / 2.0;
                    miss(0) + radius * (miss(1) + miss(2))
                })
                .fold(0.0, f64::max);
            if off <= tolerance || steps >= MOST {
                return Chart {
                    low,
                    scale: 1.0 / step,
                    rows,
                };
            }
            steps *= 2;
        }
    }

    /// The place of the grain coordinates (x, y, s). Beyond the table's ends it runs straight on.
    pub fn place(&self, p: DVec3) -> DVec3 {
        let u = (p.z - self.low) * self.scale;
        let i = (u.max(0.0) as usize).min(self.rows.len().saturating_sub(2));
        let [Some(a), Some(b)] = [self.rows.get(i), self.rows.get(i + 1)] else {
            return p;
        };
        let t = u - i as f64;
        let at = |row: &[DVec3; 3]| row[0] + row[1] * p.x + row[2] * p.y;
        let (a, b) = (at(a), at(b));
        a + (b - a) * t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chart_places_points_as_the_space_does() {
        let points: Vec<DVec3> = (0..30)
            .map(|i| f64::from(i) * 0.05)
            .map(|a| DVec3::new(a.cos(), a.sin(), 0.3 * a))
            .collect();
        let axis = Axis::new(&points, None).unwrap();
        let length = axis.length();
        let taper = vec![(0.0, 1.2), (length / 2.0, 1.0), (length, 0.7)];
        let space = GrainSpace::new(axis, taper).with_spiral(0.8, 0.3);
        let map = DAffine3::from_scale_rotation_translation(
            DVec3::splat(2.0),
            glam::DQuat::from_rotation_x(0.7),
            DVec3::new(1.0, -3.0, 0.2),
        );
        let chart = Chart::new(&space, &map, (0.1, length - 0.1), (0.05, 1e-7));
        for i in 0..500 {
            let s = 0.1 + (length - 0.2) * f64::from(i) / 499.0;
            let (sin, cos) = (f64::from(i) * 1.7).sin_cos();
            let p = DVec3::new(0.05 * cos, 0.05 * sin, s);
            let exact = map.transform_point3(space.to_world(p));
            assert!(chart.place(p).distance(exact) < 2.5e-7);
        }
    }
}
