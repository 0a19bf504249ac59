//! Photographs: PNG and JPEG.

use png::{ColorType, Transformations};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// First bytes of a JPEG file.
pub(crate) const JPEG: [u8; 3] = [0xff, 0xd8, 0xff];
/// Most pixels of a photograph: twice the largest camera sensors.
const MAX_PIXELS: usize = 300_000_000;

/// A photograph as 8-bit sRGB colours.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Photograph {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green and blue of each pixel, row by row from the top.
    pub rgb: Vec<u8>,
}

/// Why bytes are no photograph that can be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PhotographError {
    /// The bytes are neither JPEG nor PNG, or they are damaged.
    #[error("{0}")]
    Invalid(String),
    /// There are too many pixels.
    #[error("it has {width} × {height} pixels; at most {} million are read", most / 1_000_000)]
    TooLarge {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
        /// Most pixels.
        most: usize,
    },
}

/// Reads a photograph: JPEG as the pixels are stored, whatever orientation the camera noted, or PNG of any depth and colour
/// type, of which what is transparent is white.
///
/// # Errors
/// [`PhotographError`] where the bytes are neither, or hold too many pixels.
pub fn read_photograph(bytes: &[u8]) -> Result<Photograph, PhotographError> {
    if bytes.starts_with(&JPEG) {
        decode_jpeg(bytes, MAX_PIXELS)
    } else {
        decode_png(bytes)
    }
}

/// Returns how an error of a decoder, or what a file lacks, makes it invalid.
pub(crate) fn invalid(problem: impl ToString) -> PhotographError {
    PhotographError::Invalid(problem.to_string())
}

pub(crate) fn check_size(width: usize, height: usize, most: usize) -> Result<(), PhotographError> {
    if width.saturating_mul(height) <= most {
        return Ok(());
    }
    Err(PhotographError::TooLarge {
        width,
        height,
        most,
    })
}

pub(crate) fn decode_jpeg(bytes: &[u8], most: usize) -> Result<Photograph, PhotographError> {
    let options = DecoderOptions::default().jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(invalid)?;
    let (width, height) = decoder
        .dimensions()
        .ok_or_else(|| invalid("it has no size"))?;
    check_size(width, height, most)?;
    let rgb = decoder.decode().map_err(invalid)?;
    Ok(Photograph {
        width: width as u32,
        height: height as u32,
        rgb,
    })
}

fn decode_png(bytes: &[u8]) -> Result<Photograph, PhotographError> {
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(invalid)?;
    let (width, height) = reader.info().size();
    check_size(width as usize, height as usize, MAX_PIXELS)?;
    let size = reader
        .output_buffer_size()
        .ok_or_else(|| invalid("it is too large"))?;
    let mut samples = vec![0; size];
    let info = reader.next_frame(&mut samples).map_err(invalid)?;
    samples.truncate(info.buffer_size());
    let over_white = |rgb: [u8; 3], alpha: u8| {
        let alpha = u32::from(alpha);
        rgb.map(|c| ((u32::from(c) * alpha + 255 * (255 - alpha) + 127) / 255) as u8)
    };
    let pixels = samples.chunks_exact(info.color_type.samples());
    let rgb = pixels.flat_map(|c| match info.color_type {
        ColorType::Grayscale => [c[0]; 3],
        ColorType::GrayscaleAlpha => over_white([c[0]; 3], c[1]),
        ColorType::Rgba => over_white([c[0], c[1], c[2]], c[3]),
        ColorType::Rgb | ColorType::Indexed => [c[0], c[1], c[2]],
    });
    Ok(Photograph {
        width,
        height,
        rgb: rgb.collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png(color: ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(data).unwrap();
        writer.finish().unwrap();
        bytes
    }

    fn two_pixels(rgb: [u8; 6]) -> Result<Photograph, PhotographError> {
        Ok(Photograph {
            width: 2,
            height: 1,
            rgb: rgb.to_vec(),
        })
    }

    #[test]
    fn png_files_of_any_kind_are_read() {
        let eight = png::BitDepth::Eight;
        let black_white = two_pixels([0, 0, 0, 255, 255, 255]);
        let grey = png(ColorType::Grayscale, eight, &[0, 255]);
        assert_eq!(decode_png(&grey), black_white);
        let wide = png(
            ColorType::Grayscale,
            png::BitDepth::Sixteen,
            &[0, 0, 255, 255],
        );
        assert_eq!(decode_png(&wide), black_white);
        let clear = png(ColorType::Rgba, eight, &[0, 0, 0, 255, 9, 9, 9, 0]);
        assert_eq!(decode_png(&clear), black_white);
        let red = png(ColorType::Rgb, eight, &[255, 0, 0, 0, 0, 255]);
        assert_eq!(decode_png(&red), two_pixels([255, 0, 0, 0, 0, 255]));
        assert!(decode_png(b"nothing").is_err());
    }

    #[test]
    fn jpeg_files_are_read() {
        // 16 × 8 pixels, the left half red and the right half blue, by Pillow at quality 95.
        let bytes = include_bytes!("../tests/data/red_and_blue.jpg");
        let image = decode_jpeg(bytes, MAX_PIXELS).unwrap();
        assert_eq!((image.width, image.height), (16, 8));
        let at = |x: usize, y: usize| &image.rgb[3 * (16 * y + x)..][..3];
        for (x, expected) in [(2, [255u8, 0, 0]), (13, [0, 0, 255])] {
            for (found, expected) in at(x, 4).iter().zip(expected) {
                assert!(found.abs_diff(expected) < 12, "{x}: {found}, {expected}");
            }
        }
        assert!(decode_jpeg(&bytes[..200], MAX_PIXELS).is_err());
        assert!(decode_jpeg(b"\xff\xd8\xff\xe0", MAX_PIXELS).is_err());
    }

    #[test]
    fn sizes_beyond_any_camera_are_refused_before_they_are_decoded() {
        assert!(check_size(20_000, 15_000, MAX_PIXELS).is_ok());
        assert!(
            check_size(usize::MAX, 2, MAX_PIXELS)
                .unwrap_err()
                .to_string()
                .contains("300 million")
        );
    }
}
