//! From breaks of rods, scattered over the section, to heights on a grid of rings × sectors.
//!
//! A cell takes the mean height of the rod it lies in and of the rods bonded to that one, weighted by area and by a Gaussian of
//! the distance, but only of those that parted together with it: two neighbours are a step apart where bonds between them
//! broke on the way from one height to the other. So steps between groups of rods stay, and inside a group there are no
//! terraces of single rods.

use super::fractures::SimulatedFracture;
use crate::fit::{Weighted, mean_edge_length, quantile};
use crate::rods::{FractureState, Wood};
use glam::{DVec2, DVec3};
use greenstick_fracture::heights::{
    CellFailure, FailureMode, HeightField, HeightFieldError, SectionSpan, grid_middle,
};
use greenstick_wood::stem::Stem;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// Standard deviation of the weights of neighbours, in distances between rods.
const SMOOTHING: f64 = 0.6;
/// Side of a cell of the grid, in distances between rods: steps are that wide.
const CELL: f64 = 0.35;
/// Fewest and most rings and sectors of the grid.
const RINGS: (usize, usize) = (8, 96);
const SECTORS: (usize, usize) = (24, 256);
/// Least height (radii) from a rod to a neighbour along which it was split off …
const SPLIT_HEIGHT: f64 = 1.5;
/// … and the greatest share of that height by which it may differ from most of its neighbours: wood that splits off in one
/// piece is a slab, and wood of which every rod breaks elsewhere is torn.
const SLAB_SCATTER: f64 = 0.25;

/// A rod in the section of a break.
#[derive(Debug, Clone, Copy)]
pub(super) struct SectionRod {
    /// Position in the section, m.
    pub at: DVec2,
    /// Area of its cell, m².
    pub area: f64,
    /// Height of its break over the location, m; `None` for whole rods.
    pub height: Option<f64>,
    /// Height (m) of the face over the location where it passes a whole rod beside broken ones; `None` for others.
    pub root: Option<f64>,
    /// How it failed.
    pub mode: FailureMode,
    /// Median of the heights (m) by which it differs from its neighbours.
    pub scatter: f64,
}

/// The rods of a fracture in the section of a break.
pub(super) struct FracturedSection<'a> {
    stem: &'a Stem,
    pub rods: Vec<SectionRod>,
    /// For each rod, the broken ones that were bonded to it, and whether they parted together.
    neighbours: Vec<Vec<(u32, bool)>>,
    /// Mean distance between rods, m.
    spacing: f64,
}

impl<'a> FracturedSection<'a> {
    /// Takes a fracture to the section of `stem`, which is placed there; `to_grain` leads from the world to its grain
    /// coordinates, m.
    pub fn new(
        wood: &Wood,
        state: &FractureState,
        fracture: &SimulatedFracture,
        stem: &'a Stem,
        to_grain: &dyn Fn(DVec3) -> DVec3,
    ) -> Self {
        let middle = fracture.length_along();
        let rods =
            fracture
                .breaks
                .iter()
                .zip(wood.cells)
                .enumerate()
                .map(|(rod, (broken, cell))| {
                    let length = fracture.length_of_rod(rod);
                    let grain = cell.centroid.extend(length.unwrap_or(middle));
                    let grain = to_grain(wood.stem.grain.to_world(grain));
                    let height = grain.z - stem.location;
                    SectionRod {
                        at: grain.truncate(),
                        area: cell.area,
                        height: broken.map(|_| height),
                        root: length.filter(|_| broken.is_none()).map(|_| height),
                        mode: broken.map_or(FailureMode::Unbroken, |b| b.mode),
                        scatter: 0.0,
                    }
                });
        let mut section = FracturedSection {
            stem,
            rods: rods.collect(),
            neighbours: joined_neighbours(wood, state, fracture),
            spacing: wood.spacing(),
        };
        section.measure_scatter();
        section
    }

    /// Measures how far each rod differs from its neighbours, and marks those that split off.
    fn measure_scatter(&mut self) {
        let heights: Vec<Option<f64>> = self.rods.iter().map(|r| r.height).collect();
        for (rod, neighbours) in self.rods.iter_mut().zip(&self.neighbours) {
            let Some(own) = rod.height else {
                continue;
            };
            let steps = neighbours.iter().filter_map(|&(n, _)| {
                let height = heights[n as usize]?;
                Some(Weighted {
                    value: (height - own).abs(),
                    weight: 1.0,
                })
            });
            let steps: Vec<Weighted> = steps.collect();
            rod.scatter = quantile(&steps, 0.5);
            let highest = quantile(&steps, 1.0);
            let split =
                highest > SPLIT_HEIGHT * self.stem.radius && rod.scatter < SLAB_SCATTER * highest;
            if split && matches!(rod.mode, FailureMode::Torn | FailureMode::Twisted) {
                rod.mode = FailureMode::Split;
            }
        }
    }

    /// The part of the section that the grid lies over.
    fn span(&self) -> SectionSpan {
        if !self.stem.kind.is_sawn() {
            return SectionSpan::WHOLE;
        }
        let addresses = || self.rods.iter().map(|r| self.stem.rings.address(r.at));
        // Angles about the middle of the section as seen from the pith.
        let toward: DVec2 = self
            .rods
            .iter()
            .map(|r| r.at - self.stem.rings.pith())
            .sum();
        let middle = libm::atan2(toward.y, toward.x);
        let off = |phi: f64| {
            let off = phi - middle;
            off - TAU * (off / TAU).round()
        };
        let fold = |values: &mut dyn Iterator<Item = f64>| {
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                (l.min(v), h.max(v))
            })
        };
        let rho = fold(&mut addresses().map(|a| a.0));
        let phi = fold(&mut addresses().map(|a| off(a.1)));
        if !(rho.0 < rho.1 && phi.0 < phi.1) || phi.1 - phi.0 > PI {
            return SectionSpan::WHOLE;
        }
        SectionSpan {
            rho,
            phi: Some((middle + phi.0, middle + phi.1)),
        }
    }

    /// The rings and sectors of the grid over a part of the section.
    fn grid(&self, span: &SectionSpan) -> (usize, usize) {
        let rings = &self.stem.rings;
        let outer = rings.mean_radius(1.0);
        let (deep, wide) = match span.phi {
            None => (outer, TAU * outer),
            Some((a, b)) => ((span.rho.1 - span.rho.0) * outer, (b - a) * outer),
        };
        let cells = |length: f64, (least, most): (usize, usize)| {
            ((length / (CELL * self.spacing)).ceil() as usize).clamp(least, most)
        };
        (cells(deep, RINGS), cells(wide, SECTORS))
    }

    /// Returns the field of heights; `splintering` is the factor on the relief that each rod calls for.
    ///
    /// # Errors
    /// [`HeightFieldError`] where numbers are not finite, which those of a run that was checked are.
    pub fn field(&self, splintering: &[f64]) -> Result<HeightField, HeightFieldError> {
        let span = self.span();
        let (rings, sectors) = self.grid(&span);
        let (mut heights, mut failures) = (Vec::new(), Vec::new());
        for cell in 0..rings * sectors {
            let (rho, phi) = grid_middle(&span, (rings, sectors), cell);
            let at = self.stem.rings.point(rho, phi);
            let owner = self.nearest(at);
            heights.push(self.height(owner, at));
            failures.push(CellFailure {
                mode: self.rods[owner].mode,
                splintering: self.mean(owner, at, |_| true, |rod| splintering[rod]),
            });
        }
        HeightField::over(span, rings, sectors, heights)?.with_failures(failures)
    }

    /// The rod that is nearest to a point of the section.
    fn nearest(&self, at: DVec2) -> usize {
        let (mut best, mut least) = (0, f64::INFINITY);
        for (rod, known) in self.rods.iter().enumerate() {
            let far = known.at.distance_squared(at);
            if far < least {
                (best, least) = (rod, far);
            }
        }
        best
    }

    /// The height at a point that lies in the cell of the rod `owner`.
    fn height(&self, owner: usize, at: DVec2) -> f64 {
        let height = |rod: usize| self.rods[rod].height.unwrap_or(0.0);
        if self.rods[owner].height.is_some() {
            return self.mean(owner, at, |joined| joined, height);
        }
        // The face is laid through whole wood between the ends of the splits about it.
        let splits = self.rods.iter().any(|rod| rod.root.is_some());
        let (mut sum, mut weights) = (0.0, 0.0);
        for rod in &self.rods {
            let height = if splits { rod.root } else { rod.height };
            if let Some(height) = height {
                let far = rod.at.distance_squared(at) + 0.01 * self.spacing * self.spacing;
                let weight = rod.area / (far * far);
                sum += weight * height;
                weights += weight;
            }
        }
        sum / weights.max(f64::MIN_POSITIVE)
    }

    /// The mean of a value over the rod `owner` and those of its neighbours that count, near a point.
    fn mean(
        &self,
        owner: usize,
        at: DVec2,
        counts: impl Fn(bool) -> bool,
        value: impl Fn(usize) -> f64,
    ) -> f64 {
        let width = SMOOTHING * self.spacing;
        let weight = |rod: usize| {
            let far = self.rods[rod].at.distance_squared(at) / (2.0 * width * width);
            self.rods[rod].area * libm::exp(-far)
        };
        let mut weights = weight(owner);
        let mut sum = weights * value(owner);
        for &(rod, joined) in &self.neighbours[owner] {
            if counts(joined) {
                let weight = weight(rod as usize);
                weights += weight;
                sum += weight * value(rod as usize);
            }
        }
        sum / weights.max(f64::MIN_POSITIVE)
    }
}

/// For each rod, the broken rods that were bonded to it, and whether they parted together: no farther from each other than
/// an edge, below which the places of bonds cannot be told apart, or with all bonds between the heights whole.
fn joined_neighbours(
    wood: &Wood,
    state: &FractureState,
    fracture: &SimulatedFracture,
) -> Vec<Vec<(u32, bool)>> {
    let rod_of = wood.rods_of_vertices();
    let bonds = &wood.bundle.bonds;
    let mut broken: BTreeMap<(u32, u32), Vec<f64>> = BTreeMap::new();
    for (bond, parts) in state.bonded_parts.iter().enumerate() {
        let vertex = bonds.vertex[bond] as usize;
        let (a, b) = (rod_of[vertex], rod_of[bonds.edge[bond] as usize]);
        let of_pair = broken.entry((a.min(b), a.max(b))).or_default();
        if parts.iter().all(Option::is_none) {
            of_pair.push(wood.along[vertex]);
        }
    }
    let edge = mean_edge_length(wood);
    let mut neighbours = vec![Vec::new(); fracture.breaks.len()];
    for (&(a, b), lengths) in &broken {
        let both = [a, b].map(|rod| fracture.breaks[rod as usize].map(|e| e.along));
        let [Some(from), Some(to)] = both else {
            continue;
        };
        let between = from.min(to)..=from.max(to);
        let joined = (to - from).abs() <= edge || !lengths.iter().any(|l| between.contains(l));
        neighbours[a as usize].push((b, joined));
        neighbours[b as usize].push((a, joined));
    }
    neighbours
}
