//! Progress and cancellation, passed into every stage of the work: library crates hold no global state.
//!
//! A [`Context`] covers a span of the whole work. Whoever composes stages divides that span among them by weight
//! ([`Context::split`]) and names them; a stage itself only says how far it is ([`Context::report`]) and asks whether it
//! is to stop ([`Context::check`]).

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// The work was cancelled by its caller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// A request to stop, shared by whoever may ask for it and whoever must obey. Clones are the same token.
///
/// ```
/// use greenstick_geometry::CancelToken;
///
/// let token = CancelToken::default();
/// let at_work = token.clone();
/// token.cancel();
/// assert!(at_work.check().is_err());
/// ```
#[derive(Debug, Clone, Default)]
pub struct CancelToken(Arc<AtomicBool>);

impl CancelToken {
    /// Asks all work under this token to stop.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the work is to stop.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// The same as a result, for `?`.
    ///
    /// # Errors
    /// [`Cancelled`] where the work is to stop.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() {
            Err(Cancelled)
        } else {
            Ok(())
        }
    }
}

/// The name of a stage of the work, as progress bars show it and reports list it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Stage(&'static str);

impl Stage {
    /// A stage of this name, such as `"stem"`.
    pub const fn new(name: &'static str) -> Self {
        Stage(name)
    }

    /// Its name.
    pub const fn name(self) -> &'static str {
        self.0
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

/// How far the work is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// The stage that reports.
    pub stage: Stage,
    /// How much of that stage is done, 0 to 1.
    pub of_stage: f64,
    /// How much of the whole work is done, 0 to 1; never less than was reported before.
    pub overall: f64,
}

/// What a stage gets from its caller: whom to tell how far it is, and whether to stop.
///
/// ```
/// use greenstick_geometry::{CancelToken, Context, Stage};
/// use std::sync::{Arc, Mutex};
///
/// let seen = Arc::new(Mutex::new(Vec::new()));
/// let told = seen.clone();
/// let context = Context::new(CancelToken::default(), move |p| told.lock().unwrap().push(p.overall));
/// let [stem, cut] = context.split([(Stage::new("stem"), 1.0), (Stage::new("cut"), 3.0)]);
/// stem.report(0.5)?; // an eighth of the whole
/// cut.report(1.0)?;
/// assert_eq!(*seen.lock().unwrap(), [0.125, 1.0]);
/// # Ok::<(), greenstick_geometry::Cancelled>(())
/// ```
#[derive(Clone)]
pub struct Context {
    cancel: CancelToken,
    sink: Option<Arc<dyn Fn(Progress) + Send + Sync>>,
    stage: Stage,
    /// The part of the whole work that this context covers: where it starts and how wide it is.
    start: f64,
    width: f64,
    /// The same of the stage that it belongs to.
    stage_start: f64,
    stage_width: f64,
    /// The most that was reported of the whole, as bits of a non-negative `f64`, which order as the numbers do.
    furthest: Arc<AtomicU64>,
}

impl fmt::Debug for Context {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Context")
            .field("stage", &self.stage)
            .field("start", &self.start)
            .field("width", &self.width)
            .finish_non_exhaustive()
    }
}

impl Default for Context {
    fn default() -> Self {
        Context::quiet()
    }
}

impl Context {
    /// A context for the whole of some work, which `sink` is told the progress of. The sink may be called by several
    /// threads at once.
    pub fn new(cancel: CancelToken, sink: impl Fn(Progress) + Send + Sync + 'static) -> Self {
        Context {
            sink: Some(Arc::new(sink)),
            ..Context::silent(cancel)
        }
    }

    /// A context that tells nobody, but can be cancelled.
    pub fn silent(cancel: CancelToken) -> Self {
        Context {
            cancel,
            sink: None,
            stage: Stage::new("work"),
            start: 0.0,
            width: 1.0,
            stage_start: 0.0,
            stage_width: 1.0,
            furthest: Arc::default(),
        }
    }

    /// A context that never cancels and tells nobody.
    pub fn quiet() -> Self {
        Context::silent(CancelToken::default())
    }

    /// This context's token.
    pub fn cancel_token(&self) -> &CancelToken {
        &self.cancel
    }

    /// A context of the same token that tells nobody.
    pub fn silenced(&self) -> Self {
        Context::silent(self.cancel.clone())
    }

    /// Divides the span of this context among stages that follow each other, by their weights (about the seconds they
    /// take, in any unit; no less than 0).
    pub fn split<const N: usize>(&self, stages: [(Stage, f64); N]) -> [Context; N] {
        let total: f64 = stages.iter().map(|(_, weight)| weight).sum();
        let mut before = 0.0;
        stages.map(|(stage, weight)| {
            let share = |weight: f64| if total > 0.0 { weight / total } else { 0.0 };
            let (start, width) = (
                self.start + self.width * share(before),
                self.width * share(weight),
            );
            let part = Context {
                stage,
                start,
                width,
                stage_start: start,
                stage_width: width,
                ..self.clone()
            };
            before += weight;
            part
        })
    }

    /// The part from `from` to `to` (0 to 1) of this context's span, for one step of a stage that has several.
    pub fn part(&self, from: f64, to: f64) -> Context {
        Context {
            start: self.start + self.width * from,
            width: self.width * (to - from),
            ..self.clone()
        }
    }

    /// Item `index` of `count` equal steps.
    pub fn item(&self, index: usize, count: usize) -> Context {
        let share = |n: usize| n as f64 / count.max(1) as f64;
        self.part(share(index), share(index + 1))
    }

    /// Reports `fraction` (0 to 1) of this context's span done.
    ///
    /// # Errors
    /// [`Cancelled`] where the caller asked to stop.
    pub fn report(&self, fraction: f64) -> Result<(), Cancelled> {
        self.check()?;
        if let Some(sink) = &self.sink {
            let fraction = fraction.clamp(0.0, 1.0);
            let reached = (self.start + self.width * fraction).clamp(0.0, 1.0);
            let of_stage = if self.stage_width > 0.0 {
                ((reached - self.stage_start) / self.stage_width).clamp(0.0, 1.0)
            } else {
                fraction
            };
            let before = self
                .furthest
                .fetch_max(reached.to_bits(), Ordering::Relaxed);
            sink(Progress {
                stage: self.stage,
                of_stage,
                overall: f64::from_bits(before).max(reached),
            });
        }
        Ok(())
    }

    /// Asks whether to stop, without reporting: for inner loops.
    ///
    /// # Errors
    /// [`Cancelled`] where the caller asked to stop.
    pub fn check(&self) -> Result<(), Cancelled> {
        self.cancel.check()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn progress_never_runs_backwards_and_ends_at_one() {
        let seen = Arc::new(Mutex::new(Vec::new()));
        let told = seen.clone();
        let context = Context::new(CancelToken::default(), move |p| {
            told.lock().unwrap().push((p.stage.name(), p.overall));
        });
        let [a, b, c] = context.split([
            (Stage::new("a"), 1.0),
            (Stage::new("b"), 0.0),
            (Stage::new("c"), 1.0),
        ]);
        a.report(1.0).unwrap();
        b.report(0.5).unwrap();
        c.item(1, 2).report(0.0).unwrap();
        // A straggler, and a fraction that is none.
        a.report(0.2).unwrap();
        c.report(7.0).unwrap();
        let expected = [("a", 0.5), ("b", 0.5), ("c", 0.75), ("a", 0.75), ("c", 1.0)];
        assert_eq!(*seen.lock().unwrap(), expected);
    }

    #[test]
    fn a_token_stops_every_part() {
        let token = CancelToken::default();
        let context = Context::silent(token.clone());
        let part = context.part(0.0, 0.5).silenced();
        assert!(part.report(0.0).is_ok());
        token.cancel();
        assert_eq!(part.report(0.1), Err(Cancelled));
        assert_eq!(context.check(), Err(Cancelled));
    }
}
