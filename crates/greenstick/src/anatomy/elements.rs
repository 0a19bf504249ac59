//! A stem as finite elements: for ParaView, and as the input of CalculiX.

use super::outputs::Outputs;
use crate::Error;
use glam::DVec3;
use greenstick_formats::finite_elements::write_solid_model;
use greenstick_formats::vtk::{Field, Hexahedra, write_hexahedra};
use greenstick_geometry::{Context, Metadata, Values};
use greenstick_wood::anatomy::{
    Anatomy, AnatomyRequest, ElasticWood, ElementError, ElementsReport, StemElement, StemElements,
    StemMeasures,
};
use greenstick_wood::species::Species;

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
    let wood = wood(request).map_err(E::from)?;
    let nodes: Vec<DVec3> = stem.nodes.iter().map(|n| *n + outputs.offset()).collect();
    outputs.add(grid(&stem, &nodes, wood.as_ref(), outputs.metadata())?)?;
    let mut notes = Vec::new();
    match &wood {
        Some(wood) => {
            let mut model = stem.solid_model(wood, outputs.offset());
            model.metadata = outputs.metadata().clone();
            outputs.add(write_solid_model(&model, "stem.inp").map_err(Error::from)?)?;
            notes.push(format!("elastic constants in stem.inp: {}", wood.basis()));
        }
        None => notes.push(
            "stem.inp was not written: the elastic constants of wood take a species".to_owned(),
        ),
    }
    Ok(Written {
        report: Some(ElementsReport::new(&stem, anatomy, measures)),
        notes,
    })
}

/// The wood of the species that is named; `None` where none is, or the tables lack its density.
fn wood(request: &AnatomyRequest) -> Result<Option<ElasticWood>, Error> {
    let Some(name) = &request.species else {
        return Ok(None);
    };
    Ok(ElasticWood::new(
        Species::find(name)?,
        request.mensuration.moisture,
    )?)
}

/// The elements for ParaView.
fn grid(
    stem: &StemElements,
    nodes: &[DVec3],
    wood: Option<&ElasticWood>,
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
