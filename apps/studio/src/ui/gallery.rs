//! The gallery of presets, with pictures; a click shows one on the stem at hand.

use super::studio::Studio;
use eframe::egui::{self, RichText, Ui};
use greenstick::fracture::presets::Preset;

/// A preset and its picture, a PNG file.
macro_rules! pictured {
    ($($name:literal)+) => {
        [$((
            $name,
            include_bytes!(concat!("../../pictures/", $name, ".png")) as &[u8],
        )),+]
    };
}

/// What the gallery shows: ways in which wood breaks first, then figures of the paper.
const SHOWN: [(&str, &[u8]); 15] = pictured! {
    "splintering-tension" "simple-tension" "brash" "compression-first" "green-stick" "shear" "twist"
    "fig2g" "fig15" "fig16" "fig17" "fig18" "fig19" "fig20" "fig21"
};
/// Width of a picture, points.
const WIDTH: f32 = 132.0;

impl Studio {
    /// The panel on the left.
    pub(super) fn gallery_panel(&mut self, ui: &mut Ui) {
        let panel = egui::Panel::left("gallery").default_size(168.0);
        panel.size_range(160.0..=330.0).show(ui, |ui| {
            ui.add_space(4.0);
            ui.label(RichText::new("Presets").strong())
                .on_hover_text("A click shows a preset on the stem at hand. Undo takes it back.");
            ui.separator();
            egui::ScrollArea::vertical()
                .auto_shrink([false, false])
                .show(ui, |ui| {
                    let mut chosen = None;
                    let columns = ((ui.available_width() / (WIDTH + 8.0)) as usize).max(1);
                    egui::Grid::new("presets").show(ui, |ui| {
                        for (i, (name, png)) in SHOWN.into_iter().enumerate() {
                            if self.card(ui, name, png) {
                                chosen = Some(name);
                            }
                            if (i + 1) % columns == 0 {
                                ui.end_row();
                            }
                        }
                    });
                    if let Some(name) = chosen {
                        self.apply_preset(name, ui.input(|i| i.time));
                    }
                });
        });
    }

    fn card(&mut self, ui: &mut Ui, name: &'static str, png: &[u8]) -> bool {
        let summary = Preset::find(name).map_or("", |p| p.summary);
        let picture = self.gallery_pictures.get(ui.ctx(), name, png);
        let response = ui.vertical(|ui| {
            ui.set_width(WIDTH);
            let label = name.replace('-', " ");
            let mut clicked = false;
            if let Some(picture) = picture {
                let [w, h] = picture.size();
                let size = egui::vec2(WIDTH, WIDTH * h as f32 / w.max(1) as f32);
                let image = egui::Image::new((picture.id(), size)).corner_radius(4);
                let button = egui::Button::image(image).frame(false);
                clicked |= ui.add(button).on_hover_text(summary).clicked();
            }
            let text = RichText::new(label).small();
            let button = egui::Button::new(text).frame(false);
            clicked |= ui.add(button).on_hover_text(summary).clicked();
            clicked
        });
        response.inner
    }

    /// Puts a preset over the request.
    pub fn apply_preset(&mut self, name: &str, now: f64) {
        let applied = self.project.apply_preset(name);
        match applied {
            Ok(true) => {
                self.said = format!("Preset {name}.");
                self.changed(false, now);
            }
            Ok(false) => self.said = format!("Preset {name} changes nothing."),
            Err(problem) => self.said = problem,
        }
    }
}
