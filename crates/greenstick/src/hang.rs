//! A piece that hangs on, as that of a green stick does: the break opens on the tension side, and the upper piece
//! turns about the bark of the compression side.
//!
//! The face keeps within a wedge whose edge is that hinge. A turn about the edge by the wedge's angle lays one of its
//! planes on the other, so that the pieces cannot meet, however long their splinters are.

use crate::{Model, Prepared};
use glam::{DAffine3, DVec2, DVec3};
use greenstick_fracture::heights::Wedge;
use greenstick_fracture::parameters::BreakParameters;
use greenstick_geometry::Mesh;
use serde::Serialize;
use std::fmt;

/// Part of the wedge's angle that lies above the section: most strings stand on the lower piece.
const ABOVE: f64 = 0.75;
/// Part of the angle that the face may use. The rest makes up for the bend of the stem, which is not in grain
/// coordinates.
const USED: f64 = 0.94;
/// How far outside of the skin the hinge lies, radii, and how far along the stem, in radii, it keeps clear of the skin.
const OUTSIDE: f64 = 0.02;
const NEAR: f64 = 0.6;
/// How far the piece is lifted off the other before it turns, radii, so that next to the hinge they are not in touch by
/// the rounding of where it lies.
const LIFT: f64 = 0.02;
/// Angle (rad) added where a turn has to be made wider than was asked for.
const CLEARANCE: f64 = 0.01;
/// How far from the hinge the pieces are looked at, in radii beyond the face.
const AROUND: f64 = 3.0;

/// How the upper piece hangs on the lower one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HangReport {
    /// Angle that it turned by, degrees.
    pub angle_degrees: f64,
    /// Least angle at which the pieces are clear of each other, degrees.
    pub clear_degrees: f64,
    /// A point of the hinge, m.
    pub hinge_m: [f64; 3],
    /// Direction of the hinge; the turn is a positive one about it.
    pub axis: [f64; 3],
}

impl fmt::Display for HangReport {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(
            f,
            "upper piece turned by {:.1}° about the compression side's bark (clear from {:.1}° on)",
            self.angle_degrees, self.clear_degrees
        )
    }
}

/// The hinge in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hinge {
    point: DVec3,
    /// Across the stem towards the tension side, along it, and along the hinge (unit).
    toward: DVec3,
    along: DVec3,
    axis: DVec3,
}

impl Prepared {
    /// The wedge that the face keeps within where the upper piece is to hang on.
    pub(crate) fn wedge(&self, p: &BreakParameters) -> Option<Wedge> {
        if p.hang <= 0.0 {
            return None;
        }
        let stem = &self.found.stem;
        let (sin, cos) = libm::sincos(p.ductile.direction.to_radians());
        let toward = DVec2::new(cos, sin);
        let least = (self.found.limb.iter())
            .flat_map(|&t| self.corners[t as usize])
            .map(|point| self.grain[point as usize])
            .filter(|g| (g.z - stem.location).abs() < NEAR * stem.radius)
            .map(|g| g.truncate().dot(toward))
            .fold(f64::INFINITY, f64::min);
        let angle = p.hang.to_radians() * USED;
        let slope = |part: f64| libm::tan((angle * part).min(1.45));
        least.is_finite().then(|| Wedge {
            toward,
            from: least - OUTSIDE * stem.radius,
            slopes: (slope(1.0 - ABOVE), slope(ABOVE)),
        })
    }

    fn hinge(&self, wedge: &Wedge) -> Hinge {
        let stem = &self.found.stem;
        let frame = stem.grain.axis().frame(stem.location);
        let toward = frame.x * wedge.toward.x + frame.y * wedge.toward.y;
        Hinge {
            point: frame.origin + toward * wedge.from + frame.tangent * (0.5 * LIFT * stem.radius),
            toward,
            along: frame.tangent,
            axis: toward.cross(frame.tangent),
        }
    }

    /// The turn of the upper piece of `model`, which was made with `p`: by the angle asked for, or by the least at
    /// which both pieces are clear of each other where that is more.
    pub(crate) fn hang(
        &self,
        model: &Model,
        p: &BreakParameters,
    ) -> Option<(DAffine3, HangReport)> {
        let wedge = self.wedge(p)?;
        let hinge = self.hinge(&wedge);
        let lift = LIFT * self.found.stem.radius;
        let (low, high) = model.heights.range;
        let far = AROUND * self.found.stem.radius + high.max(-low);
        let highest = self
            .angles(&model.lower, &hinge, (0.0, far))
            .fold(f64::NEG_INFINITY, f64::max);
        let lowest = self
            .angles(&model.upper, &hinge, (lift, far))
            .fold(f64::INFINITY, f64::min);
        let clear = highest - lowest;
        let mut angle = p.hang.to_radians();
        if clear.is_finite() && clear > angle {
            angle = clear + CLEARANCE;
        }
        let about = DAffine3::from_translation(hinge.point)
            * DAffine3::from_axis_angle(hinge.axis, angle)
            * DAffine3::from_translation(hinge.along * lift - hinge.point);
        let report = HangReport {
            angle_degrees: angle.to_degrees(),
            clear_degrees: clear.to_degrees(),
            hinge_m: hinge.point.to_array(),
            axis: hinge.axis.to_array(),
        };
        Some((about, report))
    }

    /// Angles (rad, −π/2 down along the stem, 0 across it, π/2 up) about the hinge at which the vertices of a piece lie
    /// that are no farther than `far` (m) from it once the piece is lifted by `lift` (m). A plane at an angle between those of two pieces parts them.
    fn angles(
        &self,
        piece: &Mesh,
        hinge: &Hinge,
        (lift, far): (f64, f64),
    ) -> impl Iterator<Item = f64> {
        let transform = *self.transform();
        piece.positions.iter().filter_map(move |&p| {
            let off = transform.transform_point3(p) - hinge.point;
            let (across, along) = (off.dot(hinge.toward), off.dot(hinge.along) + lift);
            (across.hypot(along) <= far).then(|| libm::atan2(along, across))
        })
    }
}

#[cfg(test)]
mod tests;
