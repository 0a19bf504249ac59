//! A worker of the page, as the page sees it.

use super::news::{Inbox, JsFile, News, Wake};
use crate::model::messages::{Ask, SimulationAsk, to_bytes};
use crate::platform::WorkProgress;
use eframe::wasm_bindgen::closure::Closure;
use eframe::wasm_bindgen::{JsCast, JsValue};
use js_sys::{Array, Uint8Array};
use std::cell::Cell;
use std::time::Duration;
use web_sys::{ErrorEvent, MessageEvent, Worker, WorkerOptions, WorkerType};
use web_time::Instant;

/// The file that begins a worker.
const SCRIPT: &str = "./worker.js";

/// How long the work on a picture, or on a frame of a simulation, goes on after another was asked for. Then its worker is ended: a new
/// one begins by finding the stem again, which an answer that is nearly there does not.
pub const PATIENCE: Duration = Duration::from_millis(1500);

/// The files of an input.
#[derive(Default)]
pub struct Held {
    /// Its number.
    pub input: u64,
    /// The unit of length in them.
    pub unit: Option<String>,
    /// The files.
    pub files: Vec<JsFile>,
}

thread_local! {
    static NEXT: Cell<u64> = const { Cell::new(1) };
}

/// A worker; it ends when this is dropped.
pub struct Helper {
    /// Tells helpers apart.
    pub number: u64,
    /// The input that it holds.
    pub holds: u64,
    /// How far its work is; none where it rests.
    pub at: Option<WorkProgress>,
    /// What it said of a fault before it ended.
    pub fault: Option<String>,
    since: Option<Instant>,
    /// What it is to be asked when it is ready; none once it is.
    queue: Option<Vec<Array>>,
    worker: Option<Worker>,
    _heard: Closure<dyn FnMut(MessageEvent)>,
    _ended: Closure<dyn FnMut(ErrorEvent)>,
}

impl Helper {
    /// Starts a worker, which tells `inbox` and wakes the page.
    pub fn new(inbox: &Inbox, wake: &Wake) -> Self {
        let number = NEXT.with(|n| n.replace(n.get() + 1));
        let heard = {
            let (inbox, wake) = (inbox.clone(), wake.clone());
            Closure::new(move |event: MessageEvent| {
                let message = Array::from(&event.data());
                inbox.borrow_mut().push_back(News::Said(number, message));
                wake();
            })
        };
        let ended = {
            let (inbox, wake) = (inbox.clone(), wake.clone());
            Closure::new(move |event: ErrorEvent| {
                let news = News::Ended(number, event.message());
                inbox.borrow_mut().push_back(news);
                wake();
            })
        };
        let options = WorkerOptions::new();
        options.set_type(WorkerType::Module);
        let worker = Worker::new_with_options(SCRIPT, &options).ok();
        if let Some(worker) = &worker {
            worker.set_onmessage(Some(heard.as_ref().unchecked_ref()));
            worker.set_onerror(Some(ended.as_ref().unchecked_ref()));
            // It gets the program as the page has compiled it.
            let _ = worker.post_message(&eframe::wasm_bindgen::module());
        } else {
            let news = News::Ended(number, "the browser starts no workers".to_owned());
            inbox.borrow_mut().push_back(news);
        }
        Helper {
            number,
            holds: 0,
            at: None,
            fault: None,
            since: None,
            queue: Some(Vec::new()),
            worker,
            _heard: heard,
            _ended: ended,
        }
    }

    /// Asks it something, with files.
    pub fn ask(&mut self, ask: &Ask, files: &[JsFile]) {
        let Ok(bytes) = to_bytes(ask) else { return };
        let message = Array::of1(&Uint8Array::from(&bytes[..]));
        for file in files {
            message.push(&JsValue::from_str(&file.name));
            message.push(&file.bytes);
        }
        if is_work(ask) {
            self.since = Some(Instant::now());
            if self.at.is_none() {
                self.progress("wait".to_owned(), 0.0);
            }
        }
        match &mut self.queue {
            Some(queue) => queue.push(message),
            None => self.post(&message),
        }
    }

    fn post(&self, message: &Array) {
        if let Some(worker) = &self.worker {
            let _ = worker.post_message(message);
        }
    }

    /// It can be asked now.
    pub fn is_ready(&mut self) {
        for message in self.queue.take().unwrap_or_default() {
            self.post(&message);
        }
    }

    /// It is so far.
    pub fn progress(&mut self, stage: String, overall: f64) {
        self.at = Some(WorkProgress {
            stage: stage.into(),
            overall,
        });
    }

    /// It has answered.
    pub fn rests(&mut self) {
        self.at = None;
        self.since = None;
    }

    /// Whether it has been at the same work for so long.
    pub fn works_longer_than(&self, patience: Duration) -> bool {
        self.since.is_some_and(|s| s.elapsed() > patience)
    }

    /// Why it ended, and what helps.
    pub fn why(&self, error: &str) -> String {
        match &self.fault {
            Some(fault) => format!("the program has a fault, please tell about it: {fault}"),
            None => format!(
                "the work came to an end: {error}. A browser gives a page about 2 GB of memory at most; take a mesh of fewer triangles, \
                 fewer rings and sectors, or smaller textures, or the program `greenstick`"
            ),
        }
    }
}

/// Whether what is asked for is shown as work.
fn is_work(ask: &Ask) -> bool {
    use SimulationAsk::{Draw, Steer};
    !matches!(ask, Ask::Hold { .. } | Ask::Simulation(Draw(..) | Steer(_)))
}

impl Drop for Helper {
    fn drop(&mut self) {
        if let Some(worker) = &self.worker {
            worker.terminate();
        }
    }
}
