//! A gate between two frames of a run: closed, it holds the run's thread, and lets single frames pass.

use greenstick::geometry::CancelToken;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// How often a thread that is held looks whether it is to stop.
const LOOK: Duration = Duration::from_millis(30);

#[derive(Debug, Default)]
struct State {
    is_closed: bool,
    /// Frames that may pass while it is closed.
    steps: usize,
}

/// Holds a run between two frames.
#[derive(Debug, Default)]
pub struct Gate {
    state: Mutex<State>,
    changed: Condvar,
}

impl Gate {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Closes or opens it.
    pub fn pause(&self, paused: bool) {
        *self.state() = State {
            is_closed: paused,
            steps: 0,
        };
        self.changed.notify_all();
    }

    /// Lets one more frame pass.
    pub fn step(&self) {
        self.state().steps += 1;
        self.changed.notify_all();
    }

    /// Waits until the way is free, or the work is to stop.
    pub fn pass(&self, token: &CancelToken) {
        let mut state = self.state();
        while state.is_closed && state.steps == 0 && !token.is_cancelled() {
            let waited = self.changed.wait_timeout(state, LOOK);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        state.steps = state.steps.saturating_sub(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn a_closed_gate_lets_single_frames_pass_and_holds_no_work_that_is_to_stop() {
        let (gate, token, passed) = (Gate::default(), CancelToken::default(), AtomicUsize::new(0));
        gate.pass(&token);
        gate.pause(true);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                for _ in 0..5 {
                    gate.pass(&token);
                    passed.fetch_add(1, Ordering::SeqCst);
                }
            });
            let settled = || {
                std::thread::sleep(4 * LOOK);
                passed.load(Ordering::SeqCst)
            };
            assert_eq!(settled(), 0);
            gate.step();
            assert_eq!(settled(), 1);
            gate.step();
            gate.step();
            assert_eq!(settled(), 3);
            token.cancel();
            assert_eq!(settled(), 5);
        });
    }
}
