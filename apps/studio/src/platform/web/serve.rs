//! The worker's side of the page.

use crate::model::desk::Desk;
use crate::model::held::HeldFile;
use crate::model::messages::{Answer, Ask, from_bytes, to_bytes};
use eframe::wasm_bindgen::JsCast;
use eframe::wasm_bindgen::closure::Closure;
use greenstick::geometry::{CancelToken, Context, Progress};
use js_sys::{Array, Uint8Array};
use std::sync::Mutex;
use std::time::Duration;
use web_sys::{DedicatedWorkerGlobalScope, MessageEvent};
use web_time::Instant;

/// Time between two messages of progress.
const OFTEN: Duration = Duration::from_millis(50);

/// Answers what the page asks, until the page ends this worker.
pub fn serve(scope: &DedicatedWorkerGlobalScope) {
    std::panic::set_hook(Box::new(|fault| {
        post(&Answer::Fault(fault.to_string()), &[]);
    }));
    let mut desk = Desk::default();
    let context = context();
    let heard = Closure::<dyn FnMut(MessageEvent)>::new(move |event: MessageEvent| {
        let message = Array::from(&event.data());
        let bytes = Uint8Array::from(message.get(0)).to_vec();
        match from_bytes::<Ask>(&bytes) {
            Ok(ask) => {
                let (answer, files) = desk.answer(
                    ask,
                    files_of(&message),
                    &mut |early| post(&early, &[]),
                    &context,
                );
                if let Some(answer) = answer {
                    post(&answer, &files);
                }
            }
            Err(error) => post(&Answer::Fault(error), &[]),
        }
    });
    scope.set_onmessage(Some(heard.as_ref().unchecked_ref()));
    // The page ends the worker; until then it listens.
    heard.forget();
    post(&Answer::Ready, &[]);
}

/// A context that tells the page how far the work is. Nothing can be cancelled in it: the page ends the worker instead.
fn context() -> Context {
    let last: Mutex<Option<Instant>> = Mutex::new(None);
    let tell = move |p: Progress| {
        let Ok(mut last) = last.lock() else { return };
        if last.is_none_or(|l| l.elapsed() > OFTEN) {
            *last = Some(Instant::now());
            let (stage, overall) = (p.stage.name().to_owned(), p.overall);
            post(&Answer::Progress { stage, overall }, &[]);
        }
    };
    Context::new(CancelToken::default(), tell)
}

/// The files that come with a message, as names and bytes in turns.
fn files_of(message: &Array) -> Vec<HeldFile> {
    let pairs = (1..message.length()).step_by(2);
    let file = |i| HeldFile {
        name: message.get(i).as_string().unwrap_or_default(),
        bytes: Uint8Array::from(message.get(i + 1)).to_vec(),
    };
    pairs.map(file).collect()
}

fn post(answer: &Answer, files: &[HeldFile]) {
    let Ok(bytes) = to_bytes(answer) else { return };
    let message = Array::of1(&Uint8Array::from(&bytes[..]));
    for file in files {
        message.push(&Uint8Array::from(&file.bytes[..]));
    }
    let transferred: Array = message
        .iter()
        .map(|a| a.unchecked_into::<Uint8Array>().buffer())
        .collect();
    let scope: DedicatedWorkerGlobalScope = js_sys::global().unchecked_into();
    let _ = scope.post_message_with_transfer(&message, &transferred);
}
