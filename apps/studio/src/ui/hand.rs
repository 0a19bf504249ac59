//! Pulling on the wood of a simulation: a drag over it, at its first frame, is a hand that takes hold there and pulls.

use super::colours::ACCENT;
use super::holds::along;
use super::labels::paint_label;
use super::simulation_view::{Grabbed, SimulationView, Waiting};
use super::studio::Studio;
use crate::model::engine::Failure;
use crate::model::hand::{Grip, HandPlace, LEAST_PULL, grip_at, pulled_to, steered_on_way};
use crate::model::holds::{Hold, HoldPart, Moved, hand_of};
use crate::model::simulation::Source;
use crate::view::pick::pick;
use eframe::egui::{self, Color32, Painter, Pos2, Rect, Stroke, Ui, Vec2};
use glam::Vec3;

/// What a drag for the hand is called among the steps.
const STEP: &str = "pull";
/// A drag is along the stem where the cosine of the angle between them in the picture is greater: 20°.
const ALONG: f32 = 0.94;
/// By which part of the stem's length its direction in the picture is measured, and the points of the window that this must be: one
/// who looks along the stem cannot drag along it.
const BESIDE: f32 = 0.1;
const SEEN: f32 = 12.0;
/// Points of the curve that shows how the wood bends.
const CURVE: u16 = 24;

/// A displacement in the axes of a scene as it is drawn: its z is up, and of the picture y.
fn drawn([x, y, z]: [f64; 3]) -> Vec3 {
    glam::DVec3::new(x, z, -y).as_vec3()
}

/// A displacement of the picture in the axes of the scene.
fn of_scene(drawn: Vec3) -> [f64; 3] {
    let [x, y, z] = drawn.as_dvec3().to_array();
    [x, -z, y]
}

impl SimulationView {
    /// The length of the stem as it is drawn, m.
    fn stem_length(&self) -> f32 {
        self.axis.windows(2).map(|p| p[0].distance(p[1])).sum()
    }

    pub(super) fn hand(&self) -> Option<&Hold> {
        self.holds.iter().find(|h| h.part == HoldPart::Hand)
    }

    /// Where the hand pulls to, in the picture.
    pub(super) fn hand_end(&self) -> Option<Vec3> {
        let hand = self.hand()?;
        Some(along(&self.axis, hand.at)? + drawn(hand.by) * self.stem_length())
    }

    /// Where the hand is in the frame that is shown, in the picture.
    pub(super) fn hand_now(&self) -> Option<Vec3> {
        let time = *self.recorded.times.get(self.shown?.0)?;
        let off = |place: &&HandPlace| (place.0 - time).abs();
        let places = self.hand_way.iter();
        let nearest = places.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        Some(along(&self.axis, self.hand()?.at)? + drawn(nearest.1) * self.stem_length())
    }

    /// Where the hand is on its way to in the frame that is shown, in the picture: while it is held, to where it is dragged.
    fn pulled_to(&self) -> Option<Vec3> {
        if self.waited.is_some() {
            return self.hand_end();
        }
        let hand = hand_of(&self.simulated)?;
        let time = *self.recorded.times.get(self.shown?.0)?;
        let by = pulled_to(&self.hand_way, &hand, time);
        Some(along(&self.axis, hand.at)? + drawn(by) * self.stem_length())
    }

    /// Whether the hand pulls along the stem; it goes on so when it is steered.
    fn pulls_along(&self) -> bool {
        let hand = self.hand();
        hand.is_some_and(|h| h.before.first().map_or(h.by, |s| s.by)[0] != 0.0)
    }

    /// Takes note that the hand was steered elsewhere.
    pub(super) fn steered(&mut self, hand: Moved, way: Vec<HandPlace>) {
        self.hand_way = way;
        for hold in self.holds.iter_mut().filter(|h| h.part == HoldPart::Hand) {
            (hold.by, hold.before) = (hand.by, hand.before.clone());
        }
        self.simulated = self.holds.iter().map(Moved::from).collect();
    }
}

impl Studio {
    /// Begins to pull on the stem at hand, or switches pulling on and off in the simulation that is looked at.
    pub(super) fn toggle_pulling(&mut self) {
        let Some(simulation) = &mut self.simulation else {
            return self.begin_pulling();
        };
        if let (Err(problem), false) = (&simulation.can_pull, simulation.pulls) {
            let failure = Failure::new(problem);
            return self.fail(&failure);
        }
        simulation.pulls ^= true;
        self.say_how_to_pull();
    }

    fn begin_pulling(&mut self) {
        if !self.project.input.is_mesh() {
            let problem = "A scan has no bark yet that could be pulled on. Export its bark as a mesh, and open that.";
            return self.fail(&Failure::new(problem));
        }
        self.begin_simulation(Source::ByHand, true);
        self.say_how_to_pull();
    }

    pub(super) fn say_how_to_pull(&mut self) {
        let pulls = self.simulation.as_ref().is_some_and(|s| s.pulls);
        self.said = match pulls {
            true => "Drag the wood to pull on it; beside it a drag turns the picture.".to_owned(),
            false => String::new(),
        };
    }

    /// Whether a press at a point of the window is one on wood that is to be pulled.
    fn is_on_pulled_wood(&self, rect: Rect, pos: Pos2) -> bool {
        let simulation = self.simulation.as_ref().filter(|s| s.pulls);
        let drawn = simulation.and_then(|s| s.drawn.as_ref());
        drawn.is_some_and(|d| pick(&d.1, self.ray_at(rect, pos), None).is_some())
    }

    /// Has the run wait while its hand is held, `beside` the pointer, to be steered elsewhere.
    pub(super) fn hold_run(&mut self, beside: Vec2) {
        if self.steered_scene().is_none() {
            return;
        }
        let live = self.is_live();
        let Some(simulation) = &mut self.simulation else {
            return;
        };
        simulation.beside = beside;
        if live {
            let paused = simulation.paused;
            simulation.waited = Some(Waiting::Live { paused });
            simulation.paused = true;
            simulation.playback.follows = true;
            self.platform.pause_simulation(true);
        } else {
            let shown = simulation.shown.map_or(0, |s| s.0);
            simulation.waited = Some(Waiting::Frame(shown));
            simulation.playback.go(shown, simulation.frames());
        }
    }

    /// Lets the run go on, with the hand where it was let go, from the frame in which it was taken hold of. Returns whether it waited.
    pub(super) fn steer_run(&mut self) -> bool {
        let Some(simulation) = &mut self.simulation else {
            return false;
        };
        let Some(waited) = simulation.waited.take() else {
            return false;
        };
        simulation.held = None;
        simulation.history.rest();
        let Some(by) = simulation.hand().map(|h| h.by) else {
            return true;
        };
        match waited {
            Waiting::Live { paused } if simulation.outcome.is_none() => {
                simulation.paused = paused;
                self.platform.steer_simulation(by);
                if !paused {
                    self.platform.pause_simulation(false);
                }
            }
            // The run may have ended meanwhile.
            Waiting::Live { .. } => self.steer_from(usize::MAX, by),
            Waiting::Frame(number) => self.steer_from(number, by),
        }
        self.said = "The hand pulls there from this frame on.".to_owned();
        true
    }

    /// Moves the wood anew from a frame that was recorded on, with the hand on its way to another place.
    fn steer_from(&mut self, number: usize, by: [f64; 3]) {
        let Some(simulation) = &mut self.simulation else {
            return;
        };
        let times = &simulation.recorded.times;
        let time = times.get(number).or(times.last()).copied();
        let before = hand_of(&simulation.simulated);
        let (Some(time), Some(before)) = (time, before) else {
            return;
        };
        let next = steered_on_way(&simulation.hand_way, &before, time, by);
        for hold in simulation
            .holds
            .iter_mut()
            .filter(|h| h.part == HoldPart::Hand)
        {
            (hold.by, hold.before) = (next.by, next.before.clone());
        }
        self.simulate_again();
    }

    /// Takes hold of the wood under the pointer, where that is asked for. A drag that cannot pull does nothing else either.
    pub(super) fn take_hold(&mut self, rect: Rect, pos: Pos2) -> Option<Grabbed> {
        if !self.is_on_pulled_wood(rect, pos) {
            return None;
        }
        if self.steered_scene().is_some() {
            // Wherever the wood is dragged, the hand goes along.
            let dot = self.hold_dot(HoldPart::Hand)?;
            self.hold_run(dot - pos);
            return Some(Grabbed::Part(HoldPart::Hand));
        }
        let simulation = self.simulation.as_mut()?;
        if simulation.shown.is_none_or(|s| s.0 != 0) {
            self.said = "This is the first frame again: drag the wood to pull on it.".to_owned();
            simulation.playback.go(0, simulation.frames());
            return Some(Grabbed::Nothing);
        }
        let at = self.fraction_at(rect, pos)?;
        let simulation = self.simulation.as_mut()?;
        match grip_at(&simulation.holds, at) {
            Err(problem) => {
                self.said = problem;
                Some(Grabbed::Nothing)
            }
            Ok(grip) => {
                let SimulationView { history, holds, .. } = simulation;
                history.note(STEP, holds, true);
                holds.retain(|h| h.part != HoldPart::Hand);
                holds.push(Hold {
                    part: HoldPart::Hand,
                    name: "hand".to_owned(),
                    at: grip.at,
                    by: [0.0; 3],
                    before: Vec::new(),
                });
                Some(Grabbed::Part(HoldPart::Hand))
            }
        }
    }

    /// Drags the hand to a point of the window: along the stem where the drag goes along it in the picture, else in the plane through
    /// where it took hold that faces the camera.
    pub(super) fn drag_hand(&mut self, rect: Rect, pos: Pos2) {
        let steers = self.simulation.as_ref().filter(|s| s.waited.is_some());
        let pos = pos + steers.map_or(Vec2::ZERO, |s| s.beside);
        let (origin, direction) = self.ray_at(rect, pos);
        let facing = self.camera.backward();
        let along_stem = match steers {
            // What the hand holds the wood across or along was decided when it took hold.
            Some(simulation) => simulation.pulls_along(),
            None => self.is_along_stem(rect, pos),
        };
        let Some(simulation) = &mut self.simulation else {
            return;
        };
        let length = simulation.stem_length();
        let Some(hand) = simulation.hand().cloned() else {
            return;
        };
        let (Some(start), Ok(grip)) = (
            along(&simulation.axis, hand.at),
            grip_at(&simulation.holds, hand.at),
        ) else {
            return;
        };
        let steers = simulation.waited.is_some();
        let now = simulation.hand_now().filter(|_| steers).unwrap_or(start);
        let way = if along_stem {
            // The point of the line along the stem that is nearest to the ray.
            let flat = Vec3::X - direction * direction.x;
            Vec3::X * ((origin - start).dot(flat) / flat.x)
        } else {
            let depth = (now - origin).dot(facing) / direction.dot(facing);
            let [_, y, z] = (origin + direction * depth - start).to_array();
            Vec3::new(0.0, y, z)
        };
        if !way.is_finite() || length <= 0.0 {
            return;
        }
        let by = grip.pull(of_scene(way / length));
        if by != hand.by {
            let SimulationView { history, holds, .. } = simulation;
            history.note(STEP, holds, true);
            let hand = holds.iter_mut().find(|h| h.part == HoldPart::Hand);
            if let Some(hand) = hand {
                hand.by = by;
                if !steers {
                    hand.before.clear();
                }
            }
        }
    }

    /// Whether the way from where the hand took hold to a point of the window goes along the stem, as it is seen.
    fn is_along_stem(&self, rect: Rect, pos: Pos2) -> bool {
        let ways = || {
            let simulation = self.simulation.as_ref()?;
            let hand = simulation.hand()?;
            let start = along(&simulation.axis, hand.at)?;
            let beside = start + Vec3::X * (BESIDE * simulation.stem_length());
            let from = self.in_window(rect, start)?;
            Some((pos - from, self.in_window(rect, beside)? - from))
        };
        ways().is_some_and(|(way, stem)| {
            way.dot(stem).abs() > ALONG * way.length() * stem.length() && stem.length() > SEEN
        })
    }

    /// The hand is let go: one that hardly moved is none.
    pub(super) fn let_go_of_hand(&mut self) {
        let Some(simulation) = &mut self.simulation else {
            return;
        };
        let by = simulation.hand().map_or([0.0; 3], |h| h.by);
        if glam::DVec3::from_array(by).length() < LEAST_PULL {
            simulation.history.drop_step(&mut simulation.holds);
            self.say_how_to_pull();
        }
    }

    /// Draws the hand: where it took hold, where it pulls to, and how the wood would bend there if it did not break.
    pub(super) fn paint_hand(&self, painter: &Painter, rect: Rect, simulation: &SimulationView) {
        let Some(hand) = simulation.hand() else {
            return;
        };
        let (Some(start), Some(end)) = (along(&simulation.axis, hand.at), simulation.hand_end())
        else {
            return;
        };
        if simulation.shown.is_some_and(|s| s.0 > 0) {
            let end = simulation.pulled_to().unwrap_or(end);
            return self.paint_steered_hand(painter, rect, simulation, end);
        }
        let grip = grip_at(&simulation.holds, hand.at).ok();
        if let Some(curve) = grip.and_then(|g| self.bent(rect, simulation, &g, end - start)) {
            let shade = Color32::from_rgba_unmultiplied(ACCENT.r(), ACCENT.g(), ACCENT.b(), 110);
            painter.line(curve, Stroke::new(3.0, shade));
        }
        if let (Some(from), Some(to)) = (self.in_window(rect, start), self.in_window(rect, end)) {
            painter.circle_stroke(from, 4.0, Stroke::new(1.5, ACCENT));
            painter.arrow(from, to - from, Stroke::new(2.0, ACCENT));
        }
    }

    /// Draws the hand of a run that goes on: where it is, and, while it is held, where it will pull to.
    fn paint_steered_hand(
        &self,
        painter: &Painter,
        rect: Rect,
        simulation: &SimulationView,
        end: Vec3,
    ) {
        let now = simulation
            .hand_now()
            .and_then(|now| self.in_window(rect, now));
        let (Some(from), Some(to)) = (now, self.in_window(rect, end)) else {
            return;
        };
        let held = simulation.waited.is_some();
        painter.circle(from, 5.5, ACCENT, Stroke::new(1.0, Color32::BLACK));
        let alpha = if held { 255 } else { 90 };
        let shade = Color32::from_rgba_unmultiplied(ACCENT.r(), ACCENT.g(), ACCENT.b(), alpha);
        painter.arrow(from, to - from, Stroke::new(2.0, shade));
        if let (true, Some(hand)) = (held, simulation.hand()) {
            paint_label(painter, to, self.hand_text(simulation, hand), ACCENT);
        }
    }

    /// The axis of the wood as a cantilever's, with its end moved by `by`.
    fn bent(
        &self,
        rect: Rect,
        simulation: &SimulationView,
        grip: &Grip,
        by: Vec3,
    ) -> Option<Vec<Pos2>> {
        let root = grip.root?;
        let points = (0..=CURVE).map(|k| {
            let at = root + (grip.at - root) * f64::from(k) / f64::from(CURVE);
            let place = along(&simulation.axis, at)?;
            self.in_window(rect, place + by * grip.share(at)? as f32)
        });
        points.collect()
    }

    /// What the hand does, beside its dot.
    pub(super) fn hand_text(&self, simulation: &SimulationView, hand: &Hold) -> String {
        let way = glam::DVec3::from_array(hand.by).length() * f64::from(simulation.stem_length());
        format!(
            "hand, at {:.3}, pulls {}",
            hand.at,
            self.settings.unit.text(way)
        )
    }

    /// The switch of pulling in the header.
    pub(super) fn pull_switch(&mut self, ui: &mut Ui) {
        let mut pulls = self.simulation.as_ref().is_some_and(|s| s.pulls);
        let before = pulls;
        ui.toggle_value(&mut pulls, "Pull")
            .on_hover_text("A drag over the wood pulls on it: at the first frame where the drag begins, later on with the hand that is there (L).");
        if pulls != before {
            self.toggle_pulling();
        }
    }

    /// Shows that the wood under the pointer can be taken hold of.
    pub(super) fn point_at_wood(&self, ui: &Ui, rect: Rect, response: &egui::Response) {
        let still = ui.input(|i| !i.pointer.any_down());
        let pos = response.hover_pos().filter(|_| still);
        if pos.is_some_and(|pos| self.is_on_pulled_wood(rect, pos)) {
            ui.ctx().set_cursor_icon(egui::CursorIcon::Grab);
        }
    }
}
