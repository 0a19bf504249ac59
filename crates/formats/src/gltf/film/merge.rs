//! Reduction of the joints of a piece: some are kept, and each of the others is replaced by a blend of two of those.

use glam::{DAffine3, DVec3};
use greenstick_geometry::SkinnedMesh;
use std::collections::BTreeMap;

/// Two joints that replace one, with their weights, which add up to 1.
pub(super) type Blend = [(usize, f64); 2];

/// Number of nearest joints among which the second one of a blend is chosen.
const BLEND_CANDIDATES: usize = 8;

/// Most rounds in which the chosen joints are moved to the centres of their clusters.
const MAX_ROUNDS: usize = 4;
/// Most joints of a cluster among which its centre is chosen.
const CENTRE_CANDIDATES: usize = 32;

/// Replaces each joint in `used` by a blend, so that at most `max_joints` are left.
///
/// Joints are chosen one by one, always that whose motion differs most from all chosen before (Gonzalez 1985, Clustering
/// to Minimize the Maximum Intercluster Distance), then moved to the centres of their clusters. Each other joint becomes
/// the blend of the nearest chosen joint and one more that fits its motion in the samples best: along a rod, the blend of
/// its two neighbours.
pub(super) fn merge(
    piece: &SkinnedMesh,
    used: &[u32],
    max_joints: usize,
    samples: &[Vec<DAffine3>],
) -> Vec<Blend> {
    let joints = Joints::new(probes(piece, used), used, samples);
    let first = (0..used.len())
        .rev()
        .max_by(|&a, &b| joints.probes[a].total.total_cmp(&joints.probes[b].total))
        .unwrap_or(0);
    let mut near: Vec<Nearest> = vec![Vec::new(); used.len()];
    let mut chosen = vec![first];
    joints.add_chosen(first, &mut near);
    while chosen.len() < max_joints {
        let farthest = (0..used.len())
            .rev()
            .max_by(|&a, &b| near[a][0].0.total_cmp(&near[b][0].0))
            .unwrap_or(0);
        if near[farthest][0].0 == 0.0 {
            break;
        }
        chosen.push(farthest);
        joints.add_chosen(farthest, &mut near);
    }
    for _ in 0..MAX_ROUNDS {
        let better = joints.centres(&chosen, &near);
        let mut nearer: Vec<Nearest> = vec![Vec::new(); used.len()];
        better
            .iter()
            .for_each(|&j| joints.add_chosen(j, &mut nearer));
        if largest_distance(&nearer) >= largest_distance(&near) {
            break;
        }
        (chosen, near) = (better, nearer);
    }
    (0..used.len()).map(|k| joints.blend(k, &near[k])).collect()
}

/// The chosen joints whose motion is closest to that of a joint, with their distances, the closest first.
type Nearest = Vec<(f64, usize)>;

/// The largest distance of a joint from the nearest chosen one.
fn largest_distance(near: &[Nearest]) -> f64 {
    near.iter().map(|n| n[0].0).fold(0.0, f64::max)
}

/// The joints of a piece with their motion.
struct Joints<'a> {
    probes: Vec<Probe>,
    used: &'a [u32],
    samples: &'a [Vec<DAffine3>],
    /// Positions of the probe of each joint in all samples.
    own: Vec<Vec<[DVec3; 4]>>,
}

impl<'a> Joints<'a> {
    fn new(probes: Vec<Probe>, used: &'a [u32], samples: &'a [Vec<DAffine3>]) -> Self {
        let positions = |(probe, &j): (&Probe, &u32)| {
            let of_sample = |maps: &Vec<DAffine3>| probe.moved_by(&maps[j as usize]);
            samples.iter().map(of_sample).collect()
        };
        Joints {
            own: probes.iter().zip(used).map(positions).collect(),
            probes,
            used,
            samples,
        }
    }

    /// The largest distance by which points that follow `k` would be displaced if they followed `j`.
    fn distance(&self, k: usize, j: usize) -> f64 {
        if k == j {
            return 0.0;
        }
        let (probe, joint) = (&self.probes[k], self.used[j] as usize);
        let mut squared: f64 = 0.0;
        for (own, maps) in self.own[k].iter().zip(self.samples) {
            let other = probe.moved_by(&maps[joint]);
            for (p, q) in own.iter().zip(other) {
                squared = squared.max(p.distance_squared(q));
            }
        }
        probe.weight * squared.sqrt()
    }

    /// Adds a chosen joint to the nearest ones of each joint.
    fn add_chosen(&self, chosen: usize, near: &mut [Nearest]) {
        for (k, near) in near.iter_mut().enumerate() {
            let distance = self.distance(k, chosen);
            let at = near.partition_point(|n| n.0 <= distance);
            if at < BLEND_CANDIDATES {
                near.insert(at, (distance, chosen));
                near.truncate(BLEND_CANDIDATES);
            }
        }
    }

    /// For each chosen joint the centre of its cluster: the joint with the smallest largest distance from the others.
    fn centres(&self, chosen: &[usize], near: &[Nearest]) -> Vec<usize> {
        let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (k, near) in near.iter().enumerate() {
            members.entry(near[0].1).or_default().push(k);
        }
        let centre = |&j: &usize| {
            let Some(members) = members.get(&j) else {
                return j;
            };
            let sample = || {
                members
                    .iter()
                    .step_by(members.len().div_ceil(CENTRE_CANDIDATES))
            };
            let farthest = |c: usize| sample().map(|&k| self.distance(k, c)).fold(0.0, f64::max);
            let measured = sample()
                .map(|&c| (farthest(c), c))
                .chain([(farthest(j), j)]);
            measured
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .map_or(j, |m| m.1)
        };
        chosen.iter().map(centre).collect()
    }

    /// The blend of the nearest and one other of `near` that is closest to `k` in the mean.
    fn blend(&self, k: usize, near: &Nearest) -> Blend {
        let Some(&(distance, nearest)) = near.first() else {
            return [(k, 1.0), (k, 0.0)];
        };
        let mut best = (f64::INFINITY, [(nearest, 1.0), (nearest, 0.0)]);
        if distance == 0.0 {
            return best.1;
        }
        let positions = |j: usize| {
            let joint = self.used[j] as usize;
            let of_sample = move |maps: &Vec<DAffine3>| self.probes[k].moved_by(&maps[joint]);
            self.samples.iter().flat_map(of_sample)
        };
        let own = self.own[k].as_flattened().iter().copied();
        let own: Vec<(DVec3, DVec3)> = own.zip(positions(nearest)).collect();
        for &(_, other) in &near[1..] {
            let (mut along, mut length, mut square) = (0.0, 0.0, 0.0);
            for ((p, a), b) in own.iter().zip(positions(other)) {
                let (to, step) = (*p - *a, b - *a);
                along += to.dot(step);
                length += step.length_squared();
                square += to.length_squared();
            }
            let share = if length > 0.0 {
                (along / length).clamp(0.0, 1.0)
            } else {
                0.0
            };
            let residual = square + share * (share * length - 2.0 * along);
            if residual < best.0 {
                best = (residual, [(nearest, 1.0 - share), (other, share)]);
            }
        }
        best.1
    }
}

/// The region of the vertices that follow a joint.
#[derive(Clone, Copy, Default)]
struct Probe {
    /// The centroid of its vertices, and points beside it at the radius of the region: four points determine a map.
    points: [DVec3; 4],
    /// Largest weight of the joint for a vertex.
    weight: f64,
    /// Sum of its weights.
    total: f64,
}

impl Probe {
    /// Its points moved by the map of a joint.
    fn moved_by(&self, map: &DAffine3) -> [DVec3; 4] {
        self.points.map(|p| map.transform_point3(p))
    }
}

/// Computes the regions of the joints in `used`.
fn probes(piece: &SkinnedMesh, used: &[u32]) -> Vec<Probe> {
    let mut probes = vec![Probe::default(); used.len()];
    let mut squares = vec![0.0; used.len()];
    let entries = |v: usize| {
        let known = move |(j, w): (u32, f64)| Some((used.binary_search(&j).ok()?, w));
        piece.binding.influences(v).filter_map(known)
    };
    for (v, &p) in piece.mesh.positions.iter().enumerate() {
        for (k, w) in entries(v) {
            probes[k].points[0] += p * w;
            probes[k].total += w;
            probes[k].weight = probes[k].weight.max(w);
        }
    }
    for probe in &mut probes {
        probe.points = [probe.points[0] / probe.total; 4];
    }
    for (v, &p) in piece.mesh.positions.iter().enumerate() {
        for (k, w) in entries(v) {
            squares[k] += w * p.distance_squared(probes[k].points[0]);
        }
    }
    for (probe, square) in probes.iter_mut().zip(squares) {
        let radius: f64 = f64::sqrt(square / probe.total);
        for (point, axis) in probe.points[1..].iter_mut().zip(DVec3::AXES) {
            *point += axis * radius;
        }
    }
    probes
}
