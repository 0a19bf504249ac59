//! Sections at the ends of a stem, whose outlines decide the tissues that a sawn end shows.

use super::PreparedStem;
use glam::DVec2;
use greenstick_fracture::cracks::EndFace;
use greenstick_wood::appearance::EndSection;
use greenstick_wood::rings::RingField;
use std::f64::consts::{PI, TAU};

/// Distances below the face of an end at which its outline is looked for, radii: its rim may be rounded or chipped.
const OUTLINE_DEPTHS: [f64; 4] = [0.02, 0.04, 0.08, 0.16];
/// Cosine to the normal of an end's face above which a triangle belongs to it: a plane through that is too near.
const FACING: f64 = 0.8;
/// Share of a direction by which a side of the outline is widened, so that none falls between two sides.
const ROUNDING: f64 = 1e-9;
/// Directions of an outline.
const DIRECTIONS: usize = 256;

impl PreparedStem {
    /// As [`PreparedStem::end_sections`], measured anew.
    pub(super) fn find_end_sections(&self) -> Vec<EndSection> {
        let stem = &self.found.stem;
        if stem.kind.is_sawn() {
            return Vec::new();
        }
        let ends = [(stem.ends.0, false), (stem.ends.1, true)];
        let sections = ends.iter().filter(|end| end.0).filter_map(|&(_, far)| {
            let limb = &self.found.limb;
            let end = EndFace::fit(&self.corners, limb, &self.grain, far, stem.radius).ok()?;
            let pith = stem.rings.pith();
            OUTLINE_DEPTHS.iter().find_map(|depth| {
                let outline = self.outline_below(&end, depth * stem.radius, pith)?;
                let rings = RingField::from_outline(&outline, pith).ok()?;
                let length = end.at(pith);
                Some(EndSection { length, rings })
            })
        });
        sections.collect()
    }

    /// Returns the outline of the limb in the plane that lies `depth` (m) below the face of an end, as the farthest points of
    /// its skin from `pith` in directions around it; `None` where it is not closed, or crosses the face.
    fn outline_below(&self, end: &EndFace, depth: f64, pith: DVec2) -> Option<Vec<DVec2>> {
        let mut farthest = [f64::NAN; DIRECTIONS];
        let sign = if end.far { 1.0 } else { -1.0 };
        for &t in &self.found.limb {
            let points = self.corners[t as usize].map(|p| {
                let point = self.grain[p as usize];
                let across = point.truncate();
                across.extend(sign * (point.z - end.at(across)) + depth)
            });
            let crossings = (0..3).filter_map(|k| {
                let (a, b) = (points[k], points[(k + 1) % 3]);
                let t = a.z / (a.z - b.z);
                ((a.z < 0.0) != (b.z < 0.0)).then(|| a.lerp(b, t).truncate() - pith)
            });
            if let [p, q] = crossings.collect::<Vec<_>>()[..] {
                let normal = (points[1] - points[0]).cross(points[2] - points[0]);
                if normal.z.abs() > FACING * normal.length() {
                    return None;
                }
                reach(&mut farthest, p, q);
            }
        }
        let closed = farthest.iter().all(|r| *r > 0.0);
        closed.then(|| {
            let at = |(k, r): (usize, &f64)| pith + direction(k) * *r;
            farthest.iter().enumerate().map(at).collect()
        })
    }
}

fn direction(k: usize) -> DVec2 {
    let (sin, cos) = libm::sincos(k as f64 * TAU / DIRECTIONS as f64);
    DVec2::new(cos, sin)
}

/// Extends the `farthest` distances by a side of the outline from `p` to `q`.
fn reach(farthest: &mut [f64; DIRECTIONS], p: DVec2, q: DVec2) {
    let step = TAU / DIRECTIONS as f64;
    let from = libm::atan2(p.y, p.x);
    let turn = libm::atan2(p.perp_dot(q), p.dot(q));
    let (low, high) = (from.min(from + turn), from.max(from + turn));
    if high - low >= PI {
        return;
    }
    let first = (low / step - ROUNDING).ceil() as i64;
    let last = (high / step + ROUNDING).floor() as i64;
    for k in first..=last {
        let at = k.rem_euclid(DIRECTIONS as i64) as usize;
        let d = direction(at);
        let side = d.perp_dot(q - p);
        if side != 0.0 {
            let r = (p + (q - p) * (d.perp_dot(-p) / side)).dot(d);
            farthest[at] = farthest[at].max(r);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick_geometry::{Context, Node, Scene};
    use greenstick_wood::primitive::{self, BranchOptions};
    use greenstick_wood::stem::{StemLocation, StemOptions};

    /// A branch tapers from its base on, and its bark has furrows: the rim of an end lies where the rings of that end end,
    /// and not where those of the middle do.
    #[test]
    fn the_rings_of_an_end_reach_its_rim() {
        let mesh = primitive::branch(&BranchOptions {
            around: 48,
            ..BranchOptions::default()
        });
        let mut scene = Scene::default();
        scene
            .nodes
            .push(Node::new("branch", glam::DAffine3::IDENTITY, mesh));
        let middle = StemLocation::Fraction(0.5);
        let context = Context::quiet();
        let stem = PreparedStem::find(scene, &middle, &StemOptions::default(), &context).unwrap();
        let ends = stem.end_sections();
        assert_eq!(ends.len(), 2, "{:?}", stem.found.stem.ends);
        for end in ends {
            let far = end.length > stem.found.stem.location;
            let (limb, radius) = (&stem.found.limb, stem.found.stem.radius);
            let face = EndFace::fit(&stem.corners, limb, &stem.grain, far, radius).unwrap();
            let points = limb.iter().flat_map(|&t| stem.corners[t as usize]);
            let points = points.map(|p| stem.grain[p as usize]);
            let near = points.filter(|p| (p.z - face.at(p.truncate())).abs() < 1e-3);
            let (mut own, mut others) = ([0.0f64; 8], [0.0f64; 8]);
            for p in near {
                let (rho, angle) = end.rings.address(p.truncate());
                let sector = ((angle / TAU).rem_euclid(1.0) * 8.0) as usize % 8;
                own[sector] = own[sector].max(rho);
                let (rho, _) = stem.found.stem.rings.address(p.truncate());
                others[sector] = others[sector].max(rho);
            }
            assert!(own.iter().all(|r| (r - 1.0).abs() < 0.03), "{own:?}");
            assert!(others.iter().any(|r| (r - 1.0).abs() > 0.1), "{others:?}");
        }
    }
}
