//! Messages that stay until they are dismissed.

use super::message::Message;
use super::studio::Studio;
use eframe::egui::{self, Color32, Ui};
use greenstick::formats::LengthUnit;

/// No stem is thicker, m: the stoutest tree, the Árbol del Tule, is 11.6 m thick.
const THICKEST: f64 = 12.0;
/// Points that a message takes at most in width.
const WIDEST: f32 = 560.0;
/// Units of files that are no metres.
const UNITS: [(LengthUnit, &str); 2] = [
    (LengthUnit::Millimetre, "Millimetres"),
    (LengthUnit::Centimetre, "Centimetres"),
];

impl Studio {
    /// Asks for the unit of a file whose stem is thicker than any.
    pub(super) fn ask_for_unit(&mut self) {
        let file = &self.project.file;
        let is_known = file.unit.is_some() || self.project.input.path.is_none();
        let thick = self.diameter();
        if is_known || thick <= THICKEST || !self.platform.has_folders() {
            return;
        }
        self.messages.push(Message {
            text: format!(
                "In metres this stem is {thick:.0} m thick. In which unit is the file? Opened in it, the stem has its true size, and the \
                 wood its true grain."
            ),
            asks_unit: true,
            ..Message::default()
        });
    }

    /// Opens the file at hand again, in a unit of length.
    pub(super) fn open_in(&mut self, unit: LengthUnit) {
        if let Some(path) = self.project.input.path.clone() {
            self.project.file.unit = Some(unit);
            self.open(&path);
        }
    }

    /// Draws the messages.
    pub(super) fn message_cards(&mut self, ui: &mut Ui) {
        let (mut dismissed, mut go, mut unit) = (None, None, None);
        for (i, message) in self.messages.iter().enumerate() {
            let accent = if message.is_error {
                Color32::from_rgb(214, 78, 60)
            } else {
                Color32::from_rgb(90, 130, 190)
            };
            egui::Frame::popup(ui.style())
                .stroke(egui::Stroke::new(1.5, accent))
                .show(ui, |ui| {
                    ui.set_max_width(WIDEST.min(ui.available_width()));
                    ui.horizontal_top(|ui| {
                        if ui.button("Dismiss").clicked() {
                            dismissed = Some(i);
                        }
                        if let Some(place) = message.place {
                            let button = ui.button(format!("Break at {place}"));
                            if button.clicked() {
                                dismissed = Some(i);
                                go = Some(place);
                            }
                        }
                        for (choice, name) in UNITS {
                            if message.asks_unit && ui.button(name).clicked() {
                                dismissed = Some(i);
                                unit = Some(choice);
                            }
                        }
                        ui.add(egui::Label::new(&message.text).wrap().selectable(true));
                    });
                });
            ui.add_space(6.0);
        }
        if let Some(i) = dismissed {
            self.messages.remove(i);
        }
        if let Some(unit) = unit {
            self.open_in(unit);
        }
        if let Some(place) = go {
            self.move_break(place, ui.input(|i| i.time));
        }
    }
}
