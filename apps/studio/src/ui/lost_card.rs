//! Drawing on the graphics card, and what is done when it is lost: the work is kept as after any change, the window closes, and the
//! same studio goes on in the next window, on another device.

use super::card::{Card, WindowPlace};
use super::studio::Studio;
use crate::view::renderer::Renderer;
use crate::view::sharpness::Sharpness;
use eframe::egui;
use eframe::egui_wgpu::RenderState;
use std::sync::{Arc, Mutex, PoisonError};

impl Studio {
    /// Shows the studio that is held, or a new one, in a window or on a canvas that was just made.
    pub fn show_in(
        held: &mut Option<Studio>,
        creation: &eframe::CreationContext,
        new: impl FnOnce(&egui::Context) -> Studio,
    ) {
        let ctx = &creation.egui_ctx;
        match held {
            Some(studio) => studio.go_on(ctx),
            None => *held = Some(new(ctx)),
        }
        if let (Some(studio), Some(state)) = (held, &creation.wgpu_render_state) {
            studio.use_card(ctx, state);
        }
    }

    /// Draws on the card of a window, and notices when it is lost.
    pub fn use_card(&mut self, ctx: &egui::Context, state: &RenderState) {
        let renderer = Renderer::new(&state.device, &state.queue, state.target_format);
        state.renderer.write().callback_resources.insert(renderer);
        let lost = Arc::new(Mutex::new(None));
        let (told, ctx) = (lost.clone(), ctx.clone());
        state
            .device
            .set_device_lost_callback(move |reason, message| {
                let reason = if message.is_empty() {
                    format!("{reason:?}")
                } else {
                    message
                };
                *told.lock().unwrap_or_else(PoisonError::into_inner) = Some(reason);
                // Nothing else may happen for long: the window has to begin again by itself.
                ctx.request_repaint();
            });
        self.card = Card {
            device: Some((state.device.clone(), state.queue.clone())),
            lost,
            place: self.card.place,
        };
        let is_processor = state.adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        self.sharpness = Sharpness::new(is_processor);
    }

    /// Why the graphics device was lost, if it was.
    pub fn lost_card(&self) -> Option<String> {
        self.card.why_lost()
    }

    /// Keeps what was not saved and closes the window, where the card was lost; returns whether it was. Nothing may be drawn then.
    pub(super) fn leaves_lost_card(&mut self, ctx: &egui::Context) -> bool {
        if self.lost_card().is_none() {
            let zoom = ctx.zoom_factor();
            self.card.place = ctx.input(|i| {
                let info = i.viewport();
                WindowPlace {
                    inner: info.inner_rect.map(|r| r * zoom),
                    outer: info.outer_rect.map(|r| r * zoom),
                    maximized: info.maximized.unwrap_or(false),
                    fullscreen: info.fullscreen.unwrap_or(false),
                }
            });
            return false;
        }
        self.keep_changes();
        self.platform.tell_card_lost();
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        true
    }

    /// Keeps changes that were not saved, so that they survive the end of the program. What was kept before stays where there are none.
    pub fn keep_changes(&mut self) {
        if self.project.is_changed() {
            let project = self.project_file();
            self.platform.keep(Some(&project));
        }
        self.changed_at = None;
    }

    /// Goes on in another window, whose context is new: everything is as it was, but for what was held, and for pictures that lay on
    /// the card, which are made again.
    pub fn go_on(&mut self, ctx: &egui::Context) {
        ctx.options_mut(|o| o.zoom_with_keyboard = false);
        self.card = Card {
            place: self.card.place,
            ..Card::default()
        };
        self.project.history.rest();
        self.gallery_pictures = super::pictures::Pictures::default();
        self.photograph.picture = None;
        self.anatomy.board = None;
        self.anatomy.held = None;
        self.anatomy.pith_held = None;
        self.anatomy.holds_section = false;
        self.cracks.held = None;
        self.fans.held = None;
        self.paint.stroke = None;
        self.holds_handle = false;
        // Another window counts its seconds from 0.
        if let Some(work) = &mut self.at_work {
            work.since = 0.0;
        }
        self.rests_at = self.rests_at.map(|_| 0.0);
        if let Some(simulation) = &mut self.simulation {
            simulation.seen = 0.0;
        }
        self.apply_settings(ctx);
        self.said =
            "The graphics card was lost. The window began again, with everything as it was."
                .to_owned();
    }

    /// Where the window was when it was drawn last.
    pub fn window_place(&self) -> WindowPlace {
        self.card.place
    }
}
