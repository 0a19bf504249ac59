//! The panel of parameters, made from their declarations: nothing here knows any parameter by more than its key.

use super::actions::Action;
use super::studio::Studio;
use crate::model::breaks::PLACE;
use crate::model::units::ShownUnit;
use eframe::egui::{self, RichText, Slider, Ui};
use greenstick::schema::{Kind, ParameterInfo, Scale, Value};
use greenstick::wood::species::Species;

/// Widest range of a slider, as a ratio to the default's size: wider ones get a field to type in.
const WIDEST_RANGE: f64 = 1e4;
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
    ("Drying cracks", &["Crack"]),
    ("Rings", &["Annual rings", "Where rings"]),
    ("Look and output", &["Colours", "What comes out"]),
    ("The stem", &["Input", "Point clouds", "What it is"]),
];
const FACE: &str = "The broken face";
/// Groups that the window has other places for.
const ELSEWHERE: [&str; 1] = ["Picture"];
/// Keys that the window has other places for.
const ELSEWHERE_KEYS: [&str; 2] = ["input", "texture_size"];
/// Width of a number with its unit.
const VALUE_WIDTH: f32 = 74.0;
/// Width of a parameter's name.
const NAME_WIDTH: f32 = 128.0;

/// What happened to a parameter's widget.
enum Edit {
    /// It has a new value; whether the hand still moves.
    To(Value, bool),
    /// A drag ended.
    Rest,
}

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
                                ui.label(RichText::new(chapter).small().weak());
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
            if let Some(new) = self.value(ui, p, response.id) {
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

    fn value(&mut self, ui: &mut Ui, p: &ParameterInfo, name: egui::Id) -> Option<Edit> {
        if p.key == "species" {
            return species(ui, p);
        }
        if p.key == PLACE {
            return place(ui, p, name);
        }
        let mut edit = None;
        let shown = p;
        if p.auto {
            let mut auto = p.value == Value::Auto;
            let response = ui
                .checkbox(&mut auto, "auto")
                .on_hover_text("Worked out by the program.");
            if response.changed() {
                let value = if auto { Value::Auto } else { first_value(p) };
                edit = Some(Edit::To(value, false));
            }
            if p.value == Value::Auto {
                return edit;
            }
        }
        let unit = self.settings.unit;
        let other = match p.kind {
            Kind::Number { min, max, .. } => number(ui, shown, (min, max), (name, unit)),
            Kind::Integer { min, max, .. } => {
                number(ui, shown, (min as f64, max as f64), (name, unit))
            }
            Kind::Flag => flag(ui, shown),
            Kind::Choice { options } => choice(ui, shown, options),
            Kind::Text { .. } | Kind::List { .. } => text(ui, shown, name),
        };
        other.or(edit)
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
    let own = p.key.rsplit('.').next().unwrap_or(&p.key).replace('_', " ");
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
        let title = if table.is_empty() {
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

/// The value that a parameter has when "auto" is taken off.
fn first_value(p: &ParameterInfo) -> Value {
    match (p.kind, &p.default) {
        (_, value) if *value != Value::Auto => value.clone(),
        (Kind::Number { min, max, .. }, _) if p.key == "moisture" => {
            Value::Number(12.0f64.clamp(min, max))
        }
        (Kind::Number { min, max, .. }, _) => {
            let high = if max < 1e3 { max } else { min + 1.0 };
            Value::Number(0.5 * (min + high))
        }
        (Kind::Integer { min, max, .. }, _) => Value::Integer(20.clamp(min, max)),
        (Kind::Flag, _) => Value::Flag(true),
        (Kind::Choice { options }, _) => {
            Value::Text(options.first().map_or("", |o| o.word).to_owned())
        }
        (Kind::Text { .. } | Kind::List { .. }, _) => Value::Text(String::new()),
    }
}

/// The unit of a number and the factor from its value: lengths are shown in the unit that was chosen.
fn display_unit(p: &ParameterInfo, unit: ShownUnit) -> (&'static str, f64) {
    match ShownUnit::from_symbol(p.unit()) {
        Some(own) => (unit.symbol(), unit.per_metre() / own.per_metre()),
        None => (p.unit(), 1.0),
    }
}

fn number(
    ui: &mut Ui,
    p: &ParameterInfo,
    (min, max): (f64, f64),
    (name, unit): (egui::Id, ShownUnit),
) -> Option<Edit> {
    let whole = matches!(p.kind, Kind::Integer { .. });
    let before = match p.value {
        Value::Number(x) => x,
        Value::Integer(n) => n as f64,
        _ => return text(ui, p, name),
    };
    let (unit, factor) = display_unit(p, unit);
    let suffix = match unit {
        "" => String::new(),
        "°" | "%" => unit.to_owned(),
        unit => format!(" {unit}"),
    };
    let mut shown = before * factor;
    let default = match p.default {
        Value::Number(x) => x,
        Value::Integer(n) => n as f64,
        _ => before,
    };
    let wide = max - min > WIDEST_RANGE.max(WIDEST_RANGE * default.abs());
    // Of fixed sizes, or the panel would grow with what is in it.
    let height = ui.spacing().interact_size.y;
    let slider_width = ui.available_width() - VALUE_WIDTH - 2.0 * ui.spacing().item_spacing.x;
    let range = min * factor..=max * factor;
    let slider = (!wide && slider_width > 40.0).then(|| {
        ui.spacing_mut().slider_width = slider_width;
        // A range that begins at 0 and whose usual values lie near it is divided by factors as well.
        let low = min >= 0.0 && default > 0.0 && default < 0.06 * max;
        let slider = Slider::new(&mut shown, range.clone())
            .logarithmic(p.scale == Scale::Logarithmic || low)
            .smallest_positive(1e-3)
            .show_value(false);
        ui.add(if whole { slider.integer() } else { slider })
            .labelled_by(name)
    });
    let speed = if whole {
        1.0
    } else {
        (0.01 * shown.abs()).max(0.01)
    };
    let field = egui::DragValue::new(&mut shown)
        .range(range)
        .speed(speed)
        .suffix(suffix);
    let field = if whole {
        field.fixed_decimals(0)
    } else {
        field.max_decimals(3)
    };
    let field = ui.add_sized([VALUE_WIDTH, height], field).labelled_by(name);
    let response = match slider {
        Some(slider) => slider.union(field),
        None => field,
    };
    let reset = ui.input(|i| {
        i.pointer
            .button_double_clicked(egui::PointerButton::Primary)
    }) && response.contains_pointer()
        && !response.has_focus();
    if reset && p.value != p.default {
        return Some(Edit::To(p.default.clone(), false));
    }
    if shown != before * factor {
        let value = (shown / factor).clamp(min, max);
        let dragged = response.dragged();
        let value = match p.kind {
            Kind::Integer { step, .. } => {
                Value::Integer((value / step as f64).round() as i128 * step)
            }
            _ => Value::Number(value),
        };
        return Some(Edit::To(value, dragged));
    }
    response.drag_stopped().then_some(Edit::Rest)
}

fn flag(ui: &mut Ui, p: &ParameterInfo) -> Option<Edit> {
    let mut on = p.value == Value::Flag(true);
    let changed = ui.checkbox(&mut on, "").changed();
    changed.then_some(Edit::To(Value::Flag(on), false))
}

fn choice(
    ui: &mut Ui,
    p: &ParameterInfo,
    options: &'static [greenstick::schema::Choice],
) -> Option<Edit> {
    let word = p.value.to_string();
    let label = options.iter().find(|o| o.word == word);
    let label = label.map_or(word.clone(), greenstick::schema::Choice::label);
    let mut chosen = None;
    egui::ComboBox::from_id_salt(&p.key)
        .selected_text(label)
        .show_ui(ui, |ui| {
            for option in options {
                let response = ui.selectable_label(option.word == word, option.label());
                if response.on_hover_text(option.doc).clicked() {
                    chosen = Some(Edit::To(Value::Text(option.word.to_owned()), false));
                }
            }
        });
    chosen
}

/// A text, which counts when it is finished.
fn text(ui: &mut Ui, p: &ParameterInfo, name: egui::Id) -> Option<Edit> {
    let id = ui.make_persistent_id(("text", &p.key));
    let held: Option<String> = ui.data(|d| d.get_temp(id));
    let mut text = held.clone().unwrap_or_else(|| p.value.to_string());
    let width = (ui.available_width() - 2.0 * ui.spacing().item_spacing.x).max(60.0);
    let response = ui.add(egui::TextEdit::singleline(&mut text).desired_width(width));
    let response = response.labelled_by(name);
    if response.changed() {
        ui.data_mut(|d| d.insert_temp(id, text.clone()));
    }
    if response.lost_focus() {
        ui.data_mut(|d| d.remove::<String>(id));
        if held.is_some() && text != p.value.to_string() {
            return Some(Edit::To(Value::Text(text), false));
        }
    }
    None
}

/// A place: a slider along the stem where it is a fraction, and a text, as it may be a length or a point.
fn place(ui: &mut Ui, p: &ParameterInfo, name: egui::Id) -> Option<Edit> {
    let Ok(before) = p.value.to_string().parse::<f64>() else {
        return text(ui, p, name);
    };
    let mut fraction = before;
    let spacing = 2.0 * ui.spacing().item_spacing.x;
    ui.spacing_mut().slider_width = (ui.available_width() - VALUE_WIDTH - spacing).max(40.0);
    let slider = Slider::new(&mut fraction, 0.0..=1.0).show_value(false);
    let slider = ui.add(slider).labelled_by(name);
    let height = ui.spacing().interact_size.y;
    let field = egui::DragValue::new(&mut fraction)
        .range(0.0..=1.0)
        .speed(0.002)
        .fixed_decimals(3);
    let response = slider.union(ui.add_sized([VALUE_WIDTH, height], field).labelled_by(name));
    if fraction != before {
        let value = Value::Text(fraction.to_string());
        return Some(Edit::To(value, response.dragged()));
    }
    response.drag_stopped().then_some(Edit::Rest)
}

/// The species, with a search among their names.
fn species(ui: &mut Ui, p: &ParameterInfo) -> Option<Edit> {
    let id = ui.make_persistent_id("species search");
    let present = match &p.value {
        Value::Text(name) => name.clone(),
        _ => "any (softwood)".to_owned(),
    };
    let mut chosen = None;
    egui::ComboBox::from_id_salt("species")
        .selected_text(present.clone())
        .width(ui.available_width() - 24.0)
        .height(320.0)
        .close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside)
        .show_ui(ui, |ui| {
            let mut search: String = ui.data(|d| d.get_temp(id)).unwrap_or_default();
            let edit = egui::TextEdit::singleline(&mut search).hint_text("Search species");
            if ui.add(edit).changed() {
                ui.data_mut(|d| d.insert_temp(id, search.clone()));
            }
            let wanted = search.to_lowercase();
            if ui
                .selectable_label(p.value == Value::Auto, "any (softwood)")
                .clicked()
            {
                chosen = Some(Edit::To(Value::Auto, false));
                ui.close();
            }
            for species in Species::all() {
                let names = format!("{} {}", species.name, species.scientific_name);
                if !names.to_lowercase().contains(&wanted) {
                    continue;
                }
                let response = ui.selectable_label(present == species.name, &species.name);
                if response.on_hover_text(&species.scientific_name).clicked() {
                    let name = species.name.to_string();
                    chosen = Some(Edit::To(Value::Text(name), false));
                    ui.close();
                }
            }
        });
    chosen
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
