//! Text that only the people of one workplace can make sense of: paths of some machine, documents and discussions that
//! are not in the repository.

use crate::workspace::{Fault, files_below, read, relative};
use std::path::Path;

/// What may not occur in sources and documentation, and what stands for it in messages. The texts are put together here,
/// so that this file does not hold them.
const FORBIDDEN: [(&str, &str); 6] = [
    (concat!("/wo", "rk/"), "a path of some machine"),
    (concat!("/ho", "me/"), "a path of some machine"),
    (concat!("/ro", "ot/"), "a path of some machine"),
    (concat!("/Us", "ers/"), "a path of some machine"),
    (
        concat!("mod", "el.md"),
        "a document that is not in the repository",
    ),
    (
        concat!("iss", "ue \""),
        "a discussion that is not in the repository",
    ),
];

/// Endings of the files that are searched; files without an ending are searched in `.ci`.
const ENDINGS: [&str; 7] = ["rs", "md", "toml", "py", "mjs", "sh", "yml"];

/// Finds every reference that a reader of the repository cannot follow.
pub fn faults(root: &Path) -> Result<Vec<Fault>, String> {
    let wanted = |path: &Path| match path.extension().and_then(|e| e.to_str()) {
        Some(ending) => ENDINGS.contains(&ending),
        None => path.parent().and_then(Path::file_name) == Some(".ci".as_ref()),
    };
    let mut faults = Vec::new();
    for file in files_below(root, &wanted)? {
        let path = relative(&file, root);
        for (line, text) in (1..).zip(read(&file)?.lines()) {
            if let Some((found, what)) = FORBIDDEN.iter().find(|(text_, _)| text.contains(text_)) {
                faults.push(Fault {
                    message: format!(
                        "{path}:{line}: `{found}` refers to {what}; cite what a reader can open"
                    ),
                    exception: Some(format!("reference {path}")),
                });
            }
        }
    }
    Ok(faults)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::TestFolder;

    #[test]
    fn references_nobody_can_follow_are_reported() {
        let bad = format!("// ok\n// see {} §3\n", FORBIDDEN[4].0);
        let script = format!("cd {}me\n", FORBIDDEN[1].0);
        let folder = TestFolder::new(
            "references",
            &[
                ("src/a.rs", &bad),
                (".ci/run", &script),
                ("target/b.rs", &bad),
                ("notes", &bad),
            ],
        );
        let found = faults(&folder.0).unwrap();
        let places: Vec<&str> = found
            .iter()
            .map(|f| f.message.split(": ").next().unwrap())
            .collect();
        assert_eq!(places, [".ci/run:1", "src/a.rs:2"]);
    }
}
