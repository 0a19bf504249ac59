//! The studio: a key light like a low sun through thin cloud, a weaker rim light, a weak sky dome, and a floor that fades into
//! the background.

use crate::camera::Camera;
use crate::ground::ShownGround;
use glam::{DVec3, Vec3};
use std::f32::consts::PI;

/// A distant light: a round patch of sky, the same for the whole scene.
pub(crate) struct Lamp {
    /// Unit direction to its centre.
    pub direction: Vec3,
    /// Cosine and sine of its angular radius.
    pub cosine: f32,
    pub sine: f32,
    /// Irradiance on a surface that faces it.
    pub irradiance: Vec3,
}

/// The light at a place.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Light {
    /// Share of each lamp that is not hidden, 0 to 1.
    pub lamps: [f32; 2],
    /// Irradiance from the sky and from other surfaces.
    pub indirect: Vec3,
}

/// The light that rays have found at a pixel.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Traced {
    pub light: Light,
    /// Whether rays to the key light were traced.
    pub has_key: bool,
    /// Whether rays of the rest were: to the rim light, and of indirect light.
    pub has_rest: bool,
}

/// A horizontal plane that shows shadows: on a ground, or else only those, as a darkened background. Shadows fade with the distance
/// from the scene.
pub(crate) struct Floor {
    /// Position along the upward direction, m.
    pub level: f64,
    pub ground: Option<ShownGround>,
}

/// All sources of light.
pub(crate) struct Studio {
    /// Unit upward direction.
    pub up: Vec3,
    /// The key light and the rim light.
    pub lamps: [Lamp; 2],
    /// Radiance of the sky at the zenith and at the nadir.
    pub sky: [Vec3; 2],
    /// Radiance of the floor as seen from items.
    pub floor_radiance: Vec3,
    pub floor: Option<Floor>,
    /// Linear colour of the background at the centre and in the corners of the picture.
    pub background: [Vec3; 2],
}

/// Cosine of the angular radius of the key light (1.5°): its shadows show the shapes of splinters, with edges as soft as those of a
/// sun behind haze.
const KEY_LIGHT_COSINE: f32 = 0.99966;
/// Cosine of the angular radius of the rim light (20°).
const RIM_LIGHT_COSINE: f32 = 0.94;
/// Radiance of the floor of a studio as seen from items: it returns the warm key light.
const FLOOR_RADIANCE: Vec3 = Vec3::new(0.190, 0.182, 0.172);
/// How much more light comes from the sky and from the floor over a ground than in a studio: it lies outdoors, where hollows are not black.
const OUTDOOR_SKY: f32 = 1.5;
const OUTDOOR_FLOOR: f32 = 1.4;
/// How much darker a ground is in the corners of the picture.
const VIGNETTE: f32 = 0.28;

impl Floor {
    /// The distance along a ray at which it meets the floor from above.
    pub fn distance(&self, origin: DVec3, direction: DVec3, up: Vec3) -> Option<f64> {
        let up = up.as_dvec3();
        let fall = direction.dot(up);
        let distance = (self.level - origin.dot(up)) / fall;
        (fall < 0.0 && distance.is_finite()).then_some(distance)
    }
}

impl Lamp {
    /// A lamp in a unit direction whose angular radius has the cosine `cosine`.
    pub fn new(direction: DVec3, cosine: f32, irradiance: Vec3) -> Lamp {
        Lamp {
            direction: direction.as_vec3(),
            cosine,
            sine: (1.0 - cosine * cosine).max(0.0).sqrt(),
            irradiance,
        }
    }

    /// The mean over the lamp of the cosine of its angle to a normal, where it is above the horizon: the cosine at its centre,
    /// with a parabola where the horizon cuts the lamp.
    pub fn cosine_to(&self, normal: Vec3) -> f32 {
        let cosine = self.direction.dot(normal);
        let edge = self.sine.max(1e-4);
        if cosine >= edge {
            cosine
        } else {
            let above = (cosine + edge).max(0.0);
            above * above / (4.0 * edge)
        }
    }
}

impl Studio {
    /// The studio around a scene with a floor at `floor_level`. The lights turn with the camera: the key light comes from the
    /// upper left in front, the rim light from the right behind.
    pub fn new(
        camera: &Camera,
        up: DVec3,
        floor_level: Option<f64>,
        background: [f64; 3],
    ) -> Studio {
        let right = camera.right;
        let toward = right.cross(up);
        let direction = |x: f64, y: f64, z: f64| (right * x + up * y + toward * z).normalize();
        let background = DVec3::from_array(background).as_vec3();
        // From below, the floor would hide the scene.
        let is_below_camera = |level: &f64| camera.origin.dot(up) > *level;
        Studio {
            up: up.as_vec3(),
            lamps: [
                Lamp::new(
                    direction(-0.45, 0.85, 0.75),
                    KEY_LIGHT_COSINE,
                    Vec3::new(4.34, 4.07, 3.58),
                ),
                Lamp::new(
                    direction(0.85, 0.55, -0.75),
                    RIM_LIGHT_COSINE,
                    Vec3::new(1.02, 1.20, 1.45),
                ),
            ],
            sky: [Vec3::new(0.165, 0.195, 0.245), FLOOR_RADIANCE * 0.7],
            floor_radiance: FLOOR_RADIANCE,
            floor: floor_level.filter(is_below_camera).map(|level| Floor {
                level,
                ground: None,
            }),
            background: [background, background * 0.55],
        }
    }

    /// Shows a ground on the floor, if there is a floor, and takes the studio outdoors.
    pub fn show_ground(&mut self, ground: ShownGround) {
        if let Some(floor) = &mut self.floor {
            floor.ground = Some(ground);
            self.sky = [self.sky[0] * OUTDOOR_SKY, self.sky[1] * OUTDOOR_FLOOR];
            self.floor_radiance *= OUTDOOR_FLOOR;
        }
    }

    /// Radiance of the sky in a unit direction.
    pub fn sky(&self, direction: Vec3) -> Vec3 {
        let t = 0.5 + 0.5 * direction.dot(self.up);
        self.sky[1] + (self.sky[0] - self.sky[1]) * t
    }

    /// Radiance of what a ray meets that meets no item.
    pub fn surroundings(&self, direction: Vec3) -> Vec3 {
        if self.floor.is_some() && direction.dot(self.up) < 0.0 {
            self.floor_radiance
        } else {
            self.sky(direction)
        }
    }

    /// Irradiance of the whole sky, without anything in its way, on a surface with a normal. The sky is linear in the cosine, whose
    /// mean over a hemisphere, weighted by the cosine, is two thirds.
    pub fn sky_irradiance(&self, normal: Vec3) -> Vec3 {
        let t = 0.5 + normal.dot(self.up) / 3.0;
        (self.sky[1] + (self.sky[0] - self.sky[1]) * t) * PI
    }

    /// Background at a point of the picture, in coordinates from −1 to 1.
    pub fn background(&self, x: f64, y: f64) -> Vec3 {
        self.background[0] + (self.background[1] - self.background[0]) * corner(x, y)
    }

    /// The colour of the ground at a point of the picture, in coordinates from −1 to 1, in light that nothing hides; detail finer than
    /// `blur` pixels is averaged. `None` where no ground is shown.
    pub fn ground_color(&self, camera: &Camera, [u, v]: [f64; 2], blur: f64) -> Option<Vec3> {
        let floor = self.floor.as_ref()?;
        let ground = floor.ground.as_ref()?;
        let direction = camera.direction(u, v);
        let distance = floor.distance(camera.origin, direction, self.up)?;
        let up = self.up.as_dvec3();
        let (color, normal) = ground.at(
            camera.origin + direction * distance,
            up,
            (distance, direction.dot(up)),
            blur,
        );
        Some(color * self.unshadowed(normal) / PI * self.vignette(u, v))
    }

    /// What a lens leaves of the light at a point of the picture, in coordinates from −1 to 1.
    pub fn vignette(&self, x: f64, y: f64) -> f32 {
        1.0 - VIGNETTE * corner(x, y)
    }

    /// How open the floor is to the sky where its irradiance from there is `indirect`, 0 to 1.
    pub fn floor_openness(&self, indirect: Vec3) -> f32 {
        (luminance(indirect) / luminance(self.sky_irradiance(self.up))).min(1.0)
    }

    /// Irradiance on a surface without anything in its way.
    pub fn unshadowed(&self, normal: Vec3) -> Vec3 {
        let lamps: Vec3 = (self.lamps.iter())
            .map(|l| l.irradiance * l.cosine_to(normal))
            .sum();
        self.sky_irradiance(normal) + lamps
    }
}

/// How near a point of the picture is to a corner, 0 to 1.
fn corner(x: f64, y: f64) -> f32 {
    let far = (((x * x + y * y) * 0.5) as f32).min(1.0);
    far * far * (3.0 - 2.0 * far)
}

/// The luminance of a linear colour (ITU-R BT.709).
pub(crate) fn luminance(c: Vec3) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}
