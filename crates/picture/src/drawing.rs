//! Lines and text in a [`Picture`].

use crate::picture::Picture;

/// Colour of text.
pub(crate) const TEXT_COLOUR: [u8; 3] = [50, 50, 50];
/// Width and height of a character, pixels.
pub(crate) const CHARACTER_SIZE: i64 = 16;

/// Sets a pixel, if it is in the picture.
fn set_pixel(to: &mut Picture, x: i64, y: i64, colour: [u8; 3]) {
    if x < 0 || y < 0 || x >= i64::from(to.width) || y >= i64::from(to.height) {
        return;
    }
    let at = 3 * (y as usize * to.width as usize + x as usize);
    to.rgb[at..at + 3].copy_from_slice(&colour);
}

/// A pen for straight lines.
pub(crate) struct Pen {
    /// Width, pixels.
    pub width: i64,
    /// Colour, sRGB.
    pub colour: [u8; 3],
}

impl Pen {
    /// Draws a line between two pixels.
    pub fn draw(&self, to: &mut Picture, start: [f64; 2], end: [f64; 2]) {
        let (dx, dy) = (end[0] - start[0], end[1] - start[1]);
        let steps = dx.abs().max(dy.abs()).ceil().clamp(1.0, 20_000.0);
        let half = (self.width - 1) / 2;
        for k in 0..=steps as i64 {
            let fraction = k as f64 / steps;
            let (x, y) = (start[0] + dx * fraction, start[1] + dy * fraction);
            for a in 0..self.width {
                for b in 0..self.width {
                    let (px, py) = (x.round() as i64 + a - half, y.round() as i64 + b - half);
                    set_pixel(to, px, py, self.colour);
                }
            }
        }
    }
}

/// Draws text with its top left corner at (x, y).
pub(crate) fn draw_text(to: &mut Picture, x: i64, y: i64, text: &str) {
    for (k, c) in text.chars().enumerate() {
        let glyph = font8x8::legacy::BASIC_LEGACY
            .get(c as usize)
            .copied()
            .unwrap_or_default();
        for row in 0..CHARACTER_SIZE {
            for column in 0..CHARACTER_SIZE {
                if glyph[(row * 8 / CHARACTER_SIZE) as usize] >> (column * 8 / CHARACTER_SIZE) & 1
                    == 1
                {
                    set_pixel(
                        to,
                        x + k as i64 * CHARACTER_SIZE + column,
                        y + row,
                        TEXT_COLOUR,
                    );
                }
            }
        }
    }
}
