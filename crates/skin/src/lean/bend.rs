//! How far splinters lean: for each one a displacement across the grain that grows with the height.
//!
//! All that stands on a splinter at one height moves as one, so that sections keep their shape and, but for the straight sides
//! of triangles, their area.

use super::tree::{Branch, SplinterTree};
use glam::DVec2;
use greenstick_fracture::surface::NONE;
use greenstick_wood::noise;

/// Heights at which displacements are kept.
const STEPS: usize = 192;
/// Areas of a section, as parts of that of the stem, from which on it is too thick to bend and up to which it bends freely.
const STIFF: f64 = 0.3;
const LIMP: f64 = 0.035;
/// Least length of a splinter that leans by itself, in radii and over the root of its section's area.
const MIN_LENGTH: f64 = 0.1;
const MIN_SLENDERNESS: f64 = 1.4;
/// Factors on the mean lean between which that of splinters lies.
const LEANS: (f64, f64) = (0.45, 1.55);
/// Slenderness (length over the root of the section's area) of a splinter that leans by the mean, the power of it that others lean
/// by, and the least and greatest factor that it leads to.
const SLENDERNESS: f64 = 6.0;
const SLENDERNESS_POWER: f64 = 0.5;
const SLENDERNESS_FACTORS: (f64, f64) = (0.6, 1.7);
/// How much of the direction in which a splinter leans is away from what it parted from, how much is outwards, and how much chance.
const APART: f64 = 0.7;
const OUTWARDS: f64 = 0.45;
const CHANCE: f64 = 0.8;
/// Mean and range of how much more a splinter leans at its tip than in its middle, as a part: it is a cantilever, whose slope grows
/// from its root on.
const BOW: (f64, f64) = (0.8, 0.2);
/// How much a splinter bends to the side of the way in which it leans, as part of its lean.
const SWAY: f64 = 0.8;
/// Greatest slope of all splinters that stand on each other together, over that of the mean lean.
const STEEPEST: f64 = 3.2;
/// How much of its lean is left to a splinter that crossed others, and how often before it goes with what it grew on.
const DAMPING: f64 = 0.5;
const MOST_DAMPED: u8 = 2;
/// In the hash: what random numbers are drawn for.
const PURPOSE: u64 = 0x1ea4;

/// The lean of the splinters of a side of a face.
pub(super) struct Leans {
    pub tree: SplinterTree,
    /// The branch whose displacement each has: its own, or that which it grew on.
    bends_as: Vec<u32>,
    targets: Vec<Target>,
    /// How often each was damped.
    damped: Vec<u8>,
    /// Displacements (m) at even heights from `low` on.
    tables: Vec<Vec<DVec2>>,
    low: f64,
    step: f64,
    /// Area of the stem's section, m².
    section: f64,
    /// Greatest slope.
    steepest: f64,
}

/// How a splinter is to lean.
#[derive(Debug, Clone, Copy, Default)]
struct Target {
    /// Tangent of its lean in the middle of its length.
    lean: DVec2,
    /// How much larger that is at its tip, as a part.
    bow: f64,
    /// Tangent of its sway, and its phase, rad.
    sway: DVec2,
    phase: f64,
}

impl Target {
    /// Returns the slope at a part of the length, over that at the root.
    fn slope(&self, along: f64) -> DVec2 {
        let sway = libm::sin(self.phase + 4.0 * along) - libm::sin(self.phase);
        self.lean * (1.0 + self.bow * (2.0 * along - 1.0)) + self.sway * (sway * along)
    }
}

impl Branch {
    /// Draws how a splinter is to lean about a mean (degrees) on a stem with a radius and a middle (m).
    fn target(
        &self,
        (radius, middle): (f64, DVec2),
        degrees: f64,
        random: impl Fn(i64) -> f64,
    ) -> Target {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * random(0));
        let way = self.aside.normalize_or_zero() * APART
            + (self.middle - middle) * (OUTWARDS / radius)
            + DVec2::new(cos, sin) * CHANCE;
        let way = way.normalize_or_zero();
        let slenderness = self.length() / self.foot_area().sqrt().max(f64::MIN_POSITIVE);
        let (least, most) = SLENDERNESS_FACTORS;
        let slender = libm::pow(slenderness / SLENDERNESS, SLENDERNESS_POWER);
        let slender = if slender.is_finite() {
            slender.clamp(least, most)
        } else {
            1.0
        };
        let lean = degrees * (LEANS.0 + (LEANS.1 - LEANS.0) * random(1)) * slender;
        let tangent = libm::tan(lean.to_radians());
        let sway = SWAY * tangent * (2.0 * random(3) - 1.0);
        Target {
            lean: way * tangent,
            bow: BOW.0 + BOW.1 * (2.0 * random(2) - 1.0),
            sway: way.perp() * sway,
            phase: std::f64::consts::TAU * random(4),
        }
    }
}

/// A splinter's lean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SplinterLean {
    /// Length of the splinter, m.
    pub length: f64,
    /// Angle of the line from its foot to its tip with the grain, degrees.
    pub degrees: f64,
}

impl Leans {
    /// Draws the leans of splinters about a mean (degrees).
    pub fn new(
        tree: SplinterTree,
        (radius, middle): (f64, DVec2),
        degrees: f64,
        seed: u64,
    ) -> Leans {
        let cells = tree.branches.len();
        let ends = |pick: fn(f64, f64) -> f64, start: f64| {
            let finite = tree
                .branches
                .iter()
                .map(|b| b.from)
                .filter(|h| h.is_finite());
            let tips = tree.branches.iter().map(|b| b.to).filter(|h| h.is_finite());
            finite.chain(tips).fold(start, pick)
        };
        let (low, high) = (
            ends(f64::min, f64::INFINITY),
            ends(f64::max, f64::NEG_INFINITY),
        );
        let mut leans = Leans {
            bends_as: (0..cells as u32).collect(),
            targets: vec![Target::default(); cells],
            damped: vec![0; cells],
            tables: vec![Vec::new(); cells],
            low,
            step: ((high - low) / STEPS as f64).max(f64::MIN_POSITIVE),
            section: std::f64::consts::PI * radius * radius,
            steepest: STEEPEST * libm::tan(degrees.to_radians()),
            tree,
        };
        for i in 0..leans.tree.order.len() {
            let number = leans.tree.order[i];
            let branch = &leans.tree.branches[number as usize];
            let slender = branch.length() >= MIN_LENGTH * radius
                && branch.length() >= MIN_SLENDERNESS * branch.foot_area().sqrt();
            if branch.parent != NONE && !slender {
                leans.bends_as[number as usize] = leans.bends_as[branch.parent as usize];
                continue;
            }
            leans.targets[number as usize] = branch.target((radius, middle), degrees, |k| {
                noise::unit(seed ^ PURPOSE << 20, i64::from(number), k, 0)
            });
        }
        leans.bend();
        leans
    }

    /// Returns how freely a section of an area (m²) bends, 0 to 1.
    fn limpness(&self, area: f64) -> f64 {
        let part = (area / self.section).max(1e-12);
        1.0 - noise::smoothstep(libm::log(LIMP), libm::log(STIFF), libm::log(part))
    }

    /// Computes all displacements anew.
    fn bend(&mut self) {
        for i in 0..self.tree.order.len() {
            let number = self.tree.order[i] as usize;
            if self.bends_as[number] as usize == number {
                self.tables[number] = self.table(number);
            }
        }
    }

    fn table(&self, number: usize) -> Vec<DVec2> {
        let branch = &self.tree.branches[number];
        let below = (branch.parent != NONE).then(|| self.bends_as[branch.parent as usize]);
        let share = match self.damped[number] {
            n if n >= MOST_DAMPED => 0.0,
            n => (0..n).fold(1.0, |share, _| share * DAMPING),
        };
        let target = self.targets[number];
        // The slope of what it stands on, at its root, times a step.
        let mut root = DVec2::ZERO;
        let mut table = Vec::with_capacity(STEPS + 1);
        let mut at = DVec2::ZERO;
        let mut areas = branch.areas.iter().rev().peekable();
        let mut area = areas.peek().map_or(0.0, |a| a.1);
        let from = if branch.from.is_finite() {
            branch.from
        } else {
            self.low
        };
        for k in 0..=STEPS {
            let height = self.low + self.step * k as f64;
            table.push(at);
            let carried = below.map_or(DVec2::ZERO, |b| {
                let table = &self.tables[b as usize];
                table[(k + 1).min(STEPS)] - table[k]
            });
            // The next step is a splinter's own only where all of it lies above its foot.
            if height < from {
                at += carried;
                root = carried;
                continue;
            }
            while let Some(&&(until, of)) = areas.peek() {
                area = of;
                if until > height {
                    break;
                }
                areas.next();
            }
            let along = ((height - from) / (branch.to - from).max(self.step)).min(1.0);
            let own = root + target.slope(along) * self.step;
            let own = own.clamp_length_max(self.steepest * self.step);
            at += carried + (own - carried) * (share * self.limpness(area));
        }
        table
    }

    /// Returns the displacement of a cell's wood at a height and its slope.
    pub fn at(&self, cell: u32, height: f64) -> (DVec2, DVec2) {
        let branch = self.bends_as[self.tree.branch_at(cell, height) as usize];
        let table = &self.tables[branch as usize];
        let place = ((height - self.low) / self.step).clamp(0.0, STEPS as f64);
        let k = (place as usize).min(STEPS - 1);
        let (a, b) = (table[k], table[k + 1]);
        (a.lerp(b, place - k as f64), (b - a) / self.step)
    }

    /// Returns the splinter that a cell's wood at a height belongs to, or the one that it grew on where it has no lean of its own
    /// left; `None` where none has.
    pub fn blame(&self, cell: u32, height: f64) -> Option<u32> {
        let mut branch = self.bends_as[self.tree.branch_at(cell, height) as usize];
        while self.damped[branch as usize] >= MOST_DAMPED {
            let parent = self.tree.branches[branch as usize].parent;
            if parent == NONE {
                return None;
            }
            branch = self.bends_as[parent as usize];
        }
        Some(branch)
    }

    /// Returns the thinnest of some splinters: the others are spared as long as that is enough.
    pub fn thinnest(&self, branches: impl Iterator<Item = u32>) -> Option<u32> {
        let area = |b: &u32| self.tree.branches[*b as usize].foot_area();
        branches.min_by(|a, b| area(a).total_cmp(&area(b)).then(a.cmp(b)))
    }

    /// Makes splinters lean less.
    pub fn damp(&mut self, branches: &[u32]) {
        for &branch in branches {
            self.damped[branch as usize] = (self.damped[branch as usize] + 1).min(MOST_DAMPED);
        }
        self.bend();
    }

    /// Makes nothing lean.
    pub fn straighten(&mut self) {
        self.damped.fill(MOST_DAMPED);
        self.bend();
    }

    /// Returns the lean of every splinter that is long and slender enough to have one.
    pub fn splinters(&self) -> Vec<SplinterLean> {
        let own = (0..self.tree.branches.len()).filter(|&b| self.bends_as[b] as usize == b);
        own.filter(|&b| self.tree.branches[b].parent != NONE)
            .map(|b| {
                let branch = &self.tree.branches[b];
                let table = &self.tables[b];
                let at = |height: f64| {
                    let place = ((height - self.low) / self.step).clamp(0.0, STEPS as f64);
                    let k = (place as usize).min(STEPS - 1);
                    table[k].lerp(table[k + 1], place - k as f64)
                };
                let aside = at(branch.to).distance(at(branch.from));
                SplinterLean {
                    length: branch.length(),
                    degrees: libm::atan(aside / branch.length()).to_degrees(),
                }
            })
            .collect()
    }
}
