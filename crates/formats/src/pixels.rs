//! The images of textures: PNG, JPEG and WebP, with opacity.

use crate::photograph::{JPEG, PhotographError, decode_jpeg, invalid};
use greenstick_geometry::Pixels;
use image_webp::WebPDecoder;
use png::{ColorType, Transformations};
use std::io::Cursor;

/// Most pixels of an image: 8192 × 8192, which take 256 MiB.
const MAX_PIXELS: usize = 1 << 26;

/// Reads the image of a texture; its bytes decide whether it is PNG, JPEG or WebP. The size is checked before anything is decoded.
///
/// # Errors
/// [`PhotographError`] where the bytes are no such image, or it has too many pixels.
pub fn read_pixels(bytes: &[u8]) -> Result<Pixels, PhotographError> {
    let is_webp = bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP");
    if is_webp {
        read_webp(bytes)
    } else if bytes.starts_with(&JPEG) {
        let photograph = decode_jpeg(bytes, MAX_PIXELS)?;
        let opaque = |c: &[u8]| [c[0], c[1], c[2], 255];
        Ok(Pixels {
            width: photograph.width,
            height: photograph.height,
            rgba: photograph.rgb.chunks_exact(3).flat_map(opaque).collect(),
        })
    } else {
        read_png(bytes)
    }
}

fn check_size(width: usize, height: usize) -> Result<(), PhotographError> {
    crate::photograph::check_size(width, height, MAX_PIXELS)
}

fn read_webp(bytes: &[u8]) -> Result<Pixels, PhotographError> {
    let mut decoder = WebPDecoder::new(Cursor::new(bytes)).map_err(invalid)?;
    let (width, height) = decoder.dimensions();
    check_size(width as usize, height as usize)?;
    let channels = if decoder.has_alpha() { 4 } else { 3 };
    let mut samples = vec![0; channels * width as usize * height as usize];
    decoder.read_image(&mut samples).map_err(invalid)?;
    let rgba = if channels == 4 {
        samples
    } else {
        let opaque = |c: &[u8]| [c[0], c[1], c[2], 255];
        samples.chunks_exact(3).flat_map(opaque).collect()
    };
    Ok(Pixels {
        width,
        height,
        rgba,
    })
}

fn read_png(bytes: &[u8]) -> Result<Pixels, PhotographError> {
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(invalid)?;
    let (width, height) = reader.info().size();
    check_size(width as usize, height as usize)?;
    let size = reader
        .output_buffer_size()
        .ok_or_else(|| invalid("it is too large"))?;
    let mut samples = vec![0; size];
    let info = reader.next_frame(&mut samples).map_err(invalid)?;
    samples.truncate(info.buffer_size());
    let pixels = samples.chunks_exact(info.color_type.samples());
    let rgba = pixels.flat_map(|c| match info.color_type {
        ColorType::Grayscale => [c[0], c[0], c[0], 255],
        ColorType::GrayscaleAlpha => [c[0], c[0], c[0], c[1]],
        ColorType::Rgba => [c[0], c[1], c[2], c[3]],
        ColorType::Rgb | ColorType::Indexed => [c[0], c[1], c[2], 255],
    });
    Ok(Pixels {
        width,
        height,
        rgba: rgba.collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 × 1 pixels, opaque red and clear blue, as lossless WebP.
    fn webp() -> Vec<u8> {
        let mut bytes = Vec::new();
        image_webp::WebPEncoder::new(&mut bytes)
            .encode(&RED_AND_CLEAR, 2, 1, image_webp::ColorType::Rgba8)
            .unwrap();
        bytes
    }

    const RED_AND_CLEAR: [u8; 8] = [255, 0, 0, 255, 0, 0, 255, 0];

    #[test]
    fn all_three_kinds_are_read_with_their_opacity() {
        assert_eq!(read_pixels(&webp()).unwrap().rgba, RED_AND_CLEAR);
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(ColorType::Rgba);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&RED_AND_CLEAR).unwrap();
        writer.finish().unwrap();
        assert_eq!(read_pixels(&bytes).unwrap().rgba, RED_AND_CLEAR);
        let jpeg = include_bytes!("../tests/data/red_and_blue.jpg");
        let image = read_pixels(jpeg).unwrap();
        assert_eq!((image.width, image.height), (16, 8));
        assert!(image.rgba[0] > 240 && image.rgba[2] < 15 && image.rgba[3] == 255);
    }

    #[test]
    fn damaged_images_are_refused() {
        let whole = webp();
        for length in [0, 4, 12, 20, whole.len() - 3] {
            assert!(read_pixels(&whole[..length]).is_err(), "{length} bytes");
        }
        assert!(check_size(8193, 8192).is_err());
    }
}
