//! Several breaks of one stem: the bar that selects one of them, and their numbers in the picture.

use super::actions::Action;
use super::colours::ACCENT;
use super::studio::Studio;
use eframe::egui::{self, Align2, Color32, FontId, Pos2, Rect, Ui};
use greenstick::wood::stem::StemLocation;

/// Radius of a number's disc in the picture, points.
const DISC: f32 = 10.0;
/// Places, as parts of the length, at which another break is tried, the last of those that are farthest from all others and from the ends.
const CANDIDATE_PLACES: [f64; 7] = [0.875, 0.625, 0.375, 0.125, 0.25, 0.75, 0.5];

impl Studio {
    /// The bar above the parameters.
    pub(super) fn breaks_bar(&mut self, ui: &mut Ui) {
        let count = self.project.break_count();
        let selected = self.project.selected();
        let mut chosen = None;
        ui.horizontal_wrapped(|ui| {
            ui.label("Breaks");
            if count > 1 {
                let all = ui.selectable_label(selected.is_none(), "all");
                if all.on_hover_text("Changes apply to all breaks.").clicked() {
                    chosen = Some(None);
                }
            }
            for i in 0..count {
                let is_selected = selected == Some(i) || count == 1;
                let label = ui.selectable_label(is_selected, (i + 1).to_string());
                let about = format!("Changes and clicks apply to break {}.", i + 1);
                if label.on_hover_text(about).clicked() && count > 1 {
                    chosen = Some(Some(i));
                }
            }
            for (action, sign) in [(Action::AddBreak, "+"), (Action::RemoveBreak, "−")] {
                let usable = action == Action::AddBreak || selected.is_some();
                let button = ui.add_enabled(usable, egui::Button::new(sign));
                let name = action.label();
                button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, usable, name));
                if button.on_hover_text(action.about()).clicked() {
                    self.act(action, &ui.ctx().clone());
                }
            }
        });
        if let Some(selection) = chosen {
            self.project.select(selection);
        }
    }

    /// Adds a break where a click was; a point is one of the unbroken stem.
    pub(super) fn add_break(&mut self, place: StemLocation, now: f64) {
        let added = self.project.add_break(place);
        if added == Ok(true) {
            self.said = format!("Break {}.", self.project.break_count());
        }
        self.finish_step(added, now);
    }

    /// Adds a break where the stem has most room.
    pub(super) fn add_break_beside(&mut self, now: f64) {
        let length = (self.shown.as_ref()).map_or(1.0, |s| s.report.place.stem_length_m);
        let drawn = self.drawn.iter().flat_map(|d| &d.1.breaks);
        let taken: Vec<f64> = drawn.map(|b| f64::from(b.length) / length).collect();
        let room = |part: &f64| {
            let others = taken.iter().map(|t| (t - part).abs());
            others.fold(part.min(1.0 - part), f64::min)
        };
        let widest = CANDIDATE_PLACES
            .into_iter()
            .max_by(|a, b| room(a).total_cmp(&room(b)));
        self.add_break(StemLocation::Fraction(widest.unwrap_or(0.5)), now);
    }

    /// Takes the selected break away.
    pub(super) fn remove_break(&mut self, now: f64) {
        let Some(number) = self.project.selected() else {
            self.said = "Select one of several breaks first.".to_owned();
            return;
        };
        let removed = self.project.remove_break(number);
        self.finish_step(removed, now);
    }

    /// Where the numbers of several breaks stand in the picture.
    pub(super) fn break_marks(&self, rect: Rect) -> Vec<(usize, Pos2)> {
        let Some((_, drawn)) = &self.drawn else {
            return Vec::new();
        };
        // Without an answer to the last change there may be more, or fewer.
        if drawn.breaks.len() < 2 || drawn.breaks.len() != self.project.break_count() {
            return Vec::new();
        }
        let mark = |i: usize| Some((i, self.in_window(rect, drawn.break_place(i))?));
        (0..drawn.breaks.len()).filter_map(mark).collect()
    }

    /// Draws the numbers of several breaks.
    pub(super) fn paint_break_marks(&self, ui: &Ui, rect: Rect) {
        let painter = ui.painter_at(rect);
        let selected = self.project.selected();
        for (i, pos) in self.break_marks(rect) {
            let active = selected.is_none_or(|s| s == i);
            let fill = if active {
                ACCENT
            } else {
                Color32::from_black_alpha(150)
            };
            let text = if active {
                Color32::BLACK
            } else {
                Color32::WHITE
            };
            painter.circle(pos, DISC, fill, egui::Stroke::new(1.0, Color32::BLACK));
            let number = (i + 1).to_string();
            painter.text(
                pos,
                Align2::CENTER_CENTER,
                number,
                FontId::proportional(12.0),
                text,
            );
        }
    }

    /// The break whose number is at a point of the window.
    pub(super) fn break_mark_at(&self, rect: Rect, pos: Pos2) -> Option<usize> {
        let marks = self.break_marks(rect).into_iter();
        let near = marks.filter(|(_, at)| at.distance(pos) <= DISC);
        near.map(|(i, _)| i).next()
    }
}
