//! A stem as an orthotropic solid: its hexahedra with the elastic constants and densities of a species.

use super::hexahedra::{StemElement, StemElements};
use super::mensuration::WoodMass;
use crate::moisture::{FIBRE_SATURATION_PERCENT, Fallback, MoistureError};
use crate::species::{EngineeringConstants, Species};
use crate::tissue::Zone;
use glam::DVec3;
use greenstick_geometry::{ElementSet, Metadata, NodeSet, OrthotropicMaterial, SolidModel};
use std::ops::Range;

/// What the wood of a species is like as an elastic solid.
#[derive(Debug, Clone)]
pub struct ElasticWood {
    elastic: EngineeringConstants,
    /// Of heartwood and of sapwood, kg/m³.
    densities: [f64; 2],
}

impl ElasticWood {
    /// Returns the wood of a species at `moisture` percent, green where it is not given. `None` where the tables have no
    /// density.
    ///
    /// # Errors
    /// [`MoistureError`] where the moisture is out of range.
    pub fn new(species: &Species, moisture: Option<f64>) -> Result<Option<Self>, MoistureError> {
        let Some(mass) = WoodMass::new(species, moisture)? else {
            return Ok(None);
        };
        let moisture = moisture.unwrap_or(FIBRE_SATURATION_PERCENT);
        Ok(Some(ElasticWood {
            elastic: species.engineering_constants(moisture, Fallback::Estimate)?,
            densities: mass.densities(),
        }))
    }

    /// Density of a tissue, kg/m³; 0 where no table has it.
    pub fn density(&self, tissue: Zone) -> f64 {
        match tissue {
            Zone::Pith | Zone::Heartwood => self.densities[0],
            Zone::Sapwood => self.densities[1],
            Zone::Phloem | Zone::Bark => 0.0,
        }
    }

    fn material(&self, density: f64) -> OrthotropicMaterial {
        OrthotropicMaterial {
            moduli: self.elastic.moduli,
            poisson: self.elastic.poisson,
            shear: self.elastic.shear,
            density,
        }
    }

    /// Returns where its constants come from, in a few words.
    pub fn basis(&self) -> String {
        let modulus = &self.elastic.basis;
        let ratios = if self.elastic.own_ratios {
            ""
        } else {
            "; ratios of the mean hardwood or softwood stand for those that the tables lack"
        };
        format!("modulus along the grain, {modulus}{ratios}")
    }
}

impl StemElements {
    /// Returns the wood as a solid whose nodes are moved by `offset` (m). Bark is left out, whose constants no table has.
    pub fn solid_model(&self, wood: &ElasticWood, offset: DVec3) -> SolidModel {
        let elements: Vec<&StemElement> = self
            .elements
            .iter()
            .filter(|e| e.tissue <= Zone::Sapwood)
            .collect();
        // Nodes of bark alone are left out too.
        let mut numbers: Vec<Option<u32>> = vec![None; self.nodes.len()];
        for corner in elements.iter().flat_map(|e| e.corners) {
            numbers[corner as usize] = Some(0);
        }
        let mut kept = Vec::new();
        for (node, number) in self.nodes.iter().zip(&mut numbers) {
            if let Some(number) = number {
                *number = kept.len() as u32;
                kept.push(*node + offset);
            }
        }
        let number = |corner: u32| numbers[corner as usize].unwrap_or_default();
        let part = |name: &str, of: &dyn Fn(Zone) -> bool, density: f64| {
            let own = elements.iter().zip(0..).filter(|(e, _)| of(e.tissue));
            ElementSet {
                name: name.to_owned(),
                elements: own.map(|(_, k)| k).collect(),
                material: wood.material(density),
            }
        };
        let [heartwood, sapwood] = wood.densities;
        let parts = [
            part("HEARTWOOD", &|t| t <= Zone::Heartwood, heartwood),
            part("SAPWOOD", &|t| t == Zone::Sapwood, sapwood),
        ];
        let end = |name: &str, range: Range<usize>| NodeSet {
            name: name.to_owned(),
            nodes: numbers[range].iter().flatten().copied().collect(),
        };
        let (all, [butt, top]) = (self.nodes.len(), self.end_nodes);
        SolidModel {
            hexahedra: elements.iter().map(|e| e.corners.map(number)).collect(),
            axes: elements.iter().map(|e| [e.axes[0], e.axes[1]]).collect(),
            parts: parts
                .into_iter()
                .filter(|p| !p.elements.is_empty())
                .collect(),
            node_sets: vec![end("BUTT", 0..butt), end("TOP", all - top..all)],
            nodes: kept,
            metadata: Metadata::default(),
        }
    }
}
