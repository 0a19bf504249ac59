//! Points of surfaces with their reflectance.

use crate::light::{Lamp, Light, Studio, luminance};
use crate::shader::{Appearance, Hit};
use glam::{DVec3, Vec3};
use std::f32::consts::PI;

/// Reflectance of bark and wood at normal incidence (refractive index 1.5).
const NORMAL_REFLECTANCE: f32 = 0.04;
/// Smallest roughness: sharper highlights are noise at few samples.
const MIN_ROUGHNESS: f64 = 0.3;
/// Smallest cosine of the angle between the shading normal and the geometric normal.
const MIN_NORMAL_COSINE: f64 = 0.1;
/// Largest radiance of a pixel: rare highlights would remain as white pixels.
const MAX_RADIANCE: f32 = 4.0;

/// Sheen of fibres on the cone, relative to white matt wood, and half the width of its lobe, as a sum of sines of angles.
const SHEEN: f32 = 0.45;
const SHEEN_WIDTH: f32 = 0.35;

/// How much darker the floor is where things stand on it, for the cube of the share of the sky that they hide, and what is left at least.
const CONTACT: f32 = 1.2;
const LEAST_CONTACT: f32 = 0.4;

/// What a camera ray meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Met {
    Item(u32),
    Floor,
    /// The ground so far from the scene that no shadows fall there.
    FarGround,
    Background,
}

impl Met {
    /// Whether no light is traced there: its radiance is its colour.
    pub fn is_unlit(self) -> bool {
        matches!(self, Met::FarGround | Met::Background)
    }
}

/// Where a camera ray ends: what light and filter need to know of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub met: Met,
    /// From the centre of the scene, m.
    pub position: Vec3,
    /// Unit normals on the side of the viewer: interpolated, and of the triangle.
    pub normal: Vec3,
    pub geometric_normal: Vec3,
    /// Size of a pixel there, m.
    pub footprint: f32,
    /// Whether light comes through where it is thin.
    pub is_fibrous: bool,
}

/// What a camera ray sees.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen {
    pub place: Place,
    /// Linear colour of the surface or the background.
    pub color: Vec3,
    pub roughness: f32,
    /// Unit normal with relief finer than the mesh.
    pub normal: Vec3,
    /// Unit direction of fibres, or zero.
    pub fibre: Vec3,
    /// Unit direction to the viewer.
    pub to_viewer: Vec3,
    /// How much of the shadows on the floor is shown, from 0 (none) to 1.
    pub shadows: f32,
}

impl Seen {
    /// The radiance towards the viewer in the light at its place.
    pub fn radiance(&self, studio: &Studio, light: &Light) -> Vec3 {
        match self.place.met {
            Met::Background | Met::FarGround => self.color,
            Met::Floor => {
                let lamps: Vec3 = (studio.lamps.iter().zip(light.lamps))
                    .map(|(lamp, share)| lamp.irradiance * lamp.cosine_to(studio.up) * share)
                    .sum();
                // Next to the wood the floor sees little else: light that it has returned itself is missing there too.
                let hidden = 1.0 - studio.floor_openness(light.indirect);
                let contact = (1.0 - CONTACT * hidden * hidden * hidden).max(LEAST_CONTACT);
                let (lit, full) = (lamps + light.indirect, studio.unshadowed(studio.up));
                let is_plain = studio.floor.as_ref().is_none_or(|f| f.ground.is_none());
                // On a ground the sky colours shadows; a backdrop stays grey.
                let left = match is_plain {
                    true => Vec3::splat(luminance(lit) / luminance(full)),
                    false => lit / full,
                };
                self.color * (Vec3::ONE + (left * contact - Vec3::ONE) * self.shadows)
            }
            Met::Item(_) => {
                let mut sum = self.color * light.indirect / PI;
                // The relief turns the surface towards another part of the sky.
                sum *= studio.sky_irradiance(self.normal)
                    / studio
                        .sky_irradiance(self.place.normal)
                        .max(Vec3::splat(1e-6));
                for (lamp, share) in studio.lamps.iter().zip(light.lamps) {
                    if share > 0.0 {
                        sum += self.direct(lamp) * share;
                    }
                }
                sum.min(Vec3::splat(MAX_RADIANCE))
            }
        }
    }

    /// The radiance from a lamp that nothing hides.
    fn direct(&self, lamp: &Lamp) -> Vec3 {
        let cosine = lamp.cosine_to(self.normal);
        if cosine <= 0.0 {
            return Vec3::ZERO;
        }
        self.scatter(lamp) * lamp.irradiance * cosine
    }

    /// The reflectance (1/sr) for light from a lamp: Lambertian with a GGX coat (Walter et al. 2007, with the height-correlated
    /// masking of Heitz 2014), which the size of the lamp makes rougher (Karis 2013).
    fn scatter(&self, lamp: &Lamp) -> Vec3 {
        let (n, out) = (self.normal, lamp.direction);
        let half = (out + self.to_viewer).normalize_or(n);
        let (nl, nv) = (n.dot(out).max(1e-2), n.dot(self.to_viewer).max(0.05));
        let (nh, vh) = (
            n.dot(half).max(0.0),
            self.to_viewer.dot(half).clamp(0.0, 1.0),
        );
        let own = self.roughness * self.roughness;
        let wide = (own + lamp.sine / 3.0).min(1.0);
        let a = wide * wide;
        let d = nh * nh * (a - 1.0) + 1.0;
        let masking = nl * (nv * nv * (1.0 - a) + a).sqrt() + nv * (nl * nl * (1.0 - a) + a).sqrt();
        let f = 1.0 - vh;
        let fresnel = NORMAL_REFLECTANCE + (1.0 - NORMAL_REFLECTANCE) * f * f * f * f * f;
        let coat = a / (PI * d * d) * 0.5 / masking * fresnel;
        self.color * ((1.0 - fresnel) / PI + self.sheen(out)) + Vec3::splat(coat)
    }

    /// The sheen of fibres: light from below the surface leaves them near the cone about the fibre on which a mirror along it would
    /// send it, in the colour of the wood (Marschner et al. 2005, with one lobe).
    fn sheen(&self, out: Vec3) -> f32 {
        if self.fibre == Vec3::ZERO {
            return 0.0;
        }
        let off = (self.fibre.dot(out) + self.fibre.dot(self.to_viewer)) / SHEEN_WIDTH;
        let lobe = 1.0 + off * off;
        SHEEN / (PI * lobe * lobe)
    }
}

/// Makes the result of a shader valid: finite and within range, with a unit normal on the side of the viewer.
pub(crate) fn valid_appearance(appearance: Appearance, hit: &Hit) -> Appearance {
    let color = appearance.color.map(|c| {
        if c.is_finite() {
            c.clamp(0.0, 1.0)
        } else {
            0.0
        }
    });
    let roughness = if appearance.roughness.is_finite() {
        appearance.roughness
    } else {
        1.0
    };
    let mut normal = appearance.normal.try_normalize().unwrap_or(hit.normal);
    // A tilted normal must not turn the surface entirely into its own shadow.
    let cosine = normal.dot(hit.geometric_normal);
    if cosine < MIN_NORMAL_COSINE {
        normal = (normal + hit.geometric_normal * (MIN_NORMAL_COSINE - cosine))
            .normalize_or(hit.geometric_normal);
    }
    Appearance {
        color,
        roughness: roughness.clamp(MIN_ROUGHNESS, 1.0),
        normal,
        fibre: appearance.fibre.normalize_or_zero(),
    }
}

/// A vector in the precision of light.
pub(crate) fn single(v: [f64; 3]) -> Vec3 {
    DVec3::from_array(v).as_vec3()
}
