//! The handles of the ductile zone and of the high and low layers: their outline on the broken wood, and dots that are dragged.

use super::colours::ACCENT;
use super::fan_tool::{FanGrip, HeldFan};
use super::labels::paint_label;
use super::studio::Studio;
use crate::model::fan::{Fan, FanKind, FanPart};
use crate::model::placed_cracks::{CrackFace, Polar};
use crate::model::tilt::on_cylinder;
use eframe::egui::{
    self, Color32, ComboBox, CursorIcon, Mesh, Pos2, Rect, Shape, Stroke, Ui, Vec2,
};
use std::sync::Arc;

/// Radius of a dot, points, and of what takes hold of it.
const DOT: f32 = 5.5;
const HOLD: f32 = 11.0;
/// Degrees from point to point of an outline, and steps from the pith to the bark.
const STEP: f64 = 6.0;
const STEPS: usize = 6;
/// How far an edge goes down the stem, radii.
const DOWN: f32 = 1.1;
/// How nearly along the stem one looks where the pointer is on the face and not on the bark: the cosine.
const FROM_ABOVE: f32 = 0.8;
/// Opacity of the outline, in front and behind, and of the fan's surface.
const FRONT: u8 = 230;
const BEHIND: u8 = 70;
const FILL: u8 = 46;

fn radians(degrees: f64) -> f32 {
    degrees.to_radians() as f32
}

fn accent(alpha: u8) -> Color32 {
    Color32::from_rgba_unmultiplied(ACCENT.r(), ACCENT.g(), ACCENT.b(), alpha)
}

impl Studio {
    /// The break whose handles are shown: the selected one, or the only one.
    pub(super) fn handled_break(&self) -> Option<usize> {
        let (_, drawn) = self.drawn.as_ref()?;
        let count = self.project.break_count();
        let number = if count == 1 {
            0
        } else {
            self.project.selected()?
        };
        (drawn.breaks.len() == count).then_some(number)
    }

    /// The fan that has the handles, as it is drawn, and the face that it lies on.
    fn handled_fan(&mut self) -> Option<(FanKind, Fan, Arc<CrackFace>)> {
        let kind = self.fans.kind.filter(|_| self.view.handles)?;
        let number = self.handled_break()?;
        // What was measured has its own heights; the zone of splinters still acts.
        if self.project.has_own_heights(number) && kind != FanKind::Ductile {
            return None;
        }
        let face = self.crack_face()?;
        let fan = self.project.fan(number, kind).or_first(kind);
        Some((kind, fan, face))
    }

    /// The place of a part in the section, and its height over the break's, m.
    fn part_place(fan: &Fan, part: FanPart, face: &CrackFace) -> (Polar, f32) {
        let (start, end) = fan.edges();
        let place = match part {
            FanPart::Start => (1.0, radians(start)),
            FanPart::End => (1.0, radians(end)),
            FanPart::Middle => (1.0, radians(fan.direction)),
            FanPart::Inner => (fan.inner() as f32, radians(fan.direction)),
        };
        (place, face.height(place))
    }

    /// Where the dot of a part is in the window, where the handles of a fan are shown.
    pub fn fan_dot(&mut self, part: FanPart) -> Option<Pos2> {
        let rect = self.viewport_rect?;
        let (_, fan, face) = self.handled_fan()?;
        let (place, height) = Self::part_place(&fan, part, &face);
        self.in_window(rect, face.point(place, height))
    }

    /// The part whose dot is at a point of the window.
    pub(super) fn fan_part_at(&mut self, pos: Pos2) -> Option<FanPart> {
        let dots = FanPart::ALL.map(|part| (part, self.fan_dot(part)));
        let near = dots
            .into_iter()
            .filter_map(|(part, dot)| Some((part, dot?.distance(pos))));
        let near = near.filter(|d| d.1 <= HOLD);
        near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|d| d.0)
    }

    /// Where the pointer is about the stem, as a drag of a part means it.
    fn fan_grip(
        &self,
        rect: Rect,
        pos: Pos2,
        (part, fan): (FanPart, &Fan),
        face: &CrackFace,
    ) -> Option<FanGrip> {
        let ray = self.ray_at(rect, pos);
        let (place, height) = Self::part_place(fan, part, face);
        let along = face.along();
        let from_above = ray.1.dot(along).abs() > FROM_ABOVE;
        let (met, raised) = if part == FanPart::Inner || from_above {
            (face.met(ray.0, ray.1, height)?, None)
        } else {
            let dot = face.point(place, height);
            let axis = (face.point_across(glam::Vec2::ZERO, 0.0), along);
            let point = on_cylinder(axis, ray, dot)?;
            let across = face.across_of(point);
            (face.polar(across), Some((point - axis.0).dot(along)))
        };
        Some(FanGrip {
            angle: f64::from(met.1).to_degrees(),
            rho: f64::from(met.0),
            height: raised.map(f64::from),
        })
    }

    /// Drags a part of the fan with the pointer; returns whether one is held.
    pub(super) fn drag_fan(&mut self, ui: &Ui, rect: Rect, response: &egui::Response) -> bool {
        let left = egui::PointerButton::Primary;
        let (pressed, modifiers, now) =
            ui.input(|i| (i.pointer.press_origin(), i.modifiers, i.time));
        if response.drag_started_by(left)
            && modifiers.is_none()
            && let Some(pos) = pressed
        {
            self.hold_fan(rect, pos);
        }
        let Some(held) = self.fans.held else {
            return false;
        };
        let fan = self.handled_fan();
        let (Some((kind, fan, face)), true) = (fan, response.dragged_by(left)) else {
            self.fans.held = None;
            self.rest(now);
            return false;
        };
        let pos = response.interact_pointer_pos();
        let grip = pos.and_then(|pos| self.fan_grip(rect, pos, (held.part, &fan), &face));
        if let Some(grip) = grip {
            let HeldFan { before, from, .. } = held;
            let turn = grip.angle - from.angle;
            let raised = grip.height.zip(from.height);
            let raise = raised.map_or(0.0, |(to, from)| (to - from) / f64::from(face.radius()));
            let (start, end) = before.edges();
            let next = match held.part {
                FanPart::Start => fan.with_edge(FanPart::Start, start + turn),
                FanPart::End => fan.with_edge(FanPart::End, end + turn),
                FanPart::Middle => fan.with_middle(
                    kind,
                    before.direction + turn,
                    before.height.unwrap_or(0.0) + raise,
                ),
                FanPart::Inner => fan.with_inner(before.inner() + grip.rho - from.rho),
            };
            match self.project.lay_fan(kind, next, true) {
                Ok(true) => self.changed(true, now),
                Ok(false) => {}
                Err(problem) => self.said = problem,
            }
        }
        true
    }

    fn hold_fan(&mut self, rect: Rect, pos: Pos2) {
        let Some(part) = self.fan_part_at(pos) else {
            return;
        };
        let Some((_, before, face)) = self.handled_fan() else {
            return;
        };
        let from = self.fan_grip(rect, pos, (part, &before), &face);
        self.fans.held = from.map(|from| HeldFan { part, before, from });
    }

    /// Draws the fan on the broken wood, and its dots, while the pointer is in the viewport.
    pub(super) fn paint_fan(&mut self, ui: &Ui, rect: Rect, response: &egui::Response) {
        let turning = response.dragged() && self.fans.held.is_none();
        if !response.contains_pointer() && self.fans.held.is_none() || turning {
            return;
        }
        let Some((kind, fan, face)) = self.handled_fan() else {
            return;
        };
        let number = self.handled_break().unwrap_or(0);
        let is_there = self.project.fan(number, kind).is_there();
        let painter = ui.painter_at(rect);
        self.paint_fan_surface(&painter, rect, &fan, &face);
        self.paint_fan_outline(&painter, rect, (&fan, is_there), &face);
        let pointer = response.hover_pos();
        let over = match self.fans.held {
            Some(held) => Some(held.part),
            None => pointer.and_then(|p| self.fan_part_at(p)),
        };
        for part in FanPart::ALL {
            if let Some(dot) = self.fan_dot(part) {
                paint_dot(&painter, dot, part, over == Some(part));
            }
        }
        let Some((part, dot)) = over.and_then(|part| Some((part, self.fan_dot(part)?))) else {
            return;
        };
        ui.ctx().set_cursor_icon(if self.fans.held.is_some() {
            CursorIcon::Grabbing
        } else {
            CursorIcon::Grab
        });
        paint_label(&painter, dot, describe(kind, &fan, part), ACCENT);
    }

    /// The wood of the fan, tinted.
    fn paint_fan_surface(&self, painter: &egui::Painter, rect: Rect, fan: &Fan, face: &CrackFace) {
        let (start, _) = fan.edges();
        let turns = (fan.angle / STEP).ceil().max(1.0) as usize;
        let mut mesh = Mesh::default();
        for i in 0..=turns {
            for k in 0..=STEPS {
                let rho = fan.inner() + fan.rings * k as f64 / STEPS as f64;
                let angle = start + fan.angle * i as f64 / turns as f64;
                let place = (rho as f32, radians(angle));
                let point = face.point(place, face.height(place));
                let Some(pos) = self.in_window(rect, point) else {
                    return;
                };
                mesh.colored_vertex(pos, accent(FILL));
            }
        }
        let row = STEPS as u32 + 1;
        for i in 0..turns as u32 {
            for k in 0..STEPS as u32 {
                let a = i * row + k;
                mesh.add_triangle(a, a + 1, a + row);
                mesh.add_triangle(a + 1, a + row + 1, a + row);
            }
        }
        painter.add(Shape::mesh(mesh));
    }

    /// Its outline, with its edges going on down the stem; dashed where a drag would only make it, faint behind the stem.
    fn paint_fan_outline(
        &self,
        painter: &egui::Painter,
        rect: Rect,
        (fan, is_there): (&Fan, bool),
        face: &CrackFace,
    ) {
        let (start, end) = fan.edges();
        let turns = (fan.angle / STEP).ceil().max(1.0) as usize;
        let at = |i: usize| start + fan.angle * i as f64 / turns as f64;
        let on_face = |rho: f64, angle: f64| {
            let place = (rho as f32, radians(angle));
            (place, face.height(place))
        };
        let arc = |rho: f64| -> Vec<_> { (0..=turns).map(|i| on_face(rho, at(i))).collect() };
        let mut lines = vec![arc(1.0)];
        if fan.inner() > 0.0 {
            lines.push(arc(fan.inner()));
        }
        if fan.angle < 360.0 {
            for edge in [start, end] {
                let inwards = (0..=STEPS).map(|k| {
                    let rho = fan.inner() + fan.rings * k as f64 / STEPS as f64;
                    on_face(rho, edge)
                });
                lines.push(inwards.collect());
                let (rim, height) = on_face(1.0, edge);
                lines.push(vec![(rim, height), (rim, height - DOWN * face.radius())]);
            }
        }
        for line in lines {
            for pair in line.windows(2) {
                let ends = [pair[0], pair[1]].map(|(p, h)| self.in_window(rect, face.point(p, h)));
                let [Some(from), Some(to)] = ends else {
                    continue;
                };
                let towards = self.ray_at(rect, from).1;
                let on_bark = pair[0].0.0 >= 1.0 && pair[1].0.0 >= 1.0;
                let hidden = on_bark && !face.is_outside(pair[0].0.1, towards);
                let alpha = if hidden { BEHIND } else { FRONT };
                let stroke = Stroke::new(1.8, accent(alpha));
                if is_there {
                    painter.line_segment([from, to], stroke);
                } else {
                    painter.extend(Shape::dashed_line(&[from, to], stroke, 4.0, 4.0));
                }
            }
        }
    }

    /// The choice of what the handles act on.
    pub(super) fn handle_choice(&mut self, ui: &mut Ui) {
        if !self.view.handles {
            return;
        }
        let name = |kind: Option<FanKind>| match kind {
            None => ("Plane", "Tilts and turns the plane of the break."),
            Some(FanKind::Ductile) => (
                "Ductile",
                "The zone of long splinters: its two edges, its middle, and its bound towards the pith.",
            ),
            Some(FanKind::High) => (
                "High",
                "The layer that stands higher: its two edges, its height and direction, and its bound towards the pith.",
            ),
            Some(FanKind::Low) => (
                "Low",
                "The layer that stands lower: its two edges, its height and direction, and its bound towards the pith.",
            ),
        };
        ComboBox::from_id_salt("handles")
            .selected_text(name(self.fans.kind).0)
            .width(58.0)
            .show_ui(ui, |ui| {
                for kind in HANDLES {
                    let (label, about) = name(kind);
                    ui.selectable_value(&mut self.fans.kind, kind, label)
                        .on_hover_text(about);
                }
            })
            .response
            .on_hover_text(
                "What the handles in the picture act on (Shift H). A painted face has no plane and no layers but those of \
                 the paint.",
            );
    }

    /// Gives the handles to the next that can have them.
    pub(super) fn next_handles(&mut self) {
        let at = HANDLES.iter().position(|k| *k == self.fans.kind);
        let next = at.map_or(0, |i| (i + 1) % HANDLES.len());
        self.fans.kind = HANDLES[next];
        self.fans.held = None;
        self.view.handles = true;
        let name = self.fans.kind.map_or("plane of the break", FanKind::label);
        self.said = format!("Handles of the {name}.");
    }
}

/// What handles can act on.
const HANDLES: [Option<FanKind>; 4] = [
    None,
    Some(FanKind::Ductile),
    Some(FanKind::High),
    Some(FanKind::Low),
];

/// What a part of a fan is set to, in words.
fn describe(kind: FanKind, fan: &Fan, part: FanPart) -> String {
    let (start, end) = fan.edges();
    let [start, end] = [start, end].map(|a| a.rem_euclid(360.0));
    match (part, fan.height) {
        (FanPart::Start | FanPart::End, _) => {
            format!("{}, {start:.0}° to {end:.0}°", kind.label())
        }
        (FanPart::Inner, _) => format!("outer {:.0} % of the rings", 100.0 * fan.rings),
        (FanPart::Middle, None) => format!("{}, direction {:.0}°", kind.label(), fan.direction),
        (FanPart::Middle, Some(height)) => format!(
            "{}, height {height:.2} radii, direction {:.0}°",
            kind.label(),
            fan.direction
        ),
    }
}

/// A dot: round on an edge, a diamond in the middle, a square on the bound towards the pith.
fn paint_dot(painter: &egui::Painter, dot: Pos2, part: FanPart, over: bool) {
    let radius = if over { DOT + 2.0 } else { DOT };
    let line = Stroke::new(1.0, Color32::BLACK);
    match part {
        FanPart::Start | FanPart::End => {
            painter.circle(dot, radius, ACCENT, line);
        }
        FanPart::Inner => {
            let square = Rect::from_center_size(dot, Vec2::splat(1.7 * radius));
            painter.rect(square, 1.0, ACCENT, line, egui::StrokeKind::Outside);
        }
        FanPart::Middle => {
            let r = 1.3 * radius;
            let corners = [(0.0, -r), (r, 0.0), (0.0, r), (-r, 0.0)];
            let corners = corners.map(|(x, y)| dot + Vec2::new(x, y)).to_vec();
            painter.add(Shape::convex_polygon(corners, ACCENT, line));
        }
    }
}
