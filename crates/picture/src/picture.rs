//! The finished picture: tone mapping and PNG.

use glam::DVec3;

/// A picture: 8-bit sRGB, rows from the top, three bytes per pixel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green and blue of each pixel.
    pub rgb: Vec<u8>,
}

/// Up to here the tone curve is a straight line, so that the colours of wood stay what they are; above it bends
/// towards white.
const SHOULDER: f64 = 0.65;

impl Picture {
    /// Tone-maps linear light.
    pub(crate) fn develop(width: u32, height: u32, light: &[DVec3]) -> Picture {
        let rgb = light
            .iter()
            .flat_map(|l| l.to_array())
            .map(|v| {
                let bent = if v > SHOULDER {
                    let over = (v - SHOULDER) / (1.0 - SHOULDER);
                    SHOULDER + (1.0 - SHOULDER) * over / (1.0 + over)
                } else {
                    v.max(0.0)
                };
                (encode(bent) * 255.0 + 0.5) as u8
            })
            .collect();
        Picture { width, height, rgb }
    }

    /// The picture as a PNG file, sRGB.
    pub fn png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let written = encoder.write_header().and_then(|mut writer| {
            writer
                .write_image_data(&self.rgb)
                .and_then(|()| writer.finish())
        });
        // Memory takes every byte, and `rgb` has the size that `render` gave it; only a caller who changed the public
        // fields so that they contradict each other gets nothing.
        match written {
            Ok(()) => bytes,
            Err(_) => Vec::new(),
        }
    }
}

/// The sRGB transfer function (IEC 61966-2-1). `libm`, because the standard library's power differs by platform.
fn encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
    }
}
