//! The report on the breaks of a stem.

use super::finished_break::{FinishedBreak, in_order_of_request};
use super::scene::piece_reports;
use crate::prepared::{PreparedStem, volume_scale};
use crate::report::{BreakNote, BreakReport, FaceReport, FurtherBreak, InputReport, PlaceReport};
use crate::stages::StemStage;
use greenstick_fracture::parameters::SurfaceStyle;
use greenstick_geometry::text::one_line;
use greenstick_geometry::{Mesh, Scene};

/// The scene that is broken, and what reports say of it.
#[derive(Debug)]
pub struct BreakInput {
    /// The scene.
    pub scene: Scene,
    /// Triangles of all meshes.
    triangles: usize,
    /// Area of all meshes, m².
    area_m2: f64,
}

impl BreakInput {
    /// Measures a scene. The strands on faces that were broken before are left out: they are no wood that could be broken. So is the
    /// only material of a scene that says nothing of how its surface looks, as of an OBJ file without its MTL file: the surface is then
    /// shown as that of wood.
    pub fn new(mut scene: Scene) -> Self {
        leave_out_details(&mut scene);
        leave_out_blank_material(&mut scene);
        let triangles = scene.nodes.iter().map(|n| n.mesh.triangles.len()).sum();
        let area_m2 = scene
            .nodes
            .iter()
            .map(|n| n.mesh.area() * volume_scale(n).cbrt().powi(2))
            .sum();
        BreakInput {
            scene,
            triangles,
            area_m2,
        }
    }
}

/// Removes the only material of a scene where it says nothing: no texture, no colour of vertices, and the grey or white that programs
/// write for a material nobody has changed. Says so in the scene's notes.
fn leave_out_blank_material(scene: &mut Scene) {
    let [material] = &scene.materials[..] else {
        return;
    };
    let textures = [
        &material.base_color_texture,
        &material.metallic_roughness_texture,
        &material.normal_texture,
        &material.occlusion_texture,
        &material.emissive_texture,
    ];
    let is_default = [0.8f32, 1.0].iter().any(|&grey| {
        let off = material.base_color[..3].iter().map(|c| (c - grey).abs());
        off.fold(0.0, f32::max) < 1e-3
    });
    let colours = |mesh: &Mesh| mesh.attributes.keys().any(|name| name.starts_with("COLOR"));
    if !is_default
        || textures.iter().any(|t| t.is_some())
        || material.alpha_mode != "OPAQUE"
        || material.metallic > 0.0
        || material.emissive != [0.0; 3]
        || !material.extensions.is_empty()
        || scene.nodes.iter().any(|n| colours(&n.mesh))
    {
        return;
    }
    let name = one_line(&material.name);
    scene.notes.push(format!(
        "The material \"{name}\" has the default colour and no texture: the surface is shown as that of wood."
    ));
    scene.materials.clear();
    scene.change_meshes(
        |mesh| !mesh.materials.is_empty(),
        |mesh| mesh.materials.clear(),
    );
}

/// Removes the nodes of a scene that only add to the looks of others, and says so in its notes.
fn leave_out_details(scene: &mut Scene) {
    let details = scene.nodes.iter().filter(|n| n.is_detail).count();
    if details == 0 {
        return;
    }
    // Where each node comes to be.
    let mut kept = 0;
    let places: Vec<Option<usize>> = (scene.nodes.iter())
        .map(|node| {
            let place = (!node.is_detail).then_some(kept);
            kept += usize::from(!node.is_detail);
            place
        })
        .collect();
    scene.nodes.retain(|node| !node.is_detail);
    for node in &mut scene.nodes {
        node.parent = node
            .parent
            .and_then(|parent| places.get(parent).copied().flatten());
    }
    scene.notes.push(format!(
        "{details} meshes of torn fibre on earlier breaks were left out"
    ));
}

/// Returns the notes on all breaks, in the order of the request, and those on places that were left out.
pub fn break_notes(breaks: &[FinishedBreak], left_out: &[BreakNote]) -> Vec<BreakNote> {
    let order = in_order_of_request(breaks);
    let notes = order.iter().flat_map(|one| one.pieces.notes.clone());
    notes.chain(left_out.iter().cloned()).collect()
}

/// Reports on breaks of an input, given in the order in which they were made, on the pieces in `scene`, and on places
/// that were left out. Returns `None` where there is no break.
pub fn break_report(
    input: &BreakInput,
    breaks: &[FinishedBreak],
    scene: &Scene,
    left_out: &[BreakNote],
) -> Option<BreakReport> {
    let order = in_order_of_request(breaks);
    let first = order.first()?;
    let further = order[1..].iter().map(|one| FurtherBreak {
        place: place_report(&one.stages.stem),
        face: face_report(one),
        species: one.stages.heights.relief.report.clone(),
        hang: one.pieces.hang.clone(),
        crack_volume_m3: one.pieces.crack_volume_m3,
    });
    let mut pieces = piece_reports(breaks);
    for (report, node) in pieces.iter_mut().zip(&scene.nodes) {
        report.name.clone_from(&node.name);
    }
    Some(BreakReport {
        scan: None,
        input: input_report(input, &breaks[0].stages.stem.sound),
        place: place_report(&first.stages.stem),
        face: face_report(first),
        species: first.stages.heights.relief.report.clone(),
        pieces,
        hang: first.pieces.hang.clone(),
        crack_volume_m3: first.pieces.crack_volume_m3,
        further_breaks: further.collect(),
        notes: break_notes(breaks, left_out)
            .iter()
            .map(ToString::to_string)
            .collect(),
    })
}

fn face_report(one: &FinishedBreak) -> FaceReport {
    let heights = &one.stages.heights.heights;
    let stem = one.stages.stem.stem();
    let (low, high) = one.stages.cut.face.cut.face_range(&stem.grain);
    let location = stem.found.stem.location;
    let percentile = percentiles(&heights.surface.heights);
    FaceReport {
        seed: one.stages.stem.face.seed,
        surface: match one.stages.stem.face.surface {
            SurfaceStyle::Smooth => "smooth".into(),
            SurfaceStyle::Fibrous => "fibrous".into(),
        },
        bundles: one.stages.layout.bundles.bundles.len(),
        thorns: heights.thorns.len(),
        range_m: [low - location, high - location],
        percentiles_m: [percentile(0.05) - location, percentile(0.95) - location],
        scales: heights.scales.into(),
        moved_m: heights.moved,
        limited: heights.limited,
        wanted_m: [heights.wanted.0, heights.wanted.1],
    }
}

/// Returns what tells the height that a share of a face's corners lies below: of all corners of all facets, as the species
/// counts them.
fn percentiles(heights: &[impl AsRef<[f64]>]) -> impl Fn(f64) -> f64 {
    let mut sorted: Vec<f64> = heights.iter().flat_map(AsRef::as_ref).copied().collect();
    sorted.sort_unstable_by(f64::total_cmp);
    move |share| {
        let last = sorted.len().saturating_sub(1);
        let index = (share * last as f64) as usize;
        sorted.get(index).copied().unwrap_or_default()
    }
}

/// Reports on the input, whose stem is `stem`.
fn input_report(input: &BreakInput, stem: &PreparedStem) -> InputReport {
    let found = &stem.found;
    let mut repairs = input.scene.notes.clone();
    repairs.extend(found.notes.iter().cloned());
    if stem.split > 0 {
        repairs.push(format!(
            "{} triangles near the break were split because the stem is bent there",
            stem.split
        ));
    }
    let (closed, volume_m3) = stem.closed_volume();
    InputReport {
        meshes: stem.scene.nodes.len(),
        triangles: input.triangles,
        area_m2: input.area_m2,
        volume_m3,
        closed,
        repairs,
    }
}

fn place_report(stage: &StemStage) -> PlaceReport {
    let prepared = stage.stem();
    let stem = &prepared.found.stem;
    PlaceReport {
        mesh: prepared.node().name.clone(),
        kind: stem.kind.word().into(),
        stem_length_m: stage.whole.length,
        length_m: stem.location,
        point_m: stem.grain.axis().frame(stem.location).origin.to_array(),
        radius_m: stem.radius,
        pith_m: stem.rings.pith().to_array(),
        free_m: [stem.usable.0, stem.usable.1],
    }
}
