//! Drying cracks that are placed by hand: what a drag over the wood means, and where a crack lies on it.

use super::look::WoodLook;
use super::meshes::{DrawnBreak, DrawnScene, Shading};
use super::project::Project;
use glam::{Vec2, Vec3};
use greenstick::RequestFile;
use greenstick::fracture::parameters::{
    Crack, CrackEnd, CrackParameters, RadialCrack, TangentialCrack,
};

/// Ring coordinate from which on a point is on the bark: a crack that reaches it opens there.
pub const BARK: f32 = 0.96;
/// Least length of a crack, as a ring coordinate, and of a ring shake, degrees.
const SHORTEST: f32 = 0.08;
const NARROWEST: f32 = 8.0;
/// How much farther around the pith than outwards a drag goes that follows a ring.
const AROUND: f32 = 1.5;
/// Ring coordinates inwards and outwards of a click that a crack takes.
const INWARDS: f32 = 0.45;
const OUTWARDS: f32 = 0.35;
/// Range of depths, radii.
const DEPTHS: (f64, f64) = (0.01, 40.0);
/// Half the side of the map of heights, radii.
const MAP_HALF: f32 = 1.5;
/// Cells of the map of heights along a side.
const CELLS: usize = 40;
/// Cells to every side over which heights are averaged.
const REACH: i32 = 2;
/// Steps in which a ray is followed over the face.
const STEPS: u16 = 256;
/// Points along a course.
const POINTS: usize = 25;

/// A place in the section: ring coordinate, and angle about the pith, rad.
pub type Polar = (f32, f32);

/// The part of a crack that is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrackEndPoint {
    /// Where it begins.
    Begin,
    /// Where it ends.
    End,
    /// How deep it is.
    Depth,
}

/// The whole turn in which an angle lies, degrees from 0 to 360.
fn degrees(angle: f32) -> f64 {
    f64::from(angle).to_degrees().rem_euclid(360.0)
}

/// The crack that a drag from one place to another means: along a ray, or, where it goes around the pith, along a ring. A click is a
/// drag to where it began.
pub fn crack_of_drag(from: Polar, to: Polar) -> Crack {
    let turn = (to.1 - from.1 + std::f32::consts::PI).rem_euclid(std::f32::consts::TAU)
        - std::f32::consts::PI;
    let (around, outwards) = (turn.abs() * from.0.min(1.0), (to.0 - from.0).abs());
    if around > AROUND * outwards && around > SHORTEST && from.0 < BARK {
        let (first, last) = if turn > 0.0 {
            (from.1, to.1)
        } else {
            (to.1, from.1)
        };
        return Crack::Tangential(TangentialCrack {
            ring: f64::from(from.0.clamp(0.05, 0.95)),
            begin: degrees(first),
            end: degrees(last),
            ..TangentialCrack::default()
        });
    }
    let (low, high) = if from.0 >= BARK {
        (to.0.min(1.0 - INWARDS), 1.0)
    } else if outwards < SHORTEST {
        (from.0 - INWARDS, from.0 + OUTWARDS)
    } else {
        (from.0.min(to.0), from.0.max(to.0))
    };
    let mut crack = RadialCrack {
        angle: degrees(from.1),
        ..RadialCrack::default()
    };
    (crack.begin, crack.end) = between(low, high);
    Crack::Radial(crack)
}

/// Ring coordinates that a radial crack may have; what nearly reaches the bark does.
fn between(low: f32, high: f32) -> (f64, f64) {
    let end = if high >= BARK {
        1.0
    } else {
        high.max(2.0 * SHORTEST)
    };
    let begin = low.clamp(0.0, end - SHORTEST);
    (f64::from(begin), f64::from(end))
}

/// A crack of which a part is dragged to a place.
pub fn dragged_to(crack: &Crack, part: CrackEndPoint, to: Polar) -> Crack {
    let mut crack = crack.clone();
    match (&mut crack, part) {
        (Crack::Radial(c), CrackEndPoint::Begin) => {
            c.begin = f64::from(to.0.max(0.0))
                .min(c.end - f64::from(SHORTEST))
                .max(0.0);
            c.angle = degrees(to.1);
        }
        (Crack::Radial(c), CrackEndPoint::End) => {
            (_, c.end) = between(c.begin as f32, to.0.max(c.begin as f32 + SHORTEST));
            c.angle = degrees(to.1);
        }
        (Crack::Tangential(c), CrackEndPoint::Begin) => c.begin = degrees(to.1),
        (Crack::Tangential(c), CrackEndPoint::End) => {
            c.end = degrees(to.1);
            c.ring = f64::from(to.0.clamp(0.05, 0.95));
        }
        (_, CrackEndPoint::Depth) => {}
    }
    if let Crack::Tangential(c) = &mut crack
        && (c.end - c.begin).rem_euclid(360.0) < f64::from(NARROWEST)
    {
        c.end = (c.begin + f64::from(NARROWEST)).rem_euclid(360.0);
    }
    crack
}

/// The depth of a crack, radii.
pub fn depth(crack: &Crack) -> f64 {
    match crack {
        Crack::Radial(c) => c.depth,
        Crack::Tangential(c) => c.depth,
    }
}

/// A crack with another depth, radii.
pub fn with_depth(crack: &Crack, depth: f32) -> Crack {
    let mut crack = crack.clone();
    let depth = f64::from(depth).clamp(DEPTHS.0, DEPTHS.1);
    match &mut crack {
        Crack::Radial(c) => c.depth = depth,
        Crack::Tangential(c) => c.depth = depth,
    }
    crack
}

/// The places of a crack's course, from its beginning to its end.
pub fn course(crack: &Crack) -> Vec<Polar> {
    let steps = (0..POINTS).map(|k| k as f64 / (POINTS - 1) as f64);
    let place = |t: f64| match crack {
        Crack::Radial(c) => (c.begin + (c.end - c.begin) * t, c.angle.to_radians()),
        Crack::Tangential(c) => {
            let turn = if c.end < c.begin { 360.0 } else { 0.0 };
            (
                c.ring,
                (c.begin + (c.end + turn - c.begin) * t).to_radians(),
            )
        }
    };
    steps
        .map(place)
        .map(|(r, a)| (r as f32, a as f32))
        .collect()
}

/// What a crack is, in words.
pub fn describe(crack: &Crack) -> String {
    match crack {
        Crack::Radial(c) => format!(
            "crack at {:.0}°, rings {:.2} to {:.2}, {:.2} radii deep",
            c.angle, c.begin, c.end, c.depth
        ),
        Crack::Tangential(c) => format!(
            "ring shake at {:.2}, {:.0}° to {:.0}°, {:.2} radii deep",
            c.ring, c.begin, c.end, c.depth
        ),
    }
}

/// The broken face of the piece below a break, on which cracks are drawn: how high it is over each place of the section.
#[derive(Debug, Clone, PartialEq)]
pub struct CrackFace {
    at: DrawnBreak,
    /// Where the axis is, moved with the piece.
    place: Vec3,
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
        let known = scene.faces.get(number).filter(|f| f.len() == CELLS * CELLS);
        let heights = match known {
            Some(heights) => heights.clone(),
            None => face_heights(scene, number),
        };
        scene.piece_below(number)?;
        Some(CrackFace {
            at,
            place,
            look,
            half: MAP_HALF * at.radius,
            heights,
        })
    }

    /// Radius of the stem, m.
    pub fn radius(&self) -> f32 {
        self.at.radius
    }

    /// The direction of the stem.
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
        let local = |v: Vec3| Vec3::from(axes.map(|axis| axis.dot(v)));
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
        self.place + self.at.across[0] * p.x + self.at.across[1] * p.y + self.at.along * height
    }

    /// The grain coordinates of a point of the picture, m.
    pub fn across_of(&self, point: Vec3) -> Vec2 {
        let d = point - self.place;
        Vec2::new(d.dot(self.at.across[0]), d.dot(self.at.across[1]))
    }

    /// Where a ray (origin and direction) meets the section at a height over the break's; none along it.
    pub fn met(&self, origin: Vec3, direction: Vec3, height: f32) -> Option<Polar> {
        let speed = direction.dot(self.at.along);
        if speed.abs() < 0.02 {
            return None;
        }
        let from = self.place + self.at.along * height - origin;
        let t = from.dot(self.at.along) / speed;
        let d = origin + direction * t - self.place;
        let across = Vec2::new(d.dot(self.at.across[0]), d.dot(self.at.across[1]));
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

/// The heights of the face below a break of a scene, cell by cell; none where there is no such break.
pub fn face_heights(scene: &DrawnScene, number: usize) -> Vec<f32> {
    let (Some(&at), Some(piece)) = (scene.breaks.get(number), scene.piece_below(number)) else {
        return Vec::new();
    };
    let half = MAP_HALF * at.radius;
    let mut highest = vec![(0.0f32, 0u32); CELLS * CELLS];
    let wood = |b: &&super::meshes::Batch| b.shading == Shading::Wood(number);
    for batch in scene.batches.iter().filter(wood) {
        let (first, last) = (batch.first as usize, (batch.first + batch.count) as usize);
        for &i in &scene.indices[first..last] {
            let v = &scene.vertices[i as usize];
            if v.zone_piece[1] as usize != piece {
                continue;
            }
            if let Some(cell) = cell(Vec2::new(v.grain[0], v.grain[1]), half) {
                // The highest point: the walls of a crack lie below its rim.
                let height = v.grain[2] - at.length;
                let (known, count) = &mut highest[cell];
                *known = if *count == 0 {
                    height
                } else {
                    known.max(height)
                };
                *count = 1;
            }
        }
    }
    (0..CELLS * CELLS)
        .map(|i| height_around(&highest, i))
        .collect()
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

impl Project {
    /// The cracks that are placed one by one at the selected break, or the first.
    pub fn placed_cracks(&self) -> &[Crack] {
        &self.cracks().cracks
    }

    fn cracks(&self) -> &CrackParameters {
        let number = self.selected().unwrap_or(0);
        let one = self.file.breaks.get(number).unwrap_or(&self.file.common);
        &one.recipe.cracks
    }

    /// Whether its cracks are in the sawn end of the stem, not in the broken face.
    pub fn cracks_are_sawn(&self) -> bool {
        let cracks = self.cracks();
        cracks.settings.end == CrackEnd::Sawn && !cracks.is_empty()
    }

    /// Changes the placed cracks of the selected break, or of all.
    ///
    /// # Errors
    /// As [`Project::change`].
    pub fn change_cracks(
        &mut self,
        label: &str,
        drag: bool,
        change: impl Fn(&mut CrackParameters),
    ) -> Result<bool, String> {
        let selected = self.selected();
        self.change(label, drag, |file: &mut RequestFile| {
            let breaks = file.breaks.iter_mut().enumerate();
            let own = breaks.filter(|(i, _)| selected.is_none_or(|s| s == *i));
            let common = selected.is_none().then_some(&mut file.common);
            for one in own.map(|(_, one)| one).chain(common) {
                change(&mut one.recipe.cracks);
            }
            Ok::<(), String>(())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::engine::{Engine, Haste, Job};
    use crate::model::input::Input;
    use greenstick::geometry::Context;
    use greenstick::schema::Parameters;

    fn radial(crack: &Crack) -> (f64, f64, f64) {
        match crack {
            Crack::Radial(c) => (c.angle, c.begin, c.end),
            Crack::Tangential(_) => panic!("{crack:?}"),
        }
    }

    #[test]
    fn drags_mean_what_they_look_like() {
        let close = |a: f64, b: f64| (a - b).abs() < 1e-5;
        let (angle, begin, end) = radial(&crack_of_drag((0.2, 1.0), (0.7, 1.02)));
        assert!(close(angle, 1f64.to_degrees()) && close(begin, 0.2) && close(end, 0.7));
        // Inwards it is the same crack, and near the bark it opens through it.
        let (_, begin, end) = radial(&crack_of_drag((0.9, 1.0), (0.3, 1.0)));
        assert!(close(begin, 0.3) && close(end, 0.9));
        assert_eq!(radial(&crack_of_drag((0.5, -0.5), (0.99, -0.5))).2, 1.0);
        let Crack::Tangential(c) = crack_of_drag((0.6, 0.3), (0.62, -0.9)) else {
            panic!("a drag around the pith is a ring shake");
        };
        assert!(close(c.begin, degrees(-0.9)) && close(c.end, 0.3f64.to_degrees()));
        // Whatever is dragged, the schema takes it.
        let places = [0.0, 0.02, 0.3, 0.95, 1.0, 1.7];
        let angles = [-3.1, -0.2, 0.0, 1.5, 3.1];
        for from in places.map(|r| angles.map(|a| (r, a))).concat() {
            for to in places.map(|r| angles.map(|a| (r, a))).concat() {
                let crack = crack_of_drag(from, to);
                crack.check().unwrap();
                for part in [CrackEndPoint::Begin, CrackEndPoint::End] {
                    dragged_to(&crack, part, to).check().unwrap();
                }
                with_depth(&crack, to.0 - 0.5).check().unwrap();
            }
        }
    }

    fn drawn() -> DrawnScene {
        let job = Job {
            input: Input::built_in(),
            file: RequestFile::default(),
            haste: Haste::Whole,
            sections_of: None,
        };
        let shown = Engine::default().work(&job, &mut |_| {}, &Context::quiet());
        shown.unwrap().unwrap().drawn
    }

    #[test]
    fn a_ray_picks_the_place_that_is_drawn_under_it() {
        let drawn = drawn();
        let face = CrackFace::new(&drawn, 0).unwrap();
        for place in [(0.3, 0.4), (0.8, -2.0), (0.97, 3.0)] {
            let height = 0.2 * face.radius();
            let point = face.point(place, height);
            let direction = (Vec3::new(0.3, -0.2, 0.1) - face.along()).normalize();
            let origin = point - direction * 2.0;
            let (rho, angle) = face.met(origin, direction, height).unwrap();
            assert!((rho - place.0).abs() < 2e-3 && (angle - place.1).abs() < 2e-3);
            let side = face.along().any_orthonormal_vector();
            let met = face.height_met(point - side * 3.0, side, place).unwrap();
            assert!((met - height).abs() < 1e-4, "{met} {height}");
        }
    }

    #[test]
    fn a_drag_along_a_ray_is_a_radial_crack_whatever_the_heights_of_the_face_are() {
        let drawn = drawn();
        let face = CrackFace::new(&drawn, 0).unwrap();
        let close = |a: Polar, b: Polar| {
            let section = |p: Polar| Vec2::from_angle(p.1) * p.0;
            section(a).distance(section(b)) < 0.02
        };
        let mut seen = 0;
        for (lean, turn) in [
            (0.0f32, 0.0f32),
            (0.4, 0.0),
            (0.4, 2.0),
            (1.0, 4.0),
            (1.3, 1.0),
        ] {
            let side = face.at.across[0] * turn.cos() + face.at.across[1] * turn.sin();
            let direction = side * lean.sin() - face.along() * lean.cos();
            let under = |place: Polar| {
                let point = face.point(place, face.height(place));
                face.seen((point - direction * 60.0 * face.radius(), direction))
            };
            for angle in (0..12).map(|k| f32::from(k as u8) * 0.5) {
                let (from, to) = ((0.3, angle), (0.8, angle));
                let (Some(a), Some(b)) = (under(from), under(to)) else {
                    continue;
                };
                // What lies behind a higher part of the face cannot be dragged over.
                if !(close(a.0, from) && close(b.0, to)) {
                    assert!(lean > 0.0, "{a:?} {b:?} at {angle}");
                    continue;
                }
                seen += 1;
                let (_, begin, end) = radial(&crack_of_drag(a.0, b.0));
                assert!((begin - 0.3).abs() < 0.03 && (end - 0.8).abs() < 0.03);
            }
        }
        assert!(seen > 24, "{seen}");
    }
}
