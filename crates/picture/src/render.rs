//! Rendering in four steps: what is seen at the middle of each pixel, the light there from few rays (on smooth surfaces at every fourth
//! pixel), the same smoothed, and the picture, with more camera rays where an edge or fine detail asks for them.

use crate::camera::{Camera, CameraPlacement, Sphere, View};
use crate::coin::Coin;
use crate::denoise::{Neighbours, smooth};
use crate::enlarge::enlarged;
use crate::error::{MAX_SAMPLES, MAX_SIDE, PictureError};
use crate::focus::{Distances, Focus, Lens, Spreading, depth_of_field};
use crate::ground::{FallenLeaves, Ground, ShownGround};
use crate::item::Item;
use crate::layers::Pixel;
use crate::lens::soften;
use crate::light::Studio;
use crate::picture::{Film, Picture};
use crate::resolve::{CELL, Frame, Resolve};
use crate::scene::{Scene, world_points};
use crate::shader::Shader;
use crate::surface::Place;
use glam::{DVec3, Vec3};
use greenstick_geometry::Context;
use rayon::prelude::*;

/// Options of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureOptions {
    /// Width, 1 to 16384 pixels.
    pub width: u32,
    /// Height, 1 to 16384 pixels.
    pub height: u32,
    /// Most camera rays per pixel, 1 to 65536; a pixel without an edge or fine detail takes fewer.
    pub samples: u32,
    /// Whether a rough picture is enough: a third as wide and high, with at most four camera rays per pixel, enlarged, and without grain
    /// unless that is given.
    pub draft: bool,
    /// Direction of view.
    pub view: View,
    /// Where the camera is; `None` to place it by `view`, `zoom` and `shown`, which are then left alone.
    pub camera: Option<CameraPlacement>,
    /// Sphere that fills the picture; `None` to show everything.
    pub zoom: Option<Sphere>,
    /// How much whoever knows where the wood is broken shows of it as `zoom`, in diameters of the stem; [`render`] does not look at it.
    pub close_up: Option<f64>,
    /// What the scene stands on, where it has a floor; [`render`] takes `None` as the plain backdrop.
    pub ground: Option<Ground>,
    /// How much what lies before and behind the focus is blurred, 0 to 1; `None` is a little on a ground that is shown.
    pub depth_of_field: Option<f64>,
    /// Grain, 0 to 1; `None` is a little on a ground that is shown.
    pub film_grain: Option<f64>,
    /// Softness of the lens, 0 to 1; `None` is a little on a ground that is shown.
    pub lens_softness: Option<f64>,
    /// Whether a coin lies on the floor in front of the scene, for scale.
    pub coin: bool,
    /// Whether whoever opens broken wood for the picture strews chips of it about; [`render`] does not look at it.
    pub chips: bool,
    /// Points in the world that fit into the picture if `zoom` is `None`, m; empty for all vertices.
    pub shown: Vec<DVec3>,
    /// Point in the world where the pattern of the ground begins, m; `None` for the middle of the scene. Pictures that belong together, as
    /// frames of a film do, share it.
    pub ground_origin: Option<DVec3>,
    /// Upward direction, of any length above 0: the vertical of the picture and the normal of the floor.
    pub up: DVec3,
    /// Whether the lowest of the points that fit into the picture lies on a floor, which receives shadows and hides what is below it. It
    /// is invisible from below.
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
            draft: false,
            view: View::Automatic,
            camera: None,
            zoom: None,
            close_up: None,
            ground: None,
            depth_of_field: None,
            film_grain: None,
            lens_softness: None,
            coin: false,
            chips: true,
            shown: Vec::new(),
            ground_origin: None,
            up: DVec3::Y,
            floor: true,
            background: [0.40, 0.385, 0.36],
        }
    }
}

/// Rows per thread after which the renderer reports progress and may be cancelled.
const BAND_ROWS: usize = 8;
/// Camera rays per pixel for each ray to a lamp, and for each indirect ray.
const SAMPLES_PER_LIGHT_RAY: u32 = 8;
/// How many times wider and higher than it is rendered a draft is, and its most camera rays per pixel.
const DRAFT_SCALE: u32 = 3;
const DRAFT_SAMPLES: u32 = 4;
/// Aperture of the lens (m) where a ground is shown: that of 85 mm at f/3.5. Near a branch what lies behind the focus is blurred; a
/// trunk is seen from farther off. What it blurs at most, as a depth of field: all of what is broken is to be seen.
const GROUND_APERTURE: f64 = 0.024;
const GROUND_DEPTH_OF_FIELD: f64 = 0.18;
/// Grain on a ground that is shown: that of a good camera in a workshop.
const GROUND_GRAIN: f64 = 0.25;
/// Softness of the lens on a ground that is shown: that of a good one.
const GROUND_SOFTNESS: f64 = 0.3;
/// Shares of the work after which what is seen, its light, more of that in soft shadows, and all pixels before they are blurred are there.
const PROGRESS: [f64; 5] = [0.0, 0.3, 0.6, 0.7, 0.9];

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
    check_size(options)?;
    let size = [options.width, options.height];
    let (rendered, samples) = if options.draft {
        (
            size.map(|n| n.div_ceil(DRAFT_SCALE)),
            options.samples.min(DRAFT_SAMPLES),
        )
    } else {
        (size, options.samples)
    };
    context.report(0.0)?;
    let mut points = world_points(items)?;
    let shown = if options.shown.is_empty() {
        &points
    } else {
        &options.shown
    };
    if shown.iter().any(|p| !p.is_finite()) {
        return Err(PictureError::View("the points to show must be finite"));
    }
    let mut camera = aimed(shown, options, rendered)?;
    let up = options.up.normalize();
    let level = shown
        .iter()
        .map(|p| p.dot(up))
        .fold(f64::INFINITY, f64::min);
    let coin = (options.coin).then(|| Coin::before(shown, &camera, up));
    let leaves = (options.ground == Some(Ground::Litter) && options.floor)
        .then(|| FallenLeaves::about(shown, &camera, up));
    let with_coin: Vec<Item>;
    let mut items = items;
    if let Some(coin) = &coin {
        let wider: Vec<DVec3> = shown.iter().copied().chain(coin.corners()).collect();
        camera = aimed(&wider, options, rendered)?;
        with_coin = coin.beside(items);
        items = &with_coin;
        points = world_points(items)?;
    }
    let with_leaves: Vec<Item>;
    if let Some(leaves) = &leaves {
        with_leaves = leaves.beside(items);
        items = &with_leaves;
        points = world_points(items)?;
    }
    let scene = Scene::new(items, &points);
    drop(points);
    let floor = options.floor.then_some(level);
    let mut studio = Studio::new(&camera, up, floor, options.background);
    let origin = options.ground_origin.unwrap_or(scene.bounds.centre);
    let ground = (options.ground).and_then(|kind| ShownGround::new(kind, &camera, up, origin));
    if let Some(ground) = ground {
        studio.show_ground(ground);
    }
    let is_ground_shown = studio.floor.as_ref().is_some_and(|f| f.ground.is_some());
    let film = match is_ground_shown {
        true => Film::Photographic,
        false => Film::Even,
    };
    let on_ground = |usual: f64| if is_ground_shown { usual } else { 0.0 };
    let usual = if options.draft { 0.0 } else { GROUND_GRAIN };
    let grain = options.film_grain.unwrap_or(on_ground(usual));
    let softness = (options.lens_softness).unwrap_or(on_ground(GROUND_SOFTNESS));
    let frame = Frame {
        scene: &scene,
        studio: &studio,
        camera: &camera,
        size: rendered.map(|n| n as usize),
        samples,
        rays: samples.div_ceil(SAMPLES_PER_LIGHT_RAY),
    };
    let radiance = radiance(&frame, Blur::of(options, is_ground_shown), context)?;
    let radiance = soften(radiance, frame.size, softness);
    let radiance = enlarged(radiance, frame.size, size.map(|n| n as usize));
    Ok(Picture::from_radiance(size, &radiance, film, grain))
}

/// The camera of a picture of `size` pixels in which `points` are to be seen.
fn aimed(
    points: &[DVec3],
    options: &PictureOptions,
    size: [u32; 2],
) -> Result<Camera, PictureError> {
    match options.camera {
        Some(placement) => Camera::placed(&placement, options.up, size),
        None => Camera::new(points, options.view, options.zoom, options.up, size),
    }
}

/// How much is blurred that is out of focus.
#[derive(Clone, Copy, PartialEq)]
enum Blur {
    /// A depth of field, 0 to 1.
    Given(f64),
    /// As by a lens whose aperture has a diameter, m.
    Aperture(f64),
}

impl Blur {
    fn of(options: &PictureOptions, is_ground_shown: bool) -> Self {
        match options.depth_of_field {
            Some(given) => Blur::Given(given),
            None if is_ground_shown => Blur::Aperture(GROUND_APERTURE),
            None => Blur::Given(0.0),
        }
    }
}

/// Finds the radiance of all pixels of a frame, blurred out of focus.
fn radiance(frame: &Frame, blur: Blur, context: &Context) -> Result<Vec<Vec3>, PictureError> {
    let rows = |step: usize| Rows {
        columns: frame.size[0],
        rows: frame.size[1],
        context,
        progress: [
            PROGRESS[step],
            PROGRESS.get(step + 1).copied().unwrap_or(1.0),
        ],
    };
    let mut seen = rows(0).fill(|x, y| frame.seen(x, y))?;
    let places: Vec<Place> = seen.par_iter().map(|s| s.place).collect();
    let neighbours = Neighbours {
        places: &places,
        size: frame.size,
    };
    let focus = focus(frame, &places, blur);
    let columns = frame.size[0];
    let disc = |place: &Place| (focus.as_ref()).map_or(0.0, |focus| focus.radius(place));
    // Band by band, so that a picture can be cancelled.
    let cells = BAND_ROWS * rayon::current_num_threads().max(1);
    for (band, seen) in seen.chunks_mut(cells * CELL * columns).enumerate() {
        context.report(PROGRESS[1])?;
        let rows = seen.par_chunks_mut(CELL * columns).enumerate();
        rows.for_each(|(row, seen)| frame.color_ground(band * cells + row, seen, disc));
    }
    let support: Vec<f32> = (0..places.len())
        .into_par_iter()
        .map(|i| neighbours.support([i % columns, i / columns]))
        .collect();
    let light = rows(1).fill(|x, y| {
        let place = &places[y * columns + x];
        frame.light(&neighbours, (&support, disc(place)), [x, y])
    })?;
    let light = rows(2).fill(|x, y| {
        let support = support[y * columns + x];
        frame.refined(&neighbours, (&light, support), [x, y])
    })?;
    let light = smooth(&neighbours, light);
    let centres: Vec<Vec3> = (seen.par_iter().zip(&light))
        .map(|(seen, light)| seen.radiance(frame.studio, light))
        .collect();
    let resolved = Resolve {
        frame,
        neighbours,
        seen: &seen,
        light: &light,
        centres: &centres,
        focus: focus.as_ref(),
    };
    let mut pixels = rows(3).fill(|x, y| resolved.pixel([x, y], false))?;
    resolved.follow_outlines(&mut pixels, (context, PROGRESS[4]))?;
    let pixels: Vec<Pixel> = pixels.par_iter().map(|p| p.pixel).collect();
    let Some(focus) = focus else {
        context.report(1.0)?;
        return Ok(pixels.par_iter().map(Pixel::radiance).collect());
    };
    let spreading = Spreading::new(&pixels, frame.size, &focus.lens);
    rows(4).fill(|x, y| spreading.pixel([x, y]))
}

/// What a camera that sees these places is focused on; `None` where nothing is out of focus.
fn focus(frame: &Frame, places: &[Place], blur: Blur) -> Option<Focus> {
    if blur == Blur::Given(0.0) {
        return None;
    }
    let distances = Distances::new(frame.camera, frame.scene.bounds.centre);
    let focus = distances.focus(places, frame.size)?;
    let strength = match blur {
        Blur::Given(given) => given,
        Blur::Aperture(aperture) => {
            depth_of_field(aperture, focus, frame.camera).min(GROUND_DEPTH_OF_FIELD)
        }
    };
    Some(Focus {
        lens: Lens { focus, strength },
        distances,
        height: frame.size[1],
    })
}

/// How the values of all pixels are found: band by band, so that a picture can be cancelled.
struct Rows<'a> {
    columns: usize,
    rows: usize,
    context: &'a Context,
    /// Progress at the first row and after the last one.
    progress: [f64; 2],
}

impl Rows<'_> {
    /// Returns the values at all pixels, in rows.
    fn fill<T: Send>(
        &self,
        value: impl Fn(usize, usize) -> T + Sync,
    ) -> Result<Vec<T>, PictureError> {
        let band = BAND_ROWS * rayon::current_num_threads().max(1);
        let mut values = Vec::with_capacity(self.columns * self.rows);
        let [start, end] = self.progress;
        for first in (0..self.rows).step_by(band) {
            let done = first as f64 / self.rows as f64;
            self.context.report(start + (end - start) * done)?;
            let last = (first + band).min(self.rows);
            let columns = self.columns;
            // By pixels and not by rows, whose number of values rayon does not know: it would collect them in lists of their own first.
            let pixels = (first * columns..last * columns).into_par_iter();
            values.par_extend(pixels.map(|i| value(i % columns, i / columns)));
        }
        self.context.report(end)?;
        Ok(values)
    }
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
