//! How far splinters lean: for each one a displacement across the grain that grows with the height.
//!
//! All that stands on a splinter at one height moves as one, so that sections keep their shape and, but for the straight sides
//! of triangles, their area.

use super::tree::SplinterTree;
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
const LEANS: (f64, f64) = (0.6, 1.4);
/// How much of the direction in which a splinter leans is away from what it parted from, and how much is chance.
const APART: f64 = 0.85;
const CHANCE: f64 = 0.7;
/// Mean and range of how much more a splinter leans at its tip than in its middle, as a part.
const BOW: (f64, f64) = (0.2, 0.55);
/// How much of its lean is left to a splinter that crossed others, and how often before it goes with what it grew on.
const DAMPING: f64 = 0.55;
const MOST_DAMPED: u8 = 3;
/// In the hash: what random numbers are drawn for.
const PURPOSE: u64 = 0x1ea4;

/// The lean of the splinters of a side of a face.
pub(super) struct Leans {
    pub tree: SplinterTree,
    /// The branch whose displacement each has: its own, or that which it grew on.
    bends_as: Vec<u32>,
    /// Tangent of the lean of those that have one, in the middle of their length, and their bow.
    targets: Vec<(DVec2, f64)>,
    /// How often each was damped.
    damped: Vec<u8>,
    /// Displacements (m) at even heights from `low` on.
    tables: Vec<Vec<DVec2>>,
    low: f64,
    step: f64,
    /// Area of the stem's section, m².
    section: f64,
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
    pub fn new(tree: SplinterTree, radius: f64, degrees: f64, seed: u64) -> Leans {
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
            targets: vec![(DVec2::ZERO, 0.0); cells],
            damped: vec![0; cells],
            tables: vec![Vec::new(); cells],
            low,
            step: ((high - low) / STEPS as f64).max(f64::MIN_POSITIVE),
            section: std::f64::consts::PI * radius * radius,
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
            let random = |k: i64| noise::unit(seed ^ PURPOSE << 20, i64::from(number), k, 0);
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * random(0));
            let way = branch.aside.normalize_or_zero() * APART + DVec2::new(cos, sin) * CHANCE;
            let lean = degrees * (LEANS.0 + (LEANS.1 - LEANS.0) * random(1));
            let tangent = libm::tan(lean.to_radians());
            let bow = BOW.0 + BOW.1 * (2.0 * random(2) - 1.0);
            leans.targets[number as usize] = (way.normalize_or_zero() * tangent, bow);
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
        let (target, bow) = self.targets[number];
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
            let own = target * (1.0 + bow * (2.0 * along - 1.0)) * self.step;
            at += carried + (own - carried) * (share * self.limpness(area));
        }
        table
    }

    /// Returns the displacement of a cell's wood at a height and its slope.
    pub fn at(&self, cell: u32, height: f64) -> (DVec2, DVec2) {
        let branch = self.bends_as[self.tree.branch_at(cell, height) as usize];
        let table = &self.tables[branch as usize];
        // What lies over a tip goes along with it.
        let height = height.min(self.tree.branches[branch as usize].to);
        let place = ((height - self.low) / self.step).clamp(0.0, STEPS as f64);
        let k = (place as usize).min(STEPS - 1);
        let (a, b) = (table[k], table[k + 1]);
        (a.lerp(b, place - k as f64), (b - a) / self.step)
    }

    /// Returns the height up to which nothing moves.
    pub fn foot(&self) -> f64 {
        let still = |table: &Vec<DVec2>| table.iter().take_while(|d| **d == DVec2::ZERO).count();
        let tables = self.tables.iter().filter(|t| !t.is_empty());
        let least = tables.map(still).min().unwrap_or(STEPS + 1);
        self.low + self.step * (least.max(1) - 1) as f64
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
