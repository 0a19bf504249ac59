//! The three images of a texture: baking their rows in parallel, and encoding them as PNG.

use super::error::TextureError;
use glam::DVec2;
use greenstick_geometry::{Cancelled, Context};
use greenstick_wood::appearance::WoodSurface;
use rayon::prelude::*;
use std::sync::LazyLock;

/// Encoded PNG files of one size.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WoodTextures {
    /// Base colour, 8-bit sRGB.
    pub color: Vec<u8>,
    /// Tangent-space normals in the convention of glTF 2.0 (§3.9.3): red towards +u, green towards −v.
    pub normal: Vec<u8>,
    /// Roughness in green, metalness (none) in blue.
    pub roughness: Vec<u8>,
}

/// Pixels of an image.
#[derive(Debug, Clone, Copy)]
pub(super) struct ImageSize {
    pub width: u32,
    pub height: u32,
}

/// Rows that are baked between two reports; each row asks whether to go on.
const BAND: usize = 64;

/// Bakes the rows of the three images, and encodes them.
pub(super) fn bake_images(
    size: ImageSize,
    context: &Context,
    bake_row: impl Fn(u32, [&mut [u8]; 3]) + Sync,
) -> Result<WoodTextures, TextureError> {
    let row = size.width as usize * 3;
    let [mut color, mut normal, mut roughness] =
        [(); 3].map(|()| vec![0; row * size.height as usize]);
    let band = BAND * row;
    let bands =
        (color.chunks_mut(band).zip(normal.chunks_mut(band))).zip(roughness.chunks_mut(band));
    for (number, ((color, normal), roughness)) in bands.enumerate() {
        let first = (number * BAND) as u32;
        context.report(f64::from(first) / f64::from(size.height))?;
        let rows = color
            .par_chunks_mut(row)
            .zip(normal.par_chunks_mut(row))
            .zip(roughness.par_chunks_mut(row))
            .enumerate();
        rows.try_for_each(|(i, ((color, normal), roughness))| {
            context.check()?;
            bake_row(first + i as u32, [color, normal, roughness]);
            Ok::<_, Cancelled>(())
        })?;
    }
    context.report(1.0)?;
    let encoded = |rgb: &[u8], srgb| {
        context.check()?;
        png(size, rgb, srgb)
    };
    let (color, (normal, roughness)) = rayon::join(
        || encoded(&color, true),
        || rayon::join(|| encoded(&normal, false), || encoded(&roughness, false)),
    );
    Ok(WoodTextures {
        color: color?,
        normal: normal?,
        roughness: roughness?,
    })
}

/// Writes a surface, whose relief rises by `rise` along u and v (m per m), into a column of the rows of the three images.
pub(super) fn put(images: &mut [&mut [u8]; 3], column: u32, surface: &WoodSurface, rise: DVec2) {
    static ENCODE: LazyLock<Encoder> = LazyLock::new(Encoder::new);
    let [color, normal, roughness] = images;
    // The normal leans away from where the relief rises; green counts against v.
    let length = (rise.length_squared() + 1.0).sqrt();
    let at = 3 * column as usize;
    color[at..at + 3].copy_from_slice(&surface.color.map(|c| ENCODE.srgb(c)));
    normal[at..at + 3]
        .copy_from_slice(&[-rise.x, rise.y, 1.0].map(|n| byte(0.5 + 0.5 * n / length)));
    roughness[at..at + 3].copy_from_slice(&[255, byte(surface.roughness), 0]);
}

/// Converts 0 to 1 to a byte.
fn byte(v: f64) -> u8 {
    (v * 255.0 + 0.5) as u8
}

/// The sRGB transfer function (IEC 61966-2-1), by a table of the least linear value of each byte.
struct Encoder {
    /// Byte at the linear values i / 4096, as a first guess.
    guess: Vec<u8>,
    /// Least linear value of each byte.
    begins: [f64; 257],
}

impl Encoder {
    fn new() -> Encoder {
        let mut begins = [0.0; 257];
        for (i, b) in begins.iter_mut().enumerate().skip(1) {
            let v = (i as f64 - 0.5) / 255.0;
            *b = if v <= 0.040_45 {
                v / 12.92
            } else {
                libm::pow((v + 0.055) / 1.055, 2.4)
            };
        }
        let guess = (0..=4096)
            .map(|i| {
                let v = f64::from(i) / 4096.0;
                (begins[1..256].partition_point(|&b| b <= v)) as u8
            })
            .collect();
        Encoder { guess, begins }
    }

    fn srgb(&self, linear: f64) -> u8 {
        let v = linear.clamp(0.0, 1.0);
        let mut byte = self.guess[(v * 4096.0) as usize];
        while byte < 255 && self.begins[byte as usize + 1] <= v {
            byte += 1;
        }
        byte
    }
}

fn png(size: ImageSize, rgb: &[u8], srgb: bool) -> Result<Vec<u8>, TextureError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size.width, size.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    // Textures of noise hardly get smaller by more work.
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Up);
    if srgb {
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    }
    encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(rgb).and_then(|()| writer.finish()))
        .map_err(|e| TextureError::Encoding(e.to_string()))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick_geometry::CancelToken;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn baking_stops_within_a_band_of_rows() {
        let token = CancelToken::default();
        let context = Context::new(token.clone(), |_| ());
        let (size, baked) = (
            ImageSize {
                width: 8,
                height: 4096,
            },
            AtomicU32::new(0),
        );
        let made = bake_images(size, &context, |_, _| {
            if baked.fetch_add(1, Ordering::Relaxed) == 200 {
                token.cancel();
            }
        });
        assert!(matches!(made, Err(TextureError::Cancelled(_))), "{made:?}");
        // Rows that other threads had begun are finished.
        let baked = baked.into_inner();
        assert!((201..201 + BAND as u32).contains(&baked), "{baked} rows");
    }

    #[test]
    fn baking_stops_where_progress_is_reported() {
        let token = CancelToken::default();
        let stop = token.clone();
        let context = Context::new(token, move |p| {
            if p.overall >= 0.5 {
                stop.cancel();
            }
        });
        let last = AtomicU32::new(0);
        let size = ImageSize {
            width: 8,
            height: 4096,
        };
        let made = bake_images(size, &context, |row, _| {
            last.fetch_max(row, Ordering::Relaxed);
        });
        assert!(matches!(made, Err(TextureError::Cancelled(_))), "{made:?}");
        assert!(last.into_inner() <= 2048 + BAND as u32);
    }
}
