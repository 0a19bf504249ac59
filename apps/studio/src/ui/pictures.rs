//! Pictures that are decoded when they are first shown.

use eframe::egui::{self, ColorImage, TextureHandle};
use greenstick::formats::photograph::read_photograph;
use std::collections::BTreeMap;

/// Pictures that were decoded.
#[derive(Default)]
pub struct Pictures(BTreeMap<&'static str, TextureHandle>);

impl Pictures {
    /// The picture of a name, from a PNG file.
    pub fn get(
        &mut self,
        ctx: &egui::Context,
        name: &'static str,
        png: &[u8],
    ) -> Option<TextureHandle> {
        if let Some(found) = self.0.get(name) {
            return Some(found.clone());
        }
        let image = read_photograph(png).ok()?;
        let size = [image.width as usize, image.height as usize];
        let pixels = ColorImage::from_rgb(size, &image.rgb);
        let handle = ctx.load_texture(name, pixels, egui::TextureOptions::LINEAR);
        self.0.insert(name, handle.clone());
        Some(handle)
    }
}
