//! Depth of field: what lies before or behind the focus is spread over a disc, as a lens does.
//!
//! The picture is spread after it was rendered, by the distances of what its pixels see, so that it needs no more rays (Potmesil and
//! Chakravarty 1981). Pixels at edges are taken apart into what is near and what is seen past it, so that sharp edges before a
//! blurred ground stay smooth. What a near surface hides stays hidden.

use crate::camera::Camera;
use crate::layers::{Layer, Pixel};
use crate::surface::{Met, Place};
use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;
use std::f32::consts::PI;

/// Radius of the disc at twice the distance of the focus with a depth of field of 1, in heights of the picture.
const LARGEST_DISC: f32 = 0.10;
/// Largest radius of a disc, in heights of the picture.
const MAX_RADIUS: f32 = 0.02;
/// Share of what the picture shows in its middle that lies before the focus: it is on the near parts of the wood there. How far the
/// middle reaches, in heights of the picture.
const FOCUS_QUANTILE: f64 = 0.3;
const FOCUS_REACH: f32 = 0.3;
/// Radius up to which a disc is that of a pixel, and up to which a pixel stays as it is, pixels.
const PIXEL_RADIUS: f32 = 0.5;
const SHARP_RADIUS: f32 = 0.75;
/// Radius from which on discs are those of cells of two by two pixels, which nobody could tell from those of their pixels.
const COARSE_RADIUS: f32 = 4.0;
/// Radius from which on what is before cells is blurred as they are: what is sharper would have their edges.
const BLURRED_RADIUS: f32 = 1.5;
/// Difference of the nearness of pixels from that of their cell, as a part of it, up to which one surface is seen.
const ALIKE: f32 = 0.01;
/// Side of a cell, and of the blocks of pixels of which it is known what reaches into them, pixels.
const CELL: usize = 2;
const BLOCK: usize = 16;
/// Middle of a cell from that of its first pixel along one axis, pixels.
const MIDDLE: f32 = 0.5 * (CELL as f32 - 1.0);

/// Where a camera sees things.
pub(crate) struct Distances {
    from: Vec3,
    forward: Vec3,
}

impl Distances {
    /// Distances of places whose positions are relative to `centre`.
    pub fn new(camera: &Camera, centre: DVec3) -> Self {
        Distances {
            from: (centre - camera.origin).as_vec3(),
            forward: camera.forward.as_vec3(),
        }
    }

    /// One over the distance of a place from the camera along its view, 1/m; 0 where nothing is.
    pub fn nearness(&self, place: &Place) -> f32 {
        match place.met {
            Met::Background => 0.0,
            _ => 1.0 / (place.position + self.from).dot(self.forward),
        }
    }

    /// The distance (m) on which a camera focuses that sees these places, in rows; `None` where all of them are ground.
    pub fn focus(&self, places: &[Place], size: [usize; 2]) -> Option<f32> {
        let is_item = |i: &usize| matches!(places[*i].met, Met::Item(_));
        let is_in_middle = |i: &usize| {
            let off = [i % size[0], i / size[0]];
            let off = [0, 1].map(|k| off[k] as f32 - 0.5 * size[k] as f32);
            off[0].hypot(off[1]) < FOCUS_REACH * size[1] as f32
        };
        let distance = |i: usize| 1.0 / self.nearness(&places[i]);
        let items = || (0..places.len()).filter(is_item);
        let mut found: Vec<f32> = items().filter(is_in_middle).map(distance).collect();
        if found.is_empty() {
            found = items().map(distance).collect();
        }
        if found.is_empty() {
            return None;
        }
        let at = (FOCUS_QUANTILE * (found.len() - 1) as f64) as usize;
        Some(*found.select_nth_unstable_by(at, f32::total_cmp).1)
    }
}

/// The depth of field (0 to 1) of a lens whose aperture has a diameter (m), focused on a distance (m).
pub(crate) fn depth_of_field(aperture: f64, focus: f32, camera: &Camera) -> f64 {
    // A point at infinity covers a disc of the aperture's diameter in the plane of the focus.
    let height = 2.0 * f64::from(focus) * camera.tangents[1];
    let disc = 0.5 * aperture / height;
    disc / (2.0 * f64::from(LARGEST_DISC))
}

/// A lens that is focused on a distance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lens {
    /// The distance of what stays sharp, m.
    pub focus: f32,
    /// The depth of field, 0 to 1.
    pub strength: f64,
}

impl Lens {
    /// The radius of the disc over which what has a nearness is spread in a picture of a height, both in pixels.
    pub fn radius(&self, nearness: f32, height: usize) -> f32 {
        // The background is a slow gradient: spread, it would only lose what edges before it share with it.
        let away = match nearness > 0.0 {
            true => (1.0 - self.focus * nearness).abs(),
            false => 0.0,
        };
        (2.0 * LARGEST_DISC * self.strength as f32 * away).min(MAX_RADIUS) * height as f32
    }
}

/// What a camera is focused on in a picture.
pub(crate) struct Focus {
    pub lens: Lens,
    pub distances: Distances,
    /// Height of the picture, pixels.
    pub height: usize,
}

impl Focus {
    /// The radius of the disc over which what is seen at a place is spread, pixels.
    pub fn radius(&self, place: &Place) -> f32 {
        self.lens
            .radius(self.distances.nearness(place), self.height)
    }
}

/// What is spread over a disc: a layer of a pixel, or what layers of a cell have in common.
#[derive(Clone, Copy)]
struct Spot {
    layer: Layer,
    /// Radius of its disc, pixels.
    radius: f32,
}

impl Spot {
    const NONE: Spot = Spot {
        layer: Layer::NONE,
        radius: 0.0,
    };

    fn is_coarse(&self) -> bool {
        self.radius > COARSE_RADIUS
    }
}

/// What may reach into a block of pixels, from it or from around it.
#[derive(Clone, Copy, Default)]
struct Reach {
    /// Largest radius of the discs of pixels, pixels.
    fine: f32,
    /// The same of those of cells that lie before the focus: no others are spread over what is nearer.
    before: f32,
}

/// A picture whose pixels a lens spreads.
pub(crate) struct Spreading {
    size: [usize; 2],
    spots: Vec<[Spot; 2]>,
    /// Of each cell what of it lies before the focus and what lies behind, where their discs are coarse; the light and the shares
    /// of pixels are added up.
    cells: Vec<[Spot; 2]>,
    cell_columns: usize,
    /// The radiance that a lens shows in the middle of each cell that it only blurs: one surface, where nothing reaches that is sharper.
    blurred: Vec<Option<Vec3>>,
    reaches: Vec<Reach>,
    block_columns: usize,
}

impl Spreading {
    pub fn new(pixels: &[Pixel], size: [usize; 2], lens: &Lens) -> Self {
        let focus_nearness = 1.0 / lens.focus;
        let spot = |layer: Layer| Spot {
            layer,
            radius: lens.radius(layer.nearness, size[1]),
        };
        let spots: Vec<[Spot; 2]> = pixels.par_iter().map(|p| p.0.map(spot)).collect();
        let [columns, rows] = size;
        let cell_columns = columns.div_ceil(CELL);
        let cell = |i: usize| {
            let (x, y) = (i % cell_columns * CELL, i / cell_columns * CELL);
            let mut sums = [Spot::NONE; 2];
            for b in y..(y + CELL).min(rows) {
                for own in &spots[b * columns + x..b * columns + (x + CELL).min(columns)] {
                    for spot in own.iter().filter(|s| s.is_coarse()) {
                        let sum = &mut sums[usize::from(spot.layer.nearness < focus_nearness)];
                        let share = spot.layer.share;
                        sum.layer.light += spot.layer.light;
                        sum.layer.share += share;
                        sum.layer.nearness += share * spot.layer.nearness;
                        sum.radius += share * spot.radius;
                    }
                }
            }
            for sum in sums.iter_mut().filter(|s| s.layer.share > 0.0) {
                sum.layer.nearness /= sum.layer.share;
                sum.radius /= sum.layer.share;
            }
            sums
        };
        let count = cell_columns * rows.div_ceil(CELL);
        let cells: Vec<[Spot; 2]> = (0..count).into_par_iter().map(cell).collect();
        let mut spreading = Spreading {
            size,
            spots,
            cells,
            cell_columns,
            blurred: Vec::new(),
            reaches: Vec::new(),
            block_columns: columns.div_ceil(BLOCK),
        };
        spreading.reaches = spreading.reaches_into(&spreading.reaches_of_blocks());
        let cells = (0..spreading.cells.len()).into_par_iter();
        spreading.blurred = cells.map(|cell| spreading.blurred(cell)).collect();
        spreading
    }

    /// What reaches out of each block.
    fn reaches_of_blocks(&self) -> Vec<Reach> {
        let [columns, rows] = self.size;
        let mut blocks = vec![Reach::default(); self.block_columns * rows.div_ceil(BLOCK)];
        for (i, spots) in self.spots.iter().enumerate() {
            let block = i / columns / BLOCK * self.block_columns + i % columns / BLOCK;
            let reach = &mut blocks[block];
            for spot in spots.iter().filter(|s| s.layer.share > 0.0) {
                if !spot.is_coarse() {
                    reach.fine = reach.fine.max(spot.radius);
                }
            }
        }
        for (i, cell) in self.cells.iter().enumerate() {
            let (x, y) = (i % self.cell_columns * CELL, i / self.cell_columns * CELL);
            let reach = &mut blocks[y / BLOCK * self.block_columns + x / BLOCK];
            reach.before = reach.before.max(cell[0].radius);
        }
        blocks
    }

    /// What reaches into each block, from it or from as many around it as the largest disc covers.
    fn reaches_into(&self, own: &[Reach]) -> Vec<Reach> {
        let largest = own.iter().map(|r| r.fine.max(r.before)).fold(0.0, f32::max);
        let blocks = (largest.ceil() as usize + CELL).div_ceil(BLOCK);
        let (columns, rows) = (self.block_columns, own.len() / self.block_columns);
        let around = |i: usize| {
            let (x, y) = (i % columns, i / columns);
            let mut all = Reach::default();
            for b in y.saturating_sub(blocks)..=(y + blocks).min(rows - 1) {
                for a in x.saturating_sub(blocks)..=(x + blocks).min(columns - 1) {
                    let one = own[b * columns + a];
                    all.fine = all.fine.max(one.fine);
                    all.before = all.before.max(one.before);
                }
            }
            all
        };
        (0..own.len()).map(around).collect()
    }

    fn reach(&self, at: [usize; 2]) -> Reach {
        self.reaches[at[1] / BLOCK * self.block_columns + at[0] / BLOCK]
    }

    /// The radiance that a lens shows in the middle of a cell that it only blurs.
    fn blurred(&self, cell: usize) -> Option<Vec3> {
        let [columns, rows] = self.size;
        let (x, y) = (cell % self.cell_columns, cell / self.cell_columns);
        let [x, y] = [x, y].map(|k| k * CELL);
        let reach = self.reach([x, y]);
        if x + CELL > columns || y + CELL > rows || reach.fine > SHARP_RADIUS {
            return None;
        }
        let own = (self.cells[cell].iter()).find(|s| s.layer.share == (CELL * CELL) as f32)?;
        let nearness = own.layer.nearness;
        let is_alike = |pixel: usize| {
            let [seen, _] = &self.spots[(y + pixel / CELL) * columns + x + pixel % CELL];
            (seen.layer.nearness - nearness).abs() < ALIKE * nearness
        };
        if !(0..CELL * CELL).all(is_alike) {
            return None;
        }
        let mut sum = Gathered::of(*own);
        let middle = [x, y].map(|k| k as f32 + MIDDLE);
        self.add_cells(&mut sum, middle, own.radius.max(reach.before));
        Some(sum.radiance())
    }

    /// The radiance of a pixel among cells that a lens only blurs, linearly between their middles.
    fn between_cells(&self, at: [usize; 2]) -> Option<Vec3> {
        let cells = [self.cell_columns, self.cells.len() / self.cell_columns];
        let [(left, right, along), (top, bottom, down)] = [0, 1].map(|axis| {
            let place = ((at[axis] as f32 - MIDDLE) / CELL as f32).max(0.0);
            let first = place as usize;
            let second = (first + 1).min(cells[axis] - 1);
            (first, second, place - first as f32)
        });
        let cell = |x: usize, y: usize| self.blurred[y * self.cell_columns + x];
        let upper = cell(left, top)?.lerp(cell(right, top)?, along);
        let lower = cell(left, bottom)?.lerp(cell(right, bottom)?, along);
        Some(upper.lerp(lower, down))
    }

    /// The radiance of a pixel.
    pub fn pixel(&self, at: [usize; 2]) -> Vec3 {
        self.between_cells(at).unwrap_or_else(|| self.own_pixel(at))
    }

    /// The radiance of a pixel that a lens does not only blur.
    fn own_pixel(&self, at: [usize; 2]) -> Vec3 {
        let reach = self.reach(at);
        let own = &self.spots[at[1] * self.size[0] + at[0]];
        let widest = own[0].radius.max(own[1].radius);
        if widest.max(reach.fine).max(reach.before) <= SHARP_RADIUS {
            return own[0].layer.light + own[1].layer.light;
        }
        let seen = own.iter().filter(|s| s.layer.share > 0.0);
        seen.map(|spot| self.gathered(at, spot, reach) * spot.layer.share)
            .sum()
    }

    /// The radiance that a lens shows where a layer of a pixel is.
    fn gathered(&self, at: [usize; 2], own: &Spot, reach: Reach) -> Vec3 {
        let mut sum = Gathered::of(*own);
        let [columns, rows] = self.size;
        if !own.is_coarse() {
            sum.add(own, 0.0);
        }
        if reach.fine > SHARP_RADIUS {
            let near = (reach.fine + PIXEL_RADIUS).floor() as usize;
            for y in at[1].saturating_sub(near)..(at[1] + near + 1).min(rows) {
                for x in at[0].saturating_sub(near)..(at[0] + near + 1).min(columns) {
                    if [x, y] == at {
                        continue;
                    }
                    let square = (x.abs_diff(at[0]).pow(2) + y.abs_diff(at[1]).pow(2)) as f32;
                    for spot in &self.spots[y * columns + x] {
                        if spot.layer.share > 0.0 && !spot.is_coarse() {
                            sum.add(spot, square);
                        }
                    }
                }
            }
        }
        let behind = match own.radius < BLURRED_RADIUS {
            true => 0.0,
            false => own.radius,
        };
        let coarse = behind.max(reach.before);
        if coarse > 0.0 {
            self.add_cells(&mut sum, at.map(|k| k as f32), coarse);
        }
        sum.radiance()
    }

    /// Adds what cells with discs of up to a radius spread over a place, pixels.
    fn add_cells(&self, sum: &mut Gathered, at: [f32; 2], radius: f32) {
        let near = ((radius + PIXEL_RADIUS) / CELL as f32).ceil() as usize;
        let [x, y] = at.map(|k| k as usize / CELL);
        let last = [self.cell_columns, self.cells.len() / self.cell_columns];
        for b in y.saturating_sub(near)..(y + near + 1).min(last[1]) {
            let down = middle(b) - at[1];
            for a in x.saturating_sub(near)..(x + near + 1).min(last[0]) {
                let across = middle(a) - at[0];
                let square = across * across + down * down;
                for spot in &self.cells[b * self.cell_columns + a] {
                    if spot.layer.share > 0.0 {
                        sum.add(spot, square);
                    }
                }
            }
        }
    }
}

/// The place of the middle of a cell along one axis, pixels.
fn middle(cell: usize) -> f32 {
    (cell * CELL) as f32 + MIDDLE
}

/// What is gathered where a layer of a pixel is: light, and the share of the lens that it comes through.
struct Gathered {
    own: Spot,
    /// From what is nearer, and from the rest.
    before: Vec4,
    behind: Vec4,
}

impl Gathered {
    /// Nothing yet.
    fn of(own: Spot) -> Self {
        Gathered {
            own,
            before: Vec4::ZERO,
            behind: Vec4::ZERO,
        }
    }

    /// Adds what a spot spreads over a pixel; `square` is that of its distance, pixels.
    #[inline]
    fn add(&mut self, spot: &Spot, square: f32) {
        let is_before = spot.layer.nearness > self.own.layer.nearness;
        // What lies behind is not spread over what is before it.
        let wide = match is_before {
            true => spot.radius,
            false if spot.is_coarse() && self.own.radius < BLURRED_RADIUS => return,
            false if spot.layer.nearness == 0.0 => self.own.radius,
            false => spot.radius.min(self.own.radius),
        };
        let wide = wide.max(PIXEL_RADIUS);
        let reach = wide + PIXEL_RADIUS;
        if square >= reach * reach {
            return;
        }
        let covered = (reach - square.sqrt()).min(1.0);
        let weight = covered / (PI * wide * wide).max(1.0);
        let light = spot.layer.light.extend(spot.layer.share) * weight;
        match is_before {
            true => self.before += light,
            false => self.behind += light,
        }
    }

    /// What is nearer, over the rest.
    fn radiance(&self) -> Vec3 {
        let behind = match self.behind.w > 0.0 {
            true => self.behind.truncate() / self.behind.w,
            false => self.own.layer.light / self.own.layer.share,
        };
        let through = self.before.w.max(1.0);
        behind * (1.0 - self.before.w / through) + self.before.truncate() / through
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::View;

    const SIZE: [usize; 2] = [120, 300];
    const FOCUS: f32 = 1.0;
    /// Nearness of what is behind the focus.
    const FAR: f32 = 0.5;

    fn spread_all(pixel: impl Fn(usize, usize) -> Pixel, strength: f64) -> Vec<Vec3> {
        let pixels: Vec<Pixel> = (0..SIZE[0] * SIZE[1])
            .map(|i| pixel(i % SIZE[0], i / SIZE[0]))
            .collect();
        let lens = Lens {
            focus: FOCUS,
            strength,
        };
        let spreading = Spreading::new(&pixels, SIZE, &lens);
        (0..pixels.len())
            .map(|i| spreading.pixel([i % SIZE[0], i / SIZE[0]]))
            .collect()
    }

    #[test]
    fn a_lens_blurs_large_things_less() {
        let depth = |size: f64| {
            let points = [DVec3::ZERO, DVec3::splat(size)];
            let camera = Camera::new(&points, View::Automatic, None, DVec3::Y, [120, 90]).unwrap();
            let focus = camera.origin.distance(0.5 * points[1]) as f32;
            depth_of_field(0.024, focus, &camera)
        };
        assert!((depth(0.1) / depth(1.0) - 10.0).abs() < 1e-4);
        assert!((0.01..1.0).contains(&depth(0.3)), "{}", depth(0.3));
    }

    #[test]
    fn an_even_picture_stays_even_whatever_is_in_it() {
        let even = Vec3::new(0.2, 0.4, 0.6);
        let nearness = |x: usize, y: usize| match (x / 20 + y / 30) % 4 {
            0 => 2.0,
            1 => 1.0,
            2 => FAR,
            _ => 0.0,
        };
        for strength in [0.1, 0.5, 1.0] {
            let spread = spread_all(|x, y| Pixel::even(even, nearness(x, y)), strength);
            assert!(spread.iter().all(|p| p.abs_diff_eq(even, 1e-5)));
        }
    }

    #[test]
    fn a_point_out_of_focus_is_a_disc_of_its_light() {
        // Of pixels, and of cells.
        for strength in [0.1, 0.18] {
            let point = [60, 150];
            let lit = |x: usize, y: usize| [x, y] == point;
            let pixel = |x, y| Pixel::even(Vec3::splat(if lit(x, y) { 1.0 } else { 0.0 }), FAR);
            let spread = spread_all(pixel, strength);
            let radius = f64::from(LARGEST_DISC) * strength * SIZE[1] as f64;
            let (mut light, mut moment) = (0.0, 0.0);
            for (i, p) in spread.iter().enumerate() {
                let off = [i % SIZE[0], i / SIZE[0]].map(|k| k as f64);
                let square = (off[0] - 60.0).powi(2) + (off[1] - 150.0).powi(2);
                light += f64::from(p.x);
                moment += f64::from(p.x) * square;
            }
            assert!((light - 1.0).abs() < 0.1, "{strength}: {light}");
            // That of a disc is half the square of its radius.
            let found = (2.0 * moment / light).sqrt() / radius;
            assert!((0.85..1.35).contains(&found), "{strength}: {found}");
        }
    }

    /// Against the mean over the disc itself: pixels that are mixed between cells are as near to it as those that are gathered.
    #[test]
    fn pixels_between_blurred_cells_are_as_true_as_pixels_by_themselves() {
        let tile = |x: f32, y: f32| ((x / 20.0) as i32 + (y / 30.0) as i32) % 2;
        let pixels: Vec<Pixel> = (0..SIZE[0] * SIZE[1])
            .map(|i| tile((i % SIZE[0]) as f32, (i / SIZE[0]) as f32))
            .map(|light| Pixel::even(Vec3::splat(light as f32), FAR))
            .collect();
        let lens = Lens {
            focus: FOCUS,
            strength: 0.18,
        };
        let spreading = Spreading::new(&pixels, SIZE, &lens);
        let radius = lens.radius(FAR, SIZE[1]);
        let disc = |at: [usize; 2]| {
            let reach = (4.0 * radius) as i32;
            let (mut sum, mut count) = (0, 0);
            for v in -reach..=reach {
                for u in -reach..=reach {
                    let [u, v] = [u, v].map(|k| k as f32 / 4.0);
                    if u * u + v * v <= radius * radius {
                        // A pixel's own tile reaches half a pixel to either side of its middle.
                        sum += tile(at[0] as f32 + 0.5 + u, at[1] as f32 + 0.5 + v);
                        count += 1;
                    }
                }
            }
            sum as f32 / count as f32
        };
        let (mut between, mut own) = (0.0f32, 0.0f32);
        for y in 10..SIZE[1] - 10 {
            for x in 10..SIZE[0] - 10 {
                let expected = disc([x, y]);
                let mixed = spreading.between_cells([x, y]).expect("only blurred").x;
                between = between.max((mixed - expected).abs());
                own = own.max((spreading.own_pixel([x, y]).x - expected).abs());
            }
        }
        assert!(between < own && own < 0.1, "{between} {own}");
    }

    #[test]
    fn a_sharp_edge_before_a_blurred_ground_stays_smooth() {
        let ground = |x: usize| Vec3::splat(0.2 + 0.2 * (x % 2) as f32);
        let layer = |light: Vec3, share: f32, nearness: f32| Layer {
            light: light * share,
            share,
            nearness,
        };
        let pixel = |x: usize, _| match x {
            0..80 => Pixel::even(Vec3::ONE, 1.0),
            80 => Pixel([layer(Vec3::ONE, 0.5, 1.0), layer(ground(x), 0.5, FAR)]),
            _ => Pixel::even(ground(x), FAR),
        };
        let spread = spread_all(pixel, 0.2);
        let row: Vec<f32> = (70..90).map(|x| spread[150 * SIZE[0] + x].x).collect();
        assert!(row[..10].iter().all(|v| *v == 1.0), "{row:?}");
        assert!((row[10] - 0.65).abs() < 0.03, "{row:?}");
        assert!(row[11..].iter().all(|v| (v - 0.3).abs() < 0.05), "{row:?}");
    }

    /// What is blurred a little less than cells are has no sharp edge before what is blurred as they are.
    #[test]
    fn edges_between_pixels_and_cells_are_blurred() {
        let nearness = |radius: f32| 1.0 - radius / (0.2 * 0.3 * SIZE[1] as f32);
        for radius in [2.0, 3.0, 3.9, 4.1, 5.0] {
            let pixel = |x: usize, _| match x {
                0..60 => Pixel::even(Vec3::ONE, nearness(radius)),
                _ => Pixel::even(Vec3::ZERO, nearness(5.5)),
            };
            let spread = spread_all(pixel, 0.3);
            let row: Vec<f32> = (40..80).map(|x| spread[150 * SIZE[0] + x].x).collect();
            let steepest = row.windows(2).map(|w| w[0] - w[1]).fold(0.0, f32::max);
            assert!(steepest < 1.0 / radius, "{radius}: {row:?}");
            assert!(row.is_sorted_by(|a, b| *a > b - 0.02), "{radius}: {row:?}");
        }
    }

    #[test]
    fn what_is_before_the_focus_is_spread_over_what_is_sharp() {
        let pixel = |x: usize, _| match x {
            0..80 => Pixel::even(Vec3::ONE, 2.0),
            _ => Pixel::even(Vec3::ZERO, 1.0),
        };
        let spread = spread_all(pixel, 0.1);
        let at = |x: usize| spread[150 * SIZE[0] + x].x;
        // Half of it is seen at its edge.
        assert!((0.35..0.65).contains(&at(80)), "{}", at(80));
        assert!(at(81) < at(80) && at(88) == 0.0 && at(70) == 1.0);
    }
}
