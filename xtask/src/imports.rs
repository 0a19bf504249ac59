//! Circles of imports: files of one crate that use each other, directly or by way of others.
//!
//! A file uses another where it names something that the other defines, in a `use` or in a path. Names that a module
//! re-exports are followed to the file that defines them; the re-export itself is no use, and neither is `mod`. Methods
//! are not seen, so that an `impl` may stand in a file of its own.

use crate::modules::{Crate, Path as ModulePath};
use crate::workspace::{Fault, Package, relative};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// For each file the files that it uses, and the names that it takes from them.
type Uses = BTreeMap<usize, BTreeMap<usize, BTreeSet<String>>>;

/// Finds every circle of imports within a crate.
pub fn faults(packages: &[Package], root: &Path) -> Result<Vec<Fault>, String> {
    let mut faults = Vec::new();
    let mut seen = BTreeSet::new();
    for target in packages.iter().flat_map(|p| &p.roots) {
        let tree = Crate::read(target)?;
        let uses = uses(&tree);
        let path = |file: usize| relative(&tree.files[file], root);
        for circle in circles(&uses) {
            let mut files: Vec<String> = circle.iter().map(|&f| path(f)).collect();
            files.sort();
            let exception = format!("circle {}", files.join(" "));
            // A file that several tests share is read with each of them.
            if !seen.insert(exception.clone()) {
                continue;
            }
            let mut message = format!("{} files import each other in a circle:", files.len());
            for (&from, to) in uses.iter().filter(|(from, _)| circle.contains(from)) {
                for (&to, names) in to.iter().filter(|(to, _)| circle.contains(to)) {
                    let names: Vec<&str> = names.iter().map(String::as_str).collect();
                    let (from, to) = (path(from), path(to));
                    message += &format!("\n  {from} takes {} from {to}", names.join(", "));
                }
            }
            faults.push(Fault {
                message,
                exception: Some(exception),
            });
        }
    }
    Ok(faults)
}

/// Which file of a crate uses which.
fn uses(tree: &Crate) -> Uses {
    let mut uses = Uses::new();
    for (number, module) in tree.modules.iter().enumerate() {
        let imports = module.imports.iter().filter(|i| !i.is_public);
        let imported = imports.map(|i| &i.path);
        let mut add = |path: &ModulePath| {
            if let Some(definition) = tree.resolve(number, path)
                && definition.file != module.file
            {
                let names = uses.entry(module.file).or_default();
                names
                    .entry(definition.file)
                    .or_default()
                    .insert(definition.name);
            }
        };
        imported.for_each(&mut add);
        module.paths.iter().for_each(&mut add);
    }
    uses
}

/// Sets of files each of which reaches all others of its set.
fn circles(uses: &Uses) -> Vec<BTreeSet<usize>> {
    let reach: BTreeMap<usize, BTreeSet<usize>> =
        uses.keys().map(|&f| (f, reachable(uses, f))).collect();
    let mut circles: Vec<BTreeSet<usize>> = Vec::new();
    for (&file, reached) in &reach {
        if !reached.contains(&file) || circles.iter().any(|c| c.contains(&file)) {
            continue;
        }
        let returns = |f: &&usize| reach.get(f).is_some_and(|r| r.contains(&file));
        circles.push(reached.iter().filter(returns).copied().collect());
    }
    circles
}

/// The files that a file uses, directly or by way of others; itself only by way of others.
fn reachable(uses: &Uses, file: usize) -> BTreeSet<usize> {
    let mut reached = BTreeSet::new();
    let mut open = vec![file];
    while let Some(next) = open.pop() {
        for &to in uses.get(&next).into_iter().flat_map(BTreeMap::keys) {
            if reached.insert(to) {
                open.push(to);
            }
        }
    }
    reached
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::TestFolder;

    fn found(files: &[(&str, &str)], name: &str) -> Vec<Fault> {
        let folder = TestFolder::new(name, files);
        faults(&[folder.package("src/lib.rs")], &folder.0).unwrap()
    }

    #[test]
    fn re_exports_are_followed_to_the_definition() {
        // Both children take names by way of their parent, which uses neither: no circle.
        let parent = "pub mod b;\nmod c;\npub use b::B;\npub use c::C;\n";
        let none = found(
            &[
                ("src/lib.rs", "pub mod a;\npub use a::C;\n"),
                ("src/a.rs", parent),
                ("src/a/b.rs", "use super::C;\npub struct B(C);\n"),
                (
                    "src/a/c.rs",
                    "pub struct C;\n#[cfg(test)]\nmod tests { use super::*; }\n",
                ),
            ],
            "re-exports",
        );
        assert_eq!(none, []);
    }

    #[test]
    fn circles_are_found_through_paths_globs_and_macros() {
        let circle = found(
            &[
                ("src/lib.rs", "mod a;\nmod b;\nmod c;\nmod d;\nmod e;\n"),
                ("src/a.rs", "pub fn a() { crate::b::b() }\n"),
                (
                    "src/b.rs",
                    "use super::c::{self as see};\npub fn b() { see::c!() }\n",
                ),
                (
                    "src/c.rs",
                    "use crate::d::*;\nmacro_rules! c { () => { d() } }\npub(crate) use c;\n",
                ),
                ("src/d.rs", "pub fn d() { use crate::a::a; a() }\n"),
                ("src/e.rs", "pub fn e() { crate::a::a() }\n"),
            ],
            "circles",
        );
        assert_eq!(circle.len(), 1, "{circle:?}");
        assert_eq!(
            circle[0].message,
            "4 files import each other in a circle:\n  src/a.rs takes b from src/b.rs\n  \
             src/b.rs takes c from src/c.rs\n  src/c.rs takes d from src/d.rs\n  \
             src/d.rs takes a from src/a.rs"
        );
        assert_eq!(
            circle[0].exception.as_deref(),
            Some("circle src/a.rs src/b.rs src/c.rs src/d.rs")
        );
    }
}
