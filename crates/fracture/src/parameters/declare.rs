//! How a parameter is declared: once, with its key, symbol, documentation, unit, range and default.
//! Struct field, default, check, text and TOML reading, listing, schema and reference page all come
//! from that declaration.

use super::value::{ParameterError, parse_number, parse_whole};
use greenstick_wood::spelling::closest_names;
use serde::{Deserialize, Serialize};

/// The unit a number is held in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Unit {
    /// A ratio to the stem's radius.
    Radius,
    /// A part of a whole, 0 to 1.
    Fraction,
    /// Centimetres.
    Centimetre,
    /// Degrees.
    Degree,
    /// Degrees per height of one radius.
    DegreePerRadius,
    /// Cycles per metre.
    PerMetre,
    /// No unit.
    One,
}

impl Unit {
    /// Symbol as written after a number; empty for [`Unit::One`] and [`Unit::Fraction`].
    pub const fn symbol(self) -> &'static str {
        match self {
            Unit::Radius => "radius",
            Unit::Fraction | Unit::One => "",
            Unit::Centimetre => "cm",
            Unit::Degree => "°",
            Unit::DegreePerRadius => "°/radius",
            Unit::PerMetre => "1/m",
        }
    }
}

/// What values a parameter takes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// A real number from `min` to `max`, both included.
    Number {
        /// Its unit.
        unit: Unit,
        /// Least value.
        min: f64,
        /// Greatest value.
        max: f64,
        /// Whether the word "auto" may stand for a value that is worked out.
        auto: bool,
    },
    /// A whole number from `min` to `max`, both included.
    Integer {
        /// Least value.
        min: u64,
        /// Greatest value.
        max: u64,
    },
    /// One of a few words.
    Choice {
        /// The words.
        options: &'static [&'static str],
    },
}

/// [`Kind::Number`] for a declaration.
pub(crate) const fn number(unit: Unit, min: f64, max: f64) -> Kind {
    Kind::Number {
        unit,
        min,
        max,
        auto: false,
    }
}

/// [`Kind::Number`] that may be "auto".
pub(crate) const fn auto(unit: Unit, min: f64, max: f64) -> Kind {
    Kind::Number {
        unit,
        min,
        max,
        auto: true,
    }
}

/// [`Kind::Integer`] for a declaration.
pub(crate) const fn count(min: u64, max: u64) -> Kind {
    Kind::Integer { min, max }
}

/// [`Kind::Choice`] for a declaration.
pub(crate) const fn choice(options: &'static [&'static str]) -> Kind {
    Kind::Choice { options }
}

/// The value of some parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Value {
    /// A real number in the parameter's unit.
    Number(f64),
    /// A whole number.
    Integer(u64),
    /// A choice, "auto", or a number with its unit that is still to be read.
    Text(String),
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Value::Number(x) => write!(f, "{x}"),
            Value::Integer(n) => write!(f, "{n}"),
            Value::Text(t) => f.write_str(t),
        }
    }
}

/// Everything that is known of one parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterInfo {
    /// Key in recipes and settings; groups are joined by dots: `sapwood.perlin_amplitude`.
    pub key: String,
    /// Symbol in Yang 2019, with its subscript after `_`; empty where the paper has none.
    pub symbol: String,
    /// Heading it is listed under.
    pub group: String,
    /// What it does.
    pub doc: String,
    /// Values it takes.
    pub kind: Kind,
    /// Its default, or its value where it was listed from a changed set.
    pub value: Value,
}

impl ParameterInfo {
    /// Symbol of the unit; empty where there is none.
    pub fn unit(&self) -> &'static str {
        match self.kind {
            Kind::Number { unit, .. } => unit.symbol(),
            _ => "",
        }
    }

    /// Least value; `None` for choices.
    pub fn min(&self) -> Option<f64> {
        match self.kind {
            Kind::Number { min, .. } => Some(min),
            Kind::Integer { min, .. } => Some(min as f64),
            Kind::Choice { .. } => None,
        }
    }

    /// Greatest value; `None` for choices.
    pub fn max(&self) -> Option<f64> {
        match self.kind {
            Kind::Number { max, .. } => Some(max),
            Kind::Integer { max, .. } => Some(max as f64),
            Kind::Choice { .. } => None,
        }
    }

    /// `value` as this parameter holds it: numbers in range and finite, text with a unit read,
    /// choices known.
    ///
    /// # Errors
    /// [`ParameterError`] saying the key, what was found and what it may be.
    pub fn read(&self, value: &Value) -> Result<Value, ParameterError> {
        let key = || self.key.clone();
        match (&self.kind, value) {
            (Kind::Choice { options }, Value::Text(word)) => {
                let word = word.trim().to_lowercase();
                if options.contains(&word.as_str()) {
                    return Ok(Value::Text(word));
                }
                let found = word;
                Err(ParameterError::Choice {
                    key: key(),
                    found,
                    options: options.join(", "),
                })
            }
            (Kind::Choice { options }, other) => Err(ParameterError::Choice {
                key: key(),
                found: other.to_string(),
                options: options.join(", "),
            }),
            (Kind::Integer { min, max }, value) => {
                let n = match value {
                    Value::Integer(n) => Some(*n),
                    Value::Text(text) => parse_whole(text),
                    // Languages with one kind of number send 20.0 for 20.
                    Value::Number(x) => Some(*x as u64).filter(|n| *n as f64 == *x),
                };
                let whole = ParameterError::Whole {
                    key: key(),
                    found: value.to_string(),
                    min: *min,
                    max: *max,
                };
                n.filter(|n| (min..=max).contains(&n))
                    .map(Value::Integer)
                    .ok_or(whole)
            }
            (Kind::Number { auto: true, .. }, Value::Text(word)) if word.trim() == "auto" => {
                Ok(Value::Text("auto".to_owned()))
            }
            (Kind::Number { unit, min, max, .. }, value) => {
                let x = match value {
                    Value::Number(x) => *x,
                    Value::Integer(n) => *n as f64,
                    Value::Text(text) => parse_number(&self.key, text, *unit)?,
                };
                // NaN fails this too.
                if (*min..=*max).contains(&x) {
                    return Ok(Value::Number(x));
                }
                Err(ParameterError::OutOfRange {
                    key: key(),
                    found: x,
                    min: *min,
                    max: *max,
                    unit: self.unit(),
                })
            }
        }
    }
}

/// A type that a parameter's field may have.
pub(crate) trait Field: Sized {
    fn to_value(&self) -> Value;
    fn from_value(value: &Value) -> Option<Self>;
}

impl Field for f64 {
    fn to_value(&self) -> Value {
        Value::Number(*self)
    }
    fn from_value(value: &Value) -> Option<f64> {
        if let Value::Number(x) = value {
            Some(*x)
        } else {
            None
        }
    }
}

impl Field for Option<f64> {
    fn to_value(&self) -> Value {
        self.map_or_else(|| Value::Text("auto".to_owned()), Value::Number)
    }
    fn from_value(value: &Value) -> Option<Option<f64>> {
        match value {
            Value::Number(x) => Some(Some(*x)),
            Value::Text(_) => Some(None),
            Value::Integer(_) => None,
        }
    }
}

impl Field for u32 {
    fn to_value(&self) -> Value {
        Value::Integer(u64::from(*self))
    }
    fn from_value(value: &Value) -> Option<u32> {
        if let Value::Integer(n) = value {
            u32::try_from(*n).ok()
        } else {
            None
        }
    }
}

impl Field for u64 {
    fn to_value(&self) -> Value {
        Value::Integer(*self)
    }
    fn from_value(value: &Value) -> Option<u64> {
        if let Value::Integer(n) = value {
            Some(*n)
        } else {
            None
        }
    }
}

/// A set of declared parameters.
pub trait Parameters: Default {
    /// Appends every parameter with its present value. `prefix` is put before each key, with a dot
    /// unless it is empty.
    fn describe(&self, prefix: &str, list: &mut Vec<ParameterInfo>);

    /// Puts a value that [`ParameterInfo::read`] has passed; false where there is no such key.
    fn assign(&mut self, key: &str, value: &Value) -> bool;

    /// What holds between parameters, beyond each one's range.
    ///
    /// # Errors
    /// The first condition that does not hold.
    fn consistent(&self) -> Result<(), ParameterError> {
        Ok(())
    }

    /// Every parameter with its present value, in the order of declaration.
    fn list(&self) -> Vec<ParameterInfo> {
        let mut list = Vec::new();
        self.describe("", &mut list);
        list
    }

    /// Every parameter with its default, in the order of declaration.
    fn table() -> Vec<ParameterInfo> {
        Self::default().list()
    }

    /// Sets one parameter. The set is unchanged where this fails.
    ///
    /// # Errors
    /// An unknown key, with the nearest ones; a value of the wrong kind or out of range.
    fn set(&mut self, key: &str, value: &Value) -> Result<(), ParameterError> {
        let table = Self::table();
        let unknown = || ParameterError::UnknownKey {
            key: key.to_owned(),
            nearest: closest_names(key, table.iter().map(|p| p.key.as_str())),
        };
        let info = table.iter().find(|p| p.key == key).ok_or_else(unknown)?;
        if self.assign(key, &info.read(value)?) {
            Ok(())
        } else {
            Err(unknown())
        }
    }

    /// Sets one parameter from text, where numbers may carry a unit: "12 mm", "0.5 rad", "30 %".
    ///
    /// # Errors
    /// As [`Parameters::set`].
    fn set_text(&mut self, key: &str, text: &str) -> Result<(), ParameterError> {
        self.set(key, &Value::Text(text.to_owned()))
    }

    /// Checks every range, and what holds between parameters. Needed after fields were written
    /// directly.
    ///
    /// # Errors
    /// The first parameter that is out of range, or the first condition that does not hold.
    fn check(&self) -> Result<(), ParameterError> {
        for parameter in self.list() {
            parameter.read(&parameter.value)?;
        }
        self.consistent()
    }
}

/// `sapwood` and `λ` make `λ_sapwood`; a symbol with its own subscript is whole already.
pub(crate) fn subscript(symbol: &str, group: &str) -> String {
    if symbol.is_empty() || group.is_empty() || symbol.contains('_') {
        return symbol.to_owned();
    }
    format!("{symbol}_{group}")
}

pub(crate) fn join(prefix: &str, key: &str) -> String {
    if prefix.is_empty() {
        key.to_owned()
    } else {
        format!("{prefix}.{key}")
    }
}

/// Documentation lines as one paragraph.
pub(crate) fn paragraph(lines: &[&str]) -> String {
    lines.iter().map(|l| l.trim()).collect::<Vec<_>>().join(" ")
}

/// Declares a struct of parameters: sections of fields, then nested groups. A field is `name: type
/// = default, "symbol", kind;`. A section's name is the heading it is listed under; an empty one
/// takes the name of the group that the struct is nested in.
macro_rules! parameters {
    (
        $(#[doc = $struct_doc:literal])+
        pub struct $name:ident {
            $($section:literal {
                $($(#[doc = $doc:literal])+
                $field:ident: $type:ty = $default:expr, $symbol:literal, $kind:expr;)+
            })+
        }
        groups {
            $($(#[doc = $group_doc:literal])+
            $group:ident: $group_type:ty = $group_default:expr;)*
        }
    ) => {
        $(#[doc = $struct_doc])+
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            $($($(#[doc = $doc])+ pub $field: $type,)+)+
            $($(#[doc = $group_doc])+ pub $group: $group_type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                $name {
                    $($($field: $default,)+)+
                    $($group: $group_default,)*
                }
            }
        }

        impl $name {
            fn describe_declared(
                &self,
                prefix: &str,
                list: &mut Vec<$crate::parameters::ParameterInfo>,
            ) {
                use $crate::parameters::declare::{Field, join, paragraph, subscript};
                $($(list.push($crate::parameters::ParameterInfo {
                    key: join(prefix, stringify!($field)),
                    symbol: subscript($symbol, prefix),
                    group: if $section.is_empty() { prefix } else { $section }.to_owned(),
                    doc: paragraph(&[$($doc),+]),
                    kind: $kind,
                    value: self.$field.to_value(),
                });)+)+
                $($crate::parameters::Parameters::describe(
                    &self.$group, &join(prefix, stringify!($group)), list);)*
            }

            fn assign_declared(
                &mut self,
                key: &str,
                value: &$crate::parameters::Value,
            ) -> bool {
                use $crate::parameters::declare::Field;
                match key {
                    $($(stringify!($field) => match <$type>::from_value(value) {
                        Some(value) => { self.$field = value; true }
                        None => false,
                    },)+)+
                    _ => match key.split_once('.') {
                        $(Some((stringify!($group), rest)) =>
                            $crate::parameters::Parameters::assign(&mut self.$group, rest, value),)*
                        _ => false,
                    },
                }
            }
        }
    };
}
pub(crate) use parameters;

/// Implements [`Parameters`] for a declared struct, with what must hold between its parameters.
macro_rules! parameters_hold {
    ($name:ty $(, $consistent:expr)?) => {
        impl $crate::parameters::Parameters for $name {
            fn describe(&self, prefix: &str, list: &mut Vec<$crate::parameters::ParameterInfo>) {
                self.describe_declared(prefix, list);
            }
            fn assign(&mut self, key: &str, value: &$crate::parameters::Value) -> bool {
                self.assign_declared(key, value)
            }
            $(fn consistent(&self) -> Result<(), $crate::parameters::ParameterError> {
                let consistent: fn(&$name) -> Result<(), $crate::parameters::ParameterError> = $consistent;
                consistent(self)
            })?
        }
    };
}
pub(crate) use parameters_hold;

/// Declares an enum that is a parameter's choice: `Variant = "word"`.
macro_rules! choices {
    (
        $(#[doc = $enum_doc:literal])+
        pub enum $name:ident { $($(#[doc = $doc:literal])+ $variant:ident = $word:literal,)+ }
    ) => {
        $(#[doc = $enum_doc])+
        #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        pub enum $name { $($(#[doc = $doc])+ #[serde(rename = $word)] $variant,)+ }

        impl $name {
            /// The words for it, in the order of declaration.
            pub const WORDS: &'static [&'static str] = &[$($word),+];
        }

        impl $crate::parameters::declare::Field for $name {
            fn to_value(&self) -> $crate::parameters::Value {
                $crate::parameters::Value::Text(match self { $($name::$variant => $word,)+ }.to_owned())
            }
            fn from_value(value: &$crate::parameters::Value) -> Option<Self> {
                match value {
                    $($crate::parameters::Value::Text(word) if word == $word => Some($name::$variant),)+
                    _ => None,
                }
            }
        }
    };
}
pub(crate) use choices;
