//! `greenstick-studio [FILE]`: opens the window; in a browser, the page and its worker begin here, too.

#[cfg(not(target_arch = "wasm32"))]
fn main() -> std::process::ExitCode {
    greenstick_studio::window::main()
}

#[cfg(target_arch = "wasm32")]
fn main() {
    greenstick_studio::platform::web::begin();
}
