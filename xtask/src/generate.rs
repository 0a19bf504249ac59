//! The reference pages below `docs/reference`, as the program prints them, and the types of parameters for Python.

use crate::stubs;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Pages, and the program's commands that print them.
const PAGES: [(&str, &str); 5] = [
    ("parameters", "parameters"),
    ("presets", "presets"),
    ("scenes", "simulate"),
    ("species", "species"),
    ("sweeps", "sweep"),
];

/// The first line of every page, which says where to change it.
const MARK: &str =
    "<!-- Written by `cargo xtask generate`; change the declarations, not this file. -->\n\n";

/// The file of types for Python.
const STUBS: &str = "python/greenstick/_keys.pyi";

/// Writes every file or, with `check`, only compares it. Returns a message for each page that differs.
pub fn generate(root: &Path, check: bool) -> Result<Vec<String>, String> {
    let folder = root.join("docs/reference");
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut texts = Vec::new();
    for (page, command) in PAGES {
        let text = format!("{MARK}{}", printed(root, &[command, "--markdown"])?);
        texts.push((format!("docs/reference/{page}.md"), text));
    }
    let listed = printed(root, &["parameters", "--json"])?;
    texts.push((STUBS.to_owned(), stubs::stubs(&listed)?));
    let mut faults = Vec::new();
    for (name, text) in texts {
        let path = root.join(&name);
        if !check {
            fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))?;
        } else if fs::read_to_string(&path).ok().as_deref() != Some(&text) {
            faults.push(format!(
                "{name} is not what the program prints; run `cargo xtask generate`"
            ));
        }
    }
    Ok(faults)
}

/// Returns what `greenstick ARGUMENTS` prints: the program that `GREENSTICK_PROGRAM` names, or that of the workspace, which is built.
fn printed(root: &Path, wanted: &[&str]) -> Result<String, String> {
    let command = wanted.join(" ");
    let mut program = match std::env::var_os("GREENSTICK_PROGRAM") {
        Some(program) => Command::new(program),
        None => {
            let mut cargo =
                Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
            cargo.args([
                "run",
                "--quiet",
                "--release",
                "--package",
                "greenstick-cli",
                "--",
            ]);
            cargo
        }
    };
    let output = program
        .args(wanted)
        .current_dir(root)
        .output()
        .map_err(|e| format!("greenstick {command} did not start: {e}"))?;
    let errors = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        return Err(format!("greenstick {command} failed: {errors}"));
    }
    String::from_utf8(output.stdout)
        .map_err(|e| format!("greenstick {command} did not print UTF-8: {e}"))
}
