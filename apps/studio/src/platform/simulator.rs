//! Simulations on threads of their own: one that runs, one that draws frames.

use super::gate::Gate;
use super::working::{Wake, Working};
use super::{Done, WorkProgress};
use crate::model::engine::Failure;
use crate::model::frame_artist::FrameArtist;
use crate::model::input::{Input, InputContent};
use crate::model::job_scene::{JobScene, KeptRun, begun_before, own_setting};
use crate::model::recording::Recording;
use crate::model::simulated::{
    Ended, EndedRun, Listener, RunStem, Wish, recorded, recorded_outcome, run, time_of,
};
use crate::model::simulation::{Begun, Look, News, Outcome, SimulationJob, Source};
use greenstick::fibre::scene::Scene as Setting;
use greenstick::files;
use greenstick::files::run::{Origin, RunFolder, read_body_meshes};
use greenstick::formats::{Content, Reach};
use greenstick::geometry::{Context, Stage};
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
        // Told before another film can be taken, whose news then comes later.
        let mut artist = locked(artist);
        match artist.as_mut().map(|artist| artist.draw(number, look)) {
            Some(Ok(scene)) => teller.tell(News::Frame(number, look, Box::new(scene))),
            Some(Err(failure)) => teller.tell(News::Ended(Err(failure))),
            None => {}
        }
    }
}

/// The scene of a source, and where its files are.
fn read_scene(source: &Source) -> Result<(Setting, PathBuf), Failure> {
    let path = match source {
        Source::File(path) | Source::Run(path) => Path::new(path),
        Source::BuiltIn(_) | Source::ByHand => return Ok((own_setting(source)?, PathBuf::new())),
    };
    let text = files::read_text(path).map_err(Failure::new)?;
    let setting =
        Setting::read(&text).map_err(|e| Failure::new(format!("{}: {e}", path.display())))?;
    let beside = path.parent().unwrap_or(Path::new(""));
    Ok((setting, beside.to_owned()))
}

/// Writes the scene of a job, with parts of it where they were moved.
///
/// # Errors
/// Where it cannot be read or written, or would no longer find the meshes of its bodies.
pub fn save_scene(path: &str, job: &SimulationJob) -> Result<(), Failure> {
    let (setting, beside) = read_scene(&job.source)?;
    let setting = JobScene::new(setting, job)?.0.with_hand();
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
        (scene, meshes): (&mut JobScene, &SceneMeshes),
        recording: &Recording,
        teller: &Teller,
        context: &Context,
    ) -> Result<Outcome, Failure> {
        let tell = |source: &dyn RunSource| teller.tell(News::Recorded(recorded(source)));
        let ask = || {
            self.gate.pass(&self.working.token);
            match locked(&self.steer).take() {
                Some(by) => Wish::Steer(by),
                None => Wish::GoOn,
            }
        };
        let listener = Listener {
            tell: &tell,
            ask: &ask,
        };
        loop {
            let setting = scene.with_hand();
            *locked(&self.kept) = Some(KeptRun {
                job: job.clone(),
                setting: setting.clone(),
                recording: recording.clone(),
            });
            let by = match run((setting, meshes.clone()), recording, &listener, context)? {
                Ended::Over(outcome) => return Ok(outcome),
                Ended::Resting => continue,
                Ended::Steered(by) => by,
            };
            if let Some((hand, way)) = scene.steer(time_of(recording), by) {
                teller.tell(News::Steered(hand, way));
            }
        }
    }
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
            let (setting, beside) = read_scene(&job.source)?;
            let (mut scene, begun) = JobScene::new(setting, &job)?;
            teller.tell(News::Begun(begun));
            scene.wait_for_hand(&job.source);
            let bodies = read_body_meshes(&scene.setting, &beside, Reach::Folder);
            let meshes = SceneMeshes {
                input: scene.input.take(),
                bodies: bodies.map_err(Failure::new)?,
            };
            let recording = begun_before(before, &job, &scene.with_hand());
            let source: Arc<dyn RunSource> = Arc::new(recording.clone());
            artist_of(&source, &meshes);
            teller.tell(News::Recorded(recorded(&recording)));
            let of = (&mut scene, &meshes);
            let outcome = shared.run(&job, of, &recording, teller, &running)?;
            let stem = scene.stem;
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
