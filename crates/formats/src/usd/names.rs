//! Names of prims and properties.

use super::layer::{Metadatum, Prim, Value};

/// Distinct names that are valid in USD.
#[derive(Default)]
pub(super) struct Names {
    taken: std::collections::BTreeSet<String>,
}

impl Names {
    /// Returns a new name similar to `wanted`, or to `default` if that is empty.
    pub fn unique(&mut self, wanted: &str, default: &str) -> String {
        let replace = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let mut name: String = wanted.chars().map(replace).collect();
        if name.is_empty() {
            name = default.to_owned();
        }
        if name.starts_with(|c: char| c.is_ascii_digit()) {
            name.insert(0, '_');
        }
        let mut unique = name.clone();
        let mut number = 1;
        while !self.taken.insert(unique.clone()) {
            number += 1;
            unique = format!("{name}_{number}");
        }
        unique
    }
}

/// Sets the name to display, unless it is the name of the prim.
pub(super) fn set_display_name(prim: &mut Prim, name: &str) {
    if !name.is_empty() && prim.name != name {
        let name = Value::Text(name.to_owned());
        prim.metadata.push(Metadatum::new("displayName", name));
    }
}
