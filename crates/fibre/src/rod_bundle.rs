//! The bundle: all rods as arrays, their material and their bonds (Sutherland 2012 §3.2, §3.3).
//!
//! Vertices of all rods lie one rod after another. Edge `j` joins vertices `j` and `j + 1`. Edge arrays are as long as
//! vertex arrays, and the entry behind a rod's last vertex is a **gap**: no edge, with stiffness and mass 0 and a rest
//! length of 1. One loop without branches therefore covers all rods. Quantities at vertices that need two edges (bending,
//! twist) are 0 at a rod's ends.
//!
//! A bundle changes only where something breaks ([`crate::topology`]). [`RodBundle::generation`] then rises by one, and
//! whatever was derived from the bundle must be derived again.

use crate::bonds::{Bond, Bonds};
use crate::error::RodBundleError;
use crate::material_frame;
use crate::vectors::Vectors;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// The material and cross-section of a rod.
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
    /// Diameter of the rod's cross-section, m: h of the bending ratio.
    pub diameter: f64,
    /// Strain along the grain at tensile failure.
    pub tension_limit: f64,
    /// Shear strain at the surface at which the rod fails in torsion.
    pub shear_limit: f64,
    /// Strain at which the rod yields in compression (a positive number), infinite for never.
    pub yield_strain: f64,
}

impl RodMaterial {
    /// Returns the material of a solid round rod that neither yields nor breaks: cell area `area` (m²), modulus of
    /// elasticity `young` and shear modulus `shear` (Pa), `density` (kg/m³).
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
            shear_limit: f64::INFINITY,
            yield_strain: f64::INFINITY,
        }
    }
}

/// A rod at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Rod {
    /// Vertices, m.
    pub vertices: Vec<DVec3>,
    /// Material and cross-section.
    pub material: RodMaterial,
    /// Strength of each vertex relative to the material's (Weibull scatter); empty for 1 everywhere.
    pub relative_strength: Vec<f64>,
    /// Direction across the first edge in which the material frame starts; any direction where `None`.
    pub director: Option<DVec3>,
}

impl Rod {
    /// Returns a rod whose strength is the same along its length.
    pub fn new(vertices: Vec<DVec3>, material: RodMaterial) -> Self {
        Rod {
            vertices,
            material,
            relative_strength: Vec::new(),
            director: None,
        }
    }
}

/// Rods and their bonds. The module's text says how the arrays are laid out.
///
/// ```
/// use glam::DVec3;
/// use greenstick_fibre::{Rod, RodBundle, RodMaterial};
///
/// // A rod of oak, 10 cm long, in 20 edges.
/// let material = RodMaterial::solid(1e-5, 12e9, 1e9, 700.0);
/// let vertices = (0..=20).map(|i| DVec3::Z * (0.005 * f64::from(i))).collect();
/// let bundle = RodBundle::new(&[Rod::new(vertices, material)], false)?;
/// assert_eq!((bundle.rods(), bundle.vertices()), (1, 21));
/// assert!((bundle.total_mass() - 0.1 * material.line_density).abs() < 1e-12);
/// # Ok::<(), greenstick_fibre::RodBundleError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RodBundle {
    /// Per rod: its first vertex, and at the end the number of vertices.
    pub rod_offsets: Vec<u32>,
    /// Per rod: area of its cell, m².
    pub area: Vec<f64>,
    /// Per rod: diameter of its cross-section, m.
    pub diameter: Vec<f64>,
    /// Per rod: the rod of the unbroken bundle that it is a part of.
    pub parent: Vec<u32>,
    /// Per vertex: position at rest, m.
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
    /// Per vertex: shear strain at failure in torsion.
    pub shear_limit: Vec<f64>,
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
    /// Per edge: yield strain in compression, positive.
    pub yield_strain: Vec<f64>,
    /// Per edge: first material director at rest (unit); the second is tangent × first.
    pub rest_director: Vectors,
    /// Whether rods resist twist and carry material frames.
    pub twisting: bool,
    /// The bonds that hold the rods together.
    pub bonds: Bonds,
    /// Rises with every change.
    pub generation: u64,
}

/// The largest number of vertices, and of bonds: indices have 32 bits, and gather instructions read them as signed.
pub(crate) const MAX_VERTICES: usize = i32::MAX as usize - 16;

/// Greatest angle between edges of a rod without twist, rad. Straight rods in any orientation are this straight after
/// rounding.
const STRAIGHTNESS_TOLERANCE: f64 = 1e-7;

impl RodBundle {
    /// Builds a bundle of rods without bonds, at rest as given. With `twisting` rods may be curved: their natural
    /// curvature is that of the given shape, in material frames that are parallel along each rod.
    ///
    /// # Errors
    /// [`RodBundleError`] for values out of range, and for curved rods without `twisting`.
    pub fn new(rods: &[Rod], twisting: bool) -> Result<Self, RodBundleError> {
        if rods.is_empty() {
            return Err(RodBundleError::NoRods);
        }
        let count: usize = rods.iter().map(|r| r.vertices.len()).sum();
        if count > MAX_VERTICES {
            return Err(RodBundleError::TooMany {
                what: "vertices",
                count,
                most: MAX_VERTICES,
            });
        }
        let mut bundle = RodBundle::empty(twisting);
        for (number, rod) in rods.iter().enumerate() {
            check_material(number, rod)?;
            check_shape(number, rod, twisting)?;
            bundle.push_rod(number, rod);
        }
        bundle.bonds = Bonds::none(count);
        Ok(bundle)
    }

    fn empty(twisting: bool) -> Self {
        RodBundle {
            rod_offsets: vec![0],
            area: Vec::new(),
            diameter: Vec::new(),
            parent: Vec::new(),
            rest: Vectors::default(),
            mass: Vec::new(),
            bend: Vec::new(),
            natural_curvature: [Vec::new(), Vec::new()],
            twist: Vec::new(),
            tension_limit: Vec::new(),
            shear_limit: Vec::new(),
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

    fn push_rod(&mut self, number: usize, rod: &Rod) {
        let m = &rod.material;
        let n = rod.vertices.len();
        let start = self.mass.len();
        let edges: Vec<DVec3> = rod.vertices.windows(2).map(|p| p[1] - p[0]).collect();
        let directors = material_frame::parallel_directors(&edges, rod.director);
        for (i, &position) in rod.vertices.iter().enumerate() {
            let inner = i > 0 && i + 1 < n;
            let kappa = if inner && self.twisting {
                let frame = |j: usize| (edges[j].normalize(), directors[j]);
                material_frame::curvature(frame(i - 1), frame(i))
            } else {
                [0.0; 2]
            };
            let length = edges.get(i).map(|e| e.length());
            self.rest.push(position);
            self.bend.push(if inner { m.bend } else { 0.0 });
            self.natural_curvature[0].push(kappa[0]);
            self.natural_curvature[1].push(kappa[1]);
            self.twist
                .push(if inner && self.twisting { m.twist } else { 0.0 });
            let relative = rod.relative_strength.get(i).copied().unwrap_or(1.0);
            self.tension_limit.push(m.tension_limit * relative);
            self.shear_limit.push(m.shear_limit * relative);
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
        self.rod_offsets.push((start + n) as u32);
        self.distribute_mass(start..start + n);
    }

    /// Gives each of a rod's vertices half of the mass of its edges.
    pub(crate) fn distribute_mass(&mut self, vertices: Range<usize>) {
        for i in vertices.clone() {
            let before = if i > vertices.start {
                self.edge_mass[i - 1]
            } else {
                0.0
            };
            self.mass[i] = 0.5 * (before + self.edge_mass[i]);
        }
    }

    /// Adds a mass per length (kg/m) to each rod: what lies on it and moves along.
    pub(crate) fn add_line_mass(&mut self, mass: f64) {
        for j in 0..self.vertices() {
            if self.is_edge(j) {
                self.edge_mass[j] += mass * self.rest_length[j];
            }
        }
        (0..self.rods()).for_each(|rod| self.distribute_mass(self.rod(rod)));
    }

    /// Returns the number of rods.
    pub fn rods(&self) -> usize {
        self.rod_offsets.len() - 1
    }

    /// Returns the number of vertices, which is the length of all vertex and edge arrays.
    pub fn vertices(&self) -> usize {
        self.mass.len()
    }

    /// Returns the vertices of rod `rod`, which must be below [`RodBundle::rods`].
    pub fn rod(&self, rod: usize) -> Range<usize> {
        self.rod_offsets[rod] as usize..self.rod_offsets[rod + 1] as usize
    }

    /// Returns the rod of a vertex.
    pub fn rod_of(&self, vertex: usize) -> usize {
        self.rod_offsets.partition_point(|&f| f as usize <= vertex) - 1
    }

    /// Whether `edge` is an edge of a rod and no gap.
    pub fn is_edge(&self, edge: usize) -> bool {
        edge < self.vertices() && self.stretch[edge] > 0.0
    }

    /// Returns l = |ē₋| + |ē₊| at a vertex, m. At a rod's ends it is the length of the only edge.
    pub(crate) fn both_lengths(&self, vertex: usize) -> f64 {
        let length = |edge: usize| {
            if self.is_edge(edge) {
                self.rest_length[edge]
            } else {
                0.0
            }
        };
        vertex.checked_sub(1).map_or(0.0, length) + length(vertex)
    }

    /// Returns the sum of all masses, kg.
    pub fn total_mass(&self) -> f64 {
        self.mass.iter().sum()
    }

    /// Replaces the bonds.
    ///
    /// # Errors
    /// [`RodBundleError::Bond`] where a bond names a vertex or edge that does not exist, joins a rod to itself, or has a
    /// value out of range.
    pub fn set_bonds(&mut self, bonds: Vec<Bond>) -> Result<(), RodBundleError> {
        for (number, bond) in bonds.iter().enumerate() {
            self.check_bond(number, bond)?;
        }
        if bonds.len() > MAX_VERTICES {
            return Err(RodBundleError::TooMany {
                what: "bonds",
                count: bonds.len(),
                most: MAX_VERTICES,
            });
        }
        self.bonds = Bonds::sorted(bonds, self.vertices());
        self.generation += 1;
        Ok(())
    }

    fn check_bond(&self, bond: usize, b: &Bond) -> Result<(), RodBundleError> {
        let fail = |what, value, right| {
            Err(RodBundleError::Bond {
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
            return fail("parameter along the edge", b.t, "from 0 to 1");
        }
        if !(-1.0..=1.0).contains(&b.rest_cosine) {
            return fail("cosine at rest", b.rest_cosine, "from -1 to 1");
        }
        if !(0.0..=1.0).contains(&b.damage) {
            return fail("damage", b.damage, "from 0 to 1");
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
            ("tensile strength (N)", b.tension_strength),
            ("shear strength (N)", b.shear_strength),
            ("fracture energy (J)", b.fracture_energy),
            ("fracture energy in shear (J)", b.shear_fracture_energy),
        ];
        for (what, value) in strengths {
            if value.is_nan() || value < 0.0 {
                return fail(what, value, "0 or more");
            }
        }
        Ok(())
    }
}

fn check_material(number: usize, rod: &Rod) -> Result<(), RodBundleError> {
    let fail = |what, value, right| {
        Err(RodBundleError::Rod {
            rod: number,
            what,
            value,
            right,
        })
    };
    let m = &rod.material;
    let positive = [
        ("mass per length (kg/m)", m.line_density),
        ("stretching stiffness (N)", m.stretch),
        ("cell area (m²)", m.area),
        ("diameter (m)", m.diameter),
    ];
    for (what, value) in positive {
        if !(value > 0.0 && value.is_finite()) {
            return fail(what, value, "above 0 and finite");
        }
    }
    for (what, value) in [
        ("bending stiffness (N m²)", m.bend),
        ("twisting stiffness (N m²)", m.twist),
    ] {
        if !(value >= 0.0 && value.is_finite()) {
            return fail(what, value, "0 or more and finite");
        }
    }
    let limits = [
        ("strain at tensile failure", m.tension_limit),
        ("shear strain at failure", m.shear_limit),
        ("yield strain", m.yield_strain),
    ];
    let scatter = rod
        .relative_strength
        .iter()
        .map(|&s| ("relative strength", s));
    for (what, value) in limits.into_iter().chain(scatter) {
        if value.is_nan() || value <= 0.0 {
            return fail(what, value, "above 0");
        }
    }
    Ok(())
}

fn check_shape(number: usize, rod: &Rod, twisting: bool) -> Result<(), RodBundleError> {
    let n = rod.vertices.len();
    if n < 2 {
        return Err(RodBundleError::ShortRod {
            rod: number,
            count: n,
        });
    }
    let mut previous: Option<DVec3> = None;
    for (vertex, pair) in rod.vertices.windows(2).enumerate() {
        let edge = pair[1] - pair[0];
        let length = edge.length();
        if !(length > 0.0 && length.is_finite()) {
            return Err(RodBundleError::Edge {
                rod: number,
                vertex,
                length,
            });
        }
        let t = edge / length;
        if let Some(before) = previous {
            if before.dot(t) < -1.0 + 1e-9 {
                return Err(RodBundleError::Fold {
                    rod: number,
                    vertex,
                });
            }
            let angle = before.cross(t).length().max(1.0 - before.dot(t));
            if !twisting && angle > STRAIGHTNESS_TOLERANCE {
                return Err(RodBundleError::Curved {
                    rod: number,
                    vertex,
                    angle,
                });
            }
        }
        previous = Some(t);
    }
    Ok(())
}
