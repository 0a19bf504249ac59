//! The simulation of a page: a worker of its own, which is asked for one frame after the other.

use super::helper::{Held, Helper, PATIENCE};
use super::news::{Inbox, JsFile, Wake};
use crate::model::engine::Failure;
use crate::model::messages::{Answer, Ask, AskedSimulation, SimulationAsk, TakenFile};
use crate::model::simulation::{Look, News, SimulationJob};
use crate::model::simulation_desk::STEM_FILE;
use crate::platform::{Done, WorkProgress};
use js_sys::{Array, Uint8Array};

/// A simulation and its worker.
#[derive(Default)]
pub struct Simulating {
    helper: Option<Helper>,
    number: u64,
    /// Whether it waits to be gone on with.
    rests: bool,
    /// Whether there is nothing left to do, or nobody who wants it.
    is_over: bool,
    paused: bool,
    /// Frames that it may go on by while it is paused.
    steps: usize,
}

/// What became of an answer.
pub enum Heard {
    /// It is to be passed on.
    Done(Done),
    /// There is nothing to pass on.
    Nothing,
    /// A break was taken of a stem that the scene made, which comes with it.
    Stem(Done, u64, JsFile),
}

impl Simulating {
    /// Begins another simulation, of an input whose files are held.
    pub fn begin(&mut self, job: SimulationJob, held: &Held, inbox: &Inbox, wake: &Wake) {
        // A worker that rests soon knows the run before, which the next one may go on from.
        if self.is_stuck() {
            self.helper = None;
        }
        let helper = (self.helper).get_or_insert_with(|| Helper::new(inbox, wake));
        let (input, place) = match &job.stem {
            Some((input, place)) => (input.id, Some(*place)),
            None => (0, None),
        };
        if input != 0 && helper.holds != input && held.input == input {
            let unit = held.unit.clone();
            helper.ask(&Ask::Hold { input, unit }, &held.files);
            helper.holds = input;
        }
        let asked = AskedSimulation {
            number: job.number,
            source: job.source,
            input,
            place,
            own: job.own,
            moved: job.moved,
        };
        helper.ask(&Ask::Simulation(SimulationAsk::Begin(asked)), &[]);
        (self.number, self.rests, self.is_over) = (job.number, false, false);
        (self.paused, self.steps) = (false, 0);
    }

    fn is_stuck(&self) -> bool {
        let helper = self.helper.as_ref();
        !self.rests && helper.is_some_and(|h| h.works_longer_than(PATIENCE))
    }

    fn ask(&mut self, ask: SimulationAsk) {
        if let Some(helper) = &mut self.helper {
            helper.ask(&Ask::Simulation(ask), &[]);
        }
    }

    /// Asks for the next frame, if that is wanted.
    fn go_on(&mut self) {
        if !self.rests || self.is_over || self.paused && self.steps == 0 {
            return;
        }
        self.rests = false;
        self.steps = self.steps.saturating_sub(1);
        self.ask(SimulationAsk::GoOn);
    }

    /// Holds it after its present frame, or lets it go on.
    pub fn pause(&mut self, paused: bool) {
        (self.paused, self.steps) = (paused, 0);
        self.go_on();
    }

    /// Lets it go on to its next frame.
    pub fn step(&mut self) {
        self.steps += 1;
        self.go_on();
    }

    /// Has its hand pull elsewhere from its present frame on.
    pub fn steer(&mut self, by: [f64; 3]) {
        self.ask(SimulationAsk::Steer(by));
        self.step();
    }

    /// Asks for a frame as it is drawn; returns why there will be none.
    pub fn draw(&mut self, frame: usize, look: Look) -> Option<Done> {
        if self.helper.is_none() {
            let failure =
                Failure::new("what was recorded ended with its worker: simulate it again");
            return Some(self.ended_by(failure));
        }
        self.ask(SimulationAsk::Draw(frame, look));
        None
    }

    /// Asks for the break that it left.
    pub fn take(&mut self, at_hand: u64) {
        self.ask(SimulationAsk::Take(at_hand));
    }

    fn ended_by(&self, failure: Failure) -> Done {
        Done::Simulated(self.number, News::Ended(Err(failure)))
    }

    /// Stops it after its present frame: its worker is ended where that takes long. What was recorded can be drawn.
    pub fn cancel(&mut self) -> Option<Done> {
        if self.is_over {
            return None;
        }
        self.is_over = true;
        if let Some(helper) = &mut self.helper {
            helper.at = None;
        }
        Some(self.ended_by(Failure::cancelled()))
    }

    /// Ends the worker of a simulation that was stopped and goes on with a frame for long.
    pub fn give_up(&mut self) {
        if self.is_over && self.is_stuck() {
            self.helper = None;
        }
    }

    /// How far it is.
    pub fn progress(&self) -> Option<WorkProgress> {
        self.helper.as_ref()?.at.clone()
    }

    /// Whether the worker of a number is its own.
    pub fn is_by(&self, worker: u64) -> bool {
        self.helper.as_ref().is_some_and(|h| h.number == worker)
    }

    /// Hears an answer of its worker.
    pub fn hear(&mut self, answer: Answer, message: &Array) -> Heard {
        let Some(helper) = &mut self.helper else {
            return Heard::Nothing;
        };
        match answer {
            Answer::Ready => helper.is_ready(),
            Answer::Progress { stage, overall } if !self.is_over => helper.progress(stage, overall),
            Answer::Fault(text) => helper.fault = Some(text),
            Answer::Simulated(number, news) if number == self.number => {
                return Heard::Done(Done::Simulated(number, *news));
            }
            Answer::Rested(number, is_over) if number == self.number => {
                self.rests = true;
                self.is_over |= is_over;
                if self.is_over {
                    helper.rests();
                }
                self.go_on();
            }
            Answer::Taken(number, taken) if number == self.number => {
                helper.rests();
                return taken_file(number, taken, message);
            }
            _ => {}
        }
        Heard::Nothing
    }

    /// Hears that its worker ended by itself.
    pub fn ended(&mut self, error: &str) -> Option<Done> {
        let helper = self.helper.take()?;
        (self.is_over, self.rests) = (true, true);
        Some(self.ended_by(Failure::new(helper.why(error))))
    }
}

fn taken_file(number: u64, taken: Result<Box<TakenFile>, Failure>, message: &Array) -> Heard {
    let file = (message.length() > 1).then(|| Uint8Array::from(message.get(1)));
    let bytes = file.as_ref().map(|f| f.to_vec()).unwrap_or_default();
    let taken = taken.and_then(|t| t.taken(bytes));
    let stem = taken.as_ref().ok().and_then(|t| Some(t.input.as_ref()?.id));
    let done = Done::Simulated(number, News::Taken(taken.map(Box::new)));
    match (stem, file) {
        (Some(id), Some(bytes)) => {
            let name = STEM_FILE.to_owned();
            Heard::Stem(done, id, JsFile { name, bytes })
        }
        _ => Heard::Done(done),
    }
}
