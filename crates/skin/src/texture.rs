//! Baking the appearance of the inner wood into textures for glTF: colour, normals and roughness.
//!
//! The image is two squares side by side. **Left**, u 0 to ½: the section (end grain), a square of side W about the
//! section's middle, x = (2u − ½) W, y = (v − ½) W. **Right**, u ½ to 1: the side grain, distance from the pith
//! r = (2u − 1) W and length along the grain s = v W, which repeats in v.
//!
//! In each square the outermost columns beside u = ½ repeat their neighbour, so that filtering across the seam shows
//! nothing of the other square.

use glam::DVec2;
use greenstick_geometry::{Cancelled, Context, ErrorKind};
use greenstick_wood::appearance::{WoodAppearance, WoodPoint, WoodSurface};
use greenstick_wood::rings::{RingSource, StemAddress};
use rayon::prelude::*;

/// The square of a section that a texture covers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SectionSquare {
    /// Its middle, grain (x, y), m.
    pub middle: DVec2,
    /// Its side, m.
    pub side: f64,
}

/// Encoded PNG files of one size, twice as wide as high.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WoodTextures {
    /// Base colour, 8-bit sRGB.
    pub color: Vec<u8>,
    /// Tangent-space normals in the convention of glTF 2.0 (§3.9.3): red towards +u, green towards −v.
    pub normal: Vec<u8>,
    /// Roughness in green, metalness (none) in blue.
    pub roughness: Vec<u8>,
}

/// Why there are no textures.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TextureError {
    /// The size is out of range.
    #[error(
        "a texture {size} pixels wide cannot be baked; the width must be even and {MIN_WIDTH} to {MAX_WIDTH}"
    )]
    Size {
        /// Width requested, pixels.
        size: u32,
    },
    /// The side of the squares is no length.
    #[error("the side of the texture's squares is {width} m; it must be a finite length above 0")]
    Width {
        /// Side requested, m, as text.
        width: String,
    },
    /// The PNG encoder failed.
    #[error("encoding the texture as PNG failed: {0}")]
    Encoding(String),
    /// The caller cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl TextureError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            TextureError::Cancelled(_) => ErrorKind::Cancelled,
            TextureError::Size { .. } => ErrorKind::Request,
            _ => ErrorKind::Work,
        }
    }
}

/// Least width of a texture, pixels.
const MIN_WIDTH: u32 = 8;
/// Greatest width of a texture, pixels.
const MAX_WIDTH: u32 = 16_384;
/// Columns on either side of the seam that repeat their neighbour.
const PADDING: u32 = 2;

/// Gives the ring coordinate and the angle (rad) at a point of a section, m from its pith.
pub type SectionAddress<'a> = &'a (dyn Fn(DVec2) -> (f64, f64) + Sync);

/// The wood that textures show.
#[derive(Clone, Copy)]
pub struct TexturedWood<'a> {
    /// The middle of the section's square, m from the pith.
    pub middle: DVec2,
    /// The address at each point of the section.
    pub section: SectionAddress<'a>,
    /// What the wood looks like.
    pub appearance: &'a WoodAppearance,
    /// Its annual rings.
    pub rings: &'a (dyn RingSource + Sync),
}

/// Bakes textures `size` pixels wide and half as high; `width` is the side W of both squares, m.
///
/// # Errors
/// [`TextureError`] where the size or width is out of range or the caller cancelled.
///
/// # Examples
/// ```
/// use greenstick_geometry::Context;
/// use greenstick_skin::texture::{TexturedWood, bake};
/// use greenstick_wood::appearance::WoodAppearance;
///
/// let appearance = WoodAppearance::softwood();
/// let wood = TexturedWood {
///     middle: glam::DVec2::ZERO,
///     section: &|p| (p.length() / 0.02, p.y.atan2(p.x)),
///     appearance: &appearance,
///     rings: &appearance.usual_rings(),
/// };
/// let textures = bake(16, 0.04, wood, &Context::quiet())?;
/// assert!(textures.color.starts_with(b"\x89PNG"));
/// # Ok::<(), greenstick_skin::texture::TextureError>(())
/// ```
pub fn bake(
    size: u32,
    width: f64,
    wood: TexturedWood,
    context: &Context,
) -> Result<WoodTextures, TextureError> {
    if !(MIN_WIDTH..=MAX_WIDTH).contains(&size) || !size.is_multiple_of(2) {
        return Err(TextureError::Size { size });
    }
    if !(width.is_finite() && width > 0.0) {
        return Err(TextureError::Width {
            width: width.to_string(),
        });
    }
    let half = size / 2;
    let texel = width / f64::from(half);
    // End grain is met at all lengths, side grain tiles: only that needs the period.
    let tiling = WoodAppearance {
        period: Some(width),
        ..wood.appearance.clone()
    };
    let baker = Baker {
        encode: Encoder::new(),
        wood,
        tiling,
        half,
        width,
        texel,
    };
    let row = size as usize * 3;
    let texels = (size * half) as usize;
    let [mut color, mut normal, mut roughness] = [(); 3].map(|()| vec![0; texels * 3]);
    let band = BAND * row;
    let bands =
        (color.chunks_mut(band).zip(normal.chunks_mut(band))).zip(roughness.chunks_mut(band));
    for (number, ((color, normal), roughness)) in bands.enumerate() {
        let first = (number * BAND) as u32;
        context.report(f64::from(first) / f64::from(half))?;
        let rows = color
            .par_chunks_mut(row)
            .zip(normal.par_chunks_mut(row))
            .zip(roughness.par_chunks_mut(row))
            .enumerate();
        rows.try_for_each(|(i, ((color, normal), roughness))| {
            context.check()?;
            baker.bake_row(first + i as u32, [color, normal, roughness]);
            Ok::<_, Cancelled>(())
        })?;
    }
    context.report(1.0)?;
    let (color, (normal, roughness)) = rayon::join(
        || png(size, half, &color, true),
        || {
            rayon::join(
                || png(size, half, &normal, false),
                || png(size, half, &roughness, false),
            )
        },
    );
    Ok(WoodTextures {
        color: color?,
        normal: normal?,
        roughness: roughness?,
    })
}

/// Rows that are baked between two reports; each row asks whether to go on.
const BAND: usize = 64;

/// What the rows of a texture are baked from.
struct Baker<'a> {
    encode: Encoder,
    wood: TexturedWood<'a>,
    /// The appearance with the period in which side grain repeats.
    tiling: WoodAppearance,
    /// Columns of each of the two squares.
    half: u32,
    /// Side of the squares, m.
    width: f64,
    /// Side of a texel, m.
    texel: f64,
}

impl Baker<'_> {
    /// Bakes a row into its colours, normals and roughnesses.
    fn bake_row(&self, row: u32, [color, normal, roughness]: [&mut [u8]; 3]) {
        let padding = PADDING.min(self.half / 4);
        let v = (f64::from(row) + 0.5) * self.texel;
        for column in 0..2 * self.half {
            let is_end_grain = column < self.half;
            let within = if is_end_grain {
                column.min(self.half - 1 - padding)
            } else {
                (column - self.half).max(padding)
            };
            let u = (f64::from(within) + 0.5) * self.texel;
            let (surface, rise) = if is_end_grain {
                let from_middle = DVec2::new(u, v) - DVec2::splat(self.width / 2.0);
                self.end_grain(self.wood.middle + from_middle)
            } else {
                self.side_grain(u, v)
            };
            // The normal leans away from where the relief rises; green counts against v.
            let length = (rise.length_squared() + 1.0).sqrt();
            let at = 3 * column as usize;
            color[at..at + 3].copy_from_slice(&surface.color.map(|c| self.encode.srgb(c)));
            normal[at..at + 3]
                .copy_from_slice(&[-rise.x, rise.y, 1.0].map(|n| byte(0.5 + 0.5 * n / length)));
            roughness[at..at + 3].copy_from_slice(&[255, byte(surface.roughness), 0]);
        }
    }

    /// Returns the surface at a point of the section, m from the pith, and the slope of its relief along u and v (m per m).
    fn end_grain(&self, across: DVec2) -> (WoodSurface, DVec2) {
        let surface = self.surface(self.wood.appearance, across, 0.0, 1.0);
        (surface, surface.slope.truncate())
    }

    /// Returns the surface at distance `radius` (m) from the pith and length `along` (m), and the slope of its relief along
    /// u and v.
    fn side_grain(&self, radius: f64, along: f64) -> (WoodSurface, DVec2) {
        let across = DVec2::new(radius, 0.0);
        let surface = self.surface(&self.tiling, across, along, 0.0);
        (surface, DVec2::new(surface.slope.x, surface.slope.z))
    }

    fn surface(
        &self,
        appearance: &WoodAppearance,
        across: DVec2,
        along: f64,
        end_grain: f64,
    ) -> WoodSurface {
        let (rho, angle) = (self.wood.section)(across);
        let address = StemAddress {
            rho,
            angle,
            across,
            along,
        };
        let point = WoodPoint { address, end_grain };
        appearance.surface_at(self.wood.rings, &point, self.texel)
    }
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

fn png(width: u32, height: u32, rgb: &[u8], srgb: bool) -> Result<Vec<u8>, TextureError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
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
            middle: DVec2::ZERO,
            section: &round,
            appearance: &appearance,
            rings: &appearance.usual_rings(),
        };
        bake(size, width, wood, &Context::quiet())
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
            assert_eq!((width, height), (64, 32));
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
            let start = ((y * width + width / 2) * 3) as usize;
            &pixels[start..start + (width / 2 * 3) as usize]
        };
        let change = |a: u32, b: u32| -> f64 {
            let sum: i32 = row(a)
                .iter()
                .zip(row(b))
                .map(|(&p, &q)| (i32::from(p) - i32::from(q)).abs())
                .sum();
            f64::from(sum) / f64::from(width / 2 * 3)
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
        let (width, _, pixels) = decode(&baked(256).color);
        let red = |x: u32, y: u32| i32::from(pixels[((y * width + x) * 3) as usize]);
        // Sapwood at r = 0.75 in all four directions, dark bark at the corners.
        for (x, y) in [(64 + 46, 64), (64 - 46, 64), (64, 64 + 46), (64, 64 - 46)] {
            assert!(red(x, y) > 130, "{} at {x} {y}", red(x, y));
        }
        for (x, y) in [(2, 2), (120, 2), (2, 125), (120, 125), (64, 64)] {
            assert!(red(x, y) < 125, "{} at {x} {y}", red(x, y));
        }
        // Beside the seam the columns repeat.
        for y in 0..128 {
            assert_eq!(red(126, y), red(127, y));
            assert_eq!(red(128, y), red(129, y));
        }
    }
}
