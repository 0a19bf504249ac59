//! Lengths of source files, and the documentation lint of library crates.

use crate::workspace::{Fault, Package, read, relative, rust_files};
use std::path::Path;

/// Most lines of a source file.
const MAX_LINES: usize = 600;
/// The façade, which only composes, and the most lines of its source.
const FACADE: &str = "greenstick";
const MAX_FACADE_LINES: usize = 5000;
/// The line that the root file of every library has.
const LINT: &str = "#![deny(missing_docs)]";

/// Finds every source file that is too long, and every library that may leave things undocumented.
pub fn faults(packages: &[Package], root: &Path) -> Result<Vec<Fault>, String> {
    let mut faults = Vec::new();
    for package in packages {
        let source = package.folder.join("src");
        let mut all = 0;
        for file in rust_files(&package.folder)? {
            let lines = read(&file)?.lines().count();
            all += if file.starts_with(&source) { lines } else { 0 };
            if lines > MAX_LINES {
                let file = relative(&file, root);
                faults.push(Fault::from(format!(
                    "{file} has {lines} lines; split what exceeds {MAX_LINES}"
                )));
            }
        }
        if package.name == FACADE && all > MAX_FACADE_LINES {
            faults.push(Fault::from(format!(
                "the façade {FACADE} has {all} lines of source; move what exceeds {MAX_FACADE_LINES} to the crates that it composes"
            )));
        }
        if let Some(library) = &package.library
            && !read(library)?.lines().any(|l| l.trim() == LINT)
        {
            let library = relative(library, root);
            faults.push(Fault::from(format!("{library} lacks {LINT}")));
        }
    }
    Ok(faults)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::TestFolder;

    #[test]
    fn long_files_and_missing_lints_are_reported() {
        let folder = TestFolder::new(
            "sources",
            &[
                ("src/lib.rs", "//! x\n"),
                ("src/deep/long.rs", &"\n".repeat(MAX_LINES + 1)),
                ("src/deep/just.rs", &"\n".repeat(MAX_LINES)),
            ],
        );
        let package = folder.package("src/lib.rs");
        let found = |package: &Package| -> Vec<String> {
            let faults = faults(std::slice::from_ref(package), &folder.0).unwrap();
            faults.into_iter().map(|f| f.message).collect()
        };
        assert_eq!(
            found(&package),
            [
                "src/deep/long.rs has 601 lines; split what exceeds 600",
                "src/lib.rs lacks #![deny(missing_docs)]"
            ]
        );
        std::fs::write(folder.0.join("src/lib.rs"), format!("{LINT}\n")).unwrap();
        std::fs::remove_file(folder.0.join("src/deep/long.rs")).unwrap();
        assert!(found(&package).is_empty());
        // The façade is short as a whole; tests and benches do not count.
        let full = "\n".repeat(MAX_LINES);
        std::fs::create_dir(folder.0.join("tests")).unwrap();
        std::fs::write(folder.0.join("tests/t.rs"), &full).unwrap();
        for k in 0..MAX_FACADE_LINES / MAX_LINES {
            std::fs::write(folder.0.join(format!("src/{k}.rs")), &full).unwrap();
        }
        assert!(found(&package).is_empty());
        let mut facade = folder.package("src/lib.rs");
        facade.name = FACADE.to_owned();
        let [fault] = &found(&facade)[..] else {
            panic!("{:?}", found(&facade))
        };
        assert!(fault.contains("has 5401 lines"), "{fault}");
    }
}
