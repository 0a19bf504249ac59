//! Where whole rods pass a fracture: the wood split between them and the broken ones beside them, and what is split off goes with one
//! of the two sides.

use super::observed::{ObservedRun, RodEnd};
use crate::rods::Wood;
use std::collections::BTreeMap;

/// The split between a whole rod and a broken one beside it; lengths along the axis, m.
#[derive(Debug, Clone)]
struct Split {
    /// Where that one broke.
    end: f64,
    /// The bonds between both that broke from there on, to both sides, ascending.
    bonds: Vec<f64>,
}

impl Split {
    fn new(end: f64, mut bonds: Vec<(f64, bool)>) -> Split {
        bonds.sort_by(|a, b| a.0.total_cmp(&b.0));
        let above = bonds.partition_point(|b| b.0 <= end);
        let below = bonds[..above].iter().rev().take_while(|b| b.1).count();
        let beyond = bonds[above..].iter().take_while(|b| b.1).count();
        let broken = bonds[above - below..above + beyond].iter();
        Split {
            end,
            bonds: broken.map(|b| b.0).collect(),
        }
    }

    /// Where it ends on the side on which it is longer, and how long it is there.
    fn longer(&self) -> (f64, f64) {
        let (low, high) = self.ends();
        match self.end - low >= high - self.end {
            true => (low, self.end - low),
            false => (high, high - self.end),
        }
    }

    /// Where it ends on both sides.
    fn ends(&self) -> (f64, f64) {
        let of = |bond: Option<&f64>| bond.copied().unwrap_or(self.end);
        let (low, high) = (of(self.bonds.first()), of(self.bonds.last()));
        (low.min(self.end), high.max(self.end))
    }

    /// The number of its bonds between wood of the same side, where the whole rod passes the fracture at `root`: the face does not
    /// part it there.
    fn hidden(&self, root: f64) -> usize {
        let (low, high) = (root.min(self.end), root.max(self.end));
        self.bonds.iter().filter(|&&b| b < low || b > high).count()
    }
}

/// Returns where a whole rod with these splits beside it passes the fracture: at the end of one of them, so that the least of them
/// lies between wood of the same side; of equals on the side on which the longest one is longer.
fn root(splits: &[Split]) -> Option<f64> {
    let longest = splits.iter().map(Split::longer);
    let longest = longest.reduce(|best, next| if next.1 > best.1 { next } else { best })?;
    let ends = splits.iter().flat_map(|split| {
        let (low, high) = split.ends();
        [low, high]
    });
    let hidden = |root: &f64| splits.iter().map(|s| s.hidden(*root)).sum::<usize>();
    // The first of equals.
    [longest.0].into_iter().chain(ends).min_by_key(hidden)
}

/// Returns where whole rods beside broken ones pass a fracture with these breaks; `None` for others.
pub(super) fn split_roots(
    wood: &Wood,
    run: &ObservedRun,
    breaks: &[Option<RodEnd>],
) -> Vec<Option<f64>> {
    let rod_of = wood.rods_of_vertices();
    let bonds = &wood.bundle.bonds;
    // For each pair of a whole and a broken rod the lengths of bonds, and whether they are broken.
    let mut between: BTreeMap<(usize, usize), Vec<(f64, bool)>> = BTreeMap::new();
    for (bond, held) in run.state.bonded_parts.iter().enumerate() {
        let vertex = bonds.vertex[bond] as usize;
        let (a, b) = (
            rod_of[vertex] as usize,
            rod_of[bonds.edge[bond] as usize] as usize,
        );
        let pair = match (breaks[a].is_some(), breaks[b].is_some()) {
            (false, true) => (a, b),
            (true, false) => (b, a),
            _ => continue,
        };
        let is_broken = held.iter().all(Option::is_none);
        let of_pair = between.entry(pair).or_default();
        of_pair.push((wood.along[vertex], is_broken));
    }
    let mut splits: Vec<Vec<Split>> = vec![Vec::new(); breaks.len()];
    for ((whole, broken), bonds) in between {
        if let Some(of_broken) = breaks[broken] {
            splits[whole].push(Split::new(of_broken.along, bonds));
        }
    }
    // Where rods hold to each other, those that are split from others decide.
    if splits.iter().flatten().any(|split| !split.bonds.is_empty()) {
        let of_rods = splits.iter_mut();
        of_rods.for_each(|splits| splits.retain(|split| !split.bonds.is_empty()));
    }
    splits.iter().map(|splits| root(splits)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A split beside a rod that broke at `end`, whose bonds, a metre apart from 0 to 20, broke from `low` to `high`.
    fn split(end: f64, low: f64, high: f64) -> Split {
        let bond = |k: i32| {
            let at = f64::from(k);
            (at, low <= at && at <= high)
        };
        Split::new(end, (0..=20).map(bond).collect())
    }

    #[test]
    fn what_is_split_off_goes_with_the_side_on_which_the_split_is_longer() {
        assert_eq!(root(&[]), None);
        assert_eq!(root(&[split(5.5, 4.0, 12.0)]), Some(12.0));
        assert_eq!(root(&[split(9.5, 4.0, 12.0)]), Some(4.0));
        // Bonds that broke elsewhere are not of the split, and without one the rod passes beside the break.
        assert_eq!(root(&[split(5.5, 8.0, 12.0)]), Some(5.5));
        assert_eq!(root(&[split(30.0, 8.0, 12.0)]), Some(30.0));
    }

    #[test]
    fn as_little_as_can_be_is_split_within_a_side() {
        // Two long slivers of the lower side, which broke at 14.5 and were split off from 4 on, and one of the upper side.
        let lower = split(14.5, 4.0, 14.0);
        let upper = split(3.5, 4.0, 16.0);
        let both = [lower.clone(), lower.clone(), upper.clone()];
        // By the longest alone, that of the upper side, 22 bonds would be hidden.
        assert_eq!(root(&[lower.clone(), upper.clone()]), Some(16.0));
        assert_eq!(lower.hidden(16.0), 10 + 1);
        let hidden = |root: f64| both.iter().map(|s| s.hidden(root)).sum::<usize>();
        assert_eq!(root(&both), Some(4.0));
        assert!(hidden(4.0) < hidden(16.0));
    }
}
