//! Work that goes on beside the window: how far it is, and stopping it.

use super::WorkProgress;
use greenstick::geometry::{CancelToken, Context, Progress};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// How long work may go on after another was asked for, before it is left behind: a few stages do not ask whether to stop.
const PATIENCE: Duration = Duration::from_secs(3);

/// Wakes the window.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// Work that is going on in a lane.
#[derive(Clone, Default)]
pub struct Working {
    /// When it was begun.
    since: Option<Instant>,
    /// Stops it.
    pub token: CancelToken,
    progress: Arc<Mutex<Option<WorkProgress>>>,
}

impl Working {
    /// Work that begins now.
    pub fn begun_now() -> Self {
        Working {
            since: Some(Instant::now()),
            ..Working::default()
        }
    }

    /// A context that tells the window how far the work is.
    pub fn context(&self, wake: &Wake) -> Context {
        let (progress, wake) = (self.progress.clone(), wake.clone());
        let tell = move |p: Progress| {
            if let Ok(mut at) = progress.lock() {
                *at = Some(WorkProgress {
                    stage: p.stage.name().into(),
                    overall: p.overall,
                });
            }
            wake();
        };
        Context::new(self.token.clone(), tell)
    }

    /// How far it is; none where nothing is at work.
    pub fn at(&self) -> Option<WorkProgress> {
        self.progress.lock().ok()?.clone()
    }

    /// Notes that it waits for its turn.
    pub fn begin(&self) {
        if let Ok(mut at) = self.progress.lock() {
            *at = Some(WorkProgress {
                stage: "wait".into(),
                overall: 0.0,
            });
        }
    }

    /// Whether it is still going on after longer than anybody waits for work that was asked to stop.
    pub fn is_stuck(&self) -> bool {
        self.at().is_some() && self.since.is_some_and(|s| s.elapsed() > PATIENCE)
    }

    /// Notes that it is over.
    pub fn end(&self) {
        if let Ok(mut at) = self.progress.lock() {
            *at = None;
        }
    }
}
