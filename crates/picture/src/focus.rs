//! Depth of field: what lies before or behind the focus is spread over a disc, as a lens does.
//!
//! The picture is spread after it was rendered, by the distance of what the middle of each pixel sees, so that it needs no more
//! rays (Potmesil and Chakravarty 1981). What a sharp edge hides stays hidden.

use crate::camera::Camera;
use crate::surface::{Met, Place};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Radius of the disc at twice the distance of the focus with a depth of field of 1, in heights of the picture.
const LARGEST_DISC: f32 = 0.10;
/// Largest radius of a disc, in heights of the picture.
const MAX_RADIUS: f32 = 0.02;
/// Share of what the picture shows that lies before the focus: it is on the near parts of the wood.
const FOCUS_QUANTILE: f64 = 0.3;

/// Distances from the camera along its view at the middles of pixels, m; infinite where nothing is.
fn depths(places: &[Place], camera: &Camera, centre: DVec3) -> Vec<f32> {
    let from = (centre - camera.origin).as_vec3();
    let forward = camera.forward.as_vec3();
    let depth = |place: &Place| match place.met {
        Met::Background => f32::INFINITY,
        _ => (place.position + from).dot(forward),
    };
    places.iter().map(depth).collect()
}

/// Spreads the pixels of a picture; `strength` is 0 to 1. Positions of places are relative to `centre`.
pub(crate) fn spread(
    pixels: &[Vec3],
    size: [usize; 2],
    (places, centre): (&[Place], DVec3),
    camera: &Camera,
    strength: f64,
) -> Vec<Vec3> {
    let depths = depths(places, camera, centre);
    let on_items = places.iter().zip(&depths);
    let mut items: Vec<f32> = on_items
        .filter(|(place, _)| matches!(place.met, Met::Item(_)))
        .map(|(_, &depth)| depth)
        .collect();
    if items.is_empty() {
        return pixels.to_vec();
    }
    items.sort_unstable_by(f32::total_cmp);
    let focus = items[(FOCUS_QUANTILE * (items.len() - 1) as f64) as usize];
    let height = size[1] as f32;
    let radius = |depth: f32| {
        // The background is a slow gradient: spread, it would only lose what edges before it share with it.
        let away = if depth.is_finite() {
            1.0 - focus / depth
        } else {
            0.0
        };
        (2.0 * LARGEST_DISC * strength as f32 * away.abs()).min(MAX_RADIUS) * height
    };
    let radii: Vec<f32> = depths.iter().map(|&d| radius(d)).collect();
    let reach = Reach::new(&radii, size);
    let pixel = |x: usize, y: usize| {
        let own = y * size[0] + x;
        let reach = reach.at(x, y);
        if reach == 0 {
            return pixels[own];
        }
        let (mut sum, mut total) = (Vec3::ZERO, 0.0);
        for b in (y as i64 - reach).max(0)..=(y as i64 + reach).min(size[1] as i64 - 1) {
            for a in (x as i64 - reach).max(0)..=(x as i64 + reach).min(size[0] as i64 - 1) {
                let (dx, dy) = (a - x as i64, b - y as i64);
                let at = b as usize * size[0] + a as usize;
                // What lies behind is not spread over what is before it.
                let wide = match depths[at] > depths[own] {
                    true if depths[at].is_infinite() => radii[own],
                    true => radii[at].min(radii[own]),
                    false => radii[at],
                };
                let wide = wide.max(0.5);
                let square = (dx * dx + dy * dy) as f32;
                if square < (wide + 0.5) * (wide + 0.5) {
                    let covered = (wide + 0.5 - square.sqrt()).min(1.0);
                    let weight = covered / (wide * wide);
                    sum += pixels[at] * weight;
                    total += weight;
                }
            }
        }
        sum / total
    };
    let pixel = &pixel;
    (0..size[1])
        .into_par_iter()
        .flat_map_iter(move |y| (0..size[0]).map(move |x| pixel(x, y)))
        .collect()
}

/// Side of the blocks of pixels whose largest radius is known, pixels.
const BLOCK: usize = 16;
/// Radius up to which a pixel is not spread: it covers its neighbours by less than can be seen.
const SHARP_RADIUS: f32 = 0.75;

/// How far around a pixel others are spread over it: not far in most of a picture.
struct Reach {
    /// Rows and columns of blocks with the largest radius in each or in one from which it may be reached, pixels.
    largest: Vec<f32>,
    columns: usize,
}

impl Reach {
    fn new(radii: &[f32], [width, height]: [usize; 2]) -> Reach {
        let columns = width.div_ceil(BLOCK);
        let rows = height.div_ceil(BLOCK);
        let mut own = vec![0.0f32; columns * rows];
        for (i, &radius) in radii.iter().enumerate() {
            let block = &mut own[i / width / BLOCK * columns + i % width / BLOCK];
            *block = block.max(radius);
        }
        let all = own.iter().copied().fold(0.0, f32::max);
        let blocks = (all.ceil() as usize).div_ceil(BLOCK);
        let around = |i: usize| {
            let (x, y) = (i % columns, i / columns);
            let rows = y.saturating_sub(blocks)..=(y + blocks).min(rows - 1);
            let near = rows.flat_map(|b| {
                let columns_near = x.saturating_sub(blocks)..=(x + blocks).min(columns - 1);
                columns_near.map(move |a| b * columns + a)
            });
            near.map(|block| own[block]).fold(0.0, f32::max)
        };
        Reach {
            largest: (0..own.len()).map(around).collect(),
            columns,
        }
    }

    /// The distance from which others may be spread over a pixel, pixels; 0 where it stays as it is.
    fn at(&self, x: usize, y: usize) -> i64 {
        let largest = self.largest[y / BLOCK * self.columns + x / BLOCK];
        match largest > SHARP_RADIUS {
            true => largest.ceil() as i64,
            false => 0,
        }
    }
}
