//! The camera: a long lens, positioned automatically or by the caller.

use crate::error::PictureError;
use glam::{DVec3, dvec3};

/// The direction from which the scene is seen.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum View {
    /// A three-quarter view of the longest horizontal extent, from slightly above.
    #[default]
    Automatic,
    /// A given direction.
    Direction {
        /// Angle about the upward direction, rad. At 0 the camera is at +Z if +Y points up, and at −Y if +Z points up.
        azimuth: f64,
        /// Angle above the horizon, rad, −π/2 to π/2.
        elevation: f64,
    },
}

/// Vertical field of view, rad (25°): that of a short telephoto lens, without the perspective distortion of a wide one.
const FIELD_OF_VIEW: f64 = 0.436_332;
/// Fraction of the width and height of the picture that a fitted scene fills.
const FILL_FRACTION: f64 = 0.88;
/// A camera whose direction is nearer than this to the vertical (sine of the angle) looks straight up or down: what is to its right
/// would be rounding.
const STRAIGHT: f64 = 1e-9;
/// Elevation of the automatic view, rad (17°).
const AUTOMATIC_ELEVATION: f64 = 0.3;
/// Angle of the automatic view from perpendicular to the longest extent, rad (28°).
const AUTOMATIC_AZIMUTH: f64 = 0.49;

/// A camera that stands where the caller says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPlacement {
    /// Where it is, m.
    pub place: DVec3,
    /// A point that is seen in the middle of the picture, m.
    pub target: DVec3,
    /// Field of view across the shorter side of the picture, rad, from that of 1° to that of 150°.
    pub field_of_view: f64,
}

/// Fields of view that a placed camera may have, degrees: beyond them a picture is a point, or mostly distortion.
const FIELDS_OF_VIEW: [f64; 2] = [1.0, 150.0];

impl CameraPlacement {
    /// The field of view of a camera whose own is not given, rad.
    pub const FIELD_OF_VIEW: f64 = FIELD_OF_VIEW;

    /// Whether it looks somewhere, at an angle that it may have.
    pub fn is_valid(&self) -> bool {
        let [least, most] = FIELDS_OF_VIEW.map(f64::to_radians);
        (self.target - self.place).try_normalize().is_some()
            && (least..=most).contains(&self.field_of_view)
    }
}

/// The camera.
pub(crate) struct Camera {
    pub origin: DVec3,
    /// Unit directions to the right, up and forwards.
    pub right: DVec3,
    pub up: DVec3,
    pub forward: DVec3,
    /// Tangents of half the horizontal and vertical fields of view.
    pub tangents: [f64; 2],
    /// Size of a pixel at a distance of one metre, m.
    pub pixel_size: f64,
}

impl Camera {
    /// A camera that shows all `points`, or the sphere `zoom`.
    pub fn new(
        points: &[DVec3],
        view: View,
        zoom: Option<Sphere>,
        up: DVec3,
        size: [u32; 2],
    ) -> Result<Camera, PictureError> {
        let up = up
            .try_normalize()
            .ok_or(PictureError::View("the upward direction has length 0"))?;
        let (azimuth, elevation) = match view {
            View::Automatic => (automatic_azimuth(points, up), AUTOMATIC_ELEVATION),
            View::Direction { azimuth, elevation } => (azimuth, elevation),
        };
        if !(azimuth.is_finite() && elevation.abs() <= std::f64::consts::FRAC_PI_2 + 1e-9) {
            return Err(PictureError::View(
                "the azimuth must be finite and the elevation between −π/2 and π/2 rad",
            ));
        }
        let Horizontal {
            right: across,
            toward,
        } = horizontal(up);
        let (sa, ca) = libm::sincos(azimuth);
        let (se, ce) = libm::sincos(elevation);
        let back = (across * sa + toward * ca) * ce + up * se;
        let right = across * ca - toward * sa;
        let forward = -back;
        let above = right.cross(forward);
        let shorter = libm::tan(FIELD_OF_VIEW / 2.0);
        let tangents = tangents(shorter, size);
        let origin = match zoom {
            Some(Sphere { centre, radius })
                if centre.is_finite() && radius.is_finite() && radius > 0.0 =>
            {
                // The sphere touches the shorter sides of the picture.
                let sine = shorter / (1.0 + shorter * shorter).sqrt();
                centre + back * (radius / sine)
            }
            Some(_) => {
                return Err(PictureError::View(
                    "the sphere must have a finite centre and a finite radius above 0",
                ));
            }
            None => fit(points, [right, above, forward], tangents),
        };
        Ok(Camera {
            origin,
            right,
            up: above,
            forward,
            tangents,
            pixel_size: 2.0 * tangents[1] / f64::from(size[1]),
        })
    }

    /// The camera of a placement. One that looks straight up or down has the directions of a view at azimuth 0.
    pub fn placed(
        placement: &CameraPlacement,
        up: DVec3,
        size: [u32; 2],
    ) -> Result<Camera, PictureError> {
        let up = up
            .try_normalize()
            .ok_or(PictureError::View("the upward direction has length 0"))?;
        if !placement.is_valid() {
            return Err(PictureError::View(
                "the camera must look at another point than its own, with a field of view of 1 to 150°",
            ));
        }
        let forward = (placement.target - placement.place).normalize();
        let right = forward.cross(up);
        let right = if right.length() > STRAIGHT {
            right.normalize()
        } else {
            horizontal(up).right
        };
        let tangents = tangents(libm::tan(placement.field_of_view / 2.0), size);
        Ok(Camera {
            origin: placement.place,
            right,
            up: right.cross(forward),
            forward,
            tangents,
            pixel_size: 2.0 * tangents[1] / f64::from(size[1]),
        })
    }

    /// Unit direction through a point of the picture, in coordinates from −1 to 1, the second one upwards.
    pub fn direction(&self, x: f64, y: f64) -> DVec3 {
        (self.forward + self.right * (x * self.tangents[0]) + self.up * (y * self.tangents[1]))
            .normalize()
    }
}

/// Tangents of half the fields of view across and up a picture of `size` pixels, whose shorter side has `shorter`.
fn tangents(shorter: f64, size: [u32; 2]) -> [f64; 2] {
    let [width, height] = size.map(f64::from);
    if width < height {
        [shorter, shorter * height / width]
    } else {
        [shorter * width / height, shorter]
    }
}

/// A sphere in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// Centre, m.
    pub centre: DVec3,
    /// Radius, m.
    pub radius: f64,
}

/// Horizontal unit directions of a view at azimuth 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Horizontal {
    /// Direction to the right in the picture.
    pub right: DVec3,
    /// Direction towards the viewer.
    pub toward: DVec3,
}

/// Returns the horizontal directions at azimuth 0 for the unit upward direction `up`.
///
/// ```
/// use glam::DVec3;
/// use greenstick_picture::horizontal;
///
/// let directions = horizontal(DVec3::Z);
/// assert_eq!((directions.right, directions.toward), (DVec3::X, DVec3::NEG_Y));
/// ```
pub fn horizontal(up: DVec3) -> Horizontal {
    let reference = if up.x.abs() < 0.9 { DVec3::X } else { DVec3::Y };
    let right = (reference - up * up.dot(reference)).normalize();
    Horizontal {
        right,
        toward: right.cross(up),
    }
}

/// Returns the azimuth of a view in the direction `forward`, rad, for the unit upward direction `up`.
///
/// ```
/// use glam::DVec3;
/// use greenstick_picture::azimuth_of_view;
///
/// assert_eq!(azimuth_of_view(DVec3::Z, DVec3::Y), 0.0);
/// ```
pub fn azimuth_of_view(up: DVec3, forward: DVec3) -> f64 {
    let Horizontal { right, toward } = horizontal(up);
    libm::atan2(-forward.dot(right), -forward.dot(toward))
}

/// The nearest position from which all points are visible: the four side planes of the view are moved outwards until they
/// touch the points; the camera is where they meet.
fn fit(points: &[DVec3], [right, above, forward]: [DVec3; 3], tangents: [f64; 2]) -> DVec3 {
    let [tx, ty] = tangents.map(|t| t * FILL_FRACTION);
    let mut largest = [f64::NEG_INFINITY; 4];
    for p in points {
        let (x, y, z) = (p.dot(right), p.dot(above), p.dot(forward));
        for (m, v) in largest
            .iter_mut()
            .zip([x - tx * z, -x - tx * z, y - ty * z, -y - ty * z])
        {
            *m = m.max(v);
        }
    }
    let [a, b, c, d] = largest;
    let depth = (-(a + b) / (2.0 * tx)).min(-(c + d) / (2.0 * ty));
    // The pair of planes that is not tight is centred.
    right * ((a - b) / 2.0) + above * ((c - d) / 2.0) + forward * depth
}

/// The azimuth of a three-quarter view of the longest horizontal extent.
fn automatic_azimuth(points: &[DVec3], up: DVec3) -> f64 {
    let Horizontal {
        right: across,
        toward,
    } = horizontal(up);
    let flat = |p: &DVec3| dvec3(p.dot(across), p.dot(toward), 0.0);
    let number = points.len().max(1) as f64;
    let middle = points.iter().map(flat).sum::<DVec3>() / number;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for p in points {
        let d = flat(p) - middle;
        xx += d.x * d.x;
        xy += d.x * d.y;
        yy += d.y * d.y;
    }
    // The principal axis of the covariance, by its angle from `across` to `toward`.
    let anisotropy = ((xx - yy) * (xx - yy) + 4.0 * xy * xy).sqrt();
    if anisotropy < 0.1 * (xx + yy) {
        return AUTOMATIC_AZIMUTH;
    }
    let axis = 0.5 * libm::atan2(2.0 * xy, xx - yy);
    // A view at azimuth 0 is perpendicular to `across`.
    AUTOMATIC_AZIMUTH - axis
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fitted_scene_touches_the_frame_from_inside() {
        let points: Vec<DVec3> = (0..200)
            .map(|i| {
                let t = f64::from(i);
                dvec3(
                    (t * 0.7).sin() * 3.0,
                    (t * 1.3).cos() * 0.4,
                    (t * 2.1).sin(),
                )
            })
            .collect();
        for up in [DVec3::Y, DVec3::Z] {
            for view in [
                View::Automatic,
                View::Direction {
                    azimuth: 2.0,
                    elevation: -0.3,
                },
            ] {
                let camera = Camera::new(&points, view, None, up, [400, 300]).unwrap();
                let mut largest = 0.0f64;
                for p in &points {
                    let d = *p - camera.origin;
                    let z = d.dot(camera.forward);
                    assert!(z > 0.0);
                    let x = d.dot(camera.right) / (z * camera.tangents[0]);
                    let y = d.dot(camera.up) / (z * camera.tangents[1]);
                    largest = largest.max(x.abs()).max(y.abs());
                }
                assert!((largest - FILL_FRACTION).abs() < 1e-9, "reaches {largest}");
                assert!(camera.up.dot(up) > 0.0);
                assert!(camera.right.cross(camera.forward).distance(camera.up) < 1e-12);
            }
        }
    }
    #[test]
    fn a_placed_camera_sees_its_target_in_the_middle_and_its_field_at_the_shorter_side() {
        let placement = CameraPlacement {
            place: dvec3(1.0, 2.0, 3.0),
            target: dvec3(-2.0, 0.5, 1.0),
            field_of_view: 40f64.to_radians(),
        };
        for size in [[400, 300], [300, 400]] {
            let camera = Camera::placed(&placement, DVec3::Y, size).unwrap();
            let middle = camera.direction(0.0, 0.0);
            let target = (placement.target - placement.place).normalize();
            assert!(middle.distance(target) < 1e-12);
            let side = match size[0] < size[1] {
                true => [1.0, 0.0],
                false => [0.0, 1.0],
            };
            let angle = camera.direction(side[0], side[1]).angle_between(middle);
            assert!((angle - 20f64.to_radians()).abs() < 1e-9, "{angle}");
            assert!(camera.right.y.abs() < 1e-12 && camera.up.y > 0.0);
        }
        let down = CameraPlacement {
            target: placement.place - DVec3::Y,
            ..placement
        };
        let camera = Camera::placed(&down, DVec3::Y, [4, 3]).unwrap();
        assert_eq!((camera.right, camera.up), (DVec3::X, DVec3::NEG_Z));
        let nowhere = CameraPlacement {
            target: placement.place,
            ..placement
        };
        assert!(Camera::placed(&nowhere, DVec3::Y, [4, 3]).is_err());
    }
}
