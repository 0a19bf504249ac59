//! The program with a window of its own.

use eframe::{egui, egui_wgpu, wgpu};
use greenstick_studio::platform::native::{Native, config_folder};
use greenstick_studio::ui::studio::Studio;
use std::process::ExitCode;
use std::sync::Arc;

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
    match run(path) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", advice(&error));
            ExitCode::FAILURE
        }
    }
}

fn run(path: Option<String>) -> eframe::Result {
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_app_id("greenstick-studio")
            .with_inner_size([1360.0, 860.0])
            .with_min_inner_size([760.0, 480.0])
            .with_drag_and_drop(true),
        renderer: eframe::Renderer::Wgpu,
        ..eframe::NativeOptions::default()
    };
    eframe::run_native(
        "Greenstick",
        options,
        Box::new(move |creation| {
            let ctx = creation.egui_ctx.clone();
            let wake = Arc::new(move || ctx.request_repaint());
            let platform = Native::new(config_folder(), wake);
            let mut studio = Studio::new(&creation.egui_ctx, Box::new(platform), path.as_deref());
            if let Some(state) = &creation.wgpu_render_state {
                studio.use_card(state);
            }
            Ok(Box::new(studio))
        }),
    )
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
