//! Finished pictures: tone mapping and PNG.

use glam::DVec3;
use greenstick_geometry::{Metadata, MetadataEntry};

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
const TONE_CURVE_SHOULDER: f64 = 0.65;

impl Picture {
    /// Tone-maps linear radiance.
    pub(crate) fn from_radiance(width: u32, height: u32, radiance: &[DVec3]) -> Picture {
        let rgb = radiance
            .iter()
            .flat_map(|l| l.to_array())
            .map(|v| {
                let mapped = if v > TONE_CURVE_SHOULDER {
                    let over = (v - TONE_CURVE_SHOULDER) / (1.0 - TONE_CURVE_SHOULDER);
                    TONE_CURVE_SHOULDER + (1.0 - TONE_CURVE_SHOULDER) * over / (1.0 + over)
                } else {
                    v.max(0.0)
                };
                (encode_srgb(mapped) * 255.0 + 0.5) as u8
            })
            .collect();
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

/// The sRGB transfer function (IEC 61966-2-1). It uses `libm` because `f64::powf` differs between platforms.
fn encode_srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
    }
}
