//! The simulation that is looked at, as the window knows it.

use crate::model::hand::HandPlace;
use crate::model::history::History;
use crate::model::holds::{Hold, HoldPart, Moved};
use crate::model::meshes::DrawnScene;
use crate::model::simulation::{Look, Outcome, Playback, Recorded, Source};
use crate::view::camera::Camera;
use eframe::egui::Vec2;
use glam::Vec3;
use std::sync::Arc;

/// What a drag began with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Grabbed {
    /// A part of the scene.
    Part(HoldPart),
    /// Wood that cannot be pulled there.
    Nothing,
}

/// What a run goes on from when its hand is let go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Waiting {
    /// Its last frame so far; `paused` says whether it waited before the hand was held.
    Live { paused: bool },
    /// A frame that was recorded.
    Frame(usize),
}

/// A simulation that is looked at.
pub struct SimulationView {
    /// Tells it apart from those before.
    pub number: u64,
    /// What is simulated.
    pub source: Source,
    /// Whether it is on the stem at hand.
    pub own: bool,
    /// What stands along the stem, where it is now, and the past and future of that.
    pub holds: Vec<Hold>,
    pub(super) history: History<Vec<Hold>>,
    /// Where it was when the simulation began.
    pub(super) simulated: Vec<Moved>,
    /// Whether a hand can pull on its wood, or why not, and whether a drag over the wood is one.
    pub(super) can_pull: Result<(), String>,
    pub(super) pulls: bool,
    /// Whether the run waits after its last frame.
    pub paused: bool,
    /// What the pointer holds while it is pressed.
    pub(super) held: Option<Grabbed>,
    /// While the hand of a run is held after its first frame: what it goes on from when it is let go.
    pub(super) waited: Option<Waiting>,
    /// How far the hand is from the pointer that holds it, points of the window.
    pub(super) beside: Vec2,
    /// The way of the hand, frame by frame.
    pub(super) hand_way: Vec<HandPlace>,
    /// The axis of the stem before it moved.
    pub(super) axis: Arc<Vec<Vec3>>,
    /// What its scene shows, in a sentence.
    pub about: String,
    /// What is recorded so far.
    pub recorded: Recorded,
    /// What became of the wood, once it ended.
    pub outcome: Option<Outcome>,
    /// Whether it can be drawn as wood, or why not; none while that is worked out.
    pub wood: Option<Result<(), String>>,
    /// How frames are drawn.
    pub look: Look,
    /// Where its playback is.
    pub playback: Playback,
    /// The frame that is being drawn.
    pub asked: Option<(usize, Look)>,
    /// The frame that is shown.
    pub shown: Option<(usize, Look)>,
    /// Whether the frame that is shown would be drawn otherwise by now.
    pub is_outdated: bool,
    /// The frame as the card draws it, with a number that tells it apart.
    pub drawn: Option<(u64, Arc<DrawnScene>)>,
    /// Radius of everything before it moved, m.
    pub rest_radius: f32,
    /// The camera as it was before.
    pub camera_before: Camera,
    /// Whether the break that it left is being taken.
    pub takes: bool,
    /// When the window last looked at its playback, s.
    pub seen: f64,
}

impl SimulationView {
    /// Number of frames so far.
    pub fn frames(&self) -> usize {
        self.recorded.times.len()
    }

    /// The frame that is to be shown, and how.
    pub(super) fn wanted(&self) -> (usize, Look) {
        (self.playback.at, self.look)
    }

    /// Whether it is shown so.
    pub(super) fn is_shown(&self) -> bool {
        self.shown == Some(self.wanted()) && !self.is_outdated
    }
}
