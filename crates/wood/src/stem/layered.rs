//! Grain space in layers: between two levels across the stem the map to the world is affine.
//!
//! Lengths are measured along one direction, that of the stem at the location of the break; the axis shifts the section
//! sideways and turns nothing. A straight edge that stays within a layer is straight in both spaces, so that what does not
//! cross in one does not cross in the other. Over the length of a break the directions of a stem differ little; where they
//! turn by more than [`MIN_DIRECTION_COSINE`] allows, the stem is no longer free for the break.

use super::{LevelSteps, Stem};
use glam::{DAffine3, DVec2, DVec3};

/// The map between the world (or a node's coordinates) and grain space (x, y, s), m.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LayeredGrain {
    origin: DVec3,
    x: DVec3,
    y: DVec3,
    along: DVec3,
    /// Length of the location at `origin`, m.
    location: f64,
    /// Rising in length.
    levels: Vec<Level>,
    /// The lengths of `levels`.
    lengths: Vec<f64>,
    steps: LevelSteps,
    /// Spiral grain: turn about the axis, rad per m, and the lengths (m) between which the grain turns.
    spiral: f64,
    spiral_range: (f64, f64),
}

/// A plane across the stem between two layers.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Level {
    /// m.
    length: f64,
    /// How far the section is shifted sideways there, m.
    shift: DVec2,
}

/// Cosine of the greatest angle between the stem's direction and that at the break.
const MIN_DIRECTION_COSINE: f64 = 0.64;
/// Part of the radius by which the axis may lie off the straight lines between levels.
const AXIS_TOLERANCE_RADII: f64 = 4e-3;
/// Bound of the rounding error of a grain coordinate, relative to the sum of coordinates.
const COORDINATE_ROUNDING: f64 = 1e-13;

/// Distance from the vertices of a mesh at which a level is clear of them, and the step by which it is moved to get there, as a part
/// of the distance of levels.
const CLEARANCE_PER_LEVEL: f64 = 0.01;
/// How many steps to either side a level may be moved.
const CLEARANCE_STEPS: i32 = 8;

/// A length within `range`, and within a few steps of `length`, that none of the rising `corners` is closer to than a step; where
/// there is none, that which is the farthest from them.
fn clear_of(corners: &[f64], length: f64, step: f64, range: (f64, f64)) -> f64 {
    let clearance = |at: f64| {
        let next = corners.partition_point(|&c| c < at);
        let about = &corners[next.saturating_sub(1)..corners.len().min(next + 1)];
        about
            .iter()
            .fold(step, |least: f64, c| least.min((c - at).abs()))
    };
    let moved = |k: i32| length + f64::from(k) * step;
    let others = (1..=CLEARANCE_STEPS).flat_map(|k| [moved(k), moved(-k)]);
    let within = others.filter(|at| (range.0..=range.1).contains(at));
    within.fold(length, |best, at| {
        if clearance(at) > clearance(best) {
            at
        } else {
            best
        }
    })
}

impl LayeredGrain {
    /// The layers of a stem, and the lengths between which it is free for a break.
    pub fn from_stem(stem: &Stem) -> (Self, (f64, f64)) {
        let frame = stem.grain.axis().frame(stem.location);
        let mut layered = LayeredGrain {
            origin: frame.origin,
            x: frame.x,
            y: frame.y,
            along: frame.tangent,
            location: stem.location,
            levels: Vec::new(),
            lengths: Vec::new(),
            steps: LevelSteps::default(),
            spiral: 0.0,
            spiral_range: (0.0, 0.0),
        };
        let (mut levels, low) = layered.walk(stem, stem.usable.0, -1.0);
        let (up, high) = layered.walk(stem, stem.usable.1, 1.0);
        levels.reverse();
        levels.push(Level {
            length: stem.location,
            shift: DVec2::ZERO,
        });
        levels.extend(up);
        layered.set_levels(simplify(&levels, AXIS_TOLERANCE_RADII * stem.radius));
        (layered, (low, high))
    }

    /// Samples the axis from the location to `end` (m), up (`sign` 1) or down (−1), until it turns too far; also returns
    /// the length up to which the stem is free for a break.
    fn walk(&self, stem: &Stem, end: f64, sign: f64) -> (Vec<Level>, f64) {
        let span = (end - stem.location).abs();
        let count = (span / (0.2 * stem.radius)).ceil() as usize;
        let mut samples = Vec::new();
        let mut last = stem.location;
        let mut slope: f64 = 0.0;
        for i in 1..=count {
            let length = stem.location + sign * (span * i as f64 / count as f64);
            let f = stem.grain.axis().frame(length);
            let cosine = f.tangent.dot(self.along);
            if cosine < MIN_DIRECTION_COSINE {
                break;
            }
            slope = (1.0 - cosine * cosine).max(0.0).sqrt();
            let aside = stem.grain.offset(length);
            let sample = self.project(f.origin + f.x * aside.x + f.y * aside.y);
            last = sample.length;
            samples.push(sample);
        }
        // The stem's own end may stand at an angle to the levels.
        let margin = slope * stem.radius;
        let free = if sign > 0.0 {
            (last - margin).max(stem.location)
        } else {
            (last + margin).min(stem.location)
        };
        (samples, free)
    }

    /// Length of a point, and where it lies across the stem before the section is shifted.
    fn project(&self, world: DVec3) -> Level {
        let d = world - self.origin;
        Level {
            length: self.location + d.dot(self.along),
            shift: DVec2::new(d.dot(self.x), d.dot(self.y)),
        }
    }

    /// The same with spiral grain that turns about the axis by `turn` rad per m, with levels between `low` and `high` (m) from
    /// one to the next of which it turns by about `per_level` rad at most. Levels keep clear of `corners`, the rising lengths (m) of
    /// the vertices of a mesh that will be split at them: closely below a vertex that would leave triangles without height.
    pub fn with_spiral(
        mut self,
        turn: f64,
        (low, high): (f64, f64),
        per_level: f64,
        corners: &[f64],
    ) -> Self {
        if turn == 0.0 {
            return self;
        }
        let count = ((high - low) * turn.abs() / per_level)
            .ceil()
            .clamp(1.0, 1000.0);
        let step = CLEARANCE_PER_LEVEL * (high - low) / count;
        let lengths: Vec<f64> = (0..=count as usize)
            .map(|i| low + (high - low) * i as f64 / count)
            .map(|length| clear_of(corners, length, step, (low, high)))
            .collect();
        (self.spiral, self.spiral_range) = (turn, (lengths[0], lengths[count as usize]));
        let mut levels: Vec<Level> = (lengths.into_iter())
            .map(|length| Level {
                length,
                shift: self.shift(length),
            })
            .collect();
        levels.extend(self.levels.iter().copied());
        levels.sort_by(|a, b| a.length.total_cmp(&b.length));
        levels.dedup_by(|a, b| a.length == b.length);
        self.set_levels(levels);
        self
    }

    fn set_levels(&mut self, levels: Vec<Level>) {
        self.lengths = levels.iter().map(|l| l.length).collect();
        self.steps = LevelSteps::new(&self.lengths);
        self.levels = levels;
    }

    /// Whether the grain is spiral, so that the map is not quite affine between levels.
    pub fn has_spiral_grain(&self) -> bool {
        self.spiral != 0.0
    }

    /// Levels, m, ascending: no straight edge should cross one. Where grain is straight, the map goes on unchanged beyond the first
    /// and the last.
    pub fn levels(&self) -> impl Iterator<Item = f64> + '_ {
        self.lengths.iter().copied()
    }

    /// How far the section at `s` (m) is shifted sideways.
    #[inline]
    fn shift(&self, s: f64) -> DVec2 {
        let n = self.levels.len();
        if n < 2 {
            return DVec2::ZERO;
        }
        let k = self.steps.count(&self.lengths, s).clamp(1, n - 1);
        let (a, b) = (self.levels[k - 1], self.levels[k]);
        a.shift + (b.shift - a.shift) * ((s - a.length) / (b.length - a.length))
    }

    /// The turn of spiral grain at `s` (m), as a unit vector.
    fn turn(&self, s: f64) -> DVec2 {
        let (low, high) = self.spiral_range;
        let (sin, cos) = libm::sincos(self.spiral * (s.clamp(low, high) - self.location));
        DVec2::new(cos, sin)
    }

    /// Maps grain space to the world.
    #[inline]
    pub fn to_world(&self, p: DVec3) -> DVec3 {
        let mut q = p.truncate();
        if self.spiral != 0.0 {
            q = self.turn(p.z).rotate(q);
        }
        if !self.levels.is_empty() {
            q += self.shift(p.z);
        }
        self.origin + self.x * q.x + self.y * q.y + self.along * (p.z - self.location)
    }

    /// Maps the world to grain space.
    pub fn to_grain(&self, world: DVec3) -> DVec3 {
        let projected = self.project(world);
        self.straightened(projected.length, projected.shift)
    }

    /// Maps the world to grain space for a point that lies on the level `s` (m).
    pub fn to_grain_on(&self, world: DVec3, s: f64) -> DVec3 {
        self.straightened(s, self.project(world).shift)
    }

    /// Grain coordinates of a point at length `s` (m) and at `across` in the unshifted section.
    fn straightened(&self, s: f64, across: DVec2) -> DVec3 {
        let q = across - self.shift(s);
        if self.spiral == 0.0 {
            return q.extend(s);
        }
        let turn = self.turn(s);
        DVec2::new(turn.x, -turn.y).rotate(q).extend(s)
    }

    /// Returns the least and the greatest grain coordinates (m) in a triangle that is straight in the world, whose corners
    /// have the grain coordinates `corners` in one layer.
    ///
    /// A point with the weights λ, where the grain has turned by θ = Σ λᵢ θᵢ, lies at Σ λᵢ R(θᵢ − θ) gᵢ across the grain,
    /// with the corners gᵢ and rotations R. It is off the plane through the corners, Σ λᵢ gᵢ, by the covariance of θ and g
    /// at most, (t / 2) (d / √3), and by Σ λᵢ (θᵢ − θ)² w / 2 ≤ t² w / 8, where the triangle turns by t, its corners
    /// lie within d of each other and within w of the axis.
    pub fn triangle_bounds(&self, corners: [DVec3; 3]) -> (DVec3, DVec3) {
        let [a, b, c] = corners;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let rounding = DVec3::splat(COORDINATE_ROUNDING * low.abs().max(high.abs()).element_sum());
        let (low, high) = (low - rounding, high + rounding);
        if self.spiral == 0.0 {
            return (low, high);
        }
        let turn = self.spiral.abs() * (high.z - low.z);
        let from_axis = |p: DVec3| p.truncate().length();
        let far = from_axis(a).max(from_axis(b)).max(from_axis(c));
        let across = (high - low).truncate().length();
        let margin = turn * turn * far / 8.0 + turn * across / (2.0 * 3f64.sqrt());
        let margin = DVec2::splat(margin).extend(0.0);
        (low - margin, high + margin)
    }

    /// The same map into the coordinates that `map` leads to. Only [`LayeredGrain::to_world`] may be used of it.
    pub fn transformed(&self, map: &DAffine3) -> Self {
        LayeredGrain {
            origin: map.transform_point3(self.origin),
            x: map.transform_vector3(self.x),
            y: map.transform_vector3(self.y),
            along: map.transform_vector3(self.along),
            ..self.clone()
        }
    }
}

/// The fewest of the samples between which straight lines stay within `tolerance` (m) of all (Douglas and Peucker 1973);
/// none where the stem is straight.
fn simplify(samples: &[Level], tolerance: f64) -> Vec<Level> {
    let straight = samples.iter().all(|s| s.shift.length() <= 1e-6 * tolerance);
    if samples.len() < 2 || straight {
        return Vec::new();
    }
    let mut needed = vec![false; samples.len()];
    let last = samples.len() - 1;
    (needed[0], needed[last]) = (true, true);
    let mut stack = vec![(0, last)];
    while let Some((a, b)) = stack.pop() {
        let (p, q) = (samples[a], samples[b]);
        let miss = |i: usize| {
            let t = (samples[i].length - p.length) / (q.length - p.length);
            samples[i].shift.distance(p.shift.lerp(q.shift, t))
        };
        let Some(worst) = (a + 1..b).max_by(|&i, &j| miss(i).total_cmp(&miss(j))) else {
            continue;
        };
        if miss(worst) > tolerance {
            needed[worst] = true;
            stack.extend([(a, worst), (worst, b)]);
        }
    }
    samples
        .iter()
        .zip(needed)
        .filter(|(_, needed)| *needed)
        .map(|(s, _)| *s)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Layers of a straight stem along z whose grain turns by `spiral` rad per m.
    fn spiral_layers(spiral: f64) -> LayeredGrain {
        LayeredGrain {
            x: DVec3::X,
            y: DVec3::Y,
            along: DVec3::Z,
            spiral,
            spiral_range: (-1.0, 1.0),
            ..LayeredGrain::default()
        }
    }

    #[test]
    fn bounds_hold_straight_triangles_and_little_more() {
        let layers = spiral_layers(7.0);
        let random = |i: i64, k: i64| crate::noise::unit(5, i, k, 0);
        for i in 0..300 {
            // From walls along the grain to flat tops, turning by up to 0.1 rad.
            let (wide, high) = (0.01 * random(i, 9).powi(3), 0.015 * random(i, 10));
            let at = DVec3::new(random(i, 11), random(i, 12), 0.0) * 0.1;
            let corner = |k: i64| {
                let [x, y, z] = [0, 1, 2].map(|c| random(i, 3 * k + c) - 0.5);
                at + DVec3::new(wide * x, wide * y, high * z)
            };
            let corners = [0, 1, 2].map(corner);
            let (low, high) = layers.triangle_bounds(corners);
            let world = corners.map(|p| layers.to_world(p));
            let (mut least, mut most) = (corners[0], corners[0]);
            for (u, v) in (0..=20).flat_map(|u| (0..=20 - u).map(move |v| (u, v))) {
                let [u, v] = [u, v].map(|w| f64::from(w) / 20.0);
                let inside = world[0] + (world[1] - world[0]) * u + (world[2] - world[0]) * v;
                let grain = layers.to_grain(inside);
                (least, most) = (least.min(grain), most.max(grain));
            }
            assert!(low.cmple(least).all(), "{i}: {low} {least}");
            assert!(high.cmpge(most).all(), "{i}: {high} {most}");
            let turn = 7.0 * (high.z - low.z);
            let spare = (least - low).max(high - most).max_element();
            let expected = turn * turn * 0.15 / 8.0 + turn * 0.015 / 3.0;
            assert!(spare <= expected + 1e-12, "{i}: {spare} {turn}");
        }
    }

    #[test]
    fn levels_of_spiral_grain_keep_clear_of_vertices_and_within_their_range() {
        // Rings of vertices closely above and below where levels would be, and a dense cloud about one of them.
        let mut corners = vec![0.1 - 1e-9, 0.3 + 1e-9, 0.5, 0.9 - 1e-7, 1.0 - 1e-8];
        corners.extend((-50..50).map(|i| 0.7 + 1e-5 * f64::from(i)));
        corners.sort_by(f64::total_cmp);
        let layers = LayeredGrain::default().with_spiral(2.0, (0.1, 1.0), 0.2, &corners);
        let levels: Vec<f64> = layers.levels().collect();
        assert_eq!(levels.len(), 10);
        let nearest = |l: f64| (corners.iter()).fold(1.0, |least: f64, c| least.min((c - l).abs()));
        for (i, &l) in levels.iter().enumerate() {
            assert!(nearest(l) > 0.99e-3, "{l}: {}", nearest(l));
            assert!((l - (0.1 + 0.1 * i as f64)).abs() < 8.1e-3, "{l}");
            assert!((0.1..=1.0).contains(&l), "{l}");
        }
    }

    #[test]
    fn straight_grain_goes_on_unchanged_beyond_its_first_and_last_level() {
        let level = |length, x| Level {
            length,
            shift: DVec2::new(x, 0.0),
        };
        let mut bent = LayeredGrain::default();
        bent.set_levels(vec![level(0.0, 0.1), level(0.5, 0.0), level(1.0, 0.2)]);
        for (from, to) in [(0.5, 1.0), (0.5, 0.0)] {
            let beyond = to + (to - from);
            let line = bent.shift(to) + (bent.shift(to) - bent.shift(from));
            assert!((bent.shift(beyond) - line).length() < 1e-15, "{to}");
        }
        // Spiral grain turns no further beyond its ends.
        let spiral = bent.with_spiral(3.0, (0.2, 0.8), 10.0, &[]);
        assert_eq!(
            spiral.levels().collect::<Vec<_>>(),
            [0.0, 0.2, 0.5, 0.8, 1.0]
        );
    }

    #[test]
    fn layers_invert_and_are_affine_between_levels() {
        let level = |length, x, y| Level {
            length,
            shift: DVec2::new(x, y),
        };
        let mut layered = LayeredGrain {
            origin: DVec3::new(1.0, 2.0, 3.0),
            x: DVec3::Y,
            y: DVec3::Z,
            along: DVec3::X,
            location: 0.5,
            levels: Vec::new(),
            lengths: Vec::new(),
            steps: LevelSteps::default(),
            spiral: 0.0,
            spiral_range: (0.0, 0.0),
        };
        layered.set_levels(vec![
            level(0.0, 0.1, 0.0),
            level(0.5, 0.0, 0.0),
            level(1.0, 0.0, 0.2),
        ]);
        for p in [
            DVec3::new(0.1, -0.2, 0.3),
            DVec3::new(0.0, 0.4, 0.9),
            DVec3::new(1.0, 1.0, -2.0),
        ] {
            assert!(layered.to_grain(layered.to_world(p)).distance(p) < 1e-14);
        }
        let (a, b) = (DVec3::new(0.1, 0.2, 0.5), DVec3::new(-0.3, 0.0, 1.0));
        let middle = layered.to_world((a + b) / 2.0);
        assert!(middle.distance((layered.to_world(a) + layered.to_world(b)) / 2.0) < 1e-15);
    }
}
