//! Parts of a mesh with the vertices that they use.

use greenstick_geometry::{Attribute, Mesh};

/// Vertices of a mesh to each that is used, from which on those that are used are sorted: with fewer, a look at all takes less.
const SCANNED: usize = 16;

/// Returns the vertices that `triangles` use, ascending, and the triangles renumbered accordingly. `slots` is working
/// memory with one `u32::MAX` for each vertex and is restored.
pub(crate) fn compact(
    triangles: impl Iterator<Item = [u32; 3]> + Clone,
    slots: &mut [u32],
) -> (Vec<u32>, Vec<[u32; 3]>) {
    let mut used = Vec::new();
    for i in triangles.clone().flatten() {
        if slots[i as usize] == u32::MAX {
            slots[i as usize] = 0;
            used.push(i);
        }
    }
    if used.len() < slots.len() / SCANNED {
        used.sort_unstable();
    } else {
        let all = (0..).zip(&*slots);
        used = all.filter(|s| *s.1 != u32::MAX).map(|s| s.0).collect();
    }
    for (new, &old) in used.iter().enumerate() {
        slots[old as usize] = new as u32;
    }
    let renumbered = triangles.map(|t| t.map(|i| slots[i as usize])).collect();
    for &old in &used {
        slots[old as usize] = u32::MAX;
    }
    (used, renumbered)
}

/// Returns the values of an attribute at the vertices `used`.
pub(crate) fn gather(attribute: &Attribute, used: &[u32]) -> Vec<f32> {
    match attribute.width {
        1 => gather_wide::<1>(attribute, used),
        2 => gather_wide::<2>(attribute, used),
        3 => gather_wide::<3>(attribute, used),
        4 => gather_wide::<4>(attribute, used),
        width => {
            let mut data = Vec::with_capacity(used.len() * width);
            for &i in used {
                data.extend_from_slice(attribute.at(i as usize));
            }
            data
        }
    }
}

/// As [`gather`], of an attribute whose width is known to the compiler.
fn gather_wide<const N: usize>(attribute: &Attribute, used: &[u32]) -> Vec<f32> {
    let values = attribute.data.as_chunks::<N>().0;
    let data: Vec<[f32; N]> = used.iter().map(|&i| values[i as usize]).collect();
    data.into_flattened()
}

/// Extracts the part of `mesh` that consists of the given triangles.
pub(crate) fn extract(mesh: &Mesh, triangles: &[u32], slots: &mut [u32]) -> Mesh {
    let (used, renumbered) = compact(triangles.iter().map(|&t| mesh.triangles[t as usize]), slots);
    Mesh {
        positions: used.iter().map(|&i| mesh.positions[i as usize]).collect(),
        triangles: renumbered,
        attributes: mesh
            .attributes
            .iter()
            .map(|(name, a)| {
                (
                    name.clone(),
                    Attribute {
                        width: a.width,
                        data: gather(a, &used),
                    },
                )
            })
            .collect(),
        materials: if mesh.materials.is_empty() {
            Vec::new()
        } else {
            triangles
                .iter()
                .map(|&t| mesh.material(t as usize))
                .collect()
        },
    }
}
