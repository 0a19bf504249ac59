//! The command line that does the same.

use greenstick::RequestFile;
use greenstick::schema::{ParameterInfo, Parameters, Value};

/// Returns the command that breaks `input` by the request of `file` into `output`. Settings that the command line cannot take one by
/// one come from a saved project, whose name is `project`.
pub fn equivalent(file: &RequestFile, input: Option<&str>, output: &str, project: &str) -> String {
    let mut words = vec!["greenstick".to_owned(), "break".to_owned()];
    words.extend(input.map(quoted));
    match settings(file) {
        Some(settings) => {
            for setting in settings {
                words.push("--set".to_owned());
                words.push(quoted(&setting));
            }
        }
        None => {
            words.push("--recipe".to_owned());
            words.push(quoted(project));
        }
    }
    words.push("-o".to_owned());
    words.push(quoted(output));
    words.join(" ")
}

/// Returns what differs from the defaults as settings, `key=value`; none where they cannot say it all.
pub fn settings(file: &RequestFile) -> Option<Vec<String>> {
    let changed = file.changed().into_iter().filter(|p| p.key != "input");
    let one = |p: ParameterInfo| {
        let complex = p.key.contains('[') || matches!(p.value, Value::List(_));
        (!complex).then(|| format!("{}={}", p.key, text(&p.value, p.unit())))
    };
    changed.map(one).collect()
}

/// A value as a setting: lengths must say their unit.
fn text(value: &Value, unit: &str) -> String {
    match (value, unit) {
        (Value::Number(x), "m") => format!("{x}m"),
        _ => value.to_string(),
    }
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_give_the_same_request() {
        let settings = [
            "species=white oak",
            "at=12cm",
            "break.inclination=12.5",
            "part=3cm",
            "break.seed=9",
        ];
        let file = RequestFile::resolve(&["green-stick"], None, &settings).unwrap();
        let command = equivalent(&file, Some("my tree.glb"), "out.glb", "p.greenstick.toml");
        assert!(
            command.starts_with("greenstick break 'my tree.glb' --set "),
            "{command}"
        );
        let settings = super::settings(&file).unwrap();
        let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
        assert_eq!(RequestFile::resolve(&[], None, &settings).unwrap(), file);
    }
}
