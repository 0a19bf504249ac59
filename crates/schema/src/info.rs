//! Everything that is known of a parameter, and reading values by it.

use crate::declaration::words;
use crate::value::AUTO;
use crate::{Kind, ParameterError, Scale, Unit, Value};
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};
use serde_json::json;

/// Everything that is known of one parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterInfo {
    /// Key in files and settings; groups are joined by dots: `sapwood.perlin_amplitude`.
    pub key: String,
    /// Symbol in its source, with its subscript after `_`; empty where there is none.
    pub symbol: String,
    /// Heading it is listed under.
    pub group: String,
    /// What it does.
    pub doc: String,
    /// Values it takes.
    pub kind: Kind,
    /// Whether the word "auto" may stand for a value that is worked out.
    pub auto: bool,
    /// Words that stand for numbers.
    pub words: &'static [(&'static str, f64)],
    /// How a slider divides its range.
    pub scale: Scale,
    /// The stage of the work that it changes first.
    pub stage: &'static str,
    /// Its default.
    pub default: Value,
    /// Its value in the set that it was listed from.
    pub value: Value,
}

/// A list of tables of parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct ListInfo {
    /// Its key: that of `[[clamp]]` is `clamp`.
    pub key: &'static str,
    /// What its entries are.
    pub doc: String,
}

impl ParameterInfo {
    /// Symbol of the unit; empty where there is none.
    pub fn unit(&self) -> &'static str {
        self.kind.unit().symbol()
    }

    /// Least value; `None` for what is no number.
    pub fn min(&self) -> Option<f64> {
        match self.kind {
            Kind::Number { min, .. } => Some(min),
            Kind::Integer { min, .. } => Some(min as f64),
            _ => None,
        }
    }

    /// Greatest value; `None` for what is no number.
    pub fn max(&self) -> Option<f64> {
        match self.kind {
            Kind::Number { max, .. } => Some(max),
            Kind::Integer { max, .. } => Some(max as f64),
            _ => None,
        }
    }

    /// `value` as this parameter holds it: numbers in range and finite, text with a unit read, choices known.
    ///
    /// # Errors
    /// [`ParameterError`] saying the key, what was found and what it may be.
    pub fn read(&self, value: &Value) -> Result<Value, ParameterError> {
        match value {
            Value::Auto if self.auto => return Ok(Value::Auto),
            Value::Text(word) if self.auto && word.trim() == AUTO => return Ok(Value::Auto),
            Value::Text(word) => {
                let word = word.trim();
                let named = self.words.iter().find(|w| w.0.eq_ignore_ascii_case(word));
                if let Some((_, number)) = named {
                    return Ok(Value::Number(*number));
                }
            }
            _ => {}
        }
        read(&self.key, &self.kind, value)
    }

    /// A value near its own and other than it, where its kind has one: what tests and benches change it to. `None` for
    /// texts and for lists of none.
    pub fn neighbour(&self) -> Option<Value> {
        neighbour(&self.kind, &self.value)
    }

    /// A value as people read it, with its unit: lengths in the unit that suits them.
    pub fn show(&self, value: &Value) -> String {
        let symbol = self.unit();
        match (self.kind, value) {
            (
                Kind::Number {
                    unit: Unit::Metre, ..
                },
                Value::Number(x),
            ) => show_length(*x),
            (_, Value::Number(_) | Value::Integer(_)) if !symbol.is_empty() => {
                let space = if matches!(symbol, "°" | "%") {
                    ""
                } else {
                    " "
                };
                format!("{value}{space}{symbol}")
            }
            _ => value.to_string(),
        }
    }
}

/// Metres in the unit that suits them.
fn show_length(metres: f64) -> String {
    let size = metres.abs();
    if metres == 0.0 {
        "0".to_owned()
    } else if size < 0.01 {
        format!("{} mm", rounded(metres * 1000.0))
    } else if size < 1.0 {
        format!("{} cm", rounded(metres * 100.0))
    } else {
        format!("{metres} m")
    }
}

/// Without the last bits that a change of unit adds.
fn rounded(x: f64) -> f64 {
    const DIGITS: f64 = 1e9;
    (x * DIGITS).round() / DIGITS
}

/// Reads a value of a kind.
fn read(key: &str, kind: &Kind, value: &Value) -> Result<Value, ParameterError> {
    match *kind {
        Kind::Number { unit, .. } => read_number(key, kind, unit, value),
        Kind::Integer { .. } => read_whole(key, kind, value),
        Kind::Flag => match value {
            Value::Flag(_) => Ok(value.clone()),
            Value::Text(word) if word.trim() == "true" => Ok(Value::Flag(true)),
            Value::Text(word) if word.trim() == "false" => Ok(Value::Flag(false)),
            _ => Err(other(key, value, "true or false")),
        },
        Kind::Choice { options } => {
            let found = value.to_string().trim().to_lowercase();
            let is_known = options.iter().any(|o| o.word == found);
            if matches!(value, Value::Text(_)) && is_known {
                return Ok(Value::Text(found));
            }
            Err(ParameterError::Choice {
                key: key.to_owned(),
                found,
                options: words(options),
            })
        }
        Kind::Text { format } => {
            let text = match value {
                Value::Text(text) => text.clone(),
                // A place may be written as the number that it is.
                Value::Number(_) | Value::Integer(_) => value.to_string(),
                _ => return Err(other(key, value, "a word in quotes")),
            };
            (format.check)(&text).map_err(|problem| ParameterError::Format {
                key: key.to_owned(),
                problem,
            })?;
            Ok(Value::Text(text))
        }
        Kind::List { of, min, max } => read_list(key, kind, (of, min, max), value),
    }
}

fn read_number(key: &str, kind: &Kind, unit: Unit, value: &Value) -> Result<Value, ParameterError> {
    let x = match value {
        Value::Number(x) => *x,
        Value::Integer(n) => *n as f64,
        Value::Text(text) => unit.parse(key, text)?,
        _ => return Err(other(key, value, "a number")),
    };
    let Kind::Number {
        min, max, above, ..
    } = *kind
    else {
        return Ok(Value::Number(x));
    };
    // NaN fails this too.
    if (min..=max).contains(&x) && !(above && x == min) {
        return Ok(Value::Number(x));
    }
    Err(ParameterError::OutOfRange {
        key: key.to_owned(),
        found: x,
        range: kind.range(),
    })
}

fn read_whole(key: &str, kind: &Kind, value: &Value) -> Result<Value, ParameterError> {
    let Kind::Integer {
        unit,
        min,
        max,
        step,
    } = *kind
    else {
        return Err(other(key, value, &kind.range()));
    };
    let n = match value {
        Value::Integer(n) => Some(*n),
        Value::Text(text) => match text.trim().parse() {
            Ok(n) => Some(n),
            Err(_) if unit != Unit::One => whole(unit.parse(key, text)?),
            Err(_) => None,
        },
        Value::Number(x) => whole(*x),
        _ => None,
    };
    let n = n.filter(|n| (min..=max).contains(n) && n % step == 0);
    n.map(Value::Integer).ok_or_else(|| ParameterError::Whole {
        key: key.to_owned(),
        found: value.to_string(),
        range: kind.range(),
    })
}

fn neighbour(kind: &Kind, value: &Value) -> Option<Value> {
    const STEP: f64 = 0.013;
    match (kind, value) {
        (Kind::Number { min, max, .. }, Value::Number(x)) => {
            let step = STEP * (max - min).min(x.abs().max(1.0));
            let above = x + step;
            Some(Value::Number(if above <= *max { above } else { x - step }))
        }
        (Kind::Number { max, .. }, _) => Some(Value::Number(max / 2.0)),
        (Kind::Integer { max, step, .. }, Value::Integer(n)) if n < max => {
            Some(Value::Integer(n + step))
        }
        (Kind::Integer { step, .. }, Value::Integer(n)) => Some(Value::Integer(n - step)),
        (Kind::Integer { min, .. }, _) => Some(Value::Integer(*min)),
        (Kind::Flag, value) => Some(Value::Flag(*value != Value::Flag(true))),
        (Kind::Choice { options }, value) => {
            let words = options.iter().map(|o| Value::Text(o.word.to_owned()));
            words.into_iter().find(|word| word != value)
        }
        (Kind::List { of, .. }, Value::List(list)) if !list.is_empty() => {
            let each = list.iter().map(|value| neighbour(of, value));
            each.collect::<Option<Vec<Value>>>().map(Value::List)
        }
        (Kind::Text { .. } | Kind::List { .. }, _) => None,
    }
}

/// Languages with one kind of number send 20.0 for 20.
fn whole(x: f64) -> Option<i128> {
    let n = x as i128;
    (n as f64 == x && n.unsigned_abs() <= 1 << 53).then_some(n)
}

fn read_list(
    key: &str,
    kind: &Kind,
    (of, min, max): (&'static Kind, usize, usize),
    value: &Value,
) -> Result<Value, ParameterError> {
    let parts = match (value, of) {
        (Value::List(list), _) => list.clone(),
        (Value::Text(text), Kind::Number { unit, .. }) => {
            let numbers = unit.parse_all(key, text)?;
            numbers.into_iter().map(Value::Number).collect()
        }
        (Value::Text(text), _) if text.trim().is_empty() => Vec::new(),
        (Value::Text(text), _) => text.split(',').map(Value::from).collect(),
        (Value::Number(_) | Value::Integer(_), _) => vec![value.clone()],
        _ => return Err(other(key, value, &kind.range())),
    };
    if !(min..=max).contains(&parts.len()) {
        return Err(other(key, value, &kind.range()));
    }
    let read: Result<_, _> = parts.iter().map(|part| read(key, of, part)).collect();
    read.map(Value::List)
}

fn other(key: &str, value: &Value, expected: &str) -> ParameterError {
    let found = match value {
        Value::Text(text) => format!("\"{text}\""),
        Value::List(_) => format!("[{value}]"),
        _ => value.to_string(),
    };
    ParameterError::Kind {
        key: key.to_owned(),
        found,
        expected: expected.to_owned(),
    }
}

/// The name of a unit in JSON; none for [`Unit::One`].
fn unit_name(unit: Unit) -> serde_json::Value {
    serde_json::to_value(unit).unwrap_or_default()
}

impl Serialize for Kind {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let value = match self {
            Kind::Number {
                unit,
                min,
                max,
                above,
            } => {
                let mut number = json!({ "unit": unit_name(*unit), "min": min, "max": max });
                if *above {
                    number["above"] = json!(true);
                }
                json!({ "number": number })
            }
            Kind::Integer {
                unit,
                min,
                max,
                step,
            } => {
                let bound = |n: i128| i64::try_from(n).map_or(json!(n as f64), |n| json!(n));
                let mut integer = json!({ "min": bound(*min), "max": bound(*max) });
                if *step != 1 {
                    integer["step"] = bound(*step);
                }
                if *unit != Unit::One {
                    integer["unit"] = unit_name(*unit);
                }
                json!({ "integer": integer })
            }
            Kind::Flag => json!("flag"),
            Kind::Choice { options } => {
                let words: Vec<_> = options.iter().map(|o| o.word).collect();
                let labels: Vec<_> = options.iter().map(|o| o.label()).collect();
                let docs: Vec<_> = options.iter().map(|o| o.doc).collect();
                json!({ "choice": { "options": words, "labels": labels, "docs": docs } })
            }
            Kind::Text { format } => json!({ "text": { "format": format.name } }),
            Kind::List { of, min, max } => {
                json!({ "list": { "of": of, "min": min, "max": max } })
            }
        };
        value.serialize(to)
    }
}

impl Serialize for ParameterInfo {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut object = to.serialize_struct("ParameterInfo", 10)?;
        object.serialize_field("key", &self.key)?;
        object.serialize_field("symbol", &self.symbol)?;
        object.serialize_field("group", &self.group)?;
        object.serialize_field("doc", &self.doc)?;
        object.serialize_field("kind", &self.kind)?;
        object.serialize_field("auto", &self.auto)?;
        object.serialize_field("logarithmic", &(self.scale == Scale::Logarithmic))?;
        object.serialize_field("stage", self.stage)?;
        object.serialize_field("default", &self.default)?;
        object.serialize_field("value", &self.value)?;
        object.end()
    }
}
