//! Bending of torn fibres: a smooth, one-to-one map of the space about the break.
//!
//! Above a reference height every plane across the grain is carried outwards and, in a few small steps, along a smooth
//! random field. A step moves neighbouring places by less than half their distance against each other, so no two
//! places ever fall together, and nothing tears: positions are moved, triangles stay.

use super::part::part;
use crate::Prepared;
use crate::model::Model;
use glam::{DAffine3, DVec2, DVec3};
use greenstick_geometry::Mesh;
use greenstick_wood::noise::{self, smoothstep};
use greenstick_wood::stem::LayeredGrain;

/// Width of the random field's features, radii.
const FEATURE: f64 = 0.7;
/// Way along the random field where it is fastest, as part of its features' width.
const WAY: f64 = 0.55;
/// Steps of that way. The field's slope is below 4, so a step strains by less than 4 · WAY / STEPS < 1/2.
const STEPS: u32 = 8;
/// How far fibres at the bark spread outwards, radii.
const SPLAY: f64 = 0.25;
/// Part of the face's corners that lie below the height from which on fibres bend.
const FIRM: f64 = 0.2;

/// Distance along the grain at which triangles are parted to follow the bend, radii.
const SPACING: f64 = 0.5;

/// The bend of one piece.
pub(super) struct Bend<'a> {
    layers: &'a LayeredGrain,
    transform: DAffine3,
    inverse: DAffine3,
    /// Middle of the section and half its width, m.
    middle: DVec2,
    radius: f64,
    reach: f64,
    /// Length from which on fibres bend, m, and 1 or −1 for the direction away from the piece.
    firm: f64,
    sign: f64,
    amount: f64,
    seed: u64,
}

impl<'a> Bend<'a> {
    pub fn new(prepared: &'a Prepared, model: &Model, amount: f64, seed: u64, upper: bool) -> Self {
        let mut sorted: Vec<f64> = model
            .heights
            .surface
            .heights
            .iter()
            .flatten()
            .copied()
            .collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let sign = if upper { -1.0 } else { 1.0 };
        let part = if upper { 1.0 - FIRM } else { FIRM };
        let at = (part * sorted.len().saturating_sub(1) as f64) as usize;
        let transform = *prepared.transform();
        let stem = &prepared.found.stem;
        Bend {
            layers: &prepared.layers,
            inverse: transform.inverse(),
            transform,
            middle: model.square.0,
            radius: stem.radius,
            reach: model.square.1 / 2.0,
            firm: sorted.get(at).copied().unwrap_or(stem.place),
            sign,
            amount,
            seed: seed + u64::from(upper),
        }
    }

    fn grain(&self, place: DVec3) -> DVec3 {
        self.layers.to_grain(self.transform.transform_point3(place))
    }

    /// Height over the firm wood, radii.
    fn over(&self, grain: DVec3) -> f64 {
        self.sign * (grain.z - self.firm) / self.radius
    }

    /// The field at a place, radii per unit of way.
    fn field(&self, at: DVec2) -> DVec2 {
        let p = (at - self.middle) / (FEATURE * self.radius);
        DVec2::new(
            noise::plane(self.seed << 1, p),
            noise::plane((self.seed << 1) + 1, p),
        ) * (WAY * FEATURE)
    }

    /// Where a place in grain space goes: first down, then aside within its plane.
    fn moved(&self, grain: DVec3) -> DVec3 {
        let over = self.over(grain);
        let at = grain.truncate();
        // Other limbs beside the stem stay where they are.
        let beside = at.distance(self.middle) / self.reach;
        let strength = self.amount * (1.0 - smoothstep(1.5, 3.5, beside));
        if over <= 0.0 || strength <= 0.0 {
            return grain;
        }
        let down = grain.z - self.sign * self.drop(at, strength, over) * self.radius;
        let left = self.over(at.extend(down)).max(0.0);
        let way = strength * left * left / (1.0 + left * left);
        let mut to = at + (at - self.middle) * (SPLAY * way);
        for _ in 0..STEPS {
            to += self.field(to) * (way * self.radius / f64::from(STEPS));
        }
        to.extend(down)
    }

    /// How far a fibre drops, radii: it keeps its length to first order, half the integral of its slope squared.
    fn drop(&self, at: DVec2, strength: f64, over: f64) -> f64 {
        const PARTS: u32 = 8;
        let lean = (at - self.middle) * (SPLAY / self.radius) + self.field(at);
        let part = over / f64::from(PARTS);
        let slopes = (0..PARTS).map(|i| {
            let t = part * (f64::from(i) + 0.5);
            let slope = 2.0 * t / ((1.0 + t * t) * (1.0 + t * t));
            slope * slope * part
        });
        0.5 * lean.length_squared() * strength * strength * slopes.sum::<f64>()
    }

    /// Where a place in the node's coordinates goes; `None` where it stays.
    fn map(&self, place: DVec3) -> Option<DVec3> {
        let grain = self.layers.to_grain(self.transform.transform_point3(place));
        let to = self.moved(grain);
        (to != grain).then(|| self.inverse.transform_point3(self.layers.to_world(to)))
    }

    /// The mesh, bent.
    pub fn apply(&self, mesh: &Mesh) -> Mesh {
        // Long triangles along the grain are parted, so that they bend instead of leaning.
        let over = |place: DVec3| self.over(self.grain(place));
        let mesh = &part(mesh, &over, SPACING);
        let mut bent = mesh.clone();
        let step = 1e-4 * self.radius / self.transform.matrix3.determinant().abs().cbrt();
        let derivative = |place: DVec3, to: DVec3, direction: DVec3| {
            let beside = place + direction * step;
            self.map(beside).unwrap_or(beside) - to
        };
        for i in 0..mesh.positions.len() {
            let place = mesh.positions[i];
            let Some(to) = self.map(place) else {
                continue;
            };
            bent.positions[i] = to;
            let mut turn = |name: &str, how: &dyn Fn(DVec3) -> DVec3| {
                if let Some(attribute) = bent.attributes.get_mut(name)
                    && attribute.width >= 3
                {
                    let first = i * attribute.width;
                    let values = &mut attribute.data[first..first + 3];
                    let d = DVec3::new(values[0].into(), values[1].into(), values[2].into());
                    if d != DVec3::ZERO {
                        values.copy_from_slice(
                            &how(d.normalize()).normalize_or(d).as_vec3().to_array(),
                        );
                    }
                }
            };
            turn("NORMAL", &|n| {
                let (u, v) = n.any_orthonormal_pair();
                derivative(place, to, u).cross(derivative(place, to, v))
            });
            turn("TANGENT", &|t| derivative(place, to, t));
        }
        bent
    }
}

#[cfg(test)]
impl Bend<'_> {
    /// Least determinant of the map's derivative at places within `aside` of the middle and `along` of `length` (m).
    pub fn least_stretch(&self, length: f64, aside: f64, along: f64) -> f64 {
        let h = 1e-6 * self.radius;
        let mut least = f64::INFINITY;
        for i in 0..20_000 {
            let unit = |k: i64| 2.0 * noise::unit(77, i, k, 0) - 1.0;
            let across = self.middle + DVec2::new(unit(0), unit(1)) * aside;
            let at = across.extend(length + unit(2) * along);
            let column = |e: DVec3| (self.moved(at + e * h) - self.moved(at - e * h)) / (2.0 * h);
            let d = glam::DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z));
            least = least.min(d.determinant());
        }
        least
    }
}
