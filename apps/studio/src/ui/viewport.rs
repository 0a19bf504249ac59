//! The viewport: turning, shifting, going nearer, and clicking where it shall break.

use super::actions::Action;
use super::colours::ACCENT;
use super::studio::{Section, Studio};
use crate::model::section::{Plane, SectionFaces, section_faces};
use crate::platform::Lane;
use crate::view::frame::{Colours, View};
use crate::view::pick::{Picked, pick};
use crate::view::sharpness::Motion;
use eframe::egui::{
    self, Align2, Color32, CursorIcon, Event, FontId, MouseWheelUnit, PointerButton, Pos2, Rect,
    RichText, Sense, Ui, Vec2,
};
use eframe::egui_wgpu;
use glam::DVec3;
use greenstick::wood::stem::StemLocation;
use std::sync::Arc;

/// How much nearer one notch of the wheel goes.
const NOTCH: f32 = 0.88;
/// Points of a touchpad's movement that are as much as one point of a mouse's.
const TOUCHPAD: f32 = 1.0;

/// Points beside the pointer at which a thin branch is still what is meant: the wheel goes nearer to that, not to what lies behind it.
const BESIDE: [f32; 3] = [8.0, 20.0, 40.0];

/// Room that the slider which pulls pieces apart takes with its texts, and the buttons behind it, points.
const APART_WIDTH: f32 = 310.0;

/// To which part of a metre the point of a click is rounded: nobody clicks more exactly, and short numbers can be read.
const CLICK: f64 = 1e4;

impl Studio {
    /// The middle of the window.
    pub(super) fn viewport(&mut self, ui: &mut Ui) {
        egui::CentralPanel::no_frame().show(ui, |ui| {
            self.header(ui);
            let beside = self.photograph_is_beside();
            let whole = ui.available_size();
            let size = if beside {
                Vec2::new((0.5 * whole.x).floor(), whole.y)
            } else {
                whole
            };
            let corner = ui.cursor().min;
            if beside {
                let at = corner + Vec2::new(size.x, 0.0);
                self.photograph_beside(ui, Rect::from_min_size(at, whole - Vec2::new(size.x, 0.0)));
            }
            let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
            self.aspect = rect.width() / rect.height().max(1.0);
            self.viewport_rect = Some(rect);
            let response = response.on_hover_cursor(CursorIcon::Crosshair);
            if self.simulation.is_some() {
                let moving =
                    self.drag_hold(ui, rect, &response) || self.navigate(ui, rect, &response);
                self.paint(ui, rect, moving);
                self.paint_photograph(ui, rect);
                self.point_at_wood(ui, rect, &response);
                self.paint_holds(ui, rect, &response);
                self.overlays(ui, rect);
                return;
            }
            let moving = self.drag_photograph(ui, rect, &response)
                || self.drag_section(ui, rect, &response)
                || self.drag_crack(ui, rect, &response)
                || self.drag_paint(ui, rect, &response)
                || (!self.has_tool()
                    && (self.drag_fan(ui, rect, &response)
                        || self.drag_handle(ui, rect, &response)))
                || self.navigate(ui, rect, &response);
            self.paint(ui, rect, moving);
            self.paint_photograph(ui, rect);
            self.handle_at = self.tilt_dot(rect);
            if !self.has_tool() {
                self.paint_handle(ui, rect, &response);
                self.paint_fan(ui, rect, &response);
            }
            self.paint_break_marks(ui, rect);
            self.paint_section_line(ui, rect);
            self.paint_cracks(ui, rect, &response);
            self.paint_painting(ui, rect, &response);
            if !self.moves_photograph() && !self.has_tool() {
                self.click(ui, rect, &response);
            }
            self.overlays(ui, rect);
        });
    }

    /// Whether drags over the wood place or paint something.
    fn has_tool(&self) -> bool {
        self.cracks.on || self.paint.on
    }

    fn header(&mut self, ui: &mut Ui) {
        let frame = egui::Frame::side_top_panel(ui.style());
        frame.show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                ui.set_min_width(ui.available_width());
                let label = self.view.colours.label().0;
                egui::ComboBox::from_id_salt("colours")
                    .selected_text(label)
                    .width(72.0)
                    .show_ui(ui, |ui| {
                        for colours in Colours::ALL {
                            let (label, about) = colours.label();
                            ui.selectable_value(&mut self.view.colours, colours, label)
                                .on_hover_text(about);
                        }
                    });
                ui.toggle_value(&mut self.view.wireframe, "Wireframe")
                    .on_hover_text("The edges of triangles (W).");
                if self.simulation.is_none() {
                    self.break_view(ui);
                } else {
                    ui.toggle_value(&mut self.view.handles, "Handles")
                        .on_hover_text(
                            "Dots at the first frame that move clamps, forces and bodies (H).",
                        );
                    self.pull_switch(ui);
                }
                self.frame_buttons(ui);
            });
            self.photograph_bar(ui);
            if self.simulation.is_none() {
                self.cracks_bar(ui);
                self.paint_bar(ui);
            }
        });
    }

    /// The buttons that bring the break, or everything, into the picture.
    fn frame_buttons(&mut self, ui: &mut Ui) {
        ui.label(RichText::new("Frame").weak());
        let ctx = ui.ctx().clone();
        let simulates = self.simulation.is_some();
        for (action, name) in [
            (Action::FrameBreak, "break"),
            (Action::FrameAll, "everything"),
        ] {
            // A simulation has no place yet at which it breaks.
            if simulates && action == Action::FrameBreak {
                continue;
            }
            if ui.button(name).on_hover_text(action.about()).clicked() {
                self.act(action, &ctx);
            }
        }
    }

    /// What of the header concerns breaks alone.
    fn break_view(&mut self, ui: &mut Ui) {
        ui.toggle_value(&mut self.view.section, "Section")
            .on_hover_text("Cuts the picture open along the stem, on the side that is seen (X).");
        ui.toggle_value(&mut self.view.handles, "Handles")
            .on_hover_text("Dots on the wood that are dragged: of the plane of the break, or of what is chosen (H).");
        self.handle_choice(ui);
        let mut cracks = self.cracks.on;
        ui.toggle_value(&mut cracks, "Cracks")
            .on_hover_text("Places drying cracks by a drag over the broken wood (K).");
        if cracks != self.cracks.on {
            self.toggle_cracks();
        }
        let mut paint = self.paint.on;
        ui.toggle_value(&mut paint, "Paint").on_hover_text(
            "Strokes on the wood say where it breaks, where it splinters and what stays on which piece (B).",
        );
        if paint != self.paint.on {
            self.toggle_paint();
        }
        let mut open = self.anatomy.open;
        ui.toggle_value(&mut open, "Anatomy").on_hover_text(
            "A section across the stem at any height, its rings, and rings that are dragged to where they are (S).",
        );
        if open != self.anatomy.open {
            self.toggle_anatomy();
        }
        // A row that wraps leaves a slider cut off at its end.
        if ui.available_size_before_wrap().x < APART_WIDTH {
            ui.end_row();
        } else {
            ui.separator();
        }
        let before = self.view.apart;
        ui.spacing_mut().slider_width = 64.0;
        let slider = egui::Slider::new(&mut self.view.apart, 0.0..=8.0)
            .suffix(" ×")
            .fixed_decimals(1)
            .text("apart");
        let response = ui.add(slider).on_hover_text(
            "How far apart the picture shows the pieces, in diameters of the stem. They are pulled as one would pull \
             them, so that they never meet. What is exported is moved by \"part\" alone.",
        );
        if self.view.apart != before {
            self.changed_view(response.dragged());
        }
        ui.separator();
    }

    /// Moves the camera; returns whether it is being moved.
    fn navigate(&mut self, ui: &Ui, rect: Rect, response: &egui::Response) -> bool {
        let height = rect.height();
        let aspect = rect.width() / height.max(1.0);
        let (modifiers, delta) = ui.input(|i| (i.modifiers, i.pointer.delta()));
        let by = glam::Vec2::new(delta.x, delta.y);
        let middle = response.dragged_by(PointerButton::Middle);
        let left = response.dragged_by(PointerButton::Primary);
        let right = response.dragged_by(PointerButton::Secondary);
        if (middle && modifiers.shift) || right || (left && modifiers.shift) {
            self.camera.pan(by, height);
        } else if middle && modifiers.command {
            let factor = (1.0 + by.y * 0.006).clamp(0.5, 2.0);
            self.camera.zoom(factor, glam::Vec2::ZERO, aspect);
        } else if middle || left {
            self.camera.orbit(by);
        }
        if !response.contains_pointer() {
            return response.dragged();
        }
        let pinch = ui.input(egui::InputState::zoom_delta);
        let at = response
            .hover_pos()
            .map_or(glam::Vec2::ZERO, |p| picture_point(rect, p));
        let mut moved = response.dragged();
        let events = ui.input(|i| i.events.clone());
        for event in events {
            let Event::MouseWheel {
                unit,
                delta,
                modifiers,
                ..
            } = event
            else {
                continue;
            };
            moved = true;
            match unit {
                // A touchpad: two fingers turn, with Shift they shift, with Ctrl they go nearer.
                MouseWheelUnit::Point if !modifiers.command => {
                    let by = glam::Vec2::new(delta.x, delta.y) * TOUCHPAD;
                    if modifiers.shift {
                        self.camera.pan(by, height);
                    } else {
                        self.camera.orbit(by);
                    }
                }
                MouseWheelUnit::Point => {}
                _ => {
                    self.look_at_pointed(rect, response);
                    self.camera.zoom(NOTCH.powf(delta.y), at, aspect);
                }
            }
        }
        if pinch != 1.0 {
            self.look_at_pointed(rect, response);
            self.camera.zoom(1.0 / pinch, at, aspect);
            moved = true;
        }
        moved
    }

    /// Moves what the camera turns about and comes near to, to the depth of what is under the pointer; the picture stays as it is.
    fn look_at_pointed(&mut self, rect: Rect, response: &egui::Response) {
        let drawn = match &self.simulation {
            Some(simulation) => &simulation.drawn,
            None => &self.drawn,
        };
        let (Some(pos), Some(drawn)) = (response.hover_pos(), drawn.as_ref()) else {
            return;
        };
        let at = |pos| pick(&drawn.1, self.ray_at(rect, pos), None);
        let around = || {
            let directions = (0..8).map(|k| Vec2::angled(k as f32 * std::f32::consts::FRAC_PI_4));
            let rings = BESIDE.into_iter();
            let mut places = rings.flat_map(|r| directions.clone().map(move |d| pos + d * r));
            places.find_map(at)
        };
        let pointed = at(pos).or_else(around);
        if let Some(pointed) = pointed {
            self.camera.look_at_depth_of(pointed.position);
        }
    }

    /// What moves in the picture; `held` where the pointer moves something in it.
    fn motion(&mut self, held: bool) -> Motion {
        let turned = std::mem::replace(&mut self.camera_seen, self.camera) != self.camera;
        let follows = self.rests_at.is_some() || self.at_work.is_some_and(|w| w.drag);
        let plays = self.simulation.as_ref().is_some_and(|s| s.playback.playing);
        if held && turned {
            Motion::Camera
        } else if held || follows || plays || self.is_live() {
            Motion::Scene
        } else {
            Motion::Rest
        }
    }

    fn paint(&mut self, ui: &Ui, rect: Rect, moving: bool) {
        let motion = self.motion(moving);
        let (now, seconds) = ui.input(|i| (i.time, f64::from(i.unstable_dt)));
        let (side, again) = self.sharpness.next(now, seconds, motion);
        if let Some(after) = again {
            ui.ctx().request_repaint_after_secs(after as f32);
        }
        let scale = ui.pixels_per_point() * side;
        let size = [rect.width(), rect.height()].map(|s| ((s * scale) as u32).clamp(1, 8192));
        let background = if self.settings.dark {
            [0.060, 0.064, 0.070]
        } else {
            [0.62, 0.62, 0.61]
        };
        if !self.card.is_there() {
            ui.painter().rect_filled(rect, 0.0, Color32::from_gray(40));
            return;
        }
        let view = View {
            shown: match &self.simulation {
                Some(simulation) => simulation.drawn.clone(),
                None => self.drawn.clone(),
            },
            camera: self.camera,
            size,
            colours: self.view.colours,
            wireframe: self.view.wireframe,
            section: self.section(),
            background,
        };
        let callback = egui_wgpu::Callback::new_paint_callback(rect, view);
        ui.painter().add(callback);
    }

    /// The plane that cuts the picture open, along the stem at the break, and the faces that it opens. Its open side is towards
    /// where the camera was when the section was switched on.
    fn section(&mut self) -> Option<(Plane, Arc<SectionFaces>)> {
        if !self.view.section || self.simulation.is_some() {
            self.section = Section::default();
            return None;
        }
        let (number, drawn) = self.drawn.as_ref()?;
        let at = drawn.breaks.first()?;
        let backward = self.camera.backward();
        let towards = *self.section.towards.get_or_insert(backward);
        let across = towards - at.along * towards.dot(at.along);
        let normal = across.normalize_or(self.camera.right());
        let plane = Plane {
            normal,
            distance: normal.dot(at.place),
        };
        let faces = match &self.section.faces {
            Some((of, known, faces)) if of == number && *known == plane => faces.clone(),
            _ => Arc::new(section_faces(drawn, plane)),
        };
        self.section.faces = Some((*number, plane, faces.clone()));
        Some((plane, faces))
    }

    fn click(&mut self, ui: &Ui, rect: Rect, response: &egui::Response) {
        let Some(pos) = response.hover_pos().filter(|_| !response.dragged()) else {
            return;
        };
        let clicked = response.clicked();
        let still = ui.input(|i| i.pointer.delta() == Vec2::ZERO);
        if !clicked && !still {
            return;
        }
        if self.on_handle(rect, pos) || self.fan_part_at(pos).is_some() {
            return;
        }
        if let Some(number) = self.break_mark_at(rect, pos) {
            if clicked {
                self.project.select(Some(number));
            }
            return;
        }
        let Some(picked) = self.picked(rect, pos) else {
            return;
        };
        let unbroken = self.shown.is_none();
        if picked.grain.is_none() && !clicked && !unbroken {
            return;
        }
        let place = self.place_of(&picked);
        let (now, adds) = ui.input(|i| (i.time, i.modifiers.command));
        if clicked {
            let place = StemLocation::Point(place);
            if adds {
                self.add_break(place, now);
            } else {
                self.move_break(place, now);
            }
            return;
        }
        let painter = ui.painter_at(rect);
        painter.circle_stroke(pos, 7.0, egui::Stroke::new(1.5, ACCENT));
        if adds {
            let beside = pos + Vec2::new(10.0, -10.0);
            painter.text(
                beside,
                Align2::LEFT_BOTTOM,
                "+",
                FontId::proportional(18.0),
                ACCENT,
            );
        }
    }

    /// The ray under a point of the window: its origin and direction.
    pub(super) fn ray_at(&self, rect: Rect, pos: Pos2) -> (glam::Vec3, glam::Vec3) {
        let aspect = rect.width() / rect.height().max(1.0);
        self.camera.ray(picture_point(rect, pos), aspect)
    }

    /// What is seen at a point of the window.
    pub(super) fn picked(&self, rect: Rect, pos: Pos2) -> Option<Picked> {
        let (_, drawn) = self.drawn.as_ref()?;
        pick(drawn, self.ray_at(rect, pos), None)
    }

    /// Where a point of the picture lies on the unbroken stem, in the coordinates of its file, m.
    fn place_of(&self, picked: &Picked) -> DVec3 {
        let Some((_, drawn)) = &self.drawn else {
            return DVec3::ZERO;
        };
        let origin = self.shown.as_ref().map_or([0.0; 3], |s| s.origin);
        let world = picked.position.as_dvec3() + drawn.middle;
        let piece = drawn.pieces.get(picked.piece);
        let still = piece.map_or(world, |p| p.motion.inverse().transform_point3(world));
        ((still + DVec3::from_array(origin)) * CLICK).round() / CLICK
    }

    /// What is laid over the picture: messages and progress.
    fn overlays(&mut self, ui: &mut Ui, rect: Rect) {
        let area = Rect::from_min_max(rect.min + Vec2::splat(10.0), rect.max - Vec2::splat(10.0));
        let mut ui = ui.new_child(egui::UiBuilder::new().max_rect(area));
        self.message_cards(&mut ui);
        self.progress_cards(&mut ui);
        if !self.card.is_there() {
            ui.label("No graphics adapter: there is no picture here.");
        }
    }

    fn progress_cards(&mut self, ui: &mut Ui) {
        let lanes = [
            (Lane::Show, "Breaking"),
            (Lane::Files, "Files"),
            (Lane::Simulation, "Simulation"),
        ];
        for (lane, title) in lanes {
            let Some(progress) = self.platform.progress(lane) else {
                continue;
            };
            // Nobody reads what is over at once.
            let id = egui::Id::unique(("progress", title));
            let shown = ui.ctx().animate_bool_with_time(id, true, 0.3);
            if shown < 1.0 && self.shown.is_some() {
                continue;
            }
            egui::Frame::popup(ui.style()).show(ui, |ui| {
                ui.horizontal(|ui| {
                    let waits = self.simulation.as_ref().is_some_and(|s| s.paused);
                    let about = match (&self.opening, lane) {
                        (_, Lane::Simulation) if waits => "Simulation waits".to_owned(),
                        (Some(path), Lane::Files) => format!("Opening {path}"),
                        (None, Lane::Files) => "Writing the pieces".to_owned(),
                        _ => title.to_owned(),
                    };
                    ui.label(RichText::new(format!("{about}: {}", progress.stage)));
                    let bar = egui::ProgressBar::new(progress.overall as f32);
                    ui.add(bar.desired_width(140.0).show_percentage());
                    if ui.button("Stop").clicked() {
                        self.platform.cancel(lane);
                    }
                });
            });
        }
        for (lane, title) in lanes {
            if self.platform.progress(lane).is_none() {
                let id = egui::Id::unique(("progress", title));
                ui.ctx().animate_bool_with_time(id, false, 0.0);
            }
        }
    }
}

/// A point of the window in the picture: −1 to 1 across and up.
pub(super) fn picture_point(rect: Rect, pos: Pos2) -> glam::Vec2 {
    let at = (pos - rect.min) / rect.size();
    glam::Vec2::new(at.x * 2.0 - 1.0, 1.0 - at.y * 2.0)
}
