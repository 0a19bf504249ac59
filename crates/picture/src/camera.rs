//! The camera: a long lens on the scene, placed by itself or by the caller.

use crate::PictureError;
use glam::{DVec3, dvec3};

/// From where the scene is seen.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum View {
    /// Three quarters on the longest horizontal extent, from a little above.
    #[default]
    Automatic,
    /// From the given direction.
    Direction {
        /// Angle about the upward direction, rad; 0 looks from +Z where up is +Y, and from −Y where up is +Z.
        azimuth: f64,
        /// Angle above the horizon, rad, −π/2 to π/2.
        elevation: f64,
    },
}

/// Vertical field of view, rad (25°): as a short telephoto lens, without the swollen foreground of a wide one.
const FIELD: f64 = 0.436_332;
/// Part of the picture's half width and height that a fitted scene may fill.
const FILL: f64 = 0.88;
/// Elevation of the automatic view, rad (24°).
const AUTOMATIC_ELEVATION: f64 = 0.42;
/// How far the automatic view is turned from square on, rad (28°).
const AUTOMATIC_TURN: f64 = 0.49;

/// The camera: where a point of the picture looks to.
pub(crate) struct Camera {
    pub origin: DVec3,
    /// To the right, up and forwards (unit).
    pub right: DVec3,
    pub up: DVec3,
    pub forward: DVec3,
    /// Tangents of the half fields of view.
    pub tangents: [f64; 2],
    /// Size of a pixel one metre ahead, m.
    pub pixel: f64,
}

impl Camera {
    /// A camera that fits all `points`, or the ball `zoom` (centre, radius in m).
    pub fn new(
        points: &[DVec3],
        view: View,
        zoom: Option<(DVec3, f64)>,
        up: DVec3,
        size: [u32; 2],
    ) -> Result<Camera, PictureError> {
        let up = up
            .try_normalize()
            .ok_or(PictureError::View("the upward direction has no length"))?;
        let (azimuth, elevation) = match view {
            View::Automatic => (automatic_azimuth(points, up), AUTOMATIC_ELEVATION),
            View::Direction { azimuth, elevation } => (azimuth, elevation),
        };
        if !(azimuth.is_finite() && elevation.abs() <= std::f64::consts::FRAC_PI_2 + 1e-9) {
            return Err(PictureError::View(
                "the azimuth must be a number and the elevation −π/2 to π/2 radians",
            ));
        }
        let (across, toward) = horizontal(up);
        let (sa, ca) = libm::sincos(azimuth);
        let (se, ce) = libm::sincos(elevation);
        let back = (across * sa + toward * ca) * ce + up * se;
        let right = across * ca - toward * sa;
        let forward = -back;
        let above = right.cross(forward);
        let [width, height] = size.map(f64::from);
        let shorter = libm::tan(FIELD / 2.0);
        let tangents = if width < height {
            [shorter, shorter * height / width]
        } else {
            [shorter * width / height, shorter]
        };
        let origin = match zoom {
            Some((centre, radius)) if centre.is_finite() && radius.is_finite() && radius > 0.0 => {
                // The ball touches the shorter side of the picture.
                let sine = shorter / (1.0 + shorter * shorter).sqrt();
                centre + back * (radius / sine)
            }
            Some(_) => {
                return Err(PictureError::View(
                    "the target must be finite and its radius above 0",
                ));
            }
            None => fit(points, [right, above, forward], tangents),
        };
        let pixel = 2.0 * tangents[1] / height;
        Ok(Camera {
            origin,
            right,
            up: above,
            forward,
            tangents,
            pixel,
        })
    }

    /// Unit direction through a point of the picture, both coordinates −1 to 1, the second upwards.
    pub fn direction(&self, x: f64, y: f64) -> DVec3 {
        (self.forward + self.right * (x * self.tangents[0]) + self.up * (y * self.tangents[1]))
            .normalize()
    }
}

/// Two horizontal directions of a picture with the upward direction `up` (unit): the one to the right and the one towards a viewer at azimuth 0.
pub fn horizontal(up: DVec3) -> (DVec3, DVec3) {
    let reference = if up.x.abs() < 0.9 { DVec3::X } else { DVec3::Y };
    let across = (reference - up * up.dot(reference)).normalize();
    (across, across.cross(up))
}

/// The nearest place from which all points are inside the picture: the four side planes are pushed outwards until
/// they touch, then the camera is where they meet.
fn fit(points: &[DVec3], [right, above, forward]: [DVec3; 3], tangents: [f64; 2]) -> DVec3 {
    let [tx, ty] = tangents.map(|t| t * FILL);
    let mut most = [f64::NEG_INFINITY; 4];
    for p in points {
        let (x, y, z) = (p.dot(right), p.dot(above), p.dot(forward));
        for (m, v) in most
            .iter_mut()
            .zip([x - tx * z, -x - tx * z, y - ty * z, -y - ty * z])
        {
            *m = m.max(v);
        }
    }
    let [a, b, c, d] = most;
    let depth = (-(a + b) / (2.0 * tx)).min(-(c + d) / (2.0 * ty));
    // The narrower pair of planes has room to spare, which is shared at the depth of the scene's middle.
    right * ((a - b) / 2.0) + above * ((c - d) / 2.0) + forward * depth
}

/// The azimuth that shows the longest horizontal extent three quarters on.
fn automatic_azimuth(points: &[DVec3], up: DVec3) -> f64 {
    let (across, toward) = horizontal(up);
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
    // Main axis of the covariance; its angle from `across` towards `toward`.
    let spread = ((xx - yy) * (xx - yy) + 4.0 * xy * xy).sqrt();
    if spread < 0.1 * (xx + yy) {
        return AUTOMATIC_TURN;
    }
    let axis = 0.5 * libm::atan2(2.0 * xy, xx - yy);
    // Azimuth 0 looks along −toward and sees `across` square on.
    AUTOMATIC_TURN - axis
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fitted_scene_touches_the_frame_and_stays_inside() {
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
                assert!((largest - FILL).abs() < 1e-9, "reaches {largest}");
                assert!(camera.up.dot(up) > 0.0);
                assert!(camera.right.cross(camera.forward).distance(camera.up) < 1e-12);
            }
        }
    }
}
