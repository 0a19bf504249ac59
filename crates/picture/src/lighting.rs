//! The light that reaches a place: which share of each lamp, and how much from the sky and from other surfaces. It is found
//! with a few rays and without regard to what the surface looks like, so that it can be smoothed and the wood stays sharp
//! (the ratio estimator of Heitz, Hill and McGuire 2018).

use crate::light::{Lamp, Light, Studio};
use crate::sampling::{Purpose, Sampler, cone_direction, cosine_direction};
use crate::scene::Scene;
use crate::surface::Place;
use glam::Vec3;
use std::f32::consts::PI;
use std::ops::Range;

/// Fraction of the sky that is assumed to be visible from surfaces that indirect light comes from; their occlusion is not
/// traced.
const INDIRECT_OPENNESS: f32 = 0.6;
/// Share of what surfaces that indirect light comes from reflect that meets such surfaces again.
const FURTHER_BOUNCES: f32 = 0.5;
/// Share of indirect rays whose surfaces are lit by the rim light; the others take the key light.
const RIM_LIGHT_SHARE: f32 = 0.25;

/// Part of the light that passes very thin wood, and its colour: what is left after ways through fibres.
const TRANSLUCENCY: f32 = 0.5;
const TRANSLUCENT_COLOR: Vec3 = Vec3::new(1.0, 0.78, 0.52);
/// Thickness that light passes by a quarter, m, and how many of them let nothing through.
const TRANSLUCENT_DEPTH: f32 = 8e-4;
const MAX_DEPTHS: f32 = 4.0;

impl Scene<'_> {
    /// The light at a place, from `rays` rays to the key light, as many indirect ones, and half as many to the rim light.
    pub fn light_at(&self, studio: &Studio, place: &Place, sampler: &Sampler, rays: u32) -> Light {
        if place.met.is_unlit() {
            return Light::default();
        }
        let mut light = Light::default();
        // The rim light is weak.
        let lamp_rays = [
            (Purpose::KeyLight, rays),
            (Purpose::RimLight, rays.div_ceil(2)),
        ];
        for ((lamp, share), (purpose, rays)) in
            (studio.lamps.iter()).zip(&mut light.lamps).zip(lamp_rays)
        {
            *share = self.visible_share(lamp, place, sampler, purpose, 0..rays);
        }
        for i in 0..rays {
            light.indirect += self.indirect(studio, place, sampler, i);
        }
        // The density cosine / π of directions cancels the cosine.
        light.indirect *= PI / rays as f32;
        if place.is_fibrous {
            light.indirect += self.through(&studio.lamps[0], place, sampler, rays);
        }
        light
    }

    /// Irradiance from a lamp behind thin wood.
    fn through(&self, lamp: &Lamp, place: &Place, sampler: &Sampler, rays: u32) -> Vec3 {
        if lamp.direction.dot(place.geometric_normal) > lamp.sine {
            return Vec3::ZERO;
        }
        let mut share = 0.0;
        for i in 0..rays {
            let square = sampler.square(i, Purpose::KeyLight);
            let out = cone_direction(lamp.direction, lamp.cosine, square);
            let behind = -place.geometric_normal;
            let cosine = out.dot(behind);
            if cosine <= 0.0 {
                continue;
            }
            let most = MAX_DEPTHS * TRANSLUCENT_DEPTH;
            let Some(thickness) = self.thickness(place.position, behind, out, most) else {
                continue;
            };
            let left = place.position + out * thickness;
            if !self.is_hidden(left, out, out) {
                let depth = thickness / TRANSLUCENT_DEPTH;
                let passed = 1.0 + depth * depth;
                share += cosine / (passed * passed);
            }
        }
        lamp.irradiance * TRANSLUCENT_COLOR * (TRANSLUCENCY * share / rays as f32)
    }

    /// The same light with `further` rays to the key light, after the first `rays`.
    pub fn refined_light(
        &self,
        studio: &Studio,
        place: &Place,
        sampler: &Sampler,
        mut light: Light,
        [rays, further]: [u32; 2],
    ) -> Light {
        let (lamp, purpose) = (&studio.lamps[0], Purpose::KeyLight);
        let share = self.visible_share(lamp, place, sampler, purpose, rays..rays + further);
        let part = further as f32 / (rays + further) as f32;
        light.lamps[0] += (share - light.lamps[0]) * part;
        light
    }

    /// The share of a lamp that is visible from a place, weighted by the cosine, of the part above its horizon.
    fn visible_share(
        &self,
        lamp: &Lamp,
        place: &Place,
        sampler: &Sampler,
        purpose: Purpose,
        rays: Range<u32>,
    ) -> f32 {
        if lamp.direction.dot(place.geometric_normal) < -lamp.sine {
            return 0.0;
        }
        let (mut seen, mut all) = (0.0, 0.0);
        for i in rays {
            let out = cone_direction(lamp.direction, lamp.cosine, sampler.square(i, purpose));
            let weight = out.dot(place.normal).max(0.0);
            all += weight;
            let is_above = weight > 0.0 && out.dot(place.geometric_normal) > 0.0;
            if is_above && !self.is_hidden(place.position, place.geometric_normal, out) {
                seen += weight;
            }
        }
        if all > 0.0 { seen / all } else { 0.0 }
    }

    /// Radiance from the sky, the floor or another surface in a random direction.
    fn indirect(&self, studio: &Studio, place: &Place, sampler: &Sampler, index: u32) -> Vec3 {
        let out = cosine_direction(place.normal, sampler.square(index, Purpose::Indirect));
        if out.dot(place.geometric_normal) <= 0.0 {
            return Vec3::ZERO;
        }
        let Some(bounce) =
            self.bounce(place.position, place.geometric_normal, out, place.footprint)
        else {
            return studio.surroundings(out);
        };
        let [choice, _] = sampler.square(index, Purpose::BounceLight);
        let (lamp, probability) = if choice < RIM_LIGHT_SHARE {
            (&studio.lamps[1], RIM_LIGHT_SHARE)
        } else {
            (&studio.lamps[0], 1.0 - RIM_LIGHT_SHARE)
        };
        let square = sampler.square(index, Purpose::Bounce);
        let to_lamp = cone_direction(lamp.direction, lamp.cosine, square);
        let cosine = to_lamp.dot(bounce.normal);
        let mut light = studio.sky(bounce.normal) * INDIRECT_OPENNESS;
        if cosine > 0.0 && !self.is_hidden(bounce.position, bounce.normal, to_lamp) {
            light += lamp.irradiance * (cosine / (probability * PI));
        }
        // Light that goes on between surfaces loses their colour each time: a geometric series.
        bounce.color * light / (Vec3::ONE - bounce.color * FURTHER_BOUNCES)
    }
}
