//! From items to a picture: camera, studio, samples, smoothing, tone mapping.

use crate::camera::{Camera, View};
use crate::light::Studio;
use crate::picture::Picture;
use crate::sampling::Sampler;
use crate::scene::{Scene, Seen, world_points};
use crate::smooth::smooth;
use crate::{Item, MAXIMUM_SAMPLES, MAXIMUM_SIDE, PictureError};
use glam::DVec3;
use greenstick_geometry::Context;
use rayon::prelude::*;

/// How a picture is taken.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureOptions {
    /// Pixels per row, 1 to 16384.
    pub width: u32,
    /// Rows, 1 to 16384.
    pub height: u32,
    /// Camera rays per pixel, 1 to 65536; from 4 on rounded up to a multiple of 4. Empty background takes fewer.
    pub samples: u32,
    /// From where.
    pub view: View,
    /// The ball (centre and radius, m in the world) to fill the picture with; everything where `None`.
    pub zoom: Option<(DVec3, f64)>,
    /// Points (m in the world) to fit into the picture where there is no `zoom`; all of the scene where empty.
    pub shown: Vec<DVec3>,
    /// The upward direction, of any length above 0; the picture's vertical and the floor's normal.
    pub up: DVec3,
    /// Whether the lowest point stands on a floor that takes shadows. Seen from below there is none.
    pub floor: bool,
    /// Linear colour of the background in the middle of the picture; it darkens towards the corners.
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
            shown: Vec::new(),
            up: DVec3::Y,
            floor: true,
            background: [0.72, 0.72, 0.71],
        }
    }
}

/// Rows between two looks at the caller's wish to stop.
const BAND: usize = 8;
/// One sample in so many goes to the light from behind, the others to the key light.
const RIM_EVERY: u32 = 4;
/// Pixels that met no item in so many samples are background and floor, which are smooth: those samples will do.
const BACKGROUND_SAMPLES: u32 = 8;

/// Takes a picture of the items.
///
/// # Errors
/// [`PictureError`] where there is nothing to show, a coordinate is not finite, an option is out of range, or the
/// caller cancelled.
pub fn render(
    items: &[Item],
    options: &PictureOptions,
    context: &Context,
) -> Result<Picture, PictureError> {
    let PictureOptions {
        width,
        height,
        samples,
        ..
    } = *options;
    if width == 0 || height == 0 || width > MAXIMUM_SIDE || height > MAXIMUM_SIDE {
        return Err(PictureError::Size { width, height });
    }
    if samples == 0 || samples > MAXIMUM_SAMPLES {
        return Err(PictureError::Samples { samples });
    }
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
    let ball = (scene.middle, scene.radius);
    let floor = options.floor.then_some(level);
    let studio = Studio::new(&camera, up, ball, floor, options.background);

    let columns = width as usize;
    let mut seen = vec![Seen::default(); columns * height as usize];
    let bands = seen.chunks_mut(columns * BAND * rayon::current_num_threads().max(1));
    let number = bands.len();
    let mut row = 0;
    for (done, band) in bands.enumerate() {
        context.report(done as f64 / number as f64)?;
        band.par_chunks_mut(columns)
            .enumerate()
            .for_each(|(r, pixels)| {
                for (x, pixel) in pixels.iter_mut().enumerate() {
                    *pixel = look(&scene, &studio, &camera, [x, row + r], options);
                }
            });
        row += band.len() / columns;
    }
    context.report(1.0)?;
    let light = smooth(&seen, columns, camera.pixel);
    Ok(Picture::develop(width, height, &light))
}

/// The mean of one pixel's samples.
fn look(
    scene: &Scene,
    studio: &Studio,
    camera: &Camera,
    [x, y]: [usize; 2],
    options: &PictureOptions,
) -> Seen {
    let PictureOptions {
        width,
        height,
        samples,
        ..
    } = *options;
    let pixel = y as u32 * width + x as u32;
    let samples = if samples < RIM_EVERY {
        samples
    } else {
        samples.next_multiple_of(RIM_EVERY)
    };
    let digits = (32 - (samples - 1).leading_zeros()).max(1);
    let mut sum = Seen::default();
    let mut remembered = None;
    for index in 0..samples {
        if index == BACKGROUND_SAMPLES && !sum.item {
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
        // Fewer samples than lights' turns: the key light alone.
        let every = f64::from(RIM_EVERY);
        let light = match (samples < RIM_EVERY, index % RIM_EVERY == RIM_EVERY - 1) {
            (true, _) => (0, 1.0),
            (false, true) => (1, every),
            (false, false) => (0, every / (every - 1.0)),
        };
        let ray = (camera.origin, camera.direction(u, v));
        let background = studio.background(u, v);
        let s = scene.see(
            studio,
            ray,
            (camera.pixel, background),
            &sampler,
            light,
            &mut remembered,
        );
        sum.light += s.light;
        sum.color += s.color;
        sum.normal += s.normal;
        sum.item |= s.item;
        sum.samples += 1;
        // A pixel on an edge lies between the two surfaces, so that smoothing takes it for neither.
        sum.distance += s.distance;
    }
    let mean = 1.0 / f64::from(sum.samples);
    Seen {
        light: sum.light * mean,
        color: sum.color * mean,
        normal: sum.normal * mean,
        distance: sum.distance * mean,
        ..sum
    }
}

/// Turns an even density on 0..1 into a tent on −1..1, the filter of the picture.
fn tent(t: f64) -> f64 {
    if t < 0.5 {
        (2.0 * t).sqrt() - 1.0
    } else {
        1.0 - (2.0 - 2.0 * t).sqrt()
    }
}
