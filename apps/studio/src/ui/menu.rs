//! The menus.

use super::actions::Action;
use super::studio::Studio;
use eframe::egui::{self, Button, Ui};

/// The menus with their actions; `None` is a line between.
const MENUS: [(&str, &[Option<Action>]); 4] = [
    (
        "Edit",
        &[
            Some(Action::Undo),
            Some(Action::Redo),
            None,
            Some(Action::Randomise),
            Some(Action::NewSeed),
            Some(Action::ResetAll),
            None,
            Some(Action::AddBreak),
            Some(Action::RemoveBreak),
            None,
            Some(Action::Palette),
        ],
    ),
    (
        "View",
        &[
            Some(Action::FrameBreak),
            Some(Action::FrameAll),
            None,
            Some(Action::ViewFront),
            Some(Action::ViewBack),
            Some(Action::ViewRight),
            Some(Action::ViewLeft),
            Some(Action::ViewTop),
            Some(Action::ViewBottom),
            Some(Action::Perspective),
            Some(Action::VerticalAxis),
        ],
    ),
    (
        "Window",
        &[
            Some(Action::Gallery),
            Some(Action::Wireframe),
            Some(Action::Section),
            Some(Action::Handles),
            Some(Action::Anatomy),
            Some(Action::Cracks),
            Some(Action::HidePhotograph),
            Some(Action::NextColours),
            None,
            Some(Action::Units),
            Some(Action::Theme),
            Some(Action::Larger),
            Some(Action::Smaller),
        ],
    ),
    ("Help", &[Some(Action::Shortcuts)]),
];

impl Studio {
    /// The line of menus.
    pub(super) fn menu(&mut self, ui: &mut Ui) {
        egui::Panel::top("menu").show(ui, |ui| {
            egui::MenuBar::new().ui(ui, |ui| {
                ui.menu_button("File", |ui| self.file_menu(ui));
                for (title, actions) in MENUS {
                    ui.menu_button(title, |ui| {
                        ui.set_min_width(210.0);
                        for action in actions {
                            match action {
                                Some(action) => self.menu_item(ui, *action),
                                None => drop(ui.separator()),
                            }
                        }
                    });
                }
                ui.separator();
                let [undo, redo] = self.step_labels();
                for (action, label) in [(Action::Undo, undo), (Action::Redo, redo)] {
                    let button = Button::new(action.label());
                    let response = ui.add_enabled(label.is_some(), button);
                    let about = label.unwrap_or_default();
                    if response.on_hover_text(about).clicked() {
                        self.act(action, &ui.ctx().clone());
                    }
                }
            });
        });
    }

    fn menu_item(&mut self, ui: &mut Ui, action: Action) {
        let mut button = Button::new(action.label());
        if let Some(shortcut) = action.shortcut() {
            button = button.shortcut_text(ui.ctx().format_shortcut(&shortcut));
        }
        if ui.add(button).on_hover_text(action.about()).clicked() {
            self.act(action, &ui.ctx().clone());
            ui.close();
        }
    }

    fn file_menu(&mut self, ui: &mut Ui) {
        ui.set_min_width(230.0);
        let has_folders = self.platform.has_folders();
        self.menu_item(ui, Action::Open);
        if has_folders {
            self.recent_menu(ui);
        }
        self.menu_item(ui, Action::BuiltIn);
        self.menu_item(ui, Action::Photograph);
        if !self.platform.scenes().is_empty() {
            self.menu_item(ui, Action::Simulate);
            self.menu_item(ui, Action::Pull);
        }
        ui.separator();
        self.menu_item(ui, Action::Save);
        self.menu_item(ui, Action::SaveAs);
        self.menu_item(ui, Action::Export);
        if has_folders {
            ui.separator();
            self.menu_item(ui, Action::Quit);
        }
    }

    fn recent_menu(&mut self, ui: &mut Ui) {
        let recent = self.platform.recent();
        ui.add_enabled_ui(!recent.is_empty(), |ui| {
            ui.menu_button("Open recent", |ui| {
                ui.set_min_width(320.0);
                for path in recent {
                    if ui.button(&path).clicked() {
                        self.open(&path);
                        ui.close();
                    }
                }
            });
        });
    }
}
