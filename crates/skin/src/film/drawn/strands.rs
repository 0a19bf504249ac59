//! The strand of rods that a piece follows where it is split lengthwise: each of those that hang on whole wood moves as it
//! likes, and their mean would jump where one of them ends.

use crate::rods::{FractureState, RodPart, Wood};
use greenstick_geometry::Unions;
use std::collections::BTreeMap;

/// Least share of the stem's section of a strand that a piece follows.
const LEADING_SHARE: f64 = 0.15;

/// Parts of rods at a section: rod and part, ascending.
#[derive(Debug, Clone, Default)]
pub(super) struct SectionParts(pub Vec<(u32, RodPart)>);

impl SectionParts {
    /// The area of their cells, m².
    pub fn area(&self, wood: &Wood) -> f64 {
        let areas = self.0.iter().map(|p| wood.cells[p.0 as usize].area);
        areas.sum()
    }

    /// The area of the cells of those rods that are in another section, too, m².
    fn overlap(&self, other: &SectionParts, wood: &Wood) -> f64 {
        let shared = (self.0.iter()).filter(|p| other.0.binary_search(p).is_ok());
        shared.map(|p| wood.cells[p.0 as usize].area).sum()
    }
}

/// A bond that holds.
struct HeldBond {
    /// Length along the axis, m.
    along: f64,
    parts: [(u32, RodPart); 2],
}

/// The bonds that hold in a state, along the stem.
pub(super) struct HeldBonds {
    bonds: Vec<HeldBond>,
    /// Distance along the axis (m) up to which bonds count at a section.
    reach: f64,
}

impl HeldBonds {
    pub fn new(wood: &Wood, state: &FractureState) -> Self {
        let rod_of = wood.rods_of_vertices();
        let bonds = &wood.bundle.bonds;
        let mut held = Vec::new();
        for (bond, parts) in state.bonded_parts.iter().enumerate() {
            let vertex = bonds.vertex[bond] as usize;
            let rods = [rod_of[vertex], rod_of[bonds.edge[bond] as usize]];
            held.extend(parts.iter().flatten().map(|&(a, b)| HeldBond {
                along: wood.along[vertex],
                parts: [(rods[0], a), (rods[1], b)],
            }));
        }
        held.sort_by(|a, b| a.along.total_cmp(&b.along));
        HeldBonds {
            bonds: held,
            reach: wood.stem.radius,
        }
    }

    /// Divides the parts of a section at a length along the axis (m) into those that bonds near it hold together.
    fn strands(&self, parts: &SectionParts, along: f64) -> Vec<SectionParts> {
        let number = |part: &(u32, RodPart)| parts.0.binary_search(part).ok();
        let mut unions = Unions::new(parts.0.len());
        let from = self.bonds.partition_point(|b| b.along < along - self.reach);
        let near = self.bonds[from..].iter();
        for bond in near.take_while(|b| b.along <= along + self.reach) {
            if let [Some(a), Some(b)] = [0, 1].map(|k| number(&bond.parts[k])) {
                unions.join(a as u32, b as u32);
            }
        }
        let mut strands: BTreeMap<u32, SectionParts> = BTreeMap::new();
        for (k, &part) in parts.0.iter().enumerate() {
            strands
                .entry(unions.root(k as u32))
                .or_default()
                .0
                .push(part);
        }
        strands.into_values().collect()
    }

    /// Returns of the parts at each section those of one strand: the one that reaches farthest from where the piece has most of
    /// the stem's section, to either side, with no less than [`LEADING_SHARE`] of the stem's `section` (m²). `along` are the
    /// lengths of sections, m.
    pub fn leading_strand(
        &self,
        wood: &Wood,
        (along, section): (&[f64], f64),
        parts: &[SectionParts],
    ) -> Vec<SectionParts> {
        let area = |k: &usize| parts[*k].area(wood);
        let Some(middle) = (0..parts.len()).max_by(|a, b| area(a).total_cmp(&area(b))) else {
            return Vec::new();
        };
        let strands = |k: usize| self.strands(&parts[k], along[k]);
        let best = |k: usize, size: &dyn Fn(&SectionParts) -> f64| {
            let strand = strands(k)
                .into_iter()
                .max_by(|a, b| size(a).total_cmp(&size(b)));
            strand.filter(|s| size(s) > 0.0).unwrap_or_default()
        };
        let mut leading = vec![SectionParts::default(); parts.len()];
        let sides: [Vec<usize>; 2] = [
            (middle..parts.len()).collect(),
            (0..=middle).rev().collect(),
        ];
        for side in sides {
            let leads = |k: usize| best(k, &|s| s.area(wood)).area(wood) >= LEADING_SHARE * section;
            let Some(end) = (0..side.len()).rev().find(|&n| leads(side[n])) else {
                continue;
            };
            leading[side[end]] = best(side[end], &|s| s.area(wood));
            let inward = (0..end).rev().map(|n| (side[n + 1], side[n]));
            let outward = (end + 1..side.len()).map(|n| (side[n - 1], side[n]));
            for (from, to) in inward.chain(outward) {
                let before = leading[from].clone();
                leading[to] = best(to, &|s| s.overlap(&before, wood));
            }
        }
        leading
    }
}
