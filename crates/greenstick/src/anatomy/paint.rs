//! Pictures of the inside: sections as contour, rings and zones, and the longitudinal section of forests-2023 Fig. 9.
//!
//! Rings are those of the data, ring by ring; streaks, vessels and rays between them come from the look of the wood.

use super::drawn::Look;
use super::{RingColours, Work, sections_at};
use crate::Error;
use glam::{DVec2, DVec3};
use greenstick_formats::Encoded;
use greenstick_geometry::{Bitmap, Context};
use greenstick_picture::Picture;
use greenstick_wood::anatomy::{Grid, LATEWOOD, RingNumbers, Section, fill};
use greenstick_wood::appearance::{WoodAppearance, WoodPoint};
use greenstick_wood::noise::smoothstep;
use greenstick_wood::tissue::Zone;
use rayon::prelude::*;

/// Sides of pictures of sections, pixels: at least.
const SIDE: usize = 640;
/// The longitudinal picture: pixels across the stem at least, and along it at most.
const ACROSS: usize = 256;
const ALONG: usize = 3000;
/// Samples along each side of a pixel where wood is shown.
const SAMPLES: usize = 2;
/// Linear colour of the paper.
const PAPER: DVec3 = DVec3::splat(0.93);
/// The paper's browns for latewood and earlywood. It prints (30, 92, 186) and (184, 215, 248), which are blues: OpenCV's
/// order, blue first.
const PUBLISHED: [[u8; 3]; 2] = [[186, 92, 30], [248, 215, 184]];
/// Colours of the zones from the pith outwards, told apart by people who see fewer hues too (Okabe and Ito 2008).
const ZONES: [[u8; 3]; 5] = [
    [213, 94, 0],
    [230, 159, 0],
    [240, 228, 66],
    [0, 158, 115],
    [86, 60, 40],
];

/// Colour of every pass, sRGB; black for what is no wood.
pub(super) fn palette(look: &Look, numbers: &RingNumbers) -> Vec<[u8; 3]> {
    let colours = look.colours;
    let look = &look.wood;
    let darker = latewood(look);
    let of = |pass: usize| {
        let late = numbers.latewood[pass];
        if colours == RingColours::Published {
            return PUBLISHED[usize::from(!late)];
        }
        let base = match numbers.zone[pass] {
            Zone::Pith => look.pith_color,
            Zone::Heartwood => look.heartwood_color,
            Zone::Sapwood => look.sapwood_color,
            Zone::Phloem => look.phloem_color,
            Zone::Bark => look.cork_color,
        };
        let wood = matches!(numbers.zone[pass], Zone::Heartwood | Zone::Sapwood);
        let shade = if late && wood { darker } else { DVec3::ONE };
        bytes(DVec3::from_array(base) * shade)
    };
    (0..numbers.ring.len())
        .map(|pass| if pass == 0 { [0; 3] } else { of(pass) })
        .collect()
}

/// What latewood makes of a colour.
fn latewood(look: &WoodAppearance) -> DVec3 {
    DVec3::from_array(look.latewood_color)
        / DVec3::from_array(look.sapwood_color).max(DVec3::splat(1e-3))
}

/// A linear colour as sRGB (IEC 61966-2-1).
fn bytes(linear: DVec3) -> [u8; 3] {
    linear.to_array().map(|v| {
        let v = v.clamp(0.0, 1.0);
        let coded = if v <= 0.003_130_8 {
            12.92 * v
        } else {
            1.055 * libm::pow(v, 1.0 / 2.4) - 0.055
        };
        (coded * 255.0 + 0.5) as u8
    })
}

/// An sRGB colour as linear numbers.
fn linear(colour: [u8; 3]) -> DVec3 {
    DVec3::from_array(colour.map(|c| {
        let v = f64::from(c) / 255.0;
        if v <= 0.040_45 {
            v / 12.92
        } else {
            libm::pow((v + 0.055) / 1.055, 2.4)
        }
    }))
}

impl Work<'_> {
    /// Linear colour of the wood at a point of a section, m; `end` is 1 on a cut across the grain and 0 along it.
    fn colour(&self, section: &Section, p: DVec2, end: f64, footprint: f64) -> DVec3 {
        let (rho, angle) = section.field.address(p);
        let rho = rho.min(1.0);
        let t = rho * f64::from(self.anatomy.rings);
        let part = t - t.floor();
        if self.request.colours == RingColours::Published {
            return linear(PUBLISHED[usize::from(part <= 1.0 - LATEWOOD && rho < 1.0)]);
        }
        let point = WoodPoint {
            ring: rho,
            angle,
            across: p - section.field.pith(),
            along: section.length,
            end_grain: end,
        };
        let colour = DVec3::from_array(self.look.wood.wood(&point, footprint).color);
        if rho >= self.look.wood.phloem || rho < self.look.wood.pith {
            return colour;
        }
        // Latewood darkens outwards and ends at once.
        let late = self.look.wood.latewood * smoothstep(1.0 - 2.0 * LATEWOOD, 0.95, part);
        colour * (DVec3::ONE + (latewood(&self.look.wood) - DVec3::ONE) * late)
    }
}

/// Contour, rings and zones of the section at the place, and of others at equal distances.
pub(super) fn sections(work: &Work, context: &Context) -> Result<Vec<Encoded>, Error> {
    let (low, high) = work.anatomy.whole;
    let others = work.request.sections - 1;
    let mut lengths = vec![work.anatomy.stem().location];
    lengths
        .extend((0..others).map(|k| low + (high - low) * (f64::from(k) + 0.5) / f64::from(others)));
    let side = work.anatomy.grid.pixel * work.anatomy.grid.count as f64;
    let fine = work.request.resolution.max(SIDE);
    // Eroded rings are those of the voxels, shown as squares.
    let (pixels, zoom) = match &work.erosion {
        Some(_) => (
            work.request.resolution,
            SIDE.div_ceil(work.request.resolution),
        ),
        None => (fine, 1),
    };
    let grid = Grid {
        count: pixels,
        pixel: side / pixels as f64,
    };
    let count = pixels * zoom;
    let mut files: Vec<Encoded> = Vec::new();
    for (i, section) in sections_at(work, &lengths).iter().enumerate() {
        context.report(i as f64 / lengths.len() as f64)?;
        let drawn = work.drawn(section, &grid);
        let zone = |p: u16| match p {
            0 => [255; 3],
            p => ZONES[usize::from(drawn.numbers.zone[usize::from(p)].code())],
        };
        let pass = |x: usize, y: usize| drawn.passes[y / zoom * grid.count + x / zoom];
        let name = format!("section_{:06.1}mm", section.length * 1e3);
        if files.iter().any(|f| f.name.starts_with(&name)) {
            continue;
        }
        let contour = |x: usize, y: usize| [u8::from(drawn.map.get(x / zoom, y / zoom)) * 255; 3];
        let rings = if work.erosion.is_some() {
            let colour = |p: u16| match p {
                0 => bytes(PAPER),
                p => drawn.palette[usize::from(p)],
            };
            picture(count, |x, y| colour(pass(x, y)))
        } else {
            wood_picture(work, section, &grid)
        };
        let pictures = [
            ("contour", picture(count, contour)),
            ("rings", rings),
            ("zones", picture(count, |x, y| zone(pass(x, y)))),
        ];
        files.extend(pictures.map(|(kind, picture)| Encoded {
            name: format!("{name}_{kind}.png"),
            bytes: picture.png(),
        }));
    }
    Ok(files)
}

/// A square picture, its rows from the top.
fn picture(count: usize, pixel: impl Fn(usize, usize) -> [u8; 3]) -> Picture {
    let rgb = (0..count)
        .rev()
        .flat_map(|y| (0..count).map(move |x| (x, y)))
        .flat_map(|(x, y)| pixel(x, y))
        .collect();
    Picture {
        width: count as u32,
        height: count as u32,
        rgb,
    }
}

fn wood_picture(work: &Work, section: &Section, grid: &Grid) -> Picture {
    let fine = Grid {
        count: grid.count * SAMPLES,
        pixel: grid.pixel / SAMPLES as f64,
    };
    let map: Bitmap = fill(&fine, &section.outline.loops);
    let rows: Vec<Vec<u8>> = (0..grid.count)
        .into_par_iter()
        .rev()
        .map(|y| {
            (0..grid.count)
                .flat_map(|x| {
                    let mut sum = DVec3::ZERO;
                    for (i, j) in (0..SAMPLES * SAMPLES).map(|k| (k % SAMPLES, k / SAMPLES)) {
                        let (u, v) = (SAMPLES * x + i, SAMPLES * y + j);
                        sum += if map.get(u, v) {
                            work.colour(section, fine.middle(u, v), 1.0, fine.pixel)
                        } else {
                            PAPER
                        };
                    }
                    bytes(sum / (SAMPLES * SAMPLES) as f64)
                })
                .collect()
        })
        .collect();
    Picture {
        width: grid.count as u32,
        height: grid.count as u32,
        rgb: rows.concat(),
    }
}

/// The stem cut in half along its pith, laid straight, the base on the left.
pub(super) fn longitudinal(work: &Work, context: &Context) -> Result<Encoded, Error> {
    let grid = &work.anatomy.grid;
    let side = grid.pixel * grid.count as f64;
    let length = work.anatomy.stem().grain.axis().length();
    let pixel = (side / work.request.resolution.max(ACROSS) as f64).max(length / ALONG as f64);
    let height = (side / pixel).round().max(1.0) as usize;
    let width = (length / pixel).round().max(1.0) as usize;
    let mut columns: Vec<Vec<[u8; 3]>> = Vec::with_capacity(width);
    const BATCH: usize = 64;
    for start in (0..width).step_by(BATCH) {
        context.report(start as f64 / width as f64)?;
        let batch: Vec<Vec<[u8; 3]>> = (start..width.min(start + BATCH))
            .into_par_iter()
            .map(|k| {
                column(
                    work,
                    length * (k as f64 + 0.5) / width as f64,
                    height,
                    pixel,
                )
            })
            .collect();
        columns.extend(batch);
    }
    let rgb = (0..height)
        .rev()
        .flat_map(|y| columns.iter().flat_map(move |c| c[y]))
        .collect();
    let picture = Picture {
        width: width as u32,
        height: height as u32,
        rgb,
    };
    Ok(Encoded {
        name: "longitudinal.png".to_owned(),
        bytes: picture.png(),
    })
}

/// A column of the longitudinal picture, the lowest pixel first: the line through the pith along the frame's x.
fn column(work: &Work, length: f64, height: usize, pixel: f64) -> Vec<[u8; 3]> {
    let paper = bytes(PAPER);
    let Some(section) = work.anatomy.section(length) else {
        return vec![paper; height];
    };
    // A board's pith may lie outside of it.
    let level = if work.is_board() {
        section.outline.centroid.y
    } else {
        section.field.pith().y
    };
    if work.erosion.is_some() {
        return eroded_column(work, &section, level, height, pixel);
    }
    let mut crossings: Vec<f64> = Vec::new();
    for outline in &section.outline.loops {
        for (i, a) in outline.iter().enumerate() {
            let b = outline[(i + 1) % outline.len()];
            if (a.y <= level) != (b.y <= level) {
                crossings.push(a.x + (b.x - a.x) * (level - a.y) / (b.y - a.y));
            }
        }
    }
    crossings.sort_by(f64::total_cmp);
    (0..height)
        .map(|y| {
            let x = (y as f64 + 0.5 - 0.5 * height as f64) * pixel;
            let inside = crossings.partition_point(|&c| c < x) % 2 == 1;
            if !inside {
                return paper;
            }
            let mut sum = DVec3::ZERO;
            for k in 0..SAMPLES {
                let part = ((k as f64 + 0.5) / SAMPLES as f64 - 0.5) * pixel;
                sum += work.colour(
                    &section,
                    DVec2::new(x + part, level),
                    0.0,
                    pixel / SAMPLES as f64,
                );
            }
            bytes(sum / SAMPLES as f64)
        })
        .collect()
}

/// A column of the longitudinal picture from eroded rings.
fn eroded_column(
    work: &Work,
    section: &Section,
    level: f64,
    height: usize,
    pixel: f64,
) -> Vec<[u8; 3]> {
    let grid = &work.anatomy.grid;
    let drawn = work.drawn(section, grid);
    let index = |v: f64| {
        let i = (v / grid.pixel + 0.5 * grid.count as f64).max(0.0) as usize;
        i.min(grid.count - 1)
    };
    let row = &drawn.passes[index(level) * grid.count..][..grid.count];
    (0..height)
        .map(|y| (y as f64 + 0.5 - 0.5 * height as f64) * pixel)
        .map(|x| match row[index(x)] {
            0 => bytes(PAPER),
            p => drawn.palette[usize::from(p)],
        })
        .collect()
}
