//! What varies: the values of one key.

use crate::error::SweepError;
use crate::keys;
use greenstick::schema::{Kind, ParameterInfo, Parameters, Scale, Value};
use toml::Value as Toml;

/// Most values of one key.
const MAX_VALUES: u64 = 1 << 32;
/// Most values of one key that are made by steps, each of which is kept.
const MAX_STEPS: u64 = 1 << 20;

/// How a key's values come about.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// One after the other; every one is combined with every one of other keys.
    Listed(Vec<Value>),
    /// Whole numbers from one on, at a distance, and how many; combined likewise.
    Whole {
        /// The first.
        from: i128,
        /// The distance.
        by: i128,
        /// How many.
        count: u64,
    },
    /// Drawn between two numbers, anew for every sample.
    Drawn {
        /// The least.
        low: f64,
        /// The greatest.
        high: f64,
        /// Whether ratios count rather than differences.
        logarithmic: bool,
        /// Whether they are whole.
        whole: bool,
    },
}

/// A key and its values.
#[derive(Debug, Clone)]
pub struct Axis {
    /// The parameter.
    pub info: ParameterInfo,
    /// Its values.
    pub values: Values,
}

impl Axis {
    /// Reads what `[vary]` says of a key.
    ///
    /// # Errors
    /// [`SweepError::Vary`]: an unknown key, with the nearest; values that the key does not take.
    pub fn read(base: &dyn Parameters, key: &str, value: &Toml) -> Result<Self, SweepError> {
        let wrong = |problem: String| SweepError::Vary {
            key: key.to_owned(),
            problem,
        };
        let info = keys::find(base, key).map_err(|e| wrong(e.to_string()))?;
        let values = match value {
            Toml::Array(list) if list.is_empty() => {
                Err("the list is empty; expected values".to_owned())
            }
            Toml::Array(list) => list
                .iter()
                .map(|item| read(&info, item))
                .collect::<Result<_, _>>()
                .map(Values::Listed),
            Toml::Table(table) => range(&info, table),
            _ => Err(format!(
                "found {value}; expected a list of values, {{ from = A, to = B, steps = N }} or {{ between = [A, B] }}"
            )),
        };
        Ok(Axis {
            values: values.map_err(wrong)?,
            info,
        })
    }

    /// How many values are combined with those of other keys; one where they are drawn.
    pub fn count(&self) -> u64 {
        match &self.values {
            Values::Listed(list) => list.len() as u64,
            Values::Whole { count, .. } => *count,
            Values::Drawn { .. } => 1,
        }
    }

    /// Whether its values are drawn.
    pub fn is_drawn(&self) -> bool {
        matches!(self.values, Values::Drawn { .. })
    }

    /// Whether all its values are whole numbers from 0 that 32 bits hold.
    pub fn is_small(&self) -> bool {
        let fits = |n: i128| u32::try_from(n).is_ok();
        match &self.values {
            Values::Listed(list) => list
                .iter()
                .all(|value| matches!(value, Value::Integer(n) if fits(*n))),
            Values::Whole { from, by, count } => {
                fits(*from) && fits(from + by * (i128::from(*count) - 1))
            }
            Values::Drawn {
                low, high, whole, ..
            } => *whole && fits(*low as i128) && fits(*high as i128),
        }
    }

    /// The value of a place among those that are combined, or, where values are drawn, at `drawn`, 0 to below 1.
    pub fn value(&self, place: u64, drawn: f64) -> Value {
        match &self.values {
            Values::Listed(list) => list[place as usize].clone(),
            Values::Whole { from, by, .. } => Value::Integer(from + by * i128::from(place)),
            Values::Drawn {
                low,
                high,
                logarithmic,
                whole,
            } => {
                // Every whole number has the same share.
                let high = if *whole { high + 1.0 } else { *high };
                let x = between(*low, high, drawn, *logarithmic && !whole);
                if *whole {
                    Value::Integer(x.floor() as i128)
                } else {
                    Value::Number(x)
                }
            }
        }
    }
}

/// A number at a fraction of the way between two.
fn between(low: f64, high: f64, fraction: f64, logarithmic: bool) -> f64 {
    if logarithmic {
        low * libm::pow(high / low, fraction)
    } else {
        low + (high - low) * fraction
    }
}

/// Reads a value of a parameter.
fn read(info: &ParameterInfo, value: &Toml) -> Result<Value, String> {
    let plain = match value {
        Toml::String(text) => Value::Text(text.clone()),
        Toml::Integer(n) => Value::Integer((*n).into()),
        Toml::Float(x) => Value::Number(*x),
        Toml::Boolean(b) => Value::Flag(*b),
        Toml::Array(list) => {
            let numbers = list.iter().map(|item| match item {
                Toml::Integer(n) => Ok(Value::Integer((*n).into())),
                Toml::Float(x) => Ok(Value::Number(*x)),
                Toml::String(text) => Ok(Value::Text(text.clone())),
                other => Err(format!(
                    "found {other} in a list; expected numbers or texts"
                )),
            });
            Value::List(numbers.collect::<Result<_, _>>()?)
        }
        other => return Err(format!("found {other}; expected a value of the key")),
    };
    info.read(&plain).map_err(|e| e.to_string())
}

/// Reads a number of a parameter.
fn number(info: &ParameterInfo, key: &str, value: &Toml) -> Result<f64, String> {
    match read(info, value)? {
        Value::Number(x) => Ok(x),
        Value::Integer(n) => Ok(n as f64),
        other => Err(format!("{key} is {other}; expected a number")),
    }
}

/// Reads `{ from, to, steps }`, `{ from, to, by }` or `{ between, scale }`.
fn range(info: &ParameterInfo, table: &toml::Table) -> Result<Values, String> {
    const KNOWN: [&str; 6] = ["from", "to", "steps", "by", "between", "scale"];
    if let Some(other) = table.keys().find(|k| !KNOWN.contains(&k.as_str())) {
        return Err(format!(
            "unknown word \"{other}\"; expected {}",
            KNOWN.join(", ")
        ));
    }
    let whole = match info.kind {
        Kind::Integer { .. } => true,
        Kind::Number { .. } => false,
        _ => return Err("it takes no numbers; expected a list of values".to_owned()),
    };
    let logarithmic = match table.get("scale").map(|s| s.as_str()) {
        None => info.scale == Scale::Logarithmic,
        Some(Some("logarithmic")) => true,
        Some(Some("linear")) => false,
        Some(_) => return Err("scale must be \"linear\" or \"logarithmic\"".to_owned()),
    };
    let (low, high) = match (table.get("between"), table.get("from"), table.get("to")) {
        (Some(Toml::Array(two)), None, None) if two.len() == 2 => (&two[0], &two[1]),
        (None, Some(from), Some(to)) => (from, to),
        _ => return Err("expected from and to, or between = [A, B]".to_owned()),
    };
    let (low, high) = (number(info, "from", low)?, number(info, "to", high)?);
    if low > high {
        return Err(format!(
            "{low} is above {high}; expected the lower one first"
        ));
    }
    // A range that touches 0 has no ratios.
    let logarithmic = logarithmic && low > 0.0;
    if table.contains_key("between") {
        if let Some(other) = ["steps", "by"].iter().find(|k| table.contains_key(**k)) {
            return Err(format!("values between two are drawn and take no {other}"));
        }
        return Ok(Values::Drawn {
            low,
            high,
            logarithmic,
            whole,
        });
    }
    stepped((low, high), table, (whole, logarithmic))
}

/// The values from one to another in steps.
fn stepped(
    (low, high): (f64, f64),
    table: &toml::Table,
    (whole, logarithmic): (bool, bool),
) -> Result<Values, String> {
    let count = |key: &str, least: i64, most: u64| match table.get(key) {
        None => Ok(None),
        Some(Toml::Integer(n)) if (least..=most as i64).contains(n) => Ok(Some(*n)),
        Some(other) => Err(format!(
            "{key} is {other}; expected a whole number from {least} to {most}"
        )),
    };
    match (count("steps", 2, MAX_STEPS)?, count("by", 1, MAX_VALUES)?) {
        (Some(_), Some(_)) => Err("steps and by exclude each other".to_owned()),
        (Some(steps), None) => {
            let value = |k: i64| {
                let x = match k {
                    0 => low,
                    k if k == steps - 1 => high,
                    k => between(low, high, k as f64 / (steps - 1) as f64, logarithmic),
                };
                if whole {
                    Value::Integer(x.round() as i128)
                } else {
                    Value::Number(x)
                }
            };
            let mut values: Vec<Value> = (0..steps).map(value).collect();
            values.dedup();
            Ok(Values::Listed(values))
        }
        (None, by) if whole => {
            let by = i128::from(by.unwrap_or(1));
            let (from, to) = (low as i128, high as i128);
            let count = ((to - from) / by + 1) as u64;
            if count > MAX_VALUES {
                return Err(format!(
                    "it has {count} values; expected {MAX_VALUES} at most"
                ));
            }
            Ok(Values::Whole { from, by, count })
        }
        _ => Err("expected steps, the number of values from one to the other".to_owned()),
    }
}
