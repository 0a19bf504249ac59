//! The numbers that the shader takes: those of a frame, and those of a surface.

use super::frame::View;
use super::resources::SHADOW_SIDE;
use crate::model::materials::{Opacity, Texture, Wrap};
use crate::model::meshes::{Batch, Shading};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use glam::camera::rh::proj::directx::orthographic;
use glam::camera::rh::view::look_at_mat4;

/// The numbers of a frame, in the layout of the shader's `Globals`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Globals {
    view_projection: [[f32; 4]; 4],
    light_projection: [[f32; 4]; 4],
    eye: [f32; 4],
    up: [f32; 4],
    key_direction: [f32; 4],
    rim_direction: [f32; 4],
    background: [f32; 4],
    section: [f32; 4],
    flags: [f32; 4],
    forward: [f32; 4],
    right: [f32; 4],
}

/// The numbers of a surface, in the layout of the shader's `Surface`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct SurfaceNumbers {
    base: [f32; 4],
    kind: [f32; 4],
    texture_map: [f32; 4],
    turn: [f32; 4],
    relief_map: [f32; 4],
    relief: [f32; 4],
    opacity: [f32; 4],
}

/// How far things shade each other from the sky, in radii of the stem, and that radius in radii of a scene that has no break.
const SHADE: f32 = 0.45;
const SHADE_WITHOUT_STEM: f32 = 0.05;
/// Part of the shadow map over which the edge of a shadow is spread.
const SOFTNESS: f32 = 0.004;

/// The numbers of a frame.
pub(super) fn globals(frame: &View) -> Globals {
    let camera = &frame.camera;
    let aspect = frame.size[0] as f32 / frame.size[1].max(1) as f32;
    let radius = frame.shown.as_ref().map_or(1.0, |s| s.1.radius as f32);
    // The lights turn with the camera, as in greenstick's pictures.
    let (right, vertical) = (camera.right(), camera.vertical());
    let toward = right.cross(vertical);
    let direction = |x: f32, y: f32, z: f32| (right * x + vertical * y + toward * z).normalize();
    let (key, rim) = (direction(-0.75, 0.95, 0.55), direction(0.85, 0.55, -0.75));
    // The shadow map covers what is in the picture; what casts shadows may lie anywhere between.
    let covered = (0.55 * camera.distance).min(radius * 1.05).max(1e-6);
    let centre = camera.target;
    let reach = centre.length() + radius + covered;
    let light = orthographic(-covered, covered, -covered, covered, 0.0, 2.0 * reach)
        * look_at_mat4(centre + key * reach, centre, vertical);
    let eye = if camera.parallel {
        camera.target + camera.backward() * 1e3 * camera.distance
    } else {
        camera.eye()
    };
    let pixel = if camera.parallel {
        camera.pixel(frame.size[1] as f32) / 1e3
    } else {
        camera.pixel(frame.size[1] as f32)
    };
    let section = frame.section.as_ref();
    let (normal, distance) = section.map_or((Vec3::X, 0.0), |s| (s.0.normal, s.0.distance));
    let on = |x: bool| f32::from(u8::from(x));
    let stem = frame.shown.as_ref().and_then(|s| s.1.breaks.first());
    let shade = SHADE * stem.map_or(SHADE_WITHOUT_STEM * radius, |b| b.radius);
    Globals {
        view_projection: camera.projection(aspect, radius).to_cols_array_2d(),
        light_projection: light.to_cols_array_2d(),
        eye: eye.extend(pixel).to_array(),
        up: vertical.extend(frame.colours as u8 as f32).to_array(),
        key_direction: key.extend(SOFTNESS).to_array(),
        rim_direction: rim.extend(0.0).to_array(),
        background: [
            frame.background[0],
            frame.background[1],
            frame.background[2],
            0.0,
        ],
        section: normal.extend(distance).to_array(),
        flags: [
            on(section.is_some()),
            (2.0 * covered / SHADOW_SIDE as f32).max(SOFTNESS * covered),
            shade,
            0.0,
        ],
        forward: (-camera.backward()).extend(radius).to_array(),
        right: right.extend(0.0).to_array(),
    }
}

/// The numbers of the surface of a batch.
pub(super) fn surface_numbers(batch: &Batch) -> SurfaceNumbers {
    let kind = match batch.shading {
        Shading::Material => 0.0,
        Shading::Wood(_) => 1.0,
        Shading::Skin => 2.0,
    };
    let none = Texture {
        image: 0,
        map: [1.0, 1.0, 0.0, 0.0],
        turn: 0.0,
        strength: 0.0,
        wraps: [Wrap::Repeat; 2],
    };
    let texture = batch.texture.unwrap_or(none);
    let relief = batch.relief.unwrap_or(none);
    let flag = |on: bool| f32::from(u8::from(on));
    let [metal, rough] = batch.metal_rough;
    let (mode, cutoff) = match batch.opacity {
        Opacity::Opaque => (0.0, 0.0),
        Opacity::Masked(cutoff) => (1.0, cutoff),
        Opacity::Blended => (2.0, 0.0),
    };
    SurfaceNumbers {
        base: batch.base,
        kind: [metal, rough, kind, flag(batch.texture.is_some())],
        texture_map: texture.map,
        turn: [texture.turn.sin(), texture.turn.cos(), 0.0, 0.0],
        relief_map: relief.map,
        relief: [
            relief.turn.sin(),
            relief.turn.cos(),
            relief.strength,
            flag(batch.relief.is_some()),
        ],
        opacity: [mode, cutoff, 0.0, 0.0],
    }
}
