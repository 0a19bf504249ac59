//! Options made from the library's declarations: one for each parameter of a set.

use crate::failure::Failure;
use clap::builder::PossibleValue;
use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, Error, FromArgMatches};
use greenstick::schema::{Kind, ParameterError, ParameterInfo, Parameters, Value};
use std::marker::PhantomData;

/// A set of parameters whose keys are options: `texture_size` is `--texture-size`.
pub trait OptionSet: Parameters + Default {
    /// Top-level keys that have no option.
    const EXCLUDED_KEYS: &'static [&'static str] = &[];
    /// Keys in tables that have an option, named after their last part.
    const SHORTCUTS: &'static [&'static str] = &[];

    /// Adds to an option what its declaration does not say.
    fn adjust(option: Arg) -> Arg {
        option
    }
}

/// The options of a set that were given, with their text.
#[derive(Debug, Clone)]
pub struct Declared<T> {
    given: Vec<(ParameterInfo, String)>,
    set: PhantomData<T>,
}

/// Returns the parameters of a set that have options.
fn options<T: OptionSet>() -> impl Iterator<Item = ParameterInfo> {
    T::table().into_iter().filter(|p| {
        let key = p.key.as_str();
        let at_the_top = !key.contains('.') && !T::EXCLUDED_KEYS.contains(&key);
        at_the_top || T::SHORTCUTS.contains(&key)
    })
}

/// Returns the name of a parameter's option in clap.
fn id(p: &ParameterInfo) -> &str {
    p.key.rsplit('.').next().unwrap_or(&p.key)
}

/// Returns the option as it is typed.
fn flag(p: &ParameterInfo) -> String {
    format!("--{}", id(p).replace('_', "-"))
}

/// Returns what `--help` says about a parameter.
fn help(p: &ParameterInfo) -> String {
    let mut text = p.doc.trim_end_matches('.').to_owned();
    text += &range(p);
    match &p.default {
        Value::Auto | Value::Flag(_) => {}
        value if value.to_string().is_empty() => {}
        value => text += &format!(" [default: {}]", p.show(value)),
    }
    text
}

/// Returns the range of a number in parentheses, unless it is too wide to be of use.
fn range(p: &ParameterInfo) -> String {
    const MAX_SHOWN_LIMIT: f64 = 1e9;
    let (Some(min), Some(max)) = (p.min(), p.max()) else {
        return String::new();
    };
    let unit = match p.unit() {
        "" => String::new(),
        unit => format!(" {unit}"),
    };
    match p.kind {
        _ if max >= MAX_SHOWN_LIMIT => String::new(),
        Kind::Number { above: true, .. } => format!(" (above {min}, up to {max}{unit})"),
        _ => format!(" ({min} to {max}{unit})"),
    }
}

fn option<T: OptionSet>(p: &ParameterInfo) -> Arg {
    let arg = Arg::new(id(p).to_owned())
        .long(id(p).replace('_', "-"))
        .help(help(p))
        .help_heading(p.group.clone());
    T::adjust(match p.kind {
        Kind::Flag if p.default == Value::Flag(false) => arg.action(ArgAction::SetTrue),
        Kind::Choice { options } => {
            let word = |o: &greenstick::schema::Choice| {
                PossibleValue::new(o.word).help(o.doc.trim_end_matches('.'))
            };
            let auto = p
                .auto
                .then(|| PossibleValue::new("auto").help("decided by the program"));
            arg.value_name("WORD")
                .value_parser(options.iter().map(word).chain(auto).collect::<Vec<_>>())
        }
        _ => arg
            .value_name(p.kind.placeholder())
            .allow_hyphen_values(true),
    })
}

impl<T: OptionSet> Args for Declared<T> {
    fn augment_args(command: Command) -> Command {
        command.args(options::<T>().map(|p| option::<T>(&p)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<T: OptionSet> FromArgMatches for Declared<T> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let mut given = Vec::new();
        for p in options::<T>() {
            let name = id(&p);
            if matches.value_source(name) != Some(ValueSource::CommandLine) {
                continue;
            }
            if matches!(p.kind, Kind::Flag) && p.default == Value::Flag(false) {
                let text = matches.get_flag(name).to_string();
                given.push((p, text));
                continue;
            }
            let Some(texts) = matches.get_many::<String>(name) else {
                return Err(Error::raw(ErrorKind::InvalidValue, name));
            };
            given.extend(texts.map(|text| (p.clone(), text.clone())));
        }
        Ok(Declared {
            given,
            set: PhantomData,
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl<T: OptionSet> Declared<T> {
    /// Returns the text that was given for a key.
    pub fn text(&self, key: &str) -> Option<&str> {
        let given = self.given.iter().find(|(p, _)| p.key == key);
        given.map(|(_, text)| text.as_str())
    }

    /// Returns all texts that were given for a key whose option may be given several times.
    pub fn texts(&self, key: &str) -> Vec<&str> {
        let given = self.given.iter().filter(|(p, _)| p.key == key);
        given.map(|(_, text)| text.as_str()).collect()
    }

    /// Replaces the text that was given for a key.
    pub fn replace(&mut self, key: &str, text: &str) {
        let given = self.given.iter_mut().filter(|(p, _)| p.key == key);
        given.for_each(|(_, known)| text.clone_into(known));
    }

    /// Applies the options to a set that has all of their keys. `rewrite` may replace the text of a key.
    pub fn apply(
        &self,
        target: &mut dyn Parameters,
        rewrite: impl Fn(&str, &str) -> Result<Option<String>, Failure>,
    ) -> Result<(), Failure> {
        for (p, text) in &self.given {
            let text = match rewrite(&p.key, text)? {
                Some(new) => new,
                None => text.clone(),
            };
            target
                .set_text(&p.key, &text)
                .map_err(|error| Failure::parameter(&flag(p), &error))?;
        }
        Ok(())
    }

    /// Applies the options to a set that has only some of their keys.
    pub fn apply_known(&self, target: &mut dyn Parameters) -> Result<(), Failure> {
        for (p, text) in &self.given {
            match target.set_text(&p.key, text) {
                Err(ParameterError::UnknownKey { .. }) | Ok(()) => {}
                Err(error) => return Err(Failure::parameter(&flag(p), &error)),
            }
        }
        Ok(())
    }

    /// Returns the set with its defaults and the options.
    pub fn set(&self) -> Result<T, Failure> {
        let mut set = T::default();
        self.apply(&mut set, |_, _| Ok(None))?;
        Ok(set)
    }
}
