//! Bonds between rods, as arrays, with the lists from which each vertex gathers its forces (Sutherland 2012 §3.3.2).
//!
//! A bond joins a vertex `x` to the point `c = (1 − t) y₀ + t y₁` on an edge of another rod. Bonds are sorted by vertex,
//! then edge. Every bond acts on three vertices; [`Incidence`] lists for each vertex the bonds that act on it, so that
//! forces are gathered in a fixed order by whichever thread has the vertex.

use crate::bundle::Bundle;
use crate::error::BundleError;
use serde::{Deserialize, Serialize};

/// One bond, for making [`Bonds`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bond {
    /// Vertex x.
    pub vertex: u32,
    /// Edge y₀y₁ of another rod, by its first vertex.
    pub edge: u32,
    /// Place t on the edge, 0 to 1.
    pub t: f64,
    /// Distance d₀ at rest, m.
    pub distance: f64,
    /// Cosine of the angle at rest between edge and x − c.
    pub rest_cosine: f64,
    /// Transverse stiffness k_t, N.
    pub transverse: f64,
    /// Shear stiffness S, J.
    pub shear: f64,
    /// Area of the facet it stands for, m².
    pub area: f64,
    /// Strength across the facet f_t90 times its area, N.
    pub tension_strength: f64,
    /// Shear strength f_v times the facet's area, N.
    pub shear_strength: f64,
    /// Energy of fracture G_c times the facet's area, J.
    pub fracture_energy: f64,
}

/// All bonds of a bundle; every array has one entry for each bond.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Bonds {
    /// Vertex x; ascending.
    pub vertex: Vec<u32>,
    /// Edge y₀y₁, by its first vertex.
    pub edge: Vec<u32>,
    /// Place on the edge, 0 to 1.
    pub t: Vec<f64>,
    /// Distance at rest, m.
    pub distance: Vec<f64>,
    /// Cosine of the angle at rest.
    pub rest_cosine: Vec<f64>,
    /// Transverse stiffness k_t, N.
    pub transverse: Vec<f64>,
    /// Shear stiffness S, J.
    pub shear: Vec<f64>,
    /// Area of the facet, m².
    pub area: Vec<f64>,
    /// Strength across the facet times its area, N.
    pub tension_strength: Vec<f64>,
    /// Shear strength times the facet's area, N.
    pub shear_strength: Vec<f64>,
    /// Energy of fracture times the facet's area, J.
    pub fracture_energy: Vec<f64>,
    /// Who gathers what.
    pub incidence: Incidence,
}

/// For each vertex the bonds that act on it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Incidence {
    /// First bond of each vertex as x, and the number of bonds at the end: its own bonds are
    /// `own[v]..own[v + 1]`.
    pub own: Vec<u32>,
    /// First entry of each edge in `held`, and their number at the end.
    pub first: Vec<u32>,
    /// Bonds sorted by the edge they hold on to, then by number.
    pub held: Vec<u32>,
}

impl Bonds {
    /// No bonds, for `vertices` vertices.
    pub fn none(vertices: usize) -> Self {
        Bonds {
            incidence: Incidence {
                own: vec![0; vertices + 1],
                first: vec![0; vertices + 1],
                held: Vec::new(),
            },
            ..Bonds::default()
        }
    }

    /// Number of bonds.
    pub fn len(&self) -> usize {
        self.vertex.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.vertex.is_empty()
    }

    /// Bond `i`, which must be below [`Bonds::len`].
    pub fn get(&self, i: usize) -> Bond {
        Bond {
            vertex: self.vertex[i],
            edge: self.edge[i],
            t: self.t[i],
            distance: self.distance[i],
            rest_cosine: self.rest_cosine[i],
            transverse: self.transverse[i],
            shear: self.shear[i],
            area: self.area[i],
            tension_strength: self.tension_strength[i],
            shear_strength: self.shear_strength[i],
            fracture_energy: self.fracture_energy[i],
        }
    }

    /// All bonds in order.
    pub fn iter(&self) -> impl Iterator<Item = Bond> + '_ {
        (0..self.len()).map(|i| self.get(i))
    }

    /// Bonds sorted by vertex and edge, with their lists, for `vertices` vertices.
    pub(crate) fn sorted(mut bonds: Vec<Bond>, vertices: usize) -> Self {
        bonds.sort_by(|a, b| {
            (a.vertex, a.edge)
                .cmp(&(b.vertex, b.edge))
                .then(a.t.total_cmp(&b.t))
        });
        let mut made = Bonds {
            incidence: Incidence::of(&bonds, vertices),
            ..Bonds::default()
        };
        for b in &bonds {
            made.vertex.push(b.vertex);
            made.edge.push(b.edge);
            made.t.push(b.t);
            made.distance.push(b.distance);
            made.rest_cosine.push(b.rest_cosine);
            made.transverse.push(b.transverse);
            made.shear.push(b.shear);
            made.area.push(b.area);
            made.tension_strength.push(b.tension_strength);
            made.shear_strength.push(b.shear_strength);
            made.fracture_energy.push(b.fracture_energy);
        }
        made
    }
}

impl Incidence {
    fn of(bonds: &[Bond], vertices: usize) -> Self {
        let mut own = vec![0; vertices + 1];
        let mut first = vec![0; vertices + 1];
        for b in bonds {
            own[b.vertex as usize + 1] += 1;
            first[b.edge as usize + 1] += 1;
        }
        for v in 0..vertices {
            own[v + 1] += own[v];
            first[v + 1] += first[v];
        }
        let mut next: Vec<u32> = first.clone();
        let mut held = vec![0; bonds.len()];
        for (i, b) in bonds.iter().enumerate() {
            let place = &mut next[b.edge as usize];
            held[*place as usize] = i as u32;
            *place += 1;
        }
        Incidence { own, first, held }
    }
}

impl Bundle {
    /// Replaces the bonds.
    ///
    /// # Errors
    /// [`BundleError::Bond`] where a bond names no vertex or edge, joins a rod to itself, or has a value out of range.
    pub fn set_bonds(&mut self, bonds: Vec<Bond>) -> Result<(), BundleError> {
        for (number, bond) in bonds.iter().enumerate() {
            self.check_bond(number, bond)?;
        }
        if bonds.len() > crate::bundle::MOST_VERTICES {
            return Err(BundleError::TooMany {
                what: "bonds",
                count: bonds.len(),
                most: crate::bundle::MOST_VERTICES,
            });
        }
        self.bonds = Bonds::sorted(bonds, self.vertices());
        self.generation += 1;
        Ok(())
    }

    fn check_bond(&self, bond: usize, b: &Bond) -> Result<(), BundleError> {
        let fail = |what, value, right| {
            Err(BundleError::Bond {
                bond,
                what,
                value,
                right,
            })
        };
        if b.vertex as usize >= self.vertices() {
            return fail("vertex", b.vertex.into(), "a vertex of the bundle");
        }
        if !self.is_edge(b.edge as usize) {
            return fail("edge", b.edge.into(), "an edge of a rod");
        }
        if self.rod_of(b.vertex as usize) == self.rod_of(b.edge as usize) {
            return fail(
                "edge",
                b.edge.into(),
                "an edge of another rod than the vertex's",
            );
        }
        if !(0.0..=1.0).contains(&b.t) {
            return fail("place on the edge", b.t, "from 0 to 1");
        }
        if !(-1.0..=1.0).contains(&b.rest_cosine) {
            return fail("cosine at rest", b.rest_cosine, "from -1 to 1");
        }
        if !(b.distance > 0.0 && b.distance.is_finite()) {
            return fail("distance at rest (m)", b.distance, "above 0 and finite");
        }
        for (what, value) in [
            ("transverse stiffness (N)", b.transverse),
            ("shear stiffness (J)", b.shear),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return fail(what, value, "0 or more and finite");
            }
        }
        let strengths = [
            ("area (m²)", b.area),
            ("tension strength (N)", b.tension_strength),
            ("shear strength (N)", b.shear_strength),
            ("fracture energy (J)", b.fracture_energy),
        ];
        for (what, value) in strengths {
            if value.is_nan() || value < 0.0 {
                return fail(what, value, "0 or more");
            }
        }
        Ok(())
    }
}
