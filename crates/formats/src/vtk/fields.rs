//! Data of points, lines and cells.

use super::appended::{CompressedArray, bytes_of, escape};
use crate::error::{FormatError, InFile};
use glam::DVec3;
use greenstick_geometry::Values;

/// Data of points, lines or cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Name, with the unit if there is one: `force_N`.
    pub name: String,
    /// Values for each point, line or cell: 1, 3 for a vector …
    pub components: usize,
    /// The values.
    pub values: Values,
}

impl Field {
    /// A field with one value for each of them.
    pub fn scalar(name: &str, values: Values) -> Self {
        Field {
            name: name.to_owned(),
            components: 1,
            values,
        }
    }

    /// A field with a vector for each of them.
    pub fn vectors(name: &str, vectors: &[DVec3]) -> Self {
        Field {
            name: name.to_owned(),
            components: 3,
            values: Values::F64(vectors.iter().flat_map(|v| v.to_array()).collect()),
        }
    }
}

/// A compressed field with the attributes of its array.
pub(super) struct CompressedField {
    pub attributes: String,
    pub array: CompressedArray,
}

/// Compresses fields.
pub(super) fn compress_fields(fields: &[Field]) -> Vec<CompressedField> {
    let compress = |field: &Field| {
        let (kind, bytes) = bytes_of(&field.values);
        let attributes = format!(
            "type=\"{kind}\" Name=\"{}\" NumberOfComponents=\"{}\"",
            escape(&field.name),
            field.components
        );
        CompressedField {
            attributes,
            array: CompressedArray::new(&bytes),
        }
    };
    fields.iter().map(compress).collect()
}

/// Refuses fields that do not have their components for each of `entries`, or a number that is not finite.
pub(super) fn check_fields(
    fields: &[Field],
    entries: usize,
    file: InFile,
) -> Result<(), FormatError> {
    for field in fields {
        let right = field.components.checked_mul(entries);
        if field.components == 0 || right != Some(field.values.len()) {
            let found = format!("field {} has {} values", field.name, field.values.len());
            let right = format!("{} for each of {entries}", field.components.max(1));
            return Err(file.unwritable(found, right));
        }
        if let Values::F64(values) = &field.values
            && let Some(k) = values.iter().position(|v| !v.is_finite())
        {
            let found = format!("{} in field {}", values[k], field.name);
            return Err(file.unwritable(found, "finite numbers"));
        }
    }
    Ok(())
}
