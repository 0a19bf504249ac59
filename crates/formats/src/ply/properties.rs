//! The meaning of vertex properties.

use super::header::{Element, Property};
use crate::error::{FormatError, InFile};

/// The attribute that a property is a component of.
pub(super) struct AttributeComponent {
    pub attribute: String,
    pub component: usize,
    /// The value that stands for 1.
    pub scale: f64,
}

impl AttributeComponent {
    /// The meaning of a vertex property other than a coordinate.
    pub fn from_property(property: &Property) -> Self {
        let (attribute, component) = match property.name.as_str() {
            "nx" => ("NORMAL", 0),
            "ny" => ("NORMAL", 1),
            "nz" => ("NORMAL", 2),
            "s" | "u" | "texture_u" | "texture_s" => ("TEXCOORD_0", 0),
            "t" | "v" | "texture_v" | "texture_t" => ("TEXCOORD_0", 1),
            "red" | "r" | "diffuse_red" => ("COLOR_0", 0),
            "green" | "g" | "diffuse_green" => ("COLOR_0", 1),
            "blue" | "b" | "diffuse_blue" => ("COLOR_0", 2),
            "alpha" | "a" | "diffuse_alpha" => ("COLOR_0", 3),
            other => {
                let bare = other.trim_start_matches('_').to_ascii_uppercase();
                return AttributeComponent {
                    attribute: format!("_{bare}"),
                    component: 0,
                    scale: 1.0,
                };
            }
        };
        let is_colour = attribute == "COLOR_0";
        AttributeComponent {
            attribute: attribute.to_owned(),
            component,
            scale: if is_colour {
                property.number_type.full_intensity()
            } else {
                1.0
            },
        }
    }
}

/// Finds the properties that are the coordinates x, y and z.
pub(super) fn coordinate_properties(
    element: &Element,
    file: InFile,
) -> Result<[usize; 3], FormatError> {
    let find = |name: &str| {
        let found = element
            .properties
            .iter()
            .position(|p| p.name == name && p.list.is_none());
        found.ok_or_else(|| file.malformed("vertex", format!("no {name}"), "x, y and z"))
    };
    Ok([find("x")?, find("y")?, find("z")?])
}
