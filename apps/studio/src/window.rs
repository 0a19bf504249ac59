//! The program with a window of its own, or several, one after the other, where the graphics card is lost.

use crate::platform::native::{Native, config_folder};
use crate::ui::card::WindowPlace;
use crate::ui::studio::Studio;
use eframe::{egui, egui_wgpu, wgpu};
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::process::ExitCode;
use std::rc::Rc;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Size of the first window, points.
const FIRST_SIZE: [f32; 2] = [1360.0, 860.0];

const USAGE: &str = "\
Usage: greenstick-studio [FILE]

Opens a window on a mesh (.glb, .gltf, .obj, .ply, .stl, .off), a scan (.las, .laz, .ply, .xyz), a recipe or a project
(.toml); without a file, on the built-in branch.
";

/// Opens the window by the arguments of the command line.
pub fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let path = match &arguments[..] {
        [] => None,
        [word] if word == "--help" || word == "-h" => {
            print!("{USAGE}");
            return ExitCode::SUCCESS;
        }
        [word] if word == "--version" || word == "-V" => {
            println!("greenstick-studio {}", env!("CARGO_PKG_VERSION"));
            return ExitCode::SUCCESS;
        }
        [path] if !path.starts_with("--") => Some(path.clone()),
        _ => {
            eprint!("error: expected one file at most\n{USAGE}");
            return ExitCode::from(2);
        }
    };
    match run(path.as_deref(), |_| {}) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Losses of the graphics device, each soon after the one before, after which the program gives up: a card that is gone stays gone.
const MOST_LOSSES: usize = 3;
/// What is soon.
const SOON: Duration = Duration::from_secs(60);

/// Time in which a device tells of its end where a window ended in the middle of a frame: it first ends what it was given to draw.
const NEWS: Duration = Duration::from_secs(10);

/// The studio, which outlives its windows.
type Held = Rc<RefCell<Option<Studio>>>;

/// What a window shows.
struct Shown(Held);

impl eframe::App for Shown {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        if let Some(studio) = &mut *self.0.borrow_mut() {
            studio.frame(ui);
        }
    }

    fn on_exit(&mut self) {
        if let Some(studio) = &mut *self.0.borrow_mut()
            && studio.lost_card().is_none()
        {
            eframe::App::on_exit(studio);
        }
    }
}

/// Opens the window on `path`, and again where the graphics device is lost; `on_card` hears of each device.
///
/// # Errors
/// That there is no display or no card, or that the card is lost again and again.
pub fn run(path: Option<&str>, on_card: impl Fn(&::wgpu::Device)) -> Result<(), String> {
    let held = Held::default();
    // The context of the present window, which work beside it wakes.
    let present: Arc<Mutex<Option<egui::Context>>> = Arc::default();
    let mut losses = 0;
    loop {
        let begun = Instant::now();
        // What draws the window does not expect its device to be lost in the middle of a frame.
        let ended = catch_unwind(AssertUnwindSafe(|| open(&held, &present, path, &on_card)));
        let patience = if ended.is_err() { NEWS } else { Duration::ZERO };
        let lost = why_lost(&held, patience);
        let reason = match (ended, lost) {
            (Ok(ended), None) => return ended.map_err(|e| advice(&e)),
            (Ok(Err(error)), Some(_)) => return Err(advice(&error)),
            (Err(panic), None) => resume_unwind(panic),
            (_, Some(reason)) => reason,
        };
        if let Some(studio) = &mut *held.borrow_mut() {
            studio.keep_changes();
        }
        losses = if begun.elapsed() < SOON {
            losses + 1
        } else {
            1
        };
        if losses == MOST_LOSSES {
            return Err(format!(
                "the graphics card was lost {MOST_LOSSES} times ({reason}); what was not saved is offered at the next start"
            ));
        }
        eprintln!("the graphics card was lost ({reason}); the window begins again");
    }
}

/// Returns why the graphics device was lost, if it was or is within `patience`.
fn why_lost(held: &Held, patience: Duration) -> Option<String> {
    let begun = Instant::now();
    loop {
        let lost = held.borrow().as_ref().and_then(Studio::lost_card);
        if lost.is_some() || begun.elapsed() >= patience {
            return lost;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Opens one window, on the studio that is held, or on a new one.
fn open(
    held: &Held,
    present: &Arc<Mutex<Option<egui::Context>>>,
    path: Option<&str>,
    on_card: &dyn Fn(&::wgpu::Device),
) -> eframe::Result {
    let place = held.borrow().as_ref().map(Studio::window_place);
    let options = eframe::NativeOptions {
        viewport: viewport(place.unwrap_or_default()),
        renderer: eframe::Renderer::Wgpu,
        ..eframe::NativeOptions::default()
    };
    let create = |creation: &eframe::CreationContext<'_>| {
        let now = creation.egui_ctx.clone();
        *present.lock().unwrap_or_else(PoisonError::into_inner) = Some(now);
        Studio::show_in(&mut held.borrow_mut(), creation, |ctx| {
            let present = present.clone();
            let wake = Arc::new(move || {
                let present = present.lock().unwrap_or_else(PoisonError::into_inner);
                if let Some(ctx) = &*present {
                    ctx.request_repaint();
                }
            });
            let platform = Native::new(config_folder(), wake);
            Studio::new(ctx, Box::new(platform), path)
        });
        if let Some(state) = &creation.wgpu_render_state {
            on_card(&state.device);
        }
        let shown: Box<dyn eframe::App> = Box::new(Shown(held.clone()));
        Ok(shown)
    };
    eframe::run_native("Greenstick", options, Box::new(create))
}

/// The window where it was, or where the display puts it.
fn viewport(place: WindowPlace) -> egui::ViewportBuilder {
    let inner = place.inner.map_or(FIRST_SIZE.into(), |r| r.size());
    let builder = egui::ViewportBuilder::default()
        .with_app_id("greenstick-studio")
        .with_inner_size(inner)
        .with_min_inner_size([760.0, 480.0])
        .with_maximized(place.maximized)
        .with_fullscreen(place.fullscreen)
        .with_drag_and_drop(true);
    match place.outer {
        Some(outer) => builder.with_position(outer.min),
        None => builder,
    }
}

/// What went wrong, and what helps.
fn advice(error: &eframe::Error) -> String {
    let missing = matches!(
        error,
        eframe::Error::Wgpu(
            egui_wgpu::WgpuError::RequestAdapterError(_)
                | egui_wgpu::WgpuError::CustomNativeAdapterSelectionError(_)
                | egui_wgpu::WgpuError::CreateSurfaceError(_)
                | egui_wgpu::WgpuError::NoSurfaceFormatsAvailable
        )
    );
    if missing {
        let driver = if cfg!(target_os = "linux") {
            "\n  hint: install a Vulkan driver. On Debian and Ubuntu mesa-vulkan-drivers has those of most cards, and one \
             that draws on the processor where there is no card: apt install mesa-vulkan-drivers"
        } else {
            "\n  hint: install the driver of your graphics card"
        };
        return format!(
            "no graphics adapter: the window needs Vulkan, Metal or DirectX 12 ({error}){driver}"
        );
    }
    let display = match error {
        eframe::Error::WinitEventLoop(_) | eframe::Error::Winit(_) => {
            "\n  hint: the window needs a display, X11 or Wayland; `greenstick` does the same work from the command line"
        }
        _ => "",
    };
    format!("{error}{display}")
}

/// Keeps the crate's version of wgpu the one that eframe uses: two would not fit together.
const _: fn(wgpu::Limits) -> ::wgpu::Limits = |limits| limits;
