//! The rest of the input in a film: what rods do not fill, and what carries it.

use super::error::FilmError;
use super::options::FilmOptions;
use super::report::{CarriedPiece, RestReport, SkinReport};
use super::run::Run;
use crate::remainder::{CarriedPart, CarriedParts, StemMesh};
use crate::rods::RodSkin;
use greenstick_fibre::scene::StemChoice;
use greenstick_geometry::components::NONE;
use greenstick_geometry::{Context, Mesh};

/// Returns the report of carried parts; `pieces` are the names of the skin's pieces.
fn rest_report(carried: &CarriedParts, pieces: &[String]) -> RestReport {
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
            scene: &self.wood.input,
            node: self.wood.node,
            shell: &self.wood.shell,
        };
        let carried = self.with_materials(|wood, materials| {
            CarriedParts::find(&input, wood, skin, materials, context)
        })?;
        let names: Vec<String> = report.pieces.iter().map(|p| p.name.clone()).collect();
        report.rest = rest_report(&carried, &names);
        Ok(carried)
    }
}

/// Returns whether no edge of a mesh is open.
fn is_closed(mesh: &Mesh) -> bool {
    let adjacency = mesh.adjacency();
    adjacency.neighbours.iter().flatten().all(|&n| n != NONE)
}
