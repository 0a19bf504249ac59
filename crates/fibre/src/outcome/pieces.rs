//! The pieces that rods and bonds hold together.

use crate::rod_bundle::RodBundle;
use greenstick_geometry::Unions;
use serde::Serialize;
use std::collections::BTreeMap;

/// Pieces of less than this share of the wood are splinters.
pub(super) const SPLINTER_SHARE: f64 = 0.01;

/// A piece of the wood.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OutcomePiece {
    /// Its share of the wood's mass.
    pub share: f64,
    /// Its share of the wood's volume, which differs where earlywood and latewood, or sapwood and heartwood, differ in density.
    pub volume_share: f64,
}

/// The pieces of a bundle.
pub(super) struct Pieces {
    /// All of them.
    pub all: Vec<OutcomePiece>,
    /// Per vertex: its piece.
    of_vertex: Vec<u32>,
}

impl Pieces {
    /// Returns what rods and bonds hold together, but for those that cross the cut. `at_base` says on which side of it a vertex
    /// lies.
    pub fn new(bundle: &RodBundle, at_base: Option<&[bool]>) -> Self {
        let mut pieces = Unions::new(bundle.vertices());
        let mut join = |a: usize, b: usize| {
            if at_base.is_none_or(|side| side[a] == side[b]) {
                pieces.join(a as u32, b as u32);
            }
        };
        for j in (0..bundle.vertices()).filter(|&j| bundle.is_edge(j)) {
            join(j, j + 1);
        }
        let bonds = &bundle.bonds;
        for bond in 0..bonds.len() {
            let edge = bonds.edge[bond] as usize;
            join(
                bonds.vertex[bond] as usize,
                edge + usize::from(bonds.t[bond] > 0.5),
            );
        }
        // Mass and volume.
        let mut made = BTreeMap::<u32, [f64; 2]>::new();
        let roots: Vec<u32> = (0..bundle.vertices() as u32)
            .map(|v| pieces.root(v))
            .collect();
        for rod in 0..bundle.rods() {
            for v in bundle.rod(rod) {
                made.entry(roots[v]).or_default()[0] += bundle.mass[v];
            }
            for edge in bundle.rod(rod).filter(|&v| bundle.is_edge(v)) {
                let volume = bundle.area[rod] * bundle.rest_length[edge];
                made.entry(roots[edge]).or_default()[1] += volume;
            }
        }
        let [mass, volume] = [0, 1].map(|k| made.values().map(|m| m[k]).sum::<f64>());
        let number: BTreeMap<u32, u32> = (made.keys().copied()).zip(0..).collect();
        Pieces {
            all: (made.values())
                .map(|m| OutcomePiece {
                    share: m[0] / mass,
                    volume_share: m[1] / volume,
                })
                .collect(),
            of_vertex: roots.iter().map(|root| number[root]).collect(),
        }
    }

    /// The piece of a vertex.
    pub fn of(&self, vertex: usize) -> &OutcomePiece {
        &self.all[self.of_vertex[vertex] as usize]
    }
}
