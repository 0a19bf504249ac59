//! The scene of a simulation that is asked for: put on the stem at hand, with its parts where they were moved and with the hand that
//! pulls; and what a run that was simulated before has in common with it.

use super::engine::Failure;
use super::hand::{BY_HAND, HandPlace, add_hand, can_pull, hand_way, steered};
use super::holds::{Moved, hand_of, holds_of, move_holds};
use super::recording::Recording;
use super::simulated::{RunStem, put_on};
use super::simulation::{Begun, SimulationJob, Source};
use greenstick::fibre::scene::{Scene as Setting, StemChoice};
use greenstick::geometry::Scene as Meshes;

/// The scene of a source that comes with the program.
///
/// # Errors
/// Where no scene has that name, or it is in a file.
pub fn own_setting(source: &Source) -> Result<Setting, Failure> {
    match source {
        Source::BuiltIn(name) => Setting::built_in(name).map_err(Failure::new),
        Source::ByHand => Setting::read(BY_HAND).map_err(Failure::new),
        Source::File(name) | Source::Run(name) => Err(Failure::new(format!(
            "{name}: scene files and recorded runs are simulated by the program, not by its page"
        ))),
    }
}

/// The scene of a job.
pub struct JobScene {
    /// The scene, with its parts where they were moved, without the hand.
    pub setting: Setting,
    /// The hand.
    pub hand: Option<Moved>,
    /// The stem at hand, where the scene is put on that.
    pub stem: Option<RunStem>,
    /// The meshes that the scene is put on.
    pub input: Option<Meshes>,
}

impl JobScene {
    /// That of a job whose scene, as it comes, is `setting`; also returns what a window needs to know of it.
    ///
    /// # Errors
    /// Where it cannot be put on the stem at hand.
    pub fn new(mut setting: Setting, job: &SimulationJob) -> Result<(Self, Begun), Failure> {
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
        let scene = JobScene {
            setting,
            hand,
            stem,
            input,
        };
        Ok((scene, begun))
    }

    /// Has a stem that waits for a hand rest: nothing moves before a hand does.
    pub fn wait_for_hand(&mut self, source: &Source) {
        if *source == Source::ByHand && self.hand.is_none() {
            self.setting.duration = 0.0;
        }
    }

    /// Steers the hand elsewhere from a time (s) on; returns what it does now, and its way, where there is one.
    pub fn steer(&mut self, time: f64, by: [f64; 3]) -> Option<(Moved, Vec<HandPlace>)> {
        let hand = self.hand.as_mut()?;
        *hand = steered(&self.setting, hand, time, by);
        Some((hand.clone(), hand_way(&self.setting, hand)))
    }

    /// What is simulated: the scene with its hand.
    pub fn with_hand(&self) -> Setting {
        let mut setting = self.setting.clone();
        if let Some(hand) = &self.hand {
            add_hand(&mut setting, hand);
        }
        setting
    }
}

/// A run whose states are kept, so that one which begins as it did can go on from there.
pub struct KeptRun {
    /// What was asked for.
    pub job: SimulationJob,
    /// Its scene, with the hand.
    pub setting: Setting,
    /// What is recorded of it.
    pub recording: Recording,
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

/// What the run of a scene (with the hand) begins with: the one before as far as it is the same, or nothing.
pub fn begun_before(before: Option<KeptRun>, job: &SimulationJob, setting: &Setting) -> Recording {
    let begun = before.and_then(|before| before.branch(job, setting));
    begun.unwrap_or_default()
}
