//! Where the vertices of a face in spiral grain lie in the world.
//!
//! The skin consists of straight triangles, and is cut as if they were straight in grain space too. In spiral grain they are
//! not: the map R from grain space takes a straight triangle there to a bowed one. Skin that is flat in the world is folded
//! in grain space, by little, but a face that runs closely below the fold would come to lie in the flat skin or beyond it.
//! So vertices near the skin are moved as the skin itself is: with the point q of the skin nearest to a vertex g in grain
//! space, and S the map that is linear on each triangle of the skin, g lies at R(g) + w (S(q) − R(q)). The weight w falls from
//! 1 on the skin to 0 at a distance of [`FADE_RADII`], over which the bow is small. A vertex that comes to lie less than
//! the least depth below the skin is moved that deep.

use crate::source::Source;
use glam::DVec3;
use greenstick_fracture::cut::{Cut, Skin};
use greenstick_geometry::{Aabb, Bvh, closest_point_on_triangle};

/// Distance from the skin, radii, at which its bow no longer moves vertices: many times the greatest bow, which is 2 % of
/// the radius, so that what is moved does not fold, and less than the radius, so that sides opposite each other do not meet.
const FADE_RADII: f64 = 0.3;

/// The skin about a cut, and the map from grain space that agrees with it.
pub(super) struct Placement<'a> {
    source: Source<'a>,
    /// Grain coordinates and positions of the skin's triangles.
    grain: Vec<[DVec3; 3]>,
    places: Vec<[DVec3; 3]>,
    tree: Bvh,
    /// See [`FADE_RADII`]; m.
    fade: f64,
    /// Least depth of vertices below the skin, m.
    least_depth: f64,
}

impl<'a> Placement<'a> {
    /// The placement of a cut of `skin` through a stem of the given radius, with the least depth of vertices below the skin
    /// (both m).
    pub fn new(
        source: Source<'a>,
        cut: &Cut,
        skin: &Skin,
        (radius, least_depth): (f64, f64),
    ) -> Self {
        let about = &skin.order[cut.sides.below..][..cut.sides.between.len()];
        let mut grain = Vec::with_capacity(about.len());
        let mut places = Vec::with_capacity(about.len());
        for &t in about {
            let vertices = source.mesh.triangles[t as usize];
            let corners = vertices.map(|v| source.grain[source.points[v as usize] as usize]);
            // Skin off the limb has no grain.
            if corners.iter().all(|g| !g.is_nan()) {
                grain.push(corners);
                places.push(vertices.map(|v| source.mesh.positions[v as usize]));
            }
        }
        let boxes: Vec<Aabb> = grain.iter().map(|t| Aabb::around(t)).collect();
        Placement {
            source,
            tree: Bvh::new(&boxes),
            grain,
            places,
            fade: FADE_RADII * radius,
            least_depth,
        }
    }

    /// Returns the position of a vertex within the wood, in the node's coordinates. It is moved to the least depth below the skin, or
    /// to the depth `most` (m) where that is less.
    pub fn place(&self, grain: DVec3, most: f64) -> DVec3 {
        let least_depth = self.least_depth.min(most);
        let chart = self.source.chart;
        let on = |t: usize| closest_point_on_triangle(grain, self.grain[t]);
        let squared = |t: usize| on(t).distance_squared(grain);
        let place = chart.to_world(grain);
        let Some((t, squared)) = self.tree.nearest(grain, self.fade, squared) else {
            return place;
        };
        let nearest = on(t);
        let distance = squared.sqrt();
        let w = weights(nearest, self.grain[t]);
        let skin: DVec3 = (0..3).map(|k| self.places[t][k] * w[k]).sum();
        let nearness = 1.0 - squared / (self.fade * self.fade);
        let place = place + (skin - chart.to_world(nearest)) * (nearness * nearness);
        if distance >= least_depth {
            return place;
        }
        let [a, b, c] = self.places[t];
        let inwards = -(b - a).cross(c - a).normalize_or_zero();
        place + inwards * (least_depth - (place - skin).dot(inwards)).max(0.0)
    }

    /// Whether a point within the wood is so close to the skin that it is moved away from it.
    pub fn is_shallow(&self, grain: DVec3) -> bool {
        let squared =
            |t: usize| closest_point_on_triangle(grain, self.grain[t]).distance_squared(grain);
        self.tree
            .nearest(grain, self.least_depth, squared)
            .is_some()
    }
}

/// Barycentric coordinates of a point of a triangle.
fn weights(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let (u, v, w) = (b - a, c - a, p - a);
    let normal = u.cross(v);
    let area = normal.length_squared();
    if area == 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let (t, s) = (u.cross(w).dot(normal) / area, w.cross(v).dot(normal) / area);
    [1.0 - s - t, s, t]
}
