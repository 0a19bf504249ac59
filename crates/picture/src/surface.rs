//! Points of surfaces with their reflectance.

use crate::shader::{Appearance, Hit};
use glam::DVec3;
use std::f64::consts::PI;

/// Reflectance of bark and wood at normal incidence (refractive index 1.5).
const NORMAL_REFLECTANCE: f64 = 0.04;
/// Smallest roughness: sharper highlights are noise at few samples.
const MIN_ROUGHNESS: f64 = 0.3;
/// Smallest cosine of the angle between the shading normal and the geometric normal.
const MIN_NORMAL_COSINE: f64 = 0.1;

/// A point of a surface.
pub(crate) struct Surface<'a> {
    pub appearance: &'a Appearance,
    pub position: DVec3,
    /// Geometric normal on the side of the viewer.
    pub geometric_normal: DVec3,
    /// Unit direction to the viewer.
    pub to_viewer: DVec3,
}

impl Surface<'_> {
    /// The reflectance (1/sr) for light from the unit direction `out`: Lambertian with a GGX coat (Walter et al. 2007, with
    /// the height-correlated masking of Heitz 2014).
    pub fn scatter(&self, out: DVec3) -> DVec3 {
        let n = self.appearance.normal;
        let half = (out + self.to_viewer).normalize_or(n);
        let (nl, nv) = (n.dot(out).max(1e-4), n.dot(self.to_viewer).max(0.05));
        let (nh, vh) = (
            n.dot(half).max(0.0),
            self.to_viewer.dot(half).clamp(0.0, 1.0),
        );
        let a = self.appearance.roughness * self.appearance.roughness;
        let a = a * a;
        let d = nh * nh * (a - 1.0) + 1.0;
        let masking = nl * (nv * nv * (1.0 - a) + a).sqrt() + nv * (nl * nl * (1.0 - a) + a).sqrt();
        let f = 1.0 - vh;
        let fresnel = NORMAL_REFLECTANCE + (1.0 - NORMAL_REFLECTANCE) * f * f * f * f * f;
        let coat = a / (PI * d * d) * 0.5 / masking * fresnel;
        DVec3::from_array(self.appearance.color) * ((1.0 - fresnel) / PI) + DVec3::splat(coat)
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
    }
}
