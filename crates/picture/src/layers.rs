//! The layers of a pixel: what of it is near, and what is seen past that.

use glam::Vec3;

/// What of a pixel lies at about one distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Layer {
    /// Its radiance times its share of the pixel.
    pub light: Vec3,
    /// Its share of the pixel, 0 to 1.
    pub share: f32,
    /// One over its distance from the camera along the view, 1/m; 0 where nothing is.
    pub nearness: f32,
}

impl Layer {
    /// No part of a pixel.
    pub const NONE: Layer = Layer {
        light: Vec3::ZERO,
        share: 0.0,
        nearness: 0.0,
    };
}

/// A pixel in two layers, the nearer first; the second has no share where all of the pixel lies at about one distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pixel(pub [Layer; 2]);

/// Difference of the least and the greatest nearness of a pixel, as a part of the greatest, from which on it has two layers.
const SEPARATE: f32 = 0.01;

impl Pixel {
    /// A pixel that lies at one distance.
    pub fn even(radiance: Vec3, nearness: f32) -> Pixel {
        let all = Layer {
            light: radiance,
            share: 1.0,
            nearness,
        };
        Pixel([all, Layer::NONE])
    }

    /// A pixel of rays, each with its radiance and the nearness of what it meets.
    pub fn of_rays(rays: &[(Vec3, f32)]) -> Pixel {
        let (least, greatest) = (rays.iter()).fold((f32::INFINITY, 0.0f32), |(low, high), ray| {
            (low.min(ray.1), high.max(ray.1))
        });
        let border = match greatest - least > SEPARATE * greatest {
            true => 0.5 * (least + greatest),
            false => 0.0,
        };
        let layer = |is_near: bool| {
            let mut sum = Layer::NONE;
            for (radiance, nearness) in rays {
                if (*nearness >= border) == is_near {
                    sum.light += *radiance;
                    sum.nearness += nearness;
                    sum.share += 1.0;
                }
            }
            if sum.share == 0.0 {
                return Layer::NONE;
            }
            Layer {
                light: sum.light / rays.len() as f32,
                nearness: sum.nearness / sum.share,
                share: sum.share / rays.len() as f32,
            }
        };
        Pixel([layer(true), layer(false)])
    }

    /// The radiance of all of it.
    pub fn radiance(&self) -> Vec3 {
        self.0[0].light + self.0[1].light
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_that_end_far_apart_make_two_layers() {
        let (red, blue) = (Vec3::X, Vec3::Z);
        let pixel = Pixel::of_rays(&[(red, 2.0), (blue, 1.0), (red, 2.0), (red, 1.99)]);
        let [near, far] = pixel.0;
        assert_eq!((near.share, far.share), (0.75, 0.25));
        assert_eq!((near.light, far.light), (0.75 * red, 0.25 * blue));
        assert!((near.nearness - 5.99 / 3.0).abs() < 1e-6 && far.nearness == 1.0);
        // One surface is one layer, and so is nothing.
        let even = Pixel::of_rays(&[(red, 2.0), (blue, 1.99)]);
        assert_eq!((even.0[0].share, even.0[1].share), (1.0, 0.0));
        assert_eq!(even.radiance(), 0.5 * (red + blue));
        assert_eq!(Pixel::of_rays(&[(red, 0.0)]), Pixel::even(red, 0.0));
    }
}
