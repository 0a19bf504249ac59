//! What the studio needs of the machine it runs on: work beside the window, files, and places to keep things.

#[cfg(not(target_arch = "wasm32"))]
mod gate;
#[cfg(not(target_arch = "wasm32"))]
pub mod native;
#[cfg(not(target_arch = "wasm32"))]
mod simulator;
#[cfg(target_arch = "wasm32")]
pub mod web;
#[cfg(not(target_arch = "wasm32"))]
mod working;

use crate::model::engine::{Failure, Job, Shown};
use crate::model::input::Input;
use crate::model::meshes::DrawnScene;
use crate::model::project_file::ProjectFile;
use crate::model::simulation::{Look, News, SceneEntry, SimulationJob, Source};
use crate::model::units::ShownUnit;
use greenstick::RequestFile;
use greenstick::formats::LengthUnit;
use greenstick::formats::photograph::Photograph;
use std::borrow::Cow;
use std::sync::Arc;

/// How far some work is.
#[derive(Debug, Clone, PartialEq)]
pub struct WorkProgress {
    /// The name of its stage.
    pub stage: Cow<'static, str>,
    /// 0 to 1.
    pub overall: f64,
}

/// The two things that go on beside the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lane {
    /// What the viewport shows.
    Show,
    /// Reading and writing of files.
    Files,
    /// A simulation, and what is made of it.
    Simulation,
}

/// Pieces that are to be written.
#[derive(Debug, Clone)]
pub struct Export {
    /// What is broken.
    pub input: Input,
    /// How.
    pub file: RequestFile,
    /// The file's path; its ending decides the format.
    pub path: String,
}

/// What was opened.
#[derive(Debug)]
pub enum Opened {
    /// A mesh or a scan.
    Input(Input),
    /// A project or a recipe, and what it is about.
    Project(Input, Box<ProjectFile>),
    /// A scene or a run, to be simulated or played.
    Simulation(Source),
}

/// Work that came to an end.
#[derive(Debug)]
pub enum Done {
    /// What the viewport shows before the answer is finished, by the number it was asked for with.
    Drawn(u64, Arc<DrawnScene>),
    /// The finished answer, by the number it was asked for with; none where only what is drawn was wanted.
    Shown(u64, Result<Option<Box<Shown>>, Failure>),
    /// A file that was read: its path, and what is in it.
    Opened(String, Result<Opened, Failure>),
    /// A photograph that was read, no larger than cards take: its path, and what is in it.
    Pictured(String, Result<Photograph, Failure>),
    /// News of a simulation, by its number.
    Simulated(u64, News),
    /// Files that were written, with their sizes in bytes.
    Exported(String, Result<Vec<(String, usize)>, Failure>),
}

/// A file or folder.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Entry {
    /// Whether it is no folder; folders come first.
    pub is_file: bool,
    /// Its name.
    pub name: String,
}

/// The machine.
pub trait Platform {
    /// Starts to make what the viewport shows; what is still at work is given up, or finished first where it is nearly there.
    fn show(&mut self, number: u64, job: Job);
    /// Starts to read a file: a mesh, a scan, a recipe or a project.
    fn open(&mut self, path: &str, unit: Option<LengthUnit>);
    /// Starts to read a photograph: PNG or JPEG.
    fn open_picture(&mut self, path: &str);
    /// Starts to break as the command line does, and to write the pieces.
    fn export(&mut self, export: Export);
    /// The scenes that come with the program; none where nothing can be simulated.
    fn scenes(&self) -> Vec<SceneEntry> {
        Vec::new()
    }
    /// Starts to simulate, or to read a run; what was simulated before is given up.
    fn simulate(&mut self, _: SimulationJob) {}
    /// Holds the run that goes on after its present frame, or lets it go on.
    fn pause_simulation(&mut self, _paused: bool) {}
    /// Lets a run that is held go on to its next frame.
    fn step_simulation(&mut self) {}
    /// Has the hand of the run that goes on pull elsewhere from its present frame on: so many parts of the stem's length along the axes of
    /// the scene.
    fn steer_simulation(&mut self, _by: [f64; 3]) {}
    /// Writes the scene of a simulation, with parts of it where they were moved.
    ///
    /// # Errors
    /// Why it could not be written.
    fn save_scene(&self, _path: &str, _: &SimulationJob) -> Result<(), Failure> {
        Err(Failure::new("nothing can be simulated here"))
    }
    /// Starts to draw a frame of the simulation; only the newest that was asked for counts.
    fn draw_frame(&mut self, _: usize, _: Look) {}
    /// Starts to take the break that the simulation left; `at_hand` is the number of the input that is shown.
    fn take_break(&mut self, _at_hand: u64) {}
    /// Asks work to stop.
    fn cancel(&mut self, lane: Lane);
    /// How far work is; none where nothing is at work.
    fn progress(&self, lane: Lane) -> Option<WorkProgress>;
    /// The next work that came to an end.
    fn poll(&mut self) -> Option<Done>;
    /// Writes a project; the paths of its input and its photograph become relative to its folder where they are inside.
    ///
    /// # Errors
    /// Why it could not be written.
    fn save(&self, path: &str, project: &ProjectFile) -> Result<(), Failure>;
    /// Whether there are folders to look into. Where there are none, files are chosen by [`Platform::choose`] and written by their
    /// names alone.
    fn has_folders(&self) -> bool {
        true
    }
    /// Lets the machine ask for files to open, where it has a dialog of its own for that.
    fn choose(&mut self) {}
    /// The entries of a folder, and its whole path.
    ///
    /// # Errors
    /// Why it could not be read.
    fn list(&self, folder: &str) -> Result<(String, Vec<Entry>), Failure>;
    /// The path of a name in a folder.
    fn join(&self, folder: &str, name: &str) -> String;
    /// The folder above one.
    fn parent(&self, folder: &str) -> Option<String>;
    /// Files that were opened lately, the last one first.
    fn recent(&self) -> Vec<String>;
    /// Notes that a file was opened or saved.
    fn note_recent(&mut self, path: &str);
    /// Keeps a project so that it survives a crash; `None` once it is saved or given up.
    fn keep(&mut self, project: Option<&ProjectFile>);
    /// What was kept when the program last ended without saving: where it is.
    fn kept(&self) -> Option<String>;
    /// Tells that the graphics card was lost, where it is the machine that goes on with the studio on another one.
    fn tell_card_lost(&mut self) {}
    /// Settings of the window.
    fn settings(&self) -> Settings;
    /// Keeps settings of the window.
    fn keep_settings(&mut self, settings: &Settings);
}

/// Settings of the window.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Whether it is dark.
    pub dark: bool,
    /// How large everything is.
    pub scale: f32,
    /// The unit in which lengths are shown.
    pub unit: ShownUnit,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            dark: true,
            scale: 1.0,
            unit: ShownUnit::default(),
        }
    }
}
