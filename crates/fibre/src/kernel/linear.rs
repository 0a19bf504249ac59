//! What a small motion meets in bonds: the evaluator's part of linear systems ([`super::wide::slopes`]).

use super::Evaluator;
use super::wide::bonds::BondTable;
use super::wide::lanes::{Row, WIDTH};
use super::wide::own::Own;
use super::wide::slopes::{Slope, Slopes};
use crate::bundle::Bundle;
use crate::state::State;

/// A vertex that does not move.
pub(crate) const NONE: Row = Row([0.0; 4]);

impl Evaluator {
    /// Makes the bonds linear about a state.
    pub(crate) fn linearise(&mut self, state: &State) {
        self.slopes.resize(self.bonds.len() / WIDTH, Slopes::NONE);
        if !self.bonds.is_empty() {
            self.fill_places(state);
            let (level, slopes) = (self.level, &mut self.slopes);
            self.bonds.linearise(level, &self.position, slopes);
        }
    }

    /// Makes the forces that the motion `x` of vertices meets in the bonds, for [`Evaluator::gather_met`].
    pub(crate) fn meet(&mut self, x: &[Row]) {
        if self.bonds.is_empty() {
            return;
        }
        let (force, sums) = (&mut self.bond_force, &mut self.edge_force);
        self.bonds
            .products(self.level, x, &self.slopes, force, sums);
    }

    /// Puts these forces on the vertices from `first` on into `out`.
    pub(crate) fn gather_met(&self, bundle: &Bundle, first: usize, out: &mut [Row]) {
        if self.bonds.is_empty() {
            out.fill(NONE);
            return;
        }
        let (force, sums) = (&self.bond_force, &self.edge_force);
        self.bonds
            .gather(self.level, bundle, force, sums, first, out);
    }

    /// Bonds with stiffness made linear, one after another: of `parts` equal parts number `part`.
    #[inline(always)]
    pub(crate) fn each_slope(&self, part: usize, parts: usize, work: impl FnMut(&Slope)) {
        let table: &BondTable = &self.bonds;
        let end = |k: usize| table.len() * k / parts;
        table.each_slope(&self.slopes, end(part)..end(part + 1), work);
    }

    /// What linear bonds have between vertices of one rod, per vertex.
    pub(crate) fn own_blocks(&self, bundle: &Bundle, out: &mut Vec<Own>) {
        out.resize(bundle.vertices(), Own::NONE);
        if self.bonds.is_empty() {
            out.fill(Own::NONE);
        } else {
            self.bonds.own_blocks(self.level, &self.slopes, out);
        }
    }

    /// Takes the stiffness of bonds `broken`, until everything is derived anew.
    pub(crate) fn weaken(&mut self, broken: &[u32]) {
        self.bonds.weaken(broken);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Level;
    use crate::bonds::Bond;
    use crate::energy::{Curvature, bond};
    use crate::{Rod, RodMaterial};
    use glam::DVec3;
    use greenstick_wood::noise::unit;

    fn chance(i: usize, k: i64) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|c| unit(9, i as i64, k, c) - 0.5))
    }

    #[test]
    fn what_a_motion_meets_is_the_hessian_times_it_on_every_level() {
        let material = RodMaterial::solid(1e-6, 1e10, 1e9, 600.0);
        let rods: Vec<Rod> = (0..9)
            .map(|r| {
                let corner = DVec3::new((r % 3) as f64, (r / 3) as f64, 0.0) * 1e-3;
                let at = |i: usize| corner + DVec3::Z * 4e-3 * i as f64;
                Rod::new((0..9).map(at).collect(), material)
            })
            .collect();
        let mut bundle = Bundle::new(&rods, false).unwrap();
        let mut bonds = Vec::new();
        for v in 0..bundle.vertices() as u32 {
            for r in 0..9u32 {
                let edge = 9 * r + v % 8;
                if r != v / 9 {
                    bonds.push(Bond {
                        vertex: v,
                        edge,
                        t: unit(3, i64::from(v), i64::from(r), 0),
                        distance: 1.1e-3,
                        rest_cosine: 0.1,
                        transverse: 40.0,
                        shear: 2e-3,
                        area: 1e-6,
                        tension_strength: 1.0,
                        shear_strength: 1.0,
                        fracture_energy: 1.0,
                    });
                }
            }
        }
        bundle.set_bonds(bonds).unwrap();
        let mut state = State::at_rest(&bundle);
        for v in 0..bundle.vertices() {
            state.position.add(v, chance(v, 0) * 4e-4);
        }
        let x: Vec<Row> = (0..bundle.vertices())
            .map(|v| Row(chance(v, 1).extend(0.0).to_array()))
            .collect();
        let broken = [3, 50, 51];
        let mut expected = vec![0.0; 3 * bundle.vertices()];
        for b in (0..bundle.bonds.len()).filter(|b| !broken.contains(&(*b as u32))) {
            let made = bond::hessian(&bundle, &state, b, Curvature::GaussNewton);
            for r in 0..made.count {
                for c in 0..made.count {
                    let f = made.freedoms[c] as usize;
                    expected[made.freedoms[r] as usize] += made.matrix[r][c] * x[f / 3].0[f % 3];
                }
            }
        }
        let largest = expected.iter().fold(0.0f64, |a, v| a.max(v.abs()));
        let mut first: Option<Vec<[f64; 4]>> = None;
        for level in [Level::Plain, Level::Avx2, Level::Avx512] {
            let mut evaluator = Evaluator::with_level(&bundle, level);
            evaluator.weaken(&broken);
            evaluator.linearise(&state);
            evaluator.meet(&x);
            let mut out = vec![NONE; bundle.vertices()];
            evaluator.gather_met(&bundle, 0, &mut out);
            let mut one_by_one = vec![0.0; 3 * bundle.vertices()];
            evaluator.each_slope(0, 1, |s| {
                for (which, _) in [(&s.length, 0), (&s.cosine, 1)] {
                    let along: f64 = (0..3)
                        .map(|n| {
                            (0..3)
                                .map(|a| which[n][a] * x[s.nodes[n] as usize].0[a])
                                .sum::<f64>()
                        })
                        .sum();
                    for n in 0..3 {
                        for a in 0..3 {
                            one_by_one[3 * s.nodes[n] as usize + a] += along * which[n][a];
                        }
                    }
                }
            });
            let mut own = Vec::new();
            evaluator.own_blocks(&bundle, &mut own);
            let mut of = vec![[0.0; 21]; bundle.vertices()];
            evaluator.each_slope(0, 1, |s| {
                let [v, y, _] = s.nodes.map(|v| v as usize);
                for g in [&s.length, &s.cosine] {
                    let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
                    for (k, (a, b)) in pairs.into_iter().enumerate() {
                        of[v][k] += g[0][a] * g[0][b];
                        of[y][6 + k] += g[1][a] * g[1][b];
                        of[y][12 + k] += g[2][a] * g[2][b];
                    }
                    (0..3).for_each(|a| of[y][18 + a] += g[1][a] * g[2][2]);
                }
            });
            for (own, of) in own.iter().zip(&of) {
                for k in 0..6 {
                    let at = k + usize::from(k > 2);
                    assert!((own.vertex.0[at] - of[k]).abs() < 1e-12 * largest / 1e-4);
                    assert!((own.start.0[at] - of[6 + k]).abs() < 1e-12 * largest / 1e-4);
                    assert!((own.end.0[at] - of[12 + k]).abs() < 1e-12 * largest / 1e-4);
                }
                (0..3).for_each(|a| {
                    assert!((own.across[1].0[a] - of[18 + a]).abs() < 1e-12 * largest / 1e-4);
                });
            }
            for (f, e) in expected.iter().enumerate() {
                // Gradients are rounded to half the width.
                assert!((out[f / 3].0[f % 3] - e).abs() < 1e-5 * largest);
                assert!((one_by_one[f] - out[f / 3].0[f % 3]).abs() < 1e-12 * largest);
            }
            let bits: Vec<[f64; 4]> = out.iter().map(|r| r.0).collect();
            assert_eq!(*first.get_or_insert_with(|| bits.clone()), bits);
        }
    }
}
