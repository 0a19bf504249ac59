//! Checks of the workspace that the compiler does not make, the files that are generated from it, and what a version is
//! published as. Run as `cargo xtask check`, `cargo xtask generate`, `cargo xtask generate --check`,
//! `cargo xtask page -o FOLDER` and `cargo xtask release --dry-run`.

mod directions;
mod exceptions;
mod functions;
mod generate;
mod imports;
mod lexer;
mod modules;
mod page;
mod references;
mod release;
mod sources;
mod stubs;
mod workspace;

use std::path::Path;
use std::process::ExitCode;

const USAGE: &str =
    "usage: cargo xtask check | generate [--check] | page -o FOLDER | release --dry-run";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    if let [word, option, folder] = &arguments[..]
        && (word.as_str(), option.as_str()) == ("page", "-o")
    {
        return said(page::build(&root, Path::new(folder)));
    }
    let (outcome, message) = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["check"] => (
            check(&root),
            "directions between crates, imports, lengths of files and functions, references and documentation lints \
             are in order",
        ),
        ["generate"] => (
            generate::generate(&root, false),
            "the pages in docs/reference and the types for Python are written",
        ),
        ["generate", "--check"] => (
            generate::generate(&root, true),
            "the pages in docs/reference and the types for Python are what the program prints",
        ),
        ["release", "--dry-run"] => (
            release::build(&root),
            "target/release-files holds all that a version is published as; nothing was published",
        ),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match outcome {
        Ok(faults) if faults.is_empty() => {
            println!("{message}");
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

/// Prints what was done, or what went wrong.
fn said(outcome: Result<String, String>) -> ExitCode {
    match outcome {
        Ok(message) => {
            println!("{message}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(1)
        }
    }
}

/// Everything that is out of order in the workspace, as messages.
fn check(root: &Path) -> Result<Vec<String>, String> {
    let packages = workspace::packages(&workspace::metadata(root)?)?;
    let mut faults = directions::faults(&packages);
    faults.extend(sources::faults(&packages, root)?);
    faults.extend(functions::faults(&packages, root)?);
    faults.extend(imports::faults(&packages, root)?);
    faults.extend(references::faults(root)?);
    let list = root.join(exceptions::FILE);
    let list = if list.exists() {
        workspace::read(&list)?
    } else {
        String::new()
    };
    let remaining = exceptions::pass(faults, &list);
    if remaining.passed > 0 {
        println!(
            "{} faults of {} pass for now",
            remaining.passed,
            exceptions::FILE
        );
    }
    Ok(remaining.faults.into_iter().map(|f| f.message).collect())
}
