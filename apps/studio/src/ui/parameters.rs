//! The panel of parameters, made from their declarations: nothing here knows any parameter by more than its key.

use super::actions::Action;
use super::parameter_values::{Edit, value};
use super::studio::Studio;
use crate::model::breaks::PLACE;
use crate::model::units::ShownUnit;
use eframe::egui::{self, RichText, Ui};
use greenstick::schema::{Kind, ParameterInfo};

/// Groups that are open at first, by the headings of their declarations.
const OPEN: [&str; 3] = ["Where", "wood", "branch"];
/// The chapters of the panel and the groups in them, by the first words of their titles, in this order; the face's chapter also has
/// what no other has. What is changed most often comes first.
const CHAPTERS: [(&str, &[&str]); 7] = [
    ("The break", &["Where", "Wood", "Branch"]),
    (FACE, &["Face", "Fibrous face"]),
    (
        "Layers of the stem",
        &["Tissue", "Pith", "Heartwood", "Sapwood", "Phloem", "Bark"],
    ),
    (
        "Drying cracks",
        &[
            "All cracks",
            "Large cracks",
            "Medium cracks",
            "Small cracks",
        ],
    ),
    ("Rings", &["Annual rings", "Where rings"]),
    ("Look and output", &["Colours", "What comes out"]),
    ("The stem", &["Input", "Point clouds", "What it is"]),
];
const FACE: &str = "The broken face";
/// Tables whose names say little without the file that they stand in, and the titles of their groups.
const TITLES: [(&str, &str); 4] = [
    ("crack_groups", "All cracks"),
    ("crack_groups.large", "Large cracks"),
    ("crack_groups.medium", "Medium cracks"),
    ("crack_groups.small", "Small cracks"),
];
/// Groups that the window has other places for.
const ELSEWHERE: [&str; 1] = ["Picture"];
/// Keys that the window has other places for.
const ELSEWHERE_KEYS: [&str; 2] = ["input", "texture_size"];
/// Size of a chapter's title, points.
const CHAPTER: f32 = 11.5;
/// Width of a parameter's name.
const NAME_WIDTH: f32 = 128.0;

/// A group of parameters as the panel shows it.
struct Group {
    chapter: &'static str,
    title: String,
    open: bool,
    parameters: Vec<ParameterInfo>,
}

impl Studio {
    /// The panel on the right.
    pub(super) fn parameters(&mut self, ui: &mut Ui) {
        let panel = egui::Panel::right("parameters").default_size(348.0);
        panel.size_range(280.0..=560.0).show(ui, |ui| {
            ui.add_space(4.0);
            ui.horizontal(|ui| {
                let edit = egui::TextEdit::singleline(&mut self.search)
                    .hint_text("Search parameters")
                    .desired_width(ui.available_width() - 172.0);
                ui.add(edit);
                self.unit_choice(ui);
                if ui
                    .button("Randomise")
                    .on_hover_text(Action::Randomise.about())
                    .clicked()
                {
                    self.act(Action::Randomise, &ui.ctx().clone());
                }
            });
            self.breaks_bar(ui);
            ui.separator();
            let mut list = self.project.parameters();
            list.retain(|p| self.is_listed(p));
            let search = self.search.trim().to_lowercase();
            egui::ScrollArea::vertical()
                .auto_shrink([false, false])
                .show(ui, |ui| {
                    if search.is_empty() {
                        let mut chapter = "";
                        for group in grouped(list) {
                            if group.chapter != chapter {
                                chapter = group.chapter;
                                ui.add_space(6.0);
                                ui.label(RichText::new(chapter).size(CHAPTER).strong());
                            }
                            self.group(ui, group);
                        }
                    } else {
                        self.found(ui, list, &search);
                    }
                });
        });
    }

    /// The unit in which lengths are shown.
    fn unit_choice(&mut self, ui: &mut Ui) {
        let before = self.settings.unit;
        let combo = egui::ComboBox::from_id_salt("unit of length")
            .selected_text(before.symbol())
            .width(48.0);
        let shown = combo.show_ui(ui, |ui| {
            for unit in ShownUnit::ALL {
                ui.selectable_value(&mut self.settings.unit, unit, unit.symbol());
            }
        });
        let about = "The unit in which lengths are shown. Files keep metres.";
        shown.response.on_hover_text(about);
        if self.settings.unit != before {
            self.apply_settings(&ui.ctx().clone());
        }
    }

    fn is_listed(&self, p: &ParameterInfo) -> bool {
        // Several breaks have no place in common.
        let is_place = p.key == PLACE && self.project.break_count() > 1;
        let elsewhere = is_place && self.project.selected().is_none()
            || ELSEWHERE_KEYS.contains(&p.key.as_str());
        !elsewhere && !ELSEWHERE.contains(&p.group.as_str())
    }

    fn group(&mut self, ui: &mut Ui, group: Group) {
        let changed = group.parameters.iter().any(|p| p.value != p.default);
        let title = if changed {
            RichText::new(&group.title).strong()
        } else {
            RichText::new(&group.title)
        };
        egui::CollapsingHeader::new(title)
            .id_salt(&group.title)
            .default_open(group.open)
            .show(ui, |ui| {
                for p in &group.parameters {
                    self.parameter(ui, p, None);
                }
            });
    }

    fn found(&mut self, ui: &mut Ui, list: Vec<ParameterInfo>, search: &str) {
        let words: Vec<&str> = search.split_whitespace().collect();
        let matches = |p: &ParameterInfo| {
            let text = format!("{} {} {}", p.key.replace('_', " "), p.group, p.doc).to_lowercase();
            words.iter().all(|w| text.contains(w) || p.key.contains(w))
        };
        let mut found = 0;
        for p in list.iter().filter(|p| matches(p)) {
            let table = p.key.rsplit_once('.').map_or("", |k| k.0);
            self.parameter(ui, p, Some(table));
            found += 1;
        }
        if found == 0 {
            ui.label(format!(
                "No parameter's name or description contains \"{search}\"."
            ));
        }
    }

    /// One parameter: its name, its value and its lock. `table` is shown before the name.
    fn parameter(&mut self, ui: &mut Ui, p: &ParameterInfo, table: Option<&str>) {
        let mut edit = None;
        ui.horizontal(|ui| {
            let mut locked = self.project.locked.contains(&p.key);
            let about = if locked {
                "Locked: randomising leaves it alone."
            } else {
                "Lock it against randomising."
            };
            if lock(ui, locked).on_hover_text(about).clicked() {
                locked = !locked;
                if locked {
                    self.project.locked.insert(p.key.clone());
                } else {
                    self.project.locked.remove(&p.key);
                }
            }
            let name = shown_name(p, table);
            let text = if p.value == p.default {
                RichText::new(name)
            } else {
                RichText::new(name).strong()
            };
            let size = egui::vec2(NAME_WIDTH, ui.spacing().interact_size.y);
            let label = egui::Label::new(text)
                .truncate()
                .sense(egui::Sense::click());
            let layout = egui::Layout::left_to_right(egui::Align::Center);
            let response = ui.allocate_ui_with_layout(size, layout, |ui| {
                ui.set_min_width(NAME_WIDTH);
                ui.add(label)
            });
            let response = response.inner.on_hover_ui(|ui| about_parameter(ui, p));
            if response.double_clicked() && p.value != p.default {
                edit = Some(Edit::To(p.default.clone(), false));
            }
            if let Some(new) = value(ui, p, (response.id, self.settings.unit)) {
                edit = Some(new);
            }
        });
        let now = ui.input(|i| i.time);
        match edit {
            Some(Edit::To(value, drag)) => self.set(&p.key, &value, drag, now),
            Some(Edit::Rest) => self.rest(now),
            None => {}
        }
    }
}

/// A padlock, drawn, as fonts lack one.
fn lock(ui: &mut Ui, locked: bool) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(egui::vec2(12.0, 16.0), egui::Sense::click());
    let label = if locked { "Unlock" } else { "Lock" };
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, label));
    let color = if locked {
        ui.visuals().selection.stroke.color
    } else if response.hovered() {
        ui.visuals().text_color()
    } else {
        ui.visuals().weak_text_color().gamma_multiply(0.45)
    };
    let middle = rect.center();
    let body = egui::Rect::from_center_size(middle + egui::vec2(0.0, 2.0), egui::vec2(9.0, 6.0));
    ui.painter().rect_filled(body, 1.0, color);
    let lift = if locked { 0.0 } else { 2.0 };
    let shackle = [
        (-2.5, -1.0),
        (-2.5, -4.0),
        (0.0, -6.0),
        (2.5, -4.0),
        (2.5, -1.0 - lift),
    ];
    let points = shackle.map(|(x, y)| middle + egui::vec2(x, y)).to_vec();
    ui.painter()
        .add(egui::Shape::line(points, egui::Stroke::new(1.3, color)));
    response
}

/// The name of a parameter as people read it.
fn shown_name(p: &ParameterInfo, table: Option<&str>) -> String {
    let own = match p.key.rsplit('.').next().unwrap_or(&p.key) {
        // Not that of the stem, which is told in other places.
        "diameter" => "noise diameter".to_owned(),
        own => own.replace('_', " "),
    };
    let table = table.filter(|t| !t.is_empty() && *t != "break");
    let table = table.map(|t| t.trim_start_matches("break.").replace('_', " "));
    let name = match table {
        Some(table) => format!("{table}: {own}"),
        None => own,
    };
    let mut letters = name.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}

/// The groups of parameters, in the order of their declarations. What breaks most often is changed comes first.
fn grouped(list: Vec<ParameterInfo>) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for p in list {
        let table = p.key.rsplit_once('.').map_or("", |k| k.0);
        let table = table.trim_start_matches("break").trim_start_matches('.');
        let named = TITLES.iter().find(|t| t.0 == table);
        let title = if let Some((_, title)) = named {
            (*title).to_owned()
        } else if table.is_empty() {
            capital(&p.group)
        } else {
            let table = table.replace(['_', '.'], " ");
            let group = p.group.replace('_', " ");
            if group.is_empty() || table.ends_with(&group) {
                capital(&table)
            } else {
                format!("{}: {group}", capital(&table))
            }
        };
        match groups.iter_mut().find(|g| g.title == title) {
            Some(group) => group.parameters.push(p),
            None => groups.push(Group {
                chapter: chapter(&title),
                open: OPEN.contains(&p.group.as_str()) && table.is_empty(),
                title,
                parameters: vec![p],
            }),
        }
    }
    groups.sort_by_key(|g| CHAPTERS.iter().position(|c| c.0 == g.chapter));
    groups
}

/// The chapter of a group.
fn chapter(title: &str) -> &'static str {
    let named = CHAPTERS
        .iter()
        .flat_map(|c| c.1.iter().map(|words| (*words, c.0)));
    let fits = named.filter(|(words, _)| title.starts_with(words));
    // "Where" and "Where rings come from" are two groups.
    let longest = fits.max_by_key(|(words, _)| words.len());
    longest.map_or(FACE, |(_, chapter)| chapter)
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}

/// What a tooltip says of a parameter.
fn about_parameter(ui: &mut Ui, p: &ParameterInfo) {
    ui.set_max_width(360.0);
    ui.label(&p.doc);
    let range = p.kind.range();
    if !range.is_empty() {
        ui.label(format!("Takes {range}."));
    }
    if let Kind::Choice { options } = p.kind {
        for option in options {
            ui.label(format!("{}: {}", option.label(), option.doc));
        }
    }
    let default = p.show(&p.default);
    if !default.is_empty() {
        ui.label(format!(
            "Default: {default}. Double click on the name resets it."
        ));
    }
    ui.label(RichText::new(&p.key).monospace().weak());
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick::RequestFile;
    use greenstick::schema::Parameters;

    #[test]
    fn every_group_that_a_chapter_names_is_there_once_and_what_is_open_comes_first() {
        let groups = grouped(RequestFile::default().list());
        for (name, first) in CHAPTERS {
            for words in first {
                let found = groups.iter().filter(|g| g.title.starts_with(words));
                assert!(found.count() > 0, "{name}: {words}");
            }
        }
        let closed = groups.iter().position(|g| !g.open).unwrap();
        assert!(groups[closed..].iter().all(|g| !g.open));
    }
}
