//! Contact sheets: many small pictures in one.

use crate::drawing::{CHARACTER_SIZE, draw_text};
use crate::picture::Picture;

/// White around every picture, pixels.
const GAP: u32 = 8;
/// Height of a line of text below a picture, pixels.
const LINE: u32 = CHARACTER_SIZE as u32 + 4;
/// Width of a sheet over its height, as of a page that lies.
const PROPORTION: f64 = 1.5;

/// A picture of a contact sheet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SheetCell {
    /// What stands below it.
    pub label: String,
    /// The picture.
    pub picture: Picture,
}

/// Lays pictures out in rows, each with its label below it. Every picture is given the same room, `size` pixels; what is
/// larger is cut off.
pub fn contact_sheet(cells: &[SheetCell], size: [u32; 2]) -> Picture {
    let step = [size[0] + GAP, size[1] + GAP + LINE];
    let count = cells.len().max(1);
    let across = (count as f64 * PROPORTION * f64::from(step[1]) / f64::from(step[0])).sqrt();
    let columns = (across.round() as usize).clamp(1, count);
    let rows = count.div_ceil(columns);
    let (width, height) = (columns as u32 * step[0] + GAP, rows as u32 * step[1] + GAP);
    let mut sheet = Picture {
        width,
        height,
        rgb: vec![255; 3 * width as usize * height as usize],
    };
    for (number, cell) in cells.iter().enumerate() {
        let column = (number % columns) as u32;
        let row = (number / columns) as u32;
        let (x, y) = (GAP + column * step[0], GAP + row * step[1]);
        copy(&cell.picture, &mut sheet, [x, y], size);
        let below = i64::from(y + size[1] + 2);
        draw_text(&mut sheet, i64::from(x), below, &cell.label);
    }
    sheet
}

/// Copies a picture into another with its top left corner at (x, y).
fn copy(from: &Picture, to: &mut Picture, [x, y]: [u32; 2], size: [u32; 2]) {
    let width = 3 * from.width.min(size[0]) as usize;
    for row in 0..from.height.min(size[1]) {
        let source = 3 * row as usize * from.width as usize;
        let target = 3 * ((y + row) as usize * to.width as usize + x as usize);
        to.rgb[target..target + width].copy_from_slice(&from.rgb[source..source + width]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_picture_has_its_place_and_its_label() {
        let cell = |k: u8| SheetCell {
            label: k.to_string(),
            picture: Picture {
                width: 30,
                height: 20,
                rgb: vec![k; 3 * 30 * 20],
            },
        };
        let cells: Vec<SheetCell> = (1..=7).map(cell).collect();
        let sheet = contact_sheet(&cells, [30, 20]);
        for k in 1..=7 {
            let pixels = sheet.rgb.chunks_exact(3).filter(|p| **p == [k; 3]).count();
            assert_eq!(pixels, 30 * 20, "{k}");
        }
        let dark = sheet.rgb.chunks_exact(3).filter(|p| **p == [50; 3]).count();
        assert!(dark > 7 * 20, "{dark} pixels of text");
        assert!(sheet.width > sheet.height);
        assert_eq!(contact_sheet(&[], [30, 20]).width, 46);
    }
}
