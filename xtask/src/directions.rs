//! Which package may depend on which: data flows one way through the crates.

use crate::workspace::{Fault, Package};

/// What each library crate may use. A library crate that is not listed is a fault, so that none is forgotten.
const ALLOWED: [(&str, &[&str]); 10] = [
    ("greenstick-schema", &[]),
    ("greenstick-geometry", &[]),
    (
        "greenstick-formats",
        &["greenstick-schema", "greenstick-geometry"],
    ),
    (
        "greenstick-picture",
        &["greenstick-schema", "greenstick-geometry"],
    ),
    (
        "greenstick-wood",
        &["greenstick-schema", "greenstick-geometry"],
    ),
    (
        "greenstick-fracture",
        &[
            "greenstick-schema",
            "greenstick-geometry",
            "greenstick-wood",
        ],
    ),
    (
        "greenstick-fibre",
        &[
            "greenstick-schema",
            "greenstick-geometry",
            "greenstick-wood",
        ],
    ),
    (
        "greenstick-skin",
        &[
            "greenstick-schema",
            "greenstick-geometry",
            "greenstick-wood",
            "greenstick-fracture",
            "greenstick-fibre",
        ],
    ),
    (
        "greenstick",
        &[
            "greenstick-schema",
            "greenstick-geometry",
            "greenstick-formats",
            "greenstick-picture",
            "greenstick-wood",
            "greenstick-fracture",
            "greenstick-fibre",
            "greenstick-skin",
        ],
    ),
    ("greenstick-sweep", &["greenstick"]),
];

/// What programs (`apps/*`), Python and tools may use: the façade, which re-exports the rest, and many breaks at once.
const FACADE: &[&str] = &["greenstick", "greenstick-sweep"];

/// Finds every dependency between packages of the workspace that runs against the order of crates. Dependencies for
/// tests and builds count like any other.
pub fn faults(packages: &[Package]) -> Vec<Fault> {
    let mut faults = Vec::new();
    for package in packages {
        let allowed = match ALLOWED.iter().find(|(name, _)| *name == package.name) {
            Some((_, allowed)) => *allowed,
            None if package.is_app() => FACADE,
            None if ["greenstick-python", "xtask"].contains(&&*package.name) => FACADE,
            None => {
                faults.push(Fault::from(format!(
                    "{} has no place in the order of crates; give it one in xtask/src/directions.rs",
                    package.name
                )));
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
                faults.push(Fault::from(format!(
                    "{} depends on {dependency}; of the workspace it may use {may}",
                    package.name
                )));
            }
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::packages;
    use serde_json::Value;

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

    fn messages(packages: &[Package]) -> Vec<String> {
        faults(packages).into_iter().map(|f| f.message).collect()
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
        assert_eq!(messages(&house), Vec::<String>::new());
    }

    #[test]
    fn every_crossing_is_reported() {
        let house = workspace(&[
            ("greenstick-geometry", &["greenstick-wood"]),
            ("greenstick-wood", &[]),
            ("greenstick-fracture", &["greenstick-fibre"]),
            ("greenstick-fibre", &["greenstick-fracture"]),
            ("greenstick-formats", &["greenstick-wood"]),
            ("greenstick-attic", &[]),
            ("apps/greenstick-cli", &["greenstick-wood"]),
        ]);
        let faults = messages(&house);
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
