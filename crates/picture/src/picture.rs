//! Finished pictures: tone mapping and PNG.

use crate::grain::Grain;
use crate::light::luminance;
use glam::Vec3;
use greenstick_geometry::{Metadata, MetadataEntry};
use rayon::prelude::*;

/// A picture in 8-bit sRGB, with three bytes per pixel and rows from top to bottom.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Red, green and blue of each pixel.
    pub rgb: Vec<u8>,
}

/// End of the linear part of the tone curve, which preserves the colours of wood; above, the curve bends towards white.
const TONE_CURVE_SHOULDER: f32 = 0.45;

/// What turns light into the levels of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Film {
    /// Keeps the ratios of colours up to the shoulder of the tone curve.
    Even,
    /// Has the contrast of a photograph: shadows are darker and lights lighter than they were.
    Photographic,
}

/// Gamma and exposure of the photographic film: together they keep a tenth of white and raise what is lighter.
const PHOTOGRAPHIC_GAMMA: f64 = 1.16;
const PHOTOGRAPHIC_EXPOSURE: f32 = 1.36;

/// Luminance that the brightest large parts of a photograph have at most, and the share of its pixels that is brighter than those: the
/// photographer exposes for the highlights.
const HIGHLIGHT: f32 = 0.60;
const HIGHLIGHT_SHARE: f64 = 0.03;

impl Film {
    /// The exposure of a picture whose brightest large parts have this luminance.
    fn exposure(self, highlight: f32) -> f32 {
        match self {
            Film::Even => 1.0,
            Film::Photographic => (HIGHLIGHT / highlight).min(PHOTOGRAPHIC_EXPOSURE),
        }
    }

    /// A value of the tone curve as the film shows it, both 0 to 1.
    fn developed(self, v: f64) -> f64 {
        match self {
            Film::Even => v,
            Film::Photographic => libm::pow(v, PHOTOGRAPHIC_GAMMA),
        }
    }
}

/// Steps of the table of the sRGB transfer function, whose values lie less than 0.02 of a level of 255 from it.
const CURVE_STEPS: usize = 4096;
/// Places in which the levels between two of 255 are shown by a pattern of both, so that slow gradients have no bands: an
/// ordered pattern (Bayer 1973) stays smaller in files than noise.
const DITHER: [[u8; 8]; 8] = bayer();

const fn bayer() -> [[u8; 8]; 8] {
    let mut table = [[0; 8]; 8];
    let mut i = 0;
    while i < 64 {
        let (x, y) = (i % 8, i / 8);
        let (mut value, mut bit) = (0, 0);
        while bit < 3 {
            let (a, b) = (x >> bit & 1, y >> bit & 1);
            value = value << 2 | (a ^ b) << 1 | b;
            bit += 1;
        }
        table[y][x] = value as u8;
        i += 1;
    }
    table
}

impl Picture {
    /// Tone-maps linear radiance.
    pub(crate) fn from_radiance(
        [width, height]: [u32; 2],
        radiance: &[Vec3],
        film: Film,
        grain: f64,
    ) -> Picture {
        let mut luminances: Vec<f32> = radiance.par_iter().map(|&l| luminance(l)).collect();
        let place = ((1.0 - HIGHLIGHT_SHARE) * luminances.len() as f64) as usize;
        let highlight = match place < luminances.len() {
            true => *luminances.select_nth_unstable_by(place, f32::total_cmp).1,
            false => 0.0,
        };
        let exposure = film.exposure(highlight);
        // The square root spreads the dark part of the curve, where it is steepest.
        let curve: Vec<f32> = (0..=CURVE_STEPS)
            .map(|i| i as f64 / CURVE_STEPS as f64)
            .map(|root| (encode_srgb(film.developed(root * root)) * 255.0) as f32)
            .collect();
        let level = |v: f32| {
            let place = tone_mapped(v * exposure).sqrt() * CURVE_STEPS as f32;
            let step = (place as usize).min(CURVE_STEPS - 1);
            curve[step] + (curve[step + 1] - curve[step]) * (place - step as f32)
        };
        // Frames of a film differ in it, as their light does.
        let grain = Grain::new(grain, height, highlight.to_bits());
        let mut rgb = vec![0; 3 * radiance.len()];
        let rows = radiance.par_chunks(width as usize);
        let bytes = rgb.par_chunks_mut(3 * width as usize);
        rows.zip(bytes).enumerate().for_each(|(y, (row, bytes))| {
            let grain = grain.row(y, width as usize);
            for (x, (l, bytes)) in row.iter().zip(bytes.as_chunks_mut().0).enumerate() {
                let above = (f32::from(DITHER[y % 8][x % 8]) + 0.5) / 64.0;
                let levels = grain.over(l.to_array().map(level).into(), x);
                *bytes = levels.to_array().map(|v| (v + above) as u8);
            }
        });
        Picture { width, height, rgb }
    }

    /// Encodes the picture as PNG. Returns nothing if `rgb` does not have the size of the picture.
    pub fn png(&self) -> Vec<u8> {
        self.png_with(&Metadata::default())
    }

    /// The same with metadata as international text chunks, whose keywords are their names.
    pub fn png_with(&self, metadata: &Metadata) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        for MetadataEntry { name, text } in &metadata.entries {
            // Names and texts are short, and their characters are allowed.
            let _ = encoder.add_itxt_chunk(name.clone(), text.clone());
        }
        let written = encoder.write_header().and_then(|mut writer| {
            writer
                .write_image_data(&self.rgb)
                .and_then(|()| writer.finish())
        });
        // Writing to memory cannot fail.
        match written {
            Ok(()) => bytes,
            Err(_) => Vec::new(),
        }
    }
}

/// A component of radiance on the tone curve, 0 to 1.
fn tone_mapped(v: f32) -> f32 {
    if v > TONE_CURVE_SHOULDER {
        let over = (v - TONE_CURVE_SHOULDER) / (1.0 - TONE_CURVE_SHOULDER);
        TONE_CURVE_SHOULDER + (1.0 - TONE_CURVE_SHOULDER) * over / (1.0 + over)
    } else {
        v.max(0.0)
    }
}

/// The sRGB transfer function (IEC 61966-2-1). It uses `libm` because `f64::powf` differs between platforms.
fn encode_srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The level of a large part of this radiance, beside a small one that is lighter.
    fn level(radiance: f32, film: Film) -> u8 {
        let mut all = vec![Vec3::splat(radiance); 1000];
        all[..20].fill(Vec3::splat(4.0));
        Picture::from_radiance([1000, 1], &all, film, 0.0).rgb[3 * 500]
    }

    #[test]
    fn photographs_are_exposed_for_large_light_parts_and_plain_pictures_are_not() {
        let photograph = |radiance| level(radiance, Film::Photographic);
        // What is twice too light is as light as what just fits; what is darker stays as it is.
        let fits = HIGHLIGHT / PHOTOGRAPHIC_EXPOSURE;
        assert!(photograph(2.0 * fits).abs_diff(photograph(fits)) <= 1);
        assert!(photograph(0.9 * fits) < photograph(fits));
        let ratio = f64::from(photograph(0.5 * fits)) / f64::from(photograph(fits));
        assert!(ratio < 0.8, "{ratio}");
        assert!(level(2.0 * fits, Film::Even) > photograph(2.0 * fits));
    }
}
