//! The macros that declare sets of parameters and choices.

/// The name of the table that a prefix leads to.
fn name(prefix: &str) -> &str {
    prefix.rsplit('.').next().unwrap_or(prefix)
}

/// The heading of a section: its own, else the name of the table that it stands in.
pub fn heading(section: &str, prefix: &str) -> String {
    if section.is_empty() {
        name(prefix).to_owned()
    } else {
        section.to_owned()
    }
}

/// In a table that may stand in several places (its section has no heading), `sapwood` and `λ` make `λ_sapwood`; a symbol
/// with its own subscript is whole already.
pub fn subscript(symbol: &str, section: &str, prefix: &str) -> String {
    let name = name(prefix);
    if symbol.is_empty() || !section.is_empty() || name.is_empty() || symbol.contains('_') {
        return symbol.to_owned();
    }
    format!("{symbol}_{name}")
}

/// A key within a group.
pub fn join(prefix: &str, key: &str) -> String {
    if prefix.is_empty() {
        key.to_owned()
    } else {
        format!("{prefix}.{key}")
    }
}

/// Documentation lines as one paragraph.
pub fn paragraph(lines: &[&str]) -> String {
    let lines: Vec<&str> = lines.iter().map(|l| l.trim()).collect();
    lines.join(" ")
}

/// The key of a field: its own name, or the one that is given.
#[doc(hidden)]
#[macro_export]
macro_rules! key {
    ($name:ident) => {
        stringify!($name)
    };
    ($name:ident as $key:literal) => {
        $key
    };
}

/// Declares a struct of parameters.
///
/// Sections of fields come first: the heading that they are listed under and the stage of the work that they change,
/// then for each field its documentation, name, type, default and [`Declaration`](crate::Declaration). A heading that is
/// empty takes the name of the table that the struct stands in. Then come, all optional: `other` (fields that no file
/// holds), `include` (structs of
/// parameters whose keys stand among the struct's own), `tables` (structs of parameters inside), `lists` (of such
/// structs, written `[[name]]` in files; fields of all kinds may have a key other than their name, `face as "break"`, and
/// a list may say what a new entry starts from, a function of the struct), and `check`, a function of a reference to the
/// struct that says what must hold between its parameters.
#[macro_export]
macro_rules! parameters {
    (
        $(#[doc = $struct_doc:literal])+
        pub struct $name:ident {
            $($section:literal, $stage:literal {
                $($(#[doc = $doc:literal])+
                $field:ident $(as $key:literal)?: $type:ty = $default:expr, $declaration:expr;)+
            })*
        }
        $(other {
            $($(#[doc = $other_doc:literal])+
            $other:ident: $other_type:ty = $other_default:expr;)+
        })?
        $(include {
            $($(#[doc = $include_doc:literal])+
            $include:ident: $include_type:ty = $include_default:expr;)+
        })?
        $(tables {
            $($(#[doc = $table_doc:literal])+
            $table:ident $(as $table_key:literal)?: $table_type:ty = $table_default:expr;)+
        })?
        $(lists {
            $($(#[doc = $list_doc:literal])+
            $list:ident $(as $list_key:literal)?: $list_type:ty $(= $list_start:expr)?;)+
        })?
        $(check $check:expr;)?
    ) => {
        $(#[doc = $struct_doc])+
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            $($($(#[doc = $doc])+
            $(#[serde(rename = $key)])?
            pub $field: $type,)+)*
            $($($(#[doc = $other_doc])+
            #[serde(skip, default = "Default::default")]
            pub $other: $other_type,)+)?
            $($($(#[doc = $include_doc])+
            pub $include: $include_type,)+)?
            $($($(#[doc = $table_doc])+
            $(#[serde(rename = $table_key)])?
            pub $table: $table_type,)+)?
            $($($(#[doc = $list_doc])+
            #[serde(skip_serializing_if = "Vec::is_empty" $(, rename = $list_key)?)]
            pub $list: Vec<$list_type>,)+)?
        }

        impl Default for $name {
            fn default() -> Self {
                $name {
                    $($($field: $default,)+)*
                    $($($other: $other_default,)+)?
                    $($($include: $include_default,)+)?
                    $($($table: $table_default,)+)?
                    $($($list: Vec::new(),)+)?
                }
            }
        }

        impl $crate::Parameters for $name {
            #[allow(unused_imports, unused_variables)]
            fn describe(&self, prefix: &str, list: &mut Vec<$crate::ParameterInfo>) {
                use $crate::Field;
                use $crate::macro_support::{heading, join, paragraph, subscript};
                $($({
                    let declared: $crate::Declaration = $declaration;
                    let value = self.$field.to_value();
                    list.push($crate::ParameterInfo {
                        key: join(prefix, $crate::key!($field $(as $key)?)),
                        symbol: subscript(declared.symbol, $section, prefix),
                        group: heading($section, prefix),
                        doc: paragraph(&[$($doc),+]),
                        kind: declared.kind,
                        auto: declared.auto,
                        words: declared.words,
                        scale: declared.scale,
                        stage: if declared.stage.is_empty() { $stage } else { declared.stage },
                        default: value.clone(),
                        value,
                    });
                })+)*
                $($($crate::Parameters::describe(&self.$include, prefix, list);)+)?
                $($($crate::Parameters::describe(
                    &self.$table, &join(prefix, $crate::key!($table $(as $table_key)?)), list);)+)?
            }

            #[allow(unused_imports, unused_variables)]
            fn assign(&mut self, key: &str, value: &$crate::Value) -> bool {
                use $crate::Field;
                match key {
                    $($($crate::key!($field $(as $key)?) => match <$type>::from_value(value) {
                        Some(value) => { self.$field = value; true }
                        None => false,
                    },)+)*
                    $($(_ if $crate::Parameters::assign(&mut self.$include, key, value) => true,)+)?
                    _ => match key.split_once('.') {
                        $($(Some(($crate::key!($table $(as $table_key)?), rest)) =>
                            $crate::Parameters::assign(&mut self.$table, rest, value),)+)?
                        _ => false,
                    },
                }
            }

            fn defaults(&self) -> Box<dyn $crate::Parameters> {
                Box::new($name::default())
            }

            #[allow(unused_mut)]
            fn tables(&self) -> Vec<(&'static str, &dyn $crate::Parameters)> {
                let mut all: Vec<(&'static str, &dyn $crate::Parameters)> = Vec::new();
                $($(all.extend($crate::Parameters::tables(&self.$include));)+)?
                $($(all.push(($crate::key!($table $(as $table_key)?), &self.$table));)+)?
                all
            }

            #[allow(unused_variables)]
            fn table_mut(&mut self, name: &str) -> Option<&mut dyn $crate::Parameters> {
                match name {
                    $($($crate::key!($table $(as $table_key)?) => Some(&mut self.$table),)+)?
                    _ => {
                        $($(if let Some(table) = $crate::Parameters::table_mut(&mut self.$include, name) {
                            return Some(table);
                        })+)?
                        None
                    }
                }
            }

            #[allow(unused_mut)]
            fn lists(&self) -> Vec<$crate::ListInfo> {
                let mut all = Vec::new();
                $($(all.extend($crate::Parameters::lists(&self.$include));)+)?
                $($(all.push($crate::ListInfo {
                    key: $crate::key!($list $(as $list_key)?),
                    doc: $crate::macro_support::paragraph(&[$($list_doc),+]),
                });)+)?
                all
            }

            #[allow(unused_mut, unused_variables)]
            fn entries(&self, list: &str) -> Vec<&dyn $crate::Parameters> {
                match list {
                    $($($crate::key!($list $(as $list_key)?) =>
                        self.$list.iter().map(|e| e as &dyn $crate::Parameters).collect(),)+)?
                    _ => {
                        let mut all = Vec::new();
                        $($(all.extend($crate::Parameters::entries(&self.$include, list));)+)?
                        all
                    }
                }
            }

            #[allow(unused_variables)]
            fn add_entry(&mut self, list: &str) -> Option<&mut dyn $crate::Parameters> {
                match list {
                    $($($crate::key!($list $(as $list_key)?) => {
                        let entry = $crate::first_entry!(self, $list_type $(, $list_start)?);
                        self.$list.push(entry);
                        self.$list.last_mut().map(|e| e as &mut dyn $crate::Parameters)
                    })+)?
                    _ => {
                        $($(if let Some(entry) = $crate::Parameters::add_entry(&mut self.$include, list) {
                            return Some(entry);
                        })+)?
                        None
                    }
                }
            }

            #[allow(unused_variables)]
            fn clear_entries(&mut self, list: &str) {
                match list {
                    $($($crate::key!($list $(as $list_key)?) => self.$list.clear(),)+)?
                    _ => {
                        $($($crate::Parameters::clear_entries(&mut self.$include, list);)+)?
                    }
                }
            }

            fn consistent(&self) -> Result<(), $crate::ParameterError> {
                $($($crate::Parameters::consistent(&self.$include)?;)+)?
                $(
                    let check: fn(&$name) -> Result<(), $crate::ParameterError> = $check;
                    check(self)?;
                )?
                Ok(())
            }
        }
    };
}

/// The entry that a list grows by: its type's default, or what a function makes of the set.
#[doc(hidden)]
#[macro_export]
macro_rules! first_entry {
    ($set:ident, $type:ty) => {
        <$type>::default()
    };
    ($set:ident, $type:ty, $start:expr) => {{
        let start: fn(&Self) -> $type = $start;
        start($set)
    }};
}

/// Declares an enum that is a parameter's choice: `Variant = "word"`.
#[macro_export]
macro_rules! choices {
    ($(
        $(#[doc = $enum_doc:literal])+
        pub enum $name:ident { $($(#[doc = $doc:literal])+ $variant:ident = $word:literal,)+ }
    )+) => {$(
        $(#[doc = $enum_doc])+
        #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        pub enum $name { $($(#[doc = $doc])+ #[serde(rename = $word)] $variant,)+ }

        impl $name {
            /// The words for it and what they mean, in the order of declaration.
            pub const CHOICES: &'static [$crate::Choice] = &[$($crate::Choice {
                word: $word,
                doc: concat!($($doc),+).trim_ascii(),
            }),+];

            /// The word for it.
            pub const fn word(self) -> &'static str {
                match self { $($name::$variant => $word,)+ }
            }
        }

        impl $crate::Field for $name {
            fn to_value(&self) -> $crate::Value {
                $crate::Value::Text(self.word().to_owned())
            }

            fn from_value(value: &$crate::Value) -> Option<Self> {
                match value {
                    $($crate::Value::Text(word) if word == $word => Some($name::$variant),)+
                    _ => None,
                }
            }
        }
    )+};
}

/// Makes a type that has a text form a type of parameters: implements [`Field`](crate::Field), `Serialize` and
/// `Deserialize` by its `FromStr` and by a function that writes it exactly, and declares the
/// [`Format`](crate::Format).
#[macro_export]
macro_rules! text_field {
    ($type:ty, $name:literal, $write:expr; $(#[doc = $doc:literal])+ pub const $format:ident) => {
        $(#[doc = $doc])+
        pub const $format: $crate::Format = $crate::Format {
            name: $name,
            check: |text| match text.parse::<$type>() {
                Ok(_) => Ok(()),
                Err(error) => Err(error.to_string()),
            },
        };

        impl $crate::Field for $type {
            fn to_value(&self) -> $crate::Value {
                let write: fn(&$type) -> String = $write;
                $crate::Value::Text(write(self))
            }

            fn from_value(value: &$crate::Value) -> Option<Self> {
                match value {
                    $crate::Value::Text(text) => text.parse().ok(),
                    _ => None,
                }
            }
        }

        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                let write: fn(&$type) -> String = $write;
                to.serialize_str(&write(self))
            }
        }

        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
                let text = <std::borrow::Cow<'de, str> as serde::Deserialize>::deserialize(from)?;
                text.parse().map_err(serde::de::Error::custom)
            }
        }
    };
}
