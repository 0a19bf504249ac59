//! Taking what came to an end: pictures of breaks, files that were read or written.

use super::message::Message;
use super::studio::{AtWork, Studio};
use crate::model::engine::{Failure, Haste, Shown};
use crate::model::input::Input;
use crate::model::meshes::DrawnScene;
use crate::platform::{Done, Opened};
use std::sync::Arc;

/// Seconds without a change after which a hand that still drags rests: the whole answer is asked for.
const RESTS_AFTER: f64 = 0.3;

impl Studio {
    pub(super) fn take(&mut self, done: Done, now: f64) {
        match done {
            Done::Drawn(number, drawn) => {
                let current = self.at_work.filter(|w| w.number == number);
                let Some(work) = current else { return };
                if work.haste != Haste::Coarse {
                    self.drawn_seconds = Some(now - work.since);
                }
                let before = self.draw(drawn);
                self.before = self.before.take().or(before);
            }
            Done::Shown(number, outcome) => {
                let current = self.at_work.filter(|w| w.number == number);
                let Some(work) = current else { return };
                self.at_work = None;
                match outcome {
                    Ok(Some(shown)) => self.take_shown(*shown, work, now),
                    Ok(None) => self.rests_at = Some(now + RESTS_AFTER),
                    Err(failure) => {
                        // What cannot be finished is not shown.
                        self.drawn = self.before.take().or(self.drawn.take());
                        if !self.break_at_nearest_place(&failure) {
                            self.fail(&failure);
                        }
                    }
                }
            }
            Done::Opened(path, opened) => {
                self.opening = None;
                match opened {
                    Ok(Opened::Simulation(source)) => {
                        self.platform.note_recent(&path);
                        if self.drawn.is_none() {
                            self.begin(Opened::Input(Input::built_in()), "");
                        }
                        self.begin_simulation(source, false);
                    }
                    Ok(opened) => {
                        self.platform.note_recent(&path);
                        self.said = format!("Opened {path}.");
                        self.begin(opened, &path);
                        if !self.platform.has_folders() {
                            // The address of a page says what is open.
                            self.changed_at = Some(now);
                        }
                    }
                    Err(failure) => self.fail(&failure),
                }
            }
            Done::Pictured(path, picture) => self.take_photograph(&path, picture, now),
            Done::Simulated(number, news) => self.take_simulated(number, news, now),
            Done::Exported(path, Ok(files)) => {
                let bytes: usize = files.iter().map(|f| f.1).sum();
                let size = bytes as f64 / 1e6;
                self.said = format!("Wrote {path} ({} files, {size:.1} MB).", files.len());
            }
            Done::Exported(_, Err(failure)) => self.fail(&failure),
        }
    }

    /// Breaks what was just opened at the nearest place that works, if its middle does not; returns whether there is one.
    fn break_at_nearest_place(&mut self, failure: &Failure) -> bool {
        let may_move_place = std::mem::take(&mut self.may_move_place);
        let Some(place) = failure.place.filter(|_| may_move_place) else {
            return false;
        };
        let project = &mut self.project;
        let untouched = !project.is_changed();
        project.file.common.place = place;
        if untouched {
            // Nobody changed anything that could be lost.
            project.note_saved();
        }
        self.messages.push(Message {
            text: format!("Broken at {place}: {}.", failure.message),
            ..Message::default()
        });
        self.wanted = Some(false);
        true
    }

    fn take_shown(&mut self, mut shown: Shown, work: AtWork, now: f64) {
        self.may_move_place = false;
        if !shown.coarse {
            self.last_seconds = now - work.since;
        }
        if self.before.take().is_none() {
            self.drawn_seconds = None;
        }
        // The size of the stem was not known when the pieces of the first picture were moved apart.
        let first = self.shown.is_none() && self.apart() == 0.0 && self.view.apart > 0.0;
        self.rests_at = shown.coarse.then_some(now + RESTS_AFTER);
        self.take_sections(shown.sections.take());
        self.draw(Arc::new(std::mem::take(&mut shown.drawn)));
        let is_new = self.shown.is_none();
        self.shown = Some(shown);
        if is_new {
            self.ask_for_unit();
        }
        if first && self.apart() > 0.0 {
            self.wanted = Some(false);
        }
        self.frame_shown();
    }

    /// Frames what is shown for the first time; not while a simulation is looked at.
    pub(super) fn frame_shown(&mut self) {
        if self.simulation.is_some() {
            return;
        }
        if self.frame_next {
            self.frame_break();
            self.frame_next = false;
        }
        let view = self.view_next.take();
        let middle = self.drawn.as_ref().map(|d| d.1.middle);
        if let Some(camera) = view.zip(middle).and_then(|(v, middle)| v.camera(middle)) {
            self.camera = camera;
        }
    }

    /// Draws another scene, seen from where the one before was; returns that.
    fn draw(&mut self, scene: Arc<DrawnScene>) -> Option<(u64, Arc<DrawnScene>)> {
        if let Some((_, before)) = &self.drawn {
            let camera = match &mut self.simulation {
                Some(simulation) => &mut simulation.camera_before,
                None => &mut self.camera,
            };
            camera.target += (before.middle - scene.middle).as_vec3();
        }
        self.numbers += 1;
        self.drawn.replace((self.numbers, scene))
    }
}
