//! A face on which cracks are placed: that of a break, or a sawn end.

use super::look::WoodLook;
use super::meshes::{DrawnBreak, DrawnScene, Shading, Vertex};
use glam::{Affine3A, DMat3, DVec3, Vec2, Vec3};
use rayon::iter::ParallelIterator;
use rayon::slice::ParallelSlice;

/// Half the side of the map of heights, radii.
const MAP_HALF: f32 = 1.5;
/// Cells of the map of heights along a side.
const CELLS: usize = 40;
/// Cells to every side over which heights are averaged.
const REACH: i32 = 2;
/// Corners of triangles whose highest points one task finds.
const CORNERS_OF_A_TASK: usize = 1 << 16;
/// Steps in which a ray is followed over the face.
const STEPS: u16 = 256;

/// How far from the end (radii) wood is looked at for where the end lies.
const END_ZONE: f32 = 1.0;
/// Cosine to the grain above which a triangle is of a sawn end, and the least part of the section that such triangles must be.
const FACING: f32 = 0.8;
const LEAST_END: f32 = 0.4;
/// How far from the outmost point an end that is no flat face is taken to be sawn off, radii.
const SAWN_OFF: f32 = 0.25;
/// Determinant over the cube of the trace below which points lie in a plane.
const FLAT: f64 = 1e-9;

/// A place in the section: ring coordinate, and angle about the pith, rad.
pub type Polar = (f32, f32);

/// The face on which cracks are drawn, that of the piece below a break or a sawn end: how high it is over each place of the section.
#[derive(Debug, Clone, PartialEq)]
pub struct CrackFace {
    pub(super) at: DrawnBreak,
    /// Where the axis is, moved with the piece.
    place: Vec3,
    /// Size of the section here over that in grain coordinates.
    scale: f32,
    /// 1 where the face looks along the stem, −1 where it looks back to its base, as the end there does.
    sign: f32,
    look: WoodLook,
    /// Half the side of the map, m.
    half: f32,
    heights: Vec<f32>,
}

impl CrackFace {
    /// The face below a break of a scene; none where there is no such break.
    pub fn new(scene: &DrawnScene, number: usize) -> Option<Self> {
        let (at, look) = (*scene.breaks.get(number)?, scene.woods.get(number)?.clone());
        let place = scene.break_place(number);
        scene.piece_below(number)?;
        let heights = scene.surveyed().faces.get(number)?.clone();
        Some(CrackFace {
            at,
            place,
            scale: 1.0,
            sign: 1.0,
            look,
            half: MAP_HALF * at.radius,
            heights,
        })
    }

    /// An end of the stem, the far one, beyond the last break, or that at the base, as the wood there lies; none where there is no break.
    /// Where it is no flat face, it is a plane across the stem where that is sawn off before it cracks, or near there.
    pub fn end(scene: &DrawnScene, number: usize, far: bool) -> Option<Self> {
        let (at, look) = (*scene.breaks.get(number)?, scene.woods.get(number)?.clone());
        let (piece, sign) = match far {
            true => (scene.last_piece()?, 1.0),
            false => (scene.first_piece()?, -1.0),
        };
        let piece = piece as f32;
        let of_piece = |v: &&Vertex| v.zone_piece[1] == piece && v.grain[3] > 0.5;
        let vertices = || scene.vertices.iter().filter(of_piece);
        let outmost = vertices()
            .map(|v| sign * v.grain[2])
            .fold(f32::NEG_INFINITY, f32::max);
        // Only what was broken here has the coordinates of this wood.
        if outmost <= sign * at.length {
            return None;
        }
        let zone = outmost - END_ZONE * at.radius;
        let near: Vec<&Vertex> = vertices().filter(|v| sign * v.grain[2] > zone).collect();
        let frame = affine_of(&near, sign, Vec3::new(0.0, 0.0, outmost))?;
        let end = flat_end(scene, (piece, sign), outmost, at.radius);
        let [level, slope_x, slope_y] = end.unwrap_or([outmost - SAWN_OFF * at.radius, 0.0, 0.0]);
        let [x, y, outwards] = [Vec3::X, Vec3::Y, Vec3::Z].map(|v| frame.transform_vector3(v));
        let scale = 0.5 * (x.length() + y.length());
        let half = MAP_HALF * at.radius;
        let across = |i: usize| half * ((i as f32 + 0.5) / CELLS as f32 * 2.0 - 1.0);
        let height = |cell: usize| slope_x * across(cell % CELLS) + slope_y * across(cell / CELLS);
        Some(CrackFace {
            at: DrawnBreak {
                along: outwards.normalize_or_zero(),
                across: [x, y].map(Vec3::normalize_or_zero),
                length: sign * level,
                ..at
            },
            place: frame.transform_point3(Vec3::new(0.0, 0.0, level - outmost)),
            scale,
            sign,
            look,
            half,
            heights: (0..CELLS * CELLS).map(height).collect(),
        })
    }

    /// How high a length along the grain (m) lies over the plane from which heights are counted, to where the face looks, m.
    pub fn height_of(&self, length: f32) -> f32 {
        self.sign * (length - self.at.length)
    }

    /// Radius of the stem, m.
    pub fn radius(&self) -> f32 {
        self.at.radius
    }

    /// The direction to which the face looks, along the stem.
    pub fn along(&self) -> Vec3 {
        self.at.along
    }

    /// The place in the section of grain coordinates, m.
    pub fn polar(&self, across: Vec2) -> Polar {
        self.look.address(across)
    }

    /// The height of the face at a place of the section, m over the break's.
    pub fn height(&self, place: Polar) -> f32 {
        self.height_across(self.look.point(place.0, place.1))
    }

    /// The point of the picture where the face is at a place of the section.
    pub fn face_point(&self, place: Polar) -> Vec3 {
        let across = self.look.point(place.0, place.1);
        self.point_across(across, self.height_across(across))
    }

    /// The height of the face at grain coordinates, between those of the cells around them.
    fn height_across(&self, across: Vec2) -> f32 {
        let at = (across / self.half * 0.5 + 0.5) * CELLS as f32 - 0.5;
        let at = at.clamp(Vec2::ZERO, Vec2::splat(CELLS as f32 - 1.0));
        let low = at.floor().min(Vec2::splat(CELLS as f32 - 2.0));
        let part = at - low;
        let height = |dx, dy| self.heights[(low.y as usize + dy) * CELLS + low.x as usize + dx];
        let row = |dy| height(0, dy) + (height(1, dy) - height(0, dy)) * part.x;
        row(0) + (row(1) - row(0)) * part.y
    }

    /// Where a ray (origin and direction) first meets the face as cracks are drawn on it, and the height there over the break's. None
    /// where it comes from the side, below the edge of the face.
    pub fn seen(&self, (origin, direction): (Vec3, Vec3)) -> Option<(Polar, f32)> {
        let axes = [self.at.across[0], self.at.across[1], self.at.along];
        let size = Vec3::new(self.scale, self.scale, 1.0);
        let local = |v: Vec3| Vec3::from(axes.map(|axis| axis.dot(v))) / size;
        let (origin, direction) = (local(origin - self.place), local(direction));
        let start = (f32::INFINITY, f32::NEG_INFINITY);
        let heights = self.heights.iter();
        let (bottom, top) = heights.fold(start, |(a, b), h| (a.min(*h), b.max(*h)));
        let margin = 0.01 * self.at.radius;
        let low = Vec3::new(-self.half, -self.half, bottom - margin);
        let high = Vec3::new(self.half, self.half, top + margin);
        let (a, b) = ((low - origin) / direction, (high - origin) / direction);
        let (first, last) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
        let over = |t: f32| {
            let p = origin + direction * t;
            let across = p.truncate();
            (self.polar(across).0 <= 1.0).then(|| p.z - self.height_across(across))
        };
        let mut above = None;
        for step in 0..=STEPS {
            let t = first + (last - first) * f32::from(step) / f32::from(STEPS);
            match (over(t), above) {
                (None, _) => above = None,
                (Some(height), _) if height > 0.0 => above = Some(t),
                (Some(_), None) => return None,
                (Some(_), Some(before)) => {
                    let (mut before, mut after) = (before, t);
                    for _ in 0..12 {
                        let middle = 0.5 * (before + after);
                        match over(middle) {
                            Some(height) if height > 0.0 => before = middle,
                            _ => after = middle,
                        }
                    }
                    let p = origin + direction * after;
                    return Some((self.polar(p.truncate()), p.z));
                }
            }
        }
        None
    }

    /// Whether who looks in a direction sees the bark at an angle from outside.
    pub fn is_outside(&self, angle: f32, direction: Vec3) -> bool {
        let out = self.at.across[0] * angle.cos() + self.at.across[1] * angle.sin();
        out.dot(direction) < 0.0
    }

    /// The point of the picture at a place of the section, and a height over the break's.
    pub fn point(&self, place: Polar, height: f32) -> Vec3 {
        self.point_across(self.look.point(place.0, place.1), height)
    }

    /// The point of the picture at grain coordinates, m, and a height over the break's.
    pub fn point_across(&self, p: Vec2, height: f32) -> Vec3 {
        let p = p * self.scale;
        self.place + self.at.across[0] * p.x + self.at.across[1] * p.y + self.at.along * height
    }

    /// The grain coordinates of a point of the picture, m.
    pub fn across_of(&self, point: Vec3) -> Vec2 {
        let d = point - self.place;
        Vec2::new(d.dot(self.at.across[0]), d.dot(self.at.across[1])) / self.scale
    }

    /// Where a ray (origin and direction) meets the section at a height over the break's; none along it.
    pub fn met(&self, origin: Vec3, direction: Vec3, height: f32) -> Option<Polar> {
        let speed = direction.dot(self.at.along);
        if speed.abs() < 0.02 {
            return None;
        }
        let from = self.place + self.at.along * height - origin;
        let t = from.dot(self.at.along) / speed;
        let across = self.across_of(origin + direction * t);
        (t > 0.0).then(|| self.polar(across))
    }

    /// The height over the break's of the point of a line along the stem, through a place of the section, that a ray comes nearest to.
    pub fn height_met(&self, origin: Vec3, direction: Vec3, place: Polar) -> Option<f32> {
        let (from, along) = (self.point(place, 0.0), self.at.along);
        let across = along.cross(direction);
        let square = across.length_squared();
        (square > 1e-6).then(|| direction.cross(across).dot(origin - from) / square)
    }
}

/// Grain coordinates with lengths counted to where an end looks.
fn outwards(v: &Vertex, sign: f32) -> Vec3 {
    Vec3::new(v.grain[0], v.grain[1], sign * v.grain[2])
}

/// How the wood about an end lies in the picture: the affine map that its vertices follow best, from grain coordinates about `origin`,
/// with lengths counted to where the end looks. None where they lie in a plane.
fn affine_of(vertices: &[&Vertex], sign: f32, origin: Vec3) -> Option<Affine3A> {
    let count = vertices.len().max(1) as f64;
    let grain = |v: &Vertex| (outwards(v, sign) - origin).as_dvec3();
    let place = |v: &Vertex| Vec3::from_array(v.position).as_dvec3();
    let mean = vertices.iter().map(|v| grain(v)).sum::<DVec3>() / count;
    let middle = vertices.iter().map(|v| place(v)).sum::<DVec3>() / count;
    let (mut own, mut both) = (DMat3::ZERO, DMat3::ZERO);
    let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
    for v in vertices {
        let (g, p) = (grain(v) - mean, place(v) - middle);
        own += outer(g, g);
        both += outer(p, g);
    }
    let size = own.x_axis.x + own.y_axis.y + own.z_axis.z;
    if own.determinant() <= FLAT * size.powi(3) {
        return None;
    }
    let linear = both * own.inverse();
    let start = middle - linear * mean;
    Some(Affine3A::from_mat3_translation(
        linear.as_mat3(),
        start.as_vec3(),
    ))
}

/// The flat face at the end of a piece: its length on the axis, counted to where the end looks, and its rise along x and y. None where
/// too little of the section is one.
fn flat_end(
    scene: &DrawnScene,
    (piece, sign): (f32, f32),
    outmost: f32,
    radius: f32,
) -> Option<[f32; 3]> {
    let (mut area, mut sum, mut tilt) = (0.0, 0.0, Vec2::ZERO);
    for corners in scene.indices.as_chunks::<3>().0 {
        let v = corners.map(|i| &scene.vertices[i as usize]);
        let is_end = |v: &&Vertex| {
            let depth = outmost - sign * v.grain[2];
            v.zone_piece[1] == piece && v.grain[3] > 0.5 && depth < END_ZONE * radius
        };
        if !v.iter().all(is_end) {
            continue;
        }
        let [a, b, c] = v.map(|v| outwards(v, sign));
        // Where lengths count the other way, corners go round the other way.
        let normal = (b - a).cross(c - a) * sign;
        if normal.z <= FACING * normal.length() {
            continue;
        }
        let middle = (a + b + c) / 3.0;
        let slope = -normal.truncate() / normal.z;
        area += normal.z;
        sum += (middle.z - slope.dot(middle.truncate())) * normal.z;
        tilt += slope * normal.z;
    }
    let whole = 2.0 * std::f32::consts::PI * radius * radius;
    let tilt = tilt / area.max(f32::MIN_POSITIVE);
    (area > LEAST_END * whole).then(|| [sum / area, tilt.x, tilt.y])
}

/// The heights of the face below a break of a scene, cell by cell; none where there is no such break.
pub fn face_heights(scene: &DrawnScene, number: usize) -> Vec<f32> {
    let (Some(&at), Some(piece)) = (scene.breaks.get(number), scene.piece_below(number)) else {
        return Vec::new();
    };
    let half = MAP_HALF * at.radius;
    let highest_of = |corners: &[u32]| {
        let mut highest = vec![(0.0f32, 0u32); CELLS * CELLS];
        for &i in corners {
            let v = &scene.vertices[i as usize];
            if v.zone_piece[1] as usize != piece {
                continue;
            }
            if let Some(cell) = cell(Vec2::new(v.grain[0], v.grain[1]), half) {
                raise(&mut highest[cell], (v.grain[2] - at.length, 1));
            }
        }
        highest
    };
    let mut highest = vec![(0.0f32, 0u32); CELLS * CELLS];
    let wood = |b: &&super::meshes::Batch| b.shading == Shading::Wood(number);
    for batch in scene.batches.iter().filter(wood) {
        let (first, last) = (batch.first as usize, (batch.first + batch.count) as usize);
        let parts = scene.indices[first..last].par_chunks(CORNERS_OF_A_TASK);
        for part in parts.map(highest_of).collect::<Vec<_>>() {
            (highest.iter_mut().zip(part)).for_each(|(known, found)| raise(known, found));
        }
    }
    (0..CELLS * CELLS)
        .map(|i| height_around(&highest, i))
        .collect()
}

/// Raises a cell to the highest point in it: the walls of a crack lie below its rim.
fn raise((known, count): &mut (f32, u32), (height, found): (f32, u32)) {
    *known = match (*count, found) {
        (_, 0) => return,
        (0, _) => height,
        _ => known.max(height),
    };
    *count = 1;
}

/// The mean height over a cell and those around it, so that lines over them are smooth; 0 where there is none.
fn height_around(sums: &[(f32, u32)], cell: usize) -> f32 {
    let (x, y) = ((cell % CELLS) as i32, (cell / CELLS) as i32);
    let (mut total, mut count) = (0.0, 0);
    for dy in -REACH..=REACH {
        for dx in -REACH..=REACH {
            let (x, y) = (x + dx, y + dy);
            let inside = (0..CELLS as i32).contains(&x) && (0..CELLS as i32).contains(&y);
            if let (true, Some((sum, n))) = (inside, sums.get((y * CELLS as i32 + x) as usize)) {
                total += sum;
                count += n;
            }
        }
    }
    if count == 0 {
        0.0
    } else {
        total / count as f32
    }
}

fn cell(across: Vec2, half: f32) -> Option<usize> {
    let at = (across / half * 0.5 + 0.5) * CELLS as f32;
    let inside = at.min_element() >= 0.0 && at.max_element() < CELLS as f32;
    inside.then(|| at.y as usize * CELLS + at.x as usize)
}
