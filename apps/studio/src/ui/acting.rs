//! Doing actions: by menus, keys and drops.

use super::actions::Action;
use super::studio::Studio;
use crate::model::engine::Failure;
use crate::model::input::Input;
use crate::model::units::ShownUnit;
use crate::platform::{Lane, Opened};
use crate::view::camera::AxisView;
use crate::view::frame::Colours;
use eframe::egui;
use greenstick::RequestFile;
use greenstick::schema::Value;

impl Studio {
    /// Does an action.
    pub(super) fn act(&mut self, action: Action, ctx: &egui::Context) {
        let now = ctx.input(|i| i.time);
        let mut look = |view, opposite| self.camera.look(view, opposite);
        match action {
            Action::ViewFront => look(AxisView::Front, false),
            Action::ViewBack => look(AxisView::Front, true),
            Action::ViewRight => look(AxisView::Right, false),
            Action::ViewLeft => look(AxisView::Right, true),
            Action::ViewTop => look(AxisView::Top, false),
            Action::ViewBottom => look(AxisView::Top, true),
            Action::Perspective => self.camera.parallel ^= true,
            Action::VerticalAxis => self.camera.z_up ^= true,
            Action::Simulate => match self.dialog_of(action) {
                Some(dialog) => self.dialog = Some(dialog),
                None => self.fail(&Failure::new(
                    "Nothing can be simulated here: a page has one thread for its work. The program simulates.",
                )),
            },
            Action::Pull => self.toggle_pulling(),
            Action::HidePhotograph => self.photograph.hidden ^= true,
            Action::Wireframe => self.view.wireframe ^= true,
            Action::Section => self.view.section ^= true,
            Action::Handles => self.view.handles ^= true,
            Action::NextHandles => self.next_handles(),
            Action::Anatomy => self.toggle_anatomy(),
            Action::Cracks => self.toggle_cracks(),
            Action::Paint => self.toggle_paint(),
            Action::Units => {
                let next = (self.settings.unit as usize + 1) % ShownUnit::ALL.len();
                self.settings.unit = ShownUnit::ALL[next];
                self.apply_settings(ctx);
            }
            Action::NextColours => {
                let next = (self.view.colours as usize + 1) % Colours::ALL.len();
                self.view.colours = Colours::ALL[next];
            }
            Action::FrameBreak => self.frame_break(),
            Action::FrameAll => self.frame_all(),
            Action::Gallery => self.gallery ^= true,
            Action::Undo | Action::Redo => self.step(action == Action::Undo, now),
            Action::Randomise => self.randomise(now),
            Action::NewSeed => self.new_seed(now),
            Action::ResetAll => {
                let reset = self.project.reset();
                self.finish_step(reset, now);
            }
            Action::AddBreak => self.add_break_beside(now),
            Action::RemoveBreak => self.remove_break(now),
            Action::BuiltIn => self.begin(Opened::Input(Input::built_in()), ""),
            Action::Theme => {
                self.settings.dark ^= true;
                self.apply_settings(ctx);
            }
            Action::Larger | Action::Smaller => {
                let factor = if action == Action::Larger {
                    1.1
                } else {
                    1.0 / 1.1
                };
                self.settings.scale = (self.settings.scale * factor).clamp(0.5, 4.0);
                self.apply_settings(ctx);
            }
            Action::Save => self.save(),
            Action::Open | Action::Photograph if !self.platform.has_folders() => {
                self.platform.choose();
            }
            Action::SaveScene if self.simulation.is_none() => {
                self.said = "No scene is simulated.".to_owned();
            }
            Action::Open
            | Action::SaveScene
            | Action::Photograph
            | Action::SaveAs
            | Action::Export
            | Action::Palette
            | Action::Shortcuts => self.dialog = self.dialog_of(action),
            Action::Cancel => self.cancel(),
            Action::Quit => self.quit = self.platform.has_folders(),
        }
    }

    fn cancel(&mut self) {
        if self.dialog.is_some() {
            self.dialog = None;
        } else if self.at_work.is_some() {
            self.platform.cancel(Lane::Show);
        } else if self.platform.progress(Lane::Simulation).is_some() {
            self.platform.cancel(Lane::Simulation);
        } else {
            self.platform.cancel(Lane::Files);
        }
    }

    /// Goes a step back or forward: of the simulation that is looked at, or of the project.
    fn step(&mut self, back: bool, now: f64) {
        if self.step_hold(back) {
            return;
        }
        match back {
            true => self.step_back(now),
            false => self.step_forward(now),
        }
    }

    fn step_back(&mut self, now: f64) {
        let before = self.project.file.clone();
        if let Some(label) = self.project.undo() {
            self.said = format!("Took back: {label}.");
            self.changed_since(&before, now);
        }
    }

    fn step_forward(&mut self, now: f64) {
        let before = self.project.file.clone();
        if let Some(label) = self.project.redo() {
            self.said = format!("Made again: {label}.");
            self.changed_since(&before, now);
        }
    }

    /// Notes a change; only another request is broken again.
    fn changed_since(&mut self, before: &RequestFile, now: f64) {
        if self.project.file == *before {
            self.changed_at = Some(now);
        } else {
            self.changed(false, now);
        }
    }

    fn randomise(&mut self, now: f64) {
        let drawn = self.project.randomise(now.to_bits());
        self.finish_step(drawn, now);
    }

    fn new_seed(&mut self, now: f64) {
        const SEED: &str = "break.seed";
        let list = self.project.parameters();
        let seed = list.iter().find(|p| p.key == SEED).map(|p| &p.value);
        if let Some(Value::Integer(seed)) = seed {
            let next = Value::Integer(seed % 1_000_000 + 1);
            self.set(SEED, &next, false, now);
        }
    }

    /// Saves the project where it was saved before, or asks where.
    fn save(&mut self) {
        match self.project.path.clone() {
            Some(path) => self.save_as(&path),
            None => self.dialog = self.dialog_of(Action::SaveAs),
        }
    }

    /// Saves the project under a name.
    pub fn save_as(&mut self, path: &str) {
        let project = self.project_file();
        match self.platform.save(path, &project) {
            Ok(()) => {
                self.project.mark_saved(path);
                self.project.path = Some(path.to_owned());
                self.platform.note_recent(path);
                self.platform.keep(None);
                self.changed_at = None;
                self.said = format!("Saved {path}.");
            }
            Err(failure) => self.fail(&failure),
        }
    }

    pub(super) fn shortcuts(&mut self, ctx: &egui::Context) {
        if ctx.text_edit_focused() {
            return;
        }
        // Keys with more modifiers first: Ctrl+Shift+Z is not Ctrl+Z.
        let mut all: Vec<_> = Action::ALL
            .iter()
            .flat_map(|a| a.3.iter().map(move |k| (a.0, *k)))
            .collect();
        all.sort_by_key(|(_, (m, _))| {
            std::cmp::Reverse(u8::from(m.shift) + u8::from(m.command) + u8::from(m.alt))
        });
        let pressed = all
            .into_iter()
            .find(|(_, (m, k))| ctx.input_mut(|i| i.consume_key(*m, *k)));
        if let Some((action, _)) = pressed {
            self.act(action, ctx);
        }
    }

    pub(super) fn dropped(&mut self, ctx: &egui::Context) {
        if !self.platform.has_folders() {
            // Without folders the machine reads drops itself.
            return;
        }
        let dropped = ctx.input(|i| i.raw.dropped_files.clone());
        if let Some(file) = dropped.last() {
            let path = file.path().display().to_string();
            self.open(&path);
        }
    }
}
