//! The handle on the wood that tilts the break.

use super::colours::ACCENT;
use super::labels::paint_label;
use super::studio::Studio;
use crate::model::tilt::{Tilt, TiltHandle};
use eframe::egui::{self, Color32, Pos2, Rect, Stroke, Ui, Vec2};

/// Radius of the handle's dot, points, and of what takes hold of it.
const DOT: f32 = 6.0;
const HOLD: f32 = 11.0;

impl Studio {
    /// The handle of the selected break, or of the only one, and the tilt that is set.
    fn tilt_handle(&self) -> Option<(TiltHandle, Tilt)> {
        let (_, drawn) = self.drawn.as_ref()?;
        let number = self.handled_break()?;
        let at = drawn.breaks[number];
        let handle = TiltHandle {
            place: drawn.break_place(number),
            across: at.across,
            along: at.along,
            radius: at.radius,
        };
        let file = &self.project.file;
        let face = &file.breaks.get(number).unwrap_or(&file.common).recipe.face;
        let tilt = Tilt {
            inclination: face.inclination,
            direction: face.inclination_direction,
        };
        Some((handle, tilt))
    }

    /// Whether the heights of the break were measured, so that its plane changes nothing.
    fn has_own_heights(&self) -> bool {
        let number = self.handled_break();
        number.is_some_and(|n| self.project.has_own_heights(n))
    }

    /// Where a point is in the window.
    pub(super) fn in_window(&self, rect: Rect, point: glam::Vec3) -> Option<Pos2> {
        let aspect = rect.width() / rect.height().max(1.0);
        let seen = self.camera.seen_at(point, aspect)?;
        let at = Vec2::new(0.5 * (1.0 + seen.x), 0.5 * (1.0 - seen.y));
        Some(rect.min + at * rect.size())
    }

    /// Where the handle's dot is.
    pub(super) fn tilt_dot(&self, rect: Rect) -> Option<Pos2> {
        let (handle, tilt) = self
            .tilt_handle()
            .filter(|_| self.view.handles && self.fans.kind.is_none())
            .filter(|_| !self.has_own_heights())?;
        self.in_window(rect, handle.tip(tilt))
    }

    /// Whether a point of the window is on the handle.
    pub(super) fn on_handle(&self, rect: Rect, pos: Pos2) -> bool {
        self.tilt_dot(rect)
            .is_some_and(|dot| dot.distance(pos) <= HOLD)
    }

    /// Draws the handle and the outline of the break's plane, while the pointer is in the viewport.
    pub(super) fn paint_handle(&self, ui: &Ui, rect: Rect, response: &egui::Response) {
        let turning = response.dragged() && !self.holds_handle;
        if !response.contains_pointer() && !self.holds_handle || turning {
            return;
        }
        let (Some((handle, tilt)), Some(dot)) = (self.tilt_handle(), self.tilt_dot(rect)) else {
            return;
        };
        let painter = ui.painter_at(rect);
        let outline = handle.outline(tilt);
        let line: Option<Vec<Pos2>> = outline.iter().map(|p| self.in_window(rect, *p)).collect();
        let over = response
            .hover_pos()
            .is_some_and(|p| dot.distance(p) <= HOLD);
        if let Some(line) = line {
            let alpha = if over || self.holds_handle { 230 } else { 110 };
            let color = Color32::from_rgba_unmultiplied(ACCENT.r(), ACCENT.g(), ACCENT.b(), alpha);
            painter.line(line, Stroke::new(1.5, color));
        }
        let radius = if over || self.holds_handle {
            DOT + 2.0
        } else {
            DOT
        };
        painter.circle(dot, radius, ACCENT, Stroke::new(1.0, Color32::BLACK));
        if over || self.holds_handle {
            let text = format!(
                "inclination {:.0}°, direction {:.0}°",
                tilt.inclination, tilt.direction
            );
            paint_label(&painter, dot, text, ACCENT);
        }
    }

    /// Moves the handle with the pointer; returns whether it is held.
    pub(super) fn drag_handle(&mut self, ui: &Ui, rect: Rect, response: &egui::Response) -> bool {
        let left = egui::PointerButton::Primary;
        let (pressed, modifiers) = ui.input(|i| (i.pointer.press_origin(), i.modifiers));
        if response.drag_started_by(left) && modifiers.is_none() {
            self.holds_handle = pressed.is_some_and(|pos| self.on_handle(rect, pos));
        }
        if !self.holds_handle {
            return false;
        }
        let now = ui.input(|i| i.time);
        if !response.dragged_by(left) {
            self.holds_handle = false;
            self.rest(now);
            return false;
        }
        let held = self.tilt_handle().zip(response.interact_pointer_pos());
        if let Some(((handle, before), pos)) = held {
            let aspect = rect.width() / rect.height().max(1.0);
            let at = super::viewport::picture_point(rect, pos);
            let (origin, direction) = self.camera.ray(at, aspect);
            if let Some(tilt) = handle.dragged(origin, direction, before)
                && tilt != before
            {
                match self.project.tilt(tilt, true) {
                    Ok(true) => self.changed(true, now),
                    Ok(false) => {}
                    Err(problem) => self.said = problem,
                }
            }
        }
        true
    }
}
