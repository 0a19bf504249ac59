//! The plan of a face's cracks: groups drawn at random, courses distorted, crossings avoided.

use super::profile::relative_opening;
use crate::parameters::{
    Crack, CrackGroup, CrackKind, CrackParameters, RadialCrack, TangentialCrack,
};
use glam::DVec2;
use greenstick_wood::noise;
use std::f64::consts::TAU;

/// Seeds of independent random numbers.
mod purpose {
    pub const ANGLE: u64 = 0xc4a1;
    pub const BEGIN: u64 = 0xc4be;
    pub const LENGTH: u64 = 0xc41e;
    pub const DEPTH: u64 = 0xc4de;
    pub const RANGE: u64 = 0xc4a6;
    pub const ALONG: u64 = 0xc4a7;
    pub const ACROSS: u64 = 0xc4ac;
}

/// A planned crack.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedCrack {
    /// Its kind.
    pub kind: CrackKind,
    /// Ring coordinate and angle (rad) along its course.
    pub course: Vec<(f64, f64)>,
    /// Fraction (0 to 1) of the course at each of these points.
    pub fractions: Vec<f64>,
    /// Whether its end is open at the bark.
    pub open_at_bark: bool,
    /// Depth along the grain from the face, in radii.
    pub depth: f64,
    /// Range σ of the wood that gives way on either side: rad for a radial crack, in radii for a tangential one.
    pub range: f64,
    /// Shrinkage across the crack.
    pub shrinkage: f64,
}

/// The cracks of a face.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CrackPlan {
    /// The cracks; none crosses another.
    pub cracks: Vec<PlannedCrack>,
    /// Number of cracks shortened so that they cross no other.
    pub shortened: usize,
    /// Number of cracks left out because they would have crossed others.
    pub skipped: usize,
}

/// Steps along a course.
const STEPS: usize = 28;
/// Ring coordinate from which on a crack's end counts as open at the bark.
const OPEN_END: f64 = 0.999;
/// Distance (in radii) that cracks keep from each other beside their own openings.
const MIN_DISTANCE: f64 = 0.012;
/// Shares of its course that a crack is tried with before it is left out.
const LENGTH_ATTEMPTS: [f64; 5] = [1.0, 0.85, 0.7, 0.55, 0.4];
/// Waves of the distortion per radius; each octave has twice as many.
const WAVES_PER_RADIUS: f64 = 3.5;

impl PlannedCrack {
    /// Returns the width of the opening at the face, radii, at a fraction of the course and a distance from the pith in radii.
    pub fn width(&self, fraction: f64, radius: f64) -> f64 {
        let across = match self.kind {
            CrackKind::Radial => radius,
            CrackKind::Tangential => 1.0,
        };
        self.shrinkage * self.range * across * relative_opening(fraction, self.open_at_bark)
    }

    /// Returns the course in ring coordinates.
    fn points(&self) -> Vec<DVec2> {
        self.course
            .iter()
            .map(|&(rho, phi)| {
                let (sin, cos) = libm::sincos(phi);
                DVec2::new(cos, sin) * rho
            })
            .collect()
    }

    /// Returns half the greatest width, radii.
    fn half_width(&self) -> f64 {
        self.course
            .iter()
            .zip(&self.fractions)
            .map(|(&(rho, _), &t)| self.width(t, rho) / 2.0)
            .fold(0.0, f64::max)
    }
}

/// A straight course before it is distorted: from (ring coordinate, angle) to the same.
#[derive(Clone, Copy)]
struct Straight {
    kind: CrackKind,
    from: (f64, f64),
    to: (f64, f64),
    depth: f64,
    range: f64,
    shrinkage: f64,
}

/// Plans the cracks of a face.
///
/// `shrinkage` is that of the wood along and across its rings (ε_tangential, ε_radial, parts of 1) at its moisture. Cracks
/// with a shrinkage of their own take that.
///
/// ```
/// use greenstick_fracture::cracks::plan;
/// use greenstick_fracture::parameters::CrackParameters;
///
/// let none = plan(&CrackParameters::default(), (0.08, 0.04), 1);
/// assert!(none.cracks.is_empty());
/// ```
pub fn plan(parameters: &CrackParameters, shrinkage: (f64, f64), seed: u64) -> CrackPlan {
    let mut all: Vec<Straight> = parameters
        .cracks
        .iter()
        .map(|crack| match crack {
            Crack::Radial(c) => radial(c, shrinkage.0),
            Crack::Tangential(c) => tangential(c, shrinkage.1),
        })
        .collect();
    let s = &parameters.settings;
    for (g, group) in [&s.large, &s.medium, &s.small].into_iter().enumerate() {
        all.extend((0..group.count).map(|i| drawn(group, g, i, shrinkage.0, seed)));
    }
    let mut plan = CrackPlan::default();
    let mut taken: Vec<(Course, f64)> = Vec::new();
    for (number, straight) in all.iter().enumerate() {
        let fits = LENGTH_ATTEMPTS.iter().find_map(|&part| {
            let crack = distorted(&shortened(straight, part), s.distortion, seed, number);
            let (course, half) = (Course::new(crack.points()), crack.half_width());
            let free =
                (taken.iter()).all(|(other, h)| course.keeps(half + h + MIN_DISTANCE, other));
            free.then_some((crack, course, half, part))
        });
        match fits {
            Some((crack, course, half, part)) => {
                plan.shortened += usize::from(part < 1.0);
                taken.push((course, half));
                plan.cracks.push(crack);
            }
            None => plan.skipped += 1,
        }
    }
    plan
}

fn radial(c: &RadialCrack, shrinkage: f64) -> Straight {
    let phi = c.angle.to_radians();
    Straight {
        kind: CrackKind::Radial,
        from: (c.begin, phi),
        to: (c.end, phi),
        depth: c.depth,
        range: c.range.to_radians(),
        shrinkage: c.shrinkage.unwrap_or(shrinkage),
    }
}

fn tangential(c: &TangentialCrack, shrinkage: f64) -> Straight {
    // An end below the beginning lies past 360°.
    let turn = if c.end < c.begin { 360.0 } else { 0.0 };
    Straight {
        kind: CrackKind::Tangential,
        from: (c.ring, c.begin.to_radians()),
        // A crack all around would meet itself.
        to: (c.ring, (c.end + turn).min(c.begin + 350.0).to_radians()),
        depth: c.depth,
        range: c.range,
        shrinkage: c.shrinkage.unwrap_or(shrinkage),
    }
}

fn drawn(group: &CrackGroup, which: usize, i: u32, shrinkage: f64, seed: u64) -> Straight {
    let random = |purpose: u64| noise::unit(seed ^ purpose << 20, which as i64, i64::from(i), 0);
    let between = |purpose, low: f64, high: f64| low + (high - low) * random(purpose);
    let off = group.jitter * (random(purpose::ANGLE) - 0.5);
    let phi = (group.direction + group.spacing * (f64::from(i) + off)).to_radians();
    let begin = between(purpose::BEGIN, group.begin_min, group.begin_max);
    let end = begin + between(purpose::LENGTH, group.length_min, group.length_max);
    Straight {
        kind: CrackKind::Radial,
        from: (begin, phi),
        to: (end.min(1.0), phi),
        depth: between(purpose::DEPTH, group.depth_min, group.depth_max),
        range: between(purpose::RANGE, group.range_min, group.range_max).to_radians(),
        shrinkage: group.shrinkage.unwrap_or(shrinkage),
    }
}

/// Shortens a course to a share of it: for a radial crack the outer one, where it is widest and most visible, for a tangential one the
/// middle.
fn shortened(s: &Straight, part: f64) -> Straight {
    let mut s = *s;
    match s.kind {
        CrackKind::Radial => s.from.0 = s.to.0 - part * (s.to.0 - s.from.0),
        CrackKind::Tangential => {
            let cut = 0.5 * (1.0 - part) * (s.to.1 - s.from.1);
            s.from.1 += cut;
            s.to.1 -= cut;
        }
    }
    s
}

/// Returns the crack with the random displacement of its course (Fig. 12(b)), at most `amount` radii in both directions. Where
/// the opening would fold over itself in a tight bend, the displacement is halved.
fn distorted(s: &Straight, amount: f64, seed: u64, number: usize) -> PlannedCrack {
    let open = s.kind == CrackKind::Radial && s.to.0 >= OPEN_END;
    let fractions: Vec<f64> = (0..=STEPS)
        .map(|i| {
            // Closer together at closed ends, where the bottom rises steeply.
            let t = i as f64 / STEPS as f64;
            if open {
                1.0 - libm::cos(t * TAU / 4.0)
            } else {
                0.5 - 0.5 * libm::cos(t * TAU / 2.0)
            }
        })
        .collect();
    let mut amount = amount;
    loop {
        let crack = PlannedCrack {
            kind: s.kind,
            course: fractions
                .iter()
                .map(|&t| displaced(s, t, amount, seed, number))
                .collect(),
            fractions: fractions.clone(),
            open_at_bark: open,
            depth: s.depth,
            range: s.range,
            shrinkage: s.shrinkage,
        };
        if amount < 1e-4 || !folds(&crack) {
            return crack;
        }
        amount *= 0.5;
    }
}

fn displaced(s: &Straight, t: f64, amount: f64, seed: u64, number: usize) -> (f64, f64) {
    let mix = |a: f64, b: f64| a + (b - a) * t;
    let (rho, phi) = (mix(s.from.0, s.to.0), mix(s.from.1, s.to.1));
    let along = match s.kind {
        CrackKind::Radial => rho,
        CrackKind::Tangential => rho * phi,
    };
    let wander = |purpose: u64| {
        let seed = (seed ^ purpose << 20) + ((number as u64) << 8);
        (0..3).fold(0.0, |sum, octave: u64| {
            let scale = (1u64 << octave) as f64;
            sum + noise::value_1d(seed + octave, along * WAVES_PER_RADIUS * scale) / (1.75 * scale)
        })
    };
    // The ends of a crack keep their position along it.
    let (radial, tangential) = match s.kind {
        CrackKind::Radial => (
            0.3 * amount * wander(purpose::ALONG) * (4.0 * t * (1.0 - t)),
            amount * wander(purpose::ACROSS),
        ),
        CrackKind::Tangential => (
            amount * wander(purpose::ACROSS),
            0.3 * amount * wander(purpose::ALONG) * (4.0 * t * (1.0 - t)),
        ),
    };
    // Near the pith an angle is not much of a displacement, so it fades with the ring.
    let turn = tangential / rho.max(0.25);
    (rho + radial, phi + turn)
}

/// Whether a crack's flanks run backwards anywhere.
fn folds(crack: &PlannedCrack) -> bool {
    let unit = crack.points();
    let normal = |i: usize| {
        let d = unit[(i + 1).min(unit.len() - 1)] - unit[i.saturating_sub(1)];
        d.perp().normalize_or_zero()
    };
    (1..unit.len()).any(|i| {
        let step = unit[i] - unit[i - 1];
        [-1.0, 1.0].iter().any(|side| {
            let flank = |j: usize| {
                unit[j] + normal(j) * side * 0.5 * crack.width(crack.fractions[j], unit[j].length())
            };
            (flank(i) - flank(i - 1)).dot(step) < 0.1 * step.length_squared()
        })
    })
}

/// A course in ring coordinates, and the rectangle around it.
struct Course {
    points: Vec<DVec2>,
    low: DVec2,
    high: DVec2,
}

impl Course {
    fn new(points: Vec<DVec2>) -> Self {
        let around = |f: fn(DVec2, DVec2) -> DVec2| points.iter().copied().reduce(f);
        Course {
            low: around(DVec2::min).unwrap_or_default(),
            high: around(DVec2::max).unwrap_or_default(),
            points,
        }
    }

    /// Whether a course keeps more than a distance from another.
    fn keeps(&self, distance: f64, other: &Course) -> bool {
        let is_near = |low: DVec2, high: DVec2| {
            (low - distance).cmple(other.high).all() && (high + distance).cmpge(other.low).all()
        };
        let steps = self.points.windows(2);
        !is_near(self.low, self.high)
            || (steps.filter(|p| is_near(p[0].min(p[1]), p[0].max(p[1])))).all(|p| {
                let mut others = other.points.windows(2);
                others.all(|q| step_distance(p, q) > distance)
            })
    }
}

/// Returns the least distance between two steps of courses; 0 where they cross.
fn step_distance(p: &[DVec2], q: &[DVec2]) -> f64 {
    let side = |r: &[DVec2], x: DVec2| (r[1] - r[0]).perp_dot(x - r[0]);
    if side(p, q[0]) * side(p, q[1]) < 0.0 && side(q, p[0]) * side(q, p[1]) < 0.0 {
        return 0.0;
    }
    let to = |p: DVec2, q: &[DVec2]| {
        let d = q[1] - q[0];
        let t = ((p - q[0]).dot(d) / d.length_squared().max(1e-300)).clamp(0.0, 1.0);
        p.distance(q[0] + d * t)
    };
    let ends = [to(p[0], q), to(p[1], q), to(q[0], p), to(q[1], p)];
    ends.into_iter().fold(f64::INFINITY, f64::min)
}
