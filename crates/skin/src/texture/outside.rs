//! Baking the outside of a stem that came without a material: bark around a round stem, planed wood around a board.

use super::error::{TextureError, check_size};
use super::images::{ImageSize, WoodTextures, bake_images, put};
use super::inside::TexturedWood;
use super::square::PlanedFaces;
use glam::{DVec2, DVec3};
use greenstick_geometry::Context;
use greenstick_wood::appearance::{
    BarkAppearance, BarkPoint, WoodAppearance, WoodPoint, planed, weathered,
};
use greenstick_wood::noise::NoiseMemory;
use greenstick_wood::rings::StemAddress;
use std::f64::consts::TAU;

/// Bakes bark about a stem of radius `radius` (m): a square, `size` pixels wide, of one turn about the pith (u from 0 to 1)
/// and a length of one circumference along the stem (v from 0 to 1). It repeats in both directions.
///
/// # Errors
/// [`TextureError`] where the size or the radius is out of range or the caller cancelled.
pub fn bake_bark(
    size: u32,
    bark: &BarkAppearance,
    radius: f64,
    context: &Context,
) -> Result<WoodTextures, TextureError> {
    let around = check_size(size, TAU * radius)?;
    let tiling = BarkAppearance {
        period: Some(around),
        ..bark.clone()
    };
    let texel = around / f64::from(size);
    let image = ImageSize {
        width: size,
        height: size,
    };
    bake_images(image, context, |row, mut images| {
        let mut memory = NoiseMemory::default();
        let along = (f64::from(row) + 0.5) * texel;
        for column in 0..size {
            let angle = TAU * (f64::from(column) + 0.5) / f64::from(size);
            let at = BarkPoint {
                angle,
                along,
                radius,
            };
            let surface = tiling.surface_in_row(&at, texel, &mut memory);
            let (sin, cos) = libm::sincos(angle);
            let around = surface.slope.dot(DVec3::new(-sin, cos, 0.0));
            let rise = DVec2::new(around, surface.slope.z);
            put(&mut images, column, &surface, rise);
        }
    })
}

/// Bakes the planed faces of a board: strips side by side, the faces towards −y and +y of its section, then those towards −x
/// and +x, over the length of `faces`, along which it repeats.
///
/// # Errors
/// [`TextureError`] where the size or the section is out of range or the caller cancelled.
pub fn bake_planed(
    size: u32,
    faces: &PlanedFaces,
    (wood, weather): (TexturedWood, bool),
    context: &Context,
) -> Result<WoodTextures, TextureError> {
    let square = faces.square;
    let perimeter = check_size(size, square.perimeter())?;
    let texel = perimeter / f64::from(size);
    let image = ImageSize {
        width: size,
        // Fibres are long: texels may be longer than wide.
        height: size / 2,
    };
    let appearance = WoodAppearance {
        period: Some(faces.length),
        ..wood.appearance.clone()
    };
    let row_height = faces.length / f64::from(image.height);
    bake_images(image, context, |row, mut images| {
        let mut memory = NoiseMemory::default();
        let along = (f64::from(row) + 0.5) * row_height;
        for column in 0..size {
            let (at, direction) = square.on_perimeter((f64::from(column) + 0.5) * texel);
            let across = faces.fibre_at(at, along) - wood.pith;
            let (rho, angle) = (wood.section)(across);
            let address = StemAddress {
                rho,
                angle,
                across,
                along,
            };
            let point = WoodPoint {
                address,
                end_grain: 0.0,
                facing: direction.perp(),
            };
            let torn = appearance.surface_in_row(wood.rings, &point, texel, &mut memory);
            let mut surface = planed(torn);
            if weather {
                surface.color = weathered(surface.color);
            }
            let rise = DVec2::new(surface.slope.truncate().dot(direction), surface.slope.z);
            put(&mut images, column, &surface, rise);
        }
    })
}

#[cfg(test)]
mod tests {
    use super::super::square::SectionSquare;
    use super::*;

    /// Brightness of the pixels of a colour texture, row by row, and its size.
    fn brightness(textures: &WoodTextures) -> (usize, usize, Vec<i32>) {
        let mut reader = png::Decoder::new(std::io::Cursor::new(&textures.color))
            .read_info()
            .unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        let sums = pixels.chunks_exact(3);
        let sums = sums
            .map(|p| p.iter().map(|&c| i32::from(c)).sum())
            .collect();
        (info.width as usize, info.height as usize, sums)
    }

    #[test]
    fn bark_goes_on_around_and_along() {
        for bark in [BarkAppearance::young(0.02), BarkAppearance::furrowed(0.2)] {
            let baked = bake_bark(256, &bark, 0.02, &Context::quiet()).unwrap();
            let (width, height, pixels) = brightness(&baked);
            assert_eq!((width, height), (256, 256));
            let rows = |a: usize, b: usize| -> i32 {
                let of = |x: usize| (pixels[a * width + x] - pixels[b * width + x]).abs();
                (0..width).map(of).sum()
            };
            let columns = |a: usize, b: usize| -> i32 {
                let of = |y: usize| (pixels[y * width + a] - pixels[y * width + b]).abs();
                (0..height).map(of).sum()
            };
            let usual_row: i32 = (0..height - 1).map(|y| rows(y, y + 1)).max().unwrap();
            let usual_column: i32 = (0..width - 1).map(|x| columns(x, x + 1)).max().unwrap();
            assert!(rows(height - 1, 0) <= usual_row);
            assert!(columns(width - 1, 0) <= usual_column);
            // Not because it is all one colour.
            assert!(rows(0, height / 2) > 256 && columns(0, width / 2) > 256);
        }
    }

    #[test]
    fn planed_faces_show_rings_where_they_lie() {
        // A board 20 cm wide and 4 cm thick, its pith 3 cm below it.
        let pith = DVec2::new(0.0, -0.05);
        let outer = 0.15;
        let wood = WoodAppearance {
            radius: outer,
            ..WoodAppearance::softwood()
        };
        let square = SectionSquare {
            size: DVec2::new(0.2, 0.04),
            ..SectionSquare::round(DVec2::ZERO, 0.204)
        };
        let faces = PlanedFaces::straight_grained(square);
        // Coordinates of the middle of the upper face, and of a point 5 cm aside.
        let middle = faces.coordinates(DVec3::new(0.0, 0.02, 0.0), DVec2::Y);
        let aside = faces.coordinates(DVec3::new(0.05, 0.02, 0.0), DVec2::Y);
        for (at, expected) in [
            (middle, DVec2::new(0.0, 0.02)),
            (aside, DVec2::new(0.05, 0.02)),
        ] {
            let (point, direction) = square.on_perimeter(at.x * square.perimeter());
            assert!(point.distance(expected) < 1e-12 && direction == DVec2::X);
        }
        let textured = TexturedWood {
            pith,
            section: &|p| (p.length() / outer, libm::atan2(p.y, p.x)),
            point: &|rho, angle| DVec2::from_angle(angle) * (outer * rho),
            appearance: &wood,
            rings: &wood.usual_rings(),
        };
        let baked = bake_planed(1024, &faces, (textured, false), &Context::quiet()).unwrap();
        let (width, height, pixels) = brightness(&baked);
        assert_eq!((width, height), (1024, 512));
        // Both sides of the upper face show the same rings, mirrored about the middle: their means over the length agree
        // better than those of other places.
        let column = |x: f64| -> f64 {
            let u = faces.coordinates(DVec3::new(x, 0.02, 0.0), DVec2::Y).x;
            let x = (u * width as f64) as usize;
            let sum: i32 = (0..height).map(|y| pixels[y * width + x]).sum();
            f64::from(sum) / height as f64
        };
        let difference = |shift: f64| -> f64 {
            let xs = (10..90).map(|i| f64::from(i) * 1e-3);
            xs.map(|x| (column(x) - column(-x - shift)).abs()).sum()
        };
        assert!(difference(0.0) < 0.7 * difference(4e-3));
    }
}
