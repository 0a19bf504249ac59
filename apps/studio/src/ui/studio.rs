//! The state of the window, and what happens from frame to frame.

use super::anatomy_view::AnatomyView;
use super::card::Card;
use super::crack_tool::CrackTool;
use super::dialog::Dialog;
use super::fan_tool::FanTool;
pub use super::message::Message;
use super::paint_tool::PaintTool;
use super::photograph_view::PhotographView;
use super::simulation_view::SimulationView;
use crate::model::engine::{Failure, Haste, Job, Shown, has_coarse, unbroken};
use crate::model::input::Input;
use crate::model::meshes::DrawnScene;
use crate::model::photograph::is_picture;
use crate::model::project::Project;
use crate::model::project_file::{ProjectFile, SavedRings, SavedView};
use crate::model::section::{Plane, SectionFaces};
use crate::platform::{Opened, Platform, Settings};
use crate::view::camera::Camera;
use crate::view::frame::Colours;
use crate::view::sharpness::Sharpness;
use eframe::egui;
use glam::Vec3;
use greenstick::RequestFile;
use greenstick::schema::Value;
use greenstick::wood::stem::StemLocation;
use std::sync::Arc;

/// Seconds of work above which a drag gets a coarse answer first.
const SLOW: f64 = 0.12;
/// Seconds after a change before unsaved work is kept for a recovery.
const KEEP_AFTER: f64 = 2.0;
/// Seconds after which a frame follows the last one that something happened in.
const LAST_FRAME: f32 = 0.05;
/// Parts of the viewport's height that both faces of a break with the gap between them, and the diameter of the stem, fill at most
/// where the break is framed.
const FRAMED_FACES: f32 = 0.7;
const FRAMED_DIAMETER: f32 = 0.4;

/// How the viewport shows things.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewOptions {
    /// What colours show.
    pub colours: Colours,
    /// Whether edges are drawn.
    pub wireframe: bool,
    /// Whether the picture is cut open along the stem.
    pub section: bool,
    /// Whether handles are drawn on the wood.
    pub handles: bool,
    /// Distance of the pieces in the picture, in diameters of the stem.
    pub apart: f64,
}

/// The work for the viewport that is going on.
#[derive(Debug, Clone, Copy)]
pub(super) struct AtWork {
    pub number: u64,
    pub drag: bool,
    pub haste: Haste,
    pub since: f64,
}

/// How the picture is cut open.
#[derive(Debug, Default)]
pub(super) struct Section {
    /// The direction of its open side, of unit length.
    pub towards: Option<Vec3>,
    /// The number of what is drawn, the plane, and its faces.
    pub faces: Option<(u64, Plane, Arc<SectionFaces>)>,
}

/// The studio.
pub struct Studio {
    /// What is being worked on.
    pub project: Project,
    pub(super) platform: Box<dyn Platform>,
    /// The last answer; none while nothing of this input is broken.
    pub(super) shown: Option<Shown>,
    /// What the viewport draws, and a number that tells it apart.
    pub(super) drawn: Option<(u64, Arc<DrawnScene>)>,
    /// Width of the viewport over its height.
    pub(super) aspect: f32,
    /// Where the handle that tilts the break is in the window.
    pub(super) handle_at: Option<egui::Pos2>,
    pub(super) camera: Camera,
    pub(super) view: ViewOptions,
    pub(super) section: Section,
    pub(super) messages: Vec<Message>,
    pub(super) dialog: Option<Dialog>,
    pub(super) settings: Settings,
    /// Whether the pointer holds the handle that tilts the break.
    pub(super) holds_handle: bool,
    /// What is searched for among the parameters.
    pub(super) search: String,
    pub(super) gallery: bool,
    /// What was done last, in the status line.
    pub(super) said: String,
    /// The graphics card.
    pub(super) card: Card,
    /// How sharp the picture is while it moves.
    pub(super) sharpness: Sharpness,
    /// The camera of the frame before.
    pub(super) camera_seen: Camera,
    /// What the picture of the next result is asked with, and whether it is a drag.
    pub(super) wanted: Option<bool>,
    pub(super) at_work: Option<AtWork>,
    /// Seconds that the last whole answer took.
    pub(super) last_seconds: f64,
    /// Seconds after which the face as fine as it was asked for was drawn before its answer was finished; none where the last
    /// answer was not drawn before.
    pub(super) drawn_seconds: Option<f64>,
    /// When the whole answer is asked for, should nothing change before.
    pub(super) rests_at: Option<f64>,
    /// What was shown when the work began that is drawn before it is finished.
    pub(super) before: Option<(u64, Arc<DrawnScene>)>,
    pub(super) numbers: u64,
    /// Whether the next result is framed.
    pub(super) frame_next: bool,
    /// The view that the next result is seen from, where a project has one.
    pub(super) view_next: Option<SavedView>,
    /// Whether nobody has chosen the place of the break yet: the nearest one that works will do.
    pub(super) may_move_place: bool,
    /// When the project was changed, until it is kept.
    pub(super) changed_at: Option<f64>,
    /// A path that is being opened, as titles say it.
    pub(super) opening: Option<String>,
    pub(super) photograph: PhotographView,
    /// The section browser.
    pub(super) anatomy: AnatomyView,
    /// The handles of the ductile zone and of the layers.
    pub fans: FanTool,
    /// The tool that places cracks.
    pub(super) cracks: CrackTool,
    /// The tool that paints on the broken face.
    pub paint: PaintTool,
    /// Where the viewport was drawn.
    pub(super) viewport_rect: Option<egui::Rect>,
    /// The simulation that is looked at in place of the break.
    pub(super) simulation: Option<SimulationView>,
    pub(super) gallery_pictures: super::pictures::Pictures,
    pub(super) quit: bool,
}

impl Studio {
    /// A studio that opens `path`, or shows the built-in branch.
    pub fn new(ctx: &egui::Context, platform: Box<dyn Platform>, path: Option<&str>) -> Self {
        let settings = platform.settings();
        ctx.options_mut(|o| o.zoom_with_keyboard = false);
        let mut studio = Studio {
            project: Project::new(Input::built_in(), RequestFile::default()),
            platform,
            shown: None,
            drawn: None,
            aspect: 1.4,
            handle_at: None,
            camera: Camera::default(),
            view: ViewOptions {
                colours: Colours::Wood,
                wireframe: false,
                section: false,
                handles: true,
                apart: 1.6,
            },
            section: Section::default(),
            messages: Vec::new(),
            dialog: None,
            settings,
            holds_handle: false,
            search: String::new(),
            gallery: true,
            said: String::new(),
            card: Card::default(),
            sharpness: Sharpness::new(false),
            camera_seen: Camera::default(),
            wanted: Some(false),
            at_work: None,
            last_seconds: 0.0,
            drawn_seconds: None,
            rests_at: None,
            before: None,
            numbers: 0,
            frame_next: true,
            view_next: None,
            may_move_place: false,
            changed_at: None,
            opening: None,
            photograph: PhotographView::default(),
            anatomy: AnatomyView::default(),
            fans: FanTool::default(),
            cracks: CrackTool::default(),
            paint: PaintTool::default(),
            viewport_rect: None,
            simulation: None,
            gallery_pictures: super::pictures::Pictures::default(),
            quit: false,
        };
        studio.apply_settings(ctx);
        if let Some(path) = path.filter(|p| !is_picture(p)) {
            studio.open(path);
            return studio;
        }
        studio.begin(Opened::Input(Input::built_in()), "");
        if let Some(path) = path {
            studio.open_photograph(path);
        } else if let Some(kept) = studio.platform.kept() {
            studio.dialog = Some(Dialog::Recover(kept));
        }
        studio
    }

    /// The picture is asked for anew with another view of the pieces; nothing else changes.
    pub(super) fn changed_view(&mut self, drag: bool) {
        self.wanted = Some(drag);
    }

    pub(super) fn apply_settings(&mut self, ctx: &egui::Context) {
        let Settings { dark, scale, .. } = self.settings;
        ctx.set_theme(if dark {
            egui::Theme::Dark
        } else {
            egui::Theme::Light
        });
        ctx.set_zoom_factor(scale);
        self.platform.keep_settings(&self.settings);
    }

    /// Starts to open a file.
    pub fn open(&mut self, path: &str) {
        if is_picture(path) {
            return self.open_photograph(path);
        }
        self.opening = Some(path.to_owned());
        self.platform.open(path, self.project.file.unit);
    }

    /// Shows a message that stays.
    pub(super) fn fail(&mut self, failure: &Failure) {
        if failure.cancelled {
            self.said = "Stopped.".to_owned();
            return;
        }
        let message = Message {
            text: failure.message.clone(),
            is_error: true,
            place: failure.place,
            asks_unit: false,
        };
        if !self.messages.contains(&message) {
            self.messages.push(message);
        }
    }

    /// Whether work for the viewport is going on or about to begin.
    pub fn is_busy(&self) -> bool {
        let waits = self.wanted.is_some() || self.rests_at.is_some();
        self.at_work.is_some()
            || waits
            || self.opening.is_some()
            || self.photograph.is_awaited()
            || self.simulates()
    }

    /// Number of triangles that are shown.
    pub fn triangles(&self) -> usize {
        let drawn = self.drawn.as_ref();
        drawn.map_or(0, |d| d.1.indices.len() / 3)
    }

    /// Where the handle that tilts the break is in the window, where there is one.
    pub fn handle_at(&self) -> Option<egui::Pos2> {
        self.handle_at
    }

    /// The middle of the viewport in the window.
    pub fn viewport_middle(&self) -> Option<egui::Pos2> {
        self.viewport_rect.map(|r| r.center())
    }

    /// Messages that wait to be dismissed.
    pub fn messages(&self) -> &[Message] {
        &self.messages
    }

    /// The report on what is shown.
    pub fn report(&self) -> Option<&greenstick::BreakReport> {
        self.shown.as_ref().map(|s| &s.report)
    }

    /// Notes that the request changed; `drag` while a hand still moves.
    pub(super) fn changed(&mut self, drag: bool, now: f64) {
        self.wanted = Some(drag);
        self.changed_at = Some(now);
    }

    /// Sets one parameter as part of a drag, or as one step.
    pub fn set(&mut self, key: &str, value: &Value, drag: bool, now: f64) {
        match self.project.set(key, value, drag) {
            Ok(true) => self.changed(drag, now),
            Ok(false) => {}
            Err(problem) => self.said = problem,
        }
    }

    /// The hand rests: what was a drag is a step, and the whole answer is asked for.
    pub(super) fn rest(&mut self, now: f64) {
        self.project.history.rest();
        self.changed(false, now);
    }

    /// Notes that a step changed the request, or says why it did not.
    pub(super) fn finish_step(&mut self, step: Result<bool, String>, now: f64) {
        match step {
            Ok(true) => self.changed(false, now),
            Ok(false) => {}
            Err(problem) => self.fail(&Failure::new(problem)),
        }
    }

    /// Puts the selected break at a place of the scene; a point is one of the unbroken stem.
    pub(super) fn move_break(&mut self, place: StemLocation, now: f64) {
        let moved = self.project.move_break(place);
        self.finish_step(moved, now);
    }

    /// Begins with another input or project.
    pub(super) fn begin(&mut self, opened: Opened, path: &str) {
        self.may_move_place = matches!(opened, Opened::Input(_));
        let mut view = SavedView::default();
        match opened {
            Opened::Input(input) => {
                let mut file = self.project.file.clone();
                // A place on another stem says nothing on this one.
                file.common.place = StemLocation::Fraction(0.5);
                file.breaks.clear();
                let photograph = self.project.photograph.clone();
                self.project = Project::new(input, file);
                self.project.photograph = photograph;
            }
            Opened::Simulation(_) => return,
            Opened::Project(input, file) => {
                view = file.studio.view.clone();
                self.project = Project::new(input, *file);
                // A recovered project has no file of its own, nor has the address of a page.
                let is_file = path.to_lowercase().ends_with(".toml");
                let own = is_file && self.platform.kept().as_deref() != Some(path);
                self.project.path = own.then(|| path.to_owned());
            }
        }
        let notes = self.project.input.notes.join("\n");
        if !notes.is_empty() {
            self.messages.push(Message {
                text: notes,
                ..Message::default()
            });
        }
        self.shown = None;
        self.forget_sections();
        self.numbers += 1;
        let number = self.numbers;
        self.drawn = unbroken(&self.project.input).map(|d| (number, Arc::new(d)));
        self.camera.z_up = self.project.input.has_z_up();
        self.frame_all();
        self.frame_next = true;
        self.view_next = Some(view).filter(|v| v.saved);
        self.wanted = Some(false);
    }

    /// Takes what came to an end, and starts what is wanted.
    pub fn tick(&mut self, ctx: &egui::Context) {
        let now = ctx.input(|i| i.time);
        while let Some(done) = self.platform.poll() {
            self.take(done, now);
        }
        if let Some(at) = self.changed_at
            && now - at > KEEP_AFTER
        {
            self.changed_at = None;
            let project = self.project_file();
            self.platform.keep(Some(&project));
        } else if self.changed_at.is_some() {
            ctx.request_repaint_after_secs(KEEP_AFTER as f32);
        }
        if let Some(at) = self.rests_at {
            if self.wanted.is_some() || self.at_work.is_some() {
                self.rests_at = None;
            } else if now >= at {
                self.rests_at = None;
                self.wanted = Some(false);
            } else {
                ctx.request_repaint_after_secs((at - now) as f32);
            }
        }
        self.follow_photograph();
        self.follow_simulation(ctx, now);
        self.start_work(now);
    }

    /// The project as it is written now. The view goes with a photograph, which is matched from it alone.
    pub fn project_file(&self) -> ProjectFile {
        let mut file = ProjectFile::from(self.project.file.clone());
        file.request.input = self.project.input.path.clone();
        file.stem = self.project.input.made.clone();
        file.studio.photograph = self.project.photograph.clone();
        file.studio.rings = SavedRings::new(&self.project.pins());
        if let (Some((_, drawn)), Some(_)) = (&self.drawn, &self.project.photograph.file) {
            file.studio.view = SavedView::new(&self.camera, drawn.middle);
        }
        file
    }

    fn start_work(&mut self, now: f64) {
        let (Some(drag), None) = (self.wanted, &self.opening) else {
            return;
        };
        // What a drag asks for waits until the answer before is there: else there would never be one.
        if self.at_work.is_some_and(|w| drag && w.drag) {
            return;
        }
        let haste = self.haste(drag);
        if self.at_work.is_some() && drag && haste == Haste::Whole {
            return;
        }
        self.numbers += 1;
        self.wanted = None;
        self.at_work = Some(AtWork {
            number: self.numbers,
            drag,
            haste,
            since: now,
        });
        let mut file = self.project.file.clone();
        let apart = self.apart();
        for one in file.breaks.iter_mut().chain([&mut file.common]) {
            if one.separation < apart {
                // What an export would not do: splinters stay straight, and the slider moves as far as it says.
                (one.separation, one.part_clear) = (apart, false);
                let face = &mut one.recipe.face;
                face.splinter_lean.get_or_insert(0.0);
                face.splinter_snap.get_or_insert(0.0);
            }
        }
        let job = Job {
            input: self.project.input.clone(),
            file,
            haste,
            sections_of: self.sections_wanted(),
        };
        self.platform.show(self.numbers, job);
    }

    /// How much of an answer a drag or a step needs: a drag that can be drawn quickly needs nothing else until the hand rests.
    fn haste(&self, drag: bool) -> Haste {
        let coarser = |seconds: f64| seconds > SLOW && has_coarse(&self.project.file);
        match self.drawn_seconds {
            _ if !drag => Haste::Whole,
            Some(seconds) if coarser(seconds) => Haste::Coarse,
            Some(_) => Haste::Drawn,
            None if coarser(self.last_seconds) => Haste::Coarse,
            None => Haste::Whole,
        }
    }

    /// How far the picture pulls the pieces apart, m. Those that hang on each other stay together.
    pub(super) fn apart(&self) -> f64 {
        let file = &self.project.file;
        let breaks = std::iter::once(&file.common).chain(&file.breaks);
        let hangs = breaks.into_iter().any(|b| b.recipe.face.hang > 0.0);
        if hangs {
            0.0
        } else {
            self.view.apart * self.diameter()
        }
    }

    /// Diameter of the stem at the first break, m; 0 where it is not known yet.
    pub(super) fn diameter(&self) -> f64 {
        let report = self.shown.as_ref().map(|s| &s.report);
        report.map_or(0.0, |r| 2.0 * r.place.radius_m)
    }

    /// Shows the break from near.
    pub(super) fn frame_break(&mut self) {
        let Some((_, drawn)) = self.drawn.as_ref().filter(|_| self.simulation.is_none()) else {
            return self.frame_all();
        };
        let Some(at) = drawn.breaks.first() else {
            return self.frame_all();
        };
        // The upper face is moved up along the stem.
        let (low, high) = (at.heights[0], at.heights[1] + self.apart() as f32);
        let faces = (high - low) / FRAMED_FACES;
        let height = faces.max(2.0 * at.radius / FRAMED_DIAMETER);
        let centre = at.place + at.along * (0.5 * (low + high));
        self.camera.frame_height(centre, height, self.aspect);
        if self.frame_next {
            self.camera.look_from_aside(at.along);
        }
    }

    pub(super) fn frame_all(&mut self) {
        if let Some(simulation) = &self.simulation {
            self.camera
                .frame(Vec3::ZERO, simulation.rest_radius, self.aspect);
        } else if let Some((_, drawn)) = &self.drawn {
            self.camera
                .frame(Vec3::ZERO, drawn.radius as f32, self.aspect);
        }
    }

    /// One frame.
    pub fn frame(&mut self, ui: &mut egui::Ui) {
        let ctx = ui.ctx().clone();
        if self.leaves_lost_card(&ctx) {
            return;
        }
        self.tick(&ctx);
        self.dropped(&ctx);
        self.simulation_keys(&ctx);
        self.crack_keys(&ctx);
        self.paint_keys(&ctx);
        self.shortcuts(&ctx);
        self.menu(ui);
        self.status(ui);
        if self.simulation.is_some() {
            self.simulation_panel(ui);
            self.timeline(ui);
        } else {
            if self.anatomy.open {
                self.anatomy_panel(ui);
            } else if self.gallery {
                self.gallery_panel(ui);
            }
            self.parameters(ui);
        }
        self.viewport(ui);
        self.dialogs(&ctx);
        // Some displays show a frame only with the next one; the picture itself is not drawn again.
        if ctx.input(|i| !i.events.is_empty()) {
            ctx.request_repaint_after_secs(LAST_FRAME);
        }
        if self.quit {
            self.quit = false;
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        }
        let title = format!(
            "{}{} – Greenstick",
            if self.project.is_changed() {
                "• "
            } else {
                ""
            },
            self.project.input.title()
        );
        ctx.send_viewport_cmd(egui::ViewportCommand::Title(title));
    }
}

impl eframe::App for Studio {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        self.frame(ui);
    }

    fn on_exit(&mut self) {
        if self.project.is_changed() {
            self.keep_changes();
        } else {
            self.platform.keep(None);
        }
    }
}
