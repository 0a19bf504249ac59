//! What the window knows of the photograph besides the project.

use eframe::egui::TextureHandle;
use greenstick::formats::photograph::Photograph;

/// What of the photograph is not part of the project.
#[derive(Default)]
pub struct PhotographView {
    /// The picture with its path, once it is read.
    pub picture: Option<(String, TextureHandle)>,
    /// The path that is being read.
    pub asked: Option<String>,
    /// A path that could not be read: it is not tried again.
    pub failed: Option<String>,
    /// Pixels of a picture that was read, until there is a window to show them in.
    pub pixels: Option<(String, Photograph)>,
    /// Whether it is not shown.
    pub hidden: bool,
    /// Whether dragging moves it and not the camera.
    pub moves: bool,
}

impl PhotographView {
    /// Whether a picture is being read.
    pub fn is_awaited(&self) -> bool {
        self.asked.is_some()
    }
}
