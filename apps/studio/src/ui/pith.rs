//! The pith and the onset of eccentricity in the section browser, dragged to where they are.

use super::colours::ACCENT;
use super::section_picture::Lie;
use super::studio::Studio;
use crate::model::rings::PithPart;
use crate::model::section_book::{RingShape, SectionBook, SectionRings};
use eframe::egui::{
    self, Color32, CursorIcon, Painter, PointerButton, Pos2, Shape, Stroke, Ui, Vec2,
};
use std::f64::consts::{FRAC_PI_4, TAU};
use std::sync::Arc;

/// How near the pointer has to be to take hold, points.
const HOLD: f32 = 8.0;
/// Angle about the pith at which the onset has its dot.
const DOT_ANGLE: f64 = FRAC_PI_4;
/// Least distance of that dot from the pith, points, so that both can be taken hold of.
const APART: f32 = 18.0;
/// Points of the line of the onset.
const POINTS: i32 = 120;

impl Studio {
    /// Where the pith is in the picture of the section.
    pub fn pith_dot(&self) -> Option<Pos2> {
        let (_, lie) = self.anatomy.lie?;
        Some(lie.window(self.anatomy.rings.as_ref()?.2.pith()))
    }

    /// Where the dot of the onset of eccentricity is in the picture of the section, where a stem has one.
    pub fn onset_dot(&self) -> Option<Pos2> {
        let (_, lie) = self.anatomy.lie?;
        onset_dot(&lie, &self.anatomy.rings.as_ref()?.2)
    }

    fn pith_part_at(&self, pos: Pos2) -> Option<PithPart> {
        let near = |dot: Option<Pos2>| dot.is_some_and(|d| d.distance(pos) <= HOLD);
        if near(self.pith_dot()) {
            Some(PithPart::Pith)
        } else {
            near(self.onset_dot()).then_some(PithPart::Onset)
        }
    }

    /// Drags the pith or the onset with the pointer; returns whether one of them is held or under the pointer.
    pub(super) fn drag_pith(
        &mut self,
        ui: &Ui,
        book: &SectionBook,
        index: usize,
        lie: &Lie,
        response: &egui::Response,
    ) -> bool {
        let (now, pressed) = ui.input(|i| (i.time, i.pointer.press_origin()));
        let pos = response.interact_pointer_pos().or(response.hover_pos());
        let Some(pos) = pos else { return false };
        let left = PointerButton::Primary;
        if response.drag_started_by(left) {
            self.anatomy.pith_held = pressed.and_then(|p| self.pith_part_at(p));
        }
        if let Some(part) = self.anatomy.pith_held {
            if response.dragged_by(left) {
                self.move_pith(book, index, part, (lie, pos), now);
            } else {
                self.anatomy.pith_held = None;
                self.rest(now);
            }
            return true;
        }
        let over = self.pith_part_at(pos);
        if over.is_some() {
            ui.set_cursor_icon(CursorIcon::Grab);
        }
        if let Some(part) = over.filter(|_| response.double_clicked()) {
            let freed = self.project.free_pith(part);
            self.finish_step(freed, now);
        }
        over.is_some()
    }

    fn move_pith(
        &mut self,
        book: &SectionBook,
        index: usize,
        part: PithPart,
        (lie, pos): (&Lie, Pos2),
        now: f64,
    ) {
        let Some((number, _, rings)) = self.anatomy.rings.clone() else {
            return;
        };
        let section = &book.sections[index];
        let at = lie.section(pos);
        let mut shape: RingShape = section.rings;
        shape.pith = rings.pith().to_array();
        shape.onset = rings.onset();
        let moved = match part {
            PithPart::Pith if !book.sawn && !section.contains(at) => return,
            PithPart::Pith => {
                shape.pith = at.to_array();
                self.project.set_pith(section, index == book.at_break, at)
            }
            PithPart::Onset => {
                let onset = self.project.set_onset(rings.address(at).0);
                onset.map(|(onset, changed)| {
                    shape.onset = Some(onset);
                    changed
                })
            }
        };
        match moved {
            Ok(changed) => {
                let rings = section.rings_of(&shape);
                self.anatomy.rings = Some((number, index, Arc::new(rings)));
                if changed {
                    self.changed(true, now);
                }
            }
            Err(problem) => self.said = problem,
        }
    }
}

/// Where the dot of the onset is in the window, where there is an onset.
fn onset_dot(lie: &Lie, rings: &SectionRings) -> Option<Pos2> {
    let pith = lie.window(rings.pith());
    let off = lie.window(rings.point(rings.onset()?, DOT_ANGLE)) - pith;
    let direction = Vec2::new(DOT_ANGLE.cos() as f32, -DOT_ANGLE.sin() as f32);
    Some(pith + direction * off.length().max(APART))
}

/// Draws the pith as a cross, and the ring at which the stem began to lean as a dashed line with a dot.
pub(super) fn paint_pith_and_onset(
    painter: &Painter,
    lie: &Lie,
    rings: &SectionRings,
    pointer: Option<Pos2>,
) {
    let near = |dot: Pos2| pointer.is_some_and(|p| p.distance(dot) <= HOLD);
    if let Some(onset) = rings.onset() {
        let point = |k: i32| lie.window(rings.point(onset, TAU * f64::from(k) / f64::from(POINTS)));
        let line: Vec<Pos2> = (0..=POINTS).map(point).collect();
        for (color, width) in [(Color32::from_black_alpha(150), 2.5), (Color32::WHITE, 1.0)] {
            let stroke = Stroke::new(width, color);
            painter.extend(Shape::dashed_line(&line, stroke, 5.0, 4.0));
        }
    }
    if let Some(dot) = onset_dot(lie, rings) {
        let (radius, fill) = match near(dot) {
            true => (6.0, ACCENT),
            false => (4.5, Color32::WHITE),
        };
        painter.circle(dot, radius, fill, Stroke::new(1.0, Color32::BLACK));
    }
    let at = lie.window(rings.pith());
    let (arm, color) = match near(at) {
        true => (9.0, ACCENT),
        false => (6.0, Color32::WHITE),
    };
    for (color, width) in [(Color32::from_black_alpha(160), 3.5), (color, 1.5)] {
        for arm in [Vec2::new(arm, 0.0), Vec2::new(0.0, arm)] {
            painter.line_segment([at - arm, at + arm], Stroke::new(width, color));
        }
    }
}
