//! Photographs of sections.

use super::error::FileError;
use greenstick_fracture::cracks::measure::SectionPhotograph;
use greenstick_wood::colour::linear_from_srgb;
use png::{ColorType, Transformations};
use std::path::Path;

/// First bytes of a JPEG file.
const JPEG: [u8; 3] = [0xff, 0xd8, 0xff];

/// Reads a photograph (PNG, of any depth and colour type). What is transparent is white.
///
/// # Errors
/// [`FileError`] where there is no such file, or it is no PNG file.
pub fn read_photograph(path: &Path) -> Result<SectionPhotograph, FileError> {
    let bytes = std::fs::read(path).map_err(FileError::unreadable(path))?;
    decode(&bytes).map_err(|problem| FileError::Photograph {
        path: path.to_owned(),
        problem,
    })
}

fn decode(bytes: &[u8]) -> Result<SectionPhotograph, String> {
    if bytes.starts_with(&JPEG) {
        return Err("it is a JPEG picture".to_owned());
    }
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(|e| e.to_string())?;
    let size = reader.output_buffer_size().ok_or("it is too large")?;
    let mut samples = vec![0; size];
    let info = reader.next_frame(&mut samples).map_err(|e| e.to_string())?;
    samples.truncate(info.buffer_size());
    let colours = samples.chunks_exact(info.color_type.samples());
    let colours = colours.map(|c| {
        let (rgb, alpha) = match info.color_type {
            ColorType::Grayscale => ([c[0]; 3], 255),
            ColorType::GrayscaleAlpha => ([c[0]; 3], c[1]),
            ColorType::Rgba => ([c[0], c[1], c[2]], c[3]),
            ColorType::Rgb | ColorType::Indexed => ([c[0], c[1], c[2]], 255),
        };
        let opaque = f32::from(alpha) / 255.0;
        linear_from_srgb(rgb).map(|v| v as f32 * opaque + 1.0 - opaque)
    });
    let (width, height) = (info.width as usize, info.height as usize);
    SectionPhotograph::new(width, height, colours.collect()).map_err(|e| e.to_string())
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

    #[test]
    fn pictures_of_any_kind_are_read_as_linear_colours() {
        let two = |colours: [[f32; 3]; 2]| SectionPhotograph::new(2, 1, colours.to_vec()).unwrap();
        let eight = png::BitDepth::Eight;
        let black_white = two([[0.0; 3], [1.0; 3]]);
        assert_eq!(
            decode(&png(ColorType::Grayscale, eight, &[0, 255])),
            Ok(black_white.clone())
        );
        let wide = png(
            ColorType::Grayscale,
            png::BitDepth::Sixteen,
            &[0, 0, 255, 255],
        );
        assert_eq!(decode(&wide), Ok(black_white.clone()));
        let clear = png(ColorType::Rgba, eight, &[0, 0, 0, 255, 9, 9, 9, 0]);
        assert_eq!(decode(&clear), Ok(black_white));
        let red = png(ColorType::Rgb, eight, &[255, 0, 0, 0, 0, 255]);
        assert_eq!(decode(&red), Ok(two([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])));
        assert_eq!(
            decode(b"\xff\xd8\xff\xe0").unwrap_err(),
            "it is a JPEG picture"
        );
        assert!(decode(b"nothing").is_err());
    }
}
