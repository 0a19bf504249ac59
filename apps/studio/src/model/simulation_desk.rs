//! The simulations of a page, whose worker has one thread for all of their work: the wood is moved a frame at a time, and between two
//! frames the hand is steered and others are drawn. A run that was gone on with frame by frame is the same as one in one piece.

use super::engine::{Failure, unbroken};
use super::frame_artist::FrameArtist;
use super::held::HeldFile;
use super::input::{Input, Seen};
use super::job_scene::{JobScene, KeptRun, begun_before, own_setting};
use super::messages::{Answer, AskedSimulation, SimulationAsk, TakenFile};
use super::recording::{Recording, SAME_TIME};
use super::simulated::{Ended, EndedRun, Listener, Wish, recorded, run, time_of};
use super::simulation::{Look, News, SimulationJob, Taken};
use greenstick::RequestFile;
use greenstick::geometry::{CancelToken, Context, Stage};
use greenstick::simulate::{RunSource, SceneMeshes};
use std::sync::Arc;

/// How far a simulation is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    /// The wood is moved.
    Moving,
    /// It is to be cut as the end of the run decided.
    Cutting,
    /// There is nothing left to do.
    Over,
}

/// A simulation that goes on.
struct Current {
    job: SimulationJob,
    scene: JobScene,
    meshes: SceneMeshes,
    recording: Recording,
    artist: FrameArtist,
    step: Step,
    ended: Option<EndedRun>,
}

/// Where simulations are made.
#[derive(Default)]
pub struct SimulationDesk {
    current: Option<Current>,
}

const SIMULATE: Stage = Stage::new("simulate");
const WOOD: Stage = Stage::new("wood");

fn told(number: u64, news: News) -> Answer {
    Answer::Simulated(number, Box::new(news))
}

impl SimulationDesk {
    /// Does what is asked; `input` gives the input of a number. Returns the last answer, if there is one, and the files that go with
    /// it; `early` is told what is answered before.
    pub fn answer(
        &mut self,
        ask: SimulationAsk,
        input: impl FnOnce(u64) -> Result<Input, Failure>,
        early: &mut dyn FnMut(Answer),
        context: &Context,
    ) -> (Option<Answer>, Vec<HeldFile>) {
        let answer = match ask {
            SimulationAsk::Begin(asked) => {
                let number = asked.number;
                let mut tell = |news| early(told(number, news));
                let begun = self.begin(asked, input, &mut tell);
                if let Err(failure) = &begun {
                    tell(News::Ended(Err(failure.clone())));
                }
                Some(Answer::Rested(number, begun.is_err()))
            }
            SimulationAsk::GoOn => self.current.as_mut().map(|c| c.go_on(early, context)),
            SimulationAsk::Steer(by) => self.current.as_mut().and_then(|c| c.steer(by)),
            SimulationAsk::Draw(number, look) => {
                let current = self.current.as_mut();
                current.map(|c| c.draw(number, look))
            }
            SimulationAsk::Take(at_hand) => {
                let current = self.current.as_ref();
                return current.map_or((None, Vec::new()), |c| c.take(at_hand, context));
            }
        };
        (answer, Vec::new())
    }

    fn begin(
        &mut self,
        asked: AskedSimulation,
        input: impl FnOnce(u64) -> Result<Input, Failure>,
        tell: &mut dyn FnMut(News),
    ) -> Result<(), Failure> {
        let before = self.current.take().map(Current::into_kept);
        let stem = match asked.place {
            Some(place) => Some((input(asked.input)?, place)),
            None => None,
        };
        let job = SimulationJob {
            number: asked.number,
            source: asked.source,
            stem,
            own: asked.own,
            moved: asked.moved,
        };
        let (mut scene, begun) = JobScene::new(own_setting(&job.source)?, &job)?;
        tell(News::Begun(begun));
        scene.wait_for_hand(&job.source);
        let meshes = SceneMeshes {
            input: scene.input.take(),
            bodies: scene.setting.body.iter().map(|_| None).collect(),
        };
        let recording = begun_before(before, &job, &scene.with_hand());
        let source: Arc<dyn RunSource> = Arc::new(recording.clone());
        tell(News::Recorded(recorded(&*source)));
        self.current = Some(Current {
            artist: FrameArtist::new(source, meshes.clone(), CancelToken::default()),
            job,
            scene,
            meshes,
            recording,
            step: Step::Moving,
            ended: None,
        });
        Ok(())
    }
}

impl Current {
    fn into_kept(self) -> KeptRun {
        KeptRun {
            setting: self.scene.with_hand(),
            job: self.job,
            recording: self.recording,
        }
    }

    fn go_on(&mut self, early: &mut dyn FnMut(Answer), context: &Context) -> Answer {
        let number = self.job.number;
        let [moving, cutting] = context.split([(SIMULATE, 6.0), (WOOD, 1.0)]);
        let news = match self.step {
            Step::Moving => match self.move_wood(&moving) {
                Ok(Some(ended)) => {
                    self.step = Step::Cutting;
                    vec![News::Recorded(recorded(&self.recording)), ended]
                }
                Ok(None) => vec![News::Recorded(recorded(&self.recording))],
                Err(failure) => {
                    self.step = Step::Over;
                    vec![News::Ended(Err(failure))]
                }
            },
            Step::Cutting => {
                self.step = Step::Over;
                vec![News::Wood(self.cut(&cutting).map_err(|f| f.message))]
            }
            Step::Over => Vec::new(),
        };
        for news in news {
            early(told(number, news));
        }
        Answer::Rested(number, self.step == Step::Over)
    }

    /// Moves the wood to its next frame; returns how it ended, if it did.
    fn move_wood(&mut self, context: &Context) -> Result<Option<News>, Failure> {
        let setting = self.scene.with_hand();
        // The part of the whole that this frame is.
        let frames = self.recording.frames().map_or(0, |f| f.count()) as f64;
        let all = (setting.duration * setting.frames_per_second).max(1.0) + 1.0;
        let part = |frames: f64| (frames / all).min(1.0);
        let context = &context.part(part(frames), part(frames + 1.0));
        let end = setting.duration - SAME_TIME;
        // After its last frame it ends: gone on with from there, it would not know how it stepped.
        let ask = || match time_of(&self.recording) < end {
            true => Wish::Rest,
            false => Wish::GoOn,
        };
        let listener = Listener {
            tell: &|_| {},
            ask: &ask,
        };
        let scene = (setting, self.meshes.clone());
        match run(scene, &self.recording, &listener, context)? {
            Ended::Over(outcome) => Ok(Some(News::Ended(Ok(outcome)))),
            Ended::Steered(_) | Ended::Resting => Ok(None),
        }
    }

    /// Cuts the wood along the faces that its end decided; returns whether that shows the run better than its rods.
    fn cut(&mut self, context: &Context) -> Result<bool, Failure> {
        let source: Arc<dyn RunSource> = Arc::new(self.recording.clone());
        let opening = &context.part(0.0, 0.2);
        let mut run = EndedRun::open(source, &self.meshes, self.scene.stem.clone(), opening)?;
        let film = run.film(&context.part(0.2, 1.0));
        self.ended = Some(run);
        let (film, best) = film?;
        self.artist.take_film(film, best);
        Ok(best)
    }

    fn steer(&mut self, by: [f64; 3]) -> Option<Answer> {
        let (hand, way) = self.scene.steer(time_of(&self.recording), by)?;
        Some(told(self.job.number, News::Steered(hand, way)))
    }

    fn draw(&mut self, number: usize, look: Look) -> Answer {
        let news = match self.artist.draw(number, look) {
            Ok(frame) => News::Frame(number, look, Box::new(frame)),
            Err(failure) => News::Ended(Err(failure)),
        };
        told(self.job.number, news)
    }

    fn take(&self, at_hand: u64, context: &Context) -> (Option<Answer>, Vec<HeldFile>) {
        let taken = match &self.ended {
            Some(run) => run.take(Some(at_hand), context),
            None => Err(Failure::new("the simulation has not ended")),
        };
        let (taken, files) = match taken.and_then(cross) {
            Ok((taken, files)) => (Ok(Box::new(taken)), files),
            Err(failure) => (Err(failure), Vec::new()),
        };
        (Some(Answer::Taken(self.job.number, taken)), files)
    }
}

/// A break that was taken, as it crosses to the page, and the file of its stem.
fn cross(taken: Taken) -> Result<(TakenFile, Vec<HeldFile>), Failure> {
    let request = RequestFile::default()
        .with_request(&taken.request)
        .to_toml();
    let Some(input) = taken.input else {
        return Ok((
            TakenFile {
                request,
                stem: None,
            },
            Vec::new(),
        ));
    };
    let Some(file) = &input.made else {
        return Err(Failure::new(
            "the stem of this simulation is no longer open: open its file again, and simulate it once more",
        ));
    };
    let seen = Seen {
        unbroken: unbroken(&input),
        has_z_up: input.has_z_up(),
        notes: input.notes.clone(),
    };
    let files = vec![HeldFile {
        name: STEM_FILE.to_owned(),
        bytes: file.to_vec(),
    }];
    let stem = Some(seen);
    Ok((TakenFile { request, stem }, files))
}

/// The name of the file of a stem that a scene made.
pub const STEM_FILE: &str = "stem.glb";
