//! Grain space in layers: between two levels across the stem the map to the world is affine.
//!
//! Lengths are measured along one direction, the stem's at the place of the break; the axis moves the section sideways,
//! and turns nothing. A straight edge that stays within a layer is straight in both spaces, so what does not cross in one
//! does not cross in the other. Over the length of a break the directions of a stem differ little; where they turn by
//! more than [`STEEPEST`], the stem is no longer free for the break.

use super::Stem;
use glam::{DAffine3, DVec2, DVec3};

/// The map between the world (or a node's coordinates) and grain space (x, y, s), m.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LayeredGrain {
    origin: DVec3,
    x: DVec3,
    y: DVec3,
    along: DVec3,
    /// Length of the place at `origin`, m.
    place: f64,
    /// Levels: length (m) and how far the section is moved sideways there (m), rising in length.
    levels: Vec<(f64, DVec2)>,
    /// Turn of the grain about the axis, rad per m, and the lengths (m) between which it winds.
    spiral: f64,
    winds: (f64, f64),
}

/// Cosine of the greatest angle between the stem's direction and that at the break.
const STEEPEST: f64 = 0.64;
/// Part of the radius by which the axis may lie off the straight lines between levels.
const OFF: f64 = 4e-3;
/// Levels up to which counting all of them is quicker than searching.
const FEW: usize = 32;
/// Greatest turn of winding grain from level to level, rad.
const TURN: f64 = 0.07;

impl LayeredGrain {
    /// The layers of a stem, and the lengths between which it is free for a break.
    pub fn of(stem: &Stem) -> (Self, (f64, f64)) {
        let frame = stem.grain.axis().frame(stem.place);
        let mut made = LayeredGrain {
            origin: frame.origin,
            x: frame.x,
            y: frame.y,
            along: frame.tangent,
            place: stem.place,
            levels: Vec::new(),
            spiral: 0.0,
            winds: (0.0, 0.0),
        };
        let step = 0.2 * stem.radius;
        let walk = |sign: f64, end: f64| {
            let count = ((end - stem.place).abs() / step).ceil() as usize;
            let mut samples = Vec::new();
            let mut last = (stem.place, DVec2::ZERO);
            let mut slope: f64 = 0.0;
            for i in 1..=count {
                let length =
                    stem.place + sign * ((end - stem.place).abs() * i as f64 / count as f64);
                let f = stem.grain.axis().frame(length);
                let cosine = f.tangent.dot(frame.tangent);
                if cosine < STEEPEST {
                    break;
                }
                slope = (1.0 - cosine * cosine).max(0.0).sqrt();
                last = made.project(f.origin);
                samples.push(last);
            }
            // The stem's own end may stand at an angle to the levels.
            let margin = slope * stem.radius;
            let free = if sign > 0.0 {
                (last.0 - margin).max(stem.place)
            } else {
                (last.0 + margin).min(stem.place)
            };
            (samples, free)
        };
        let (mut down, low) = walk(-1.0, stem.usable.0);
        let (up, high) = walk(1.0, stem.usable.1);
        down.reverse();
        down.push((stem.place, DVec2::ZERO));
        down.extend(up);
        made.levels = simplify(&down, OFF * stem.radius);
        (made, (low, high))
    }

    /// Length and sideways place of a point, before the section is moved.
    fn project(&self, world: DVec3) -> (f64, DVec2) {
        let d = world - self.origin;
        (
            self.place + d.dot(self.along),
            DVec2::new(d.dot(self.x), d.dot(self.y)),
        )
    }

    /// The same with grain that winds about the axis by `turn` rad per m, with levels close enough for it between
    /// `low` and `high` (m).
    pub fn with_spiral(mut self, turn: f64, (low, high): (f64, f64)) -> Self {
        if turn == 0.0 {
            return self;
        }
        (self.spiral, self.winds) = (turn, (low, high));
        let count = ((high - low) * turn.abs() / TURN).ceil().clamp(1.0, 1000.0);
        let mut levels: Vec<(f64, DVec2)> = (0..=count as usize)
            .map(|i| low + (high - low) * i as f64 / count)
            .map(|s| (s, self.moved(s)))
            .collect();
        levels.extend(self.levels.iter().copied());
        levels.sort_by(|a, b| a.0.total_cmp(&b.0));
        levels.dedup_by(|a, b| a.0 == b.0);
        self.levels = levels;
        self
    }

    /// Whether the grain winds about the axis, so that the map is not quite affine between levels.
    pub fn winds(&self) -> bool {
        self.spiral != 0.0
    }

    /// Levels, m, ascending: no straight edge should cross one.
    pub fn levels(&self) -> impl Iterator<Item = f64> + '_ {
        self.levels.iter().map(|l| l.0)
    }

    /// How far the section at `s` is moved sideways.
    #[inline]
    fn moved(&self, s: f64) -> DVec2 {
        let n = self.levels.len();
        if n < 2 {
            return DVec2::ZERO;
        }
        let k = if n > FEW {
            self.levels.partition_point(|l| l.0 <= s)
        } else {
            self.levels.iter().map(|l| usize::from(l.0 <= s)).sum()
        };
        let k = k.clamp(1, n - 1);
        let ((a, p), (b, q)) = (self.levels[k - 1], self.levels[k]);
        p + (q - p) * ((s - a) / (b - a))
    }

    fn turn(&self, s: f64) -> DVec2 {
        let (sin, cos) =
            libm::sincos(self.spiral * (s.clamp(self.winds.0, self.winds.1) - self.place));
        DVec2::new(cos, sin)
    }

    /// Grain space to the world.
    #[inline]
    pub fn to_world(&self, p: DVec3) -> DVec3 {
        let mut q = p.truncate();
        if self.spiral != 0.0 {
            q = self.turn(p.z).rotate(q);
        }
        if !self.levels.is_empty() {
            q += self.moved(p.z);
        }
        self.origin + self.x * q.x + self.y * q.y + self.along * (p.z - self.place)
    }

    /// The world to grain space.
    pub fn to_grain(&self, world: DVec3) -> DVec3 {
        let (s, across) = self.project(world);
        self.at(s, across)
    }

    /// The world to grain space for a point that lies on the level `s` (m).
    pub fn to_grain_on(&self, world: DVec3, s: f64) -> DVec3 {
        self.at(s, self.project(world).1)
    }

    fn at(&self, s: f64, across: DVec2) -> DVec3 {
        let q = across - self.moved(s);
        if self.spiral == 0.0 {
            return q.extend(s);
        }
        let turn = self.turn(s);
        DVec2::new(turn.x, -turn.y).rotate(q).extend(s)
    }

    /// The same map into coordinates that `map` leads to. Only [`LayeredGrain::to_world`] may be asked of it.
    pub fn mapped(&self, map: &DAffine3) -> Self {
        LayeredGrain {
            origin: map.transform_point3(self.origin),
            x: map.transform_vector3(self.x),
            y: map.transform_vector3(self.y),
            along: map.transform_vector3(self.along),
            ..self.clone()
        }
    }
}

/// The fewest of the samples between which straight lines stay within `off` of all (Douglas and Peucker 1973); none
/// where the stem is straight.
fn simplify(samples: &[(f64, DVec2)], off: f64) -> Vec<(f64, DVec2)> {
    let straight = samples.iter().all(|s| s.1.length() <= 1e-6 * off);
    if samples.len() < 2 || straight {
        return Vec::new();
    }
    let mut kept = vec![false; samples.len()];
    let last = samples.len() - 1;
    (kept[0], kept[last]) = (true, true);
    let mut stack = vec![(0, last)];
    while let Some((a, b)) = stack.pop() {
        let (p, q) = (samples[a], samples[b]);
        let miss = |i: usize| {
            let t = (samples[i].0 - p.0) / (q.0 - p.0);
            samples[i].1.distance(p.1.lerp(q.1, t))
        };
        let Some(worst) = (a + 1..b).max_by(|&i, &j| miss(i).total_cmp(&miss(j))) else {
            continue;
        };
        if miss(worst) > off {
            kept[worst] = true;
            stack.extend([(a, worst), (worst, b)]);
        }
    }
    samples
        .iter()
        .zip(kept)
        .filter(|(_, k)| *k)
        .map(|(s, _)| *s)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_invert_and_are_affine_between_levels() {
        let made = LayeredGrain {
            origin: DVec3::new(1.0, 2.0, 3.0),
            x: DVec3::Y,
            y: DVec3::Z,
            along: DVec3::X,
            place: 0.5,
            levels: vec![
                (0.0, DVec2::new(0.1, 0.0)),
                (0.5, DVec2::ZERO),
                (1.0, DVec2::new(0.0, 0.2)),
            ],
            spiral: 0.0,
            winds: (0.0, 0.0),
        };
        for p in [
            DVec3::new(0.1, -0.2, 0.3),
            DVec3::new(0.0, 0.4, 0.9),
            DVec3::new(1.0, 1.0, -2.0),
        ] {
            assert!(made.to_grain(made.to_world(p)).distance(p) < 1e-14);
        }
        let (a, b) = (DVec3::new(0.1, 0.2, 0.5), DVec3::new(-0.3, 0.0, 1.0));
        let middle = made.to_world((a + b) / 2.0);
        assert!(middle.distance((made.to_world(a) + made.to_world(b)) / 2.0) < 1e-15);
    }
}
