//! What the program tells while it works: stages with their seconds, a bar on stderr for work of more than a second, and
//! Ctrl-C.

use crate::failure::Failure;
use greenstick::geometry::{Cancelled, Context};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use std::io::IsTerminal;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Set by the first Ctrl-C.
static STOP: AtomicBool = AtomicBool::new(false);

/// Work that is over sooner needs no bar.
const SILENT: Duration = Duration::from_secs(1);
/// Before so much of a stage is done, the time left would be a guess.
const TELLING: f64 = 0.05;
/// Steps of the bar.
const STEPS: u64 = 1000;

/// A stage of the work and the time it took.
#[derive(Debug, Clone, Serialize)]
pub struct Stage {
    pub name: String,
    pub seconds: f64,
}

struct State {
    stages: Vec<Stage>,
    /// When the last stage began.
    since: Instant,
    bar: Option<ProgressBar>,
}

/// Watches the stages of one run.
pub struct Progress {
    start: Instant,
    shown: bool,
    state: Mutex<State>,
}

impl Progress {
    /// Starts the clock, and takes over Ctrl-C: the first stops the work, the second ends the program at once.
    pub fn start(quiet: bool) -> Self {
        // Where no handler can be set, Ctrl-C ends the program as ever; output is renamed into place anyway.
        let _ = ctrlc::set_handler(|| {
            if STOP.swap(true, Ordering::Relaxed) {
                std::process::exit(130);
            }
        });
        let now = Instant::now();
        Progress {
            start: now,
            shown: !quiet && std::io::stderr().is_terminal(),
            state: Mutex::new(State {
                stages: Vec::new(),
                since: now,
                bar: None,
            }),
        }
    }

    /// Does a piece of work of the libraries under this watch.
    pub fn watch<T>(&self, work: impl FnOnce(&Context) -> T) -> T {
        work(&Context {
            cancel: &STOP,
            progress: &|stage, fraction| self.tell(stage, fraction),
        })
    }

    /// Does a piece of work of which no progress is told, only that it can be stopped.
    pub fn silently<T>(&self, work: impl FnOnce(&Context) -> T) -> T {
        work(&Context {
            cancel: &STOP,
            progress: &|_, _| (),
        })
    }

    /// Tells how far a stage of the program's own is, 0 to 1.
    ///
    /// # Errors
    /// Where the user asked to stop.
    pub fn part(&self, name: &str, fraction: f64) -> Result<(), Failure> {
        self.tell(name, fraction);
        if STOP.load(Ordering::Relaxed) {
            self.clear();
            return Err(Cancelled.into());
        }
        Ok(())
    }

    /// Begins a stage of the program's own.
    ///
    /// # Errors
    /// Where the user asked to stop.
    pub fn stage(&self, name: &str) -> Result<(), Failure> {
        self.part(name, 0.0)
    }

    fn tell(&self, stage: &str, fraction: f64) {
        let mut state = self.state.lock().unwrap_or_else(|e| e.into_inner());
        let now = Instant::now();
        if state.stages.last().is_none_or(|s| s.name != stage) {
            state.end_stage(now);
            state.stages.push(Stage {
                name: stage.to_owned(),
                seconds: 0.0,
            });
        }
        if !self.shown || now - self.start < SILENT {
            return;
        }
        let since = state.since;
        let bar = state.bar.get_or_insert_with(new_bar);
        bar.set_position((fraction.clamp(0.0, 1.0) * STEPS as f64) as u64);
        bar.set_prefix(stage.to_owned());
        bar.set_message(if fraction > TELLING {
            let spent = (now - since).as_secs_f64();
            format!("{} left", duration(spent * (1.0 - fraction) / fraction))
        } else {
            String::new()
        });
        bar.tick();
    }

    fn clear(&self) {
        let state = self.state.lock().unwrap_or_else(|e| e.into_inner());
        if let Some(bar) = &state.bar {
            bar.finish_and_clear();
        }
    }

    /// Takes the bar away; all stages, those of one name together, in the order in which they began.
    pub fn finish(&self) -> Vec<Stage> {
        self.clear();
        let mut state = self.state.lock().unwrap_or_else(|e| e.into_inner());
        state.end_stage(Instant::now());
        let mut stages: Vec<Stage> = Vec::new();
        for stage in &state.stages {
            match stages.iter_mut().find(|s| s.name == stage.name) {
                Some(same) => same.seconds += stage.seconds,
                None => stages.push(stage.clone()),
            }
        }
        stages
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.clear();
    }
}

impl State {
    fn end_stage(&mut self, now: Instant) {
        if let Some(last) = self.stages.last_mut() {
            last.seconds = (now - self.since).as_secs_f64();
        }
        self.since = now;
    }
}

fn new_bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
    if let Ok(style) =
        ProgressStyle::with_template("{spinner} {prefix:10} {bar:30} {percent:>3} % {msg}")
    {
        bar.set_style(style);
    }
    bar
}

/// A time that is left, no more exact than a guess can be.
fn duration(seconds: f64) -> String {
    if seconds < 90.0 {
        format!("about {:.0} s", seconds.max(1.0))
    } else {
        format!("about {:.0} min", seconds / 60.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_of_one_name_are_one_stage() {
        let progress = Progress::start(true);
        let stages = ["read", "break", "break", "textures", "break"];
        for name in stages {
            progress.tell(name, 0.5);
        }
        std::thread::sleep(Duration::from_millis(20));
        let stages = progress.finish();
        let names: Vec<&str> = stages.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["read", "break", "textures"]);
        assert!(stages[1].seconds >= 0.02);
        assert_eq!(duration(200.0), "about 3 min");
    }
}
