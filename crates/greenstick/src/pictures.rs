//! Pictures of broken stems and of any scene.

use crate::breaking::Broken;
use crate::looks::Looks;
use glam::{DVec2, DVec3};
use greenstick_geometry::{Context, Scene};
use greenstick_picture::{
    Appearance, Hit, Item, Picture, PictureError, PictureOptions, PlainShader, Shader, render,
};
use greenstick_wood::appearance::{BarkPoint, WoodPoint, WoodSurface, bark};
use greenstick_wood::stem::{Stem, StemKind};

/// Shades the wood inside by its address at the pixel, and the skin as bark where nothing better is known.
struct StemShader<'a> {
    stem: &'a Stem,
    looks: &'a Looks,
    inner: u32,
    plain: PlainShader,
    /// For each material whether it says nothing of the colour: no colour of its own, or only a texture.
    blank: Vec<bool>,
}

impl StemShader<'_> {
    fn wood(&self, hit: &Hit, grain: DVec3) -> Appearance {
        let frame = self.stem.grain.axis().frame(grain.z);
        let (ring, angle) = self.stem.rings.address(grain.truncate());
        let point = WoodPoint {
            ring,
            angle,
            across: grain.truncate() - self.stem.rings.pith(),
            along: grain.z,
            end_grain: hit.geometric_normal.dot(frame.tangent).abs(),
        };
        let surface = self.looks.wood.wood(&point, hit.footprint);
        finish(hit, &surface, [frame.x, frame.y, frame.tangent])
    }

    fn bark(&self, hit: &Hit, grain: Option<DVec3>) -> Appearance {
        let (point, directions) = match grain {
            Some(grain) => {
                let frame = self.stem.grain.axis().frame(grain.z);
                let across: DVec2 = grain.truncate() - self.stem.rings.pith();
                let angle = libm::atan2(across.y, across.x);
                let point = BarkPoint {
                    angle,
                    along: grain.z,
                    radius: across.length(),
                };
                (point, [frame.x, frame.y, frame.tangent])
            }
            None => {
                // Off the limb: the world's own axes, as far as the bark's look goes as good as any.
                let p = hit.position;
                let angle = libm::atan2(hit.normal.z, hit.normal.x);
                let point = BarkPoint {
                    angle,
                    along: p.y,
                    radius: self.stem.radius,
                };
                (point, [DVec3::X, DVec3::Z, DVec3::Y])
            }
        };
        let surface = bark(&self.looks.bark, &point, hit.footprint);
        finish(hit, &surface, directions)
    }
}

fn finish(hit: &Hit, surface: &WoodSurface, [x, y, along]: [DVec3; 3]) -> Appearance {
    let rise = x * surface.slope.x + y * surface.slope.y + along * surface.slope.z;
    Appearance {
        color: surface.color,
        roughness: surface.roughness,
        normal: hit.bumped(rise),
    }
}

impl Shader for StemShader<'_> {
    fn shade(&self, hit: &Hit) -> Appearance {
        let grain = hit
            .attribute("_GRAIN")
            .map(|g| DVec3::new(g[0], g[1], g[2]))
            .filter(|g| *g != DVec3::ZERO);
        let material = hit.material();
        match grain {
            Some(grain) if material == self.inner => self.wood(hit, grain),
            grain => {
                if !self.blank.get(material as usize).copied().unwrap_or(true) {
                    return self.plain.shade(hit);
                }
                match grain {
                    // A board's skin is sawn wood.
                    Some(grain) if self.stem.kind == StemKind::Board => self.wood(hit, grain),
                    grain => self.bark(hit, grain),
                }
            }
        }
    }
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
    let blank = broken
        .scene
        .materials
        .iter()
        .map(|m| m.base_color_texture.is_some() || m.base_color[..3] == [1.0; 3])
        .collect();
    let shader = StemShader {
        stem: &broken.stem,
        looks: &broken.looks,
        inner: broken.inner_material,
        plain: PlainShader::of_materials(&broken.scene.materials),
        blank,
    };
    let options = PictureOptions {
        zoom: options.zoom.or(Some(broken.focus())),
        ..options.clone()
    };
    render(&items(&broken.scene, &shader), &options, context)
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
    let shader = PlainShader::of_materials(&scene.materials);
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
