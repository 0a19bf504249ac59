//! The end of a stem as a plane across the grain.

use super::error::CrackError;
use glam::{DVec2, DVec3};

/// An end of a stem, as a plane across the grain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndFace {
    /// Whether it is the far end (greater lengths).
    pub far: bool,
    /// Length along the axis (m) over the origin of the section.
    pub height: f64,
    /// Rise of the plane along x and y.
    pub slope: DVec2,
    /// Distance (m) beyond the plane at which there is no wood.
    pub clearance: f64,
}

/// Cosine to the grain above which a triangle of the skin may be end face.
const FACING: f64 = 0.5;
/// How far from the farthest point (in radii) end face may lie.
const END_ZONE: f64 = 1.5;
/// Clearance beside what the end's roughness needs, in radii.
const CLEAR: f64 = 0.01;

impl EndFace {
    /// An end, the far one or the near one, sawn straight at a length along the axis, m.
    pub fn level(far: bool, height: f64) -> Self {
        EndFace {
            far,
            height,
            slope: DVec2::ZERO,
            clearance: 0.0,
        }
    }

    /// The plane nearest to the skin's triangles that face the end (`corners` are point numbers of the triangles in
    /// `limb`, `points` grain coordinates, `radius` the stem's, m).
    ///
    /// # Errors
    /// [`CrackError::NoEnd`] where nothing faces the end.
    pub fn fit(
        corners: &[[u32; 3]],
        limb: &[u32],
        points: &[DVec3],
        far: bool,
        radius: f64,
    ) -> Result<Self, CrackError> {
        let sign = if far { 1.0 } else { -1.0 };
        let triangles = || {
            limb.iter()
                .map(|&t| corners[t as usize].map(|p| points[p as usize]))
        };
        let outmost = triangles()
            .flatten()
            .map(|p| sign * p.z)
            .fold(f64::NEG_INFINITY, f64::max);
        let mut facing: Vec<(DVec3, f64)> = Vec::new();
        for [a, b, c] in triangles() {
            let normal = (b - a).cross(c - a);
            let near = [a, b, c]
                .iter()
                .all(|p| sign * p.z > outmost - END_ZONE * radius);
            if near && sign * normal.z > FACING * normal.length() {
                // Midpoints of the sides integrate a square exactly.
                facing.extend(
                    [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0].map(|m| (m, normal.z.abs())),
                );
            }
        }
        let found = facing.len() / 3;
        let none = CrackError::NoEnd {
            which: if far { "far" } else { "near" },
            found,
        };
        let total: f64 = facing.iter().map(|f| f.1).sum();
        if total <= 0.0 {
            return Err(none);
        }
        let mean = facing.iter().map(|f| f.0 * f.1).sum::<DVec3>() / total;
        let (mut xx, mut xy, mut yy, mut xz, mut yz) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (p, w) in &facing {
            let d = *p - mean;
            xx += w * d.x * d.x;
            xy += w * d.x * d.y;
            yy += w * d.y * d.y;
            xz += w * d.x * d.z;
            yz += w * d.y * d.z;
        }
        let det = xx * yy - xy * xy;
        if det <= 1e-12 * (xx + yy) * (xx + yy) {
            return Err(none);
        }
        let slope = DVec2::new(xz * yy - yz * xy, yz * xx - xz * xy) / det;
        let height = mean.z - slope.dot(mean.truncate());
        let over = triangles()
            .flatten()
            .map(|p| sign * (p.z - height - slope.dot(p.truncate())))
            .fold(0.0, f64::max);
        Ok(EndFace {
            far,
            height,
            slope,
            clearance: over + CLEAR * radius,
        })
    }

    /// Length along the axis (m) of the plane at a point of the section.
    pub fn at(&self, p: DVec2) -> f64 {
        self.height + self.slope.dot(p)
    }
}
