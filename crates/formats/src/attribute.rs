//! Attributes as they are read from files.

use greenstick_geometry::Mesh;

/// Replaces values that are not finite by 0, with a note.
pub(crate) fn clean_attributes(mesh: &mut Mesh, notes: &mut Vec<String>) {
    for (name, attribute) in &mut mesh.attributes {
        let mut cleaned = 0;
        for v in attribute.data.iter_mut().filter(|v| !v.is_finite()) {
            *v = 0.0;
            cleaned += 1;
        }
        if cleaned > 0 {
            notes.push(format!(
                "{cleaned} values of {name} were not finite and were set to 0."
            ));
        }
    }
}
