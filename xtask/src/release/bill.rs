//! The bill of materials: every package of others in the programs, in the format CycloneDX 1.5 (ECMA-424).

use super::dependencies::Dependencies;
use serde_json::{Value, json};

/// Returns the bill of Greenstick at `version`.
pub fn cyclone_dx(all: &Dependencies, version: &str) -> Value {
    let reference = |id: &str| {
        all.packages
            .get(id)
            .map(|p| format!("pkg:cargo/{}@{}", p.name, p.version))
    };
    let components: Vec<Value> = (all.packages.iter())
        .map(|(id, package)| {
            json!({
                "type": "library",
                "bom-ref": reference(id),
                "name": package.name,
                "version": package.version,
                "purl": reference(id),
                "licenses": [{"expression": package.licence.replace('/', " OR ")}],
            })
        })
        .collect();
    let dependencies: Vec<Value> = (all.needs.iter())
        .map(|(id, needs)| {
            let needs: Vec<String> = needs.iter().filter_map(|n| reference(n)).collect();
            json!({"ref": reference(id), "dependsOn": needs})
        })
        .collect();
    json!({
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {
            "component": {"type": "application", "bom-ref": "greenstick", "name": "greenstick", "version": version},
        },
        "components": components,
        "dependencies": dependencies,
    })
}

#[cfg(test)]
mod tests {
    use super::super::dependencies::Dependency;
    use super::*;

    #[test]
    fn a_bill_lists_packages_and_what_they_need() {
        let mut all = Dependencies::default();
        for (id, needs) in [("a", &["b"][..]), ("b", &[])] {
            let package = Dependency {
                name: id.to_owned(),
                version: "1.2.3".to_owned(),
                licence: "MIT/Apache-2.0".to_owned(),
                folder: Default::default(),
            };
            all.packages.insert(id.to_owned(), package);
            let needs = needs.iter().map(|&n| n.to_owned()).collect();
            all.needs.insert(id.to_owned(), needs);
        }
        let bill = cyclone_dx(&all, "0.2.0");
        assert_eq!(bill["components"][0]["purl"], "pkg:cargo/a@1.2.3");
        assert_eq!(
            bill["components"][1]["licenses"][0]["expression"],
            "MIT OR Apache-2.0"
        );
        assert_eq!(bill["dependencies"][0]["dependsOn"][0], "pkg:cargo/b@1.2.3");
    }
}
