//! Bending of torn fibres: a smooth, one-to-one map of the space about the break.
//!
//! Above a reference height every plane across the grain is spread and lowered, and then carried, in a few small steps,
//! along a smooth random field without sources. The map is one to one, so nothing tears, and it preserves volume; straight
//! triangles deviate a little from the curved map, and those that would cross because of it are bisected.

use super::levels::{push_vertex_between, split_at_levels};
use crate::prepared::PreparedStem;
use glam::{DAffine3, DVec2, DVec3};
use greenstick_fracture::surface::FractureSurface;
use greenstick_geometry::repair::{EdgeBisector, crossing_pairs};
use greenstick_geometry::{Aabb, Cancelled, Context, Mesh};
use greenstick_wood::noise::{GradientNoise2d, smoothstep};
use greenstick_wood::stem::LayeredGrain;

/// Width of the random field's features, radii.
const FEATURE_WIDTH: f64 = 0.7;
/// Displacement along the random field per slope of its noise (about 2 at most), as part of its features' width.
const DISPLACEMENT: f64 = 0.2;
/// Steps of that displacement, each of which strains little.
const STEPS: u32 = 8;
/// How far fibres at the bark spread outwards, radii.
const SPLAY: f64 = 0.08;
/// Part of the face's corners that lie below the height above which fibres bend.
const FIRM_SHARE: f64 = 0.2;

/// Distance along the grain at which triangles are split to follow the bend, radii.
const LEVEL_SPACING: f64 = 0.5;

/// Rounds in which triangles that cross are bisected before the bend is made weaker.
const BISECTIONS: u32 = 8;
/// Ratio of crossing pairs to those at first above which bisection diverges, so that the bend is made weaker at once.
const DIVERGENCE: usize = 4;
/// Factor by which the bend is made weaker then.
const WEAKENING: f64 = 0.7;
/// How often it is made weaker.
const MAX_WEAKENINGS: u32 = 4;

/// How a piece was bent, and what kept it from crossing itself.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BendReport {
    /// Pairs of triangles that crossed at first.
    pub crossed: usize,
    /// Edges bisected.
    pub bisected: usize,
    /// Pairs that still cross.
    pub remaining: usize,
    /// How much the piece was bent, 0 to 1: as requested, or less.
    pub amount: f64,
    /// Change of the piece's volume, as part of it.
    pub volume_change: f64,
}

/// The bend of one piece.
pub struct Bend<'a> {
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
    /// Returns the bend of the lower or the upper piece of a break along `surface`, by `amount` (0 to 1).
    pub(super) fn new(
        prepared: &'a PreparedStem,
        surface: &FractureSurface,
        amount: f64,
        seed: u64,
        upper: bool,
    ) -> Self {
        let mut sorted: Vec<f64> = surface.heights.iter().flatten().copied().collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let sign = if upper { -1.0 } else { 1.0 };
        let part = if upper { 1.0 - FIRM_SHARE } else { FIRM_SHARE };
        let at = (part * sorted.len().saturating_sub(1) as f64) as usize;
        let transform = *prepared.transform();
        let stem = &prepared.found.stem;
        Bend {
            layers: &prepared.layers,
            inverse: transform.inverse(),
            transform,
            middle: prepared.square.middle,
            radius: stem.radius,
            reach: prepared.square.side / 2.0,
            firm: sorted.get(at).copied().unwrap_or(stem.location),
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

    /// The field at a place, radii per unit of way: the curl of noise, which moves areas without changing them.
    fn field(&self, noise: &mut GradientNoise2d, at: DVec2) -> DVec2 {
        const H: f64 = 1e-4;
        let p = (at - self.middle) / (FEATURE_WIDTH * self.radius);
        let mut slope = |e: DVec2| (noise.at(p + e * H) - noise.at(p - e * H)) / (2.0 * H);
        DVec2::new(slope(DVec2::Y), -slope(DVec2::X)) * (DISPLACEMENT * FEATURE_WIDTH)
    }

    /// Where a place in grain space (m) goes: first down, then aside within its plane.
    pub fn moved(&self, grain: DVec3) -> DVec3 {
        let over = self.over(grain);
        let at = grain.truncate();
        // Other limbs beside the stem stay where they are.
        let beside = at.distance(self.middle) / self.reach;
        let strength = self.amount * (1.0 - smoothstep(1.5, 3.5, beside));
        if over <= 0.0 || strength <= 0.0 {
            return grain;
        }
        let left = lowered(over, SPLAY * strength);
        let down = self.firm + self.sign * left * self.radius;
        let way = strength * left * left / (1.0 + left * left);
        let mut to = at + (at - self.middle) * (SPLAY * way);
        // By midpoints, so that areas stay to third order.
        let step = way * self.radius / f64::from(STEPS);
        let mut noise = GradientNoise2d::new(self.seed << 1);
        for _ in 0..STEPS {
            let half = to + self.field(&mut noise, to) * (0.5 * step);
            to += self.field(&mut noise, half) * step;
        }
        to.extend(down)
    }

    /// Where a place in the node's coordinates goes; `None` where it stays.
    fn map(&self, place: DVec3) -> Option<DVec3> {
        let grain = self.layers.to_grain(self.transform.transform_point3(place));
        let to = self.moved(grain);
        (to != grain).then(|| self.inverse.transform_point3(self.layers.to_world(to)))
    }

    /// The mesh, bent, and how.
    pub(super) fn apply(
        mut self,
        mesh: &Mesh,
        context: &Context,
    ) -> Result<(Mesh, BendReport), Cancelled> {
        let mut done = BendReport::default();
        for attempt in 0..=MAX_WEAKENINGS {
            let last = attempt == MAX_WEAKENINGS;
            let (straight, positions) = self.straight(mesh, &mut done, context)?;
            if done.remaining == 0 || last {
                done.amount = self.amount;
                return Ok((self.bent(straight, positions, context)?, done));
            }
            self.amount *= WEAKENING;
        }
        Ok((mesh.clone(), done))
    }

    /// The mesh before it is bent, in triangles so small that it can be: bisected where they would cross when bent. Also
    /// the positions of its vertices when bent.
    fn straight(
        &self,
        mesh: &Mesh,
        done: &mut BendReport,
        context: &Context,
    ) -> Result<(Mesh, Vec<DVec3>), Cancelled> {
        // Long triangles along the grain are split, so that they bend instead of leaning.
        let over = |place: DVec3| self.over(self.grain(place));
        let mut mesh = split_at_levels(mesh, &over, LEVEL_SPACING);
        context.check()?;
        let map = |p: DVec3| self.map(p).unwrap_or(p);
        // Vertices at one position go to one.
        let (points, count) = mesh.points();
        let mut bent_points = vec![None; count];
        let places = points.iter().zip(&mesh.positions);
        let bend = |(&point, &place): (&u32, &DVec3)| {
            let to = bent_points[point as usize].get_or_insert_with(|| self.map(place));
            context.check()?;
            Ok::<_, Cancelled>(to.unwrap_or(place))
        };
        let bent: Result<Vec<DVec3>, Cancelled> = places.map(bend).collect();
        let mut bent = bent?;
        let mut pairs = crossings_of_moved(&mesh, &bent, context)?;
        done.crossed = done.crossed.max(pairs.len());
        let pairs_at_first = pairs.len();
        (done.bisected, done.remaining) = (0, pairs_at_first);
        if pairs.is_empty() {
            return Ok((mesh, bent));
        }
        context.check()?;
        let mut bisector =
            EdgeBisector::new(std::mem::take(&mut mesh.triangles), points, count as u32);
        for _ in 0..BISECTIONS {
            let mut fresh = vec![false; bisector.triangles.len()];
            let mut changed = Vec::new();
            for t in pairs.iter().flatten().copied() {
                context.check()?;
                if fresh[t as usize] {
                    continue;
                }
                let length = |a: u32, b: u32| bent[a as usize].distance(bent[b as usize]);
                let mut make = |a: u32, b: u32| push_vertex_between(&mut mesh, a, b, 0.5);
                if let Some(four) = bisector.bisect(t, &length, &mut make) {
                    fresh.resize(bisector.triangles.len(), true);
                    four.iter().for_each(|&t| fresh[t as usize] = true);
                    changed.extend(four);
                    done.bisected += 1;
                }
                let new = mesh.positions[bent.len()..].iter().map(|&p| map(p));
                bent.extend(new.collect::<Vec<_>>());
            }
            changed.sort_unstable();
            changed.dedup();
            pairs.retain(|p| p.iter().all(|t| changed.binary_search(t).is_err()));
            pairs.extend(crossing_pairs(
                &bent,
                &bisector.triangles,
                Some(&changed),
                context,
            )?);
            pairs.sort_unstable();
            pairs.dedup();
            done.remaining = pairs.len();
            let diverges = pairs.len() > DIVERGENCE * pairs_at_first;
            if pairs.is_empty() || changed.is_empty() || diverges {
                break;
            }
        }
        if !mesh.materials.is_empty() {
            let of = bisector.origins.iter().map(|&t| mesh.materials[t as usize]);
            mesh.materials = of.collect();
        }
        mesh.triangles = bisector.triangles;
        Ok((mesh, bent))
    }

    /// The mesh with its vertices moved to `positions` and their normals turned.
    fn bent(
        &self,
        mesh: Mesh,
        positions: Vec<DVec3>,
        context: &Context,
    ) -> Result<Mesh, Cancelled> {
        let mut bent = Mesh { positions, ..mesh };
        let straight = mesh.positions;
        let step = 1e-4 * self.radius / self.transform.matrix3.determinant().abs().cbrt();
        let derivative = |place: DVec3, to: DVec3, direction: DVec3| {
            let beside = place + direction * step;
            self.map(beside).unwrap_or(beside) - to
        };
        for (i, place) in straight.into_iter().enumerate() {
            context.check()?;
            let to = bent.positions[i];
            if to == place {
                continue;
            }
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
        Ok(bent)
    }
}

/// Height to which one of `over` comes down where planes at a height u are spread by the factor 1 + k u²/(1 + u²): as
/// much as they gain in area they lose in distance, so that volumes stay. The root of
/// ∫ (1 + k u²/(1 + u²))² du = `over` by Newton's method.
fn lowered(over: f64, k: f64) -> f64 {
    let mut u = over;
    for _ in 0..8 {
        let spread = 1.0 + k * u * u / (1.0 + u * u);
        let (turn, near) = (libm::atan(u), u / (1.0 + u * u));
        let sum =
            (1.0 + k) * (1.0 + k) * u - 2.0 * k * (1.0 + k) * turn + 0.5 * k * k * (near + turn);
        u = (u - (sum - over) / (spread * spread)).max(0.0);
    }
    u
}

/// Pairs of triangles that cross once the vertices of `mesh` are at `bent`, at least one of which has moved: what crosses without
/// being bent is a fault of the input.
fn crossings_of_moved(
    mesh: &Mesh,
    bent: &[DVec3],
    context: &Context,
) -> Result<Vec<[u32; 2]>, Cancelled> {
    let moved: Vec<bool> = (mesh.triangles.iter())
        .map(|t| {
            t.iter()
                .any(|&v| bent[v as usize] != mesh.positions[v as usize])
        })
        .collect();
    let around = |t: &[u32; 3]| Aabb::around(&t.map(|v| bent[v as usize]));
    let all = mesh.triangles.iter().zip(&moved).filter(|(_, m)| **m);
    let reach = all.fold(Aabb::EMPTY, |reach, (t, _)| reach.join(&around(t)));
    let near: Vec<u32> = (0..mesh.triangles.len() as u32)
        .filter(|&t| around(&mesh.triangles[t as usize]).overlaps(&reach))
        .collect();
    let triangles: Vec<[u32; 3]> = near.iter().map(|&t| mesh.triangles[t as usize]).collect();
    let mut pairs = crossing_pairs(bent, &triangles, None, context)?;
    for t in pairs.iter_mut().flatten() {
        *t = near[*t as usize];
    }
    pairs.retain(|p| p.iter().any(|&t| moved[t as usize]));
    Ok(pairs)
}
