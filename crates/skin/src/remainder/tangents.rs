//! Tangents for normal maps.

use glam::{DVec2, DVec3};
use greenstick_geometry::{Attribute, Mesh};

/// Adds tangents, as glTF has them, to a mesh that has normals and texture coordinates but no tangents.
pub(crate) fn add_tangents(mesh: &mut Mesh) {
    let of = |name: &str, width: usize| mesh.attributes.get(name).filter(|a| a.width == width);
    let (Some(normals), Some(coordinates)) = (of("NORMAL", 3), of("TEXCOORD_0", 2)) else {
        return;
    };
    if mesh.attributes.contains_key("TANGENT") {
        return;
    }
    let mut sums = vec![[DVec3::ZERO; 2]; mesh.positions.len()];
    let at = |v: u32| {
        let uv = coordinates.at(v as usize);
        DVec2::new(uv[0].into(), uv[1].into())
    };
    for (t, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        let [p, q, r] = mesh.corners(t);
        let (e, f, u, v) = (q - p, r - p, at(b) - at(a), at(c) - at(a));
        let sign = u.perp_dot(v).signum();
        for corner in [a, b, c] {
            let sum = &mut sums[corner as usize];
            sum[0] += (e * v.y - f * u.y) * sign;
            sum[1] += (f * u.x - e * v.x) * sign;
        }
    }
    let mut data = Vec::with_capacity(4 * sums.len());
    for (v, [tangent, bitangent]) in sums.into_iter().enumerate() {
        let n = normals.at(v);
        let n = DVec3::new(n[0].into(), n[1].into(), n[2].into()).normalize_or(DVec3::Z);
        let t = tangent.reject_from_normalized(n).try_normalize();
        let t = t.unwrap_or_else(|| n.any_orthonormal_vector());
        let handedness = if n.cross(t).dot(bitangent) < 0.0 {
            -1.0
        } else {
            1.0
        };
        let [x, y, z] = t.as_vec3().to_array();
        data.extend([x, y, z, handedness]);
    }
    let tangents = Attribute { width: 4, data };
    mesh.attributes.insert("TANGENT".into(), tangents);
}
