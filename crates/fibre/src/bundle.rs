//! The bundle: all rods as arrays, what they are made of and how they are bonded (Sutherland 2012 §3.2, §3.3).
//!
//! Vertices of all rods lie one rod after another. Edge `j` joins vertices `j` and `j + 1`; edge arrays are as long as
//! vertex arrays, and the entry behind a rod's last vertex is a **gap**: no edge, with stiffness and mass 0 and a rest
//! length of 1. So one loop without branches runs over all rods. Quantities at vertices that need two edges (bending,
//! twist) are 0 at a rod's ends.
//!
//! A bundle changes only where something breaks ([`crate::failure`]); [`Bundle::generation`] then rises by one, and what
//! was derived from it has to be derived again.

use crate::bonds::Bonds;
use crate::error::BundleError;
use crate::frames;
use crate::vectors::Vectors;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// What a rod is made of.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RodMaterial {
    /// Mass per length, kg/m.
    pub line_density: f64,
    /// Stretching stiffness k = E_L a, N.
    pub stretch: f64,
    /// Bending stiffness α = E_L I, N m².
    pub bend: f64,
    /// Twisting stiffness β = G J, N m².
    pub twist: f64,
    /// Area of the rod's cell, m².
    pub area: f64,
    /// Diameter of the rod's section, m: h of the bending ratio.
    pub diameter: f64,
    /// Strain along the grain at tensile failure.
    pub tension_limit: f64,
    /// Strain at which the rod yields in compression (a positive number), infinite for never.
    pub yield_strain: f64,
}

impl RodMaterial {
    /// A round rod of solid material: cell area `area` (m²), modulus of elasticity `young` and shear modulus `shear`
    /// (Pa), `density` (kg/m³). It neither yields nor breaks.
    pub fn solid(area: f64, young: f64, shear: f64, density: f64) -> Self {
        let inertia = area * area / (4.0 * std::f64::consts::PI);
        RodMaterial {
            line_density: density * area,
            stretch: young * area,
            bend: young * inertia,
            twist: shear * 2.0 * inertia,
            area,
            diameter: 2.0 * (area / std::f64::consts::PI).sqrt(),
            tension_limit: f64::INFINITY,
            yield_strain: f64::INFINITY,
        }
    }
}

/// A rod at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Rod {
    /// Vertices, m.
    pub vertices: Vec<DVec3>,
    /// What it is made of.
    pub material: RodMaterial,
    /// Strength of each vertex relative to the material's (Weibull scatter); empty for 1 everywhere.
    pub relative_strength: Vec<f64>,
    /// Direction across the first edge from which the material frame starts; any where `None`.
    pub director: Option<DVec3>,
}

impl Rod {
    /// A rod of equal strength along its length.
    pub fn new(vertices: Vec<DVec3>, material: RodMaterial) -> Self {
        Rod {
            vertices,
            material,
            relative_strength: Vec::new(),
            director: None,
        }
    }
}

/// Rods and their bonds; see the module's text for how the arrays are laid out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Bundle {
    /// First vertex of each rod, and the number of vertices at the end.
    pub first: Vec<u32>,
    /// Per rod: area of its cell, m².
    pub area: Vec<f64>,
    /// Per rod: diameter of its section, m.
    pub diameter: Vec<f64>,
    /// Per rod: the rod of the unbroken bundle that it is a part of.
    pub parent: Vec<u32>,
    /// Per vertex: place at rest, m.
    pub rest: Vectors,
    /// Per vertex: mass, kg (half of that of its edges).
    pub mass: Vec<f64>,
    /// Per vertex: bending stiffness α, N m²; 0 at a rod's ends.
    pub bend: Vec<f64>,
    /// Per vertex: natural curvature (κ₁, κ₂) in the material frame, integrated over the vertex (no unit); 0 everywhere
    /// without twist.
    pub natural_curvature: [Vec<f64>; 2],
    /// Per vertex: twisting stiffness β, N m²; 0 at a rod's ends and without twist.
    pub twist: Vec<f64>,
    /// Per vertex: strain at tensile failure.
    pub tension_limit: Vec<f64>,
    /// Per vertex: the vertex of the unbroken bundle that it is, or is one side of.
    pub origin: Vec<u32>,
    /// Per edge: length at rest, m; 1 at gaps.
    pub rest_length: Vec<f64>,
    /// Per edge: stretching stiffness k, N; 0 at gaps.
    pub stretch: Vec<f64>,
    /// Per edge: mass, kg; 0 at gaps.
    pub edge_mass: Vec<f64>,
    /// Per edge: moment of inertia about the edge, kg m²; 0 at gaps.
    pub inertia: Vec<f64>,
    /// Per edge: strain of yielding in compression, positive.
    pub yield_strain: Vec<f64>,
    /// Per edge: first material director at rest (unit); the second is tangent × first.
    pub rest_director: Vectors,
    /// Whether rods resist twist and carry material frames.
    pub twisting: bool,
    /// What holds the rods together.
    pub bonds: Bonds,
    /// Rises with every change.
    pub generation: u64,
}

/// The largest number of vertices: indices are 32 bits, and gathering instructions take them as signed.
pub const MOST_VERTICES: usize = i32::MAX as usize - 16;

/// Greatest angle between edges of a rod without twist, rad: rounding of straight rods placed anywhere.
const STRAIGHT: f64 = 1e-7;

impl Bundle {
    /// A bundle of rods without bonds, at rest as given. With `twisting` rods may be curved: their natural curvature is
    /// that of the given shape, in material frames that are parallel along each rod.
    ///
    /// # Errors
    /// [`BundleError`] for what is out of range, and for curved rods without `twisting`.
    pub fn new(rods: &[Rod], twisting: bool) -> Result<Self, BundleError> {
        if rods.is_empty() {
            return Err(BundleError::NoRods);
        }
        let count: usize = rods.iter().map(|r| r.vertices.len()).sum();
        if count > MOST_VERTICES {
            return Err(BundleError::TooMany {
                what: "vertices",
                count,
                most: MOST_VERTICES,
            });
        }
        let mut made = Bundle::empty(twisting);
        for (number, rod) in rods.iter().enumerate() {
            made.push_rod(number, rod)?;
        }
        made.bonds = Bonds::none(count);
        Ok(made)
    }

    fn empty(twisting: bool) -> Self {
        Bundle {
            first: vec![0],
            area: Vec::new(),
            diameter: Vec::new(),
            parent: Vec::new(),
            rest: Vectors::default(),
            mass: Vec::new(),
            bend: Vec::new(),
            natural_curvature: [Vec::new(), Vec::new()],
            twist: Vec::new(),
            tension_limit: Vec::new(),
            origin: Vec::new(),
            rest_length: Vec::new(),
            stretch: Vec::new(),
            edge_mass: Vec::new(),
            inertia: Vec::new(),
            yield_strain: Vec::new(),
            rest_director: Vectors::default(),
            twisting,
            bonds: Bonds::none(0),
            generation: 0,
        }
    }

    fn push_rod(&mut self, number: usize, rod: &Rod) -> Result<(), BundleError> {
        check_rod(number, rod, self.twisting)?;
        let m = &rod.material;
        let n = rod.vertices.len();
        let start = self.mass.len();
        let edges: Vec<DVec3> = rod.vertices.windows(2).map(|p| p[1] - p[0]).collect();
        let directors = frames::parallel_along(&edges, rod.director);
        for (i, &at) in rod.vertices.iter().enumerate() {
            let inner = i > 0 && i + 1 < n;
            let kappa = if inner && self.twisting {
                let frame = |j: usize| (edges[j].normalize(), directors[j]);
                frames::curvature(frame(i - 1), frame(i))
            } else {
                [0.0; 2]
            };
            let length = edges.get(i).map(|e| e.length());
            self.rest.push(at);
            self.bend.push(if inner { m.bend } else { 0.0 });
            self.natural_curvature[0].push(kappa[0]);
            self.natural_curvature[1].push(kappa[1]);
            self.twist
                .push(if inner && self.twisting { m.twist } else { 0.0 });
            let relative = rod.relative_strength.get(i).copied().unwrap_or(1.0);
            self.tension_limit.push(m.tension_limit * relative);
            self.origin.push((start + i) as u32);
            self.rest_length.push(length.unwrap_or(1.0));
            self.stretch.push(length.map_or(0.0, |_| m.stretch));
            let mass = length.map_or(0.0, |l| l * m.line_density);
            self.edge_mass.push(mass);
            // Of a disc of the rod's diameter about its axis.
            self.inertia.push(mass * m.diameter * m.diameter / 8.0);
            self.yield_strain.push(m.yield_strain);
            let director = directors.get(i).or(directors.last());
            self.rest_director
                .push(director.copied().unwrap_or(DVec3::X));
            self.mass.push(0.0);
        }
        self.area.push(m.area);
        self.diameter.push(m.diameter);
        self.parent.push(number as u32);
        self.first.push((start + n) as u32);
        self.share_mass(start..start + n);
        Ok(())
    }

    /// Gives each of a rod's vertices half of the mass of its edges.
    pub(crate) fn share_mass(&mut self, vertices: Range<usize>) {
        for i in vertices.clone() {
            let before = if i > vertices.start {
                self.edge_mass[i - 1]
            } else {
                0.0
            };
            self.mass[i] = 0.5 * (before + self.edge_mass[i]);
        }
    }

    /// Number of rods.
    pub fn rods(&self) -> usize {
        self.first.len() - 1
    }

    /// Number of vertices, and length of all arrays of vertices and edges.
    pub fn vertices(&self) -> usize {
        self.mass.len()
    }

    /// Vertices of rod `rod`, which must be below [`Bundle::rods`].
    pub fn rod(&self, rod: usize) -> Range<usize> {
        self.first[rod] as usize..self.first[rod + 1] as usize
    }

    /// The rod of a vertex.
    pub fn rod_of(&self, vertex: usize) -> usize {
        self.first.partition_point(|&f| f as usize <= vertex) - 1
    }

    /// Whether `edge` is an edge of a rod and no gap.
    pub fn is_edge(&self, edge: usize) -> bool {
        edge < self.vertices() && self.stretch[edge] > 0.0
    }

    /// l = |ē₋| + |ē₊| at a vertex, m: only the edge there is at a rod's ends.
    pub fn both_lengths(&self, vertex: usize) -> f64 {
        let length = |edge: usize| {
            if self.is_edge(edge) {
                self.rest_length[edge]
            } else {
                0.0
            }
        };
        vertex.checked_sub(1).map_or(0.0, length) + length(vertex)
    }

    /// Sum of all masses, kg.
    pub fn total_mass(&self) -> f64 {
        self.mass.iter().sum()
    }
}

fn check_rod(number: usize, rod: &Rod, twisting: bool) -> Result<(), BundleError> {
    let n = rod.vertices.len();
    if n < 2 {
        return Err(BundleError::ShortRod {
            rod: number,
            count: n,
        });
    }
    let m = &rod.material;
    let positive = [
        ("mass per length (kg/m)", m.line_density),
        ("stretching stiffness (N)", m.stretch),
        ("cell area (m²)", m.area),
        ("diameter (m)", m.diameter),
    ];
    for (what, value) in positive {
        if !(value > 0.0 && value.is_finite()) {
            return Err(BundleError::Rod {
                rod: number,
                what,
                value,
                right: "above 0 and finite",
            });
        }
    }
    for (what, value) in [
        ("bending stiffness (N m²)", m.bend),
        ("twisting stiffness (N m²)", m.twist),
    ] {
        if !(value >= 0.0 && value.is_finite()) {
            return Err(BundleError::Rod {
                rod: number,
                what,
                value,
                right: "0 or more and finite",
            });
        }
    }
    let limits = [
        ("strain at tensile failure", m.tension_limit),
        ("strain of yielding", m.yield_strain),
    ];
    let scatter = rod
        .relative_strength
        .iter()
        .map(|&s| ("relative strength", s));
    for (what, value) in limits.into_iter().chain(scatter) {
        if value.is_nan() || value <= 0.0 {
            return Err(BundleError::Rod {
                rod: number,
                what,
                value,
                right: "above 0",
            });
        }
    }
    let mut last: Option<DVec3> = None;
    for (vertex, pair) in rod.vertices.windows(2).enumerate() {
        let edge = pair[1] - pair[0];
        let length = edge.length();
        if !(length > 0.0 && length.is_finite()) {
            return Err(BundleError::Edge {
                rod: number,
                vertex,
                length,
            });
        }
        let t = edge / length;
        if let Some(before) = last {
            if before.dot(t) < -1.0 + 1e-9 {
                return Err(BundleError::Fold {
                    rod: number,
                    vertex,
                });
            }
            let angle = before.cross(t).length().max(1.0 - before.dot(t));
            if !twisting && angle > STRAIGHT {
                return Err(BundleError::Curved {
                    rod: number,
                    vertex,
                    angle,
                });
            }
        }
        last = Some(t);
    }
    Ok(())
}
