//! Splinters that snapped on their way: the part beyond the kink hangs to one side by the fibres that still hold.

use super::place::FacetPlaces;
use super::tree::SplinterTree;
use glam::DVec2;
use greenstick_fracture::surface::{FractureSurface, NONE};
use greenstick_wood::noise;

/// Least length and slenderness (length over the root of the section's area) of a splinter that snaps, radii and a ratio, and its
/// greatest area as part of the stem's.
const LENGTH: f64 = 0.28;
const SLENDERNESS: f64 = 2.6;
const AREA: f64 = 0.03;
/// Parts of a splinter's length between which it snaps.
const KINKS: (f64, f64) = (0.12, 0.55);
/// Least length of what hangs, radii.
const LEAST_HANGING: f64 = 0.14;
/// Angles by which it turns, degrees, and shares of that which are tried one after the other where there is no room.
const ANGLES: (f64, f64) = (16.0, 125.0);
const SHARES: [f64; 4] = [1.0, 0.75, 0.55, 0.35];
/// Length of the kink: at least, and at most more, radii.
const KINK: (f64, f64) = (0.045, 0.07);
/// Number of directions that are looked at, of places along what hangs, and the distance from the wood below that is room enough,
/// radii.
const DIRECTIONS: usize = 12;
const PLACES: usize = 7;
const ROOM: f64 = 0.05;
/// In the hash: what random numbers are drawn for.
const PURPOSE: u64 = 0x54a9;

/// A splinter that snapped.
#[derive(Debug, Clone, Copy)]
pub(super) struct Snap {
    branch: u32,
    /// Height from which on it is turned, m.
    pub from: f64,
    /// A point of the line about which it turns, and the side that it turns to.
    hinge: DVec2,
    pub toward: DVec2,
    /// Angle, rad; 0 where it does not snap after all.
    angle: f64,
    /// Length over which it is bent, m.
    over: f64,
}

impl Snap {
    /// Returns where a place of the section at a height goes, and the angle by which it is turned.
    pub fn moved(&self, at: DVec2, height: f64) -> (DVec2, f64, f64) {
        let way = (height - self.from).max(0.0);
        let turned = self.angle * (way / self.over).min(1.0);
        let (sin, cos) = libm::sincos(turned);
        let bend = self.over / self.angle;
        let rest = (way - self.over).max(0.0);
        let (aside, up) = (bend * (1.0 - cos) + rest * sin, bend * sin + rest * cos);
        let off = (at - self.hinge).dot(self.toward);
        let to = at + self.toward * (aside + off * (cos - 1.0));
        (to, self.from + up - off * sin, turned)
    }
}

/// The splinters of a side of a face that snapped.
#[derive(Debug, Clone, Default)]
pub(super) struct Snaps {
    snaps: Vec<Snap>,
    /// For each branch that which it goes along with.
    of: Vec<u32>,
}

impl Snaps {
    /// Draws a share of the slender splinters, and turns each to where there is room.
    pub fn new(
        (tree, places): (&SplinterTree, &FacetPlaces),
        (surface, sign): (&FractureSurface, f64),
        radius: f64,
        share: f64,
        seed: u64,
    ) -> Snaps {
        let mut made = Snaps {
            snaps: Vec::new(),
            of: vec![NONE; tree.branches.len()],
        };
        if share <= 0.0 {
            return made;
        }
        let seed = seed ^ PURPOSE << 20;
        let section = std::f64::consts::PI * radius * radius;
        for &number in &tree.order {
            let branch = &tree.branches[number as usize];
            let length = branch.length();
            let random = |k: i64| noise::unit(seed, i64::from(number), k, 0);
            let part = KINKS.0 + (KINKS.1 - KINKS.0) * random(1);
            let snaps = branch.parent != NONE
                && random(0) < share
                && length >= LENGTH * radius
                && length * (1.0 - part) >= LEAST_HANGING * radius
                && length >= SLENDERNESS * branch.foot_area().sqrt()
                && branch.foot_area() <= AREA * section;
            let (least, more) = KINK;
            if snaps {
                made.of[number as usize] = made.snaps.len() as u32;
                made.snaps.push(Snap {
                    branch: number,
                    from: branch.from + part * length,
                    hinge: DVec2::ZERO,
                    toward: DVec2::X,
                    angle: 0.0,
                    over: (least + more * random(2)) * radius,
                });
            }
        }
        let sections = made.sections(tree, (surface, sign));
        for (snap, section) in made.snaps.iter_mut().zip(sections) {
            let tip = tree.branches[snap.branch as usize].to;
            snap.turn((&section, tip), places, radius, seed);
        }
        made.carry(tree);
        made
    }

    /// Finds out what goes along with what snaps.
    fn carry(&mut self, tree: &SplinterTree) {
        for &number in &tree.order {
            let branch = &tree.branches[number as usize];
            let parent = match branch.parent {
                NONE => NONE,
                parent => self.of[parent as usize],
            };
            // A splinter on one that snaps does not snap by itself.
            if let Some(snap) = self.snaps.get(parent as usize)
                && snap.angle > 0.0
                && branch.from >= snap.from
            {
                let own = self.of[number as usize];
                if let Some(own) = self.snaps.get_mut(own as usize) {
                    own.angle = 0.0;
                }
                self.of[number as usize] = parent;
            }
        }
    }

    /// Returns the nodes of each one's section at its kink.
    fn sections(
        &self,
        tree: &SplinterTree,
        (surface, sign): (&FractureSurface, f64),
    ) -> Vec<Vec<DVec2>> {
        let layout = surface.layout.as_ref();
        let mut sections = vec![Vec::new(); self.snaps.len()];
        for (f, facet) in layout.facets.iter().enumerate() {
            let cell = layout.cells[f];
            let heights = surface.heights[f].map(|h| sign * h);
            let top = heights[0].max(heights[1]).max(heights[2]);
            let mut branch = cell;
            while branch != NONE {
                let of = self.of[branch as usize];
                if let Some(snap) = self.snaps.get(of as usize)
                    && top >= snap.from
                    && tree.branch_at(cell, snap.from) == branch
                {
                    let above = (0..3).filter(|&k| heights[k] >= snap.from);
                    let nodes = above.map(|k| layout.nodes[facet[k] as usize]);
                    sections[of as usize].extend(nodes);
                }
                branch = tree.branches[branch as usize].parent;
            }
        }
        sections
    }

    /// Returns that which a cell's wood at a height goes along with.
    pub fn of(&self, branch: u32, height: f64) -> Option<(u32, &Snap)> {
        let number = self.of[branch as usize];
        let snap = self.snaps.get(number as usize)?;
        (snap.angle > 0.0 && height > snap.from).then_some((number, snap))
    }

    /// Makes one turn less, or not at all.
    pub fn lessen(&mut self, number: u32) {
        let snap = &mut self.snaps[number as usize];
        snap.angle *= LESS;
        if snap.angle < LEAST_TURN {
            snap.angle = 0.0;
        }
    }

    /// Makes none turn.
    pub fn straighten(&mut self) {
        self.snaps.iter_mut().for_each(|snap| snap.angle = 0.0);
    }

    /// Returns how many there are.
    pub fn count(&self) -> usize {
        self.snaps.iter().filter(|snap| snap.angle > 0.0).count()
    }
}

/// Factor on the angle of one that crosses others, and the angle (rad) below which it stays straight.
const LESS: f64 = 0.5;
const LEAST_TURN: f64 = 0.22;

impl Snap {
    /// Turns a splinter with a section and a tip to the side with the most room, as far as there is some.
    fn turn(
        &mut self,
        (section, tip): (&[DVec2], f64),
        places: &FacetPlaces,
        radius: f64,
        seed: u64,
    ) {
        if section.is_empty() {
            return;
        }
        let random = |k: i64| noise::unit(seed, i64::from(self.branch), k, 1);
        let middle = section.iter().sum::<DVec2>() / section.len() as f64;
        let (least, most) = ANGLES;
        // Most snapped half through.
        let angle = (least + (most - least) * random(0) * random(0)).to_radians();
        let length = tip - self.from;
        let mut best: Option<(f64, DVec2, DVec2)> = None;
        for share in SHARES {
            let (sin, cos) = libm::sincos(angle * share);
            for direction in 0..DIRECTIONS {
                let turn =
                    std::f64::consts::TAU * (direction as f64 + random(1)) / DIRECTIONS as f64;
                let (y, x) = libm::sincos(turn);
                let toward = DVec2::new(x, y);
                let reach = |way: DVec2| {
                    (section.iter()).fold(0.0, |far: f64, p| far.max((*p - middle).dot(way)))
                };
                let hinge = middle + toward * reach(toward);
                let half = toward.perp() * reach(toward.perp()).max(reach(-toward.perp()));
                let room = (1..=PLACES).flat_map(|k| {
                    let way = length * k as f64 / PLACES as f64;
                    let under = self.from + way * cos;
                    [-half, DVec2::ZERO, half].map(|beside| {
                        let ground = places.highest(hinge + toward * (way * sin) + beside);
                        ground.map_or(f64::INFINITY, |(_, height)| under - height)
                    })
                });
                // Next to the hinge its own foot is the highest.
                let room = room.skip(3).fold(f64::INFINITY, f64::min);
                if best.is_none_or(|b| room > b.0) {
                    best = Some((room, toward, hinge));
                }
            }
            if let Some((room, toward, hinge)) = best.take()
                && room > ROOM * radius
            {
                (self.toward, self.hinge, self.angle) = (toward, hinge, angle * share);
                return;
            }
        }
    }
}
