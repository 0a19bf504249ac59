//! Pictures of broken stems and of any scene.

use crate::session::{Broken, BrokenWood, NodeRole, PieceRole};
use glam::{DVec2, DVec3};
use greenstick_geometry::{Context, Node, Scene};
use greenstick_picture::{
    Appearance, Hit, Picture, PictureError, PictureOptions, PlainShader, Shader, Sphere, View,
    azimuth_of_view, render_scene,
};
use greenstick_skin::WoodField;
use greenstick_skin::broken::{BreakView, ViewedPiece};
use greenstick_wood::appearance::{StemAppearance, SurfacePoint};
use greenstick_wood::branch::BARK_MATERIAL_NAME;
use greenstick_wood::stem::Stem;
use std::sync::Arc;

/// Shades the wood inside by its address at the pixel, and the skin as bark unless its material has a colour.
struct StemShader<'a> {
    /// The wood inside, by material; bark and sawn ends are those of the first.
    woods: Vec<Inside<'a>>,
    plain: PlainShader,
    /// Whether each material has no colour to show: none at all, or only a texture.
    blank: Vec<bool>,
    /// Whether the wood has moved since it grew, so that the stem's frames no longer give directions.
    moved: bool,
    /// The field that is shown in place of the wood.
    field: Option<WoodField>,
}

/// Returns the field that a scene's nodes hold.
fn field_of(scene: &Scene) -> Option<WoodField> {
    let holds = |field: &WoodField| {
        let name = field.attribute();
        (scene.nodes.iter()).any(|node| node.mesh.attributes.contains_key(name))
    };
    [WoodField::Strain, WoodField::Damage]
        .into_iter()
        .find(holds)
}

/// Roughness of what shows a field.
const FIELD_ROUGHNESS: f64 = 0.9;
/// Colours of a field, linear: strain from crushing by none to tearing, damage from whole to broken.
const CRUSHED: DVec3 = DVec3::new(0.03, 0.13, 0.55);
const UNLOADED: DVec3 = DVec3::new(0.75, 0.73, 0.68);
const TORN: DVec3 = DVec3::new(0.62, 0.03, 0.02);

fn field_color(field: WoodField, value: f64) -> [f64; 3] {
    let end = match field {
        WoodField::Strain if value < 0.0 => CRUSHED,
        _ => TORN,
    };
    UNLOADED.lerp(end, value.abs().min(1.0)).to_array()
}

/// The wood inside a stem.
#[derive(Clone, Copy)]
struct Inside<'a> {
    material: u32,
    stem: &'a Stem,
    appearance: &'a StemAppearance,
}

impl<'a> Inside<'a> {
    fn new(wood: &'a BrokenWood) -> Self {
        Inside {
            material: wood.material,
            stem: &wood.stem,
            appearance: &wood.appearance,
        }
    }
}

impl StemShader<'_> {
    /// Returns the wood whose bark and sawn ends are shown.
    fn own(&self) -> Inside<'_> {
        self.woods[0]
    }

    /// The point of the stem that a ray meets.
    fn point(&self, hit: &Hit) -> SurfacePoint {
        let grain = hit.attribute("_GRAIN");
        SurfacePoint {
            position: hit.position,
            normal: hit.normal,
            geometric_normal: hit.geometric_normal,
            grain: grain
                .map(|g| DVec3::new(g[0], g[1], g[2]))
                .filter(|g| *g != DVec3::ZERO),
            moved: self.moved,
            grain_gradients: self.moved.then(|| hit.gradients("_GRAIN")).flatten(),
            footprint: hit.footprint,
        }
    }
}

impl Shader for StemShader<'_> {
    fn shade(&self, hit: &Hit) -> Appearance {
        if let Some(field) = self.field
            && let Some(value) = hit.attribute(field.attribute())
        {
            return Appearance {
                color: field_color(field, value[0]),
                roughness: FIELD_ROUGHNESS,
                normal: hit.normal,
            };
        }
        let point = self.point(hit);
        let material = hit.material();
        let inside = self.woods.iter().find(|w| w.material == material);
        let oriented = match (point.grain, inside) {
            (Some(grain), Some(inside)) => inside.appearance.wood_at(inside.stem, grain, &point),
            _ if !self.blank.get(material as usize).copied().unwrap_or(true) => {
                return self.plain.shade(hit);
            }
            _ => self.own().appearance.skin_at(self.own().stem, &point),
        };
        Appearance {
            color: oriented.surface.color,
            roughness: oriented.surface.roughness,
            normal: hit.bumped_normal(oriented.relief_gradient()),
        }
    }
}

/// Returns for each material whether it has no colour to show: our own bark, materials without a colour, and those whose
/// colour is in a texture.
fn blank(scene: &Scene) -> Vec<bool> {
    let blank = |m: &greenstick_geometry::Material| {
        m.name == BARK_MATERIAL_NAME
            || m.base_color_texture.is_some()
            || m.base_color[..3] == [1.0; 3]
    };
    scene.materials.iter().map(blank).collect()
}

/// Pieces of less than this share of the wood are splinters, which may fly far: a picture need not show them.
const SPLINTER_SHARE: f64 = 0.01;

fn is_wood(node: &Node) -> bool {
    node.mesh.attributes.contains_key("_GRAIN")
}

/// Returns the points (m) that a picture of wood in pieces shows: all but those of splinters.
fn points_without_splinters(scene: &Scene) -> Vec<DVec3> {
    let wood = scene.nodes.iter().filter(|n| is_wood(n));
    let whole: f64 = wood.map(|n| n.mesh.volume()).sum();
    let is_shown = |node: &&Node| !is_wood(node) || node.mesh.volume() >= SPLINTER_SHARE * whole;
    let points = |node: &Node| {
        let transform = node.transform;
        let positions = node.mesh.positions.clone();
        positions
            .into_iter()
            .map(move |p| transform.transform_point3(p))
    };
    let shown = scene.nodes.iter().filter(is_shown);
    shown.flat_map(points).collect()
}

/// Returns what a close-up of `diameters` diameters of a stem shows: a sphere about the faces of the wood inside, whose materials are
/// `inner`. Splinters do not count; there is none of wood without such faces.
pub fn close_up(scene: &Scene, inner: &[u32], diameters: f64) -> Option<Sphere> {
    let wood = scene.nodes.iter().filter(|node| is_wood(node));
    let whole: f64 = wood.clone().map(|n| n.mesh.volume()).sum();
    let (mut sum, mut area) = (DVec3::ZERO, 0.0);
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for node in wood.filter(|n| n.mesh.volume() >= SPLINTER_SHARE * whole) {
        let mesh = &node.mesh;
        let grain = mesh.attributes.get("_GRAIN")?;
        for t in (0..mesh.triangles.len()).filter(|&t| inner.contains(&mesh.material(t))) {
            let [a, b, c] = mesh.corners(t).map(|p| node.transform.transform_point3(p));
            let own = (b - a).cross(c - a).length();
            sum += (a + b + c) * (own / 3.0);
            area += own;
            for corner in mesh.triangles[t] {
                let at = corner as usize * grain.width;
                let point = DVec2::new(grain.data[at].into(), grain.data[at + 1].into());
                (low, high) = (low.min(point), high.max(point));
            }
        }
    }
    let sides = high - low;
    let radius = 0.5 * diameters * (sides.x * sides.y).sqrt();
    (area > 0.0 && radius > 0.0).then(|| Sphere {
        centre: sum / area,
        radius,
    })
}

/// Renders wood that has moved since it grew. Splinters do not make the picture wider. `inner` is the material of the wood
/// inside, whose address is an attribute of the meshes.
///
/// # Errors
/// As [`render_scene`].
pub fn picture_of_skin(
    scene: &Scene,
    stem: &Stem,
    appearance: &StemAppearance,
    inner: u32,
    options: &PictureOptions,
    context: &Context,
) -> Result<Picture, PictureError> {
    let inside = Inside {
        material: inner,
        stem,
        appearance,
    };
    picture_of_moved_wood(scene, vec![inside], options, context)
}

/// Renders the pieces of breaks that have moved since the wood grew, whose wood inside each break is `woods`. Splinters do not
/// make the picture wider.
///
/// # Errors
/// As [`render_scene`].
pub fn picture_of_moved_break(
    scene: &Scene,
    woods: &[BrokenWood],
    options: &PictureOptions,
    context: &Context,
) -> Result<Picture, PictureError> {
    let woods = woods.iter().map(Inside::new).collect();
    picture_of_moved_wood(scene, woods, options, context)
}

fn picture_of_moved_wood(
    scene: &Scene,
    woods: Vec<Inside>,
    options: &PictureOptions,
    context: &Context,
) -> Result<Picture, PictureError> {
    let inner: Vec<u32> = woods.iter().map(|wood| wood.material).collect();
    let shader = StemShader {
        woods,
        plain: PlainShader::from_materials(&scene.materials),
        blank: blank(scene),
        moved: true,
        field: field_of(scene),
    };
    let mut options = options.clone();
    if let (None, Some(diameters)) = (options.zoom, options.close_up) {
        options.zoom = close_up(scene, &inner, diameters);
    }
    if options.zoom.is_some() || !options.shown.is_empty() {
        return render_scene(scene, &shader, &options, context);
    }
    options.shown = points_without_splinters(scene);
    render_scene(scene, &shader, &options, context)
}

/// Renders a broken stem, seen towards the break unless `options` name a view.
///
/// # Errors
/// As [`render_scene`].
pub fn picture_of_break(
    broken: &Broken,
    options: &PictureOptions,
    context: &Context,
) -> Result<Picture, PictureError> {
    let shader = StemShader {
        woods: broken.woods.iter().map(Inside::new).collect(),
        plain: PlainShader::from_materials(&broken.scene.materials),
        blank: blank(&broken.scene),
        moved: false,
        field: None,
    };
    // Only a stem with one break is opened for its picture.
    let [wood] = &broken.woods[..] else {
        let mut options = options.clone();
        if let (None, Some(diameters), Some(first)) =
            (options.zoom, options.close_up, broken.woods.first())
        {
            options.zoom = close_up(&broken.scene, &[first.material], diameters);
        }
        return render_scene(&broken.scene, &shader, &options, context);
    };
    let opened = opened(broken, wood);
    let scene = if broken.apart || broken.end.is_some() {
        &broken.scene
    } else {
        &opened
    };
    let mut options = options.clone();
    if let (None, Some(diameters), None) = (options.zoom, options.close_up, broken.end) {
        aim(broken, wood, scene, &mut options);
        options.zoom = close_up(scene, &[wood.material], diameters);
    } else if let (Some(end), None) = (broken.end, options.zoom) {
        // Cracks in a sawn end: that end, from above.
        options.zoom = Some(Sphere {
            centre: end.middle - end.outward * (0.2 * end.radius),
            radius: 1.5 * end.radius,
        });
        (options.up, options.floor) = (end.outward, false);
        if options.view == View::Automatic {
            options.view = View::Direction {
                azimuth: 0.6,
                elevation: 0.95,
            };
        }
    } else if options.zoom.is_none() && options.shown.is_empty() {
        aim(broken, wood, scene, &mut options);
    }
    render_scene(scene, &shader, &options, context)
}

/// How steeply an opened break is looked down on, rad.
const ELEVATION: f64 = 0.5;
/// Elevation of the camera over a break that hangs open, and its turn from the side, rad.
const HANGING_ELEVATION: f64 = 0.22;
const HANGING_TURN: f64 = 0.45;
/// A break as a picture shows it.
fn view<'a>(broken: &Broken, wood: &'a BrokenWood) -> BreakView<'a> {
    BreakView {
        stem: &wood.stem,
        material: wood.material,
        range: broken.report.face.range_m,
        width: wood.width,
    }
}

/// Aims the camera at both faces and a stub of stem behind each.
fn aim(broken: &Broken, wood: &BrokenWood, scene: &Scene, options: &mut PictureOptions) {
    let lower = NodeRole::Piece(PieceRole::Lower);
    let Some(at) = broken.roles.iter().position(|&role| role == lower) else {
        return;
    };
    let nodes = scene.nodes.iter().zip(&broken.roles);
    let pieces = nodes.filter_map(|(node, role)| match role {
        NodeRole::Piece(role) => Some(ViewedPiece {
            node,
            is_upper: *role == PieceRole::Upper,
            is_splinter: matches!(role, PieceRole::Splinter(_)),
        }),
        NodeRole::Carried | NodeRole::Untouched => None,
    });
    let (view, at_rest) = (view(broken, wood), &broken.scene.nodes[at].transform);
    options.shown = view.points(pieces, at_rest);
    let frame = view.frame();
    let (up, view) = match broken.hinge {
        None if broken.apart => return,
        // Both faces look up, seen along the frame's y: they stand next to each other along its x, which runs to the right.
        None => (
            frame.tangent,
            (azimuth_of_view(frame.tangent, frame.y), ELEVATION),
        ),
        // Nearly along the hinge, from the side that opened.
        Some(axis) => {
            let opened = axis.cross(frame.tangent) * -1.0;
            let (sin, cos) = libm::sincos(HANGING_TURN);
            let back = axis * cos + opened * sin;
            let azimuth = azimuth_of_view(frame.tangent, -back);
            (frame.tangent, (azimuth, HANGING_ELEVATION))
        }
    };
    (options.up, options.floor) = (up, false);
    if options.view == View::Automatic {
        let (azimuth, elevation) = view;
        options.view = View::Direction { azimuth, elevation };
    }
}

/// The scene with the upper piece turned over and set beside the lower, both faces up.
fn opened(broken: &Broken, wood: &BrokenWood) -> Scene {
    let about = view(broken, wood).opened();
    let mut scene = broken.scene.clone();
    for (node, role) in scene.nodes.iter_mut().zip(&broken.roles) {
        match role {
            NodeRole::Piece(PieceRole::Upper) | NodeRole::Carried => {
                node.transform = about * node.transform;
            }
            NodeRole::Piece(_) => {}
            // It would hide the faces.
            NodeRole::Untouched => node.mesh = Arc::default(),
        }
    }
    scene
}

/// Renders any scene in the plain colours of its materials.
///
/// # Errors
/// As [`render_scene`].
pub fn picture_of_scene(
    scene: &Scene,
    options: &PictureOptions,
    context: &Context,
) -> Result<Picture, PictureError> {
    let shader = PlainShader::from_materials(&scene.materials);
    render_scene(scene, &shader, options, context)
}
