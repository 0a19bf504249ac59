//! A stem as finite elements: for ParaView, and as the input of CalculiX.

use super::outputs::Outputs;
use crate::Error;
use glam::DVec3;
use greenstick_formats::finite_elements::{
    ElementSet, NodeSet, OrthotropicMaterial, SolidModel, write_solid_model,
};
use greenstick_formats::vtk::{Field, Hexahedra, write_hexahedra};
use greenstick_geometry::{Context, Metadata, Values};
use greenstick_wood::anatomy::{
    Anatomy, AnatomyRequest, ElementError, ElementsReport, StemElement, StemElements, StemMeasures,
    WoodMass,
};
use greenstick_wood::moisture::{FIBRE_SATURATION_PERCENT, Fallback};
use greenstick_wood::species::{EngineeringConstants, Species};
use greenstick_wood::tissue::Zone;

/// What became of a stem's elements.
pub(super) struct Written {
    pub report: Option<ElementsReport>,
    pub notes: Vec<String>,
}

/// Writes `stem.vtu`, and `stem.inp` where the species is known. Notes say why there is none.
pub(super) fn write<E: From<Error>>(
    anatomy: &Anatomy,
    measures: &StemMeasures,
    request: &AnatomyRequest,
    context: &Context,
    outputs: &mut Outputs<E>,
) -> Result<Written, E> {
    let stem = match StemElements::new(anatomy, request.mensuration.element_size, context) {
        Ok(stem) => stem,
        Err(ElementError::Cancelled(cancelled)) => return Err(Error::from(cancelled).into()),
        Err(error) => {
            return Ok(Written {
                report: None,
                notes: vec![format!("no finite elements were made: {error}")],
            });
        }
    };
    let wood = Wood::new(request).map_err(E::from)?;
    let nodes: Vec<DVec3> = stem.nodes.iter().map(|n| *n + outputs.offset()).collect();
    outputs.add(grid(&stem, &nodes, wood.as_ref(), outputs.metadata())?)?;
    let mut notes = Vec::new();
    match &wood {
        Some(wood) => {
            let model = solid_model(&stem, &nodes, wood, outputs.metadata());
            outputs.add(write_solid_model(&model, "stem.inp").map_err(Error::from)?)?;
            notes.extend(wood.note());
        }
        None => notes.push(
            "stem.inp was not written: the elastic constants of wood take a species".to_owned(),
        ),
    }
    let (low, high) = anatomy.sections().whole;
    let report = ElementsReport {
        nodes: stem.nodes.len(),
        hexahedra: stem.elements.len(),
        volume_m3: stem.volume(|_| true),
        sections_volume_m3: measures.volume_between(low, high),
        wood_volume_m3: stem.volume(|e| e.tissue <= Zone::Sapwood),
    };
    Ok(Written {
        report: Some(report),
        notes,
    })
}

/// What a species' wood is like.
struct Wood {
    elastic: EngineeringConstants,
    /// Of heartwood and of sapwood, kg/m³.
    densities: [f64; 2],
}

impl Wood {
    /// The wood of the species that is named; `None` where none is, or the tables lack its density.
    fn new(request: &AnatomyRequest) -> Result<Option<Self>, Error> {
        let Some(name) = &request.species else {
            return Ok(None);
        };
        let species = Species::find(name)?;
        let moisture = request.mensuration.moisture;
        let Some(mass) = WoodMass::new(species, moisture)? else {
            return Ok(None);
        };
        let moisture = moisture.unwrap_or(FIBRE_SATURATION_PERCENT);
        Ok(Some(Wood {
            elastic: species.engineering_constants(moisture, Fallback::Estimate)?,
            densities: mass.densities(),
        }))
    }

    /// Density of a tissue, kg/m³; 0 where no table has it.
    fn density(&self, tissue: Zone) -> f64 {
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

    /// What was assumed of its constants.
    fn note(&self) -> Option<String> {
        let ratios = (!self.elastic.own_ratios).then_some(
            "ratios of the mean hardwood or softwood stand for those that the tables lack",
        );
        let modulus = self.elastic.basis.to_string();
        let ratios = ratios.map_or(String::new(), |r| format!("; {r}"));
        Some(format!(
            "elastic constants in stem.inp: modulus along the grain, {modulus}{ratios}"
        ))
    }
}

/// The elements for ParaView.
fn grid(
    stem: &StemElements,
    nodes: &[DVec3],
    wood: Option<&Wood>,
    metadata: &Metadata,
) -> Result<greenstick_formats::Encoded, Error> {
    let axis = |k: usize| -> Vec<DVec3> { stem.elements.iter().map(|e| e.axes[k]).collect() };
    let cells: Vec<[u32; 8]> = stem.elements.iter().map(|e| e.corners).collect();
    let numbers = |of: &dyn Fn(&StemElement) -> f64| -> Values {
        Values::F64(stem.elements.iter().map(of).collect())
    };
    let tissues = stem.elements.iter().map(|e| e.tissue.code()).collect();
    let rings = stem.elements.iter().map(|e| u32::from(e.ring)).collect();
    let mut cell_data = vec![
        Field::scalar("zone", Values::U8(tissues)),
        Field::scalar("ring", Values::U32(rings)),
        Field::vectors("longitudinal", &axis(0)),
        Field::vectors("radial", &axis(1)),
        Field::vectors("tangential", &axis(2)),
        Field::scalar("volume_m3", numbers(&|e| e.volume)),
    ];
    if let Some(wood) = wood {
        let density = numbers(&|e| wood.density(e.tissue));
        cell_data.push(Field::scalar("density_kg_m3", density));
    }
    let grid = Hexahedra {
        points: nodes,
        cells: &cells,
        point_data: &[],
        cell_data: &cell_data,
        metadata,
    };
    Ok(write_hexahedra(&grid, "stem.vtu")?)
}

/// The wood as a solid for CalculiX. Bark is left out, whose constants no table has.
fn solid_model(
    stem: &StemElements,
    nodes: &[DVec3],
    wood: &Wood,
    metadata: &Metadata,
) -> SolidModel {
    let elements: Vec<&StemElement> = stem
        .elements
        .iter()
        .filter(|e| e.tissue <= Zone::Sapwood)
        .collect();
    // Nodes of bark alone are left out too.
    let mut numbers: Vec<Option<u32>> = vec![None; nodes.len()];
    for corner in elements.iter().flat_map(|e| e.corners) {
        numbers[corner as usize] = Some(0);
    }
    let mut kept = Vec::new();
    for (node, number) in nodes.iter().zip(&mut numbers) {
        if let Some(number) = number {
            *number = kept.len() as u32;
            kept.push(*node);
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
    let end = |name: &str, range: std::ops::Range<usize>| NodeSet {
        name: name.to_owned(),
        nodes: numbers[range].iter().flatten().copied().collect(),
    };
    let (all, section) = (nodes.len(), stem.nodes_per_section);
    SolidModel {
        hexahedra: elements.iter().map(|e| e.corners.map(number)).collect(),
        axes: elements.iter().map(|e| [e.axes[0], e.axes[1]]).collect(),
        parts: parts
            .into_iter()
            .filter(|p| !p.elements.is_empty())
            .collect(),
        node_sets: vec![end("BUTT", 0..section), end("TOP", all - section..all)],
        nodes: kept,
        metadata: metadata.clone(),
    }
}
