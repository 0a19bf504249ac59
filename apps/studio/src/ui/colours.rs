//! The colours of the window that several of its parts use.

use eframe::egui::Color32;

/// The colour of what acts on the wood.
pub(super) const ACCENT: Color32 = Color32::from_rgb(255, 140, 40);
