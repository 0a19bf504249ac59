//! A simulation as the window sees it: what is asked, what is told, and where its playback is. Knows nothing of rods.

use super::engine::Failure;
use super::hand::HandPlace;
use super::holds::{Hold, Moved};
use super::input::Input;
use super::meshes::DrawnScene;
use glam::Vec3;
use greenstick::BreakRequest;
use greenstick::formats::LengthUnit;
use greenstick::wood::stem::StemLocation;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A scene that comes with the program.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneEntry {
    /// Its name.
    pub name: String,
    /// What it shows, in a sentence.
    pub about: String,
    /// How long it lasts, s.
    pub duration: f64,
}

/// What is simulated.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Source {
    /// A scene that comes with the program, by its name.
    BuiltIn(String),
    /// A scene file.
    File(String),
    /// The folder of a run that was recorded.
    Run(String),
    /// A stem that is held at its base, to be pulled on by hand.
    ByHand,
}

impl Source {
    /// What headings call it.
    pub fn title(&self) -> &str {
        match self {
            Source::BuiltIn(name) => name,
            Source::ByHand => "pulled by hand",
            Source::File(path) | Source::Run(path) => {
                path.rsplit(['/', '\\']).next().unwrap_or(path)
            }
        }
    }
}

/// A simulation that is asked for.
#[derive(Debug, Clone)]
pub struct SimulationJob {
    /// Its number, by which it is told of.
    pub number: u64,
    /// What is simulated.
    pub source: Source,
    /// The stem at hand, and the place of its break.
    pub stem: Option<(Input, StemLocation)>,
    /// Whether the scene is put on that stem in place of its own. One whose stem is an input is in any case.
    pub own: bool,
    /// Parts of the scene that are elsewhere along its stem, and the hand that pulls on it.
    pub moved: Vec<Moved>,
}

/// How a frame is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Look {
    /// As the rods that are moved.
    Rods,
    /// As wood, cut along the faces that the end of the run decided.
    Wood,
    /// As what shows the run best: the whole wood before its first break, then rods, and where the end of the run decided faces that
    /// show it well, wood.
    Best,
}

/// A curve of a chart.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Its name.
    pub name: String,
    /// Its points.
    pub points: Vec<[f64; 2]>,
}

/// Joules, newtons and metres below which a curve is rounding.
const NOTHING: f64 = 1e-15;

/// A chart.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Chart {
    /// What its axes measure, with units.
    pub axes: [String; 2],
    /// Its curves.
    pub lines: Vec<Line>,
}

impl Chart {
    /// The smallest and greatest coordinates, 0 being among the heights; none without points.
    pub fn bounds(&self) -> Option<[[f64; 2]; 2]> {
        let points = || self.lines.iter().flat_map(|l| &l.points);
        let all = || points().filter(|p| p[0].is_finite() && p[1].is_finite());
        let first = all().next()?;
        let (mut low, mut high) = ([first[0], 0.0], [first[0], 0.0]);
        for [x, y] in all() {
            low = [low[0].min(*x), low[1].min(*y)];
            high = [high[0].max(*x), high[1].max(*y)];
        }
        // What does not move is still a range, and what rounding leaves of nothing is nothing.
        for (high, low) in high.iter_mut().zip(&mut low) {
            if *high - *low <= NOTHING {
                if low.abs() <= NOTHING {
                    *low = 0.0;
                }
                *high = *low + 1.0;
            }
        }
        Some([low, high])
    }
}

/// What is recorded so far.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Recorded {
    /// Times of the frames, s.
    pub times: Vec<f64>,
    /// Load over deflection.
    pub load: Chart,
    /// Energies over time.
    pub energy: Chart,
}

/// How a simulation ended.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// What became of the wood: names and values.
    pub facts: Vec<(String, String)>,
    /// The whole report.
    pub report: String,
    /// Whether a break can be taken from it.
    pub broke: bool,
}

/// A break that was taken from a simulation.
#[derive(Debug)]
pub struct Taken {
    /// The request that breaks the stem along the faces of the run.
    pub request: BreakRequest,
    /// The stem, where it is not the one at hand.
    pub input: Option<Input>,
    /// The unit of length in its file, where one was named.
    pub unit: Option<LengthUnit>,
}

/// A frame as it is drawn.
#[derive(Debug, Serialize, Deserialize)]
pub struct DrawnFrame {
    /// The meshes.
    pub scene: DrawnScene,
    /// Radius of the sphere about the middle that held everything before it moved, m: what flies off does not count.
    pub rest_radius: f64,
    /// The axis of the stem before it moved, in even steps.
    #[serde(with = "super::wire::axis")]
    pub axis: Arc<Vec<Vec3>>,
}

/// What is known of a simulation when it begins.
#[derive(Debug, Serialize, Deserialize)]
pub struct Begun {
    /// What its scene shows, in a sentence.
    pub about: String,
    /// What stands along its stem.
    pub holds: Vec<Hold>,
    /// Whether a hand can pull on its wood, or why not.
    pub pull: Result<(), String>,
    /// The way of the hand, frame by frame; empty where there is none.
    pub hand_way: Vec<HandPlace>,
}

/// What is told of a simulation.
#[derive(Debug, Serialize, Deserialize)]
pub enum News {
    /// It begins.
    Begun(Begun),
    /// The hand was steered elsewhere: what it does now, and its way.
    Steered(Moved, Vec<HandPlace>),
    /// There is more of it.
    Recorded(Recorded),
    /// It ended.
    Ended(Result<Outcome, Failure>),
    /// It can be drawn as wood, or why it cannot. The third value says whether that shows the run best.
    Wood(Result<bool, String>),
    /// A frame as it is drawn.
    Frame(usize, Look, Box<DrawnFrame>),
    /// The break that it left.
    #[serde(skip)]
    Taken(Result<Box<Taken>, Failure>),
}

/// Frames that are played each second.
const FRAMES_PER_SECOND: f64 = 24.0;

/// Where the playback is.
#[derive(Debug, Clone, PartialEq)]
pub struct Playback {
    /// The frame that is shown.
    pub at: usize,
    /// Whether it plays.
    pub playing: bool,
    /// Whether it stays with the last frame while there are more and more.
    pub follows: bool,
    /// How many times faster it plays than 24 frames a second.
    pub speed: f64,
    /// Seconds since the frame that is shown was due.
    over: f64,
}

impl Default for Playback {
    fn default() -> Self {
        Playback {
            at: 0,
            playing: false,
            follows: true,
            speed: 1.0,
            over: 0.0,
        }
    }
}

impl Playback {
    /// Takes note that there are `count` frames now.
    pub fn recorded(&mut self, count: usize) {
        let last = count.saturating_sub(1);
        self.at = if self.follows {
            last
        } else {
            self.at.min(last)
        };
    }

    /// Goes on by some seconds of `count` frames; stops at the last one.
    pub fn advance(&mut self, seconds: f64, count: usize) {
        if !self.playing {
            return;
        }
        let step = 1.0 / (FRAMES_PER_SECOND * self.speed.max(1e-3));
        self.over += seconds.max(0.0);
        let due = (self.over / step).floor();
        self.over -= due * step;
        let last = count.saturating_sub(1);
        self.at = self.at.saturating_add(due as usize).min(last);
        if self.at == last {
            self.playing = false;
        }
    }

    /// Plays, from the start where it is at the end, or pauses.
    pub fn toggle(&mut self, count: usize) {
        self.playing = !self.playing;
        (self.follows, self.over) = (false, 0.0);
        if self.playing && self.at + 1 >= count {
            self.at = 0;
        }
    }

    /// Goes to a frame and stays there.
    pub fn go(&mut self, at: usize, count: usize) {
        let last = count.saturating_sub(1);
        self.at = at.min(last);
        (self.playing, self.follows) = (false, false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn playback_shows_every_frame_in_its_time() {
        let mut playback = Playback::default();
        playback.recorded(30);
        assert_eq!(playback.at, 29);
        playback.toggle(30);
        assert_eq!((playback.at, playback.playing), (0, true));
        // Half a second in uneven steps is 12 frames.
        for seconds in [0.1, 0.017, 0.2, 0.083, 0.1001] {
            playback.advance(seconds, 30);
        }
        assert_eq!(playback.at, 12);
        playback.speed = 0.25;
        playback.advance(0.5, 30);
        assert_eq!(playback.at, 15);
        // More frames do not move what is looked at.
        playback.recorded(40);
        assert_eq!(playback.at, 15);
        playback.advance(1e6, 40);
        assert_eq!((playback.at, playback.playing), (39, false));
        playback.go(70, 40);
        assert_eq!(playback.at, 39);
    }

    #[test]
    fn a_chart_has_room_for_all_of_its_points() {
        let line = |points: &[[f64; 2]]| Line {
            name: String::new(),
            points: points.to_vec(),
        };
        let chart = Chart {
            lines: vec![line(&[[1.0, 4.0], [f64::NAN, 9.0]]), line(&[[3.0, -2.0]])],
            ..Chart::default()
        };
        assert_eq!(chart.bounds(), Some([[1.0, -2.0], [3.0, 4.0]]));
        let flat = Chart {
            lines: vec![line(&[[0.5, 0.0]])],
            ..Chart::default()
        };
        assert_eq!(flat.bounds(), Some([[0.5, 0.0], [1.5, 1.0]]));
        let rounding = Chart {
            lines: vec![line(&[[0.0, 4e-23], [1.0, -1e-23]])],
            ..Chart::default()
        };
        assert_eq!(rounding.bounds(), Some([[0.0, 0.0], [1.0, 1.0]]));
        assert_eq!(Chart::default().bounds(), None);
    }
}
