//! The report on the breaks of a request.

use super::input::Input;
use super::notes::BreakNote;
use super::pieces::BreakPieces;
use super::scene::piece_reports;
use crate::report::{
    BreakReport, FaceReport, FurtherBreak, InputReport, PlaceReport, closed_volume,
};
use greenstick_fracture::parameters::SurfaceStyle;
use greenstick_geometry::Scene;
use greenstick_skin::prepared::PreparedStem;
use greenstick_wood::stem::StemKind;

/// Returns the notes on all breaks, in the order of the request.
pub(super) fn notes(breaks: &[BreakPieces]) -> Vec<&BreakNote> {
    let mut order: Vec<&BreakPieces> = breaks.iter().collect();
    order.sort_by_key(|m| m.number);
    order.iter().flat_map(|m| &m.pieces.notes).collect()
}

/// Reports on breaks, given in the order in which they were made, and on the pieces in `scene`.
pub(super) fn report(input: &Input, breaks: &[BreakPieces], scene: &Scene) -> BreakReport {
    let mut order: Vec<&BreakPieces> = breaks.iter().collect();
    order.sort_by_key(|m| m.number);
    let first = order[0];
    let further = order[1..].iter().map(|one| FurtherBreak {
        place: place_report(one.stages.stem.stem()),
        face: face_report(one),
        species: one.stages.heights.relief.report.clone(),
        hang: one.pieces.hang.clone(),
        crack_volume_m3: one.pieces.crack_volume_m3,
    });
    let mut pieces = piece_reports(breaks);
    for (report, node) in pieces.iter_mut().zip(&scene.nodes) {
        report.name.clone_from(&node.name);
    }
    BreakReport {
        scan: None,
        input: input_report(input, &breaks[0].stages.stem.sound),
        place: place_report(first.stages.stem.stem()),
        face: face_report(first),
        species: first.stages.heights.relief.report.clone(),
        pieces,
        hang: first.pieces.hang.clone(),
        crack_volume_m3: first.pieces.crack_volume_m3,
        further_breaks: further.collect(),
        notes: notes(breaks).iter().map(ToString::to_string).collect(),
    }
}

fn face_report(one: &BreakPieces) -> FaceReport {
    let heights = &one.stages.heights.heights;
    FaceReport {
        surface: match one.requested.recipe.face.surface {
            SurfaceStyle::Smooth => "smooth".into(),
            SurfaceStyle::Fibrous => "fibrous".into(),
        },
        bundles: one.stages.layout.bundles.bundles.len(),
        thorns: heights.thorns.len(),
        range_m: [heights.range.0, heights.range.1],
        limited: heights.limited,
        wanted_m: [heights.wanted.0, heights.wanted.1],
    }
}

/// Reports on the input, whose stem is `stem`.
fn input_report(input: &Input, stem: &PreparedStem) -> InputReport {
    let found = &stem.found;
    let mut repairs = input.scene.notes.clone();
    repairs.extend(found.notes.iter().cloned());
    if stem.split > 0 {
        repairs.push(format!(
            "{} triangles near the break were split because the stem is bent there",
            stem.split
        ));
    }
    let shell = found.shell.iter().map(|&t| t as usize);
    let (closed, volume) = closed_volume(&stem.node().mesh.submesh(shell));
    InputReport {
        meshes: stem.scene.nodes.len(),
        triangles: input.triangles,
        area_m2: input.area_m2,
        volume_m3: volume.map(|v| v * stem.volume_scale()),
        closed,
        repairs,
    }
}

fn place_report(prepared: &PreparedStem) -> PlaceReport {
    let stem = &prepared.found.stem;
    PlaceReport {
        mesh: prepared.node().name.clone(),
        kind: match stem.kind {
            StemKind::Round => "round".into(),
            StemKind::Board => "board".into(),
        },
        stem_length_m: stem.length,
        length_m: stem.location,
        point_m: stem.grain.axis().frame(stem.location).origin.to_array(),
        radius_m: stem.radius,
        pith_m: stem.rings.pith().to_array(),
        free_m: [stem.usable.0, stem.usable.1],
    }
}
