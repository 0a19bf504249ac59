//! What the published programs are built from, as `cargo metadata` resolves it.

use crate::workspace::metadata_of;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The packages that are published for users to run.
const PUBLISHED: [&str; 2] = ["greenstick-cli", "greenstick-python"];

/// A package of others.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Dependency {
    pub name: String,
    pub version: String,
    /// What it may be used under (an SPDX expression).
    pub licence: String,
    /// Folder of its source.
    pub folder: PathBuf,
}

/// All packages of others, by the identifier of cargo, and which needs which.
#[derive(Debug, Default)]
pub struct Dependencies {
    pub packages: BTreeMap<String, Dependency>,
    pub needs: BTreeMap<String, BTreeSet<String>>,
}

impl Dependencies {
    /// Finds them for the workspace at `root`.
    pub fn of(root: &Path) -> Result<Self, String> {
        let mut all = Dependencies::default();
        let metadata = metadata_of(root, "--locked")?;
        for package in PUBLISHED {
            all.add(&metadata, package)?;
        }
        Ok(all)
    }

    /// Adds what `package` is built from, directly or not, by the output of `cargo metadata`.
    pub fn add(&mut self, metadata: &Value, package: &str) -> Result<(), String> {
        let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
        let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        let by_id: BTreeMap<String, Value> = list(&metadata["packages"])
            .into_iter()
            .map(|p| (text(&p["id"]), p))
            .collect();
        let nodes: BTreeMap<String, Value> = list(&metadata["resolve"]["nodes"])
            .into_iter()
            .map(|n| (text(&n["id"]), n))
            .collect();
        let root = by_id.iter().find(|(_, p)| p["name"] == package);
        let (root, _) = root.ok_or_else(|| format!("cargo metadata has no package `{package}`"))?;
        let mut open = vec![root.clone()];
        let mut seen = BTreeSet::from([root.clone()]);
        while let Some(id) = open.pop() {
            let Some(node) = nodes.get(&id) else { continue };
            let needed = list(&node["deps"]);
            let needed = needed.iter().filter(|d| {
                // What only tests or build scripts need is not in the program.
                list(&d["dep_kinds"]).iter().any(|k| k["kind"].is_null())
            });
            let needed: BTreeSet<String> = needed.map(|d| text(&d["pkg"])).collect();
            for other in &needed {
                if seen.insert(other.clone()) {
                    open.push(other.clone());
                }
            }
            let of = &by_id[&id];
            if of["source"].is_null() {
                continue;
            }
            let manifest = PathBuf::from(text(&of["manifest_path"]));
            self.packages.insert(
                id.clone(),
                Dependency {
                    name: text(&of["name"]),
                    version: text(&of["version"]),
                    licence: text(&of["license"]),
                    folder: manifest.parent().map(Path::to_owned).unwrap_or_default(),
                },
            );
            self.needs.insert(id, needed);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_only_tests_need_is_left_out() {
        let package = |name: &str, source: Option<&str>| {
            json!({"id": name, "name": name, "version": "1.0.0", "license": "MIT", "source": source,
                   "manifest_path": format!("/r/{name}/Cargo.toml")})
        };
        let needs =
            |name: &str, kind: Option<&str>| json!({"pkg": name, "dep_kinds": [{"kind": kind}]});
        let metadata = json!({
            "packages": [package("app", None), package("own", None), package("a", Some("r")),
                         package("b", Some("r")), package("tests", Some("r"))],
            "resolve": {"nodes": [
                {"id": "app", "deps": [needs("own", None), needs("tests", Some("dev"))]},
                {"id": "own", "deps": [needs("a", None)]},
                {"id": "a", "deps": [needs("b", None)]},
                {"id": "b", "deps": []},
                {"id": "tests", "deps": []},
            ]},
        });
        let mut all = Dependencies::default();
        all.add(&metadata, "app").unwrap();
        let names: Vec<&str> = all.packages.values().map(|p| &*p.name).collect();
        assert_eq!(names, ["a", "b"]);
        assert_eq!(all.needs["a"], BTreeSet::from(["b".to_owned()]));
        assert!(all.add(&metadata, "absent").is_err());
    }
}
