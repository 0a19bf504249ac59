//! Baking the wood inside: the section and the side grain.

use super::error::{TextureError, check_size};
use super::images::{ImageSize, WoodTextures, bake_images, put};
use super::square::SectionSquare;
use glam::{DVec2, DVec3};
use greenstick_geometry::Context;
use greenstick_wood::appearance::{WoodAppearance, WoodPoint, WoodSurface, torn};
use greenstick_wood::noise::NoiseMemory;
use greenstick_wood::rings::{RingSource, StemAddress};

/// Columns on either side of the seam that repeat their neighbour.
const PADDING: u32 = 2;

/// Gives the ring coordinate and the angle (rad) at a point of a section, m from its pith.
pub type SectionAddress<'a> = &'a (dyn Fn(DVec2) -> (f64, f64) + Sync);

/// Gives the point of a section, m from its pith, at a ring coordinate and an angle (rad).
pub type SectionPoint<'a> = &'a (dyn Fn(f64, f64) -> DVec2 + Sync);

/// The wood that textures show.
#[derive(Clone, Copy)]
pub struct TexturedWood<'a> {
    /// The pith in the coordinates of the section's square, m.
    pub pith: DVec2,
    /// The address at each point of the section.
    pub section: SectionAddress<'a>,
    /// The point of each address: the inverse.
    pub point: SectionPoint<'a>,
    /// What the wood looks like.
    pub appearance: &'a WoodAppearance,
    /// Its annual rings.
    pub rings: &'a (dyn RingSource + Sync),
}

/// Bakes textures `size` pixels wide, and as high as the square of the section is in them.
///
/// # Errors
/// [`TextureError`] where the size or the square is out of range or the caller cancelled.
///
/// # Examples
/// ```
/// use glam::DVec2;
/// use greenstick_geometry::Context;
/// use greenstick_skin::texture::{SectionSquare, TexturedWood, bake};
/// use greenstick_wood::appearance::WoodAppearance;
///
/// let appearance = WoodAppearance::softwood();
/// let wood = TexturedWood {
///     pith: DVec2::ZERO,
///     section: &|p| (p.length() / 0.02, p.y.atan2(p.x)),
///     point: &|rho, angle| DVec2::from_angle(angle) * (0.02 * rho),
///     appearance: &appearance,
///     rings: &appearance.usual_rings(),
/// };
/// let square = SectionSquare::round(DVec2::ZERO, 0.04);
/// let textures = bake(16, square, wood, &Context::quiet())?;
/// assert!(textures.color.starts_with(b"\x89PNG"));
/// # Ok::<(), greenstick_skin::texture::TextureError>(())
/// ```
pub fn bake(
    size: u32,
    square: SectionSquare,
    wood: TexturedWood,
    context: &Context,
) -> Result<WoodTextures, TextureError> {
    let width = check_size(size, square.side)?;
    let extent = square.extent();
    if !(extent.is_finite() && extent > 0.0) {
        return Err(TextureError::Width {
            width: extent.to_string(),
        });
    }
    let texel = extent / f64::from(size);
    let height = ((width / texel).round() as u32).max(1);
    // Rows are as high as the square needs for a whole number of them.
    let row = width / f64::from(height);
    let first_side = ((width / texel).round() as u32).clamp(1, size - 1);
    // End grain is met at all lengths, side grain tiles: only that needs the period.
    let tiling = WoodAppearance {
        period: Some(square.period()),
        ..wood.appearance.clone()
    };
    let angle = if square.rho.0 > 0.0 {
        let forward = square.middle - wood.pith;
        libm::atan2(forward.y, forward.x)
    } else {
        0.0
    };
    let (sin, cos) = libm::sincos(angle);
    let baker = Baker {
        wood,
        tiling,
        square,
        texel,
        row,
        angle,
        outwards: DVec2::new(cos, sin),
        size,
        first_side,
    };
    let size = ImageSize {
        width: size,
        height,
    };
    bake_images(size, context, |row, images| baker.bake_row(row, images))
}

/// Ring coordinate beyond which nothing reads the section's tile: it stays the colour of the outer bark.
const OUTSIDE: f64 = 1.08;

/// Distance from the middle of what the section holds, in its width or thickness, beyond which nothing reads the section's
/// tile: a board fills a strip of its square.
const BEYOND_THE_WOOD: f64 = 0.52;

/// What the rows of a texture are baked from.
struct Baker<'a> {
    wood: TexturedWood<'a>,
    /// The appearance with the period in which side grain repeats.
    tiling: WoodAppearance,
    square: SectionSquare,
    /// Width of a texel, m.
    texel: f64,
    /// Height of a row in the section's tile, m.
    row: f64,
    /// Angle about the pith at which the side grain is taken, rad.
    angle: f64,
    /// The direction from the pith at that angle.
    outwards: DVec2,
    /// Columns.
    size: u32,
    /// The first column of the side grain.
    first_side: u32,
}

impl Baker<'_> {
    /// Bakes a row into its colours, normals and roughnesses.
    fn bake_row(&self, row: u32, images: [&mut [u8]; 3]) {
        let padding = PADDING.min(self.first_side / 4);
        let v = (f64::from(row) + 0.5) * self.row;
        let [mut end_memory, mut side_memory] = [(); 2].map(|()| NoiseMemory::default());
        let mut images = images;
        for column in 0..self.size {
            let is_end_grain = column < self.first_side;
            let within = if is_end_grain {
                column.min(self.first_side - 1 - padding)
            } else {
                column.max((self.first_side + padding).min(self.size - 1))
            };
            let u = (f64::from(within) + 0.5) * self.texel;
            let (surface, rise) = if is_end_grain {
                let p = DVec2::new(u, v) - DVec2::splat(self.square.side / 2.0);
                self.end_grain(p + self.square.middle - self.wood.pith, &mut end_memory)
            } else {
                let rho = self.square.rho.0 + (u - self.square.side) / self.square.radius;
                self.side_grain(rho, v * SectionSquare::STRETCH, &mut side_memory)
            };
            put(&mut images, column, &surface, rise);
        }
    }

    /// Returns the surface at a point of the section, m from the pith, and the slope of its relief along u and v (m per m).
    fn end_grain(&self, across: DVec2, memory: &mut NoiseMemory) -> (WoodSurface, DVec2) {
        let wood = self.wood.appearance;
        let off = (across + self.wood.pith - self.square.middle).abs() / self.square.size;
        if off.max_element() > BEYOND_THE_WOOD {
            return (plain(wood.sapwood_color), DVec2::ZERO);
        }
        let (rho, angle) = (self.wood.section)(across);
        if rho > OUTSIDE && wood.cork < OUTSIDE {
            return (plain(wood.cork_color), DVec2::ZERO);
        }
        let address = StemAddress {
            rho,
            angle,
            across,
            along: 0.0,
        };
        let surface = self.surface(wood, address, 1.0, memory);
        (surface, surface.slope.truncate())
    }

    /// Returns the surface at a ring coordinate and length `along` (m), and the slope of its relief along u and v.
    fn side_grain(&self, rho: f64, along: f64, memory: &mut NoiseMemory) -> (WoodSurface, DVec2) {
        let address = StemAddress {
            rho,
            angle: self.angle,
            across: (self.wood.point)(rho, self.angle),
            along,
        };
        // The sides of splinters are torn; ends may be sawn.
        let surface = torn(self.surface(&self.tiling, address, 0.0, memory));
        let rise = surface.slope.truncate().dot(self.outwards);
        (surface, DVec2::new(rise, surface.slope.z))
    }

    fn surface(
        &self,
        appearance: &WoodAppearance,
        address: StemAddress,
        end_grain: f64,
        memory: &mut NoiseMemory,
    ) -> WoodSurface {
        // Side grain is shown as it lies in the plane through the pith.
        let facing = self.outwards.perp() * (1.0 - end_grain);
        let point = WoodPoint {
            address,
            end_grain,
            facing,
        };
        appearance.surface_in_row(self.wood.rings, &point, self.texel, memory)
    }
}

/// A surface of one colour without relief.
fn plain(color: [f64; 3]) -> WoodSurface {
    WoodSurface {
        color,
        roughness: 0.95,
        height: 0.0,
        slope: DVec3::ZERO,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const W: f64 = 0.06;

    fn round(p: DVec2) -> (f64, f64) {
        (p.length() / (W / 2.0), p.y.atan2(p.x))
    }

    fn decode(bytes: &[u8]) -> (u32, u32, Vec<u8>) {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        (info.width, info.height, pixels)
    }

    fn try_bake(size: u32, width: f64) -> Result<WoodTextures, TextureError> {
        let appearance = WoodAppearance::softwood();
        let wood = TexturedWood {
            pith: DVec2::ZERO,
            section: &round,
            point: &|rho, angle| DVec2::from_angle(angle) * (rho * W / 2.0),
            appearance: &appearance,
            rings: &appearance.usual_rings(),
        };
        bake(
            size,
            SectionSquare::round(DVec2::ZERO, width),
            wood,
            &Context::quiet(),
        )
    }

    fn baked(size: u32) -> WoodTextures {
        try_bake(size, W).unwrap()
    }

    #[test]
    fn sizes_and_channels_are_what_gltf_wants() {
        let textures = baked(64);
        for (i, bytes) in [&textures.color, &textures.normal, &textures.roughness]
            .into_iter()
            .enumerate()
        {
            let (width, height, pixels) = decode(bytes);
            // A square and, beside it, its half and a little more.
            assert_eq!((width, height), (64, 42));
            for p in pixels.chunks_exact(3) {
                match i {
                    // Normals have unit length and look outwards.
                    1 => {
                        let n = [p[0], p[1], p[2]].map(|c| f64::from(c) / 127.5 - 1.0);
                        let square: f64 = n.iter().map(|c| c * c).sum();
                        assert!((square - 1.0).abs() < 0.03 && n[2] > 0.0);
                    }
                    2 => assert!(p[2] == 0 && p[1] > 76),
                    // Wood is red before green before blue.
                    _ => assert!(p[0] > p[1] && p[1] > p[2]),
                }
            }
        }
        for size in [0, 7, 9, 16_386] {
            let refused = try_bake(size, W);
            assert_eq!(refused, Err(TextureError::Size { size }));
        }
        let refused = try_bake(64, f64::NAN);
        assert!(matches!(refused, Err(TextureError::Width { .. })));
    }

    #[test]
    fn the_side_grain_goes_on_from_its_last_row_to_its_first() {
        let (width, height, pixels) = decode(&baked(512).color);
        let row = |y: u32| {
            let (start, end) = (y * width + height, (y + 1) * width);
            &pixels[3 * start as usize..3 * end as usize]
        };
        let change = |a: u32, b: u32| -> f64 {
            let sum: i32 = row(a)
                .iter()
                .zip(row(b))
                .map(|(&p, &q)| (i32::from(p) - i32::from(q)).abs())
                .sum();
            f64::from(sum) / f64::from((width - height) * 3)
        };
        let inside = (0..height - 1).map(|y| change(y, y + 1)).sum::<f64>() / f64::from(height - 1);
        assert!(
            change(height - 1, 0) < 2.0 * inside + 0.5,
            "{} {inside}",
            change(height - 1, 0)
        );
        // Not because all rows are alike.
        assert!(
            change(0, height / 2) > 3.0 * inside,
            "{} {inside}",
            change(0, height / 2)
        );
    }

    #[test]
    fn the_section_is_round_and_lies_where_the_coordinates_say() {
        let (width, side, pixels) = decode(&baked(256).color);
        assert_eq!(side, 168);
        let red = |x: u32, y: u32| i32::from(pixels[((y * width + x) * 3) as usize]);
        // Sapwood at r = 0.75 in all four directions, dark bark at the corners.
        for (x, y) in [(84 + 61, 84), (84 - 61, 84), (84, 84 + 61), (84, 84 - 61)] {
            assert!(red(x, y) > 130, "{} at {x} {y}", red(x, y));
        }
        for (x, y) in [(2, 2), (160, 2), (2, 165), (160, 165), (84, 84)] {
            assert!(red(x, y) < 125, "{} at {x} {y}", red(x, y));
        }
        // Beside the seam the columns repeat.
        for y in 0..side {
            assert_eq!(red(side - 2, y), red(side - 1, y));
            assert_eq!(red(side, y), red(side + 1, y));
        }
    }

    #[test]
    fn a_row_shows_what_single_points_show() {
        let wood = WoodAppearance::ring_porous();
        let rings = wood.usual_rings();
        let mut memory = NoiseMemory::default();
        for i in 0..2000 {
            let across = DVec2::new(f64::from(i) * 1.5e-5, 2e-3);
            let address = StemAddress {
                rho: across.length() / wood.radius,
                angle: libm::atan2(across.y, across.x),
                across,
                along: 0.01,
            };
            let at = WoodPoint {
                address,
                end_grain: 0.0,
                facing: DVec2::Y,
            };
            let alone = wood.surface_at(&rings, &at, 1e-5);
            assert_eq!(wood.surface_in_row(&rings, &at, 1e-5, &mut memory), alone);
        }
    }
}
