//! The line search of Newton's method: how far each part of the wood goes along a step.
//!
//! Parts that nothing joins or presses together balance by themselves, and each has a length of its own. A crumb that spins is stiff along
//! and has no stiffness across: it can take a small part of a step only. With one length for all, the rest of the wood would go
//! no further, for as many iterations as the crumb needs.

use super::balance::Balance;
use greenstick_geometry::Unions;

/// Trials of a line search.
pub(super) const LINE_SEARCH_TRIALS: usize = 8;
/// The line search accepts a step whose end has at most this fraction of the slope at its start.
const SLOPE_REDUCTION: f64 = 0.5;
/// The line search makes a step longer by at most this factor at a time.
const MAX_EXTENSION: f64 = 4.0;

/// The line search of one part.
#[derive(Debug, Clone, Copy)]
struct PartSearch {
    /// Work of the unbalanced forces along the step where it begins.
    slope: f64,
    /// The multiple of the step that is tried.
    length: f64,
    /// Whether it stays so.
    ended: bool,
    /// The work along the step in a trial, and the largest unbalanced force, N.
    now: f64,
    largest: f64,
}

impl PartSearch {
    const BEGIN: PartSearch = PartSearch {
        slope: 0.0,
        length: 1.0,
        ended: false,
        now: 0.0,
        largest: 0.0,
    };

    /// Ends after a trial, or chooses the length of the next one: up to `longest`, where there is a search at all.
    fn judge(&mut self, balanced: f64, longest: Option<f64>) {
        let PartSearch { slope, now, .. } = *self;
        // The force along the step must have fallen, and not have reversed by much.
        let accepted = now.abs() <= SLOPE_REDUCTION * slope.abs() || self.largest <= balanced;
        let Some(longest) = longest else {
            self.ended = true;
            return;
        };
        if accepted || slope.is_nan() || slope <= 0.0 || (now > 0.0 && self.length >= longest) {
            self.ended = true;
            return;
        }
        self.length *= if now > 0.0 {
            let factor = if now < slope {
                slope / (slope - now)
            } else {
                MAX_EXTENSION
            };
            factor.min(MAX_EXTENSION).min(longest / self.length)
        } else if now.is_finite() {
            (slope / (slope - now)).clamp(0.1, 0.9)
        } else {
            0.25
        };
    }
}

/// A line search along a step.
pub(super) struct LineSearch {
    /// Per vertex: its part.
    part: Vec<u32>,
    parts: Vec<PartSearch>,
}

impl LineSearch {
    /// Begins one where `balance` has the forces, and the contacts by which parts are one.
    pub fn new(balance: &Balance, step: &[f64]) -> Self {
        let n = balance.parts.len();
        let mut unions = Unions::new(n);
        for (v, &root) in balance.parts.iter().enumerate() {
            unions.join(v as u32, root as u32);
        }
        for spring in &balance.springs {
            let mut vertices = spring.shares().map(|(v, _)| v as u32);
            if let Some(first) = vertices.next() {
                for v in vertices {
                    unions.join(first, v);
                }
            }
        }
        let mut number = vec![u32::MAX; n];
        let mut count = 0;
        let part = (0..n as u32)
            .map(|v| {
                let root = unions.root(v) as usize;
                if number[root] == u32::MAX {
                    number[root] = count;
                    count += 1;
                }
                number[root]
            })
            .collect();
        let mut search = LineSearch {
            part,
            parts: vec![PartSearch::BEGIN; count as usize],
        };
        search.measure(balance, step);
        search.parts.iter_mut().for_each(|p| p.slope = p.now);
        search
    }

    /// Returns the multiple of the step that a vertex goes in the present trial.
    pub fn length(&self, vertex: usize) -> f64 {
        self.parts[self.part[vertex] as usize].length
    }

    /// Judges the trial whose forces `balance` has. Returns whether there is another to be made.
    pub fn go_on(
        &mut self,
        balance: &Balance,
        step: &[f64],
        tolerance: f64,
        longest: Option<f64>,
    ) -> bool {
        self.measure(balance, step);
        let balanced = tolerance * balance.scale;
        let searching = self.parts.iter_mut().filter(|p| !p.ended);
        searching.for_each(|p| p.judge(balanced, longest));
        self.parts.iter().any(|p| !p.ended)
    }

    fn measure(&mut self, balance: &Balance, step: &[f64]) {
        for part in &mut self.parts {
            (part.now, part.largest) = (0.0, 0.0);
        }
        for (v, &part) in self.part.iter().enumerate() {
            let part = &mut self.parts[part as usize];
            balance.measure(v, step, (&mut part.now, &mut part.largest));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rod_bundle::{Rod, RodBundle, RodMaterial};
    use glam::DVec3;

    #[test]
    fn a_part_that_must_go_back_leaves_the_others_their_way() {
        let material = RodMaterial::solid(1e-6, 1e10, 1e9, 600.0);
        let rods = [0.0, 0.1].map(|x| {
            let vertex = |i: usize| DVec3::new(x, 0.0, 4e-3 * i as f64);
            Rod::new((0..3).map(vertex).collect(), material)
        });
        let bundle = RodBundle::new(&rods, false).unwrap();
        let mut balance = Balance::default();
        balance.prepare(&bundle, Vec::new());
        balance.scale = 1.0;
        balance.held = vec![false; balance.residual.len()];
        let step = vec![1.0; balance.residual.len()];
        let (first, second) = (0..9, 9..18);
        balance.residual.fill(1.0);
        let mut search = LineSearch::new(&balance, &step);
        // At the end of the step the first rod's forces are reversed and ten times as large, the second's are nearly balanced.
        balance.residual[first.clone()].fill(-10.0);
        balance.residual[second.clone()].fill(0.1);
        assert!(search.go_on(&balance, &step, 1e-2, Some(1.0)));
        let lengths = |search: &LineSearch| [search.length(0), search.length(5)];
        assert_eq!(lengths(&search), [0.1, 1.0]);
        // What has ended stays where it is, whatever its forces are in later trials of others.
        balance.residual[first].fill(0.0);
        balance.residual[second].fill(-5.0);
        assert!(!search.go_on(&balance, &step, 1e-2, Some(1.0)));
        assert_eq!(lengths(&search), [0.1, 1.0]);
    }
}
