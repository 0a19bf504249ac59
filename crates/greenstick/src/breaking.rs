//! The whole way from a scene and a request to broken pieces with materials, and a report.

use crate::branch::bark_material;
use crate::cracking::{Cracks, SawnEnd};
use crate::fray::{Bent, FrayOptions, fray};
use crate::looks::{Looks, looks};
use crate::model::Model;
use crate::report::{
    BreakReport, FaceReport, InputReport, PieceReport, PlaceReport, SpeciesReport, closed_volume,
};
use crate::{Error, Prepared, prepare};
use glam::{DAffine3, DVec2, DVec3};
use greenstick_fracture::parameters::{BreakParameters, Surface};
use greenstick_fracture::recipe::Recipe;
use greenstick_geometry::{
    Context, Image, ImageSource, Material, Mesh, Node, Scene, Stage, Texture, TextureReference,
    mesh::NO_MATERIAL,
};
use greenstick_skin::pieces::lacks_material;
use greenstick_skin::settle::settle;
use greenstick_skin::texture;
use greenstick_skin::untangle::{Places, untangle};
use greenstick_skin::wind::Wound;
use greenstick_wood::moisture::{AIR_DRY_PERCENT, Fallback};
use greenstick_wood::species::{DEFAULT_BUNDLE_DIAMETER, HeightRule, Species};
use greenstick_wood::stem::{Stem, StemKind, StemLocation, StemOptions};

/// What is to be broken, where and how.
#[derive(Debug, Clone, PartialEq)]
pub struct BreakRequest {
    /// Where.
    pub place: StemLocation,
    /// What is known of the stem.
    pub stem: StemOptions,
    /// How.
    pub recipe: Recipe,
    /// How far the pieces are moved apart, m.
    pub part: f64,
    /// How much the thorns are bent and torn loose, 0 (not at all) to 1.
    pub fray: f64,
    /// Width of the baked textures, pixels (even; half as high).
    pub texture_width: u32,
}

impl Default for BreakRequest {
    fn default() -> Self {
        BreakRequest {
            place: StemLocation::Fraction(0.5),
            stem: StemOptions::default(),
            recipe: Recipe::default(),
            part: 0.0,
            fray: 0.0,
            texture_width: 2048,
        }
    }
}

/// Broken pieces.
#[derive(Debug, Clone)]
pub struct Broken {
    /// The pieces `lower`, `upper` and so on, then what was not touched.
    pub scene: Scene,
    /// What was done.
    pub report: BreakReport,
    /// The stem that was broken.
    pub stem: Stem,
    /// What its wood and bark look like.
    pub looks: Looks,
    /// Material of the wood inside.
    pub inner_material: u32,
    /// Side of the square that holds the section, m.
    pub width: f64,
    /// Whether the pieces were moved apart, or one hangs on the other.
    pub apart: bool,
    /// Direction of the hinge that the upper piece hangs on, where it does.
    pub hinge: Option<DVec3>,
    /// The sawn end that was cracked.
    pub end: Option<SawnEnd>,
}

/// Breaks a stem in a scene.
///
/// # Errors
/// [`Error`] where there is no stem at the place, it cannot be cut there, or the caller cancelled.
pub fn break_scene(
    scene: Scene,
    request: &BreakRequest,
    context: &Context,
) -> Result<Broken, Error> {
    let p = &request.recipe.face;
    let [stem, cut, textures] = context.split([
        (Stage::new("stem"), 1.0),
        (Stage::new("break"), 2.0),
        (Stage::new("textures"), 8.0),
    ]);
    stem.report(0.0)?;
    let mut repairs = scene.notes.clone();
    let triangles = scene.nodes.iter().map(|n| n.mesh.triangles.len()).sum();
    let area = scene
        .nodes
        .iter()
        .map(|n| n.mesh.area() * volume_scale(n).cbrt().powi(2))
        .sum();
    let prepared = prepare(scene, &request.place, &request.stem, &stem)?;
    let species = request.recipe.species()?;
    let mut notes = Vec::new();
    let (relief, species_report) = relief(&prepared, &request.recipe, species, &mut notes)?;
    let prepared = prepared.wound(p, relief);
    repairs.extend(prepared.found.notes.iter().cloned());
    if prepared.parted > 0 {
        repairs.push(format!(
            "{} triangles near the break were parted because the stem is bent there",
            prepared.parted
        ));
    }
    let node = &prepared.scene.nodes[prepared.found.node];
    let known = Places::of(&node.mesh);
    let shell = part_of(&node.mesh, prepared.found.shell.iter().map(|&t| t as usize));
    let (closed, volume) = closed_volume(&shell);
    let input = InputReport {
        meshes: prepared.scene.nodes.len(),
        triangles,
        area_m2: area,
        volume_m3: volume.map(|v| v * volume_scale(node)),
        closed,
        repairs,
    };
    cut.report(0.0)?;
    let material = prepared.scene.materials.len() as u32 + u32::from(lacks_material(&shell));
    let mut cracks = Cracks::plan(&request.recipe, &mut notes)?;
    let prepared = match &mut cracks {
        Some(cracks) if cracks.sawn => cracks.open_end(prepared, p, material, &cut)?,
        _ => prepared,
    };
    let stem = &prepared.found.stem;
    let model = prepared.model(p, relief, material)?;
    if model.heights.limited > 0 {
        notes.push(format!(
            "{} of the face's corners were limited: the break would have reached from {:.1} to {:.1} mm, but only \
             {:.1} to {:.1} mm along the stem are free",
            model.heights.limited,
            model.heights.wanted.0 * 1e3,
            model.heights.wanted.1 * 1e3,
            (stem.usable.0 - stem.location) * 1e3,
            (stem.usable.1 - stem.location) * 1e3
        ));
    }
    if model.chips > 0 {
        notes.push(format!(
            "{} slivers that would have hung in the air stay with the other piece",
            model.chips
        ));
    }
    notes.extend(model.wound.and_then(|w| wound_note(&w, &prepared)));
    let looks = looks(stem, p, species, prepared.extent.bark);
    let mut model = model;
    if let Some(cracks) = cracks.as_mut().filter(|c| !c.sawn) {
        cracks.open_break(&prepared, &mut model, p, material)?;
    }
    let splinters = frayed(&prepared, &mut model, request, material, &mut notes)?;
    if request.fray > 0.0 && splinters.is_empty() {
        notes.push(
            "no splinter came loose: no fibre bundle away from the skin stands long enough alone"
                .into(),
        );
    }
    if p.spiral_angle != 0.0 && (p.surface == Surface::Smooth || stem.kind == StemKind::Board) {
        notes.push(
            "the spiral angle was left out: grain winds in the fibrous face of a round stem only"
                .into(),
        );
    }
    let (turn, hang) = prepared.hang(&model, p).unzip();
    if let Some(h) = hang.as_ref().filter(|h| h.angle_degrees > p.hang) {
        notes.push(format!(
            "the upper piece hangs at {:.1}° instead of {:.1}°, the least at which it is clear of the lower one",
            h.angle_degrees, p.hang
        ));
    }
    let along = prepared
        .found
        .stem
        .grain
        .axis()
        .frame(prepared.found.stem.location)
        .tangent;
    let moved = DAffine3::from_translation(along * request.part) * turn.unwrap_or_default();
    let mut out = assemble(&prepared, &model, splinters, moved);
    let ours = pieces_in(&out);
    out.nodes[..ours]
        .iter_mut()
        .for_each(|n| settle(n.mesh_mut(), material));
    for node in &mut out.nodes[..ours] {
        notes.extend(untangled(node, &known));
    }
    textures.report(0.0)?;
    add_inner_material(
        &mut out,
        &prepared,
        &model,
        &looks,
        request.texture_width,
        &textures,
    )?;
    let pieces = out
        .nodes
        .iter()
        .take(ours)
        .map(|n| PieceReport::of(&n.name, &n.mesh, volume_scale(n)))
        .collect();
    let hinge = hang.as_ref().map(|h| DVec3::from_array(h.axis));
    let report = BreakReport {
        scan: None,
        input,
        place: place_report(&prepared),
        face: face_report(p, &model),
        species: species_report,
        pieces,
        hang,
        crack_volume_m3: cracks.as_ref().map(|c| c.volume),
        notes: notes
            .into_iter()
            .chain(cracks.iter().flat_map(Cracks::notes))
            .collect(),
    };
    Ok(Broken {
        scene: out,
        report,
        stem: stem.clone(),
        looks,
        inner_material: material,
        width: model.square.1,
        apart: request.part != 0.0 || p.hang > 0.0,
        hinge,
        end: cracks.and_then(|c| c.end),
    })
}

/// Takes out what crosses itself in a piece at the precision of files; what was done, where there was anything.
fn untangled(node: &mut Node, known: &Places) -> Option<String> {
    let done = untangle(node.mesh_mut(), known);
    let longest = done.longest * volume_scale(node).cbrt() * 1e6;
    (done.crossed > 0).then(|| {
        let mut note = format!(
            "{}: {} pairs of triangles crossed or met where the wood is too thin for a file's precision; {} \
             edges of at most {longest:.2} µm were drawn together",
            node.name, done.crossed, done.drawn
        );
        if done.left > 0 {
            note += &format!(", {} pairs are left", done.left);
        }
        note
    })
}

/// What was done to a face of winding grain, where anything crossed.
fn wound_note(wound: &Wound, prepared: &Prepared) -> Option<String> {
    let node = &prepared.scene.nodes[prepared.found.node];
    let longest = wound.longest * volume_scale(node).cbrt() * 1e6;
    (wound.crossed > 0).then(|| {
        let mut note = format!(
            "{} pairs of triangles of the winding face crossed; {} edges were halved and {} of at most {longest:.0} µm \
             drawn together",
            wound.crossed, wound.halved, wound.drawn
        );
        if wound.left > 0 {
            note += &format!(", {} pairs still cross", wound.left);
        }
        note
    })
}

/// How a piece was bent.
fn bend_note(name: &str, bent: &Bent, asked: f64) -> String {
    let mut note = format!(
        "{name}: bending changed the volume by {:+.3} %",
        bent.change * 100.0
    );
    if bent.crossed > 0 {
        note += &format!(
            "; {} pairs of triangles crossed when bent, and {} edges were halved",
            bent.crossed, bent.halved
        );
    }
    if bent.amount < asked {
        note += &format!(
            "; it was bent by {:.2} instead of {asked:.2}, as more would have made it cross itself",
            bent.amount
        );
    }
    if bent.left > 0 {
        note += &format!("; {} pairs still cross", bent.left);
    }
    note
}

/// Frays the pieces of `model` where that is asked for; gives the splinters that came loose.
fn frayed(
    prepared: &Prepared,
    model: &mut Model,
    request: &BreakRequest,
    material: u32,
    notes: &mut Vec<String>,
) -> Result<Vec<(Mesh, DAffine3)>, Error> {
    if request.fray <= 0.0 {
        return Ok(Vec::new());
    }
    let options = FrayOptions {
        amount: request.fray.min(1.0),
        part: request.part,
        material,
    };
    let made = fray(prepared, model, &request.recipe.face, &options)?;
    (model.lower, model.upper) = (made.lower, made.upper);
    for (name, bent) in ["lower", "upper"].into_iter().zip(&made.bent) {
        notes.push(bend_note(name, bent, options.amount));
    }
    Ok(made.splinters)
}

/// How many of the first nodes are pieces of the stem.
fn pieces_in(scene: &Scene) -> usize {
    let ours =
        |n: &&Node| n.name == "lower" || n.name == "upper" || n.name.starts_with("splinter_");
    scene.nodes.iter().take_while(ours).count()
}

/// Cubic metres per cubic unit of a node's coordinates.
pub(crate) fn volume_scale(node: &Node) -> f64 {
    node.transform.matrix3.determinant().abs()
}

fn place_report(prepared: &Prepared) -> PlaceReport {
    let stem = &prepared.found.stem;
    PlaceReport {
        mesh: prepared.scene.nodes[prepared.found.node].name.clone(),
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

fn face_report(p: &BreakParameters, model: &Model) -> FaceReport {
    FaceReport {
        surface: match p.surface {
            Surface::Smooth => "smooth".into(),
            Surface::Fibrous => "fibrous".into(),
        },
        bundles: model.bundles.bundles.len(),
        thorns: model.heights.thorns.len(),
        range_m: [model.heights.range.0, model.heights.range.1],
        limited: model.heights.limited,
        wanted_m: [model.heights.wanted.0, model.heights.wanted.1],
    }
}

/// Median over the Wood Handbook's species of the shear-lag length over the bundle's width: the wood that the relief
/// of the parameters stands for.
const TYPICAL_SLENDERNESS: f64 = 2.87;

/// Factor on the relief that the species calls for.
fn relief(
    prepared: &Prepared,
    recipe: &Recipe,
    species: Option<&Species>,
    notes: &mut Vec<String>,
) -> Result<(f64, Option<SpeciesReport>), Error> {
    let Some(species) = species else {
        return Ok((1.0, None));
    };
    let radius = prepared.found.stem.radius;
    let moisture = recipe.moisture.unwrap_or(AIR_DRY_PERCENT);
    let height = match species.fracture_height(
        radius,
        DEFAULT_BUNDLE_DIAMETER,
        moisture,
        Fallback::TwelvePercent,
    ) {
        Ok(height) => height,
        Err(error) => {
            notes.push(format!(
                "the height of the face does not follow the species: {error}"
            ));
            return Ok((1.0, None));
        }
    };
    let relief = match height.rule {
        HeightRule::Eq9 => height.ratio * radius / prepared.relief_range(&recipe.face).max(1e-9),
        HeightRule::ShearLag => {
            height.ratio * radius / DEFAULT_BUNDLE_DIAMETER / TYPICAL_SLENDERNESS
        }
    };
    let report = SpeciesReport {
        name: species.name.clone(),
        scientific_name: species.scientific_name.clone(),
        moisture_percent: moisture,
        rule: height.rule.to_string(),
        basis: height.basis.to_string(),
        height_m: height.ratio * radius,
        relief,
    };
    Ok((relief, Some(report)))
}

/// The triangles `which` of a mesh with the vertices they use, in their order.
pub(crate) fn part_of(mesh: &Mesh, which: impl Iterator<Item = usize>) -> Mesh {
    let mut new = vec![u32::MAX; mesh.positions.len()];
    let mut kept = Vec::new();
    let mut part = Mesh::default();
    for t in which {
        let corners = mesh.triangles[t].map(|v| {
            if new[v as usize] == u32::MAX {
                new[v as usize] = kept.len() as u32;
                kept.push(v as usize);
            }
            new[v as usize]
        });
        part.triangles.push(corners);
        if !mesh.materials.is_empty() {
            part.materials.push(mesh.materials[t]);
        }
    }
    part.positions = kept.iter().map(|&v| mesh.positions[v]).collect();
    for (name, attribute) in &mesh.attributes {
        let data = kept
            .iter()
            .flat_map(|&v| attribute.at(v).iter().copied())
            .collect();
        let attribute = greenstick_geometry::Attribute {
            width: attribute.width,
            data,
        };
        part.attributes.insert(name.clone(), attribute);
    }
    part
}

/// The scene of the pieces and of everything that was not cut.
fn assemble(
    prepared: &Prepared,
    model: &Model,
    splinters: Vec<(Mesh, DAffine3)>,
    moved: DAffine3,
) -> Scene {
    let (scene, found) = (&prepared.scene, &prepared.found);
    let cut = &scene.nodes[found.node];
    let mut out = Scene {
        nodes: Vec::new(),
        materials: scene.materials.clone(),
        textures: scene.textures.clone(),
        images: scene.images.clone(),
        notes: Vec::new(),
    };
    let node = |name: &str, transform, mesh: Mesh| Node::new(name, transform, mesh);
    out.nodes
        .push(node("lower", cut.transform, model.lower.clone()));
    out.nodes
        .push(node("upper", moved * cut.transform, model.upper.clone()));
    for (i, (mesh, thrown)) in splinters.into_iter().enumerate() {
        let name = format!("splinter_{i:03}");
        out.nodes.push(node(&name, thrown * cut.transform, mesh));
    }
    let mut gone: Vec<Vec<bool>> = scene
        .nodes
        .iter()
        .map(|n| vec![false; n.mesh.triangles.len()])
        .collect();
    for &t in &found.shell {
        gone[found.node][t as usize] = true;
    }
    for (n, shell) in found.carried.iter().enumerate() {
        for &t in &shell.triangles {
            gone[shell.node][t as usize] = true;
        }
        let source = &scene.nodes[shell.node];
        let mesh = part_of(&source.mesh, shell.triangles.iter().map(|&t| t as usize));
        let name = format!("{}_with_upper_{n:03}", source.name);
        out.nodes.push(Node {
            parent: Some(1),
            ..node(&name, moved * source.transform, mesh)
        });
    }
    for (i, source) in scene.nodes.iter().enumerate() {
        if gone[i].iter().all(|g| !g) {
            out.nodes.push(Node {
                parent: None,
                ..source.clone()
            });
        } else if gone[i].iter().any(|g| !g) {
            let rest = (0..source.mesh.triangles.len()).filter(|&t| !gone[i][t]);
            out.nodes.push(node(
                &source.name,
                source.transform,
                part_of(&source.mesh, rest),
            ));
        }
    }
    out
}

/// Adds the material of the wood inside with its textures, and one of bark where the mesh had none.
fn add_inner_material(
    out: &mut Scene,
    prepared: &Prepared,
    model: &Model,
    looks: &Looks,
    width: u32,
    context: &Context,
) -> Result<(), Error> {
    if out.nodes.iter().any(|n| lacks_material(&n.mesh)) {
        let bark = out.materials.len() as u32;
        out.materials.push(bark_material());
        out.change_meshes(lacks_material, |mesh| {
            mesh.materials.resize(mesh.triangles.len(), NO_MATERIAL);
            let lacking = mesh.materials.iter_mut().filter(|m| **m == NO_MATERIAL);
            lacking.for_each(|m| *m = bark);
        });
    }
    inner_wood(
        out,
        &prepared.found.stem,
        model.square,
        looks,
        width,
        context,
    )
}

/// Adds the material of the wood inside, with textures `width` pixels wide of the square of the section with this middle
/// and side (m).
pub(crate) fn inner_wood(
    out: &mut Scene,
    stem: &Stem,
    (middle, side): (DVec2, f64),
    looks: &Looks,
    width: u32,
    context: &Context,
) -> Result<(), Error> {
    let section = |p: DVec2| stem.rings.address(p + middle);
    let baked = texture::bake(width, side, &section, &looks.wood, context)?;
    let mut reference = |name: &str, bytes: Vec<u8>| {
        let image = Image {
            name: format!("inner_wood_{name}"),
            mime_type: "image/png".into(),
            source: ImageSource::Bytes(bytes),
        };
        out.images.push(image);
        // Linear filtering with mipmaps; clamped across, repeating along the grain.
        let sampler = [Some(9729), Some(9987), Some(33071), Some(10497)];
        out.textures.push(Texture {
            image: Some(out.images.len() - 1),
            alternatives: Vec::new(),
            sampler,
        });
        let scale = [(0.5 / side) as f32, (1.0 / side) as f32];
        TextureReference {
            texture: out.textures.len() - 1,
            coordinates: 0,
            transform: Some(([0.0, 0.0], 0.0, scale)),
            strength: 1.0,
        }
    };
    let (color, normal, roughness) = (
        reference("color", baked.color),
        reference("normal", baked.normal),
        reference("roughness", baked.roughness),
    );
    out.materials.push(Material {
        name: "inner_wood".into(),
        base_color_texture: Some(color),
        normal_texture: Some(normal),
        metallic_roughness_texture: Some(roughness),
        ..Material::default()
    });
    Ok(())
}
