//! The panels of a simulation: its outcome and charts on the right, its timeline below.

use super::actions::Action;
use super::charts::{chart, short};
use super::studio::Studio;
use crate::model::holds::hand_of;
use crate::model::simulation::{Look, Outcome, Source};
use crate::platform::Lane;
use eframe::egui::{self, Grid, RichText, Ui};

/// Height of a chart's area, points.
const CHART: f32 = 150.0;

impl Studio {
    /// The panel on the right.
    pub(super) fn simulation_panel(&mut self, ui: &mut Ui) {
        let panel = egui::Panel::right("simulation").default_size(348.0);
        panel.size_range(280.0..=560.0).show(ui, |ui| {
            ui.add_space(4.0);
            let mut close = false;
            ui.horizontal(|ui| {
                let title = self.simulation.as_ref().map_or("", |s| s.source.title());
                ui.heading(title);
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    close = ui
                        .button("Back to the break")
                        .on_hover_text("Leaves the simulation, and gives it up.")
                        .clicked();
                });
            });
            egui::ScrollArea::vertical()
                .auto_shrink([false, false])
                .show(ui, |ui| self.simulation_report(ui));
            if close {
                self.end_simulation();
            }
        });
    }

    fn simulation_report(&mut self, ui: &mut Ui) {
        let Some(simulation) = &self.simulation else {
            return;
        };
        ui.add(egui::Label::new(&simulation.about).wrap());
        ui.separator();
        let works = self.platform.progress(Lane::Simulation).is_some();
        let mut take = false;
        let by_hand = simulation.source == Source::ByHand;
        let is_pulled = hand_of(&simulation.simulated).is_some();
        match &simulation.outcome {
            Some(_) if by_hand && !is_pulled => {
                let text = "Drag the wood, and a hand pulls it to where it is let go, until it breaks. A drag across the stem bends \
                            it, one along it tears it.";
                ui.add(egui::Label::new(text).wrap());
            }
            Some(outcome) => {
                show_outcome(ui, outcome);
                let usable = outcome.broke && simulation.wood.is_some() && !simulation.takes;
                let button = egui::Button::new(RichText::new("Take this break").strong());
                take = ui
                    .add_enabled(usable, button)
                    .on_hover_text(
                        "Breaks the stem along the faces that the end of the run decided, with all sliders of a break.",
                    )
                    .clicked();
                if let Some(Err(problem)) = &simulation.wood {
                    let text = match outcome.broke {
                        true => format!("Drawn as rods: {problem}"),
                        false => "Nothing broke, so that there is no face to cut the wood along."
                            .to_owned(),
                    };
                    ui.add(egui::Label::new(RichText::new(text).weak()).wrap());
                }
            }
            None if works && simulation.paused => {
                drop(ui.label("The run waits. Space lets it go on, the right arrow by one frame."))
            }
            None if works => drop(ui.label("The wood is being moved …")),
            None => drop(ui.label("The simulation was stopped before its end.")),
        }
        let (mut first, mut save) = (false, false);
        if !simulation.holds.is_empty() {
            ui.separator();
            let hint = match simulation.pulls {
                true => {
                    "At the first frame, dots on the stem move what holds it, and a drag over the wood takes hold of it. From any later \
                     frame a drag takes the hand along, and the run goes on from there."
                }
                false => "At the first frame, dots on the stem move clamps, forces and bodies.",
            };
            ui.add(egui::Label::new(RichText::new(hint).weak()).wrap());
            let is_scene = !matches!(simulation.source, Source::Run(_));
            ui.horizontal(|ui| {
                first = ui.button("To the first frame").clicked();
                let button = ui.add_enabled(is_scene, egui::Button::new(Action::SaveScene.label()));
                save = button.on_hover_text(Action::SaveScene.about()).clicked();
            });
        }
        ui.separator();
        let at = simulation.recorded.times.get(simulation.playback.at);
        ui.label(RichText::new("Load over deflection").small().weak());
        chart(ui, &simulation.recorded.load, CHART, None);
        ui.add_space(6.0);
        ui.label(RichText::new("Energies").small().weak());
        chart(ui, &simulation.recorded.energy, CHART, at.copied());
        if save {
            self.act(Action::SaveScene, &ui.ctx().clone());
        }
        if let Some(simulation) = self.simulation.as_mut().filter(|_| first) {
            simulation.playback.go(0, simulation.frames());
        }
        if take {
            self.take_break();
        }
    }

    /// The line below the picture that plays, steps and scrubs.
    pub(super) fn timeline(&mut self, ui: &mut Ui) {
        let live = self.is_live();
        let Some(simulation) = &mut self.simulation else {
            return;
        };
        let count = simulation.frames();
        let has_wood = simulation.wood == Some(Ok(()));
        let (mut toggle, mut step) = (false, None);
        let label = match (live, simulation.paused, simulation.playback.playing) {
            (true, true, _) => "Go on",
            (true, false, _) | (false, _, true) => "Pause",
            (false, _, false) => "Play",
        };
        egui::Panel::bottom("timeline").show(ui, |ui| {
            ui.horizontal(|ui| {
                let playback = &mut simulation.playback;
                let play = egui::Button::new(label).min_size(egui::vec2(52.0, 0.0));
                let about = match live {
                    true => "Holds the run after its present frame, or lets it go on (Space).",
                    false => "Plays or pauses (Space).",
                };
                toggle = ui.add(play).on_hover_text(about).clicked();
                for (label, name, by) in [("‹", "One frame back", -1), ("›", "One frame on", 1)]
                {
                    let button = ui.button(label).on_hover_text(name);
                    button
                        .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name));
                    if button.clicked() {
                        step = Some(by);
                    }
                }
                let last = count.saturating_sub(1);
                let mut at = playback.at;
                ui.spacing_mut().slider_width = (ui.available_width() - 400.0).max(80.0);
                let slider = egui::Slider::new(&mut at, 0..=last.max(1)).show_value(false);
                let response = ui.add_enabled(last > 0, slider);
                response.widget_info(|| egui::WidgetInfo::slider(true, at as f64, "Frame"));
                if at != playback.at {
                    playback.go(at, count);
                    playback.follows = simulation.outcome.is_none() && at == last;
                }
                let time = simulation.recorded.times.get(playback.at).copied();
                let time = time.map_or(String::new(), |t| format!("{} s", short(t)));
                ui.monospace(format!("{:>3}/{last} {time:>8}", playback.at));
                ui.spacing_mut().slider_width = 60.0;
                let speed = egui::DragValue::new(&mut playback.speed);
                ui.add(
                    speed
                        .range(0.05..=8.0)
                        .speed(0.02)
                        .prefix("speed ")
                        .max_decimals(2),
                )
                .on_hover_text("1 is 24 frames a second.");
                ui.separator();
                ui.selectable_value(&mut simulation.look, Look::Best, "Best")
                    .on_hover_text(
                        "The whole wood with its bark until it breaks; then rods, and when the run has ended wood that is cut where \
                         it broke, where that shows the run well.",
                    );
                ui.selectable_value(&mut simulation.look, Look::Rods, "Rods")
                    .on_hover_text("The rods that are moved.");
                ui.add_enabled_ui(has_wood, |ui| {
                    ui.selectable_value(&mut simulation.look, Look::Wood, "Wood")
                        .on_hover_text("The stem cut along the faces that the end of the run decided.")
                        .on_disabled_hover_text("The wood is cut when the run has ended.");
                });
            });
        });
        if toggle {
            self.play_or_pause();
        }
        if let Some(by) = step {
            self.step_frame(by);
        }
    }
}

/// What became of the wood.
fn show_outcome(ui: &mut Ui, outcome: &Outcome) {
    Grid::new("outcome")
        .num_columns(2)
        .striped(true)
        .show(ui, |ui| {
            for (name, value) in &outcome.facts {
                ui.label(RichText::new(name).weak());
                ui.add(egui::Label::new(value).wrap().selectable(true));
                ui.end_row();
            }
        });
    if !outcome.report.is_empty() {
        let report = RichText::new(&outcome.report).monospace().small();
        ui.collapsing("Whole report", |ui| {
            ui.add(egui::Label::new(report).wrap().selectable(true));
        });
    }
}
