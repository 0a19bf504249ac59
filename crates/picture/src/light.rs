//! The studio: a large soft key light, a weaker one from behind, a sky dome and a pale floor that fades into the
//! background.

use crate::camera::Camera;
use glam::DVec3;

/// A light so far away that all of the scene sees it as the same round patch of sky.
pub(crate) struct Light {
    /// Unit direction to its middle.
    pub direction: DVec3,
    /// Cosine of its half angle.
    pub cosine: f64,
    /// Irradiance on a surface that faces it (linear).
    pub irradiance: DVec3,
}

/// A horizontal plane that shows only what the scene keeps light from: the background, darkened.
pub(crate) struct Floor {
    /// Its place along the upward direction, m.
    pub level: f64,
    /// Middle of the scene; shadows fade with the distance from it.
    pub middle: DVec3,
    /// Radius of the scene, m.
    pub radius: f64,
}

/// Everything that gives light.
pub(crate) struct Studio {
    pub up: DVec3,
    pub lights: Vec<Light>,
    /// Sky radiance overhead and straight below.
    pub sky: [DVec3; 2],
    pub floor: Option<Floor>,
    /// Background in the middle and at the corners of the picture (linear).
    pub background: [DVec3; 2],
}

/// Half angle of the key light, as its cosine (22°): shadows soft as from a large window nearby.
const KEY_COSINE: f64 = 0.927;
/// Half angle of the light from behind, as its cosine (20°).
const RIM_COSINE: f64 = 0.94;
/// Radiance of the floor in the eyes of the things that stand on it.
pub(crate) const FLOOR_RADIANCE: f64 = 0.42;

impl Studio {
    /// The studio about a scene in the ball (`middle`, `radius`) with its lowest point at `level`. The lights stand
    /// fixed to the camera's heading: key from the upper left in front, rim from the right behind.
    pub fn new(
        camera: &Camera,
        up: DVec3,
        (middle, radius): (DVec3, f64),
        floor: Option<f64>,
        background: [f64; 3],
    ) -> Studio {
        let right = camera.right;
        let toward = right.cross(up);
        let direction = |x: f64, y: f64, z: f64| (right * x + up * y + toward * z).normalize();
        let background = DVec3::from_array(background);
        // From under the floor the scene would be hidden by it.
        let above = |level: &f64| camera.origin.dot(up) > *level;
        Studio {
            up,
            lights: vec![
                Light {
                    direction: direction(-0.75, 0.95, 0.55),
                    cosine: KEY_COSINE,
                    irradiance: DVec3::new(2.55, 2.45, 2.28),
                },
                Light {
                    direction: direction(0.85, 0.55, -0.75),
                    cosine: RIM_COSINE,
                    irradiance: DVec3::new(0.85, 0.92, 1.05),
                },
            ],
            sky: [
                DVec3::new(0.50, 0.53, 0.58),
                DVec3::splat(FLOOR_RADIANCE) * 0.8,
            ],
            floor: floor.filter(above).map(|level| Floor {
                level,
                middle,
                radius,
            }),
            background: [background, background * 0.72],
        }
    }

    /// Radiance of the dome in a unit direction.
    pub fn sky(&self, direction: DVec3) -> DVec3 {
        let t = 0.5 + 0.5 * direction.dot(self.up);
        self.sky[1] + (self.sky[0] - self.sky[1]) * t
    }

    /// Background at a point of the picture, coordinates −1 to 1.
    pub fn background(&self, x: f64, y: f64) -> DVec3 {
        let far = ((x * x + y * y) * 0.5).min(1.0);
        self.background[0]
            + (self.background[1] - self.background[0]) * (far * far * (3.0 - 2.0 * far))
    }

    /// Irradiance on an open surface that faces up: the floor where nothing shades it.
    pub fn open_floor(&self) -> f64 {
        // A dome linear in the cosine: π (b + (t − b) (1/2 + 1/3)).
        let sky = self.sky[1] + (self.sky[0] - self.sky[1]) * (5.0 / 6.0);
        let lights: DVec3 = self
            .lights
            .iter()
            .map(|l| l.irradiance * l.direction.dot(self.up).max(0.0))
            .sum();
        luminance(sky * std::f64::consts::PI + lights)
    }
}

/// How bright a linear colour looks (ITU-R BT.709).
pub(crate) fn luminance(c: DVec3) -> f64 {
    c.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}
