//! What the page asks of the browser: its canvas, files, downloads, the address and a place for settings.

use super::news::{Inbox, JsFile, News, Wake};
use eframe::wasm_bindgen::closure::Closure;
use eframe::wasm_bindgen::{JsCast, JsValue};
use js_sys::{Array, Uint8Array};
use wasm_bindgen_futures::{JsFuture, spawn_local};
use web_sys::{Blob, Document, DragEvent, Event, FileList, HtmlAnchorElement, HtmlCanvasElement};
use web_sys::{HtmlInputElement, Storage, Url, Window};

fn window() -> Option<Window> {
    web_sys::window()
}

fn document() -> Option<Document> {
    window()?.document()
}

/// Where the studio is drawn.
pub fn canvas() -> Option<HtmlCanvasElement> {
    document()?.get_element_by_id("studio")?.dyn_into().ok()
}

/// Puts a new canvas in the place of the one where the studio is drawn: a canvas keeps the context that it had first.
pub fn renew_canvas() {
    if let Some(old) = canvas()
        && let Ok(new) = old.clone_node()
    {
        let _ = old.replace_with_with_node_1(&new);
    }
}

/// Calls `lost` when the WebGL context of a canvas is lost, which what draws by it is not told of.
pub fn on_lost(canvas: &HtmlCanvasElement, lost: fn()) {
    let own = canvas.clone();
    let told = Closure::<dyn FnMut(Event)>::new(move |_| {
        if self::canvas().as_ref() == Some(&own) {
            lost();
        }
    });
    let function = told.as_ref().unchecked_ref();
    let _ = canvas.add_event_listener_with_callback("webglcontextlost", function);
    told.forget();
}

/// Gives keys to the studio.
pub fn focus() {
    if let Some(canvas) = canvas() {
        let _ = canvas.focus();
    }
}

/// Shows a problem over the studio, or takes what stands there before it begins away.
pub fn say(problem: Option<&str>) {
    let Some(place) = document().and_then(|d| d.get_element_by_id("loading")) else {
        return;
    };
    match problem {
        Some(problem) => {
            place.set_text_content(Some(problem));
            let _ = place.remove_attribute("hidden");
        }
        None => drop(place.set_attribute("hidden", "")),
    }
}

/// Notes in the browser's timeline that something happened, for measurements; of what happens often only the `last` time.
pub fn mark(name: &str, last: bool) {
    if let Some(performance) = window().and_then(|w| w.performance()) {
        if last {
            performance.clear_marks_with_mark_name(name);
        }
        let _ = performance.mark(name);
    }
}

/// The address after `#`.
pub fn address() -> String {
    let hash = window().and_then(|w| w.location().hash().ok());
    hash.unwrap_or_default().trim_start_matches('#').to_owned()
}

/// Changes the address after `#` without a new entry in the history.
pub fn set_address(words: &str) {
    let history = window().and_then(|w| w.history().ok());
    if let Some(history) = history {
        let _ = history.replace_state_with_url(&JsValue::NULL, "", Some(&format!("#{words}")));
    }
}

fn storage() -> Option<Storage> {
    window()?.local_storage().ok()?
}

/// A setting that was stored.
pub fn stored(name: &str) -> Option<String> {
    storage()?.get_item(&format!("greenstick.{name}")).ok()?
}

/// Stores a setting; that it cannot be is no reason to disturb anybody.
pub fn store(name: &str, value: &str) {
    if let Some(storage) = storage() {
        let _ = storage.set_item(&format!("greenstick.{name}"), value);
    }
}

/// Listens to drops of files and to changes of the address by hand, for as long as the page is there.
pub fn listen(inbox: &Inbox, wake: &Wake) {
    let Some(window) = window() else { return };
    let dropped = {
        let (inbox, wake) = (inbox.clone(), wake.clone());
        Closure::<dyn FnMut(DragEvent)>::new(move |event: DragEvent| {
            event.prevent_default();
            if let Some(files) = event.data_transfer().and_then(|d| d.files()) {
                read_all(&files, &inbox, &wake);
            }
        })
    };
    // A browser that is not told otherwise shows what is dropped instead of the page.
    let over = Closure::<dyn FnMut(DragEvent)>::new(|event: DragEvent| event.prevent_default());
    let changed = {
        let (inbox, wake) = (inbox.clone(), wake.clone());
        Closure::<dyn FnMut(Event)>::new(move |_| {
            inbox.borrow_mut().push_back(News::Address);
            wake();
        })
    };
    // Before the canvas gets them: what draws on it keeps drops to itself.
    let listen = |name: &str, function: &JsValue| {
        let function = function.unchecked_ref();
        let _ = window.add_event_listener_with_callback_and_bool(name, function, true);
    };
    listen("drop", dropped.as_ref());
    listen("dragover", over.as_ref());
    listen("hashchange", changed.as_ref());
    dropped.forget();
    over.forget();
    changed.forget();
}

/// Lets the browser ask for files.
pub fn choose(inbox: &Inbox, wake: &Wake) {
    let element = document().and_then(|d| d.create_element("input").ok());
    let Some(input) = element.and_then(|e| e.dyn_into::<HtmlInputElement>().ok()) else {
        return;
    };
    input.set_type("file");
    input.set_multiple(true);
    let (inbox, wake, own) = (inbox.clone(), wake.clone(), input.clone());
    let chosen = Closure::once_into_js(move || {
        if let Some(files) = own.files() {
            read_all(&files, &inbox, &wake);
        }
    });
    let _ = input.add_event_listener_with_callback("change", chosen.unchecked_ref());
    input.click();
}

fn read_all(files: &FileList, inbox: &Inbox, wake: &Wake) {
    let files: Vec<web_sys::File> = (0..files.length()).filter_map(|i| files.get(i)).collect();
    if files.is_empty() {
        return;
    }
    let (inbox, wake) = (inbox.clone(), wake.clone());
    spawn_local(async move {
        let mut read = Vec::new();
        for file in files {
            let name = file.name();
            match JsFuture::from(file.array_buffer()).await {
                Ok(buffer) => {
                    let bytes = Uint8Array::new(&buffer);
                    read.push(JsFile { name, bytes });
                }
                Err(error) => {
                    let problem = format!("{name}: the browser cannot read it: {error:?}");
                    inbox.borrow_mut().push_back(News::Problem(problem));
                    return wake();
                }
            }
        }
        inbox.borrow_mut().push_back(News::Files(read));
        wake();
    });
}

/// Hands a file out, of bytes or a text.
///
/// # Errors
/// Those of the browser.
pub fn download(name: &str, content: &JsValue) -> Result<(), JsValue> {
    let blob = Blob::new_with_u8_array_sequence(&Array::of1(content))?;
    let url = Url::create_object_url_with_blob(&blob)?;
    let document = document().ok_or(JsValue::NULL)?;
    let anchor: HtmlAnchorElement = document.create_element("a")?.dyn_into()?;
    anchor.set_href(&url);
    anchor.set_download(name);
    anchor.click();
    // The browser keeps what it has begun to hand out.
    Url::revoke_object_url(&url)
}

/// Hands out the files that come with a message; returns their names and sizes.
pub fn download_all(names: &[String], message: &Array) -> Vec<(String, usize)> {
    let mut written = Vec::new();
    for (name, i) in names.iter().zip(1..) {
        let bytes = Uint8Array::from(message.get(i));
        let size = bytes.length() as usize;
        if download(name, &bytes).is_ok() {
            written.push((name.clone(), size));
        }
    }
    written
}
