//! The widgets that show the value of a parameter and change it: sliders, fields, boxes and lists.

use crate::model::breaks::PLACE;
use crate::model::units::ShownUnit;
use eframe::egui::{self, Slider, Ui};
use greenstick::schema::{Kind, ParameterInfo, Scale, Value};
use greenstick::wood::species::Species;

/// Widest range of a slider, as a ratio to the default's size: wider ones get a field to type in.
const WIDEST_RANGE: f64 = 1e4;
/// Width of a number with its unit.
const VALUE_WIDTH: f32 = 74.0;

/// What happened to a parameter's widget.
pub(super) enum Edit {
    /// It has a new value; whether the hand still moves.
    To(Value, bool),
    /// A drag ended.
    Rest,
}

/// The widgets of a parameter's value. They are labelled by the widget `name`, and lengths are shown in `unit`.
pub(super) fn value(
    ui: &mut Ui,
    p: &ParameterInfo,
    (name, unit): (egui::Id, ShownUnit),
) -> Option<Edit> {
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
    let other = match p.kind {
        Kind::Number { min, max, .. } => number(ui, shown, (min, max), (name, unit)),
        Kind::Integer { min, max, .. } => number(ui, shown, (min as f64, max as f64), (name, unit)),
        Kind::Flag => flag(ui, shown),
        Kind::Choice { options } => choice(ui, shown, options),
        Kind::Text { .. } | Kind::List { .. } => text(ui, shown, name),
    };
    other.or(edit)
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
