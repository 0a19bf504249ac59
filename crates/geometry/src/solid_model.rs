//! Orthotropic solids for finite elements.

use crate::provenance::Metadata;
use glam::DVec3;

/// A solid of hexahedra.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidModel {
    /// Nodes, m.
    pub nodes: Vec<DVec3>,
    /// Nodes of each element: four around one face, then those above them.
    pub hexahedra: Vec<[u32; 8]>,
    /// First and second material axis of each element (unit vectors at right angles).
    pub axes: Vec<[DVec3; 2]>,
    /// Parts of one material each; together they have every element once.
    pub parts: Vec<ElementSet>,
    /// Sets of nodes, for supports and loads.
    pub node_sets: Vec<NodeSet>,
    /// Remarks at the head of the file.
    pub metadata: Metadata,
}

/// A part of one material.
#[derive(Debug, Clone, PartialEq)]
pub struct ElementSet {
    /// Name: capitals, digits and `_`.
    pub name: String,
    /// Its elements, from 0.
    pub elements: Vec<u32>,
    /// What it is made of.
    pub material: OrthotropicMaterial,
}

/// A set of nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeSet {
    /// Name: capitals, digits and `_`.
    pub name: String,
    /// Its nodes, from 0.
    pub nodes: Vec<u32>,
}

/// An orthotropic elastic material in its axes 1, 2 and 3.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrthotropicMaterial {
    /// Moduli E1, E2, E3, Pa.
    pub moduli: [f64; 3],
    /// Poisson's ratios ν12, ν13, ν23: the contraction along the second axis over the stretch along the first.
    pub poisson: [f64; 3],
    /// Shear moduli G12, G13, G23, Pa.
    pub shear: [f64; 3],
    /// Density, kg/m³.
    pub density: f64,
}
