//! Simulations on threads of their own: one that runs, one that draws frames.

use super::gate::Gate;
use super::working::{Wake, Working};
use super::{Done, WorkProgress};
use crate::model::engine::Failure;
use crate::model::frame_artist::FrameArtist;
use crate::model::hand::{BY_HAND, add_hand, can_pull, hand_way, steered};
use crate::model::holds::{Moved, hand_of, holds_of, move_holds};
use crate::model::input::{Input, InputContent};
use crate::model::recording::Recording;
use crate::model::simulated::{
    Ended, EndedRun, Listener, RunStem, put_on, recorded, recorded_outcome, run, time_of,
};
use crate::model::simulation::{Begun, Look, News, Outcome, SimulationJob, Source};
use greenstick::fibre::scene::{Scene as Setting, StemChoice};
use greenstick::files;
use greenstick::files::run::{Origin, RunFolder, read_body_meshes};
use greenstick::formats::{Content, Reach};
use greenstick::geometry::{Context, Scene as Meshes, Stage};
use greenstick::schema::write_toml;
use greenstick::simulate::{RunSource, SceneMeshes};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};

/// Who draws the frames of a simulation; none before it begins.
type Artist = Arc<Mutex<Option<FrameArtist>>>;

/// What is known of the simulation that goes on.
#[derive(Default)]
struct Current {
    number: u64,
    working: Working,
    artist: Artist,
    /// Holds the run between two frames.
    gate: Arc<Gate>,
    /// Where the hand is to pull to from the next frame on, once that is asked for.
    steer: Arc<Mutex<Option<[f64; 3]>>>,
    /// The run, once it ended.
    ended: Arc<Mutex<Option<EndedRun>>>,
    /// What the next simulation may go on from.
    kept: Arc<Mutex<Option<KeptRun>>>,
}

/// A run whose states are kept, so that one which begins as it did can go on from there.
struct KeptRun {
    job: SimulationJob,
    /// Its scene, with the hand.
    setting: Setting,
    recording: Recording,
}

impl KeptRun {
    /// The run of a scene (with the hand) of another job, as far as this one is the same.
    fn branch(&self, job: &SimulationJob, setting: &Setting) -> Option<Recording> {
        let stem = |job: &SimulationJob| job.stem.as_ref().map(|(stem, place)| (stem.id, *place));
        let of = |job: &SimulationJob| (job.source.clone(), job.own, stem(job));
        // The meshes of bodies are read from files, which may be others by now.
        let is_known = setting.body.iter().all(|b| b.file.is_empty());
        let same = is_known && of(&self.job) == of(job);
        same.then(|| self.recording.branch(&self.setting, setting))?
    }
}

/// Simulates beside the window.
pub struct Simulator {
    wake: Wake,
    tell: Sender<Done>,
    current: Current,
    frames: Option<Sender<(usize, Look)>>,
}

/// Tells the window of one simulation.
#[derive(Clone)]
struct Teller {
    number: u64,
    tell: Sender<Done>,
    wake: Wake,
}

impl Teller {
    fn tell(&self, news: News) {
        // That nobody listens any more is noticed by cancelling.
        let _ = self.tell.send(Done::Simulated(self.number, news));
        (self.wake)();
    }
}

fn locked<T>(of: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Simulator {
    /// One that tells of its work.
    pub fn new(tell: &Sender<Done>, wake: &Wake) -> Self {
        Simulator {
            wake: wake.clone(),
            tell: tell.clone(),
            current: Current::default(),
            frames: None,
        }
    }

    fn teller(&self) -> Teller {
        Teller {
            number: self.current.number,
            tell: self.tell.clone(),
            wake: self.wake.clone(),
        }
    }

    /// Asks what goes on to stop.
    pub fn cancel(&self) {
        self.current.working.token.cancel();
    }

    /// How far it is.
    pub fn progress(&self) -> Option<WorkProgress> {
        self.current.working.at()
    }

    /// Holds the run after its present frame, or lets it go on.
    pub fn pause(&self, paused: bool) {
        self.current.gate.pause(paused);
    }

    /// Lets a run that is held go on to its next frame.
    pub fn step(&self) {
        self.current.gate.step();
    }

    /// Has the hand pull elsewhere from the present frame on; a run that is held goes on to its next frame.
    pub fn steer(&self, by: [f64; 3]) {
        *locked(&self.current.steer) = Some(by);
        self.current.gate.step();
    }

    /// Begins another simulation.
    pub fn begin(&mut self, job: SimulationJob) {
        self.cancel();
        let before = locked(&self.current.kept).take();
        self.current = Current {
            number: job.number,
            ..Current::default()
        };
        let (wishes, queue) = channel();
        self.frames = Some(wishes);
        let (teller, artist) = (self.teller(), self.current.artist.clone());
        std::thread::spawn(move || draw_frames(&queue, &artist, &teller));
        let shared = Shared {
            working: self.current.working.clone(),
            artist: self.current.artist.clone(),
            gate: self.current.gate.clone(),
            steer: self.current.steer.clone(),
            ended: self.current.ended.clone(),
            kept: self.current.kept.clone(),
        };
        let working = shared.working.clone();
        working.begin();
        let teller = self.teller();
        std::thread::spawn(move || {
            let outcome = work((job, before), &shared, &teller);
            working.end();
            if let Err(failure) = outcome {
                teller.tell(News::Ended(Err(failure)));
            }
            (teller.wake)();
        });
    }

    /// Draws a frame when those before are drawn; only the newest counts.
    pub fn draw(&self, number: usize, look: Look) {
        if let Some(frames) = &self.frames {
            let _ = frames.send((number, look));
        }
    }

    /// Takes the break that the run left.
    pub fn take(&mut self, at_hand: u64) {
        self.cancel();
        self.current.working = Working::default();
        let (working, ended) = (self.current.working.clone(), self.current.ended.clone());
        let teller = self.teller();
        working.begin();
        std::thread::spawn(move || {
            let taken = match &*locked(&ended) {
                Some(run) => run.take(Some(at_hand), &working.context(&teller.wake)),
                None => Err(Failure::new("the simulation has not ended")),
            };
            working.end();
            teller.tell(News::Taken(taken.map(Box::new)));
        });
    }
}

/// Draws what is asked for until nobody can ask any more.
fn draw_frames(queue: &Receiver<(usize, Look)>, artist: &Artist, teller: &Teller) {
    while let Ok(mut next) = queue.recv() {
        while let Ok(newer) = queue.try_recv() {
            next = newer;
        }
        let (number, look) = next;
        let drawn = (locked(artist).as_mut()).map(|artist| artist.draw(number, look));
        match drawn {
            Some(Ok(scene)) => teller.tell(News::Frame(number, look, Box::new(scene))),
            Some(Err(failure)) => teller.tell(News::Ended(Err(failure))),
            None => {}
        }
    }
}

/// A scene that is ready to be run, and where its files are.
fn read_scene(source: &Source) -> Result<(Setting, PathBuf), Failure> {
    match source {
        Source::BuiltIn(name) => {
            let setting = Setting::built_in(name).map_err(Failure::new)?;
            Ok((setting, PathBuf::new()))
        }
        Source::ByHand => {
            let setting = Setting::read(BY_HAND).map_err(Failure::new)?;
            Ok((setting, PathBuf::new()))
        }
        Source::File(path) | Source::Run(path) => {
            let path = Path::new(path);
            let text = files::read_text(path).map_err(Failure::new)?;
            let setting = Setting::read(&text)
                .map_err(|e| Failure::new(format!("{}: {e}", path.display())))?;
            let beside = path.parent().unwrap_or(Path::new(""));
            Ok((setting, beside.to_owned()))
        }
    }
}

/// The scene of a job.
struct JobScene {
    /// The scene, with its parts where they were moved, without the hand.
    setting: Setting,
    /// The hand.
    hand: Option<Moved>,
    /// Where its files are.
    beside: PathBuf,
    /// The stem at hand, where the scene is put on that.
    stem: Option<RunStem>,
    /// What a window needs to know.
    begun: Begun,
    /// The meshes that the scene is put on.
    input: Option<Meshes>,
}

/// A scene with a hand.
fn with_hand(setting: &Setting, hand: Option<&Moved>) -> Setting {
    let mut setting = setting.clone();
    if let Some(hand) = hand {
        add_hand(&mut setting, hand);
    }
    setting
}

fn job_scene(job: &SimulationJob) -> Result<JobScene, Failure> {
    let (mut setting, beside) = read_scene(&job.source)?;
    let is_on_input = setting.stem.kind == StemChoice::Input;
    let (mut input, mut stem) = (None, None);
    if let Some((at_hand, place)) = job.stem.as_ref().filter(|_| job.own || is_on_input) {
        let place = if job.own { *place } else { setting.stem.at };
        input = put_on(&mut setting, at_hand, place)?;
        stem = Some((at_hand.clone(), None));
    }
    let pull = can_pull(&setting);
    move_holds(&mut setting, &job.moved);
    let hand = hand_of(&job.moved);
    let way = hand.as_ref().map(|hand| hand_way(&setting, hand));
    let begun = Begun {
        about: setting.about.clone(),
        holds: holds_of(&setting),
        pull,
        hand_way: way.unwrap_or_default(),
    };
    Ok(JobScene {
        setting,
        hand,
        beside,
        stem,
        begun,
        input,
    })
}

/// Writes the scene of a job, with parts of it where they were moved.
///
/// # Errors
/// Where it cannot be read or written, or would no longer find the meshes of its bodies.
pub fn save_scene(path: &str, job: &SimulationJob) -> Result<(), Failure> {
    let JobScene {
        setting,
        hand,
        beside,
        ..
    } = job_scene(job)?;
    let setting = with_hand(&setting, hand.as_ref());
    let path = Path::new(path);
    let whole = |folder: &Path| std::path::absolute(folder).map_err(Failure::new);
    let folder = path.parent().unwrap_or(Path::new(""));
    let has_files = setting.body.iter().any(|b| !b.file.is_empty());
    if has_files && whole(&folder.join("."))? != whole(&beside.join("."))? {
        return Err(Failure::new(format!(
            "{}: bodies of this scene are meshes beside it; save it in the same folder, {}",
            path.display(),
            whole(&beside.join("."))?.display()
        )));
    }
    let bytes = write_toml(&setting).into_bytes();
    let path = path.to_owned();
    files::write_all(&[files::Output { path, bytes }]).map_err(Failure::new)
}

/// What a simulation shares with the window's side of it.
struct Shared {
    working: Working,
    artist: Artist,
    gate: Arc<Gate>,
    steer: Arc<Mutex<Option<[f64; 3]>>>,
    ended: Arc<Mutex<Option<EndedRun>>>,
    kept: Arc<Mutex<Option<KeptRun>>>,
}

impl Shared {
    /// Runs a scene, with a hand that may be steered elsewhere while it goes on.
    fn run(
        &self,
        job: &SimulationJob,
        (setting, hand, meshes): (&Setting, Option<Moved>, &SceneMeshes),
        recording: &Recording,
        teller: &Teller,
        context: &Context,
    ) -> Result<Outcome, Failure> {
        let tell = |source: &dyn RunSource| teller.tell(News::Recorded(recorded(source)));
        let steer = || {
            self.gate.pass(&self.working.token);
            locked(&self.steer).take()
        };
        let listener = Listener {
            tell: &tell,
            steer: &steer,
        };
        let mut hand = hand;
        loop {
            let scene = with_hand(setting, hand.as_ref());
            *locked(&self.kept) = Some(KeptRun {
                job: job.clone(),
                setting: scene.clone(),
                recording: recording.clone(),
            });
            let by = match run((scene, meshes.clone()), recording, &listener, context)? {
                Ended::Over(outcome) => return Ok(outcome),
                Ended::Steered(by) => by,
            };
            if let Some(hand) = &mut hand {
                *hand = steered(setting, hand, time_of(recording), by);
                let way = hand_way(setting, hand);
                teller.tell(News::Steered(hand.clone(), way));
            }
        }
    }
}

/// What the run of a scene (with the hand) begins with: the one before as far as it is the same, or nothing.
fn begun_before(before: Option<KeptRun>, job: &SimulationJob, setting: &Setting) -> Recording {
    let begun = before.and_then(|before| before.branch(job, setting));
    begun.unwrap_or_default()
}

/// Runs a scene, or reads a run, and makes wood of it.
fn work(
    (job, before): (SimulationJob, Option<KeptRun>),
    shared: &Shared,
    teller: &Teller,
) -> Result<(), Failure> {
    let Shared {
        working,
        artist,
        ended,
        ..
    } = shared;
    let artist_of = |source: &Arc<dyn RunSource>, meshes: &SceneMeshes| {
        let (source, token) = (source.clone(), working.token.clone());
        *locked(artist) = Some(FrameArtist::new(source, meshes.clone(), token));
    };
    let context = working.context(&teller.wake);
    let [running, opening] = context.split([(SIMULATE, 6.0), (WOOD, 1.0)]);
    let (source, meshes, stem) = match &job.source {
        Source::Run(folder) => {
            let (source, meshes, stem) = read_run(Path::new(folder))?;
            let scene = source.scene().map_err(|e| Failure::new(e.to_string()))?;
            teller.tell(News::Begun(Begun {
                about: scene.about,
                holds: Vec::new(),
                pull: Err("This run was recorded: it is what it is. Open its scene file to pull on its wood.".to_owned()),
                hand_way: Vec::new(),
            }));
            artist_of(&source, &meshes);
            teller.tell(News::Recorded(recorded(&*source)));
            let outcome = recorded_outcome(&*source)?;
            teller.tell(News::Ended(Ok(outcome)));
            (source, meshes, stem)
        }
        _ => {
            let JobScene {
                mut setting,
                hand,
                beside,
                stem,
                begun,
                input,
            } = job_scene(&job)?;
            teller.tell(News::Begun(begun));
            if job.source == Source::ByHand && hand.is_none() {
                // Nothing moves before a hand does.
                setting.duration = 0.0;
            }
            let bodies = read_body_meshes(&setting, &beside, Reach::Folder);
            let meshes = SceneMeshes {
                input,
                bodies: bodies.map_err(Failure::new)?,
            };
            let recording = begun_before(before, &job, &with_hand(&setting, hand.as_ref()));
            let source: Arc<dyn RunSource> = Arc::new(recording.clone());
            artist_of(&source, &meshes);
            teller.tell(News::Recorded(recorded(&recording)));
            let scene = (&setting, hand, &meshes);
            let outcome = shared.run(&job, scene, &recording, teller, &running)?;
            teller.tell(News::Recorded(recorded(&recording)));
            teller.tell(News::Ended(Ok(outcome)));
            (source, meshes, stem)
        }
    };
    let wood = || {
        let mut run = EndedRun::open(source, &meshes, stem, &opening.part(0.0, 0.2))?;
        let film = run.film(&opening.part(0.2, 1.0));
        *locked(ended) = Some(run);
        film
    };
    match wood() {
        Ok((film, best)) => {
            if let Some(artist) = &mut *locked(artist) {
                artist.take_film(film, best);
            }
            teller.tell(News::Wood(Ok(best)));
        }
        Err(failure) => teller.tell(News::Wood(Err(failure.message))),
    }
    Ok(())
}

/// A run with the meshes of its scene, and the stem that it is of where that is a file.
type OpenedRun = (Arc<dyn RunSource>, SceneMeshes, Option<RunStem>);

/// Reads a run that was recorded in a folder.
fn read_run(folder: &Path) -> Result<OpenedRun, Failure> {
    let origin = Origin::read(folder).map_err(Failure::new)?;
    let stem = match origin.input_file() {
        Some((path, unit)) => {
            let (mut content, _) = files::load_content(&path, unit).map_err(Failure::new)?;
            if let Content::Mesh(scene) = &mut content {
                files::embed_images(scene, &path);
            }
            Some((Input::read(path.display().to_string(), content), unit))
        }
        None => None,
    };
    let beside = origin.beside.clone();
    let run = RunFolder::new(folder, origin);
    let scene = run.scene().map_err(Failure::new)?;
    let bodies = read_body_meshes(&scene, &beside, Reach::Outside).map_err(Failure::new)?;
    let input = match stem.as_ref().map(|s| &*s.0.content) {
        Some(InputContent::Mesh(scene)) => Some(scene.clone()),
        _ => None,
    };
    Ok((Arc::new(run), SceneMeshes { input, bodies }, stem))
}

const SIMULATE: Stage = Stage::new("simulate");
const WOOD: Stage = Stage::new("wood");
