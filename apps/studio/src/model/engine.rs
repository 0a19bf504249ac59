//! The work behind the window: a request becomes a broken scene, by the one chain of stages that all of Greenstick's programs use.

use super::early::{FinishedBreaks, Surroundings};
use super::input::{Input, InputContent};
use super::materials::DecodedImages;
use super::meshes::DrawnScene;
use super::section_book::{SectionBook, StemSection, sections_of};
use super::wire;
use greenstick::geometry::{Context, Scene};
use greenstick::scanning::{ScanParameters, ScannedReport, cloud_from_scene, scan_to_scene};
use greenstick::wood::stem::{StemError, StemLocation, StemOptions};
use greenstick::{
    BreakReport, BreakRequest, BreakSession, BreakStage, Broken, Error, ErrorKind, RequestFile,
    break_scene,
};
use serde::{Deserialize, Serialize};

/// Most circles and sectors of a coarse answer.
const COARSE: (u32, u32) = (24, 60);
/// The fraction of the work on a cloud that laying the bark over it takes.
const SCANNING: f64 = 0.6;
/// The fraction that a cut takes which is drawn early.
const DRAWING: f64 = 0.05;

/// A request for a picture.
#[derive(Debug, Clone)]
pub struct Job {
    /// What is broken.
    pub input: Input,
    /// How.
    pub file: RequestFile,
    /// How much of an answer is wanted.
    pub haste: Haste,
    /// The number of the break of whose stem sections are wanted, if they are.
    pub sections_of: Option<usize>,
}

/// How much of an answer is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Haste {
    /// The whole of it, finished, whatever is drawn before.
    Whole,
    /// What is drawn alone where that can be, as the request changes again at once.
    Drawn,
    /// The same with a coarser face.
    Coarse,
}

/// What is drawn of a job before it is finished, or instead.
pub type Early<'a> = &'a mut dyn FnMut(DrawnScene);

/// What a job gives.
#[derive(Debug, Serialize, Deserialize)]
pub struct Shown {
    /// The meshes as the card draws them.
    pub drawn: DrawnScene,
    /// The report.
    #[serde(with = "wire::json")]
    pub report: BreakReport,
    /// Whether the face is coarser than was asked for.
    pub coarse: bool,
    /// The first stage that was recomputed; unknown where the work is done elsewhere.
    #[serde(skip)]
    pub started_at: Option<BreakStage>,
    /// What was subtracted from the coordinates of a cloud, m.
    pub origin: [f64; 3],
    /// The sections of the stem, or why there are none, where they were wanted.
    pub sections: Option<Result<SectionBook, String>>,
}

/// The meshes of an input before anything is broken; none of a scan, whose bark is still to be laid.
pub fn unbroken(input: &Input) -> Option<DrawnScene> {
    match &*input.content {
        InputContent::Mesh(scene) => Some(DrawnScene::unbroken(scene)),
        InputContent::Cloud(_) => None,
        InputContent::Elsewhere(seen) => seen.unbroken.clone(),
    }
}

/// What went wrong, as a message that stays until it is read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// What was found, where, and what would be right.
    pub message: String,
    /// Whether the work was only cancelled.
    pub cancelled: bool,
    /// The nearest place that works, where it is only the place that does not.
    #[serde(with = "wire::place")]
    pub place: Option<StemLocation>,
}

impl Failure {
    /// Work that was given up.
    pub fn cancelled() -> Self {
        Failure {
            cancelled: true,
            ..Failure::new("cancelled")
        }
    }

    /// A message.
    pub fn new(message: impl ToString) -> Self {
        Failure {
            message: message.to_string(),
            cancelled: false,
            place: None,
        }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let place = match &error {
            Error::Stem(
                StemError::OffStem { nearest, .. }
                | StemError::Unusable { nearest, .. }
                | StemError::FarFromWood { nearest, .. },
            ) => Some(*nearest),
            _ => None,
        };
        Failure {
            cancelled: error.kind() == ErrorKind::Cancelled,
            message: error.to_string(),
            place,
        }
    }
}

/// What a session is of: an input and, where a scan is laid over with bark, how and where.
#[derive(Debug, Clone, PartialEq)]
struct SceneKey {
    input: u64,
    scan: Option<(StemLocation, ScanParameters)>,
}

/// A scene that is ready to be broken.
#[derive(Debug)]
struct Opened {
    key: SceneKey,
    session: BreakSession,
    /// The first break's place in the scene, where it is that of a scan.
    place: Option<StemLocation>,
    scan: Option<ScannedReport>,
    /// What the last finished answer draws around a face.
    around: Option<Surroundings>,
    /// The last finished answer, where it had several breaks.
    several: Option<FinishedBreaks>,
    decoded: DecodedImages,
    /// The sections of a stem, by what it was found by.
    sections: Option<(SectionsKey, Result<Vec<StemSection>, String>)>,
}

/// What decides which stem sections are of.
type SectionsKey = (StemLocation, StemOptions);

/// Does jobs, and keeps what the next one can use.
#[derive(Debug, Default)]
pub struct Engine {
    opened: Option<Opened>,
}

/// A scan's scene, the place of the first break in it, and its report.
type Laid = (Scene, Option<StemLocation>, Option<ScannedReport>);

/// The scene of an input: its meshes, or the bark that is laid over its points.
fn lay(input: &Input, file: &RequestFile, context: &Context) -> Result<Laid, Error> {
    let sampled;
    let cloud = match &*input.content {
        InputContent::Mesh(scene) if !file.scan.as_scan => return Ok((scene.clone(), None, None)),
        InputContent::Mesh(scene) => {
            sampled = cloud_from_scene(scene);
            &sampled
        }
        InputContent::Cloud(cloud) => cloud,
        InputContent::Elsewhere(_) => {
            return Err(Error::Amount(
                "the file is not where the work is".to_owned(),
            ));
        }
    };
    let place = first_place(file);
    let scanned = scan_to_scene(cloud, &place, &file.scan.request(), context)?;
    Ok((scanned.scene, Some(scanned.location), Some(scanned.report)))
}

fn first_place(file: &RequestFile) -> StemLocation {
    file.breaks.first().unwrap_or(&file.common).place
}

fn key(input: &Input, file: &RequestFile) -> SceneKey {
    let is_scan = matches!(&*input.content, InputContent::Cloud(_)) || file.scan.as_scan;
    SceneKey {
        input: input.id,
        scan: is_scan.then(|| (first_place(file), file.scan.clone())),
    }
}

/// The request of a file in the coordinates of the scene that its scan became.
fn request_of(
    file: &RequestFile,
    place: Option<StemLocation>,
    scan: Option<&ScannedReport>,
) -> BreakRequest {
    let mut request = file.request();
    if let Some(place) = place {
        request.breaks[0].place = place;
    }
    let origin = scan.map_or([0.0; 3], |s| s.origin_m);
    for one in &mut request.breaks[1..] {
        if let StemLocation::Point(p) = &mut one.place {
            (p.x, p.y, p.z) = (p.x - origin[0], p.y - origin[1], p.z - origin[2]);
        }
    }
    request
}

/// Makes the faces of a request coarse, or one of them; false where they are no finer already.
fn coarsen(request: &mut BreakRequest, only: Option<usize>) -> bool {
    let mut changed = false;
    let breaks = request.breaks.iter_mut().enumerate();
    for (_, one) in breaks.filter(|b| only.is_none_or(|only| b.0 == only)) {
        let face = &mut one.recipe.face;
        changed |= face.rings > COARSE.0 || face.sectors > COARSE.1;
        face.rings = face.rings.min(COARSE.0);
        face.sectors = face.sectors.min(COARSE.1);
    }
    changed
}

/// Whether a coarse answer is any coarser than the request.
pub fn has_coarse(file: &RequestFile) -> bool {
    coarsen(&mut file.request(), None)
}

impl Engine {
    /// Does a job. Where only a face changes, or how far its pieces are apart, what is drawn of it is told to `early` long before the
    /// answer is finished; nothing else is made of a job that wants nothing more.
    ///
    /// # Errors
    /// What is wrong with the request or its input, or that the work was cancelled.
    pub fn work(
        &mut self,
        job: &Job,
        early: Early,
        context: &Context,
    ) -> Result<Option<Shown>, Error> {
        let key = key(&job.input, &job.file);
        let [laying, drawing, breaking] = context.split([
            (STEM, if key.scan.is_some() { SCANNING } else { 0.0 }),
            (BREAK, DRAWING),
            (BREAK, 1.0 - SCANNING - DRAWING),
        ]);
        if self.opened.as_ref().is_none_or(|o| o.key != key) {
            self.opened = None;
            let (scene, place, scan) = lay(&job.input, &job.file, &laying)?;
            self.opened = Some(Opened {
                key,
                session: BreakSession::new(scene),
                place,
                scan,
                around: None,
                several: None,
                decoded: DecodedImages::new(),
                sections: None,
            });
        }
        let Some(opened) = &mut self.opened else {
            return Err(Error::Amount("no scene is open".to_owned()));
        };
        let mut request = request_of(&job.file, opened.place, opened.scan.as_ref());
        // The viewport evaluates the wood at each pixel.
        request.texture_width = 0;
        let only = (opened.several.as_ref()).and_then(|s| s.changed(&request));
        let coarse = job.haste == Haste::Coarse && coarsen(&mut request, only);
        let started = opened.draw_early(&request, early, &drawing)?;
        if started.is_some() && job.haste != Haste::Whole {
            return Ok(None);
        }
        let mut broken = opened.session.broken(&request, &breaking)?;
        broken.report.scan.clone_from(&opened.scan);
        let origin = opened.scan.as_ref().map_or([0.0; 3], |s| s.origin_m);
        let drawn = DrawnScene::new(&broken, &mut opened.decoded);
        let started_at = started.flatten().or(opened.session.started_at());
        let sections = match job.sections_of {
            Some(number) => opened.sections(&request, number, &broken, context)?,
            None => None,
        };
        let report = broken.report.clone();
        opened.remember(&request, broken, &drawn, context)?;
        // So that the window need not.
        drawn.surveyed();
        Ok(Some(Shown {
            drawn,
            report,
            coarse,
            started_at,
            origin,
            sections,
        }))
    }
}

impl Opened {
    /// Draws a request of which only the face, or how far its pieces are apart, is another than in the last finished answer. Returns the
    /// first stage that was recomputed, if any; `None` where something else is.
    fn draw_early(
        &mut self,
        request: &BreakRequest,
        early: Early,
        context: &Context,
    ) -> Result<Option<Option<BreakStage>>, Error> {
        self.look_around(request, context)?;
        let Some(around) = self.around.take_if(|a| a.may_hold_for(request)) else {
            return Ok(None);
        };
        let stages = self.session.stages_of(request, around.number(), context)?;
        let started_at = self.session.started_at();
        if !around.hold_for(request, &stages) {
            return Ok(None);
        }
        let Some(drawn) = around.drawn(request, &stages) else {
            return Ok(None);
        };
        self.around = Some(around);
        early(drawn);
        Ok(Some(started_at))
    }

    /// Finds what the last finished answer with several breaks draws around the one whose face is another now.
    fn look_around(&mut self, request: &BreakRequest, context: &Context) -> Result<(), Error> {
        let Some(several) = &self.several else {
            return Ok(());
        };
        let Some(number) = several.changed(request) else {
            return Ok(());
        };
        if self.around.as_ref().is_none_or(|a| a.number() != number) {
            let silent = context.silenced();
            let stages = self.session.stages_of(&several.request, number, &silent)?;
            self.around = Surroundings::of_one(several, number, &stages);
        }
        Ok(())
    }

    /// The sections of the stem of a break, kept until another stem is broken.
    fn sections(
        &mut self,
        request: &BreakRequest,
        number: usize,
        broken: &Broken,
        context: &Context,
    ) -> Result<Option<Result<SectionBook, String>>, Error> {
        let (Some(one), Some(wood)) = (request.breaks.get(number), broken.woods.get(number)) else {
            return Ok(None);
        };
        let key = (one.place, request.stem.clone());
        if self.sections.as_ref().is_none_or(|s| s.0 != key) {
            let single = BreakRequest {
                breaks: vec![one.clone()],
                every: None,
                ..request.clone()
            };
            let silent = context.silenced();
            let stage = self.session.fork().stem(&single, &silent)?;
            let made = match sections_of(&stage.sound, &silent) {
                Err(error) if Error::from(error.clone()).kind() == ErrorKind::Cancelled => {
                    return Err(error.into());
                }
                made => made.map_err(|e| e.to_string()),
            };
            self.sections = Some((key, made));
        }
        let made = self.sections.as_ref().map(|s| s.1.clone());
        Ok(made.map(|made| made.map(|sections| SectionBook::new(sections, number, wood))))
    }

    /// Keeps what the next change can be drawn in.
    fn remember(
        &mut self,
        request: &BreakRequest,
        broken: Broken,
        drawn: &DrawnScene,
        context: &Context,
    ) -> Result<(), Error> {
        (self.around, self.several) = (None, None);
        if request.every.is_some() {
            return Ok(());
        }
        if request.breaks.len() == 1 {
            let stages = self.session.stages(request, context)?;
            self.around = Surroundings::new(request, &broken, drawn, &stages);
        } else {
            self.several = Some(FinishedBreaks {
                request: request.clone(),
                scene: broken.scene,
                roles: broken.roles,
                drawn: drawn.clone(),
            });
        }
        Ok(())
    }
}

const STEM: greenstick::geometry::Stage = greenstick::geometry::Stage::new("stem");
const BREAK: greenstick::geometry::Stage = greenstick::geometry::Stage::new("break");

/// Breaks an input as the command line does, textures included. `prepare` may change the scene before it is broken: what refers
/// to files is carried to where it will be written.
///
/// # Errors
/// As [`Engine::work`].
pub fn export(
    input: &Input,
    file: &RequestFile,
    prepare: impl FnOnce(&mut Scene),
    context: &Context,
) -> Result<Broken, Error> {
    let [laying, breaking] = context.split([(STEM, 0.3), (BREAK, 0.7)]);
    let (mut scene, place, scan) = lay(input, file, &laying)?;
    let request = request_of(file, place, scan.as_ref());
    prepare(&mut scene);
    let mut broken = break_scene(scene, &request, &breaking)?;
    let provenance = file.provenance(input.file_name(), scan.as_ref());
    broken.scene.metadata = provenance.metadata();
    broken.report.scan = scan;
    Ok(broken)
}
