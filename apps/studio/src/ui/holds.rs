//! The handles of a simulation: clamps, forces and bodies are dragged along the stem at its first frame, a hand wherever it pulls to,
//! and the wood is moved anew.

use super::colours::ACCENT;
use super::dialogs::buttons;
use super::file_dialog::FileDialog;
use super::labels::paint_label;
use super::simulation_view::{Grabbed, SimulationView};
use super::studio::Studio;
use crate::model::holds::{HoldPart, Moved, dragged};
use crate::model::simulation::Source;
use eframe::egui::{self, Color32, CursorIcon, PointerButton, Pos2, Rect, Shape, Stroke, Ui, Vec2};

/// Radius of a dot, points, and of what takes hold of it.
const DOT: f32 = 5.5;
const HOLD: f32 = 11.0;
/// Steps along the stem in which the place under the pointer is looked for.
const STEPS: u16 = 400;

/// The point at a fraction of an axis.
pub(super) fn along(axis: &[glam::Vec3], at: f64) -> Option<glam::Vec3> {
    let last = axis.len().checked_sub(1)?;
    let place = at.clamp(0.0, 1.0) * last as f64;
    let low = (place.floor() as usize).min(last.saturating_sub(1));
    let high = axis.get(low + 1).unwrap_or(&axis[low]);
    Some(axis[low].lerp(*high, (place - low as f64) as f32))
}

impl Studio {
    /// The simulation whose handles are shown: a scene at its first frame. A run that was recorded is what it is.
    fn held_scene(&self) -> Option<&SimulationView> {
        let simulation = self.simulation.as_ref();
        let simulation = simulation.filter(|s| self.view.handles || s.pulls)?;
        let is_scene = !matches!(simulation.source, Source::Run(_));
        let is_first = simulation.shown.is_some_and(|s| s.0 == 0);
        (is_scene && is_first && simulation.axis.len() > 1).then_some(simulation)
    }

    fn axis_in_window(&self, rect: Rect, at: f64) -> Option<Pos2> {
        self.in_window(rect, along(&self.held_scene()?.axis, at)?)
    }

    /// The simulation whose hand can be steered elsewhere: from any frame but the first on.
    pub(super) fn steered_scene(&self) -> Option<&SimulationView> {
        let simulation = self
            .simulation
            .as_ref()
            .filter(|s| s.waited.is_some() || s.pulls)?;
        let is_later = simulation.shown.is_some_and(|s| s.0 > 0);
        let has_hand = !simulation.hand_way.is_empty() && simulation.hand().is_some();
        (is_later && has_hand && simulation.axis.len() > 1).then_some(simulation)
    }

    /// Where the dot of a part of the scene is in the window, where handles are shown.
    pub fn hold_dot(&self, part: HoldPart) -> Option<Pos2> {
        let rect = self.viewport_rect?;
        if let Some(simulation) = self.steered_scene() {
            let is_hand = part == HoldPart::Hand;
            return self.in_window(rect, simulation.hand_now().filter(|_| is_hand)?);
        }
        let simulation = self.held_scene()?;
        if part == HoldPart::Hand {
            return self.in_window(rect, simulation.hand_end()?);
        }
        let hold = simulation.holds.iter().find(|h| h.part == part)?;
        self.axis_in_window(rect, hold.at)
    }

    /// Where a fraction of the stem is in the window, where handles are shown.
    pub fn stem_place(&self, at: f64) -> Option<Pos2> {
        self.axis_in_window(self.viewport_rect?, at)
    }

    /// The part whose dot is at a point of the window.
    fn hold_part_at(&self, pos: Pos2) -> Option<HoldPart> {
        let simulation = self.held_scene().or_else(|| self.steered_scene())?;
        let parts = simulation.holds.iter().map(|h| h.part);
        let dots = parts.filter_map(|part| Some((part, self.hold_dot(part)?.distance(pos))));
        let near = dots.filter(|d| d.1 <= HOLD);
        near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|d| d.0)
    }

    /// The fraction of the stem that is nearest to a point of the window.
    pub(super) fn fraction_at(&self, rect: Rect, pos: Pos2) -> Option<f64> {
        let fractions = (0..=STEPS).map(|k| f64::from(k) / f64::from(STEPS));
        let seen = fractions.filter_map(|t| Some((t, self.axis_in_window(rect, t)?.distance(pos))));
        seen.min_by(|a, b| a.1.total_cmp(&b.1)).map(|s| s.0)
    }

    /// Drags a part of the scene along the stem; returns whether one is held. The wood is moved anew when it is let go.
    pub(super) fn drag_hold(&mut self, ui: &Ui, rect: Rect, response: &egui::Response) -> bool {
        let left = PointerButton::Primary;
        let (pressed, plain) = ui.input(|i| (i.pointer.press_origin(), i.modifiers.is_none()));
        if response.drag_started_by(left) {
            let pressed = pressed.filter(|_| plain);
            let held = pressed.and_then(|pos| match self.hold_part_at(pos) {
                None => self.take_hold(rect, pos),
                Some(part) => {
                    self.hold_run(Vec2::ZERO);
                    Some(Grabbed::Part(part))
                }
            });
            if let Some(simulation) = &mut self.simulation {
                simulation.held = held;
            }
        }
        let part = match self.simulation.as_ref().and_then(|s| s.held) {
            Some(Grabbed::Part(part)) => part,
            Some(Grabbed::Nothing) => return response.dragged_by(left),
            None => return false,
        };
        let pos = response.interact_pointer_pos();
        let at = pos.and_then(|pos| self.fraction_at(rect, pos));
        if !response.dragged_by(left) {
            if self.steer_run() {
                return false;
            }
            if part == HoldPart::Hand {
                self.let_go_of_hand();
            }
            if let Some(simulation) = &mut self.simulation {
                simulation.held = None;
                simulation.history.rest();
            }
            self.simulate_again();
            return false;
        }
        if let (HoldPart::Hand, Some(pos)) = (part, pos) {
            self.drag_hand(rect, pos);
            return true;
        }
        let Some(simulation) = &mut self.simulation else {
            return false;
        };
        if let Some(at) = at {
            let at = dragged(&simulation.holds, part, at);
            let hold = simulation.holds.iter().position(|h| h.part == part);
            if let Some(i) = hold.filter(|i| simulation.holds[*i].at != at) {
                let name = simulation.holds[i].name.clone();
                simulation.history.note(&name, &simulation.holds, true);
                simulation.holds[i].at = at;
            }
        }
        true
    }

    /// Takes the last change of the scene back, or makes it again. Returns whether there was one.
    pub(super) fn step_hold(&mut self, back: bool) -> bool {
        let Some(simulation) = &mut self.simulation else {
            return false;
        };
        let SimulationView { history, holds, .. } = simulation;
        let label = if back {
            history.undo(holds)
        } else {
            history.redo(holds)
        };
        let Some(label) = label else {
            return false;
        };
        self.said = match back {
            true => format!("Took back: {label}."),
            false => format!("Made again: {label}."),
        };
        self.simulate_again();
        true
    }

    /// What the next steps back and forward are.
    pub(super) fn step_labels(&self) -> [Option<String>; 2] {
        let own = &self.project.history;
        let [mut undo, mut redo] = [own.undo_label(), own.redo_label()];
        if let Some(simulation) = &self.simulation {
            undo = simulation.history.undo_label().or(undo);
            redo = simulation.history.redo_label().or(redo);
        }
        [undo, redo].map(|label| label.map(str::to_owned))
    }

    /// The places of the parts of the scene.
    fn moved(&self) -> Vec<Moved> {
        let holds = self.simulation.iter().flat_map(|s| &s.holds);
        holds.map(Moved::from).collect()
    }

    /// Begins the simulation again where its parts are now, and looks at it from where it was looked at.
    pub(super) fn simulate_again(&mut self) {
        let moved = self.moved();
        let Some(mut before) = self.simulation.take() else {
            return;
        };
        if before.simulated == moved {
            self.simulation = Some(before);
            return;
        }
        let (source, own, camera) = (before.source.clone(), before.own, before.camera_before);
        let pulls = before.pulls;
        self.begin_simulation_at(source, own, moved);
        if let Some(simulation) = &mut self.simulation {
            simulation.camera_before = camera;
            simulation.pulls = pulls;
            simulation.holds = std::mem::take(&mut before.holds);
            simulation.history = std::mem::take(&mut before.history);
            simulation.axis = std::mem::take(&mut before.axis);
            simulation.about = std::mem::take(&mut before.about);
            simulation.look = before.look;
            simulation.playback.speed = before.playback.speed;
            // What is drawn stays until there is a frame.
            simulation.drawn = before.drawn.take();
            simulation.rest_radius = before.rest_radius;
        }
    }

    /// Draws what holds, pushes and pulls the stem, and the dots that are dragged.
    pub(super) fn paint_holds(&self, ui: &Ui, rect: Rect, response: &egui::Response) {
        let Some(simulation) = self.held_scene().or_else(|| self.steered_scene()) else {
            return;
        };
        let painter = ui.painter_at(rect);
        let over = match simulation.held {
            Some(Grabbed::Part(part)) => Some(part),
            Some(Grabbed::Nothing) => None,
            None => response.hover_pos().and_then(|p| self.hold_part_at(p)),
        };
        self.paint_hand(&painter, rect, simulation);
        if over.is_some() {
            ui.ctx().set_cursor_icon(CursorIcon::Grab);
        }
        let is_first = simulation.shown.is_some_and(|s| s.0 == 0);
        for hold in simulation.holds.iter().filter(|_| is_first) {
            if let HoldPart::ClampFrom(i) = hold.part {
                let other = simulation
                    .holds
                    .iter()
                    .find(|h| h.part == HoldPart::ClampTo(i));
                let to = other.map_or(hold.at, |h| h.at);
                let points = (0..=16).map(|k| hold.at + (to - hold.at) * f64::from(k) / 16.0);
                let line: Option<Vec<Pos2>> =
                    points.map(|t| self.axis_in_window(rect, t)).collect();
                if let Some(line) = line {
                    let shade =
                        Color32::from_rgba_unmultiplied(ACCENT.r(), ACCENT.g(), ACCENT.b(), 110);
                    painter.line(line, Stroke::new(5.0, shade));
                }
            }
        }
        for hold in &simulation.holds {
            let Some(dot) = self.hold_dot(hold.part) else {
                continue;
            };
            let is_over = over == Some(hold.part);
            paint_dot(&painter, dot, hold.part, is_over);
            if is_over {
                let text = match hold.part {
                    HoldPart::Hand => self.hand_text(simulation, hold),
                    _ => format!("{}, at {:.3}", hold.name, hold.at),
                };
                paint_label(&painter, dot, text, ACCENT);
            }
        }
    }

    /// Choosing where the scene is saved; whether it stays open.
    pub(super) fn save_scene_dialog(&mut self, ui: &mut Ui, files: &mut FileDialog) -> bool {
        let mut chosen = files.show(ui, &*self.platform);
        ui.weak("The file is a scene, which `greenstick simulate` reads, too.");
        let keep = buttons(ui, "Save", !files.name.trim().is_empty(), || {
            chosen = Some(files.path(&*self.platform));
        });
        if let Some(path) = chosen {
            let named = path.to_lowercase().ends_with(".toml");
            self.save_scene(&if named { path } else { path + ".toml" });
            return false;
        }
        keep
    }

    /// Saves the scene with its parts where they are.
    pub fn save_scene(&mut self, path: &str) {
        let moved = self.moved();
        let Some(simulation) = &self.simulation else {
            return;
        };
        let (number, source) = (simulation.number, simulation.source.clone());
        let job = self.simulation_job(number, source, simulation.own, moved);
        match self.platform.save_scene(path, &job) {
            Ok(()) => self.said = format!("Saved {path}."),
            Err(failure) => self.fail(&failure),
        }
    }
}

/// A dot: round at the ends of a clamp and of a hand, a diamond for a force, a square for a body.
fn paint_dot(painter: &egui::Painter, dot: Pos2, part: HoldPart, over: bool) {
    let radius = if over { DOT + 2.0 } else { DOT };
    let line = Stroke::new(1.0, Color32::BLACK);
    match part {
        HoldPart::ClampFrom(_) | HoldPart::ClampTo(_) | HoldPart::Hand => {
            painter.circle(dot, radius, ACCENT, line);
        }
        HoldPart::Force(_) => {
            let r = 1.3 * radius;
            let corners = [(0.0, -r), (r, 0.0), (0.0, r), (-r, 0.0)];
            let corners = corners.map(|(x, y)| dot + Vec2::new(x, y)).to_vec();
            painter.add(Shape::convex_polygon(corners, ACCENT, line));
        }
        HoldPart::Body(_) => {
            let square = Rect::from_center_size(dot, Vec2::splat(1.7 * radius));
            painter.rect(square, 1.0, ACCENT, line, egui::StrokeKind::Outside);
        }
    }
}
