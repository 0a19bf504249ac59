//! Everything that can be done by name: menus, the palette and the list of shortcuts are made of this one table.

use eframe::egui::{Key, KeyboardShortcut, Modifiers};

/// Something to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    Open,
    Save,
    SaveAs,
    Export,
    BuiltIn,
    Photograph,
    Simulate,
    Pull,
    SaveScene,
    Undo,
    Redo,
    Randomise,
    NewSeed,
    ResetAll,
    AddBreak,
    RemoveBreak,
    FrameBreak,
    FrameAll,
    ViewFront,
    ViewBack,
    ViewRight,
    ViewLeft,
    ViewTop,
    ViewBottom,
    Perspective,
    VerticalAxis,
    Wireframe,
    Section,
    Handles,
    NextHandles,
    Anatomy,
    Cracks,
    Paint,
    Units,
    HidePhotograph,
    NextColours,
    Gallery,
    Theme,
    Larger,
    Smaller,
    Palette,
    Shortcuts,
    Cancel,
    Quit,
}

const NONE: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

/// A shortcut of an action.
type Keys = (Modifiers, Key);

impl Action {
    /// All actions with their names, what they do and their keys, the first of which menus show.
    pub const ALL: &'static [(Action, &'static str, &'static str, &'static [Keys])] = &[
        (
            Action::Open,
            "Open…",
            "Opens a mesh, a scan, a recipe or a project.",
            &[(CTRL, Key::O)],
        ),
        (
            Action::Save,
            "Save project",
            "Saves everything that decides this break.",
            &[(CTRL, Key::S)],
        ),
        (
            Action::SaveAs,
            "Save project as…",
            "Saves the project under another name.",
            &[(CTRL_SHIFT, Key::S)],
        ),
        (
            Action::Export,
            "Export pieces…",
            "Writes the pieces for other programs.",
            &[(CTRL, Key::E)],
        ),
        (
            Action::BuiltIn,
            "Built-in branch",
            "Breaks the branch that comes with the program.",
            &[],
        ),
        (
            Action::Photograph,
            "Photograph…",
            "Lays a photograph of a real break over the picture or beside it.",
            &[(CTRL, Key::I)],
        ),
        (
            Action::Simulate,
            "Simulate…",
            "Moves wood as bonded fibres until it breaks, and shows how.",
            &[(CTRL, Key::M)],
        ),
        (
            Action::Pull,
            "Pull on the wood",
            "Holds the stem at its base, and lets a drag over the wood pull on it until it breaks.",
            &[(NONE, Key::L)],
        ),
        (
            Action::SaveScene,
            "Save the scene…",
            "Saves the scene that is simulated, with its clamps, forces and bodies where they were dragged.",
            &[],
        ),
        (
            Action::Undo,
            "Undo",
            "Takes the last change back.",
            &[(CTRL, Key::Z)],
        ),
        (
            Action::Redo,
            "Redo",
            "Makes it again.",
            &[(CTRL_SHIFT, Key::Z), (CTRL, Key::Y)],
        ),
        (
            Action::Randomise,
            "Randomise what is not locked",
            "Draws new values for the face around the present ones.",
            &[(NONE, Key::R)],
        ),
        (
            Action::NewSeed,
            "Another break",
            "The same values with another seed.",
            &[(NONE, Key::N)],
        ),
        (
            Action::ResetAll,
            "Reset all values",
            "Puts every value back to its default, and leaves one break.",
            &[],
        ),
        (
            Action::AddBreak,
            "Add a break",
            "Breaks the stem at another place too. Ctrl and a click choose the place.",
            &[(NONE, Key::A)],
        ),
        (
            Action::RemoveBreak,
            "Remove the break",
            "Takes the selected of several breaks away.",
            &[(NONE, Key::Delete)],
        ),
        (
            Action::FrameBreak,
            "Frame the break",
            "Shows the break from near.",
            &[(NONE, Key::F), (NONE, Key::Period)],
        ),
        (
            Action::FrameAll,
            "Frame everything",
            "Shows the whole scene.",
            &[(NONE, Key::Home)],
        ),
        (
            Action::ViewFront,
            "View from the front",
            "Looks along −z.",
            &[(NONE, Key::Num1)],
        ),
        (
            Action::ViewBack,
            "View from the back",
            "Looks along +z.",
            &[(CTRL, Key::Num1)],
        ),
        (
            Action::ViewRight,
            "View from the right",
            "Looks along −x.",
            &[(NONE, Key::Num3)],
        ),
        (
            Action::ViewLeft,
            "View from the left",
            "Looks along +x.",
            &[(CTRL, Key::Num3)],
        ),
        (
            Action::ViewTop,
            "View from above",
            "Looks down.",
            &[(NONE, Key::Num7)],
        ),
        (
            Action::ViewBottom,
            "View from below",
            "Looks up.",
            &[(CTRL, Key::Num7)],
        ),
        (
            Action::Perspective,
            "Perspective or parallel",
            "Changes between the two.",
            &[(NONE, Key::Num5)],
        ),
        (
            Action::VerticalAxis,
            "Y or Z up",
            "Changes which axis of the file is the vertical.",
            &[(NONE, Key::U)],
        ),
        (
            Action::Wireframe,
            "Wireframe",
            "Shows the edges of triangles.",
            &[(NONE, Key::W)],
        ),
        (
            Action::Section,
            "Section view",
            "Cuts the picture open along the stem.",
            &[(NONE, Key::X)],
        ),
        (
            Action::Handles,
            "Handles",
            "Shows dots on the wood that are dragged.",
            &[(NONE, Key::H)],
        ),
        (
            Action::NextHandles,
            "Next handles",
            "Handles of the plane of the break, the ductile zone, the high layer, the low layer.",
            &[(Modifiers::SHIFT, Key::H)],
        ),
        (
            Action::Anatomy,
            "Rings across the stem",
            "Shows a section at any height, and lets rings be dragged to where they are.",
            &[(NONE, Key::S)],
        ),
        (
            Action::Cracks,
            "Place cracks",
            "Lets drying cracks be placed by a drag over the broken wood.",
            &[(NONE, Key::K)],
        ),
        (
            Action::Paint,
            "Paint on the break",
            "Lets strokes on the wood say where it breaks, where it splinters and what stays.",
            &[(NONE, Key::B)],
        ),
        (
            Action::Units,
            "Next unit of length",
            "Shows lengths in millimetres, centimetres, metres or inches.",
            &[],
        ),
        (
            Action::HidePhotograph,
            "Show or hide the photograph",
            "Shows the picture without the photograph, and with it again.",
            &[(NONE, Key::P)],
        ),
        (
            Action::NextColours,
            "Next colours",
            "Wood, zones, rings, pieces, clay.",
            &[(NONE, Key::C)],
        ),
        (
            Action::Gallery,
            "Gallery of presets",
            "Shows or hides the gallery.",
            &[(NONE, Key::G)],
        ),
        (
            Action::Theme,
            "Light or dark",
            "Changes between the two.",
            &[],
        ),
        (
            Action::Larger,
            "Larger texts and controls",
            "Scales the whole window up.",
            &[(CTRL, Key::Plus), (CTRL, Key::Equals)],
        ),
        (
            Action::Smaller,
            "Smaller texts and controls",
            "Scales the whole window down.",
            &[(CTRL, Key::Minus)],
        ),
        (
            Action::Palette,
            "Find a command…",
            "Does anything by its name.",
            &[(CTRL, Key::P), (NONE, Key::F3)],
        ),
        (
            Action::Shortcuts,
            "Keyboard and mouse",
            "Lists all keys and what the mouse does.",
            &[
                (NONE, Key::Questionmark),
                (Modifiers::SHIFT, Key::Slash),
                (NONE, Key::F1),
            ],
        ),
        (
            Action::Cancel,
            "Stop the work",
            "Gives up what is being worked out.",
            &[(NONE, Key::Escape)],
        ),
        (
            Action::Quit,
            "Quit",
            "Closes the window.",
            &[(CTRL, Key::Q)],
        ),
    ];

    fn entry(self) -> (&'static str, &'static str, &'static [Keys]) {
        let found = Action::ALL.iter().find(|a| a.0 == self);
        found.map_or(("", "", &[]), |a| (a.1, a.2, a.3))
    }

    /// Its name.
    pub fn label(self) -> &'static str {
        self.entry().0
    }

    /// What it does.
    pub fn about(self) -> &'static str {
        self.entry().1
    }

    /// The shortcut that menus show.
    pub fn shortcut(self) -> Option<KeyboardShortcut> {
        let (modifiers, key) = self.entry().2.first()?;
        Some(KeyboardShortcut::new(*modifiers, *key))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_does_two_things() {
        let mut seen = Vec::new();
        for (action, label, about, keys) in Action::ALL {
            assert!(!label.is_empty() && about.ends_with('.'), "{action:?}");
            for keys in *keys {
                assert!(!seen.contains(&keys), "{label}: {keys:?}");
                seen.push(keys);
            }
        }
    }
}
