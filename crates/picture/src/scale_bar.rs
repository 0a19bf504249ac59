//! A bar of known length below a picture.

use crate::drawing::{CHARACTER_SIZE, Pen, TEXT_COLOUR, draw_text};
use crate::picture::Picture;

/// Greatest length of the bar, as a part of the picture's width.
const MAX_BAR_SHARE: f64 = 0.4;
/// Distance of the bar from the edges, and height of its ends, pixels.
const MARGIN: i64 = 14;
const END_HEIGHT: f64 = 12.0;
/// Height of the band that is added, pixels.
const BAND_HEIGHT: i64 = 2 * MARGIN + CHARACTER_SIZE;

impl Picture {
    /// Adds a band below the picture with a scale bar of a round length and that length, for pixels that are `pixel_size` m
    /// wide. A picture that is too narrow for bar and text stays as it is, and so does one whose scale is no positive number.
    ///
    /// ```
    /// use greenstick_picture::Picture;
    ///
    /// let mut picture = Picture { width: 400, height: 300, rgb: vec![255; 3 * 400 * 300] };
    /// assert_eq!(picture.add_scale_bar(1e-3), Some("10 cm".to_owned()));
    /// assert_eq!((picture.width, picture.height), (400, 344));
    /// ```
    pub fn add_scale_bar(&mut self, pixel_size: f64) -> Option<String> {
        let longest = MAX_BAR_SHARE * f64::from(self.width) * pixel_size;
        if !(longest > 0.0 && longest.is_finite()) {
            return None;
        }
        let length = round_below(longest);
        let label = length_label(length);
        let pixels = length / pixel_size;
        let width = 3 * MARGIN + pixels as i64 + label.len() as i64 * CHARACTER_SIZE;
        if width > i64::from(self.width) {
            return None;
        }
        // The band continues the paper, which is the colour of the last corner.
        let row = 3 * self.width as usize;
        let paper: [u8; 3] = match self.rgb.last_chunk() {
            Some(corner) if self.rgb.len() == row * self.height as usize => *corner,
            _ => return None,
        };
        let band = paper.repeat(self.width as usize * BAND_HEIGHT as usize);
        self.rgb.extend(band);
        let middle = (i64::from(self.height) + BAND_HEIGHT / 2) as f64;
        self.height += BAND_HEIGHT as u32;
        let [start, end] = [MARGIN as f64, MARGIN as f64 + pixels];
        let pen = Pen {
            width: 3,
            colour: TEXT_COLOUR,
        };
        pen.draw(self, [start, middle], [end, middle]);
        for x in [start, end] {
            let half = 0.5 * END_HEIGHT;
            pen.draw(self, [x, middle - half], [x, middle + half]);
        }
        let x = end as i64 + MARGIN;
        draw_text(self, x, middle as i64 - CHARACTER_SIZE / 2, &label);
        Some(label)
    }
}

/// The greatest of 1, 2 and 5 times a power of ten that is not above `length`.
fn round_below(length: f64) -> f64 {
    let power = libm::pow(10.0, libm::floor(libm::log10(length)));
    [5.0, 2.0]
        .map(|f| f * power)
        .into_iter()
        .find(|l| *l <= length * (1.0 + 1e-9))
        .unwrap_or(power)
}

/// A length in m as text in the unit in which it is at least 1.
fn length_label(length: f64) -> String {
    let (number, unit) = match length {
        l if l >= 0.999 => (l, "m"),
        l if l >= 0.00999 => (l * 1e2, "cm"),
        l if l >= 0.000_999 => (l * 1e3, "mm"),
        l => (l * 1e6, "um"),
    };
    format!("{number:.0} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_is_as_long_as_it_says() {
        for (pixel_size, label, metres) in [
            (1.1e-4, "2 cm", 0.02),
            (4.3e-3, "1 m", 1.0),
            (5e-6, "1 mm", 1e-3),
            (0.1, "20 m", 20.0),
        ] {
            let (width, height) = (600_u32, 20_u32);
            let mut picture = Picture {
                width,
                height,
                rgb: vec![240; 3 * 600 * 20],
            };
            assert_eq!(picture.add_scale_bar(pixel_size).unwrap(), label);
            let row = (height as usize + 22) * 600;
            // Up to half way between bar and text.
            let end = 14 + (metres / pixel_size) as usize + 7;
            let dark = (0..end).filter(|x| picture.rgb[3 * (row + x)] == TEXT_COLOUR[0]);
            let pixels = dark.clone().max().unwrap() - dark.min().unwrap();
            // The ends are drawn 3 pixels wide about the ends of the length.
            let off = pixels as f64 - 2.0 - metres / pixel_size;
            assert!(off.abs() <= 1.0, "{label}: {pixels} pixels");
        }
        let mut narrow = Picture {
            width: 60,
            height: 1,
            rgb: vec![0; 180],
        };
        assert_eq!(narrow.add_scale_bar(1e-3), None);
        assert_eq!(narrow.add_scale_bar(f64::NAN), None);
        assert_eq!(narrow.height, 1);
    }
}
