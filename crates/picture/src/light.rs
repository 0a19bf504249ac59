//! The studio: a large soft key light, a weaker rim light, a sky dome, and a pale floor that fades into the background.

use crate::camera::{Camera, Sphere};
use glam::DVec3;

/// A distant light: a round patch of sky, the same for the whole scene.
pub(crate) struct Light {
    /// Unit direction to its centre.
    pub direction: DVec3,
    /// Cosine of its angular radius.
    pub cosine: f64,
    /// Irradiance on a surface that faces it.
    pub irradiance: DVec3,
}

/// A horizontal plane that shows only shadows, as a darkened background.
pub(crate) struct Floor {
    /// Position along the upward direction, m.
    pub level: f64,
    /// Bounding sphere of the scene; shadows fade with the distance from it.
    pub bounds: Sphere,
}

/// All sources of light.
pub(crate) struct Studio {
    /// Unit upward direction.
    pub up: DVec3,
    pub lights: Vec<Light>,
    /// Radiance of the sky at the zenith and at the nadir.
    pub sky: [DVec3; 2],
    pub floor: Option<Floor>,
    /// Linear colour of the background at the centre and in the corners of the picture.
    pub background: [DVec3; 2],
}

/// Cosine of the angular radius of the key light (22°): its shadows are as soft as those of a large window nearby.
const KEY_LIGHT_COSINE: f64 = 0.927;
/// Cosine of the angular radius of the rim light (20°).
const RIM_LIGHT_COSINE: f64 = 0.94;
/// Radiance of the floor as seen from items.
pub(crate) const FLOOR_RADIANCE: f64 = 0.42;

impl Studio {
    /// The studio around a scene with the given bounding sphere and a floor at `floor_level`. The lights turn with the camera:
    /// the key light comes from the upper left in front, the rim light from the right behind.
    pub fn new(
        camera: &Camera,
        up: DVec3,
        bounds: Sphere,
        floor_level: Option<f64>,
        background: [f64; 3],
    ) -> Studio {
        let right = camera.right;
        let toward = right.cross(up);
        let direction = |x: f64, y: f64, z: f64| (right * x + up * y + toward * z).normalize();
        let background = DVec3::from_array(background);
        // From below, the floor would hide the scene.
        let is_below_camera = |level: &f64| camera.origin.dot(up) > *level;
        Studio {
            up,
            lights: vec![
                Light {
                    direction: direction(-0.75, 0.95, 0.55),
                    cosine: KEY_LIGHT_COSINE,
                    irradiance: DVec3::new(2.55, 2.45, 2.28),
                },
                Light {
                    direction: direction(0.85, 0.55, -0.75),
                    cosine: RIM_LIGHT_COSINE,
                    irradiance: DVec3::new(0.85, 0.92, 1.05),
                },
            ],
            sky: [
                DVec3::new(0.50, 0.53, 0.58),
                DVec3::splat(FLOOR_RADIANCE) * 0.8,
            ],
            floor: floor_level
                .filter(is_below_camera)
                .map(|level| Floor { level, bounds }),
            background: [background, background * 0.72],
        }
    }

    /// Radiance of the sky in a unit direction.
    pub fn sky(&self, direction: DVec3) -> DVec3 {
        let t = 0.5 + 0.5 * direction.dot(self.up);
        self.sky[1] + (self.sky[0] - self.sky[1]) * t
    }

    /// Background at a point of the picture, in coordinates from −1 to 1.
    pub fn background(&self, x: f64, y: f64) -> DVec3 {
        let far = ((x * x + y * y) * 0.5).min(1.0);
        self.background[0]
            + (self.background[1] - self.background[0]) * (far * far * (3.0 - 2.0 * far))
    }

    /// Luminance of the irradiance on the floor without shadows.
    pub fn unshadowed_floor(&self) -> f64 {
        // For a sky that is linear in the cosine: π (b + (t − b) (1/2 + 1/3)).
        let sky = self.sky[1] + (self.sky[0] - self.sky[1]) * (5.0 / 6.0);
        let lights: DVec3 = self
            .lights
            .iter()
            .map(|l| l.irradiance * l.direction.dot(self.up).max(0.0))
            .sum();
        luminance(sky * std::f64::consts::PI + lights)
    }
}

/// The luminance of a linear colour (ITU-R BT.709).
pub(crate) fn luminance(c: DVec3) -> f64 {
    c.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}
