//! Vertex attributes as §3.7.2.1 requires them: unit normals and tangents, valid names and widths.

use crate::subset::gather;
use glam::{DVec3, Vec3};
use greenstick_geometry::{Attribute, Mesh};
use std::collections::BTreeMap;

/// Prepares the attributes of the vertices `used`, by the names under which they are written. `triangles` are numbered
/// accordingly; `coordinate_sets` is the number of sets of texture coordinates that the material reads.
pub(crate) fn prepared_attributes(
    mesh: &Mesh,
    used: &[u32],
    triangles: &[[u32; 3]],
    coordinate_sets: u32,
) -> BTreeMap<String, Attribute> {
    let mut out = BTreeMap::new();
    for (name, attribute) in &mesh.attributes {
        let Some(written) = valid_name(name, attribute.width) else {
            continue;
        };
        let mut data = gather(attribute, used);
        data.iter_mut()
            .filter(|v| !v.is_finite())
            .for_each(|v| *v = 0.0);
        if name.starts_with("COLOR_") {
            data.iter_mut().for_each(|v| *v = v.clamp(0.0, 1.0));
        } else if name == "NORMAL" {
            unit_normals(&mut data, mesh, used, triangles);
        }
        out.entry(written).or_insert(Attribute {
            width: attribute.width,
            data,
        });
    }
    split_components(&mut out);
    match (out.get("NORMAL").cloned(), out.get_mut("TANGENT")) {
        (Some(normals), Some(tangents)) => unit_tangents(&mut tangents.data, &normals.data),
        // Tangents are meaningless without normals.
        (None, _) => drop(out.remove("TANGENT")),
        _ => {}
    }
    // Sets must be numbered without gaps, and materials may only read sets that exist.
    for (set, width, value) in [("TEXCOORD_", 2, 0.0), ("COLOR_", 4, 1.0)] {
        let numbers = out
            .keys()
            .filter_map(|k| k.strip_prefix(set)?.parse::<u32>().ok());
        let highest = numbers.map(|n| n + 1).max().unwrap_or(0);
        let needed = if set == "TEXCOORD_" {
            highest.max(coordinate_sets)
        } else {
            highest
        };
        for n in 0..needed {
            out.entry(format!("{set}{n}")).or_insert_with(|| Attribute {
                width,
                data: vec![value; used.len() * width],
            });
        }
    }
    out
}

/// Suffixes of attributes that hold single components of an application-specific attribute.
const COMPONENTS: [&str; 4] = ["_X", "_Y", "_Z", "_W"];

/// Splits application-specific attributes (`_NAME`) into their components if they have different widths: Blender (4.5)
/// assigns the widths of such attributes in a random order, and fails unless it is the order in the file.
fn split_components(out: &mut BTreeMap<String, Attribute>) {
    let specific = out.iter().filter(|(name, _)| name.starts_with('_'));
    let specific: Vec<(String, usize)> = specific.map(|(n, a)| (n.clone(), a.width)).collect();
    if specific.windows(2).all(|w| w[0].1 == w[1].1) {
        return;
    }
    for (name, width) in specific.into_iter().filter(|(_, w)| (2..=4).contains(w)) {
        let parts: Vec<String> = COMPONENTS[..width]
            .iter()
            .map(|c| format!("{name}{c}"))
            .collect();
        if parts.iter().any(|p| out.contains_key(p)) {
            continue;
        }
        let Some(Attribute { data, .. }) = out.remove(&name) else {
            continue;
        };
        for (k, part) in parts.into_iter().enumerate() {
            let data = data.chunks_exact(width).map(|value| value[k]).collect();
            out.insert(part, Attribute { width: 1, data });
        }
    }
}

/// Joins attributes that hold single components, the inverse of [`split_components`].
pub(super) fn join_components(mesh: &mut Mesh) {
    let first = COMPONENTS[0];
    let bases: Vec<String> = (mesh.attributes.keys())
        .filter(|name| name.starts_with('_'))
        .filter_map(|name| name.strip_suffix(first).map(str::to_owned))
        .filter(|base| base.len() > 1 && !mesh.attributes.contains_key(base))
        .collect();
    for base in bases {
        let parts: Vec<String> = COMPONENTS
            .iter()
            .map(|c| format!("{base}{c}"))
            .take_while(|p| mesh.attributes.get(p).is_some_and(|a| a.width == 1))
            .collect();
        if parts.len() < 2 {
            continue;
        }
        let width = parts.len();
        let parts: Vec<_> = parts
            .iter()
            .filter_map(|p| mesh.attributes.remove(p))
            .collect();
        let vertices = parts.iter().map(|p| p.data.len()).min().unwrap_or(0);
        let data = (0..vertices)
            .flat_map(|v| parts.iter().map(move |p| p.data[v]))
            .collect();
        mesh.attributes.insert(base, Attribute { width, data });
    }
}

/// The name under which an attribute is written, if glTF allows it.
fn valid_name(name: &str, width: usize) -> Option<String> {
    let set = |prefix: &str| {
        let digits = name.strip_prefix(prefix)?;
        // The gaps below high set numbers would have to be filled.
        let number: u32 = digits.parse().ok().filter(|&n| n < 16)?;
        (number.to_string() == digits).then_some(())
    };
    let standard = match name {
        "NORMAL" | "TANGENT" => true,
        _ if set("TEXCOORD_").is_some() => width == 2,
        _ if set("COLOR_").is_some() => matches!(width, 3 | 4),
        _ if name.starts_with('_') => {
            let valid = matches!(width, 1..=4 | 16);
            return valid.then(|| name.to_ascii_uppercase());
        }
        _ => false,
    };
    standard.then(|| name.to_owned())
}

/// Normalises normals; those of length 0 are computed from the triangles.
fn unit_normals(data: &mut [f32], mesh: &Mesh, used: &[u32], triangles: &[[u32; 3]]) {
    let mut degenerate = false;
    for n in data.as_chunks_mut::<3>().0 {
        let v = Vec3::from_array(*n).as_dvec3().normalize_or_zero();
        degenerate |= v == DVec3::ZERO;
        *n = v.as_vec3().to_array();
    }
    if !degenerate {
        return;
    }
    let mut sums = vec![DVec3::ZERO; used.len()];
    for t in triangles {
        let [a, b, c] = t.map(|i| mesh.positions[used[i as usize] as usize]);
        let area = (b - a).cross(c - a);
        for &i in t {
            sums[i as usize] += area;
        }
    }
    for (n, sum) in data.as_chunks_mut::<3>().0.iter_mut().zip(sums) {
        if *n == [0.0; 3] {
            *n = sum.try_normalize().unwrap_or(DVec3::Z).as_vec3().to_array();
        }
    }
}

/// Normalises tangents; those of length 0 become any vector perpendicular to the normal.
fn unit_tangents(tangents: &mut [f32], normals: &[f32]) {
    for (t, n) in tangents
        .as_chunks_mut::<4>()
        .0
        .iter_mut()
        .zip(normals.as_chunks::<3>().0)
    {
        let direction = Vec3::new(t[0], t[1], t[2]).as_dvec3().try_normalize();
        let direction = direction.unwrap_or_else(|| {
            Vec3::from_array(*n)
                .as_dvec3()
                .normalize()
                .any_orthonormal_vector()
        });
        let d = direction.as_vec3();
        *t = [d.x, d.y, d.z, if t[3] < 0.0 { -1.0 } else { 1.0 }];
    }
}
