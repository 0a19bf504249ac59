//! Which package may depend on which: data flows one way through the crates.

use serde_json::Value;
use std::path::PathBuf;

/// A package of the workspace.
pub struct Package {
    pub name: String,
    /// Folder of its manifest.
    pub folder: PathBuf,
    /// Names of the packages it depends on, those outside the workspace included.
    pub dependencies: Vec<String>,
    /// Root file of its library, where it has one.
    pub library: Option<PathBuf>,
}

impl Package {
    /// Whether it lies in `apps/`.
    fn is_app(&self) -> bool {
        self.folder.parent().is_some_and(|p| p.ends_with("apps"))
    }
}

/// What each library crate may use. A crate that is not listed is a fault, so that none is forgotten.
const ALLOWED: [(&str, &[&str]); 8] = [
    ("greenstick-geometry", &[]),
    ("greenstick-formats", &["greenstick-geometry"]),
    ("greenstick-picture", &["greenstick-geometry"]),
    ("greenstick-wood", &["greenstick-geometry"]),
    (
        "greenstick-fracture",
        &["greenstick-geometry", "greenstick-wood"],
    ),
    (
        "greenstick-fibre",
        &["greenstick-geometry", "greenstick-wood"],
    ),
    (
        "greenstick-skin",
        &[
            "greenstick-geometry",
            "greenstick-wood",
            "greenstick-fracture",
            "greenstick-fibre",
        ],
    ),
    (
        "greenstick",
        &[
            "greenstick-geometry",
            "greenstick-formats",
            "greenstick-picture",
            "greenstick-wood",
            "greenstick-fracture",
            "greenstick-fibre",
            "greenstick-skin",
        ],
    ),
];

/// What programs (`apps/*`) and tools may use: the façade, which hands on the rest.
const FACADE: &[&str] = &["greenstick"];

/// Packages from the output of `cargo metadata`.
pub fn packages(metadata: &Value) -> Result<Vec<Package>, String> {
    let text = |v: &Value, key: &str| {
        v[key]
            .as_str()
            .map(str::to_owned)
            .ok_or_else(|| format!("cargo metadata has a package without `{key}`"))
    };
    let list = metadata["packages"]
        .as_array()
        .ok_or("cargo metadata has no `packages`")?;
    list.iter()
        .map(|package| {
            let manifest = PathBuf::from(text(package, "manifest_path")?);
            let dependencies = package["dependencies"]
                .as_array()
                .map_or(&[][..], Vec::as_slice);
            let targets = package["targets"].as_array().map_or(&[][..], Vec::as_slice);
            let is_library = |t: &&Value| {
                t["kind"]
                    .as_array()
                    .is_some_and(|k| k.iter().any(|k| k == "lib"))
            };
            Ok(Package {
                name: text(package, "name")?,
                folder: manifest.parent().map(PathBuf::from).unwrap_or_default(),
                dependencies: dependencies
                    .iter()
                    .map(|d| text(d, "name"))
                    .collect::<Result<_, _>>()?,
                library: targets
                    .iter()
                    .find(is_library)
                    .and_then(|t| t["src_path"].as_str())
                    .map(PathBuf::from),
            })
        })
        .collect()
}

/// Every dependency between packages of the workspace that runs against the order of the house. Dependencies for
/// tests and builds count like any other.
pub fn crossings(packages: &[Package]) -> Vec<String> {
    let mut faults = Vec::new();
    for package in packages {
        let allowed = match ALLOWED.iter().find(|(name, _)| *name == package.name) {
            Some((_, allowed)) => *allowed,
            None if package.is_app() => FACADE,
            None if package.name == "xtask" => FACADE,
            None => {
                faults.push(format!(
                    "{} has no place in the order of crates; give it one in xtask/src/directions.rs",
                    package.name
                ));
                continue;
            }
        };
        for dependency in &package.dependencies {
            let inside = packages.iter().any(|p| p.name == *dependency);
            if inside && !allowed.contains(&dependency.as_str()) {
                let may = if allowed.is_empty() {
                    "none".to_owned()
                } else {
                    allowed.join(", ")
                };
                faults.push(format!(
                    "{} depends on {dependency}; of the workspace it may use {may}",
                    package.name
                ));
            }
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    fn workspace(dependencies: &[(&str, &[&str])]) -> Vec<Package> {
        let metadata: Vec<Value> = dependencies
            .iter()
            .map(|(name, uses)| {
                let folder = name
                    .strip_prefix("apps/")
                    .map_or(format!("crates/{name}"), |n| format!("apps/{n}"));
                let uses: Vec<Value> = uses
                    .iter()
                    .map(|u| serde_json::json!({ "name": u }))
                    .collect();
                serde_json::json!({
                    "name": name.trim_start_matches("apps/"),
                    "manifest_path": format!("/house/{folder}/Cargo.toml"),
                    "dependencies": uses,
                    "targets": [{ "kind": ["lib"], "src_path": "/house/lib.rs" }],
                })
            })
            .collect();
        packages(&serde_json::json!({ "packages": metadata })).unwrap()
    }

    #[test]
    fn the_order_of_the_house_passes() {
        let house = workspace(&[
            ("greenstick-geometry", &["glam"]),
            ("greenstick-wood", &["greenstick-geometry"]),
            (
                "greenstick-fracture",
                &["greenstick-wood", "greenstick-geometry"],
            ),
            ("greenstick-fibre", &["greenstick-wood"]),
            (
                "greenstick-skin",
                &["greenstick-fracture", "greenstick-fibre"],
            ),
            ("greenstick", &["greenstick-skin"]),
            ("apps/greenstick-cli", &["greenstick", "serde_json"]),
        ]);
        assert_eq!(crossings(&house), Vec::<String>::new());
    }

    #[test]
    fn every_crossing_is_told() {
        let house = workspace(&[
            ("greenstick-geometry", &["greenstick-wood"]),
            ("greenstick-wood", &[]),
            ("greenstick-fracture", &["greenstick-fibre"]),
            ("greenstick-fibre", &["greenstick-fracture"]),
            ("greenstick-formats", &["greenstick-wood"]),
            ("greenstick-attic", &[]),
            ("apps/greenstick-cli", &["greenstick-wood"]),
        ]);
        let faults = crossings(&house);
        assert_eq!(faults.len(), 6, "{faults:?}");
        assert_eq!(
            faults[0],
            "greenstick-geometry depends on greenstick-wood; of the workspace it may use none"
        );
        for (from, to) in [
            ("fracture", "fibre"),
            ("fibre", "fracture"),
            ("formats", "wood"),
            ("cli", "wood"),
        ] {
            let start = format!("greenstick-{from} depends on greenstick-{to};");
            assert!(
                faults.iter().any(|f| f.starts_with(&start)),
                "{start} {faults:?}"
            );
        }
        assert!(faults[4].starts_with("greenstick-attic has no place"));
    }
}
