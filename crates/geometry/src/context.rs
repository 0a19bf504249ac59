//! Progress and cancellation, passed into every stage: library crates hold no global state.

use std::sync::atomic::{AtomicBool, Ordering};

/// The work was cancelled by its caller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// What a stage may ask of its caller: whether to stop, whom to tell how far it is, and how many threads it may use.
pub struct Context<'a> {
    /// Set by the caller to stop the work.
    pub cancel: &'a AtomicBool,
    /// Called with the stage's name and the fraction done, 0 to 1.
    pub progress: &'a (dyn Fn(&str, f64) + Sync),
}

static NEVER: AtomicBool = AtomicBool::new(false);

impl Context<'static> {
    /// A context that never cancels and tells nobody.
    pub fn quiet() -> Self {
        Context {
            cancel: &NEVER,
            progress: &|_, _| {},
        }
    }
}

impl Context<'_> {
    /// Reports `fraction` (0 to 1) of `stage` done.
    ///
    /// # Errors
    /// [`Cancelled`] where the caller asked to stop.
    pub fn step(&self, stage: &str, fraction: f64) -> Result<(), Cancelled> {
        if self.cancel.load(Ordering::Relaxed) {
            return Err(Cancelled);
        }
        (self.progress)(stage, fraction);
        Ok(())
    }
}
