//! The machine as a browser gives it: work in a worker of the same program that shares no memory with the page, files by a button, by
//! drops and as downloads, and the address that holds the request.

mod browser;
mod helper;
mod news;
mod page;
mod serve;
mod simulating;

use super::{Done, Entry, Export, Lane, Opened, Platform, Settings, WorkProgress};
use crate::model::engine::{Failure, Job};
use crate::model::held::is_project;
use crate::model::input::Input;
use crate::model::job_scene::{JobScene, own_setting};
use crate::model::link::{link, read_link};
use crate::model::messages::{Answer, Ask, OpenedFiles, from_bytes};
use crate::model::photograph::is_picture;
use crate::model::project_file::ProjectFile;
use crate::model::simulated::scenes;
use crate::model::simulation::{self, Look, SceneEntry, SimulationJob};
use crate::model::units::ShownUnit;
use eframe::wasm_bindgen::{JsCast, JsValue};
use greenstick::formats::LengthUnit;
use greenstick::formats::photograph::Photograph;
use greenstick::schema::write_toml;
use helper::{Held, Helper, PATIENCE};
use js_sys::Array;
use news::{Inbox, JsFile, News, Wake};
use simulating::{Heard, Simulating};
use std::collections::VecDeque;
use std::sync::Arc;

/// What the second helper does.
enum Filing {
    /// Finds out what these files are.
    Open(Vec<JsFile>),
    /// Reads a photograph of this name.
    Picture(String),
    /// Makes the pieces, of this path.
    Export(String),
}

/// The machine.
pub struct Web {
    wake: Wake,
    inbox: Inbox,
    done: VecDeque<Done>,
    show: Helper,
    /// The picture that is being made, and the one that is wanted after it.
    showing: Option<u64>,
    wanted: Option<(u64, Job)>,
    files: Option<(Helper, Filing)>,
    simulating: Simulating,
    held: Held,
    /// The photograph that came last.
    picture: Option<JsFile>,
    /// A request that waits for the file it is about.
    waiting: Option<ProjectFile>,
}

/// Begins: as the page, or as its worker.
pub fn begin() {
    if let Ok(scope) = js_sys::global().dyn_into::<web_sys::DedicatedWorkerGlobalScope>() {
        serve::serve(&scope);
    } else {
        wasm_bindgen_futures::spawn_local(page::begin(|wake| Box::new(Web::new(wake))));
    }
}

impl Web {
    /// The machine, which wakes the page by `wake`.
    fn new(wake: Wake) -> Self {
        let inbox = Inbox::default();
        browser::listen(&inbox, &wake);
        inbox.borrow_mut().push_back(News::Address);
        Web {
            show: Helper::new(&inbox, &wake),
            wake,
            inbox,
            done: VecDeque::new(),
            showing: None,
            wanted: None,
            files: None,
            simulating: Simulating::default(),
            held: Held::default(),
            picture: None,
            waiting: None,
        }
    }

    /// Ends the worker that makes pictures, with what it does, and starts another.
    fn renew(&mut self) {
        self.show = Helper::new(&self.inbox, &self.wake);
        self.showing = None;
    }

    /// Starts to make the picture that is wanted, unless another is nearly there.
    fn show_next(&mut self) {
        if self.wanted.is_none() {
            return;
        }
        if self.showing.is_some() {
            if !self.show.works_longer_than(PATIENCE) {
                return;
            }
            self.renew();
        }
        let Some((number, job)) = self.wanted.take() else {
            return;
        };
        let input = job.input.id;
        if input != 0 && self.show.holds != input && self.held.input == input {
            let unit = self.held.unit.clone();
            self.show.ask(&Ask::Hold { input, unit }, &self.held.files);
            self.show.holds = input;
        }
        let ask = Ask::Show {
            number,
            input,
            request: job.file.to_toml(),
            haste: job.haste,
            sections_of: job.sections_of,
        };
        self.show.ask(&ask, &[]);
        self.showing = Some(number);
    }

    /// Starts work on files, in a worker of its own that ends with it.
    fn start(&mut self, ask: &Ask, files: &[JsFile], filing: Filing) {
        let mut helper = Helper::new(&self.inbox, &self.wake);
        helper.ask(ask, files);
        self.files = Some((helper, filing));
    }

    /// Starts to read the photograph that came last.
    fn read_picture(&mut self) {
        if let Some(file) = self.picture.clone() {
            let filing = Filing::Picture(file.name.clone());
            self.start(&Ask::Picture, &[file], filing);
        }
    }

    fn news(&mut self) -> Option<News> {
        self.inbox.borrow_mut().pop_front()
    }

    fn hear(&mut self, news: News) {
        match news {
            News::Said(from, message) => {
                let answer = message.get(0).dyn_into::<js_sys::Uint8Array>();
                let bytes = answer.map(|b| b.to_vec()).unwrap_or_default();
                match from_bytes::<Answer>(&bytes) {
                    Ok(answer) => self.answered(from, answer, &message),
                    Err(error) => self.ended(from, &error),
                }
            }
            News::Ended(from, error) => self.ended(from, &error),
            // A picture that comes alone is a photograph; with others it may be a texture.
            News::Files(mut files) if files.len() == 1 && is_picture(&files[0].name) => {
                self.picture = files.pop();
                self.read_picture();
            }
            News::Files(files) => {
                let unit: Option<String> = None;
                self.start(&Ask::Open { unit }, &files.clone(), Filing::Open(files));
            }
            News::Problem(problem) => self.fail(&problem),
            News::Address => self.follow_address(),
        }
    }

    /// Tells of something that went wrong with files.
    fn fail(&mut self, problem: &str) {
        let failure = Err(Failure::new(problem));
        self.done.push_back(Done::Opened(String::new(), failure));
    }

    fn answered(&mut self, from: u64, answer: Answer, message: &Array) {
        if self.simulating.is_by(from) {
            return self.simulated(answer, message);
        }
        if from == self.show.number {
            match answer {
                Answer::Ready => self.show.is_ready(),
                Answer::Progress { stage, overall } => {
                    browser::mark("progress", true);
                    self.show.progress(stage, overall);
                }
                Answer::Fault(text) => self.show.fault = Some(text),
                Answer::Drawn(number, drawn) => {
                    browser::mark("drawn", false);
                    self.done.push_back(Done::Drawn(number, Arc::from(drawn)));
                }
                Answer::Shown(number, shown) => {
                    browser::mark("shown", false);
                    self.show.rests();
                    self.showing = None;
                    self.done.push_back(Done::Shown(number, shown));
                }
                _ => {}
            }
            return;
        }
        let Some((helper, _)) = self.files.as_mut().filter(|f| f.0.number == from) else {
            return;
        };
        match answer {
            Answer::Ready => helper.is_ready(),
            Answer::Progress { stage, overall } => helper.progress(stage, overall),
            Answer::Fault(text) => helper.fault = Some(text),
            Answer::Opened(opened) => {
                if let Some((_, Filing::Open(files))) = self.files.take() {
                    self.opened(files, opened.map(|o| *o));
                }
            }
            Answer::Pictured(picture) => {
                if let Some((_, Filing::Picture(name))) = self.files.take() {
                    let picture =
                        picture.map(|(width, height, rgb)| Photograph { width, height, rgb });
                    self.done.push_back(Done::Pictured(name, picture));
                }
            }
            Answer::Exported(names) => {
                if let Some((_, Filing::Export(path))) = self.files.take() {
                    let written = names.map(|names| browser::download_all(&names, message));
                    self.done.push_back(Done::Exported(path, written));
                }
            }
            _ => {}
        }
    }

    /// The worker of the simulation said something.
    fn simulated(&mut self, answer: Answer, message: &Array) {
        match self.simulating.hear(answer, message) {
            Heard::Nothing => {}
            Heard::Done(done) => {
                if let Done::Simulated(_, simulation::News::Frame(..)) = &done {
                    browser::mark("frame", false);
                }
                self.done.push_back(done);
            }
            Heard::Stem(done, input, file) => {
                self.held = Held {
                    input,
                    unit: None,
                    files: vec![file],
                };
                self.done.push_back(done);
            }
        }
    }

    /// A worker ended by itself: most often it got no more memory.
    fn ended(&mut self, from: u64, error: &str) {
        if self.simulating.is_by(from) {
            let done = self.simulating.ended(error);
            self.done.extend(done);
        } else if from == self.show.number {
            let failure = Failure::new(self.show.why(error));
            let number = self.showing;
            self.renew();
            if let Some(number) = number {
                self.done.push_back(Done::Shown(number, Err(failure)));
            }
        } else if self.files.as_ref().is_some_and(|f| f.0.number == from)
            && let Some((helper, filing)) = self.files.take()
        {
            self.done
                .push_back(filing.failed(Failure::new(helper.why(error))));
        }
    }

    /// Files turned out to be something.
    fn opened(&mut self, files: Vec<JsFile>, opened: Result<OpenedFiles, Failure>) {
        let first = files.first().map_or(String::new(), |f| f.name.clone());
        let opened = match opened {
            Ok(opened) => opened,
            Err(failure) => return self.done.push_back(Done::Opened(first, Err(failure))),
        };
        let project = files.iter().find(|f| is_project(&f.name));
        let project = project.map(|f| f.name.clone());
        let request = opened.request.as_deref();
        let request = request.and_then(|t| ProjectFile::read(t).ok());
        if let Some(missing) = opened.missing {
            self.waiting = request;
            return self.ask_for(&missing);
        }
        let input = match opened.input {
            Some((name, seen)) => {
                let input = Input::elsewhere(name, seen);
                self.held = Held {
                    input: input.id,
                    unit: None,
                    files,
                };
                input
            }
            None => Input::built_in(),
        };
        let name = match (&request, &input.path) {
            (Some(_), _) => project.unwrap_or(first),
            (None, path) => path.clone().unwrap_or(first),
        };
        // A request that waited for this file.
        let waited = self.waiting.take_if(|w| {
            w.request.input.is_some() && w.request.input.as_deref() == input.file_name()
        });
        let found = match request.or(waited) {
            Some(file) => {
                self.held.unit = file.request.unit.map(|u| u.to_string());
                Opened::Project(input, Box::new(file))
            }
            None => Opened::Input(input),
        };
        self.done.push_back(Done::Opened(name, Ok(found)));
    }

    fn ask_for(&mut self, name: &str) {
        self.fail(&format!(
            "This is about the file {name}, which is not part of it: open {name} (File, Open…, or drop it here), and it is broken in the \
             same way."
        ));
    }

    /// Begins with what the address says.
    fn follow_address(&mut self) {
        let address = browser::address();
        if address.is_empty() {
            return;
        }
        match read_link(&address) {
            Ok(file) => match file.input.clone() {
                Some(name) => {
                    self.waiting = Some(file.into());
                    self.ask_for(&name);
                }
                None => {
                    let opened = Opened::Project(Input::built_in(), Box::new(file.into()));
                    let name = "the address".to_owned();
                    self.done.push_back(Done::Opened(name, Ok(opened)));
                }
            },
            Err(problem) => self.fail(&problem),
        }
    }
}

/// Hands a file out.
fn hand_out(name: &str, content: &JsValue) -> Result<(), Failure> {
    browser::download(name, content).map_err(|e| Failure::new(format!("{name}: {e:?}")))
}

impl Filing {
    /// The end of work that failed.
    fn failed(self, failure: Failure) -> Done {
        match self {
            Filing::Open(files) => {
                let name = files.into_iter().next().map_or(String::new(), |f| f.name);
                Done::Opened(name, Err(failure))
            }
            Filing::Picture(name) => Done::Pictured(name, Err(failure)),
            Filing::Export(path) => Done::Exported(path, Err(failure)),
        }
    }
}

impl Platform for Web {
    fn show(&mut self, number: u64, job: Job) {
        self.wanted = Some((number, job));
        self.show_next();
    }

    fn open(&mut self, path: &str, _: Option<LengthUnit>) {
        self.fail(&format!("{path}: a browser opens files by its own dialog"));
    }

    fn export(&mut self, wanted: Export) {
        let ask = Ask::Export {
            request: wanted.file.to_toml(),
            path: wanted.path.clone(),
        };
        let mine = self.held.input == wanted.input.id;
        let files = if mine {
            self.held.files.clone()
        } else {
            Vec::new()
        };
        self.start(&ask, &files, Filing::Export(wanted.path));
    }

    fn cancel(&mut self, lane: Lane) {
        match lane {
            Lane::Show => {
                let stopped = [self.showing, self.wanted.take().map(|w| w.0)];
                if self.showing.is_some() {
                    self.renew();
                }
                for number in stopped.into_iter().flatten() {
                    self.done
                        .push_back(Done::Shown(number, Err(Failure::cancelled())));
                }
            }
            Lane::Files => {
                if let Some((_, filing)) = self.files.take() {
                    self.done.push_back(filing.failed(Failure::cancelled()));
                }
            }
            Lane::Simulation => {
                let done = self.simulating.cancel();
                self.done.extend(done);
            }
        }
        (self.wake)();
    }

    fn progress(&self, lane: Lane) -> Option<WorkProgress> {
        match lane {
            Lane::Show => self.show.at.clone(),
            Lane::Files => self.files.as_ref()?.0.at.clone(),
            Lane::Simulation => self.simulating.progress(),
        }
    }

    fn poll(&mut self) -> Option<Done> {
        while let Some(news) = self.news() {
            self.hear(news);
        }
        self.show_next();
        self.simulating.give_up();
        self.done.pop_front()
    }

    fn scenes(&self) -> Vec<SceneEntry> {
        scenes()
    }

    fn simulate(&mut self, job: SimulationJob) {
        (self.simulating).begin(job, &self.held, &self.inbox, &self.wake);
    }

    fn pause_simulation(&mut self, paused: bool) {
        self.simulating.pause(paused);
    }

    fn step_simulation(&mut self) {
        self.simulating.step();
    }

    fn steer_simulation(&mut self, by: [f64; 3]) {
        self.simulating.steer(by);
    }

    fn save_scene(&self, path: &str, job: &SimulationJob) -> Result<(), Failure> {
        let setting = JobScene::new(own_setting(&job.source)?, job)?.0.with_hand();
        hand_out(path, &JsValue::from_str(&write_toml(&setting)))
    }

    fn draw_frame(&mut self, number: usize, look: Look) {
        let done = self.simulating.draw(number, look);
        self.done.extend(done);
    }

    fn take_break(&mut self, at_hand: u64) {
        self.simulating.take(at_hand);
    }

    fn open_picture(&mut self, path: &str) {
        if self.picture.as_ref().is_some_and(|p| p.name == path) {
            return self.read_picture();
        }
        let failure = Failure::new(format!(
            "This is matched to the photograph {path}, which is not part of it: open it (File, Photograph…, or drop it here), and it lies as \
             it did."
        ));
        self.done
            .push_back(Done::Pictured(path.to_owned(), Err(failure)));
    }

    fn save(&self, path: &str, project: &ProjectFile) -> Result<(), Failure> {
        let Some(stem) = &project.stem else {
            return hand_out(path, &JsValue::from_str(&project.to_toml()));
        };
        // The stem of a simulation has no file yet.
        let beside = ProjectFile::stem_path(path);
        hand_out(&beside, &js_sys::Uint8Array::from(&stem[..]))?;
        let mut project = project.clone();
        project.request.input = Some(beside);
        hand_out(path, &JsValue::from_str(&project.to_toml()))
    }

    fn has_folders(&self) -> bool {
        false
    }

    fn choose(&mut self) {
        browser::choose(&self.inbox, &self.wake);
    }

    fn list(&self, _: &str) -> Result<(String, Vec<Entry>), Failure> {
        Ok((String::new(), Vec::new()))
    }

    fn join(&self, _: &str, name: &str) -> String {
        name.to_owned()
    }

    fn parent(&self, _: &str) -> Option<String> {
        None
    }

    fn recent(&self) -> Vec<String> {
        Vec::new()
    }

    fn note_recent(&mut self, _: &str) {}

    fn tell_card_lost(&mut self) {
        page::begin_again();
    }

    fn keep(&mut self, project: Option<&ProjectFile>) {
        if let Some(ProjectFile { request, .. }) = project {
            let mut request = request.clone();
            let input = request.input.take();
            browser::set_address(&link(&request, input.as_deref()));
        }
    }

    fn kept(&self) -> Option<String> {
        None
    }

    fn settings(&self) -> Settings {
        let mut settings = Settings::default();
        if let Some(word) = browser::stored("dark") {
            settings.dark = word == "true";
        }
        if let Some(number) = browser::stored("scale") {
            settings.scale = number.parse().unwrap_or(1.0f32).clamp(0.5, 4.0);
        }
        let unit = browser::stored("unit");
        if let Some(unit) = unit.and_then(|s| ShownUnit::from_symbol(&s)) {
            settings.unit = unit;
        }
        settings
    }

    fn keep_settings(&mut self, settings: &Settings) {
        browser::store("dark", &settings.dark.to_string());
        browser::store("scale", &settings.scale.to_string());
        browser::store("unit", settings.unit.symbol());
    }
}
