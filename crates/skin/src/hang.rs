//! A piece that hangs on, as in a greenstick fracture: the break opens on the tension side, and the upper piece turns
//! about the bark of the compression side.
//!
//! The face stays within a wedge whose edge is that hinge. A turn about the edge by the wedge's angle lays one of its
//! planes on the other, so the pieces cannot meet, however long their splinters are.

use crate::prepared::PreparedStem;
use glam::{DAffine3, DVec2, DVec3};
use greenstick_fracture::heights::Wedge;
use greenstick_fracture::parameters::BreakParameters;
use greenstick_geometry::Mesh;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Part of the wedge's angle that lies above the section: most strings stand on the lower piece.
const SHARE_ABOVE: f64 = 0.75;
/// Part of the angle that the face may use. The rest makes up for the bend of the stem, which grain coordinates leave
/// out.
const USED_SHARE: f64 = 0.94;
/// Distance of the hinge from the skin, radii.
const OUTSIDE: f64 = 0.02;
/// Length of stem on either side of the break, in radii, whose skin the hinge keeps clear of.
const SKIN_NEAR: f64 = 0.6;
/// How far the piece is lifted off the other before it turns, radii, so that rounding does not make them touch at the
/// hinge.
const LIFT: f64 = 0.02;
/// Angle (rad) added where a turn must be wider than requested.
const CLEARANCE: f64 = 0.01;
/// Distance from the hinge, in radii beyond the face, within which the pieces are compared.
const COMPARED_REACH: f64 = 3.0;

/// How the upper piece hangs on the lower one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
struct Hinge {
    point: DVec3,
    /// Across the stem towards the tension side, along it, and along the hinge (unit).
    toward: DVec3,
    along: DVec3,
    axis: DVec3,
}

/// The wedge that the face stays within where the upper piece is to hang on.
pub(crate) fn wedge(stem: &PreparedStem, p: &BreakParameters) -> Option<Wedge> {
    if p.hang <= 0.0 {
        return None;
    }
    let radius = stem.found.stem.radius;
    let (sin, cos) = libm::sincos(p.ductile.direction.to_radians());
    let toward = DVec2::new(cos, sin);
    let least = stem.least_along(toward, SKIN_NEAR * radius);
    let angle = p.hang.to_radians() * USED_SHARE;
    let slope = |part: f64| libm::tan((angle * part).min(1.45));
    least.is_finite().then(|| Wedge {
        toward,
        from: least - OUTSIDE * radius,
        slopes: (slope(1.0 - SHARE_ABOVE), slope(SHARE_ABOVE)),
    })
}

/// The turn of the upper piece of a break made with `p`: by the requested angle, or by the least at which both pieces are
/// clear of each other where that is more. `pieces` are the lower and the upper one, `range` is that of the face's heights
/// (m). `None` where the piece is not to hang.
pub fn hang(
    stem: &PreparedStem,
    p: &BreakParameters,
    pieces: [&Mesh; 2],
    range: (f64, f64),
) -> Option<(DAffine3, HangReport)> {
    let hinge = Hinge::new(stem, &wedge(stem, p)?);
    let radius = stem.found.stem.radius;
    let lift = LIFT * radius;
    let (low, high) = range;
    let far = COMPARED_REACH * radius + high.max(-low);
    let [lower, upper] = pieces;
    let transform = stem.transform();
    let highest = (hinge.angles(lower, transform, 0.0, far)).fold(f64::NEG_INFINITY, f64::max);
    let lowest = (hinge.angles(upper, transform, lift, far)).fold(f64::INFINITY, f64::min);
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

impl Hinge {
    /// The edge of a wedge.
    fn new(stem: &PreparedStem, wedge: &Wedge) -> Hinge {
        let stem = &stem.found.stem;
        let frame = stem.grain.axis().frame(stem.location);
        let toward = frame.x * wedge.toward.x + frame.y * wedge.toward.y;
        Hinge {
            point: frame.origin + toward * wedge.from + frame.tangent * (0.5 * LIFT * stem.radius),
            toward,
            along: frame.tangent,
            axis: toward.cross(frame.tangent),
        }
    }

    /// Angles (rad; −π/2 down along the stem, 0 across it, π/2 up) about the hinge of the vertices of a piece that are no
    /// farther than `far` (m) from it once the piece is lifted by `lift` (m). A plane at an angle between those of two
    /// pieces separates them.
    fn angles<'a>(
        &'a self,
        piece: &'a Mesh,
        transform: &'a DAffine3,
        lift: f64,
        far: f64,
    ) -> impl Iterator<Item = f64> + 'a {
        piece.positions.iter().filter_map(move |&p| {
            let off = transform.transform_point3(p) - self.point;
            let (across, along) = (off.dot(self.toward), off.dot(self.along) + lift);
            (across.hypot(along) <= far).then(|| libm::atan2(along, across))
        })
    }
}
