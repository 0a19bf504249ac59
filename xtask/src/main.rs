//! Checks of the workspace that the compiler does not make, and the files that are written from it. Run as
//! `cargo xtask check`, `cargo xtask generate` and `cargo xtask generate --check`.

mod directions;
mod generate;
mod sources;

use std::path::Path;
use std::process::{Command, ExitCode};

const USAGE: &str = "usage: cargo xtask check | generate [--check]";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let (done, told) = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["check"] => (
            check(&root),
            "crate directions, file lengths and documentation lints are in order",
        ),
        ["generate"] => (
            generate::generate(&root, false),
            "the pages in docs/reference are written",
        ),
        ["generate", "--check"] => (
            generate::generate(&root, true),
            "the pages in docs/reference are what the program prints",
        ),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(faults) if faults.is_empty() => {
            println!("{told}");
            ExitCode::SUCCESS
        }
        Ok(faults) => {
            faults.iter().for_each(|f| eprintln!("{f}"));
            ExitCode::from(1)
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(1)
        }
    }
}

/// Everything that is out of order in the workspace, a line for each.
fn check(root: &Path) -> Result<Vec<String>, String> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let output = Command::new(cargo)
        .args(["metadata", "--format-version", "1", "--no-deps"])
        .current_dir(root)
        .output()
        .map_err(|e| format!("cargo metadata did not start: {e}"))?;
    if !output.status.success() {
        return Err(format!(
            "cargo metadata failed: {}",
            String::from_utf8_lossy(&output.stderr)
        ));
    }
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout)
        .map_err(|e| format!("cargo metadata did not print JSON: {e}"))?;
    let packages = directions::packages(&metadata)?;
    let mut faults = directions::crossings(&packages);
    faults.extend(sources::faults(&packages, root)?);
    Ok(faults)
}
