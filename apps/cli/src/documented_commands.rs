//! Tests that the commands of the documentation and of the help texts, and the recipes and scenes in the documentation, are
//! ones that the program takes.

use crate::arguments::{Arguments, Command};
use crate::{break_wood, simulate};
use clap::{CommandFactory, Parser};
use greenstick::RequestFile;
use greenstick::fibre::scene::Scene;
use greenstick_sweep::Sweep;
use std::path::{Path, PathBuf};

/// A command, and where it stands.
struct Documented {
    place: String,
    text: String,
}

/// Splits a command into words as a shell does, up to a comment, a pipe or a redirection. `$(…)` and variables are not
/// expanded.
fn words(text: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut quote = None;
    let mut quoted_word = false;
    for c in text.chars() {
        let starts = words.last().is_some_and(String::is_empty) && !quoted_word;
        match (quote, c) {
            (Some(open), _) if c == open => quote = None,
            (None, '"' | '\'') => (quote, quoted_word) = (Some(c), true),
            (None, ' ') if starts => {}
            (None, ' ') => {
                words.push(String::new());
                quoted_word = false;
            }
            (None, '#') if starts => break,
            (None, '|' | '>' | '<' | '&' | ';') => break,
            _ => words.last_mut().unwrap().push(c),
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// The commands of a page: lines of its blocks of shell, and spans of code in its paragraphs.
fn of_page(path: &Path) -> Vec<Documented> {
    let text = std::fs::read_to_string(path).unwrap().replace("\\\n", " ");
    let mut block: Option<bool> = None;
    let mut paragraph = String::new();
    let mut found: Vec<String> = Vec::new();
    for line in text.lines().chain([""]) {
        match (line.strip_prefix("```"), block) {
            (Some(_), Some(_)) => block = None,
            (Some(language), None) => block = Some(language == "sh"),
            (None, Some(is_shell)) => found.extend(is_shell.then(|| line.to_owned())),
            // A span may go on in the next line.
            (None, None) if !line.trim().is_empty() => paragraph += &format!("{line} "),
            (None, None) => {
                let spans = paragraph.split('`').skip(1).step_by(2);
                found.extend(spans.map(str::to_owned));
                paragraph.clear();
            }
        }
    }
    let commands = found
        .into_iter()
        .filter(|text| text.starts_with("greenstick "));
    let documented = |text| Documented {
        place: path.display().to_string(),
        text,
    };
    commands.map(documented).collect()
}

/// The examples in the help of the program and of its commands; two spaces part them from what is said about them.
fn of_help() -> Vec<Documented> {
    let program = Arguments::command();
    let commands = program.get_subcommands().chain([&program]);
    let examples = |command: &clap::Command| {
        let help = command.get_after_help().map(ToString::to_string);
        let help = help.unwrap_or_default();
        // Lines that go on in the next one.
        let help: String = help.split("\\\n").map(str::trim_start).collect();
        let lines = help.lines().filter_map(|l| l.strip_prefix("  greenstick "));
        let commands: Vec<Documented> = lines
            .map(|line| Documented {
                place: format!("greenstick {} --help", command.get_name()),
                text: format!("greenstick {}", line.split("  ").next().unwrap_or(line)),
            })
            .collect();
        commands
    };
    commands.flat_map(examples).collect()
}

/// README.md and the pages in docs/.
fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut pages = vec![root.join("README.md")];
    for folder in ["docs", "docs/reference"] {
        let entries = std::fs::read_dir(root.join(folder)).unwrap();
        pages.extend(entries.map(|entry| entry.unwrap().path()));
    }
    pages.retain(|page| page.extension().is_some_and(|e| e == "md"));
    pages.sort();
    pages
}

/// What is wrong with a command: options that the program does not have, values out of range, presets, keys and scenes that
/// do not exist. Files are not looked for.
fn fault(words: &[String]) -> Option<String> {
    let program = Arguments::command();
    // The text names a command, or one of its options, without what they need.
    if let [_, name, rest @ ..] = words {
        let option = rest.first();
        let has = |option: &String| {
            let command = program.find_subcommand(name);
            let mut long = command.into_iter().flat_map(|c| c.get_arguments());
            long.any(|a| a.get_long().is_some_and(|l| option == &format!("--{l}")))
        };
        let is_known = option.map_or(program.find_subcommand(name).is_some(), has);
        if words.len() <= 3 && is_known {
            return None;
        }
    }
    let parsed = match Arguments::try_parse_from(words) {
        Ok(parsed) => parsed,
        Err(error) => return Some(error.to_string()),
    };
    let is_placeholder = |text: &String| text.chars().all(|c| c.is_ascii_uppercase());
    match parsed.command {
        Command::Break(options)
            if options.recipe.is_none()
                && options.rings_from.is_none()
                && !options.preset.iter().any(is_placeholder) =>
        {
            let resolved = break_wood::resolve_request(&options);
            resolved.err().map(|failure| format!("{failure:?}"))
        }
        Command::Simulate(options) => {
            let name = options.scene.filter(|name| !is_placeholder(name))?;
            let is_file = Path::new(&name).extension().is_some_and(|e| e == "toml");
            let read = (!is_file).then(|| simulate::read(&name))?;
            read.err().map(|failure| format!("{failure:?}"))
        }
        _ => None,
    }
}

#[test]
fn commands_of_the_documentation_are_ones_that_the_program_takes() {
    let mut commands: Vec<Documented> = pages().iter().flat_map(|page| of_page(page)).collect();
    let on_pages = commands.len();
    commands.extend(of_help());
    assert!(on_pages > 150, "{on_pages} commands found");
    assert!(commands.len() > on_pages + 30, "{}", commands.len());
    let faults: Vec<String> = commands
        .iter()
        .filter_map(|c| {
            Some(format!(
                "{}: {}\n{}",
                c.place,
                c.text,
                fault(&words(&c.text))?
            ))
        })
        .collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn a_command_with_an_unknown_option_preset_key_or_scene_is_a_fault() {
    for text in [
        "greenstick break --sped 3",
        "greenstick break --preset no-such",
        "greenstick break --set no.such=1",
        "greenstick break --moisture -3",
        "greenstick simulate no-such -o run",
    ] {
        assert!(fault(&words(text)).is_some(), "{text}");
    }
    assert_eq!(
        words("greenstick break --species \"white oak\"  -o 'a b.glb' # as above"),
        [
            "greenstick",
            "break",
            "--species",
            "white oak",
            "-o",
            "a b.glb"
        ]
    );
}

/// The recipes and scenes of a page: its blocks of TOML.
fn files_of_page(path: &Path) -> Vec<Documented> {
    let text = std::fs::read_to_string(path).unwrap();
    let blocks = text.split("\n```toml\n").skip(1);
    let documented = |(i, block): (usize, &str)| Documented {
        place: format!("{}, block {} of TOML", path.display(), i + 1),
        text: block.split("\n```").next().unwrap_or(block).to_owned(),
    };
    blocks.enumerate().map(documented).collect()
}

/// What is wrong with a recipe, a scene or a sweep; only scenes have rods, and only sweeps have keys that vary. The trees of a
/// forest are looked for where it is read: a tree of the test data stands for them.
fn file_fault(text: &str) -> Option<String> {
    if text.contains("\n[rods]") {
        Scene::read(text).err().map(|e| e.to_string())
    } else if text.contains("\n[vary]") {
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data");
        let text = text.replace("\"forest.glb\"", "\"kaykit_Tree_Bare_1_C_Color1.obj\"");
        Sweep::read(&text, &data).err().map(|e| e.to_string())
    } else {
        let file = RequestFile::resolve(&[], Some(text), &[]);
        file.err().map(|e| e.to_string())
    }
}

#[test]
fn recipes_and_scenes_of_the_documentation_are_ones_that_the_program_takes() {
    let pages = pages();
    let files: Vec<Documented> = pages.iter().flat_map(|page| files_of_page(page)).collect();
    let scenes = files.iter().filter(|f| f.text.contains("\n[rods]")).count();
    assert!(scenes > 0 && files.len() - scenes > 2, "{scenes} scenes");
    let fault = |f: &Documented| Some(format!("{}: {}", f.place, file_fault(&f.text)?));
    let faults: Vec<String> = files.iter().filter_map(fault).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    let scene = files.iter().find(|f| f.text.contains("\n[rods]")).unwrap();
    let fault = file_fault(&scene.text.replace("Oak, northern red", "red oak, northern"));
    let named = "wood.species: unknown species \"red oak, northern\"; did you mean";
    assert!(
        fault.as_deref().is_some_and(|f| f.contains(named)),
        "{fault:?}"
    );
}
