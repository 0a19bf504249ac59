//! A simulation that is looked at: beginning, news of it, playback, and the break that is taken from it.

use super::dialogs::buttons;
use super::simulation_view::SimulationView;
use super::studio::Studio;
use crate::model::engine::Failure;
use crate::model::history::History;
use crate::model::holds::Moved;
use crate::model::simulation::{
    Begun, Look, News, Playback, Recorded, SceneEntry, SimulationJob, Source, Taken,
};
use crate::platform::{Lane, Opened};
use eframe::egui::{self, Key, Modifiers, RichText, Ui};
use greenstick::RequestFile;
use std::sync::Arc;

impl Studio {
    /// The choice of a scene; whether it stays open.
    pub(super) fn simulate_dialog(
        &mut self,
        ui: &mut Ui,
        scenes: &[SceneEntry],
        at: &mut usize,
        own: &mut bool,
    ) -> bool {
        egui::ScrollArea::vertical()
            .max_height(330.0)
            .auto_shrink([false, true])
            .show(ui, |ui| {
                for (i, scene) in scenes.iter().enumerate() {
                    ui.selectable_value(at, i, &scene.name);
                    ui.indent(&scene.name, |ui| {
                        let text = format!("{}; {} s", scene.about, scene.duration);
                        ui.add(egui::Label::new(RichText::new(text).weak()).wrap());
                    });
                }
            });
        let is_mesh = self.project.input.is_mesh();
        let name = format!("On the stem at hand ({})", self.project.input.title());
        ui.add_enabled(is_mesh, egui::Checkbox::new(own, name))
            .on_hover_text("Puts the scene on this stem, at its break, in place of its own stem.")
            .on_disabled_hover_text("A scan has no mesh that could be simulated.");
        ui.weak("A scene of your own, or the folder of a run: File, Open… and its scene.toml.");
        let mut chosen = None;
        let keep = buttons(ui, "Start", true, || chosen = scenes.get(*at));
        if let Some(scene) = chosen {
            self.begin_simulation(Source::BuiltIn(scene.name.clone()), *own && is_mesh);
        }
        keep
    }

    /// Begins a simulation, on the stem at hand or on that of its scene.
    pub fn begin_simulation(&mut self, source: Source, own: bool) {
        self.begin_simulation_at(source, own, Vec::new());
    }

    /// Begins a simulation with parts of its scene elsewhere.
    pub(super) fn begin_simulation_at(&mut self, source: Source, own: bool, moved: Vec<Moved>) {
        self.numbers += 1;
        let number = self.numbers;
        let job = self.simulation_job(number, source.clone(), own, moved.clone());
        self.platform.simulate(job);
        let before = self.simulation.take();
        self.simulation = Some(SimulationView {
            number,
            can_pull: Ok(()),
            pulls: source == Source::ByHand,
            paused: false,
            source,
            own,
            holds: Vec::new(),
            history: History::default(),
            simulated: moved,
            held: None,
            waited: None,
            beside: egui::Vec2::ZERO,
            hand_way: Vec::new(),
            axis: Arc::default(),
            about: String::new(),
            recorded: Recorded::default(),
            outcome: None,
            wood: None,
            look: Look::Best,
            playback: Playback::default(),
            asked: None,
            shown: None,
            is_outdated: false,
            drawn: None,
            rest_radius: 1.0,
            camera_before: before.map_or(self.camera, |b| b.camera_before),
            takes: false,
            seen: 0.0,
        });
    }

    /// What is asked for to simulate a scene with parts of it elsewhere.
    pub(super) fn simulation_job(
        &self,
        number: u64,
        source: Source,
        own: bool,
        moved: Vec<Moved>,
    ) -> SimulationJob {
        let place = self.project.file.breaks.first();
        let place = place.unwrap_or(&self.project.file.common).place;
        SimulationJob {
            number,
            source,
            stem: Some((self.project.input.clone(), place)),
            own,
            moved,
        }
    }

    /// Goes back to the break.
    pub(super) fn end_simulation(&mut self) {
        if let Some(simulation) = self.simulation.take() {
            self.platform.cancel(Lane::Simulation);
            self.camera = simulation.camera_before;
            self.frame_shown();
        }
    }

    /// The simulation that is looked at.
    pub fn simulation(&self) -> Option<&SimulationView> {
        self.simulation.as_ref()
    }

    /// Whether a simulation is at work, or a frame of it is to be drawn.
    pub(super) fn simulates(&self) -> bool {
        let paused = self.simulation.as_ref().is_some_and(|s| s.paused);
        let works = self.platform.progress(Lane::Simulation).is_some() && !paused;
        let waits = |s: &SimulationView| {
            let is_there = s.frames() == 0 || s.is_shown();
            !is_there || s.asked.is_some() || s.takes || s.playback.playing
        };
        works || self.simulation.as_ref().is_some_and(waits)
    }

    /// Takes news of the simulation that is looked at.
    pub(super) fn take_simulated(&mut self, number: u64, news: News, now: f64) {
        let Some(simulation) = self.simulation.as_mut().filter(|s| s.number == number) else {
            return;
        };
        match news {
            News::Begun(Begun {
                about,
                holds,
                pull,
                hand_way,
            }) => {
                simulation.about = about;
                simulation.hand_way = hand_way;
                simulation.can_pull = pull;
                if simulation.simulated.is_empty() {
                    simulation.simulated = holds.iter().map(Moved::from).collect();
                }
                if simulation.holds.is_empty() {
                    simulation.holds = holds;
                }
            }
            News::Steered(hand, way) => simulation.steered(hand, way),
            News::Recorded(recorded) => {
                simulation.recorded = recorded;
                simulation.playback.recorded(simulation.frames());
            }
            News::Ended(Ok(outcome)) => {
                simulation.outcome = Some(outcome);
                simulation.playback.follows = false;
            }
            News::Ended(Err(failure)) => {
                // A frame that cannot be drawn is not asked for again.
                simulation.shown = simulation.asked.take().or(simulation.shown);
                simulation.is_outdated = false;
                let nothing = simulation.frames() == 0;
                self.fail(&failure);
                if nothing {
                    self.end_simulation();
                }
            }
            News::Wood(wood) => {
                // What shows the run best may be another now.
                simulation.is_outdated = simulation.shown.is_some_and(|s| s.1 == Look::Best);
                simulation.wood = Some(wood.map(drop));
            }
            News::Frame(number, look, frame) => {
                simulation.asked = None;
                simulation.shown = Some((number, look));
                simulation.is_outdated = false;
                let first = simulation.drawn.is_none();
                self.numbers += 1;
                simulation.rest_radius = frame.rest_radius as f32;
                simulation.axis = frame.axis;
                simulation.drawn = Some((self.numbers, Arc::new(frame.scene)));
                if first {
                    self.camera.z_up = false;
                    self.frame_all();
                }
            }
            News::Taken(taken) => {
                simulation.takes = false;
                match taken {
                    Ok(taken) => self.use_taken(*taken, now),
                    Err(failure) => self.fail(&failure),
                }
            }
        }
    }

    /// Breaks the stem as the simulation did.
    fn use_taken(&mut self, taken: Taken, now: f64) {
        let Taken {
            mut request,
            input,
            unit,
        } = taken;
        let base = match &input {
            Some(_) => RequestFile {
                unit,
                ..RequestFile::default()
            },
            None => self.project.file.clone(),
        };
        request.texture_width = base.texture_width;
        let mut file = base.with_request(&request);
        if let [only] = &file.breaks[..] {
            file.common = only.clone();
            file.breaks.clear();
        }
        // Names of species become those that a recipe is read with.
        if let Err(problem) = file.complete() {
            return self.fail(&Failure::new(problem));
        }
        self.end_simulation();
        match input {
            Some(input) => self.begin(Opened::Project(input, Box::new(file.into())), ""),
            None => {
                let next = |present: &mut RequestFile| {
                    *present = file;
                    Ok::<(), String>(())
                };
                let step = self.project.change("break of the simulation", false, next);
                self.finish_step(step, now);
            }
        }
        self.changed_at = Some(now);
        self.said = "This is the break that the simulation left.".to_owned();
    }

    /// Starts to take the break that the simulation left.
    pub(super) fn take_break(&mut self) {
        let at_hand = self.project.input.id;
        if let Some(simulation) = &mut self.simulation {
            simulation.takes = true;
            self.platform.take_break(at_hand);
        }
    }

    /// Plays on, and asks for the frame that is to be shown.
    pub(super) fn follow_simulation(&mut self, ctx: &egui::Context, now: f64) {
        let Some(simulation) = &mut self.simulation else {
            return;
        };
        let passed = now - simulation.seen;
        simulation.seen = now;
        let count = simulation.frames();
        simulation.playback.advance(passed, count);
        if simulation.playback.playing {
            ctx.request_repaint();
        }
        let wanted = simulation.wanted();
        if count > 0 && !simulation.is_shown() && simulation.asked.is_none() {
            simulation.asked = Some(wanted);
            self.platform.draw_frame(wanted.0, wanted.1);
        }
    }

    /// Space plays and pauses, the arrows step.
    pub(super) fn simulation_keys(&mut self, ctx: &egui::Context) {
        if ctx.text_edit_focused() || self.dialog.is_some() || self.simulation.is_none() {
            return;
        }
        let pressed = |key| ctx.input_mut(|i| i.consume_key(Modifiers::NONE, key));
        if pressed(Key::Space) {
            self.play_or_pause();
        }
        if pressed(Key::ArrowLeft) {
            self.step_frame(-1);
        }
        if pressed(Key::ArrowRight) {
            self.step_frame(1);
        }
    }

    /// Whether the wood is still being moved, and the last frame so far is shown.
    pub(super) fn is_live(&self) -> bool {
        let works = self.platform.progress(Lane::Simulation).is_some();
        self.simulation.as_ref().is_some_and(|s| {
            let at_last = s.playback.at + 1 >= s.frames() && !s.playback.playing;
            works && s.outcome.is_none() && at_last
        })
    }

    /// Holds the run, or lets it go on; where it ended, or an earlier frame is shown, plays or pauses what is recorded.
    pub(super) fn play_or_pause(&mut self) {
        let live = self.is_live();
        let Some(simulation) = &mut self.simulation else {
            return;
        };
        if live {
            simulation.paused ^= true;
            simulation.playback.follows = true;
            self.platform.pause_simulation(simulation.paused);
        } else {
            simulation.playback.toggle(simulation.frames());
        }
    }

    /// Shows the frame before or after; after the last one, the run goes on to its next and waits.
    pub(super) fn step_frame(&mut self, by: isize) {
        let live = self.is_live();
        let Some(simulation) = &mut self.simulation else {
            return;
        };
        if live && by > 0 {
            simulation.playback.follows = true;
            match simulation.paused {
                true => self.platform.step_simulation(),
                false => self.platform.pause_simulation(true),
            }
            simulation.paused = true;
            return;
        }
        let count = simulation.frames();
        let playback = &mut simulation.playback;
        playback.go(playback.at.saturating_add_signed(by), count);
        // What is at the last frame goes on with the run.
        playback.follows = simulation.outcome.is_none() && playback.at + 1 == count;
    }
}
