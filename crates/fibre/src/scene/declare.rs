//! The declaration of a scene's keys: once, with documentation, range, unit and default. Struct fields, defaults, checks, the
//! reference page, and the names with which a misspelt key is compared all come from it.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// A key of a scene file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct KeyInfo {
    /// The table in which it stands; empty for the top of the file.
    pub table: String,
    /// Its name.
    pub key: String,
    /// Its documentation.
    pub doc: String,
    /// Unit of its numbers; empty for none.
    pub unit: &'static str,
    /// Least and greatest value; infinite for no limit.
    pub range: (f64, f64),
    /// Its default as TOML; empty for none.
    pub default: String,
}

/// A table of a scene file.
pub trait Declared {
    /// Returns its keys, as those of the table `table`.
    fn keys(table: &str) -> Vec<KeyInfo>;

    /// Returns the first number out of range, with its key.
    fn out_of_range(&self, table: &str) -> Option<(KeyInfo, f64)>;
}

/// A value whose numbers are checked against a range.
pub(super) trait Numbers {
    /// Returns its numbers.
    fn numbers(&self) -> Vec<f64>;
}

macro_rules! numbers {
    ($($type:ty: $value:ident => $numbers:expr;)+) => {
        $(impl Numbers for $type {
            fn numbers(&self) -> Vec<f64> {
                let $value = self;
                $numbers
            }
        })+
    };
}
pub(crate) use numbers;

numbers! {
    f64: v => vec![*v];
    u32: v => vec![f64::from(*v)];
    u64: v => vec![*v as f64];
    bool: _v => Vec::new();
    String: _v => Vec::new();
    [f64; 3]: v => v.to_vec();
    [f64; 2]: v => v.to_vec();
    Length: v => vec![v.0];
    [Length; 2]: v => vec![v[0].0, v[1].0];
    Lengths: v => v.0.to_vec();
}

impl<T: Numbers> Numbers for Option<T> {
    fn numbers(&self) -> Vec<f64> {
        self.as_ref().map_or(Vec::new(), T::numbers)
    }
}

impl<T> Numbers for Vec<T> {
    fn numbers(&self) -> Vec<f64> {
        Vec::new()
    }
}

/// Returns a value as TOML; empty where it has none.
pub(super) fn toml_text<T: Serialize>(value: &T) -> String {
    toml::Value::try_from(value).map_or(String::new(), |v| v.to_string())
}

/// A length (m), written with its unit: "15 cm", "4 mm", "0.3 m".
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Length(pub f64);

/// Three lengths (m), written with one unit: "0, -7.5, 2 cm".
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lengths(pub [f64; 3]);

/// Returns the number of metres in a unit.
fn metres(unit: &str) -> Option<f64> {
    match unit {
        "mm" => Some(1e-3),
        "cm" => Some(1e-2),
        "m" => Some(1.0),
        _ => None,
    }
}

/// Parses numbers followed by one unit of length, m.
fn lengths(text: &str) -> Option<Vec<f64>> {
    let text = text.trim();
    let at = text.find(|c: char| c.is_ascii_alphabetic() && c != 'e' && c != 'E')?;
    let (numbers, unit) = text.split_at(at);
    let scale = metres(unit.trim())?;
    numbers
        .split(',')
        .map(|n| n.trim().parse::<f64>().ok())
        // Division gives for "15 cm" the double nearest to 0.15.
        .map(|n| n.map(|n| n / (1.0 / scale).round()))
        .collect()
}

impl<'de> Deserialize<'de> for Length {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let text = String::deserialize(from)?;
        match lengths(&text).as_deref() {
            Some([length]) => Ok(Length(*length)),
            _ => Err(de::Error::custom(format!(
                "\"{text}\" is no length; write a number with mm, cm or m, such as \"15 cm\""
            ))),
        }
    }
}

impl<'de> Deserialize<'de> for Lengths {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let text = String::deserialize(from)?;
        match lengths(&text).as_deref() {
            Some([x, y, z]) => Ok(Lengths([*x, *y, *z])),
            _ => Err(de::Error::custom(format!(
                "\"{text}\" is no position; write three numbers with mm, cm or m, such as \"0, -7.5, 2 cm\""
            ))),
        }
    }
}

impl Serialize for Length {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(&format!("{} m", self.0))
    }
}

impl Serialize for Lengths {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let [x, y, z] = self.0;
        to.serialize_str(&format!("{x}, {y}, {z} m"))
    }
}

/// Declares a table: `key: type = default, (least, greatest, unit);`.
macro_rules! declared {
    (
        $(#[doc = $struct_doc:literal])+
        pub struct $name:ident {
            $($(#[doc = $doc:literal])+
            $field:ident: $type:ty = $default:expr, ($least:expr, $greatest:expr, $unit:literal);)+
        }
        $(tables {
            $($(#[doc = $table_doc:literal])+ $table:ident: $table_type:ty;)+
        })?
        $(lists {
            $($(#[doc = $list_doc:literal])+ $list:ident: $list_type:ty;)+
        })?
    ) => {
        $(#[doc = $struct_doc])+
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            $($(#[doc = $doc])+ pub $field: $type,)+
            $($($(#[doc = $table_doc])+ pub $table: $table_type,)+)?
            $($($(#[doc = $list_doc])+
            #[serde(skip_serializing_if = "Vec::is_empty")]
            pub $list: Vec<$list_type>,)+)?
        }

        impl Default for $name {
            fn default() -> Self {
                $name {
                    $($field: $default,)+
                    $($($table: Default::default(),)+)?
                    $($($list: Vec::new(),)+)?
                }
            }
        }

        impl $crate::scene::declare::Declared for $name {
            fn keys(table: &str) -> Vec<$crate::scene::declare::KeyInfo> {
                use $crate::scene::declare::{KeyInfo, toml_text};
                let default = Self::default();
                let keys = vec![$(KeyInfo {
                    table: table.to_owned(),
                    key: stringify!($field).to_owned(),
                    doc: [$($doc.trim()),+].join(" "),
                    unit: $unit,
                    range: ($least, $greatest),
                    default: toml_text(&default.$field),
                }),+];
                $($(let keys = [keys, <$table_type>::keys(stringify!($table))].concat();)+)?
                $($(let keys = [keys, <$list_type>::keys(concat!("[", stringify!($list), "]"))].concat();)+)?
                keys
            }

            fn out_of_range(&self, table: &str) -> Option<($crate::scene::declare::KeyInfo, f64)> {
                use $crate::scene::declare::Numbers;
                $(for value in self.$field.numbers() {
                    if !($least..=$greatest).contains(&value) {
                        let key = Self::keys(table).into_iter().find(|k| k.key == stringify!($field))?;
                        return Some((key, value));
                    }
                })+
                $($(if let Some(found) = self.$table.out_of_range(stringify!($table)) {
                    return Some(found);
                })+)?
                $($(for entry in &self.$list {
                    if let Some(found) = entry.out_of_range(concat!("[", stringify!($list), "]")) {
                        return Some(found);
                    }
                })+)?
                None
            }
        }
    };
}
pub(crate) use declared;
