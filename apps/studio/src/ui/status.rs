//! The line at the bottom: what is shown, what was said last, what the mouse does.

use super::simulation_view::SimulationView;
use super::studio::Studio;
use crate::model::units::ShownUnit;
use eframe::egui::{self, RichText, Ui};
use greenstick::BreakReport;

impl Studio {
    /// The line at the bottom.
    pub(super) fn status(&mut self, ui: &mut Ui) {
        egui::Panel::bottom("status").show(ui, |ui| {
            ui.horizontal(|ui| {
                let simulated = self.simulation.as_ref();
                let text = match self.report() {
                    _ if simulated.is_some() => simulated.map_or(String::new(), frames),
                    Some(report) => summary(report, self.triangles(), self.settings.unit),
                    None if self.is_busy() => "Breaking …".to_owned(),
                    None => "Nothing is broken yet: click where it shall break.".to_owned(),
                };
                let notes = self.report().map(|r| r.notes.clone()).unwrap_or_default();
                let whole = self.report().map(ToString::to_string).unwrap_or_default();
                let label = ui.add(egui::Label::new(text).selectable(true));
                label.on_hover_ui(|ui| {
                    ui.set_max_width(560.0);
                    ui.label(RichText::new(whole).monospace());
                });
                if !notes.is_empty() {
                    let title = match notes.len() {
                        1 => "1 note".to_owned(),
                        n => format!("{n} notes"),
                    };
                    ui.menu_button(title, |ui| {
                        ui.set_max_width(480.0);
                        for note in notes {
                            ui.add(egui::Label::new(note).wrap().selectable(true));
                        }
                    });
                }
                if self.shown.as_ref().is_some_and(|s| s.coarse) {
                    ui.label(RichText::new("coarse").weak());
                }
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    let hint = "drag turns · Shift drag shifts · wheel nears · click breaks · ? lists keys";
                    let text = if self.said.is_empty() { hint } else { &self.said };
                    ui.add(egui::Label::new(RichText::new(text).weak()).truncate());
                });
            });
        });
    }
}

/// A simulation in one line.
fn frames(simulation: &SimulationView) -> String {
    let drawn = simulation.drawn.as_ref();
    let triangles = drawn.map_or(0, |d| d.1.indices.len() / 3);
    let count = simulation.frames();
    let frames = if count == 1 { "frame" } else { "frames" };
    format!("{count} {frames} · {} triangles", thousands(triangles))
}

/// The report in one line, with the triangles that are drawn.
fn summary(report: &BreakReport, triangles: usize, unit: ShownUnit) -> String {
    let place = &report.place;
    let species = report
        .species
        .as_ref()
        .map_or(String::new(), |s| format!("{} · ", s.name));
    format!(
        "{species}diameter at the break {} · {} of {} from the base · {} pieces · {} triangles",
        unit.text(2.0 * place.radius_m),
        unit.text(place.length_m),
        unit.text(place.stem_length_m),
        report.pieces.len(),
        thousands(triangles),
    )
}

/// A number with spaces between thousands.
fn thousands(n: usize) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::thousands;

    #[test]
    fn thousands_are_set_apart() {
        assert_eq!(thousands(7), "7");
        assert_eq!(thousands(123_456), "123\u{202f}456");
    }
}
