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
/// empty takes the name of the table that the struct stands in. Then come, all optional: `tables` (structs of
/// parameters inside), `lists` (of such structs, written `[[name]]` in files; both may have a key other than their
/// field's name, `face as "break"`), and `check`, a function of a reference to the struct that says what must hold
/// between its parameters.
#[macro_export]
macro_rules! parameters {
    (
        $(#[doc = $struct_doc:literal])+
        pub struct $name:ident {
            $($section:literal, $stage:literal {
                $($(#[doc = $doc:literal])+
                $field:ident: $type:ty = $default:expr, $declaration:expr;)+
            })*
        }
        $(tables {
            $($(#[doc = $table_doc:literal])+
            $table:ident $(as $table_key:literal)?: $table_type:ty = $table_default:expr;)+
        })?
        $(lists {
            $($(#[doc = $list_doc:literal])+
            $list:ident $(as $list_key:literal)?: $list_type:ty;)+
        })?
        $(check $check:expr;)?
    ) => {
        $(#[doc = $struct_doc])+
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            $($($(#[doc = $doc])+ pub $field: $type,)+)*
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
                        key: join(prefix, stringify!($field)),
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
                $($($crate::Parameters::describe(
                    &self.$table, &join(prefix, $crate::key!($table $(as $table_key)?)), list);)+)?
            }

            #[allow(unused_imports, unused_variables)]
            fn assign(&mut self, key: &str, value: &$crate::Value) -> bool {
                use $crate::Field;
                match key {
                    $($(stringify!($field) => match <$type>::from_value(value) {
                        Some(value) => { self.$field = value; true }
                        None => false,
                    },)+)*
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

            $(fn tables(&self) -> Vec<(&'static str, &dyn $crate::Parameters)> {
                vec![$(($crate::key!($table $(as $table_key)?), &self.$table)),+]
            }

            fn table_mut(&mut self, name: &str) -> Option<&mut dyn $crate::Parameters> {
                match name {
                    $($crate::key!($table $(as $table_key)?) => Some(&mut self.$table),)+
                    _ => None,
                }
            })?

            $(fn lists(&self) -> Vec<$crate::ListInfo> {
                vec![$($crate::ListInfo {
                    key: $crate::key!($list $(as $list_key)?),
                    doc: $crate::macro_support::paragraph(&[$($list_doc),+]),
                }),+]
            }

            fn entries(&self, list: &str) -> Vec<&dyn $crate::Parameters> {
                match list {
                    $($crate::key!($list $(as $list_key)?) =>
                        self.$list.iter().map(|e| e as &dyn $crate::Parameters).collect(),)+
                    _ => Vec::new(),
                }
            }

            fn add_entry(&mut self, list: &str) -> Option<&mut dyn $crate::Parameters> {
                match list {
                    $($crate::key!($list $(as $list_key)?) => {
                        self.$list.push(Default::default());
                        self.$list.last_mut().map(|e| e as &mut dyn $crate::Parameters)
                    })+
                    _ => None,
                }
            }

            fn clear_entries(&mut self, list: &str) {
                match list {
                    $($crate::key!($list $(as $list_key)?) => self.$list.clear(),)+
                    _ => {}
                }
            })?

            $(fn consistent(&self) -> Result<(), $crate::ParameterError> {
                let check: fn(&$name) -> Result<(), $crate::ParameterError> = $check;
                check(self)
            })?
        }
    };
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
