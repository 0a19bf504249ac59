//! What the outside shows: texture coordinates, colours and material of the mesh that the stem was found in.

use super::Wood;
use glam::{DVec2, DVec3};
use greenstick_geometry::{Bvh, Mesh};

/// Names of the attributes that bark keeps.
const COORDINATES: &str = "TEXCOORD_0";
const COLORS: &str = "COLOR_0";
/// Texture coordinates that differ by more than this from where the face's own triangle would have them lie beyond a
/// seam.
const SEAM: f64 = 0.05;

/// The bark of a stem, to be asked at places.
pub(super) struct Bark<'a> {
    mesh: &'a Mesh,
    tree: &'a Bvh,
    wood: &'a Wood<'a>,
}

/// What a corner of a face of the outside shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Look {
    pub coordinates: DVec2,
    pub color: Option<[f32; 4]>,
}

impl<'a> Bark<'a> {
    /// The bark of `wood`, where its mesh has texture coordinates or colours.
    pub fn of(wood: &'a Wood<'a>) -> Option<Self> {
        let (mesh, tree) = wood.bark?;
        let says = [COORDINATES, COLORS]
            .iter()
            .any(|n| mesh.attributes.contains_key(*n));
        (says || !mesh.materials.is_empty()).then_some(Bark { mesh, tree, wood })
    }

    /// Whether it has colours.
    pub fn has_colors(&self) -> bool {
        self.mesh.attributes.contains_key(COLORS)
    }

    /// Triangle of the bark and weights of its corners at a place at rest in the rods' world.
    fn at(&self, rest: DVec3) -> Option<(usize, [f64; 3])> {
        let place = self.wood.laid.inverse().transform_point3(rest);
        let nearest = self.tree.nearest_on_mesh(self.mesh, place, f64::INFINITY)?;
        Some((
            nearest.triangle,
            weights(self.mesh.corners(nearest.triangle), nearest.point),
        ))
    }

    /// Material and looks of a face with these corners.
    pub fn face(&self, corners: [DVec3; 3]) -> Option<(u32, [Look; 3])> {
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let (own, _) = self.at(middle)?;
        let back = self.wood.laid.inverse();
        let mut looks = [None; 3];
        for (look, &corner) in looks.iter_mut().zip(&corners) {
            let (triangle, share) = self.at(corner)?;
            let here = self.blend(COORDINATES, triangle, share);
            let place = back.transform_point3(corner);
            let on = self.blend(COORDINATES, own, weights(self.mesh.corners(own), place));
            let pair = |v: [f64; 4]| DVec2::new(v[0], v[1]);
            let coordinates = match (here.map(pair), on.map(pair)) {
                (Some(here), Some(on)) if here.distance(on) > SEAM => on,
                (here, _) => here.unwrap_or_default(),
            };
            let color = self
                .blend(COLORS, triangle, share)
                .map(|c| c.map(|v| v as f32));
            *look = Some(Look { coordinates, color });
        }
        let [Some(a), Some(b), Some(c)] = looks else {
            return None;
        };
        Some((self.mesh.material(own), [a, b, c]))
    }

    /// An attribute at a place of a triangle, missing components 1.
    fn blend(&self, name: &str, triangle: usize, share: [f64; 3]) -> Option<[f64; 4]> {
        let attribute = self.mesh.attributes.get(name)?;
        let mut sum = [1.0; 4];
        for (k, sum) in sum.iter_mut().enumerate().take(attribute.width) {
            let corners = self.mesh.triangles[triangle].iter().zip(share);
            *sum = corners
                .map(|(&v, w)| f64::from(attribute.at(v as usize)[k]) * w)
                .sum();
        }
        Some(sum)
    }
}

/// Barycentric weights of a place in the plane of a triangle; those of its first corner where it has no area.
fn weights([a, b, c]: [DVec3; 3], p: DVec3) -> [f64; 3] {
    let (e, f, d) = (b - a, c - a, p - a);
    let normal = e.cross(f);
    let area = normal.length_squared();
    if area == 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let v = d.cross(f).dot(normal) / area;
    let w = e.cross(d).dot(normal) / area;
    [1.0 - v - w, v, w]
}
