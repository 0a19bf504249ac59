//! Pictures of broken stems and of any scene.

use crate::session::{Broken, BrokenWood};
use glam::DVec3;
use greenstick_geometry::{Context, Material, Scene};
use greenstick_picture::{
    Appearance, Ground, Hit, Picture, PictureError, PictureOptions, PlainShader, Shader, Sphere,
    View, azimuth_of_view, render_scene,
};
use greenstick_skin::view::{self, BreakView, FilmView};
use greenstick_skin::{WoodField, materials};
use greenstick_wood::appearance::{StemAppearance, SurfacePoint};
use greenstick_wood::stem::Stem;

/// Shades the wood inside by its address at the pixel, and the skin as bark unless its material has a colour or a texture that is
/// there.
struct StemShader<'a> {
    /// The wood inside, by material; bark and sawn ends are those of the first.
    woods: Vec<Inside<'a>>,
    plain: PlainShader,
    /// Whether each material has no colour to show: none at all, or only a texture.
    blank: Vec<bool>,
    /// The field that is shown in place of the wood.
    field: Option<WoodField>,
}

/// Roughness of what shows a field.
const FIELD_ROUGHNESS: f64 = 0.9;

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

impl<'a> StemShader<'a> {
    fn new(scene: &Scene, woods: Vec<Inside<'a>>) -> Result<Self, PictureError> {
        let inner = |number| woods.iter().any(|wood| wood.material as usize == number);
        let plain = file_materials(scene, |number, m| {
            !inner(number) && !materials::is_own_bark(scene, m)
        })?;
        let blank = materials::without_color(scene).into_iter().zip(0..);
        Ok(StemShader {
            woods,
            blank: blank.map(|(b, n)| b && !plain.is_textured(n)).collect(),
            plain,
            field: WoodField::of(scene),
        })
    }

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
            // Pieces lie elsewhere than they grew, so that the stem's frames give no directions.
            moved: true,
            grain_gradients: hit.gradients("_GRAIN"),
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
                color: field.color(value[0]),
                roughness: FIELD_ROUGHNESS,
                normal: hit.normal,
                fibre: DVec3::ZERO,
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
            fibre: inside.map_or(DVec3::ZERO, |_| oriented.directions[2]),
        }
    }

    fn has_holes(&self) -> bool {
        self.plain.has_holes()
    }

    fn is_hole(&self, hit: &Hit) -> bool {
        self.plain.is_hole(hit)
    }
}

/// The materials of a scene, of which those that `is_shown` names have the textures whose images are in the scene.
fn file_materials(
    scene: &Scene,
    is_shown: impl Fn(usize, &Material) -> bool,
) -> Result<PlainShader, PictureError> {
    #[cfg(feature = "files")]
    let read = |bytes: &[u8]| {
        let pixels = greenstick_formats::pixels::read_pixels(bytes);
        pixels.map(Some).map_err(|problem| problem.to_string())
    };
    #[cfg(not(feature = "files"))]
    let read = |_: &[u8]| Ok(None);
    PlainShader::with_textures(scene, is_shown, read)
}

/// What a close-up shows, as [`view::close_up`].
fn close_up(scene: &Scene, inner: &[u32], diameters: f64) -> Option<Sphere> {
    view::close_up(scene, inner, diameters).map(|(centre, radius)| Sphere { centre, radius })
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
    let shader = StemShader::new(scene, woods)?;
    let mut options = options.clone();
    let mut near =
        (options.close_up).and_then(|diameters| view::close_up_of_frame(scene, &inner, diameters));
    // Whoever says what is shown has decided for all frames of a film.
    if options.shown.is_empty() {
        let mut all = FilmView::default();
        all.add(scene, &inner);
        near = near.or_else(|| all.close_up(None));
        options.shown = all.points;
    }
    let near = near.map(|(centre, radius)| Sphere { centre, radius });
    options.zoom = options.zoom.or(near);
    if shader.field.is_none() {
        (options.ground).get_or_insert_with(|| Ground::under(&options.shown));
    }
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
    let woods = broken.woods.iter().map(Inside::new).collect();
    let shader = StemShader::new(&broken.scene, woods)?;
    // Only a stem with one break is opened for its picture.
    let [wood] = &broken.woods[..] else {
        let near = options.close_up.zip(broken.woods.first());
        let near = near.and_then(|(d, wood)| close_up(&broken.scene, &[wood.material], d));
        let options = PictureOptions {
            zoom: options.zoom.or(near),
            ..options.clone()
        };
        return render_scene(&broken.scene, &shader, &options, context);
    };
    let is_opened = broken.hinge.is_none() && broken.end.is_none();
    let motion = is_opened.then(|| view(broken, wood).opening(&broken.scene, &broken.roles));
    let mut scene = match &motion {
        Some(motion) => view(broken, wood).opened(&broken.scene, &broken.roles, motion),
        None => broken.scene.clone(),
    };
    let mut options = options.clone();
    if let (None, Some(diameters), None) = (options.zoom, options.close_up, broken.end) {
        aim(broken, wood, &scene, &mut options);
        let near = close_up(&scene, &[wood.material], diameters);
        let shown = &options.shown;
        // A close-up is no wider than what is shown without it.
        let is_nearer = |s: &Sphere| shown.iter().any(|p| p.distance(s.centre) > s.radius);
        options.zoom = near.filter(|s| shown.is_empty() || is_nearer(s));
    } else if let (Some(end), None) = (broken.end, options.zoom) {
        // Cracks in a sawn end: that end, from above.
        let end = view::moved_end(&scene, &broken.roles, end);
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
        aim(broken, wood, &scene, &mut options);
    }
    let has_chips = options.chips && options.floor && broken.end.is_none();
    if has_chips && broken.report.face.surface == "fibrous" {
        (scene.nodes).push(view(broken, wood).chips(&options.shown, options.up, motion.as_ref()));
    }
    render_scene(&scene, &shader, &options, context)
}

/// A break as a picture shows it.
fn view<'a>(broken: &Broken, wood: &'a BrokenWood) -> BreakView<'a> {
    BreakView {
        stem: &wood.stem,
        material: wood.material,
        range: broken.report.face.range_m,
        width: wood.width,
        long_side: view::long_side(&wood.stem, wood.material, &broken.scene, &broken.roles),
    }
}

/// Aims the camera at both faces and a stub of stem behind each.
fn aim(broken: &Broken, wood: &BrokenWood, scene: &Scene, options: &mut PictureOptions) {
    let view = view(broken, wood);
    let Some(points) = view.points(scene, &broken.scene, &broken.roles) else {
        return;
    };
    let sight = view.sight(broken.hinge, &broken.scene, &broken.roles);
    options.ground = options.ground.or_else(|| Some(Ground::under(&points)));
    (options.shown, options.up) = (points, sight.up);
    if options.view == View::Automatic {
        options.view = View::Direction {
            azimuth: azimuth_of_view(sight.up, sight.direction),
            elevation: sight.elevation,
        };
    }
}

/// Renders any scene with the colours and textures of its materials.
///
/// # Errors
/// As [`render_scene`], and where an image cannot be read.
pub fn picture_of_scene(
    scene: &Scene,
    options: &PictureOptions,
    context: &Context,
) -> Result<Picture, PictureError> {
    let shader = file_materials(scene, |_, _| true)?;
    render_scene(scene, &shader, options, context)
}
