//! Vertex attributes as §3.7.2.1 asks for them: unit normals and tangents, names and widths that are allowed.

use crate::assemble::gather;
use glam::{DVec3, Vec3};
use greenstick_geometry::{Attribute, Mesh};
use std::collections::BTreeMap;

/// An attribute ready to be written: how many numbers for each vertex, and the numbers.
pub type Ready = (usize, Vec<f32>);

/// Attributes of the vertices `used`, by the names they get. `triangles` are in the new numbers; `coordinates` is how
/// many sets of texture coordinates the material reads.
pub fn attributes(
    mesh: &Mesh,
    used: &[u32],
    triangles: &[[u32; 3]],
    coordinates: u32,
) -> BTreeMap<String, Ready> {
    let mut out = BTreeMap::new();
    for (name, attribute) in &mesh.attributes {
        let Some(written) = allowed(name, attribute.width) else {
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
        out.entry(written).or_insert((attribute.width, data));
    }
    part_own(&mut out);
    match (out.get("NORMAL").cloned(), out.get_mut("TANGENT")) {
        (Some((_, normals)), Some((_, tangents))) => unit_tangents(tangents, &normals),
        // Tangents mean nothing without normals.
        (None, _) => drop(out.remove("TANGENT")),
        _ => {}
    }
    // Sets have to be numbered without gaps, and materials may only read sets that exist.
    for (set, width, value) in [("TEXCOORD_", 2, 0.0), ("COLOR_", 4, 1.0)] {
        let numbers = out
            .keys()
            .filter_map(|k| k.strip_prefix(set)?.parse::<u32>().ok());
        let highest = numbers.map(|n| n + 1).max().unwrap_or(0);
        let needed = if set == "TEXCOORD_" {
            highest.max(coordinates)
        } else {
            highest
        };
        for n in 0..needed {
            out.entry(format!("{set}{n}"))
                .or_insert_with(|| (width, vec![value; used.len() * width]));
        }
    }
    out
}

/// What the numbers of an attribute of our own are called where they are written one by one.
const COMPONENTS: [&str; 4] = ["_X", "_Y", "_Z", "_W"];

/// Writes attributes that are no standard ones number by number where they are not all of one width: Blender (4.5) takes
/// the widths of such attributes in an order of chance, and fails where that is not the one they are written in.
fn part_own(out: &mut BTreeMap<String, Ready>) {
    let own = |out: &BTreeMap<String, Ready>| -> Vec<(String, usize)> {
        let own = out.iter().filter(|(name, _)| name.starts_with('_'));
        own.map(|(name, ready)| (name.clone(), ready.0)).collect()
    };
    let all = own(out);
    if all.windows(2).all(|w| w[0].1 == w[1].1) {
        return;
    }
    for (name, width) in all.into_iter().filter(|(_, w)| (2..=4).contains(w)) {
        let parts: Vec<String> = COMPONENTS[..width]
            .iter()
            .map(|c| format!("{name}{c}"))
            .collect();
        if parts.iter().any(|p| out.contains_key(p)) {
            continue;
        }
        let Some((_, data)) = out.remove(&name) else {
            continue;
        };
        for (k, part) in parts.into_iter().enumerate() {
            let component = data.iter().skip(k).step_by(width).copied().collect();
            out.insert(part, (1, component));
        }
    }
}

/// Joins attributes that were written number by number.
pub fn join_own(mesh: &mut Mesh) {
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

/// The name under which an attribute may be written, if it may.
fn allowed(name: &str, width: usize) -> Option<String> {
    let set = |prefix: &str| {
        let digits = name.strip_prefix(prefix)?;
        // Sets above a handful are a mistake, and the gaps below them would have to be filled.
        let number: u32 = digits.parse().ok().filter(|&n| n < 16)?;
        (number.to_string() == digits).then_some(())
    };
    let standard = match name {
        "NORMAL" | "TANGENT" => true,
        _ if set("TEXCOORD_").is_some() => width == 2,
        _ if set("COLOR_").is_some() => matches!(width, 3 | 4),
        _ if name.starts_with('_') => {
            let legal = matches!(width, 1..=4 | 16);
            return legal.then(|| name.to_ascii_uppercase());
        }
        _ => false,
    };
    standard.then(|| name.to_owned())
}

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
