//! Draws the frames of a run: as rods, as the whole wood before its first break, and as the wood that its end cut.

use super::engine::Failure;
use super::look::WoodLook;
use super::materials::DecodedImages;
use super::meshes::DrawnScene;
use super::simulation::{DrawnFrame, Look};
use glam::{DAffine3, DVec3, Vec3};
use greenstick::fibre::EventKind;
use greenstick::fibre::bodies::Shape;
use greenstick::fibre::store::Frame;
use greenstick::film::{DrawnFilm, FilmError, open_run};
use greenstick::geometry::{CancelToken, Context};
use greenstick::rods_scene;
use greenstick::session::BrokenWood;
use greenstick::simulate::{RunSource, SceneMeshes, SimulateError, body_shapes};
use greenstick::skin::film::{FilmParameters, SkinnedFilm};
use std::sync::Arc;

/// A film of wood, and what its woods look like, by their materials.
struct Wood {
    film: SkinnedFilm,
    looks: Vec<(u32, WoodLook)>,
    decoded: DecodedImages,
}

impl Wood {
    fn new(film: SkinnedFilm, woods: &[BrokenWood]) -> Self {
        let looks = woods.iter().map(|w| (w.material, WoodLook::new(w)));
        Wood {
            film,
            looks: looks.collect(),
            decoded: DecodedImages::new(),
        }
    }

    fn draw(&mut self, number: usize, middle: DVec3) -> Result<DrawnScene, Failure> {
        let scene = self.film.at(number).map_err(FilmError::from)?;
        let decoded = &mut self.decoded;
        Ok(DrawnScene::moved(&scene, &self.looks, middle, decoded))
    }
}

/// Draws frames of a run.
pub struct FrameArtist {
    source: Arc<dyn RunSource>,
    meshes: SceneMeshes,
    /// Stops what takes long.
    token: CancelToken,
    shapes: Option<Vec<Shape>>,
    /// The middle of the first frame, which all frames are drawn about, and its radius.
    rest: Option<(DVec3, f64)>,
    /// The axis of the stem there, about that middle.
    axis: Arc<Vec<Vec3>>,
    /// The whole wood, once it was asked for; none where it cannot be shown.
    whole: Option<Option<Wood>>,
    /// When it first broke, s, as far as is known.
    broke: Option<f64>,
    /// The wood, once it is cut, and whether that shows the run better than rods.
    cut: Option<(Wood, bool)>,
}

impl FrameArtist {
    /// One for a run, and the meshes that its scene names.
    pub fn new(source: Arc<dyn RunSource>, meshes: SceneMeshes, token: CancelToken) -> Self {
        FrameArtist {
            source,
            meshes,
            token,
            shapes: None,
            rest: None,
            axis: Arc::default(),
            whole: None,
            broke: None,
            cut: None,
        }
    }

    /// Has it draw wood from now on; `best` where that shows the run better than rods.
    pub fn take_film(&mut self, film: DrawnFilm, best: bool) {
        self.cut = Some((Wood::new(film.skinned, &film.broken.woods), best));
    }

    /// Draws a frame; as rods where there is no wood. Files have y up, and so has the picture.
    ///
    /// # Errors
    /// Where the frame cannot be read.
    pub fn draw(&mut self, number: usize, look: Look) -> Result<DrawnFrame, Failure> {
        let (middle, rest_radius) = match self.rest {
            Some(rest) => rest,
            None => {
                let first = DrawnScene::unbroken(&self.rods(0)?);
                let frame = self.source.frame(0).map_err(SimulateError::from)?;
                let axis = axis(&frame).into_iter();
                let drawn = axis.map(|p| (upright().transform_point3(p) - first.middle).as_vec3());
                self.axis = Arc::new(drawn.collect());
                (first.middle, first.radius)
            }
        };
        self.rest = Some((middle, rest_radius));
        let wood = match look {
            Look::Rods => None,
            _ => self.wood(number, look)?,
        };
        let scene = match wood {
            Some(wood) => wood.draw(number, middle)?,
            None => {
                let rods = self.rods(number)?;
                DrawnScene::moved(&rods, &[], middle, &mut DecodedImages::new())
            }
        };
        Ok(DrawnFrame {
            scene,
            rest_radius,
            axis: self.axis.clone(),
        })
    }

    /// The wood that shows a frame; none where rods do.
    fn wood(&mut self, number: usize, look: Look) -> Result<Option<&mut Wood>, Failure> {
        let is_cut = (self.cut.as_ref()).is_some_and(|(_, best)| *best || look == Look::Wood);
        if is_cut {
            return Ok(self.cut.as_mut().map(|(wood, _)| wood));
        }
        if self.has_broken(number)? {
            return Ok(None);
        }
        if self.whole.is_none() {
            // What cannot be shown so is shown as rods; why is said when the run has ended.
            self.whole = Some(self.make_whole().ok());
        }
        Ok(self.whole.as_mut().and_then(Option::as_mut))
    }

    /// Whether the wood has broken in a frame.
    fn has_broken(&mut self, number: usize) -> Result<bool, Failure> {
        if self.broke.is_none() {
            let events = self.source.events().map_err(SimulateError::from)?;
            let mut breaks = events.iter().filter(|e| e.kind != EventKind::RodYielded);
            self.broke = breaks.next().map(|e| e.time);
        }
        let Some(broke) = self.broke else {
            return Ok(false);
        };
        let frame = self.source.frame(number).map_err(SimulateError::from)?;
        Ok(broke <= frame.time)
    }

    /// The whole wood, along the rods that other frames are drawn as.
    fn make_whole(&self) -> Result<Wood, Failure> {
        let context = Context::silent(self.token.clone());
        let mut run = open_run(self.source.clone(), &self.meshes, &context)?.along_x();
        let options = FilmParameters::default().film_options(run.scene.seed);
        let film = run.film_of_whole(&options, &context);
        let film = film.map_err(FilmError::from)?;
        let look = BrokenWood {
            material: film.inner,
            stem: run.stem().clone(),
            appearance: run.appearance().clone(),
            width: 0.0,
        };
        Ok(Wood::new(film, &[look]))
    }

    fn rods(&mut self, number: usize) -> Result<greenstick::geometry::Scene, Failure> {
        let frame = self.source.frame(number).map_err(SimulateError::from)?;
        let shapes = match &mut self.shapes {
            Some(shapes) => shapes,
            none => {
                let setting = self.source.scene().map_err(SimulateError::from)?;
                none.insert(body_shapes(&setting, &self.meshes)?)
            }
        };
        let mut scene = rods_scene(&frame, shapes);
        for node in &mut scene.nodes {
            node.transform = upright() * node.transform;
        }
        Ok(scene)
    }
}

/// Turns what has z up to have y up.
fn upright() -> DAffine3 {
    DAffine3::from_rotation_x(-std::f64::consts::FRAC_PI_2)
}

/// Points along the axis of a stem, and the part of the longest rod's length from which on a rod runs along all of the stem.
const AXIS_POINTS: usize = 33;
const WHOLE: f64 = 0.95;

/// The axis of the stem of a frame in even steps: the middle of the rods that run along all of it.
fn axis(frame: &Frame) -> Vec<DVec3> {
    let point = |i: u32| DVec3::from(frame.position[i as usize].map(f64::from));
    let rods = frame.rod_offsets.windows(2).filter(|r| r[1] > r[0] + 1);
    let rods: Vec<Vec<DVec3>> = rods.map(|r| (r[0]..r[1]).map(point).collect()).collect();
    let length = |rod: &[DVec3]| rod.windows(2).map(|p| p[0].distance(p[1])).sum::<f64>();
    let longest = rods.iter().map(|r| length(r)).fold(0.0, f64::max);
    let whole: Vec<_> = rods
        .iter()
        .filter(|r| length(r) >= WHOLE * longest)
        .collect();
    let at = |rod: &[DVec3], part: f64| {
        let mut left = part * length(rod);
        for pair in rod.windows(2) {
            let step = pair[0].distance(pair[1]);
            if left <= step && step > 0.0 {
                return pair[0].lerp(pair[1], left / step);
            }
            left -= step;
        }
        rod[rod.len() - 1]
    };
    if whole.is_empty() {
        return Vec::new();
    }
    let parts = (0..AXIS_POINTS).map(|k| k as f64 / (AXIS_POINTS - 1) as f64);
    let sum = |part: f64| whole.iter().map(|r| at(r, part)).sum::<DVec3>();
    parts.map(|part| sum(part) / whole.len() as f64).collect()
}
