//! The licences of what the programs are built from: whether all are permissive, and their texts.

use super::dependencies::{Dependencies, Dependency};
use crate::workspace;
use std::collections::BTreeMap;
use std::fs;

/// Licences under which code may be part of programs that are MIT or Apache-2.0 (SPDX identifiers).
const PERMISSIVE: [&str; 14] = [
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "MIT",
    "MIT-0",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
    "bzip2-1.0.6",
];
/// How files that hold a licence begin.
const FILES: [&str; 5] = ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE"];

/// Whether an SPDX expression lets code be used under permissive licences alone.
fn is_permissive(expression: &str) -> bool {
    // An older notation of "OR".
    let expression = expression.replace('/', " OR ");
    expression.split(" AND ").all(|part| {
        part.split(" OR ").any(|one| {
            let one = one.trim_matches(|c: char| c == '(' || c == ')' || c.is_whitespace());
            PERMISSIVE.contains(&one)
        })
    })
}

/// Returns a message for every package that may not be used.
pub fn faults(all: &Dependencies) -> Vec<String> {
    let wrong = all.packages.values().filter(|p| !is_permissive(&p.licence));
    wrong
        .map(|p| {
            format!(
                "{} {} is licensed under \"{}\", which is not known as permissive",
                p.name, p.version, p.licence
            )
        })
        .collect()
}

/// Returns the texts of all licences, each once, with the packages that it is of.
pub fn texts(all: &Dependencies) -> Result<String, String> {
    let mut by_text: BTreeMap<String, Vec<&Dependency>> = BTreeMap::new();
    for package in all.packages.values() {
        let found = texts_of(package)?;
        if found.is_empty() {
            let only = format!(
                "(the package holds no text of its licence, {})\n",
                package.licence
            );
            by_text.entry(only).or_default().push(package);
        }
        for text in found {
            by_text.entry(text).or_default().push(package);
        }
    }
    let mut out = "Greenstick is built from the work of others, under these licences.\n".to_owned();
    for (text, packages) in &by_text {
        out += &format!("\n{}\n", "=".repeat(80));
        for package in packages {
            out += &format!(
                "{} {} ({})\n",
                package.name, package.version, package.licence
            );
        }
        out += &format!("{}\n\n{}\n", "-".repeat(80), text.trim_end());
    }
    Ok(out)
}

/// The licences and notices in the folder of a package.
fn texts_of(package: &Dependency) -> Result<Vec<String>, String> {
    let is_licence = |path: &std::path::Path| {
        let name = path
            .file_name()
            .and_then(|n| n.to_str())
            .unwrap_or_default();
        let name = name.to_uppercase();
        path.parent() == Some(&*package.folder) && FILES.iter().any(|f| name.starts_with(f))
    };
    let mut texts = Vec::new();
    for file in workspace::files_below(&package.folder, &is_licence)? {
        let bytes = fs::read(&file).map_err(|e| format!("{}: {e}", file.display()))?;
        let text = String::from_utf8_lossy(&bytes).replace("\r\n", "\n");
        if !texts.contains(&text) {
            texts.push(text);
        }
    }
    Ok(texts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_expression_is_permissive_if_one_of_each_choice_is() {
        for good in [
            "MIT",
            "MIT/Apache-2.0",
            "GPL-3.0 OR MIT",
            "(MIT OR GPL-2.0) AND Unicode-3.0",
        ] {
            assert!(is_permissive(good), "{good}");
        }
        for bad in [
            "",
            "GPL-3.0",
            "MIT AND GPL-3.0",
            "MPL-2.0",
            "LGPL-2.1 OR GPL-3.0",
        ] {
            assert!(!is_permissive(bad), "{bad}");
        }
    }
}
