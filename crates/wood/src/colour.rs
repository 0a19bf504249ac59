//! Colours: linear numbers and their sRGB encoding (IEC 61966-2-1), and pictures of them.

use glam::DVec3;
use greenstick_geometry::{Metadata, MetadataEntry};

/// Returns an 8-bit sRGB colour as linear numbers.
pub fn linear_from_srgb(colour: [u8; 3]) -> [f64; 3] {
    colour.map(|c| {
        let v = f64::from(c) / 255.0;
        if v <= 0.040_45 {
            v / 12.92
        } else {
            libm::pow((v + 0.055) / 1.055, 2.4)
        }
    })
}

/// A linear number as 8-bit sRGB.
pub(crate) fn srgb_from_linear(v: f64) -> u8 {
    let v = v.clamp(0.0, 1.0);
    let encoded = if v <= 0.003_130_8 {
        12.92 * v
    } else {
        1.055 * libm::pow(v, 1.0 / 2.4) - 0.055
    };
    (encoded * 255.0 + 0.5) as u8
}

/// A linear colour as 8-bit sRGB.
pub(crate) fn srgb_bytes(linear: DVec3) -> [u8; 3] {
    linear.to_array().map(srgb_from_linear)
}

/// A picture of 8-bit sRGB colours.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RgbImage {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green and blue of each pixel, row by row from the top.
    pub rgb: Vec<u8>,
}

impl RgbImage {
    /// Encodes the picture as PNG. Returns nothing if `rgb` does not have the size of the picture.
    ///
    /// ```
    /// use greenstick_wood::colour::RgbImage;
    ///
    /// let white = RgbImage { width: 1, height: 1, rgb: vec![255; 3] };
    /// assert!(white.png().starts_with(b"\x89PNG"));
    /// ```
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
            let data = writer.write_image_data(&self.rgb);
            data.and_then(|()| writer.finish())
        });
        // Writing to memory cannot fail.
        match written {
            Ok(()) => bytes,
            Err(_) => Vec::new(),
        }
    }
}
