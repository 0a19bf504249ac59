//! The machine with threads and a file system.

use super::simulator::{Simulator, save_scene};
use super::working::{Wake, Working};
use super::{Done, Entry, Export, Lane, Opened, Platform, Settings, WorkProgress};
use crate::model::engine::{Engine, Failure, Job, export};
use crate::model::input::Input;
use crate::model::meshes::DrawnScene;
use crate::model::photograph::{PICTURE_SIDE, reduced};
use crate::model::project_file::ProjectFile;
use crate::model::simulated::scenes;
use crate::model::simulation::{Look, SceneEntry, SimulationJob, Source};
use crate::model::units::ShownUnit;
use greenstick::fibre::scene::Scene as Setting;
use greenstick::files::{self, Output};
use greenstick::formats::photograph::Photograph;
use greenstick::formats::{Content, InputFormat, LengthUnit};
use greenstick::geometry::Context;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

type ShowJob = (u64, Job, Working);

/// The machine.
pub struct Native {
    wake: Wake,
    done: Receiver<Done>,
    tell: Sender<Done>,
    jobs: Sender<ShowJob>,
    showing: Working,
    filing: Working,
    simulator: Simulator,
    /// Where settings, recent files and unsaved work are kept; none where there is no such place.
    folder: Option<PathBuf>,
}

/// The scene of a run, and its frames.
const SCENE_FILE: &str = "scene.toml";
const FRAMES_FILE: &str = "frames.gsf";
/// Files that are remembered.
const RECENT: usize = 10;
const RECENT_FILE: &str = "recent.txt";
const KEPT_FILE: &str = "unsaved.greenstick.toml";
const SETTINGS_FILE: &str = "window.txt";

/// The folder for what programs keep about a person.
pub fn config_folder() -> Option<PathBuf> {
    let set = |name: &str| {
        std::env::var_os(name)
            .filter(|v| !v.is_empty())
            .map(PathBuf::from)
    };
    let base = if cfg!(windows) {
        set("APPDATA")
    } else if cfg!(target_os = "macos") {
        set("HOME").map(|h| h.join("Library/Application Support"))
    } else {
        set("XDG_CONFIG_HOME").or_else(|| set("HOME").map(|h| h.join(".config")))
    };
    base.map(|b| b.join("greenstick"))
}

impl Native {
    /// The machine, which keeps things in `folder` and wakes the window by `wake`.
    pub fn new(folder: Option<PathBuf>, wake: Wake) -> Self {
        let (tell, done) = channel();
        Native {
            jobs: worker(&tell, &wake),
            simulator: Simulator::new(&tell, &wake),
            wake,
            done,
            tell,
            showing: Working::default(),
            filing: Working::default(),
            folder,
        }
    }

    fn kept_at(&self, name: &str) -> Option<PathBuf> {
        self.folder.as_ref().map(|f| f.join(name))
    }

    /// Writes a small file of the studio's own; that it cannot be written is no reason to disturb anybody.
    fn write_own(&self, name: &str, text: &str) {
        let Some(path) = self.kept_at(name) else {
            return;
        };
        if let Some(folder) = path.parent() {
            let _ = std::fs::create_dir_all(folder);
        }
        let bytes = text.as_bytes().to_vec();
        let _ = files::write_all(&[Output { path, bytes }]);
    }

    fn start(&mut self, work: impl FnOnce(&Context) -> Done + Send + 'static) {
        self.filing.token.cancel();
        self.filing = Working::default();
        self.filing.begin();
        let (filing, tell, wake) = (self.filing.clone(), self.tell.clone(), self.wake.clone());
        std::thread::spawn(move || {
            let done = work(&filing.context(&wake));
            filing.end();
            let _ = tell.send(done);
            wake();
        });
    }
}

/// Starts a thread for what the viewport shows. It ends when nobody can send it jobs any more.
fn worker(tell: &Sender<Done>, wake: &Wake) -> Sender<ShowJob> {
    let (jobs, queue) = channel::<ShowJob>();
    let (tell, wake) = (tell.clone(), wake.clone());
    std::thread::spawn(move || show_jobs(&queue, &tell, &wake));
    jobs
}

/// Does what the viewport shows, one after the other, with one engine that keeps the stages.
fn show_jobs(queue: &Receiver<ShowJob>, tell: &Sender<Done>, wake: &Wake) {
    let mut engine = Engine::default();
    while let Ok(mut next) = queue.recv() {
        // Only the newest counts.
        while let Ok(newer) = queue.try_recv() {
            next = newer;
        }
        let (number, job, working) = next;
        let context = working.context(wake);
        let mut early = |drawn: DrawnScene| {
            // That nobody listens any more is noticed by the answer.
            let drawn = Arc::new(drawn);
            let _ = tell.send(Done::Drawn(number, drawn.clone()));
            wake();
            // While the window draws it, so that the pointer need not wait.
            drawn.surveyed();
        };
        let outcome = engine.work(&job, &mut early, &context);
        working.end();
        let outcome = outcome.map(|s| s.map(Box::new)).map_err(Failure::from);
        if tell.send(Done::Shown(number, outcome)).is_err() {
            return;
        }
        wake();
    }
}

/// Reads a mesh or a scan.
fn read_input(path: &Path, unit: Option<LengthUnit>) -> Result<Input, Failure> {
    let (mut content, _) = files::load_content(path, unit).map_err(Failure::new)?;
    if let Content::Mesh(scene) = &mut content {
        // What is to be written lies in no folder yet: every image that is there comes along.
        files::carry_images(scene, path, &path.join("pieces.glb"));
    }
    Ok(Input::read(path.display().to_string(), content))
}

/// Whether `stem` is what was written beside the kept project at `path`.
fn is_kept_stem(path: &Path, stem: &Path) -> bool {
    let is_kept = path.file_name().is_some_and(|n| n == KEPT_FILE);
    is_kept && stem == Path::new(&ProjectFile::stem_path(&path.to_string_lossy()))
}

/// Reads a project or recipe with what it is about.
fn read_project(path: &Path) -> Result<(Input, ProjectFile), Failure> {
    let text = files::read_text(path).map_err(Failure::new)?;
    let read = ProjectFile::read(&text);
    let mut file = read.map_err(|e| Failure::new(format!("{}: {e}", path.display())))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let input = match &file.request.input {
        // What was kept for a recovery has no file of its own yet.
        Some(name) if is_kept_stem(path, &folder.join(name)) => {
            let stem = folder.join(name);
            let bytes = std::fs::read(&stem).map_err(Failure::new)?;
            let (content, _) = files::load_content(&stem, None).map_err(Failure::new)?;
            Input::made(content, bytes)
        }
        Some(name) => read_input(&folder.join(name), file.request.unit)?,
        None => Input::built_in(),
    };
    if let Some(photograph) = &mut file.studio.photograph.file {
        *photograph = folder.join(&*photograph).display().to_string();
    }
    Ok((input, file))
}

/// What to simulate, where a file is a scene and no recipe: the run beside it, where there is one.
fn as_scene(path: &Path) -> Option<Source> {
    let text = files::read_text(path).ok()?;
    let is_recipe = ProjectFile::read(&text).is_ok();
    // A scene with a mistake is a scene still, as its name says.
    let named = path.file_name().is_some_and(|n| n == SCENE_FILE);
    if is_recipe || !(named || Setting::read(&text).is_ok()) {
        return None;
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    Some(if named && folder.join(FRAMES_FILE).is_file() {
        Source::Run(folder.display().to_string())
    } else {
        Source::File(path.display().to_string())
    })
}

/// Reads whatever a file is.
pub fn read_any(path: &Path, unit: Option<LengthUnit>) -> Result<Opened, Failure> {
    let is_toml = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    if path.is_dir() {
        return Ok(Opened::Simulation(Source::Run(path.display().to_string())));
    }
    if is_toml {
        if let Some(source) = as_scene(path) {
            return Ok(Opened::Simulation(source));
        }
        let (input, file) = read_project(path)?;
        return Ok(Opened::Project(input, Box::new(file)));
    }
    if InputFormat::from_path(path).is_none() && path.is_file() {
        return Err(Failure::new(format!(
            "{}: neither a mesh, a point cloud nor a project (.toml); expected an ending such as .glb, .obj, .ply, .las or .toml",
            path.display()
        )));
    }
    Ok(Opened::Input(read_input(path, unit)?))
}

/// Breaks and writes the pieces, as the command line does.
fn write_pieces(wanted: &Export, context: &Context) -> Result<Vec<(String, usize)>, Failure> {
    let path = Path::new(&wanted.path);
    files::output_format(path).map_err(Failure::new)?;
    files::check_writable(path).map_err(Failure::new)?;
    let inputs: Vec<PathBuf> = wanted.input.path.iter().map(PathBuf::from).collect();
    files::check_distinct(&[path], &inputs).map_err(Failure::new)?;
    // Read again, as the command line reads: images stay references where the pieces go to the same folder.
    let input = match &wanted.input.path {
        Some(source) => {
            let (content, _) =
                files::load_content(Path::new(source), wanted.file.unit).map_err(Failure::new)?;
            Input::read(source.clone(), content)
        }
        None if wanted.input.made.is_some() => wanted.input.clone(),
        None => Input::built_in(),
    };
    let source = input.path.clone();
    let carry = |scene: &mut greenstick::geometry::Scene| {
        if let Some(source) = &source {
            files::carry_images(scene, Path::new(source), path);
        }
    };
    let broken = export(&input, &wanted.file, carry, context)?;
    let unit = wanted.file.unit.unwrap_or_default();
    let outputs = files::encode(&broken.scene, path, unit).map_err(Failure::new)?;
    let paths: Vec<&Path> = outputs.iter().map(|o| o.path.as_path()).collect();
    files::check_distinct(&paths, &inputs).map_err(Failure::new)?;
    files::write_all(&outputs).map_err(Failure::new)?;
    let size = |o: &Output| (o.path.display().to_string(), o.bytes.len());
    Ok(outputs.iter().map(size).collect())
}

impl Platform for Native {
    fn show(&mut self, number: u64, job: Job) {
        self.showing.token.cancel();
        if self.showing.is_stuck() {
            self.jobs = worker(&self.tell, &self.wake);
        }
        self.showing = Working::begun_now();
        self.showing.begin();
        let _ = self.jobs.send((number, job, self.showing.clone()));
    }

    fn open(&mut self, path: &str, unit: Option<LengthUnit>) {
        let path = path.to_owned();
        self.start(move |_| {
            let opened = read_any(Path::new(&path), unit);
            Done::Opened(path, opened)
        });
    }

    fn open_picture(&mut self, path: &str) {
        let (path, tell, wake) = (path.to_owned(), self.tell.clone(), self.wake.clone());
        // Beside both lanes: it takes a moment, and nothing else waits for it.
        std::thread::spawn(move || {
            let read = files::read_photograph(Path::new(&path)).map_err(Failure::new);
            let read = read.map(|image| {
                let (width, height, rgb) = (image.width, image.height, image.rgb);
                reduced(&Photograph { width, height, rgb }, PICTURE_SIDE)
            });
            let _ = tell.send(Done::Pictured(path, read));
            wake();
        });
    }

    fn scenes(&self) -> Vec<SceneEntry> {
        scenes()
    }

    fn simulate(&mut self, job: SimulationJob) {
        self.simulator.begin(job);
    }

    fn pause_simulation(&mut self, paused: bool) {
        self.simulator.pause(paused);
    }

    fn steer_simulation(&mut self, by: [f64; 3]) {
        self.simulator.steer(by);
    }

    fn step_simulation(&mut self) {
        self.simulator.step();
    }

    fn save_scene(&self, path: &str, job: &SimulationJob) -> Result<(), Failure> {
        save_scene(path, job)
    }

    fn draw_frame(&mut self, number: usize, look: Look) {
        self.simulator.draw(number, look);
    }

    fn take_break(&mut self, at_hand: u64) {
        self.simulator.take(at_hand);
    }

    fn export(&mut self, wanted: Export) {
        self.start(move |context| {
            let written = write_pieces(&wanted, context);
            Done::Exported(wanted.path, written)
        });
    }

    fn cancel(&mut self, lane: Lane) {
        match lane {
            Lane::Show => self.showing.token.cancel(),
            Lane::Files => self.filing.token.cancel(),
            Lane::Simulation => self.simulator.cancel(),
        }
    }

    fn progress(&self, lane: Lane) -> Option<WorkProgress> {
        match lane {
            Lane::Show => self.showing.at(),
            Lane::Files => self.filing.at(),
            Lane::Simulation => self.simulator.progress(),
        }
    }

    fn poll(&mut self) -> Option<Done> {
        self.done.try_recv().ok()
    }

    fn save(&self, path: &str, project: &ProjectFile) -> Result<(), Failure> {
        let outputs = project_files(project, path)?;
        files::write_all(&outputs).map_err(Failure::new)
    }

    fn list(&self, folder: &str) -> Result<(String, Vec<Entry>), Failure> {
        let folder = if folder.is_empty() { "." } else { folder };
        let problem = |e: std::io::Error| Failure::new(format!("{folder}: {e}"));
        let whole = std::fs::canonicalize(folder).map_err(problem)?;
        let mut entries = Vec::new();
        for entry in std::fs::read_dir(&whole).map_err(problem)? {
            let Ok(entry) = entry else { continue };
            let name = entry.file_name().to_string_lossy().into_owned();
            if !name.starts_with('.') {
                let is_file = !entry.path().is_dir();
                entries.push(Entry { is_file, name });
            }
        }
        entries.sort();
        Ok((whole.display().to_string(), entries))
    }

    fn join(&self, folder: &str, name: &str) -> String {
        Path::new(folder).join(name).display().to_string()
    }

    fn parent(&self, folder: &str) -> Option<String> {
        Some(Path::new(folder).parent()?.display().to_string())
    }

    fn recent(&self) -> Vec<String> {
        let read = |path: PathBuf| std::fs::read_to_string(path).ok();
        let text = self.kept_at(RECENT_FILE).and_then(read).unwrap_or_default();
        text.lines().map(str::to_owned).collect()
    }

    fn note_recent(&mut self, path: &str) {
        let whole = std::fs::canonicalize(path).unwrap_or_else(|_| PathBuf::from(path));
        let whole = whole.display().to_string();
        let mut list = self.recent();
        list.retain(|p| *p != whole);
        list.insert(0, whole);
        list.truncate(RECENT);
        self.write_own(RECENT_FILE, &(list.join("\n") + "\n"));
    }

    fn keep(&mut self, project: Option<&ProjectFile>) {
        let Some(path) = self.kept_at(KEPT_FILE) else {
            return;
        };
        match project {
            Some(project) => {
                if let Some(folder) = path.parent() {
                    let _ = std::fs::create_dir_all(folder);
                }
                // That it cannot be kept is no reason to disturb anybody.
                if let Ok(outputs) = project_files(project, &path.to_string_lossy()) {
                    let _ = files::write_all(&outputs);
                }
            }
            None => {
                drop(std::fs::remove_file(ProjectFile::stem_path(
                    &path.to_string_lossy(),
                )));
                drop(std::fs::remove_file(path));
            }
        }
    }

    fn kept(&self) -> Option<String> {
        let path = self.kept_at(KEPT_FILE)?;
        path.is_file().then(|| path.display().to_string())
    }

    fn settings(&self) -> Settings {
        let mut settings = Settings::default();
        let read = |path: PathBuf| std::fs::read_to_string(path).ok();
        for line in self
            .kept_at(SETTINGS_FILE)
            .and_then(read)
            .unwrap_or_default()
            .lines()
        {
            match line.split_once('=') {
                Some(("dark", word)) => settings.dark = word == "true",
                Some(("scale", number)) => {
                    settings.scale = number.parse().unwrap_or(1.0f32).clamp(0.5, 4.0);
                }
                Some(("unit", symbol)) => {
                    settings.unit = ShownUnit::from_symbol(symbol).unwrap_or_default();
                }
                _ => {}
            }
        }
        settings
    }

    fn keep_settings(&mut self, settings: &Settings) {
        let Settings { dark, scale, unit } = settings;
        let unit = unit.symbol();
        let text = format!("dark={dark}\nscale={scale}\nunit={unit}\n");
        self.write_own(SETTINGS_FILE, &text);
    }
}

/// The files of a project at `path`: its own, and that of a stem that has none yet.
fn project_files(project: &ProjectFile, path: &str) -> Result<Vec<Output>, Failure> {
    let mut project = project.clone();
    let mut outputs = Vec::new();
    if let Some(stem) = &project.stem {
        let beside = ProjectFile::stem_path(path);
        outputs.push(Output {
            path: PathBuf::from(&beside),
            bytes: stem.to_vec(),
        });
        project.request.input = Some(beside);
    }
    let path = PathBuf::from(path);
    let bytes = project_text(&project, &path)?.into_bytes();
    outputs.push(Output { path, bytes });
    Ok(outputs)
}

/// A project as the text of a file at `path`, with the paths of its input and its photograph from there.
fn project_text(project: &ProjectFile, path: &Path) -> Result<String, Failure> {
    let mut project = project.clone();
    let target = std::path::absolute(path).map_err(Failure::new)?;
    let named = [
        &mut project.request.input,
        &mut project.studio.photograph.file,
    ];
    for name in named.into_iter().flatten() {
        let whole = std::path::absolute(&*name).map_err(Failure::new)?;
        let inside = target
            .parent()
            .and_then(|folder| whole.strip_prefix(folder).ok());
        let found = inside.unwrap_or(&whole).to_str().ok_or_else(|| {
            Failure::new(format!(
                "{name}: the name is not Unicode, so a project cannot contain it; rename the file"
            ))
        })?;
        *name = found.to_owned();
    }
    Ok(project.to_toml())
}
