//! Which dialog is open.

use super::file_dialog::FileDialog;
use crate::model::simulation::SceneEntry;

/// A dialog that is open.
#[derive(Debug, Clone)]
pub enum Dialog {
    /// Choosing a file to open.
    Open(FileDialog),
    /// Choosing a scene to simulate: its number, and whether it is put on the stem at hand.
    Simulate(Vec<SceneEntry>, usize, bool),
    /// Choosing a photograph.
    Photograph(FileDialog),
    /// Choosing where to save the project.
    Save(FileDialog),
    /// Choosing where to save the scene that is simulated.
    SaveScene(FileDialog),
    /// Choosing where and how to export.
    Export(FileDialog),
    /// Finding a command by its name.
    Palette(String),
    /// The list of keys.
    Shortcuts,
    /// Unsaved work was found, at this path.
    Recover(String),
}

impl Dialog {
    /// Its heading.
    pub fn title(&self) -> &'static str {
        match self {
            Dialog::Open(_) => "Open a mesh, a scan, a project or a scene",
            Dialog::Simulate(..) => "Simulate",
            Dialog::Photograph(_) => "Open a photograph, PNG or JPEG",
            Dialog::Save(_) => "Save the project",
            Dialog::SaveScene(_) => "Save the scene",
            Dialog::Export(_) => "Export the pieces",
            Dialog::Palette(_) => "Find a command",
            Dialog::Shortcuts => "Keyboard and mouse",
            Dialog::Recover(_) => "Unsaved work was found",
        }
    }
}
