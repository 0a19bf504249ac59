//! The photograph of a real break: opening it, laying it over the picture or beside it.

use super::studio::Studio;
use crate::model::engine::Failure;
use crate::model::photograph::Overlay;
use eframe::egui::{
    self, Button, Color32, ColorImage, CursorIcon, Event, Mesh, Pos2, Rect, Sense, Shape,
    TextureHandle, TextureOptions, Ui, Vec2,
};
use greenstick::formats::photograph::Photograph;

/// How much larger one notch of the wheel makes it.
const NOTCH: f64 = 1.08;
/// Degrees by which it turns for each point that the pointer moves.
const TURN_PER_POINT: f64 = 0.25;
/// Points that the slider of opacity takes with its number and its label.
const OPACITY_WIDTH: f32 = 200.0;

impl Studio {
    /// Starts to read a photograph; it becomes part of the project when it is read.
    pub fn open_photograph(&mut self, path: &str) {
        self.photograph.asked = Some(path.to_owned());
        self.platform.open_picture(path);
    }

    /// The photograph of the project, whether it is shown or not.
    pub fn has_photograph(&self) -> bool {
        self.shown_photograph().is_some()
    }

    /// Reads the photograph that the project has after a step back or forward, or after it was opened.
    pub(super) fn follow_photograph(&mut self) {
        let Some(path) = &self.project.photograph.file else {
            return;
        };
        let view = &self.photograph;
        let read = view.picture.as_ref().map(|p| &p.0);
        let pending = view.pixels.as_ref().map(|p| &p.0);
        let known = [read, pending, view.failed.as_ref()].contains(&Some(path));
        if !known && view.asked.is_none() {
            let path = path.clone();
            self.open_photograph(&path);
        }
    }

    /// Takes a photograph that was read, or tells why it was not.
    pub(super) fn take_photograph(
        &mut self,
        path: &str,
        picture: Result<Photograph, Failure>,
        now: f64,
    ) {
        // One that nobody asked for was dropped on a page.
        if self.photograph.asked.as_ref().is_some_and(|p| p != path) {
            return;
        }
        self.photograph.asked = None;
        match picture {
            Ok(picture) => {
                self.photograph.pixels = Some((path.to_owned(), picture));
                self.photograph.failed = None;
                if self.project.photograph.file.as_deref() != Some(path) {
                    let next = Overlay {
                        file: Some(path.to_owned()),
                        ..self.project.photograph.clone()
                    };
                    self.photograph.hidden = false;
                    self.lay_photograph("photograph", next, false, now);
                }
            }
            Err(failure) => {
                self.photograph.failed = Some(path.to_owned());
                self.fail(&failure);
            }
        }
    }

    fn lay_photograph(&mut self, label: &str, next: Overlay, drag: bool, now: f64) {
        if self.project.lay_photograph(label, next, drag) {
            self.changed_at = Some(now);
        }
    }

    /// The picture of the project's photograph.
    fn shown_photograph(&self) -> Option<&TextureHandle> {
        let (path, picture) = self.photograph.picture.as_ref()?;
        (self.project.photograph.file.as_ref() == Some(path)).then_some(picture)
    }

    /// Whether the photograph takes half of the viewport.
    pub(super) fn photograph_is_beside(&self) -> bool {
        let visible = !self.photograph.hidden && self.shown_photograph().is_some();
        visible && self.project.photograph.beside
    }

    /// Whether dragging in the picture moves the photograph.
    pub(super) fn moves_photograph(&self) -> bool {
        let over = !self.project.photograph.beside && !self.photograph.hidden;
        over && self.photograph.moves && self.shown_photograph().is_some()
    }

    /// Draws it over the picture.
    pub(super) fn paint_photograph(&mut self, ui: &Ui, rect: Rect) {
        if let Some((path, picture)) = self.photograph.pixels.take() {
            let size = [picture.width as usize, picture.height as usize];
            let pixels = ColorImage::from_rgb(size, &picture.rgb);
            let loaded = ui
                .ctx()
                .load_texture("photograph", pixels, TextureOptions::LINEAR);
            self.photograph.picture = Some((path, loaded));
        }
        if !self.photograph.hidden && !self.project.photograph.beside {
            self.paint_photograph_in(ui, rect, self.project.photograph.opacity);
        }
    }

    fn paint_photograph_in(&self, ui: &Ui, rect: Rect, opacity: f64) {
        let Some(picture) = self.shown_photograph() else {
            return;
        };
        let size = picture.size_vec2();
        let middle = [rect.center().x, rect.center().y].map(f64::from);
        let aspect = f64::from(size.x / size.y.max(1.0));
        let corners =
            self.project
                .photograph
                .corners(middle, f64::from(rect.height().max(1.0)), aspect);
        let color = Color32::from_white_alpha((255.0 * opacity).round() as u8);
        let mut mesh = Mesh::with_texture(picture.id());
        let at = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        for ([x, y], uv) in corners.into_iter().zip(at) {
            mesh.vertices.push(egui::epaint::Vertex {
                pos: Pos2::new(x as f32, y as f32),
                uv: Pos2::new(uv.0, uv.1),
                color,
            });
        }
        mesh.indices = vec![0, 1, 2, 0, 2, 3];
        ui.painter_at(rect).add(Shape::mesh(mesh));
    }

    /// The half of the viewport that shows the photograph; dragging moves it there.
    pub(super) fn photograph_beside(&mut self, ui: &Ui, rect: Rect) {
        ui.painter().rect_filled(rect, 0.0, Color32::from_gray(28));
        self.paint_photograph_in(ui, rect, 1.0);
        let response = ui.interact(rect, ui.scope_id().with("photograph"), Sense::drag());
        self.move_photograph(ui, rect, &response);
    }

    /// Moves it with the pointer over the picture; returns whether it does.
    pub(super) fn drag_photograph(
        &mut self,
        ui: &Ui,
        rect: Rect,
        response: &egui::Response,
    ) -> bool {
        if !self.moves_photograph() {
            return false;
        }
        if response.contains_pointer() {
            ui.set_cursor_icon(CursorIcon::Grab);
        }
        self.move_photograph(ui, rect, response);
        true
    }

    /// Shifts it by a drag, turns it by one with Shift, scales it by the wheel.
    fn move_photograph(&mut self, ui: &Ui, rect: Rect, response: &egui::Response) {
        let now = ui.input(|i| i.time);
        let height = f64::from(rect.height().max(1.0));
        let mut next = self.project.photograph.clone();
        if response.dragged() {
            let (delta, shift) = ui.input(|i| (i.pointer.delta(), i.modifiers.shift));
            if shift {
                next.turn_by(f64::from(delta.x) * TURN_PER_POINT);
                self.lay_photograph("turn of the photograph", next, true, now);
            } else {
                next.shift([delta.x, delta.y].map(f64::from), height);
                self.lay_photograph("place of the photograph", next, true, now);
            }
            return;
        }
        if response.drag_stopped() {
            self.project.history.rest();
        }
        let Some(pos) = response.hover_pos() else {
            return;
        };
        let wheel = |e: &Event| match e {
            Event::MouseWheel { delta, .. } => delta.y,
            _ => 0.0,
        };
        let notches: f32 = ui.input(|i| i.events.iter().map(wheel).sum());
        if notches != 0.0 {
            let from_middle: Vec2 = (pos - rect.center()) / rect.height().max(1.0);
            let about = [from_middle.x, -from_middle.y].map(f64::from);
            next.zoom(NOTCH.powf(f64::from(notches.clamp(-4.0, 4.0))), about);
            self.lay_photograph("size of the photograph", next, true, now);
        }
    }

    /// The line of its values, where there is one.
    pub(super) fn photograph_bar(&mut self, ui: &mut Ui) {
        let Some(path) = self.project.photograph.file.clone() else {
            return;
        };
        ui.horizontal_wrapped(|ui| {
            let name = path.rsplit(['/', '\\']).next().unwrap_or(&path);
            ui.label("Photograph").on_hover_text(name);
            let mut shown = !self.photograph.hidden;
            ui.toggle_value(&mut shown, "Show")
                .on_hover_text("Shows or hides it (P).");
            self.photograph.hidden = !shown;
            let mut next = self.project.photograph.clone();
            let mut label = "photograph";
            ui.selectable_value(&mut next.beside, false, "over");
            ui.selectable_value(&mut next.beside, true, "beside");
            let over = !next.beside;
            let moves = Button::selectable(self.photograph.moves, "Move");
            let moves = ui.add_enabled(over, moves).on_hover_text(
                "Dragging shifts the photograph and not the camera; with Shift it turns it, the wheel scales it.",
            );
            self.photograph.moves ^= moves.clicked();
            let mut drag = false;
            let mut stopped = false;
            let mut value = |response: egui::Response, name: &'static str| {
                if response.changed() {
                    label = name;
                    drag = response.dragged();
                }
                stopped |= response.drag_stopped();
            };
            ui.spacing_mut().slider_width = 80.0;
            // A slider does not begin a line by itself where it does not fit.
            if ui.available_size_before_wrap().x < OPACITY_WIDTH {
                ui.end_row();
            }
            let opacity = egui::Slider::new(&mut next.opacity, 0.0..=1.0).text("opacity");
            value(ui.add_enabled(over, opacity), "opacity");
            let by_drag = |x, prefix: &str, speed: f64| {
                egui::DragValue::new(x)
                    .prefix(format!("{prefix} "))
                    .speed(speed)
                    .max_decimals(3)
            };
            let speed = 0.01 * next.scale;
            let scale = by_drag(&mut next.scale, "scale", speed).range(0.02..=50.0);
            value(ui.add(scale), "scale");
            let turn = by_drag(&mut next.turn, "turn", 0.25).range(-180.0..=180.0);
            value(ui.add(turn.suffix("°").max_decimals(1)), "turn");
            for (x, name) in [(&mut next.right, "right"), (&mut next.up, "up")] {
                value(ui.add(by_drag(x, name, 0.002).range(-4.0..=4.0)), name);
            }
            if ui
                .button("Remove")
                .on_hover_text("Takes the photograph out of the project.")
                .clicked()
            {
                next = Overlay::default();
                label = "photograph";
            }
            let label = match label {
                "photograph" => label.to_owned(),
                name => format!("{name} of the photograph"),
            };
            let now = ui.input(|i| i.time);
            self.lay_photograph(&label, next, drag, now);
            if stopped {
                self.project.history.rest();
            }
        });
    }
}
