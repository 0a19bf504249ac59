//! Checks of the workspace that the compiler does not make. Run as `cargo xtask check`.

mod directions;
mod sources;

use std::path::Path;
use std::process::{Command, ExitCode};

const USAGE: &str = "usage: cargo xtask check";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["check"] => match check() {
            Ok(faults) if faults.is_empty() => {
                println!("crate directions, file lengths and documentation lints are in order");
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
        },
        _ => {
            eprintln!("{USAGE}");
            ExitCode::from(2)
        }
    }
}

/// Everything that is out of order in the workspace, a line for each.
fn check() -> Result<Vec<String>, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let output = Command::new(cargo)
        .args(["metadata", "--format-version", "1", "--no-deps"])
        .current_dir(&root)
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
    faults.extend(sources::faults(&packages, &root)?);
    Ok(faults)
}
