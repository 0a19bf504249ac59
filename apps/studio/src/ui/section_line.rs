//! The line on the stem where the section browser cuts it, and dragging it along the stem.

use super::labels::paint_label;
use super::studio::Studio;
use crate::model::section_book::{SectionBook, StemSection};
use eframe::egui::{self, Color32, Pos2, Rect, Stroke, Ui};
use glam::DVec3;
use std::sync::Arc;

/// The colour of the section on the stem.
const LINE: Color32 = Color32::from_rgb(80, 200, 235);
/// Radius of the dot that is dragged, points, and of what takes hold of it.
const DOT: f32 = 5.5;
const HOLD: f32 = 11.0;

impl Studio {
    fn shown_book(&self) -> Option<Arc<SectionBook>> {
        let open = self.anatomy.open && self.simulation.is_none();
        open.then(|| self.section_book()).flatten()
    }

    /// Where points of a section are in the window.
    fn seen(&self, rect: Rect, section: &StemSection, world: DVec3) -> Option<Pos2> {
        let (_, drawn) = self.drawn.as_ref()?;
        self.in_window(rect, drawn.moved_point(world, section.length as f32))
    }

    /// The outline of the section that is shown, in the window.
    fn section_line(&self, rect: Rect) -> Option<Vec<Pos2>> {
        let book = self.shown_book()?;
        let section = book.sections.get(self.section_index(&book))?;
        let line = section.outline();
        let line = line.map(|p| self.seen(rect, section, section.world(p)));
        line.collect()
    }

    /// Where the dot is by which the section is dragged along the stem.
    fn section_dot(&self, rect: Rect) -> Option<Pos2> {
        let line = self.section_line(rect)?;
        line.into_iter().max_by(|a, b| a.x.total_cmp(&b.x))
    }

    /// Where that dot was drawn.
    pub fn section_dot_at(&self) -> Option<Pos2> {
        self.section_dot(self.viewport_rect?)
    }

    /// Draws the line of the section.
    pub(super) fn paint_section_line(&self, ui: &Ui, rect: Rect) {
        let (Some(line), Some(dot)) = (self.section_line(rect), self.section_dot(rect)) else {
            return;
        };
        let painter = ui.painter_at(rect);
        let shadow = Stroke::new(3.5, Color32::from_black_alpha(90));
        painter.add(egui::Shape::closed_line(line.clone(), shadow));
        painter.add(egui::Shape::closed_line(line, Stroke::new(1.5, LINE)));
        painter.circle(dot, DOT, LINE, Stroke::new(1.0, Color32::BLACK));
        if self.anatomy.holds_section
            && let Some(length) = self.section_length()
        {
            let text = format!("section at {}", self.settings.unit.text(length));
            paint_label(&painter, dot, text, LINE);
        }
    }

    /// Moves the section with the pointer; returns whether it is held.
    pub(super) fn drag_section(&mut self, ui: &Ui, rect: Rect, response: &egui::Response) -> bool {
        let left = egui::PointerButton::Primary;
        let (pressed, modifiers) = ui.input(|i| (i.pointer.press_origin(), i.modifiers));
        if response.drag_started_by(left) && modifiers.is_none() {
            let dot = self.section_dot(rect).zip(pressed);
            self.anatomy.holds_section = dot.is_some_and(|(dot, p)| dot.distance(p) <= HOLD);
        }
        if !self.anatomy.holds_section {
            return false;
        }
        if !response.dragged_by(left) {
            self.anatomy.holds_section = false;
            return false;
        }
        let (Some(book), Some(pos)) = (self.shown_book(), response.interact_pointer_pos()) else {
            return true;
        };
        // The section whose own dot would be nearest to the pointer.
        let dot = |section: &StemSection| {
            let points = section.outline();
            let seen = points.filter_map(|p| self.seen(rect, section, section.world(p)));
            seen.max_by(|a, b| a.x.total_cmp(&b.x))
        };
        let off = |i: &usize| dot(&book.sections[*i]).map_or(f32::INFINITY, |d| d.distance(pos));
        let nearest = (0..book.sections.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
        self.show_section(nearest);
        true
    }
}
