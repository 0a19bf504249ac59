//! Progress: stages with their seconds, a bar on stderr for work of more than a second, and Ctrl-C.

use greenstick::geometry::{CancelToken, Context, Progress as Report, Stage};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use std::io::IsTerminal;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Time after which the bar appears.
const BAR_DELAY: Duration = Duration::from_secs(1);
/// Fraction of the work below which the remaining time is not estimated.
const MIN_DONE_FOR_ESTIMATE: f64 = 0.05;
/// Steps of the bar.
const BAR_STEPS: u64 = 1000;

/// A stage of the work and the time it took.
#[derive(Debug, Clone, Serialize)]
pub struct StageTime {
    pub name: &'static str,
    pub seconds: f64,
}

struct State {
    stages: Vec<StageTime>,
    /// When the last stage began.
    since: Instant,
    bar: Option<ProgressBar>,
}

/// Watches the stages of one run.
pub struct Progress {
    root: Context,
    state: Arc<Mutex<State>>,
}

impl Progress {
    /// Starts the clock, and takes over Ctrl-C: the first stops the work, the second ends the program at once.
    pub fn start(quiet: bool) -> Self {
        let token = CancelToken::default();
        let stop = token.clone();
        // Where no handler can be set, Ctrl-C ends the program as ever; output is renamed into place anyway.
        let _ = ctrlc::set_handler(move || {
            if stop.is_cancelled() {
                std::process::exit(130);
            }
            stop.cancel();
        });
        let start = Instant::now();
        let shown = !quiet && std::io::stderr().is_terminal();
        let state = Arc::new(Mutex::new(State {
            stages: Vec::new(),
            since: start,
            bar: None,
        }));
        let reported = state.clone();
        let root = Context::new(token, move |report| {
            let mut state = reported.lock().unwrap_or_else(|e| e.into_inner());
            state.update(report, shown.then_some(start));
        });
        Progress { root, state }
    }

    /// Divides the whole of the work among stages, by the seconds that they usually take.
    pub fn split<const N: usize>(&self, stages: [(&'static str, f64); N]) -> [Context; N] {
        split(&self.root, stages)
    }

    /// The part of the whole work that is one of `count` alike.
    pub fn item(&self, index: usize, count: usize) -> Context {
        self.root.item(index, count)
    }

    fn clear(&self) {
        let mut state = self.state.lock().unwrap_or_else(|e| e.into_inner());
        if let Some(bar) = state.bar.take() {
            bar.finish_and_clear();
        }
    }

    /// Takes the bar away. Returns the stages since the start or the last call, those of one name together, in the order in
    /// which they began.
    pub fn finish(&self) -> Vec<StageTime> {
        self.clear();
        let mut state = self.state.lock().unwrap_or_else(|e| e.into_inner());
        state.end_stage(Instant::now());
        let mut stages: Vec<StageTime> = Vec::new();
        for stage in std::mem::take(&mut state.stages) {
            match stages.iter_mut().find(|s| s.name == stage.name) {
                Some(same) => same.seconds += stage.seconds,
                None => stages.push(stage),
            }
        }
        stages
    }
}

/// Divides a part of the work among stages, by the seconds that they usually take.
pub fn split<const N: usize>(context: &Context, stages: [(&'static str, f64); N]) -> [Context; N] {
    context.split(stages.map(|(name, weight)| (Stage::new(name), weight)))
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.clear();
    }
}

impl State {
    /// Records a report, and shows it on the bar if there is one: for work that began at `shown_since` and takes long.
    fn update(&mut self, report: Report, shown_since: Option<Instant>) {
        let now = Instant::now();
        let name = report.stage.name();
        if self.stages.last().is_none_or(|s| s.name != name) {
            self.end_stage(now);
            self.stages.push(StageTime { name, seconds: 0.0 });
        }
        let Some(start) = shown_since.filter(|start| now - *start >= BAR_DELAY) else {
            return;
        };
        let bar = self.bar.get_or_insert_with(new_bar);
        bar.set_position((report.overall * BAR_STEPS as f64) as u64);
        bar.set_prefix(name);
        bar.set_message(if report.overall > MIN_DONE_FOR_ESTIMATE {
            let spent = (now - start).as_secs_f64();
            format!(
                "{} left",
                duration(spent * (1.0 - report.overall) / report.overall)
            )
        } else {
            String::new()
        });
        bar.tick();
    }

    fn end_stage(&mut self, now: Instant) {
        if let Some(last) = self.stages.last_mut() {
            last.seconds = (now - self.since).as_secs_f64();
        }
        self.since = now;
    }
}

fn new_bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(BAR_STEPS), ProgressDrawTarget::stderr());
    if let Ok(style) =
        ProgressStyle::with_template("{spinner} {prefix:10} {bar:30} {percent:>3} % {msg}")
    {
        bar.set_style(style);
    }
    bar
}

/// Formats a remaining time as an estimate.
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
        let [read, broken, textures] =
            progress.split([("read", 1.0), ("break", 1.0), ("textures", 1.0)]);
        for stage in [&read, &broken, &broken, &textures, &broken] {
            stage.report(0.5).unwrap();
        }
        std::thread::sleep(Duration::from_millis(20));
        let stages = progress.finish();
        let names: Vec<&str> = stages.iter().map(|s| s.name).collect();
        assert_eq!(names, ["read", "break", "textures"]);
        assert!(stages[1].seconds >= 0.02);
        assert_eq!(duration(200.0), "about 3 min");
    }
}
