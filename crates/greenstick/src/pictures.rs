//! Pictures of broken stems and of any scene.

use crate::session::{Broken, BrokenWood, NodeRole, PieceRole};
use glam::{DAffine3, DVec2, DVec3};
use greenstick_geometry::{Context, Scene};
use greenstick_picture::{
    Appearance, Hit, Horizontal, Item, Picture, PictureError, PictureOptions, PlainShader, Shader,
    Sphere, View, render,
};
use greenstick_wood::appearance::{BarkPoint, StemAppearance, WoodPoint, WoodSurface};
use greenstick_wood::branch::BARK_MATERIAL_NAME;
use greenstick_wood::rings::StemAddress;
use greenstick_wood::stem::{Frame, Stem, StemKind};
use std::sync::Arc;

/// Shades the wood inside by its address at the pixel, and the skin as bark where nothing better is known.
struct StemShader<'a> {
    /// The wood inside, by material; bark and sawn ends are those of the first.
    woods: Vec<Inside<'a>>,
    plain: PlainShader,
    /// For each material whether it says nothing of the colour: no colour of its own, or only a texture.
    blank: Vec<bool>,
    /// Whether the wood has moved since it grew, so that the stem's frames say nothing of directions.
    moved: bool,
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
    /// The wood whose bark and sawn ends are shown.
    fn own(&self) -> Inside<'_> {
        self.woods[0]
    }

    fn wood(&self, inside: Inside, hit: &Hit, grain: DVec3) -> Appearance {
        let frame = inside.stem.grain.axis().frame(grain.z);
        let (ring, angle) = inside.stem.rings.address(grain.truncate());
        let (directions, end_grain) = match self.moved.then(|| hit.gradients("_GRAIN")).flatten() {
            // A length along the grain that does not change along a face means that the face lies across it.
            Some(rise) => (rise, (1.0 - rise[2].length_squared()).max(0.0).sqrt()),
            None => (
                [frame.x, frame.y, frame.tangent],
                hit.geometric_normal.dot(frame.tangent).abs(),
            ),
        };
        let point = WoodPoint {
            address: StemAddress {
                rho: ring,
                angle,
                across: grain.truncate() - inside.stem.rings.pith(),
                along: grain.z,
            },
            end_grain,
        };
        let surface = inside.appearance.wood.surface_at(&point, hit.footprint);
        finish(hit, &surface, directions)
    }

    fn is_sawn(&self, hit: &Hit, grain: DVec3) -> bool {
        let stem = self.own().stem;
        let along = stem.grain.axis().frame(grain.z).tangent;
        let end = !self.moved && hit.geometric_normal.dot(along).abs() > SAWN;
        stem.kind == StemKind::Board || end
    }

    fn bark(&self, hit: &Hit, grain: Option<DVec3>) -> Appearance {
        let Inside {
            stem, appearance, ..
        } = self.own();
        let (point, directions) = match grain {
            Some(grain) => {
                let frame = stem.grain.axis().frame(grain.z);
                let across: DVec2 = grain.truncate() - stem.rings.pith();
                let angle = libm::atan2(across.y, across.x);
                let point = BarkPoint {
                    angle,
                    along: grain.z,
                    radius: across.length(),
                };
                let moved = self.moved.then(|| hit.gradients("_GRAIN")).flatten();
                (point, moved.unwrap_or([frame.x, frame.y, frame.tangent]))
            }
            None => {
                // Off the limb: the world's own axes, as far as the bark's look goes as good as any.
                let p = hit.position;
                let angle = libm::atan2(hit.normal.z, hit.normal.x);
                let point = BarkPoint {
                    angle,
                    along: p.y,
                    radius: stem.radius,
                };
                (point, [DVec3::X, DVec3::Z, DVec3::Y])
            }
        };
        let surface = appearance.bark.surface_at(&point, hit.footprint);
        finish(hit, &surface, directions)
    }
}

fn finish(hit: &Hit, surface: &WoodSurface, [x, y, along]: [DVec3; 3]) -> Appearance {
    let rise = x * surface.slope.x + y * surface.slope.y + along * surface.slope.z;
    Appearance {
        color: surface.color,
        roughness: surface.roughness,
        normal: hit.bumped_normal(rise),
    }
}

impl Shader for StemShader<'_> {
    fn shade(&self, hit: &Hit) -> Appearance {
        let grain = hit
            .attribute("_GRAIN")
            .map(|g| DVec3::new(g[0], g[1], g[2]))
            .filter(|g| *g != DVec3::ZERO);
        let material = hit.material();
        let inside = self.woods.iter().find(|w| w.material == material);
        match (grain, inside) {
            (Some(grain), Some(inside)) => self.wood(*inside, hit, grain),
            (grain, _) => {
                if !self.blank.get(material as usize).copied().unwrap_or(true) {
                    return self.plain.shade(hit);
                }
                match grain {
                    // A board's skin is sawn wood, and so are the ends of a stem.
                    Some(grain) if self.is_sawn(hit, grain) => self.wood(self.own(), hit, grain),
                    grain => self.bark(hit, grain),
                }
            }
        }
    }
}

/// Materials that say nothing of the colour: ours, those without a colour, and those whose colour is in a texture.
fn blank(scene: &Scene) -> Vec<bool> {
    let blank = |m: &greenstick_geometry::Material| {
        m.name == BARK_MATERIAL_NAME
            || m.base_color_texture.is_some()
            || m.base_color[..3] == [1.0; 3]
    };
    scene.materials.iter().map(blank).collect()
}

/// A picture of wood that has moved since it grew: `inner` is the material of the wood inside, whose address its meshes
/// carry.
///
/// # Errors
/// As [`render`].
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
    let shader = StemShader {
        woods: vec![inside],
        plain: PlainShader::from_materials(&scene.materials),
        blank: blank(scene),
        moved: true,
    };
    render(&items(scene, &shader), options, context)
}

/// A picture of a broken stem, turned to the break unless `options` say otherwise.
///
/// # Errors
/// As [`render`].
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
    };
    // Only a stem that is broken once is opened for its picture.
    let [wood] = &broken.woods[..] else {
        return render(&items(&broken.scene, &shader), options, context);
    };
    let opened = opened(broken, wood);
    let scene = if broken.apart || broken.end.is_some() {
        &broken.scene
    } else {
        &opened
    };
    let mut options = options.clone();
    if let (Some(end), None) = (broken.end, options.zoom) {
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
    render(&items(scene, &shader), &options, context)
}

/// Cosine of the angle to the grain within which a face of the skin is a sawn end.
const SAWN: f64 = 0.9;

/// How steeply an opened break is looked down on, rad.
const ELEVATION: f64 = 0.5;
/// The same for a break that hangs open, and how far it is turned from its side, rad.
const HANGING_ELEVATION: f64 = 0.22;
const HANGING_TURN: f64 = 0.45;
/// Length of stem that is shown behind each face: radii, and part of the face's height.
const STUB: (f64, f64) = (0.9, 0.08);
/// Ring coordinate from which on the face is near the skin: how far down there it reaches can be seen.
const OUTER: f64 = 0.85;
/// Part of the face near the skin that lies higher than the stub's beginning.
const MOST_OF_IT: f64 = 0.85;

/// Points the camera at the whole of both faces and a stub of stem behind each.
fn aim(broken: &Broken, wood: &BrokenWood, scene: &Scene, options: &mut PictureOptions) {
    let stem = &wood.stem;
    let frame = stem.grain.axis().frame(stem.location);
    let [low, high] = broken.report.face.range_m;
    let stub = STUB.0 * stem.radius + STUB.1 * (high - low);
    let lower = NodeRole::Piece(PieceRole::Lower);
    let Some(at) = broken.roles.iter().position(|&role| role == lower) else {
        return;
    };
    let rest = &broken.scene.nodes[at];
    let (along, origin) = (frame.tangent, frame.origin);
    let reach = 0.5 * wood.width;
    let mut shown = Vec::new();
    for (node, role) in scene.nodes.iter().zip(&broken.roles) {
        let NodeRole::Piece(role) = role else {
            continue;
        };
        let upper = *role == PieceRole::Upper;
        let rings = node.mesh.attributes.get("_RING");
        let face = (node.mesh.triangles.iter().enumerate())
            .filter(|(t, _)| node.mesh.materials.get(*t) == Some(&wood.material))
            .flat_map(|(_, corners)| corners.map(|v| v as usize));
        // How far down the outside the break can be seen, m from the place of the break.
        let mut ends = vec![0.0];
        for v in face {
            let Some(&at) = node.mesh.positions.get(v) else {
                continue;
            };
            let height = (rest.transform.transform_point3(at) - origin).dot(along);
            let stands = if upper { -height } else { height };
            let outer = rings.is_none_or(|r| f64::from(r.at(v)[0]) > OUTER);
            if outer {
                ends.push(-stands);
            }
            if stands > 0.0 {
                shown.push(node.transform.transform_point3(at));
            }
        }
        if matches!(role, PieceRole::Splinter(_)) {
            continue;
        }
        // The stem runs on behind the face: its section once more. Pieces have one transform at rest.
        let moved = node.transform * rest.transform.inverse();
        ends.sort_unstable_by(f64::total_cmp);
        let end = ends[(MOST_OF_IT * (ends.len() - 1) as f64) as usize].max(0.0) + stub;
        let end = if upper { end } else { -end };
        let at = stem.grain.axis().frame(stem.location + end);
        shown.extend(
            [DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y]
                .map(|p| moved.transform_point3(at.origin + (at.x * p.x + at.y * p.y) * reach)),
        );
    }
    options.shown = shown;
    let (up, view) = match broken.hinge {
        None if broken.apart => return,
        // Both faces look up, seen from the side on which they stand next to each other.
        None => (frame.tangent, (azimuth(&frame), ELEVATION)),
        // Nearly along the hinge, from the side that opened.
        Some(axis) => {
            let opened = axis.cross(frame.tangent) * -1.0;
            let (sin, cos) = libm::sincos(HANGING_TURN);
            let back = axis * cos + opened * sin;
            let Horizontal {
                right: across,
                toward,
            } = greenstick_picture::horizontal(frame.tangent);
            let azimuth = libm::atan2(back.dot(across), back.dot(toward));
            (frame.tangent, (azimuth, HANGING_ELEVATION))
        }
    };
    (options.up, options.floor) = (up, false);
    if options.view == View::Automatic {
        let (azimuth, elevation) = view;
        options.view = View::Direction { azimuth, elevation };
    }
}

/// From where the two faces stand side by side, rad, in the horizontal axes of the picture's camera.
fn azimuth(frame: &Frame) -> f64 {
    let Horizontal {
        right: across,
        toward,
    } = greenstick_picture::horizontal(frame.tangent);
    // The viewer stands on the far side of the frame's y, so that x runs to the right.
    libm::atan2(-frame.y.dot(across), -frame.y.dot(toward))
}

/// How far the upper piece is set aside, m.
fn aside(wood: &BrokenWood, across: DVec3) -> DVec3 {
    across * (1.2 * wood.width)
}

/// The scene with the upper piece turned over and set beside the lower, both faces up.
fn opened(broken: &Broken, wood: &BrokenWood) -> Scene {
    let frame = wood.stem.grain.axis().frame(wood.stem.location);
    let [low, high] = broken.report.face.range_m;
    let turn = DAffine3::from_axis_angle(frame.y, std::f64::consts::PI);
    let centre = frame.origin + frame.tangent * ((low + high) / 2.0);
    let about = DAffine3::from_translation(centre + aside(wood, frame.x))
        * turn
        * DAffine3::from_translation(-centre);
    let mut scene = broken.scene.clone();
    for (node, role) in scene.nodes.iter_mut().zip(&broken.roles) {
        match role {
            NodeRole::Piece(PieceRole::Upper) | NodeRole::Carried => {
                node.transform = about * node.transform;
            }
            NodeRole::Piece(_) => {}
            // It would only stand in the way.
            NodeRole::Untouched => node.mesh = Arc::default(),
        }
    }
    scene
}

/// A picture of any scene in its materials' plain colours.
///
/// # Errors
/// As [`render`].
pub fn picture_of_scene(
    scene: &Scene,
    options: &PictureOptions,
    context: &Context,
) -> Result<Picture, PictureError> {
    let shader = PlainShader::from_materials(&scene.materials);
    render(&items(scene, &shader), options, context)
}

fn items<'a>(scene: &'a Scene, shader: &'a (dyn Shader + Sync)) -> Vec<Item<'a>> {
    scene
        .nodes
        .iter()
        .filter(|n| !n.mesh.triangles.is_empty())
        .map(|n| Item {
            mesh: &n.mesh,
            transform: n.transform,
            shader,
        })
        .collect()
}
