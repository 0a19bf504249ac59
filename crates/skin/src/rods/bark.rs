//! Texture coordinates, colours and materials that the outside takes over from the mesh that the stem was found in.

use super::wood::Wood;
use glam::{DVec2, DVec3};
use greenstick_geometry::{Bvh, Mesh};

/// Names of the attributes that are taken over.
const TEXTURE_COORDINATES: &str = "TEXCOORD_0";
const COLORS: &str = "COLOR_0";
/// Texture coordinates that differ by more than this from those that the face's own triangle would give lie beyond a seam.
const SEAM_JUMP: f64 = 0.05;

/// The bark of a stem, which can be sampled at any position.
pub(super) struct Bark<'a> {
    mesh: &'a Mesh,
    tree: &'a Bvh,
    wood: &'a Wood<'a>,
}

/// What a corner of a face of the outside shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BarkSample {
    pub coordinates: DVec2,
    pub color: Option<[f32; 4]>,
}

impl<'a> Bark<'a> {
    /// Returns the bark of `wood` where its mesh has texture coordinates, colours or materials.
    pub fn from_wood(wood: &'a Wood<'a>) -> Option<Self> {
        let (mesh, tree) = wood.bark?;
        let has_attribute = [TEXTURE_COORDINATES, COLORS]
            .iter()
            .any(|n| mesh.attributes.contains_key(*n));
        (has_attribute || !mesh.materials.is_empty()).then_some(Bark { mesh, tree, wood })
    }

    /// Whether it has colours.
    pub fn has_colors(&self) -> bool {
        self.mesh.attributes.contains_key(COLORS)
    }

    /// Returns the triangle of the bark that is nearest to a position at rest in the rods' world, with the weights of its
    /// corners there.
    fn nearest(&self, rest: DVec3) -> Option<(usize, [f64; 3])> {
        let position = self.wood.stem_to_rods.inverse().transform_point3(rest);
        let nearest = self
            .tree
            .nearest_on_mesh(self.mesh, position, f64::INFINITY)?;
        Some((
            nearest.triangle,
            weights(self.mesh.corners(nearest.triangle), nearest.point),
        ))
    }

    /// Samples the bark for a face with these corners. Returns its material and a sample for each corner.
    pub fn sample_face(&self, corners: [DVec3; 3]) -> Option<(u32, [BarkSample; 3])> {
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let (own, _) = self.nearest(middle)?;
        let rods_to_stem = self.wood.stem_to_rods.inverse();
        let mut samples = [None; 3];
        for (sample, &corner) in samples.iter_mut().zip(&corners) {
            let (triangle, share) = self.nearest(corner)?;
            let here = self.interpolate(TEXTURE_COORDINATES, triangle, share);
            let position = rods_to_stem.transform_point3(corner);
            let share_of_own = weights(self.mesh.corners(own), position);
            let on_own = self.interpolate(TEXTURE_COORDINATES, own, share_of_own);
            let pair = |v: [f64; 4]| DVec2::new(v[0], v[1]);
            let coordinates = match (here.map(pair), on_own.map(pair)) {
                (Some(here), Some(on_own)) if here.distance(on_own) > SEAM_JUMP => on_own,
                (here, _) => here.unwrap_or_default(),
            };
            let color = self
                .interpolate(COLORS, triangle, share)
                .map(|c| c.map(|v| v as f32));
            *sample = Some(BarkSample { coordinates, color });
        }
        let [Some(a), Some(b), Some(c)] = samples else {
            return None;
        };
        Some((self.mesh.material(own), [a, b, c]))
    }

    /// Interpolates an attribute on a triangle; missing components are 1.
    fn interpolate(&self, name: &str, triangle: usize, share: [f64; 3]) -> Option<[f64; 4]> {
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

/// Returns the barycentric weights of a point in the plane of a triangle; those of its first corner where it has no area.
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
