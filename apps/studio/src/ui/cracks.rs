//! Placing drying cracks by hand: a drag over the wood makes one, and its dots are dragged.

use super::colours::ACCENT;
use super::crack_tool::Held;
use super::studio::Studio;
use crate::model::placed_cracks::{
    CrackEndPoint, CrackFace, Polar, course, crack_of_drag, depth, describe, dragged_to, with_depth,
};
use crate::view::pick::{Picked, pick};
use eframe::egui::{self, Color32, Key, Modifiers, Pos2, Rect, RichText, Shape, Stroke, Ui, Vec2};
use greenstick::fracture::parameters::Crack;
use std::sync::Arc;

/// Radius of a dot, points, and of what takes hold of it.
const DOT: f32 = 5.0;
const HOLD: f32 = 10.0;
/// Ring coordinate from which on a point lies on the bark.
const BARK: f32 = 0.96;
/// Least depth of a crack that begins on the bark, radii.
const SHALLOWEST: f32 = 0.3;

impl Studio {
    /// Switches the tool on or off.
    pub(super) fn toggle_cracks(&mut self) {
        self.cracks.on ^= true;
        self.cracks.held = None;
        self.paint.on &= !self.cracks.on;
        self.said = match self.cracks.on {
            true => "Drag over the broken wood, or over a sawn end, to place a crack.".to_owned(),
            false => String::new(),
        };
    }

    /// The broken face below the selected break as it is drawn.
    pub fn face(&mut self) -> Option<Arc<CrackFace>> {
        self.crack_face()
    }

    pub(super) fn crack_face(&mut self) -> Option<Arc<CrackFace>> {
        let (id, drawn) = self.drawn.clone()?;
        let number = self.project.selected().unwrap_or(0);
        let known = self.cracks.face.as_ref();
        if known.is_none_or(|f| (f.0, f.1) != (id, number)) {
            let face = CrackFace::new(&drawn, number).map(Arc::new);
            self.cracks.face = Some((id, number, face));
        }
        self.cracks.face.as_ref().and_then(|f| f.2.clone())
    }

    /// Whether cracks cannot be placed here by hand, and why.
    pub(super) fn why_no_cracks(&self) -> Option<&'static str> {
        let kind = self.shown.as_ref().map(|s| s.report.place.kind.as_str());
        match kind {
            Some("board" | "dowel") => Some(
                "The rings of a board are arcs: set its cracks by their parameters, under Drying cracks.",
            ),
            _ => None,
        }
    }

    /// The dots of the cracks in the window: the number of each, the part, where, and at which height over the break's.
    fn crack_dots(&self, rect: Rect, face: &CrackFace) -> Vec<(usize, CrackEndPoint, Pos2, f32)> {
        let mut dots = Vec::new();
        for (number, crack) in self.project.placed_cracks().iter().enumerate() {
            let course = course(crack);
            let (first, last) = (course[0], course[course.len() - 1]);
            let end = face.height(last);
            let bottom = end - depth(crack) as f32 * face.radius();
            for (part, place, height) in [
                (CrackEndPoint::Begin, first, face.height(first)),
                (CrackEndPoint::End, last, end),
                (CrackEndPoint::Depth, last, bottom),
            ] {
                if let Some(pos) = self.in_window(rect, face.point(place, height)) {
                    dots.push((number, part, pos, height));
                }
            }
        }
        dots
    }

    /// Where the dot of a crack's part is in the window.
    pub fn crack_dot(&mut self, number: usize, part: CrackEndPoint) -> Option<Pos2> {
        let (rect, face) = (self.viewport_rect?, self.crack_site()?);
        let dots = self.crack_dots(rect, &face);
        let found = dots.into_iter().find(|d| (d.0, d.1) == (number, part));
        found.map(|d| d.2)
    }

    /// Where a place on the broken face is in the window: its ring coordinate, and angle about the pith (rad).
    pub fn face_place_at(&mut self, rho: f32, angle: f32) -> Option<Pos2> {
        let (rect, face) = (self.viewport_rect?, self.crack_face()?);
        let place = (rho, angle);
        self.in_window(rect, face.point(place, face.height(place)))
    }

    /// Where a place on the sawn end at the tip, or on that at the base, is in the window.
    pub fn end_place_at(&mut self, far: bool, rho: f32, angle: f32) -> Option<Pos2> {
        let (rect, face) = (self.viewport_rect?, self.end_face(far)?);
        let place = (rho, angle);
        self.in_window(rect, face.point(place, face.height(place)))
    }

    /// Draws the cracks and their dots.
    pub(super) fn paint_cracks(&mut self, ui: &Ui, rect: Rect, response: &egui::Response) {
        if !self.cracks.on {
            return;
        }
        let Some(face) = self.crack_site() else {
            return;
        };
        let painter = ui.painter_at(rect);
        for (number, crack) in self.project.placed_cracks().iter().enumerate() {
            let color = if self.cracks.selected == Some(number) {
                ACCENT
            } else {
                Color32::from_rgb(250, 222, 120)
            };
            let course = course(crack);
            let seen =
                |place: &Polar| self.in_window(rect, face.point(*place, face.height(*place)));
            let line: Option<Vec<Pos2>> = course.iter().map(seen).collect();
            if let Some(line) = line {
                painter.line(
                    line.clone(),
                    Stroke::new(4.5, Color32::from_black_alpha(170)),
                );
                painter.line(line, Stroke::new(1.8, color));
            }
            let last = course[course.len() - 1];
            let deep = depth(crack) as f32 * face.radius();
            let top = face.height(last);
            let ends = [top, top - deep].map(|h| self.in_window(rect, face.point(last, h)));
            if let [Some(top), Some(bottom)] = ends {
                let dashes = Shape::dashed_line(&[top, bottom], Stroke::new(1.8, color), 6.0, 4.0);
                painter.extend(dashes);
            }
        }
        let pointer = response.hover_pos();
        for (number, part, pos, _) in self.crack_dots(rect, &face) {
            let over = pointer.is_some_and(|p| p.distance(pos) <= HOLD);
            let fill = if self.cracks.selected == Some(number) {
                ACCENT
            } else {
                Color32::from_rgb(250, 222, 120)
            };
            let radius = if over { DOT + 2.0 } else { DOT };
            if part == CrackEndPoint::Depth {
                let square = Rect::from_center_size(pos, Vec2::splat(1.7 * radius));
                painter.rect(
                    square,
                    1.0,
                    fill,
                    Stroke::new(1.0, Color32::BLACK),
                    egui::StrokeKind::Outside,
                );
            } else {
                painter.circle(pos, radius, fill, Stroke::new(1.0, Color32::BLACK));
            }
        }
    }

    /// Places and drags cracks with the pointer; returns whether it holds one.
    pub(super) fn drag_crack(&mut self, ui: &Ui, rect: Rect, response: &egui::Response) -> bool {
        if !self.cracks.on {
            return false;
        }
        let left = egui::PointerButton::Primary;
        let (pressed, modifiers, now) =
            ui.input(|i| (i.pointer.press_origin(), i.modifiers, i.time));
        if response.clicked_by(left)
            && let Some(pos) = response.interact_pointer_pos()
        {
            self.click_crack(rect, pos, now);
            return true;
        }
        if response.drag_started_by(left)
            && modifiers.is_none()
            && let Some(pos) = pressed
        {
            self.hold_crack(rect, pos);
        }
        let Some(held) = self.cracks.held.clone() else {
            return false;
        };
        if !response.dragged_by(left) {
            self.cracks.held = None;
            self.rest(now);
            return false;
        }
        let pos = response.interact_pointer_pos();
        if let (Some(pos), Some(face)) = (pos, self.crack_site()) {
            self.move_crack(rect, &face, held, pos, now);
        }
        true
    }

    /// The place in the section and the height over the break's, m, of what is under the pointer on the piece below the break. On
    /// its face this is the point of the surface that cracks are drawn on, so that neither splinters nor the gaps between them
    /// displace it; what hangs down from the piece above is looked through.
    pub(super) fn place_on_face(
        &self,
        rect: Rect,
        face: &CrackFace,
        pos: Pos2,
    ) -> Option<(Polar, f32)> {
        let drawn = &self.drawn.as_ref()?.1;
        let number = self.project.selected().unwrap_or(0);
        let ray = self.ray_at(rect, pos);
        let picked = pick(drawn, ray, Some(drawn.piece_below(number)?));
        let picked = picked.and_then(|picked| self.grain_place(face, &picked));
        let is_bark = |place: &Polar| place.0 >= BARK && face.is_outside(place.1, ray.1);
        match picked {
            Some((place, _)) if is_bark(&place) => picked,
            _ => face.seen(ray).or(picked),
        }
    }

    /// The place in the section and the height over the break's, m, of a point of the stem.
    pub(super) fn grain_place(&self, face: &CrackFace, picked: &Picked) -> Option<(Polar, f32)> {
        let number = self.project.selected().unwrap_or(0);
        let at = self.drawn.as_ref()?.1.breaks.get(number)?.length;
        let grain = picked.grain?;
        Some((face.polar(grain.truncate()), grain.z - at))
    }

    fn dot_at(
        &self,
        rect: Rect,
        face: &CrackFace,
        pos: Pos2,
    ) -> Option<(usize, CrackEndPoint, f32)> {
        let dots = self.crack_dots(rect, face).into_iter();
        let near = dots.filter(|d| d.2.distance(pos) <= HOLD);
        let nearest = near.min_by(|a, b| a.2.distance(pos).total_cmp(&b.2.distance(pos)));
        nearest.map(|d| (d.0, d.1, d.3))
    }

    fn hold_crack(&mut self, rect: Rect, pos: Pos2) {
        let Some(face) = self.crack_site() else {
            return;
        };
        if let Some((number, part, height)) = self.dot_at(rect, &face, pos) {
            self.cracks.selected = Some(number);
            self.cracks.held = Some(Held::Part(number, part, height));
            return;
        }
        match self.choose_site(rect, pos) {
            Err(why) => self.said = why.to_owned(),
            Ok(Some((_, place, height))) => {
                self.cracks.held = Some(Held::New(place, height, None));
            }
            Ok(None) => {}
        }
    }

    fn click_crack(&mut self, rect: Rect, pos: Pos2, now: f64) {
        let Some(face) = self.crack_site() else {
            return;
        };
        if let Some((number, _, _)) = self.dot_at(rect, &face, pos) {
            self.cracks.selected = Some(number);
            return;
        }
        let site = match self.choose_site(rect, pos) {
            Ok(Some(site)) => Ok(site),
            Err(why) => Err(why),
            Ok(None) => {
                // A click on another piece places a crack as well: it is the same wood.
                let picked = self.picked(rect, pos);
                let place = picked.and_then(|picked| self.grain_place(&face, &picked));
                let place = place.map(|(place, height)| (face, place, height));
                place.ok_or("That is not the stem.")
            }
        };
        let (face, place, height) = match site {
            Ok(site) => site,
            Err(why) => {
                self.said = why.to_owned();
                return;
            }
        };
        let end = self.site_end();
        let crack = drawn_crack(&face, (place, height), (place, height));
        self.cracks.selected = Some(self.project.placed_cracks().len());
        let added = self.project.change_cracks("crack", false, |cracks| {
            cracks.settings.end = end;
            cracks.cracks.push(crack.clone());
        });
        self.said = describe(&crack);
        self.finish_step(added, now);
    }

    fn move_crack(&mut self, rect: Rect, face: &CrackFace, held: Held, pos: Pos2, now: f64) {
        let (origin, direction) = self.ray_at(rect, pos);
        let (number, crack) = match held {
            Held::New(from, height, number) => {
                let on_bark = from.0 >= BARK;
                let under = self.place_on_site(rect, face, pos);
                // Beside the stem, the face goes on at the height where the drag began.
                let beside = || Some((face.met(origin, direction, height)?, height));
                let to = if on_bark {
                    under
                } else {
                    under.or_else(beside)
                };
                let Some(to) = to else { return };
                let number = number.unwrap_or(self.project.placed_cracks().len());
                self.cracks.held = Some(Held::New(from, height, Some(number)));
                (number, drawn_crack(face, (from, height), to))
            }
            Held::Part(number, CrackEndPoint::Depth, _) => {
                let Some(crack) = self.project.placed_cracks().get(number) else {
                    return;
                };
                let course = course(crack);
                let last = course[course.len() - 1];
                let Some(height) = face.height_met(origin, direction, last) else {
                    return;
                };
                let deep = (face.height(last) - height) / face.radius();
                (number, with_depth(crack, deep))
            }
            Held::Part(number, part, height) => {
                let crack = self.project.placed_cracks().get(number);
                let met = face.met(origin, direction, height);
                let (Some(crack), Some(to)) = (crack, met) else {
                    return;
                };
                (number, dragged_to(crack, part, to))
            }
        };
        self.cracks.selected = Some(number);
        self.put_crack(number, &crack, now);
    }

    /// Puts a crack in the place of one, or after the last, as part of a drag.
    fn put_crack(&mut self, number: usize, crack: &Crack, now: f64) {
        let end = self.site_end();
        let put = self.project.change_cracks("crack", true, |cracks| {
            match cracks.cracks.get_mut(number) {
                Some(known) => *known = crack.clone(),
                None => {
                    cracks.settings.end = end;
                    cracks.cracks.push(crack.clone());
                }
            }
        });
        match put {
            Ok(true) => {
                self.said = describe(crack);
                self.changed(true, now);
            }
            Ok(false) => {}
            Err(problem) => self.said = problem,
        }
    }

    /// Takes the selected crack away.
    fn remove_crack(&mut self, now: f64) {
        let Some(number) = self.cracks.selected.take() else {
            self.said = "Click on the dot of a crack first.".to_owned();
            return;
        };
        let removed = self
            .project
            .change_cracks("crack taken away", false, |cracks| {
                if number < cracks.cracks.len() {
                    cracks.cracks.remove(number);
                }
            });
        self.finish_step(removed, now);
    }

    /// The keys of the tool, before those of all else.
    pub(super) fn crack_keys(&mut self, ctx: &egui::Context) {
        if !self.cracks.on || self.dialog.is_some() || ctx.text_edit_focused() {
            return;
        }
        let pressed = |key| ctx.input_mut(|i| i.consume_key(Modifiers::NONE, key));
        let selected = self.cracks.selected.is_some();
        if selected && (pressed(Key::Delete) || pressed(Key::Backspace)) {
            self.remove_crack(ctx.input(|i| i.time));
        } else if self.at_work.is_none() && pressed(Key::Escape) {
            self.toggle_cracks();
        }
    }

    /// The line about the tool, while it is on.
    pub(super) fn cracks_bar(&mut self, ui: &mut Ui) {
        if !self.cracks.on {
            return;
        }
        let now = ui.input(|i| i.time);
        ui.horizontal(|ui| {
            ui.label("Cracks");
            if let Some(why) = self.why_no_cracks() {
                ui.weak(why);
                return;
            }
            let placed = self.project.placed_cracks().len();
            for number in 0..placed {
                let label = (number + 1).to_string();
                let chosen = self.cracks.selected == Some(number);
                let about = describe(&self.project.placed_cracks()[number]);
                if ui.selectable_label(chosen, label).on_hover_text(about).clicked() {
                    self.cracks.selected = Some(number);
                }
            }
            self.crack_end_choice(ui, now);
            let chosen = self.cracks.selected.filter(|n| *n < placed);
            let remove = ui.add_enabled(chosen.is_some(), egui::Button::new("Remove crack"));
            if remove.on_hover_text("Takes the selected crack away (Delete).").clicked() {
                self.remove_crack(now);
            }
            let text = match chosen {
                Some(number) => describe(&self.project.placed_cracks()[number]),
                None => "Drag over the broken wood or a sawn end: along a ray, or around the pith for a ring shake. On the bark, along the stem."
                    .to_owned(),
            };
            // A row more would shift the picture under the pointer.
            ui.add(egui::Label::new(RichText::new(text).weak()).truncate());
        });
    }
}

/// The crack that a drag means from a place of the section to another, each with its height over the break's, m. One that begins on
/// the bark reaches down to where the pointer is there.
fn drawn_crack(face: &CrackFace, from: (Polar, f32), to: (Polar, f32)) -> Crack {
    let ((from, began), (to, height)) = (from, to);
    if from.0 < BARK {
        return crack_of_drag(from, to);
    }
    let edge = face.height((1.0, from.1));
    let on_bark = to.0 >= BARK;
    let lowest = if on_bark { height } else { began };
    let deep = (edge - lowest) / face.radius();
    let inwards = if on_bark { from } else { to };
    with_depth(&crack_of_drag(from, inwards), deep.max(SHALLOWEST))
}
