//! Bonds between rods, as arrays, with the lists from which each vertex gathers its forces (Sutherland 2012 §3.3.2).
//!
//! A bond joins a vertex `x` to the point `c = (1 − t) y₀ + t y₁` on an edge of another rod. Bonds are sorted by vertex,
//! then edge. Every bond acts on three vertices; [`Incidence`] lists for each vertex the bonds that act on it, so that
//! whichever thread owns the vertex gathers its forces in a fixed order.

use serde::{Deserialize, Serialize};

/// One bond, from which [`Bonds`] are made.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bond {
    /// Vertex x.
    pub vertex: u32,
    /// Edge y₀y₁ of another rod, by its first vertex.
    pub edge: u32,
    /// Parameter t along the edge, 0 to 1.
    pub t: f64,
    /// Distance d₀ at rest, m.
    pub distance: f64,
    /// Cosine of the angle at rest between the edge and x − c.
    pub rest_cosine: f64,
    /// Transverse stiffness k_t, N.
    pub transverse: f64,
    /// Shear stiffness S, J.
    pub shear: f64,
    /// Area of the facet that the bond represents, m².
    pub area: f64,
    /// Tensile strength across the facet f_t90 times its area, N.
    pub tension_strength: f64,
    /// Shear strength f_v times the facet's area, N.
    pub shear_strength: f64,
    /// Fracture energy in opening G_I times the facet's area, J.
    pub fracture_energy: f64,
    /// Fracture energy in shear along the grain G_II times the facet's area, J.
    pub shear_fracture_energy: f64,
    /// Share of its stiffness against opening and slip that softening has taken, 0 to 1; never falls.
    pub damage: f64,
}

/// All bonds of a bundle. Every array has one entry for each bond.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Bonds {
    /// Vertex x; ascending.
    pub vertex: Vec<u32>,
    /// Edge y₀y₁, by its first vertex.
    pub edge: Vec<u32>,
    /// Parameter along the edge, 0 to 1.
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
    /// Tensile strength across the facet times its area, N.
    pub tension_strength: Vec<f64>,
    /// Shear strength times the facet's area, N.
    pub shear_strength: Vec<f64>,
    /// Fracture energy in opening times the facet's area, J.
    pub fracture_energy: Vec<f64>,
    /// Fracture energy in shear times the facet's area, J.
    pub shear_fracture_energy: Vec<f64>,
    /// Share of the stiffness against opening and slip that softening has taken.
    pub damage: Vec<f64>,
    /// Which bonds act on which vertex and edge.
    pub incidence: Incidence,
}

/// The bonds that act on each vertex and edge, as lists in compressed form.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Incidence {
    /// Per vertex: its first bond as x, and at the end the number of bonds. Vertex `v` has the bonds
    /// `vertex_offsets[v]..vertex_offsets[v + 1]`.
    pub vertex_offsets: Vec<u32>,
    /// Per edge: its first entry in `by_edge`, and at the end the number of bonds.
    pub edge_offsets: Vec<u32>,
    /// Bonds sorted by their edge, then by number.
    pub by_edge: Vec<u32>,
}

impl Bonds {
    /// Returns no bonds, for a bundle of `vertices` vertices.
    pub fn none(vertices: usize) -> Self {
        Bonds {
            incidence: Incidence {
                vertex_offsets: vec![0; vertices + 1],
                edge_offsets: vec![0; vertices + 1],
                by_edge: Vec::new(),
            },
            ..Bonds::default()
        }
    }

    /// Returns the number of bonds.
    pub fn len(&self) -> usize {
        self.vertex.len()
    }

    /// Whether there are no bonds.
    pub fn is_empty(&self) -> bool {
        self.vertex.is_empty()
    }

    /// Returns bond `i`, which must be below [`Bonds::len`].
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
            shear_fracture_energy: self.shear_fracture_energy[i],
            damage: self.damage[i],
        }
    }

    /// Iterates over the bonds in order.
    pub fn iter(&self) -> impl Iterator<Item = Bond> + '_ {
        (0..self.len()).map(|i| self.get(i))
    }

    /// Iterates over vertex and edge of every bond that has stiffness.
    pub(crate) fn with_stiffness(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (0..self.len())
            .filter(|&i| self.transverse[i] > 0.0 || self.shear[i] > 0.0)
            .map(|i| (self.vertex[i] as usize, self.edge[i] as usize))
    }

    /// Sorts bonds by vertex and edge and lists their incidence, for a bundle of `vertices` vertices.
    pub(crate) fn sorted(mut bonds: Vec<Bond>, vertices: usize) -> Self {
        bonds.sort_by(|a, b| {
            (a.vertex, a.edge)
                .cmp(&(b.vertex, b.edge))
                .then(a.t.total_cmp(&b.t))
        });
        let mut sorted = Bonds {
            incidence: Incidence::of_sorted(&bonds, vertices),
            ..Bonds::default()
        };
        for b in &bonds {
            sorted.vertex.push(b.vertex);
            sorted.edge.push(b.edge);
            sorted.t.push(b.t);
            sorted.distance.push(b.distance);
            sorted.rest_cosine.push(b.rest_cosine);
            sorted.transverse.push(b.transverse);
            sorted.shear.push(b.shear);
            sorted.area.push(b.area);
            sorted.tension_strength.push(b.tension_strength);
            sorted.shear_strength.push(b.shear_strength);
            sorted.fracture_energy.push(b.fracture_energy);
            sorted.shear_fracture_energy.push(b.shear_fracture_energy);
            sorted.damage.push(b.damage);
        }
        sorted
    }
}

impl Incidence {
    /// Returns the numbers of the bonds whose vertex x is `vertex`.
    pub(crate) fn of_vertex(&self, vertex: usize) -> std::ops::Range<usize> {
        self.vertex_offsets[vertex] as usize..self.vertex_offsets[vertex + 1] as usize
    }

    fn of_sorted(bonds: &[Bond], vertices: usize) -> Self {
        let mut vertex_offsets = vec![0; vertices + 1];
        let mut edge_offsets = vec![0; vertices + 1];
        for b in bonds {
            vertex_offsets[b.vertex as usize + 1] += 1;
            edge_offsets[b.edge as usize + 1] += 1;
        }
        for v in 0..vertices {
            vertex_offsets[v + 1] += vertex_offsets[v];
            edge_offsets[v + 1] += edge_offsets[v];
        }
        let mut next: Vec<u32> = edge_offsets.clone();
        let mut by_edge = vec![0; bonds.len()];
        for (i, b) in bonds.iter().enumerate() {
            let slot = &mut next[b.edge as usize];
            by_edge[*slot as usize] = i as u32;
            *slot += 1;
        }
        Incidence {
            vertex_offsets,
            edge_offsets,
            by_edge,
        }
    }
}
