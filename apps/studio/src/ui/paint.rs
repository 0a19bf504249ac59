//! Painting on the broken wood: strokes of a brush, its cursor, and what is painted.

use super::colours::ACCENT;
use super::paint_tool::Stroke;
use super::studio::Studio;
use crate::model::painted::{BrushKind, Dab, Site, middles};
use crate::model::placed_cracks::{BARK, CrackFace, Polar};
use eframe::egui::{
    self, Color32, Key, Mesh, Modifiers, PointerButton, Pos2, Rect, RichText, Shape, Ui,
};
use greenstick::fracture::height_grid::HeightGrid;
use greenstick::fracture::heights::FailureMode;

/// Distance between the dabs of a stroke, in sizes of the brush, and most dabs from frame to frame.
const SPACING: f32 = 0.25;
const MOST_DABS: f32 = 24.0;
/// Sizes of the brush, radii, and the factor from key to key.
const SIZES: std::ops::RangeInclusive<f64> = 0.05..=2.0;
const SIZE_STEP: f64 = 1.2;
/// Splintering over that of the species from which on wood is tinted, below and above it.
const TINTED: (f64, f64) = (0.75, 1.2);
/// Opacity of the strongest tint.
const TINT: f64 = 75.0;

/// The tint of a cell, transparent where its splinters are about those of the species, which `unit` is in the grid's numbers.
fn tint(grid: &HeightGrid, cell: usize, unit: f64) -> Color32 {
    let torn = grid.splintering[cell] / unit.max(1e-6);
    let blunt = grid.modes[cell] == FailureMode::Crushed || torn < TINTED.0;
    let ((r, g, b), part) = match torn {
        _ if blunt => ((90, 150, 240), 1.0 - torn.min(1.0)),
        t if t > TINTED.1 => ((ACCENT.r(), ACCENT.g(), ACCENT.b()), (t - 1.0) / 2.0),
        _ => ((0, 0, 0), 0.0),
    };
    Color32::from_rgba_unmultiplied(r, g, b, (TINT * part.min(1.0)) as u8)
}

impl Studio {
    /// Switches the tool on or off.
    pub(super) fn toggle_paint(&mut self) {
        self.paint.on ^= true;
        self.paint.stroke = None;
        self.cracks.on &= !self.paint.on;
        self.cracks.held = None;
        self.said = match self.paint.on {
            true => "Drag over the broken wood or the bark to paint.".to_owned(),
            false => String::new(),
        };
    }

    /// Why nothing can be painted here, if nothing can.
    fn why_no_paint(&self) -> Option<&'static str> {
        let kind = self.shown.as_ref().map(|s| s.report.place.kind.as_str());
        match kind {
            Some("board" | "dowel") => {
                Some("The rings of a board are arcs, which cannot be painted on.")
            }
            _ if self.handled_break().is_none() => Some("Select one of the breaks to paint on it."),
            _ => None,
        }
    }

    fn paint_site(&self, face: &CrackFace) -> Site {
        let report = self.shown.as_ref().map(|s| &s.report);
        let species = report.and_then(|r| r.species.as_ref());
        let relief = species.map_or(1.0, |s| s.relief);
        Site {
            radius: f64::from(face.radius()),
            relief,
        }
    }

    /// Where the pointer is on the wood, on whatever piece.
    fn paint_place(&mut self, rect: Rect, pos: Pos2) -> Option<(Polar, f32)> {
        let face = self.crack_face()?;
        let number = self.drawn.as_ref()?.0;
        // The same place is asked for by a stroke and by its cursor, and all triangles are looked through for it.
        if let Some((known, of, found)) = self.paint.under
            && (known, of) == (pos, number)
            && self.paint.stroke.is_some()
        {
            return found;
        }
        let elsewhere = || self.grain_place(&face, &self.picked(rect, pos)?);
        let found = self.place_on_face(rect, &face, pos).or_else(elsewhere);
        self.paint.under = Some((pos, number, found));
        found
    }

    /// Paints with the pointer; returns whether it does.
    pub(super) fn drag_paint(&mut self, ui: &Ui, rect: Rect, response: &egui::Response) -> bool {
        if !self.paint.on {
            return false;
        }
        let left = PointerButton::Primary;
        let (pressed, modifiers, now) =
            ui.input(|i| (i.pointer.press_origin(), i.modifiers, i.time));
        // A pointer that rests paints nothing, though the wood below it changes when what was painted is drawn.
        let moves = ui.input(|i| i.pointer.delta() != egui::Vec2::ZERO);
        if response.clicked_by(left) {
            if let Some(at) = response
                .interact_pointer_pos()
                .and_then(|pos| self.paint_place(rect, pos))
            {
                self.begin_stroke(at, modifiers, now);
                self.end_stroke(now);
            }
            return true;
        }
        if response.drag_started_by(left)
            && let Some(at) = pressed.and_then(|pos| self.paint_place(rect, pos))
        {
            self.begin_stroke(at, modifiers, now);
        }
        let Some(stroke) = self.paint.stroke else {
            return false;
        };
        if !response.dragged_by(left) {
            self.end_stroke(now);
            return false;
        }
        let pos = response.interact_pointer_pos().filter(|_| moves);
        if let Some(at) = pos.and_then(|pos| self.paint_place(rect, pos)) {
            self.go_on_stroke(stroke, at, modifiers, now);
        }
        true
    }

    fn begin_stroke(&mut self, at: (Polar, f32), modifiers: Modifiers, now: f64) {
        if let Some(why) = self.why_no_paint() {
            self.said = why.to_owned();
            return;
        }
        let splinters = self.paint.brush.kind == BrushKind::Splinter;
        if splinters
            && self
                .project
                .has_no_splinters(self.handled_break().unwrap_or(0))
        {
            self.said =
                "A smooth face has no splinters: choose a fibrous surface, under Face, first."
                    .to_owned();
            return;
        }
        let stroke = Stroke {
            last: at,
            began: at.1,
        };
        self.paint.stroke = Some(stroke);
        self.put_dabs(stroke, &[at], modifiers, now);
    }

    fn end_stroke(&mut self, now: f64) {
        if self.paint.stroke.take().is_some() {
            self.rest(now);
        }
    }

    /// Dabs from the last one to where the pointer is.
    fn go_on_stroke(&mut self, stroke: Stroke, at: (Polar, f32), modifiers: Modifiers, now: f64) {
        let across = |(rho, angle): Polar| glam::Vec2::from_angle(angle) * rho;
        let (from, to) = (across(stroke.last.0), across(at.0));
        let spacing = SPACING * self.paint.brush.size as f32;
        let steps = (from.distance(to) / spacing).floor().min(MOST_DABS);
        // On the bark a stroke along the stem stays where it is in the section.
        let moved = (at.1 - stroke.last.1).abs();
        let along = self.crack_face().map_or(0.0, |f| moved / f.radius());
        if steps < 1.0 && along < spacing {
            return;
        }
        let steps = steps.max(1.0);
        let dabs: Vec<_> = (1..=steps as u16)
            .map(|k| {
                let t = f32::from(k) / steps;
                let place = from + (to - from) * t;
                let height = stroke.last.1 + (at.1 - stroke.last.1) * t;
                // Between two places on the bark lies the bark, not the chord.
                let rho = stroke.last.0.0 + (at.0.0 - stroke.last.0.0) * t;
                ((rho, place.y.atan2(place.x)), height)
            })
            .collect();
        self.paint.stroke = Some(Stroke { last: at, ..stroke });
        self.put_dabs(stroke, &dabs, modifiers, now);
    }

    fn put_dabs(
        &mut self,
        stroke: Stroke,
        places: &[(Polar, f32)],
        modifiers: Modifiers,
        now: f64,
    ) {
        let (Some(number), Some(face)) = (self.handled_break(), self.crack_face()) else {
            return;
        };
        let dabs: Vec<Dab> = places
            .iter()
            .map(|&((rho, angle), height)| Dab {
                rho: f64::from(rho.min(1.0)),
                angle: f64::from(angle),
                height: f64::from(if rho >= BARK { height } else { stroke.began }),
                reversed: modifiers.command,
                smooths: modifiers.shift,
            })
            .collect();
        let (brush, site) = (self.paint.brush, self.paint_site(&face));
        match self.project.paint(number, &brush, &dabs, site) {
            Ok(true) => self.changed(true, now),
            Ok(false) => {}
            Err(problem) => self.said = problem,
        }
    }

    /// Draws what is painted, and the brush where the pointer is.
    pub(super) fn paint_painting(&mut self, ui: &Ui, rect: Rect, response: &egui::Response) {
        if !self.paint.on {
            return;
        }
        let painter = ui.painter_at(rect);
        self.tint_painting(&painter, rect);
        let turning = response.dragged() && self.paint.stroke.is_none();
        let Some(pos) = response.hover_pos().filter(|_| !turning) else {
            return;
        };
        let (Some(at), Some(face)) = (self.paint_place(rect, pos), self.crack_face()) else {
            return;
        };
        let reach = self.paint.brush.size as f32 * face.radius();
        let middle = face.point(at.0, at.1);
        let beside = middle + self.camera.right() * reach;
        // On another piece the same place of the wood is drawn elsewhere: the circle is where the pointer is, of the size it has there.
        let size = [middle, beside].map(|p| self.in_window(rect, p));
        if let [Some(a), Some(b)] = size {
            let radius = a.distance(b);
            painter.circle_stroke(
                pos,
                radius + 1.0,
                egui::Stroke::new(1.0, Color32::from_black_alpha(140)),
            );
            painter.circle_stroke(pos, radius, egui::Stroke::new(1.5, ACCENT));
            painter.circle_filled(pos, 1.5, ACCENT);
        }
    }

    /// Tints wood whose splinters were painted longer or shorter, where the face is seen from above.
    fn tint_painting(&mut self, painter: &egui::Painter, rect: Rect) {
        let (Some(number), Some(face)) = (self.handled_break(), self.crack_face()) else {
            return;
        };
        let Some(grid) = self.project.painted(number) else {
            return;
        };
        let unit = match grid.added {
            true => 1.0,
            false => self.paint_site(&face).relief,
        };
        let sectors = grid.sectors as usize;
        if grid.splintering.len() != grid.values.len() || sectors < 3 {
            return;
        }
        let middle = face.point((0.0, 0.0), 0.0);
        let seen = self.in_window(rect, middle);
        if seen.is_none_or(|pos| self.ray_at(rect, pos).1.dot(face.along()) > -0.1) {
            return;
        }
        let count = grid.values.len();
        let colors: Vec<Color32> = (0..count).map(|cell| tint(grid, cell, unit)).collect();
        // Each quad lies between a cell, the next one of its ring, and those outwards of both. Those that nothing tints are left out.
        let quads = (0..count - count % sectors).filter(|cell| cell + sectors < count);
        let quads = quads.map(|cell| {
            let next = cell - cell % sectors + (cell + 1) % sectors;
            [cell, next, cell + sectors, next + sectors]
        });
        let tinted: Vec<[usize; 4]> = quads
            .filter(|quad| quad.iter().any(|cell| colors[*cell].a() > 0))
            .collect();
        let mut mesh = Mesh::default();
        let mut vertices = vec![None; count];
        let places: Vec<(f64, f64)> = middles(grid).collect();
        for quad in tinted {
            let mut corners = [0; 4];
            for (corner, cell) in corners.iter_mut().zip(quad) {
                if vertices[cell].is_none() {
                    let place = (places[cell].0 as f32, places[cell].1 as f32);
                    let Some(pos) = self.in_window(rect, face.face_point(place)) else {
                        return;
                    };
                    vertices[cell] = Some(mesh.vertices.len() as u32);
                    mesh.colored_vertex(pos, colors[cell]);
                }
                *corner = vertices[cell].unwrap_or_default();
            }
            let [a, b, c, d] = corners;
            mesh.add_triangle(a, b, c);
            mesh.add_triangle(b, d, c);
        }
        painter.add(Shape::mesh(mesh));
    }

    /// The keys of the tool, before those of all else.
    pub(super) fn paint_keys(&mut self, ctx: &egui::Context) {
        if !self.paint.on || self.dialog.is_some() || ctx.text_edit_focused() {
            return;
        }
        let pressed = |key| ctx.input_mut(|i| i.consume_key(Modifiers::NONE, key));
        let size = &mut self.paint.brush.size;
        if pressed(Key::OpenBracket) {
            *size = (*size / SIZE_STEP).max(*SIZES.start());
        }
        if pressed(Key::CloseBracket) {
            *size = (*size * SIZE_STEP).min(*SIZES.end());
        }
        if self.at_work.is_none() && pressed(Key::Escape) {
            self.toggle_paint();
        }
    }

    /// The line of the tool, while it is on.
    pub(super) fn paint_bar(&mut self, ui: &mut Ui) {
        if !self.paint.on {
            return;
        }
        let now = ui.input(|i| i.time);
        ui.horizontal_wrapped(|ui| {
            ui.label("Paint");
            if let Some(why) = self.why_no_paint() {
                ui.weak(why);
                return;
            }
            for kind in BrushKind::ALL {
                let (label, about) = kind.label();
                ui.selectable_value(&mut self.paint.brush.kind, kind, label)
                    .on_hover_text(about);
            }
            ui.spacing_mut().slider_width = 64.0;
            let brush = &mut self.paint.brush;
            let size = egui::Slider::new(&mut brush.size, SIZES)
                .logarithmic(true)
                .fixed_decimals(2)
                .text("size");
            ui.add(size)
                .on_hover_text("How far the brush reaches, in radii of the stem ([ and ]).");
            let strength = egui::Slider::new(&mut brush.strength, 0.05..=1.0)
                .fixed_decimals(2)
                .text("strength");
            ui.add(strength)
                .on_hover_text("How much one dab of the brush does.");
            let number = self.handled_break().unwrap_or(0);
            let painted = self.project.painted(number).is_some();
            let clear = ui.add_enabled(painted, egui::Button::new("Clear"));
            let clear = clear.on_hover_text("Leaves the face to its parameters again.");
            if clear.clicked() {
                let cleared = self.project.clear_paint(number);
                self.finish_step(cleared, now);
            }
            let hint = "Ctrl does the opposite, Shift evens out. Beside the stem a drag turns the picture.";
            ui.label(RichText::new(hint).weak());
        });
    }
}
