//! Work without the interpreter's lock: it runs on a thread of its own, while the calling thread looks for signals, shows
//! progress and takes messages. No other thread than the caller's ever runs Python.

use crate::failure::Failure;
use greenstick::ErrorKind;
use greenstick::geometry::{CancelToken, Context, Progress};
use pyo3::prelude::*;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

/// How often signals are looked for: often enough for Ctrl-C to feel immediate.
const INTERVAL: Duration = Duration::from_millis(30);
/// Stack of the thread that works, bytes: as much as a main thread has.
const STACK: usize = 8 << 20;

/// What the caller is told of progress with: `True` for a bar, or something to call.
pub struct Shown {
    call: Py<PyAny>,
    close: Option<Py<PyAny>>,
}

impl Shown {
    /// Reads the argument `progress`: `None` or `False` for nothing, `True` for a bar of tqdm where that is installed, or a
    /// function that is called with the stage (str) and the fraction of the whole (float, 0 to 1).
    pub fn new(argument: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Self>> {
        let Some(argument) = argument.filter(|a| !a.is_none()) else {
            return Ok(None);
        };
        match argument.extract::<bool>() {
            Ok(false) => Ok(None),
            Ok(true) => {
                let bar = argument
                    .py()
                    .import("greenstick._progress")?
                    .call_method0("bar")?;
                if bar.is_none() {
                    return Ok(None);
                }
                Ok(Some(Shown {
                    call: bar.getattr("show")?.unbind(),
                    close: Some(bar.getattr("close")?.unbind()),
                }))
            }
            Err(_) if argument.is_callable() => Ok(Some(Shown {
                call: argument.clone().unbind(),
                close: None,
            })),
            Err(_) => Err(Failure::value(
                "progress is neither a bool nor callable; expected True, False or a function of (stage, fraction)",
            )
            .into()),
        }
    }

    /// Tells how much of the whole is done, 0 to 1.
    pub fn show(&self, py: Python<'_>, stage: &str, fraction: f64) -> PyResult<()> {
        self.call.call1(py, (stage, fraction)).map(drop)
    }

    /// Leaves a bar as it is.
    pub fn close(&self, py: Python<'_>) -> PyResult<()> {
        match &self.close {
            Some(close) => close.call0(py).map(drop),
            None => Ok(()),
        }
    }
}

/// Runs `work` without the interpreter's lock. Ctrl-C, and whatever `progress` raises, cancel it; the exception is then that
/// of the signal or of `progress`.
pub fn run<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Context) -> Result<T, Failure> + Send,
) -> PyResult<T> {
    run_with_messages(
        py,
        progress,
        |context, _: &SyncSender<()>| work(context),
        |_, ()| Ok(()),
    )
}

/// The same for work that sends messages, which `receive` is called with on the thread of the caller. The work waits while one
/// is received.
pub fn run_with_messages<T: Send, M: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Context, &SyncSender<M>) -> Result<T, Failure> + Send,
    mut receive: impl FnMut(Python<'_>, M) -> PyResult<()> + Send,
) -> PyResult<T> {
    let shown = Shown::new(progress)?;
    let token = CancelToken::default();
    let latest: Arc<Mutex<Option<Progress>>> = Arc::default();
    let told = latest.clone();
    let context = Context::new(token.clone(), move |progress| {
        *told.lock().unwrap_or_else(|e| e.into_inner()) = Some(progress);
    });
    let outcome = py.detach(|| {
        let (sender, receiver) = sync_channel::<M>(0);
        let mut watch = Watch {
            token,
            latest,
            shown: shown.as_ref(),
            stopped: None,
        };
        thread::scope(|scope| {
            let worker = thread::Builder::new()
                .name("greenstick".to_owned())
                .stack_size(STACK)
                .spawn_scoped(scope, move || work(&context, &sender));
            let worker = worker.map_err(|e| {
                Failure::new(
                    "WorkError",
                    ErrorKind::Work,
                    format!("no thread can be started: {e}"),
                )
            })?;
            watch.until_done(&receiver, &mut receive);
            let done = worker
                .join()
                .map_err(|panic| Failure::new("WorkError", ErrorKind::Work, panic_text(&panic)));
            match watch.stopped {
                Some(error) => Err(error),
                None => Ok(done??),
            }
        })
    });
    if let Some(shown) = shown {
        shown.close(py)?;
    }
    outcome
}

/// What the calling thread does meanwhile.
struct Watch<'a> {
    token: CancelToken,
    latest: Arc<Mutex<Option<Progress>>>,
    shown: Option<&'a Shown>,
    /// Why the work was cancelled.
    stopped: Option<PyErr>,
}

impl Watch<'_> {
    /// Receives messages and looks for signals until the sender is gone.
    fn until_done<M>(
        &mut self,
        receiver: &Receiver<M>,
        receive: &mut impl FnMut(Python<'_>, M) -> PyResult<()>,
    ) {
        loop {
            let message = match receiver.recv_timeout(INTERVAL) {
                Ok(message) => Some(message),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => return,
            };
            // What comes after the work was cancelled is of no use.
            if self.stopped.is_some() {
                continue;
            }
            let looked = Python::attach(|py| {
                py.check_signals()?;
                self.show(py)?;
                message.map_or(Ok(()), |message| receive(py, message))
            });
            if let Err(error) = looked {
                self.token.cancel();
                self.stopped = Some(error);
            }
        }
    }

    fn show(&self, py: Python<'_>) -> PyResult<()> {
        let Some(shown) = self.shown else {
            return Ok(());
        };
        let latest = self.latest.lock().unwrap_or_else(|e| e.into_inner()).take();
        if let Some(progress) = latest {
            shown.show(py, progress.stage.name(), progress.overall)?;
        }
        Ok(())
    }
}

/// What a panic said.
fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic
        .downcast_ref::<&str>()
        .map(|s| (*s).to_owned())
        .or_else(|| panic.downcast_ref::<String>().cloned());
    format!(
        "a fault of the library, please report it: {}",
        text.unwrap_or_default()
    )
}
