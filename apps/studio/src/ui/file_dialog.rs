//! Choosing a file: the folders of the machine as the platform lists them.

use crate::platform::{Entry, Platform};
use eframe::egui::{self, Ui};

/// A choice of a file that is going on.
#[derive(Debug, Clone, Default)]
pub struct FileDialog {
    /// The folder that is shown, as its whole path.
    folder: String,
    entries: Vec<Entry>,
    /// The name that is typed or chosen.
    pub name: String,
    /// What is wrong with the folder.
    problem: Option<String>,
    /// Endings of the files that are listed, in lower case; none for all.
    endings: Vec<String>,
    /// Whether the name is about to be ready to be typed, as at the start.
    focus: bool,
}

impl FileDialog {
    /// A choice in a folder, of files with these endings.
    pub fn new(platform: &dyn Platform, folder: &str, name: &str, endings: &[&str]) -> Self {
        let mut dialog = FileDialog {
            name: name.to_owned(),
            endings: endings.iter().map(|e| e.to_lowercase()).collect(),
            focus: true,
            ..FileDialog::default()
        };
        dialog.go(platform, folder);
        dialog
    }

    fn go(&mut self, platform: &dyn Platform, folder: &str) {
        match platform.list(folder) {
            Ok((folder, entries)) => {
                (self.folder, self.entries, self.problem) = (folder, entries, None);
            }
            Err(failure) => self.problem = Some(failure.message),
        }
    }

    fn is_listed(&self, entry: &Entry) -> bool {
        let name = entry.name.to_lowercase();
        !entry.is_file || self.endings.is_empty() || self.endings.iter().any(|e| name.ends_with(e))
    }

    /// The path that is chosen.
    pub fn path(&self, platform: &dyn Platform) -> String {
        platform.join(&self.folder, self.name.trim())
    }

    /// Shows folder, files and name. Returns a path when a file was chosen for good.
    pub fn show(&mut self, ui: &mut Ui, platform: &dyn Platform) -> Option<String> {
        let mut chosen = None;
        if platform.has_folders() {
            chosen = self.show_folder(ui, platform);
        }
        ui.horizontal(|ui| {
            ui.label("Name");
            let edit = egui::TextEdit::singleline(&mut self.name).desired_width(f32::INFINITY);
            let response = ui.add(edit);
            if std::mem::take(&mut self.focus) {
                response.request_focus();
            }
            let entered = response.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            if entered && !self.name.trim().is_empty() {
                chosen = Some(self.path(platform));
            }
        });
        chosen
    }

    /// Shows the folder and its files. Returns a path when a file was chosen for good.
    fn show_folder(&mut self, ui: &mut Ui, platform: &dyn Platform) -> Option<String> {
        let mut go = None;
        let mut chosen = None;
        ui.horizontal(|ui| {
            if ui.button("Up").on_hover_text("The folder above.").clicked() {
                go = platform.parent(&self.folder);
            }
            let edit = egui::TextEdit::singleline(&mut self.folder);
            let response = ui.add(edit.desired_width(f32::INFINITY));
            if response.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter)) {
                go = Some(self.folder.clone());
            }
        });
        if let Some(problem) = &self.problem {
            ui.colored_label(ui.visuals().error_fg_color, problem);
        }
        egui::ScrollArea::vertical()
            .max_height(280.0)
            .auto_shrink([false, false])
            .show(ui, |ui| {
                let listed: Vec<Entry> = self
                    .entries
                    .iter()
                    .filter(|e| self.is_listed(e))
                    .cloned()
                    .collect();
                if listed.is_empty() {
                    ui.weak("There are no such files here.");
                }
                for entry in listed {
                    let text = if entry.is_file {
                        entry.name.clone()
                    } else {
                        format!("{}/", entry.name)
                    };
                    let response = ui.selectable_label(self.name == entry.name, text);
                    if response.double_clicked() && entry.is_file {
                        chosen = Some(platform.join(&self.folder, &entry.name));
                    }
                    if response.clicked() {
                        if entry.is_file {
                            self.name = entry.name;
                        } else {
                            go = Some(platform.join(&self.folder, &entry.name));
                        }
                    }
                }
            });
        if let Some(folder) = go {
            self.go(platform, &folder);
        }
        chosen
    }
}
