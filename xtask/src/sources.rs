//! Lengths of source files, and the documentation lint of library crates.

use crate::directions::Package;
use std::fs;
use std::path::{Path, PathBuf};

/// Most lines of a source file.
const LINES: usize = 600;
/// What each library's root file says.
const LINT: &str = "#![deny(missing_docs)]";

/// Every source file that is too long, and every library that may leave things undocumented.
pub fn faults(packages: &[Package], root: &Path) -> Result<Vec<String>, String> {
    let mut faults = Vec::new();
    for package in packages {
        for file in rust_files(&package.folder)? {
            let lines = read(&file)?.lines().count();
            if lines > LINES {
                faults.push(format!(
                    "{} has {lines} lines; split what exceeds {LINES}",
                    shown(&file, root)
                ));
            }
        }
        if let Some(library) = &package.library
            && !read(library)?.lines().any(|l| l.trim() == LINT)
        {
            faults.push(format!("{} lacks {LINT}", shown(library, root)));
        }
    }
    Ok(faults)
}

/// All `.rs` files below a folder, sorted, build outputs left out.
fn rust_files(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let told = |e: std::io::Error| format!("{}: {e}", folder.display());
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(told)? {
        let path = entry.map_err(told)?.path();
        if path.is_dir() {
            if path
                .file_name()
                .is_some_and(|n| n != "target" && n != "node_modules")
            {
                files.extend(rust_files(&path)?);
            }
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

fn read(file: &Path) -> Result<String, String> {
    fs::read_to_string(file).map_err(|e| format!("{}: {e}", file.display()))
}

/// The path from the root of the workspace.
fn shown(file: &Path, root: &Path) -> String {
    let root = root.canonicalize().unwrap_or_else(|_| root.to_owned());
    file.strip_prefix(&root)
        .unwrap_or(file)
        .display()
        .to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_files_and_missing_lints_are_told() {
        let folder = std::env::temp_dir().join(format!("greenstick-xtask-{}", std::process::id()));
        fs::create_dir_all(folder.join("src/deep")).unwrap();
        fs::write(folder.join("src/lib.rs"), "//! x\n").unwrap();
        fs::write(folder.join("src/deep/long.rs"), "\n".repeat(LINES + 1)).unwrap();
        fs::write(folder.join("src/deep/just.rs"), "\n".repeat(LINES)).unwrap();
        let mut package = Package {
            name: "x".to_owned(),
            folder: folder.clone(),
            dependencies: Vec::new(),
            library: Some(folder.join("src/lib.rs")),
        };
        let found = faults(std::slice::from_ref(&package), &folder).unwrap();
        assert_eq!(
            found,
            [
                "src/deep/long.rs has 601 lines; split what exceeds 600",
                "src/lib.rs lacks #![deny(missing_docs)]"
            ]
        );
        fs::write(folder.join("src/lib.rs"), format!("{LINT}\n")).unwrap();
        package.folder.push("src");
        fs::remove_file(folder.join("src/deep/long.rs")).unwrap();
        assert!(faults(&[package], &folder).unwrap().is_empty());
        fs::remove_dir_all(folder).unwrap();
    }
}
