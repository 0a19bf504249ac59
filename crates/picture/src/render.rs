//! Rendering: camera, studio, samples, denoising and tone mapping.

use crate::camera::{Camera, Sphere, View};
use crate::error::{MAX_SAMPLES, MAX_SIDE, PictureError};
use crate::item::Item;
use crate::light::Studio;
use crate::picture::Picture;
use crate::sampling::Sampler;
use crate::scene::{CameraRay, LightChoice, Sample, Scene, world_points};
use crate::shader::Shader;
use crate::smooth::smooth;
use glam::DVec3;
use greenstick_geometry::Context;
use rayon::prelude::*;

/// Options of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureOptions {
    /// Width, 1 to 16384 pixels.
    pub width: u32,
    /// Height, 1 to 16384 pixels.
    pub height: u32,
    /// Camera rays per pixel, 1 to 65536. From 4 on, it is rounded up to a multiple of 4; the background takes fewer.
    pub samples: u32,
    /// Direction of view.
    pub view: View,
    /// Sphere that fills the picture; `None` to show everything.
    pub zoom: Option<Sphere>,
    /// How much whoever knows where the wood is broken shows of it as `zoom`, in diameters of the stem; [`render`] does not look at it.
    pub close_up: Option<f64>,
    /// Points in the world that fit into the picture if `zoom` is `None`, m; empty for all vertices.
    pub shown: Vec<DVec3>,
    /// Upward direction, of any length above 0: the vertical of the picture and the normal of the floor.
    pub up: DVec3,
    /// Whether the lowest point lies on a floor that receives shadows. It is invisible from below.
    pub floor: bool,
    /// Linear colour of the background at the centre of the picture; it darkens towards the corners.
    pub background: [f64; 3],
}

impl Default for PictureOptions {
    fn default() -> Self {
        crate::PictureParameters::default().options()
    }
}

impl PictureOptions {
    /// A picture of everything; its size and what else [`crate::PictureParameters`] say is still to be set.
    pub(crate) fn everything() -> Self {
        PictureOptions {
            width: 0,
            height: 0,
            samples: 0,
            view: View::Automatic,
            zoom: None,
            close_up: None,
            shown: Vec::new(),
            up: DVec3::Y,
            floor: true,
            background: [0.72, 0.72, 0.71],
        }
    }
}

/// Rows per thread after which the renderer reports progress and may be cancelled.
const BAND_ROWS: usize = 8;
/// One sample of this many uses the rim light, the others use the key light.
const RIM_LIGHT_INTERVAL: u32 = 4;
/// Number of samples after which a pixel without items is complete: background and floor are smooth.
const BACKGROUND_SAMPLES: u32 = 8;

/// Renders a scene in which one shader provides the appearance of all surfaces.
///
/// # Errors
/// As [`render`].
pub fn render_scene(
    scene: &greenstick_geometry::Scene,
    shader: &(dyn Shader + Sync),
    options: &PictureOptions,
    context: &Context,
) -> Result<Picture, PictureError> {
    let nodes = scene.nodes.iter();
    let items: Vec<Item> = nodes
        .filter(|node| !node.mesh.triangles.is_empty())
        .map(|node| Item {
            mesh: &node.mesh,
            transform: node.transform,
            shader,
        })
        .collect();
    render(&items, options, context)
}

/// Renders a picture of the items.
///
/// ```
/// use glam::{DAffine3, DVec3};
/// use greenstick_geometry::{Context, Mesh};
/// use greenstick_picture::{Item, PictureOptions, PlainShader, render};
///
/// let mesh = Mesh {
///     positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
///     triangles: vec![[0, 1, 2]],
///     ..Mesh::default()
/// };
/// let shader = PlainShader::uniform([0.8, 0.2, 0.2]);
/// let item = Item { mesh: &mesh, transform: DAffine3::IDENTITY, shader: &shader };
/// let options = PictureOptions { width: 16, height: 12, samples: 1, ..PictureOptions::default() };
/// let picture = render(&[item], &options, &Context::quiet())?;
/// assert_eq!(picture.rgb.len(), 3 * 16 * 12);
/// # Ok::<(), greenstick_picture::PictureError>(())
/// ```
///
/// # Errors
/// [`PictureError`] if there are no triangles, a coordinate is not finite, an option is out of range, or the caller asked
/// to stop.
pub fn render(
    items: &[Item],
    options: &PictureOptions,
    context: &Context,
) -> Result<Picture, PictureError> {
    let PictureOptions { width, height, .. } = *options;
    check_size(options)?;
    context.report(0.0)?;
    let points = world_points(items)?;
    let shown = if options.shown.is_empty() {
        &points
    } else {
        &options.shown
    };
    if shown.iter().any(|p| !p.is_finite()) {
        return Err(PictureError::View("the points to show must be finite"));
    }
    let camera = Camera::new(
        shown,
        options.view,
        options.zoom,
        options.up,
        [width, height],
    )?;
    let up = options.up.normalize();
    let level = points
        .iter()
        .map(|p| p.dot(up))
        .fold(f64::INFINITY, f64::min);
    let scene = Scene::new(items, &points);
    drop(points);
    let floor = options.floor.then_some(level);
    let studio = Studio::new(&camera, up, scene.bounds, floor, options.background);

    let columns = width as usize;
    let mut pixels = vec![Sample::default(); columns * height as usize];
    let bands = pixels.chunks_mut(columns * BAND_ROWS * rayon::current_num_threads().max(1));
    let number = bands.len();
    let mut row = 0;
    for (done, band) in bands.enumerate() {
        context.report(done as f64 / number as f64)?;
        band.par_chunks_mut(columns)
            .enumerate()
            .for_each(|(r, row_pixels)| {
                for (x, pixel) in row_pixels.iter_mut().enumerate() {
                    *pixel = mean_sample(&scene, &studio, &camera, [x, row + r], options);
                }
            });
        row += band.len() / columns;
    }
    context.report(1.0)?;
    let radiance = smooth(&pixels, columns, camera.pixel_size);
    Ok(Picture::from_radiance(width, height, &radiance))
}

/// Refuses sizes and numbers of samples that are out of range.
fn check_size(options: &PictureOptions) -> Result<(), PictureError> {
    let PictureOptions {
        width,
        height,
        samples,
        ..
    } = *options;
    if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
        return Err(PictureError::Size { width, height });
    }
    if samples == 0 || samples > MAX_SAMPLES {
        return Err(PictureError::Samples { samples });
    }
    Ok(())
}

/// The mean of the samples of a pixel.
fn mean_sample(
    scene: &Scene,
    studio: &Studio,
    camera: &Camera,
    [x, y]: [usize; 2],
    options: &PictureOptions,
) -> Sample {
    let PictureOptions {
        width,
        height,
        samples,
        ..
    } = *options;
    let pixel = y as u32 * width + x as u32;
    let samples = if samples < RIM_LIGHT_INTERVAL {
        samples
    } else {
        samples.next_multiple_of(RIM_LIGHT_INTERVAL)
    };
    let digits = (32 - (samples - 1).leading_zeros()).max(1);
    let mut sum = Sample::default();
    let mut last = None;
    for index in 0..samples {
        if index == BACKGROUND_SAMPLES && !sum.is_item {
            break;
        }
        let sampler = Sampler {
            pixel,
            index,
            digits,
        };
        let [jx, jy] = sampler.square(1).map(tent);
        let u = (x as f64 + 0.5 + jx) / f64::from(width) * 2.0 - 1.0;
        let v = 1.0 - (y as f64 + 0.5 + jy) / f64::from(height) * 2.0;
        // Too few samples for both lights use the key light alone.
        let interval = f64::from(RIM_LIGHT_INTERVAL);
        let light = match (
            samples < RIM_LIGHT_INTERVAL,
            index % RIM_LIGHT_INTERVAL == RIM_LIGHT_INTERVAL - 1,
        ) {
            (true, _) => LightChoice {
                light: 0,
                weight: 1.0,
            },
            (false, true) => LightChoice {
                light: 1,
                weight: interval,
            },
            (false, false) => LightChoice {
                light: 0,
                weight: interval / (interval - 1.0),
            },
        };
        let ray = CameraRay {
            origin: camera.origin,
            direction: camera.direction(u, v),
            pixel_size: camera.pixel_size,
            background: studio.background(u, v),
        };
        let s = scene.sample(studio, &ray, &sampler, light, &mut last);
        sum.radiance += s.radiance;
        sum.color += s.color;
        sum.normal += s.normal;
        sum.is_item |= s.is_item;
        sum.samples += 1;
        // A pixel on an edge is between both surfaces, so that the filter takes it for neither.
        sum.distance += s.distance;
    }
    let mean = 1.0 / f64::from(sum.samples);
    Sample {
        radiance: sum.radiance * mean,
        color: sum.color * mean,
        normal: sum.normal * mean,
        distance: sum.distance * mean,
        ..sum
    }
}

/// Maps a uniform distribution on 0…1 to a tent on −1…1, the pixel filter.
fn tent(t: f64) -> f64 {
    if t < 0.5 {
        (2.0 * t).sqrt() - 1.0
    } else {
        1.0 - (2.0 - 2.0 * t).sqrt()
    }
}
