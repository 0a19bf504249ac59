//! The specimen as a bundle of rods.

use super::error::FractureError;
use super::section::{SectionFacet, TestSection};
use super::specimen::FractureTest;
use crate::bonds::Bond;
use crate::placement::{FacetMaterial, NearestPoint, WoodMaterial};
use crate::rod_bundle::{Rod, RodBundle};
use glam::DVec3;

/// Axes of the world.
pub(super) const ACROSS: usize = 0;
pub(super) const UP: usize = 1;
pub(super) const ALONG: usize = 2;

/// How a specimen is divided along the grain: its rods' vertices lie in common cross-sections.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Division {
    /// Edges of a rod: an even number.
    pub edges: usize,
    /// Length of an edge, m.
    pub edge: f64,
    /// The first cross-section at which the crack's plane is bonded.
    pub first_bonded: usize,
}

impl Division {
    pub fn new(test: &FractureTest) -> Self {
        let half = (0.5 * test.grain_length() / test.edge - 1e-9)
            .ceil()
            .max(4.0);
        let edge = 0.5 * test.grain_length() / half;
        Division {
            edges: 2 * half as usize,
            edge,
            first_bonded: (test.crack / edge + 0.5).round() as usize,
        }
    }

    /// Returns the crack at the start, m: bonds stand for half an edge before and after their cross-section.
    pub fn crack(&self) -> f64 {
        (self.first_bonded as f64 - 0.5) * self.edge
    }

    /// Returns the vertices of some rods at a cross-section.
    pub fn vertices(&self, rods: &[usize], section: usize) -> Vec<u32> {
        let vertex = |&rod: &usize| (rod * (self.edges + 1) + section) as u32;
        rods.iter().map(vertex).collect()
    }
}

/// Builds the specimen.
pub(super) fn test_bundle(
    test: &FractureTest,
    section: &TestSection,
    division: &Division,
    wood: &WoodMaterial,
) -> Result<RodBundle, FractureError> {
    let rods: Vec<Rod> = (section.rods.iter())
        .map(|rod| {
            let at = |k: usize| rod.position.extend(k as f64 * division.edge);
            let vertices: Vec<DVec3> = (0..=division.edges).map(at).collect();
            Rod::new(vertices, wood.rod(rod.area))
        })
        .collect();
    let mut bundle = RodBundle::new(&rods, false)?;
    let bonds = section.facets.iter().flat_map(|facet| {
        let crossed = section.is_crossed(facet.rods);
        let start = if crossed { division.first_bonded } else { 0 };
        facet_bonds(test, section, division, wood, facet, start)
    });
    bundle.set_bonds(bonds.collect())?;
    Ok(bundle)
}

/// Returns the bonds of a facet from a cross-section on: one from each rod to the other.
fn facet_bonds(
    test: &FractureTest,
    section: &TestSection,
    division: &Division,
    wood: &WoodMaterial,
    facet: &SectionFacet,
    start: usize,
) -> Vec<Bond> {
    let [a, b] = facet.rods.map(|r| section.rods[r].position);
    let distance = a.distance(b);
    let upright = ((b - a).y / distance).powi(2);
    let material = FacetMaterial::new(wood, test.system.radial_part(upright))
        .with_roughness(test.arrangement.roughness());
    let mut bonds = Vec::new();
    for k in start..=division.edges {
        let at_end = k == 0 || k == division.edges;
        let length = division.edge * if at_end { 0.25 } else { 0.5 };
        let vertices = division.vertices(&facet.rods, k);
        for (from, to) in [(0, 1), (1, 0)] {
            let last = usize::from(k == division.edges);
            let nearest = NearestPoint {
                edge: vertices[to] as usize - last,
                t: last as f64,
                distance,
                cosine: 0.0,
            };
            let vertex = vertices[from] as usize;
            bonds.push(material.bond(vertex, &nearest, facet.width * length, 1.0));
        }
    }
    bonds
}
