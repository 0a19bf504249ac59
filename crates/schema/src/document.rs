//! Parameters as TOML: reading a file with the line of whatever is wrong, and writing one.

use crate::value::AUTO;
use crate::{Kind, ParameterError, ParameterInfo, Parameters, Value, closest_names};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// What is wrong with a part of a file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Problem {
    /// Not TOML.
    #[error("not valid TOML: {0}")]
    Syntax(String),
    /// A parameter.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A value of the wrong kind.
    #[error("{key} is {found}, but it must be {expected}")]
    Type {
        /// The key.
        key: String,
        /// The kind found.
        found: &'static str,
        /// The kind that would be right.
        expected: String,
    },
}

/// What is wrong with a file, and where.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("line {line}, column {column}: {problem}")]
pub struct DocumentError {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What is wrong.
    pub problem: Problem,
}

/// What is wrong and the bytes of the text it stands at.
type Located = (Range<usize>, Problem);

/// Puts a TOML text over a set of parameters.
///
/// # Errors
/// The first thing that is wrong, with its line. The set may then be changed in part.
pub fn read_toml(target: &mut dyn Parameters, text: &str) -> Result<(), DocumentError> {
    let document = DeTable::parse(text).map_err(|e| syntax_error(text, &e))?;
    read_table(target, document.get_ref(), text, &[])
}

/// Puts a TOML text that may be of an older version over a set of parameters: keys that only `former` has are put over that
/// set, for the caller to translate.
///
/// # Errors
/// As [`read_toml`].
pub fn read_toml_with_former_keys(
    target: &mut dyn Parameters,
    former: &mut dyn Parameters,
    text: &str,
) -> Result<(), DocumentError> {
    let document = DeTable::parse(text).map_err(|e| syntax_error(text, &e))?;
    let is_current: BTreeSet<String> = target.list().into_iter().map(|p| p.key).collect();
    let mut found = Vec::new();
    for ParameterInfo { key, .. } in former.list() {
        let mut nested = Some(document.get_ref());
        let (path, name) = key.rsplit_once('.').unwrap_or(("", &key));
        for table in path.split('.').filter(|t| !t.is_empty()) {
            nested = nested.and_then(|t| match t.get(table)?.get_ref() {
                DeValue::Table(inner) => Some(inner),
                _ => None,
            });
        }
        let value = nested.and_then(|t| t.get(name));
        if let (Some(value), false) = (value, is_current.contains(&key)) {
            Reader::new(former, &[])
                .put(former, &key, value)
                .map_err(|located| at(text, located))?;
            found.push(key);
        }
    }
    let found: Vec<&str> = found.iter().map(String::as_str).collect();
    read_table(target, document.get_ref(), text, &found)
}

/// Puts a parsed table of `text` over a set of parameters. `read_before` are keys that the caller has read itself.
///
/// # Errors
/// As [`read_toml`].
pub fn read_table(
    target: &mut dyn Parameters,
    table: &DeTable,
    text: &str,
    read_before: &[&str],
) -> Result<(), DocumentError> {
    Reader::new(target, read_before)
        .read(target, "", (0..0, table))
        .map_err(|located| at(text, located))
}

/// What TOML's parser finds wrong with `text`.
pub fn syntax_error(text: &str, error: &toml::de::Error) -> DocumentError {
    let problem = Problem::Syntax(error.message().replace('\n', ", "));
    at(text, (error.span().unwrap_or(0..0), problem))
}

/// The line of a byte of `text`, and its column in characters, both from 1.
pub fn line_and_column(text: &str, byte: usize) -> (usize, usize) {
    let before = text.get(..byte).unwrap_or(text);
    let last = before.rsplit('\n').next().unwrap_or_default();
    (before.matches('\n').count() + 1, last.chars().count() + 1)
}

/// Where in `text` something is wrong.
fn at(text: &str, (span, problem): Located) -> DocumentError {
    let (line, column) = line_and_column(text, span.start);
    DocumentError {
        line,
        column,
        problem,
    }
}

/// Reads a table of parameters and those inside.
struct Reader<'a> {
    /// Keys that were read before.
    read_before: &'a [&'a str],
    /// Every parameter by its key.
    known: BTreeMap<String, ParameterInfo>,
}

impl<'a> Reader<'a> {
    fn new(target: &dyn Parameters, read_before: &'a [&'a str]) -> Self {
        let list = target.list().into_iter();
        Reader {
            read_before,
            known: list.map(|p| (p.key.clone(), p)).collect(),
        }
    }

    /// Reads a table whose keys begin with `prefix`, with the bytes of the text that it takes.
    fn read(
        &self,
        target: &mut dyn Parameters,
        prefix: &str,
        (span, table): (Range<usize>, &DeTable),
    ) -> Result<(), Located> {
        // Lists last: their entries may start from what the rest says.
        let (lists, rest): (Vec<_>, Vec<_>) = table
            .iter()
            .partition(|(_, value)| is_list_of_tables(value.get_ref()));
        for (name, value) in rest.into_iter().chain(lists) {
            let key = format!("{prefix}{}", name.get_ref());
            if self.read_before.contains(&key.as_str()) {
                continue;
            }
            match value.get_ref() {
                DeValue::Table(nested) if self.has_table(&key) => {
                    self.read(target, &format!("{key}."), (value.span(), nested))?;
                }
                _ if self.known.contains_key(&key) => self.put(target, &key, value)?,
                _ => {
                    let Some((owner, list)) = owner_of_list(target, &key) else {
                        return Err((name.span(), self.unknown(target, &key).into()));
                    };
                    read_list(owner, list, &key, value)?;
                }
            }
        }
        match inside(target, prefix) {
            Some(table) => table.consistent().map_err(|e| (span, e.into())),
            None => Ok(()),
        }
    }

    /// Whether parameters stand in a table of this name.
    fn has_table(&self, key: &str) -> bool {
        let prefix = format!("{key}.");
        let mut from = self.known.range(prefix.clone()..);
        from.next().is_some_and(|(k, _)| k.starts_with(&prefix))
    }

    /// Puts one value.
    fn put(
        &self,
        target: &mut dyn Parameters,
        key: &str,
        value: &Spanned<DeValue>,
    ) -> Result<(), Located> {
        let wrong = |problem: ParameterError| (value.span(), Problem::from(problem));
        let info = &self.known[key];
        let found = scalar(key, value)?;
        let written = match &found {
            // Numbers of a file need the unit that text needs.
            Value::Number(_) | Value::Integer(_) if info.kind.unit().is_required() => {
                Value::Text(found.to_string())
            }
            _ => found,
        };
        let read = info.read(&written).map_err(wrong)?;
        if target.assign(key, &read) {
            return Ok(());
        }
        Err(wrong(ParameterError::Kind {
            key: key.to_owned(),
            found: written.to_string(),
            expected: info.kind.range(),
        }))
    }

    fn unknown(&self, target: &dyn Parameters, key: &str) -> ParameterError {
        let lists = target.lists();
        let keys = self.known.keys().map(String::as_str);
        let tables = target.tables();
        let names = tables.iter().map(|t| t.0);
        let all = keys
            .chain(names)
            .chain(lists.iter().map(|l| l.key))
            .chain(self.read_before.iter().copied());
        // Most often what is unknown here stands in a table.
        let nested = format!("{key}.");
        let is_in_table = |p: &&String| {
            let rest = p.split_once('.').map_or("", |p| p.1);
            rest == key || rest.starts_with(&nested)
        };
        let in_table = self.known.keys().find(is_in_table);
        let in_table = in_table.and_then(|p| p.split_once('.'));
        let mut nearest = closest_names(key, all);
        if let Some((table, _)) = in_table {
            nearest.insert(0, format!("[{table}] {key}"));
        }
        ParameterError::UnknownKey {
            key: key.to_owned(),
            nearest,
        }
    }
}

fn is_list_of_tables(value: &DeValue) -> bool {
    matches!(value, DeValue::Array(list) if list.iter().any(|entry| entry.get_ref().is_table()))
}

/// The table of parameters that a prefix leads to.
fn inside<'a>(target: &'a mut dyn Parameters, prefix: &str) -> Option<&'a mut dyn Parameters> {
    let mut at = target;
    for name in prefix.split('.').filter(|n| !n.is_empty()) {
        at = at.table_mut(name)?;
    }
    Some(at)
}

/// The table that a list of a key stands in, and the list's name there.
fn owner_of_list<'a, 'k>(
    target: &'a mut dyn Parameters,
    key: &'k str,
) -> Option<(&'a mut dyn Parameters, &'k str)> {
    let (prefix, name) = key.rsplit_once('.').unwrap_or(("", key));
    let owner = inside(target, prefix)?;
    let is_list = owner.lists().iter().any(|l| l.key == name);
    is_list.then_some((owner, name))
}

/// Reads the entries of a list; they replace those before.
fn read_list(
    owner: &mut dyn Parameters,
    list: &str,
    key: &str,
    value: &Spanned<DeValue>,
) -> Result<(), Located> {
    let expected = || format!("a list of tables, written [[{key}]]");
    let DeValue::Array(array) = value.get_ref() else {
        return Err(wrong_type(key, value, expected()));
    };
    owner.clear_entries(list);
    for entry in array {
        let DeValue::Table(table) = entry.get_ref() else {
            return Err(wrong_type(key, entry, expected()));
        };
        let Some(target) = owner.add_entry(list) else {
            return Err(wrong_type(key, entry, expected()));
        };
        read_entry(target, table, entry.span())?;
    }
    Ok(())
}

/// Reads an entry of a list: first its tag, which decides what parameters it has.
fn read_entry(
    target: &mut dyn Parameters,
    table: &DeTable,
    span: Range<usize>,
) -> Result<(), Located> {
    if let Some(tag) = target.tag() {
        match table.get(tag) {
            Some(value) => Reader::new(target, &[]).put(target, tag, value)?,
            None => {
                let options = target.list().into_iter().find(|p| p.key == tag);
                let expected = options.map_or(String::new(), |p| p.kind.range());
                let problem = ParameterError::Kind {
                    key: tag.to_owned(),
                    found: "missing".to_owned(),
                    expected,
                };
                return Err((span, problem.into()));
            }
        }
    }
    Reader::new(target, &[]).read(target, "", (span, table))
}

/// A value that is no table.
fn scalar(key: &str, value: &Spanned<DeValue>) -> Result<Value, Located> {
    match value.get_ref() {
        DeValue::String(text) => Ok(Value::Text(text.to_string())),
        DeValue::Boolean(b) => Ok(Value::Flag(*b)),
        DeValue::Float(x) => match x.as_str().parse() {
            Ok(x) => Ok(Value::Number(x)),
            Err(_) => Err(wrong_type(key, value, "a number".to_owned())),
        },
        DeValue::Integer(n) => match i128::from_str_radix(n.as_str(), n.radix()) {
            Ok(n) => Ok(Value::Integer(n)),
            Err(_) => Err(wrong_type(
                key,
                value,
                "a number of 64 bits at most".to_owned(),
            )),
        },
        DeValue::Array(list) => {
            let parts: Result<_, _> = list.iter().map(|part| scalar(key, part)).collect();
            parts.map(Value::List)
        }
        DeValue::Table(_) | DeValue::Datetime(_) => {
            Err(wrong_type(key, value, "a number or a word".to_owned()))
        }
    }
}

fn wrong_type(key: &str, value: &Spanned<DeValue>, expected: String) -> Located {
    let found = match value.get_ref() {
        DeValue::String(_) => "a word",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    };
    let problem = Problem::Type {
        key: key.to_owned(),
        found,
        expected,
    };
    (value.span(), problem)
}

/// All parameters of a set as TOML, so that it means the same whatever defaults become: first those at the top, then
/// tables, then lists.
pub fn write_toml(set: &dyn Parameters) -> String {
    let mut text = String::new();
    write_table(set, "", &mut text);
    text
}

/// Writes a table, `path` being empty for the top of a file.
fn write_table(set: &dyn Parameters, path: &str, text: &mut String) {
    let list = set.list();
    let tables = if path.is_empty() {
        set.tables()
    } else {
        Vec::new()
    };
    let table_of = |p: &ParameterInfo| {
        let first = p.key.split_once('.')?.0;
        tables.iter().find(|t| t.0 == first).map(|t| t.0)
    };
    for parameter in list.iter().filter(|p| table_of(p).is_none()) {
        write_parameter(parameter, &parameter.key, text);
    }
    for (name, _) in &tables {
        let own: Vec<_> = list.iter().filter(|p| table_of(p) == Some(name)).collect();
        if !own.is_empty() {
            text.push_str(&format!("\n[{name}]\n"));
        }
        for parameter in own {
            write_parameter(parameter, &parameter.key[name.len() + 1..], text);
        }
    }
    for (prefix, owner) in owners(set) {
        for list in owner.lists() {
            let name = [path, &prefix, list.key].map(str::to_owned).to_vec();
            let name: Vec<String> = name.into_iter().filter(|n| !n.is_empty()).collect();
            let name = name.join(".");
            for entry in owner.entries(list.key) {
                text.push_str(&format!("\n[[{name}]]\n"));
                write_table(entry, &name, text);
            }
        }
    }
}

/// A set and the tables in it, with their prefixes.
fn owners(set: &dyn Parameters) -> Vec<(String, &dyn Parameters)> {
    let mut all = vec![(String::new(), set)];
    for (name, table) in set.tables() {
        for (prefix, owner) in owners(table) {
            let dot = if prefix.is_empty() { "" } else { "." };
            all.push((format!("{name}{dot}{prefix}"), owner));
        }
    }
    all
}

fn write_parameter(parameter: &ParameterInfo, key: &str, text: &mut String) {
    // A text that is worked out has no word for it that could not be a text itself.
    if parameter.value == Value::Auto && matches!(parameter.kind, Kind::Text { .. }) {
        return;
    }
    let value = written(&parameter.kind, &parameter.value);
    text.push_str(&format!("{key} = {value}\n"));
}

/// A value as TOML.
fn written(kind: &Kind, value: &Value) -> String {
    let symbol = kind.unit().symbol();
    match value {
        Value::Auto => quoted(AUTO),
        Value::Flag(b) => b.to_string(),
        Value::Integer(n) => n.to_string(),
        Value::Number(x) if kind.unit().is_required() => quoted(&format!("{x} {symbol}")),
        // A point or an exponent, and every digit that is needed to read the same number again.
        Value::Number(x) => format!("{x:?}"),
        Value::Text(t) => quoted(t),
        Value::List(list) if kind.unit().is_required() && !list.is_empty() => {
            quoted(&format!("{value} {symbol}"))
        }
        Value::List(list) => {
            let of = match kind {
                Kind::List { of, .. } => of,
                other => other,
            };
            let parts: Vec<String> = list.iter().map(|v| written(of, v)).collect();
            format!("[{}]", parts.join(", "))
        }
    }
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}
