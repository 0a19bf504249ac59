//! The rest of the input in a film: what rods do not fill, and what carries it.

use super::{FilmError, FilmOptions, Run, SkinReport};
use greenstick_fibre::scene::StemChoice;
use greenstick_geometry::components::NONE;
use greenstick_geometry::{Context, Mesh};
use greenstick_skin::remainder::{CarriedPart, CarriedParts, StemMesh};
use greenstick_skin::rods::RodSkin;
use serde::Serialize;

/// A part of the input that the rods do not fill.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CarriedPiece {
    /// Its name.
    pub name: String,
    /// The input's mesh that it is of.
    pub input: String,
    /// The piece of the skin whose rods carry it; none for what hangs on nothing and stands still.
    pub carried_by: Option<String>,
    /// Number of triangles.
    pub triangles: usize,
    /// Whether it is closed; what is open in the input stays open.
    pub closed: bool,
}

/// The rest of an input.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct RestReport {
    /// Its parts.
    pub pieces: Vec<CarriedPiece>,
    /// Volume of the stem's real ends beyond the rods' ends, which is left out, m³.
    pub left_out_m3: f64,
    /// What could not be done as it should, a sentence each.
    pub notes: Vec<String>,
}

impl RestReport {
    /// Returns the report of carried parts; `pieces` are the names of the skin's pieces.
    fn new(carried: &CarriedParts, pieces: &[String]) -> Self {
        let piece = |part: &CarriedPart| CarriedPiece {
            name: part.name.clone(),
            input: part.input.clone(),
            carried_by: (part.carrier)
                .and_then(|carrier| pieces.get(carried.carriers[carrier].piece).cloned()),
            triangles: part.mesh.triangles.len(),
            closed: is_closed(&part.mesh),
        };
        RestReport {
            pieces: carried.parts.iter().map(piece).collect(),
            left_out_m3: carried.left_out_volume,
            notes: carried.notes.clone(),
        }
    }
}

impl Run {
    /// Returns the rest of the input where `options` include it and the run is of an input, and adds it to the report.
    pub(super) fn carried_parts(
        &self,
        skin: &RodSkin,
        options: &FilmOptions,
        report: &mut SkinReport,
        context: &Context,
    ) -> Result<CarriedParts, FilmError> {
        if !options.rest || self.scene.stem.kind != StemChoice::Input {
            return Ok(CarriedParts::default());
        }
        let input = StemMesh {
            scene: &self.grown.scene,
            node: self.grown.node,
            shell: &self.grown.shell,
        };
        let carried = self.with_materials(|wood, materials| {
            CarriedParts::find(&input, wood, skin, materials, context)
        })?;
        let names: Vec<String> = report.pieces.iter().map(|p| p.name.clone()).collect();
        report.rest = RestReport::new(&carried, &names);
        Ok(carried)
    }
}

/// Returns whether no edge of a mesh is open.
fn is_closed(mesh: &Mesh) -> bool {
    let adjacency = mesh.adjacency();
    adjacency.neighbours.iter().flatten().all(|&n| n != NONE)
}
