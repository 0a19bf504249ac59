//! The studio on the canvas of the page, and on another canvas where the graphics card is lost: everything goes on as it was.

use super::browser;
use super::news::Wake;
use crate::platform::Platform;
use crate::ui::studio::Studio;
use eframe::egui;
use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;
use web_time::Instant;

/// What stands on the page when nothing is drawn any more.
const STOPPED: &str = "The studio has stopped, most often because the graphics card was taken from it. Load the page again: its \
                       address holds what was being made. What happened is in the browser's console.";
/// Losses of the graphics card, each soon after the one before, after which the page gives up: a card that is gone stays gone.
const MOST_LOSSES: u32 = 3;
/// What is soon.
const SOON: Duration = Duration::from_secs(60);

/// The studio, which outlives the canvases that it is drawn on.
type Held = Rc<RefCell<Option<Studio>>>;

/// Makes the machine that the studio works on, which is woken so.
pub type Machine = fn(Wake) -> Box<dyn Platform>;

/// What goes on from canvas to canvas.
#[derive(Default)]
struct Page {
    studio: Held,
    machine: Option<Machine>,
    /// The context of the present canvas, which work beside it wakes.
    present: Rc<RefCell<Option<egui::Context>>>,
    runner: Option<eframe::WebRunner>,
    /// When the card was lost last, and how often soon after one another.
    lost: Option<(Instant, u32)>,
    /// Whether another canvas is on its way.
    begins_again: bool,
}

thread_local! {
    static PAGE: RefCell<Page> = RefCell::default();
}

/// What a canvas shows.
struct Shown(Held);

impl eframe::App for Shown {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        if let Some(studio) = &mut *self.0.borrow_mut() {
            studio.frame(ui);
        }
    }
}

/// Draws a new studio on the canvas of the page.
pub async fn begin(machine: Machine) {
    PAGE.with_borrow_mut(|p| p.machine = Some(machine));
    open().await;
}

/// Draws the studio on the canvas of the page: a new one, or that which was drawn before.
async fn open() {
    let Some(canvas) = browser::canvas() else {
        return;
    };
    let (held, present, machine) =
        PAGE.with_borrow(|p| (p.studio.clone(), p.present.clone(), p.machine));
    let Some(machine) = machine else { return };
    let create: eframe::AppCreator = Box::new(move |creation| {
        *present.borrow_mut() = Some(creation.egui_ctx.clone());
        Studio::show_in(&mut held.borrow_mut(), creation, |ctx| {
            let present = present.clone();
            let wake = Rc::new(move || {
                if let Some(ctx) = &*present.borrow() {
                    ctx.request_repaint();
                }
            });
            Studio::new(ctx, machine(wake), None)
        });
        Ok(Box::new(Shown(held.clone())))
    });
    let runner = eframe::WebRunner::new();
    say_faults();
    let started = runner.start(canvas.clone(), eframe::WebOptions::default(), create);
    let problem = started.await.err().map(|e| {
        format!(
            "This browser draws neither by WebGPU nor by WebGL 2, or has them switched off ({e:?})."
        )
    });
    PAGE.with_borrow_mut(|p| p.runner = Some(runner));
    browser::on_lost(&canvas, begin_again);
    browser::focus();
    browser::say(problem.as_deref());
}

/// Goes on on another canvas, as the card of the present one was lost.
pub fn begin_again() {
    let gives_up = PAGE.with_borrow_mut(|p| {
        if p.begins_again {
            return None;
        }
        p.begins_again = true;
        let soon = p.lost.filter(|(at, _)| at.elapsed() < SOON);
        let losses = soon.map_or(1, |(_, losses)| losses + 1);
        p.lost = Some((Instant::now(), losses));
        Some(losses == MOST_LOSSES)
    });
    let Some(gives_up) = gives_up else { return };
    // What draws the canvas may be at work now: it ends when that is done.
    wasm_bindgen_futures::spawn_local(async move {
        let (runner, held) = PAGE.with_borrow_mut(|p| (p.runner.take(), p.studio.clone()));
        if let Some(runner) = runner {
            runner.destroy();
        }
        if let Some(studio) = &mut *held.borrow_mut() {
            studio.keep_changes();
        }
        if gives_up {
            return browser::say(Some(STOPPED));
        }
        browser::renew_canvas();
        open().await;
        PAGE.with_borrow_mut(|p| p.begins_again = false);
    });
}

/// Tells of faults on the page itself, too, and not in the browser's console alone: nothing is drawn any more after one.
fn say_faults() {
    let console = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |fault| {
        browser::say(Some(STOPPED));
        console(fault);
    }));
}
