//! Dialogs: opening, saving, exporting, finding a command, the list of keys, recovery.

use super::actions::Action;
use super::dialog::Dialog;
use super::file_dialog::FileDialog;
use super::studio::Studio;
use crate::model::command::equivalent;
use crate::model::photograph::PICTURE_ENDINGS;
use crate::platform::Export;
use eframe::egui::{self, Grid, Id, Modal, RichText, Ui};
use greenstick::formats::{CloudFormat, Format, OutputFormat};
use greenstick::schema::Value;

/// Ending of project files.
const PROJECT_ENDING: &str = ".greenstick.toml";

/// What the mouse does.
const MOUSE: [(&str, &str); 11] = [
    ("Drag, or middle drag", "turns"),
    ("Shift drag, right drag, or Shift middle drag", "shifts"),
    (
        "Wheel",
        "goes nearer to what is under the pointer, and farther",
    ),
    ("Ctrl middle drag", "goes nearer and farther"),
    ("Two fingers on a touchpad", "turn; with Shift they shift"),
    ("Pinch, or two fingers with Ctrl", "goes nearer and farther"),
    ("Click on the stem", "breaks it there"),
    ("Drag of a dot on the stem", "moves what it stands for"),
    (
        "Drag of the wood in a simulation, with Pull",
        "pulls on it until it breaks",
    ),
    ("Double click on a slider or its name", "resets the value"),
    ("Drop a file on the window", "opens it"),
];

fn project_name(studio: &Studio) -> String {
    let path = studio.project.path.as_deref();
    let saved = path.and_then(|p| p.rsplit(['/', '\\']).next());
    match saved {
        Some(name) => name.to_owned(),
        None => {
            let title = studio.project.input.file_name().unwrap_or("branch");
            let stem = title.rsplit_once('.').map_or(title, |t| t.0);
            format!("{stem}{PROJECT_ENDING}")
        }
    }
}

/// The folder of what is worked on.
fn folder(studio: &Studio) -> String {
    let path = studio
        .project
        .path
        .as_ref()
        .or(studio.project.input.path.as_ref());
    let parent = path.and_then(|p| studio.platform.parent(p));
    parent
        .filter(|p| !p.is_empty())
        .unwrap_or_else(|| ".".to_owned())
}

impl Studio {
    /// The dialog of an action.
    pub(super) fn dialog_of(&self, action: Action) -> Option<Dialog> {
        let files = |name: &str, endings: &[&str]| {
            FileDialog::new(&*self.platform, &folder(self), name, endings)
        };
        Some(match action {
            Action::Open => {
                let clouds = CloudFormat::ALL.iter().flat_map(|f| f.extensions());
                let meshes = Format::ALL.map(Format::extension).into_iter();
                let mut endings: Vec<&str> = meshes.chain(clouds.copied()).collect();
                endings.push("toml");
                Dialog::Open(files("", &endings))
            }
            Action::Simulate => {
                let scenes = self.platform.scenes();
                if scenes.is_empty() {
                    return None;
                }
                let bend = scenes.iter().position(|s| s.name == "bend");
                Dialog::Simulate(scenes, bend.unwrap_or(0), false)
            }
            Action::Photograph => Dialog::Photograph(files("", &PICTURE_ENDINGS)),
            Action::SaveScene => Dialog::SaveScene(files("scene.toml", &[".toml"])),
            Action::SaveAs => Dialog::Save(files(&project_name(self), &[".toml"])),
            Action::Export => {
                let formats = OutputFormat::all();
                let endings: Vec<&str> = formats.iter().map(|f| f.extension()).collect();
                Dialog::Export(files("broken.glb", &endings))
            }
            Action::Palette => Dialog::Palette(String::new()),
            Action::Shortcuts => Dialog::Shortcuts,
            _ => return None,
        })
    }

    /// Shows the dialog that is open.
    pub(super) fn dialogs(&mut self, ctx: &egui::Context) {
        let Some(mut dialog) = self.dialog.take() else {
            return;
        };
        let mut keep = true;
        let response = Modal::new(Id::unique("dialog")).show(ctx, |ui| {
            ui.set_width(560.0f32.min(ctx.content_rect().width() - 60.0));
            ui.heading(dialog.title());
            ui.separator();
            keep = match &mut dialog {
                Dialog::Open(files) => self.open_dialog(ui, files),
                Dialog::Simulate(scenes, at, own) => self.simulate_dialog(ui, scenes, at, own),
                Dialog::Photograph(files) => self.photograph_dialog(ui, files),
                Dialog::Save(files) => self.save_dialog(ui, files),
                Dialog::SaveScene(files) => self.save_scene_dialog(ui, files),
                Dialog::Export(files) => self.export_dialog(ui, files),
                Dialog::Palette(search) => self.palette(ui, search),
                Dialog::Shortcuts => shortcuts(ui),
                Dialog::Recover(path) => self.recover(ui, path),
            };
        });
        // A command of the palette may have opened another.
        if keep && !response.should_close() && self.dialog.is_none() {
            self.dialog = Some(dialog);
        }
    }

    fn open_dialog(&mut self, ui: &mut Ui, files: &mut FileDialog) -> bool {
        let mut chosen = files.show(ui, &*self.platform);
        let keep = buttons(ui, "Open", !files.name.trim().is_empty(), || {
            chosen = Some(files.path(&*self.platform));
        });
        if let Some(path) = chosen {
            self.open(&path);
            return false;
        }
        keep
    }

    fn photograph_dialog(&mut self, ui: &mut Ui, files: &mut FileDialog) -> bool {
        let mut chosen = files.show(ui, &*self.platform);
        let keep = buttons(ui, "Open", !files.name.trim().is_empty(), || {
            chosen = Some(files.path(&*self.platform));
        });
        if let Some(path) = chosen {
            self.open_photograph(&path);
            return false;
        }
        keep
    }

    fn save_dialog(&mut self, ui: &mut Ui, files: &mut FileDialog) -> bool {
        let mut chosen = files.show(ui, &*self.platform);
        ui.weak("The file holds every value and the path of the input. `greenstick break --recipe` reads it, too.");
        let keep = buttons(ui, "Save", !files.name.trim().is_empty(), || {
            chosen = Some(files.path(&*self.platform));
        });
        if let Some(path) = chosen {
            let named = path.to_lowercase().ends_with(".toml");
            let path = if named { path } else { path + PROJECT_ENDING };
            self.save_as(&path);
            return false;
        }
        keep
    }

    fn export_dialog(&mut self, ui: &mut Ui, files: &mut FileDialog) -> bool {
        let mut chosen = files.show(ui, &*self.platform);
        let list = self.project.parameters();
        let now = ui.input(|i| i.time);
        let value = |key: &str| list.iter().find(|p| p.key == key).map(|p| p.value.clone());
        ui.horizontal(|ui| {
            let formats: Vec<&str> = OutputFormat::all()
                .into_iter()
                .map(OutputFormat::extension)
                .collect();
            ui.weak(format!(
                "The ending decides the format: {}.",
                formats.join(", ")
            ));
        });
        Grid::new("export").num_columns(2).show(ui, |ui| {
            if let Some(Value::Integer(width)) = value("texture_size") {
                ui.label("Textures of the wood");
                let mut shown = width as u32;
                egui::ComboBox::from_id_salt("texture size")
                    .selected_text(format!("{shown} × {}", shown / 2))
                    .show_ui(ui, |ui| {
                        for side in [256, 512, 1024, 2048, 4096, 8192] {
                            ui.selectable_value(&mut shown, side, format!("{side} × {}", side / 2));
                        }
                    });
                if i128::from(shown) != width {
                    let new = Value::Integer(shown.into());
                    self.set("texture_size", &new, false, now);
                }
                ui.end_row();
            }
        });
        ui.separator();
        ui.label("The same by the command line:");
        let path = files.path(&*self.platform);
        let input = self.project.input.path.clone();
        let project = self
            .project
            .path
            .clone()
            .unwrap_or_else(|| project_name(self));
        let command = match self.project.input.made {
            Some(_) => "Save the project first: its stem has no file yet.".to_owned(),
            None => equivalent(&self.project.file, input.as_deref(), &path, &project),
        };
        egui::ScrollArea::vertical()
            .id_salt("command")
            .max_height(80.0)
            .show(ui, |ui| {
                ui.add(
                    egui::Label::new(RichText::new(&command).monospace())
                        .wrap()
                        .selectable(true),
                );
            });
        if ui.button("Copy the command").clicked() {
            ui.ctx().copy_text(command);
        }
        let keep = buttons(ui, "Export", !files.name.trim().is_empty(), || {
            chosen = Some(path);
        });
        if let Some(path) = chosen {
            self.platform.export(Export {
                input: self.project.input.clone(),
                file: self.project.file.clone(),
                path,
            });
            return false;
        }
        keep
    }

    fn palette(&mut self, ui: &mut Ui, search: &mut String) -> bool {
        let edit = egui::TextEdit::singleline(search)
            .hint_text("Type a part of its name")
            .desired_width(f32::INFINITY);
        let response = ui.add(edit);
        response.request_focus();
        let wanted = search.to_lowercase();
        let words: Vec<&str> = wanted.split_whitespace().collect();
        let matches = |label: &str, about: &str| {
            let text = format!("{label} {about}").to_lowercase();
            words.iter().all(|w| text.contains(w))
        };
        let found: Vec<_> = Action::ALL.iter().filter(|a| matches(a.1, a.2)).collect();
        let mut chosen = None;
        if ui.input(|i| i.key_pressed(egui::Key::Enter)) {
            chosen = found.first().map(|a| a.0);
        }
        egui::ScrollArea::vertical()
            .max_height(320.0)
            .show(ui, |ui| {
                for (i, (action, label, about, _)) in found.into_iter().enumerate() {
                    let mut button = egui::Button::selectable(i == 0, *label);
                    if let Some(keys) = action.shortcut() {
                        button = button.shortcut_text(ui.ctx().format_shortcut(&keys));
                    }
                    let response = ui.add_sized([ui.available_width(), 22.0], button);
                    if response.on_hover_text(*about).clicked() {
                        chosen = Some(*action);
                    }
                }
            });
        if let Some(action) = chosen {
            self.act(action, &ui.ctx().clone());
            return false;
        }
        true
    }

    fn recover(&mut self, ui: &mut Ui, path: &str) -> bool {
        ui.label("The studio ended before your last changes were saved. They were kept.");
        ui.horizontal(|ui| {
            if ui.button("Open them").clicked() {
                self.open(path);
                return false;
            }
            if ui.button("Discard them").clicked() {
                self.platform.keep(None);
                return false;
            }
            true
        })
        .inner
    }
}

/// The buttons of a dialog; whether it stays open.
pub(super) fn buttons(ui: &mut Ui, label: &str, enabled: bool, act: impl FnOnce()) -> bool {
    ui.add_space(6.0);
    let mut keep = true;
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        if ui.add_enabled(enabled, egui::Button::new(label)).clicked() {
            act();
            keep = false;
        }
        if ui.button("Cancel").clicked() {
            keep = false;
        }
    });
    keep
}

fn shortcuts(ui: &mut Ui) -> bool {
    egui::ScrollArea::vertical()
        .max_height(440.0)
        .show(ui, |ui| {
            Grid::new("keys")
                .num_columns(2)
                .striped(true)
                .show(ui, |ui| {
                    for (what, does) in MOUSE {
                        ui.label(what);
                        ui.label(does);
                        ui.end_row();
                    }
                    for (_, label, about, keys) in Action::ALL {
                        if keys.is_empty() {
                            continue;
                        }
                        let keys = keys.iter().map(|(m, k)| {
                            let shortcut = egui::KeyboardShortcut::new(*m, *k);
                            ui.ctx().format_shortcut(&shortcut)
                        });
                        let keys: Vec<String> = keys.collect();
                        ui.label(keys.join(", "));
                        ui.label(*label).on_hover_text(*about);
                        ui.end_row();
                    }
                });
        });
    !ui.button("Close").clicked()
}
