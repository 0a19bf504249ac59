//! Fewer joints for a piece: some are kept, the others move as a blend of two of those.

use glam::{DAffine3, DVec3};
use greenstick_geometry::SkinnedMesh;
use std::collections::BTreeMap;

/// The joints that stand for one, and their shares, which add up to 1.
pub type Shares = [(usize, f64); 2];

/// Joints among which the second of a blend is sought.
const NEAR: usize = 8;

/// How often the chosen joints are moved to the middle of those they stand for, and among how many of those it is
/// sought.
const ROUNDS: usize = 4;
const CANDIDATES: usize = 32;

/// For each joint in `used` those that stand for it, so that at most `most` are left.
///
/// The joints whose motion differs most from those chosen before are chosen one by one (Gonzalez 1985, "Clustering to
/// minimize the maximum intercluster distance"), then moved to the middle of those that are nearest to them. Each other
/// one moves as that blend of the nearest and one more which fits it best in the samples: along a rod that is what lies
/// between two joints.
pub fn merge(
    piece: &SkinnedMesh,
    used: &[u32],
    most: usize,
    samples: &[Vec<DAffine3>],
) -> Vec<Shares> {
    let crowd = Crowd::new(probes(piece, used), used, samples);
    let first = (0..used.len())
        .rev()
        .max_by(|&a, &b| crowd.probes[a].total.total_cmp(&crowd.probes[b].total))
        .unwrap_or(0);
    let mut near: Vec<Near> = vec![Vec::new(); used.len()];
    let mut chosen = vec![first];
    crowd.meet(first, &mut near);
    while chosen.len() < most {
        let farthest = (0..used.len())
            .rev()
            .max_by(|&a, &b| near[a][0].0.total_cmp(&near[b][0].0))
            .unwrap_or(0);
        if near[farthest][0].0 == 0.0 {
            break;
        }
        chosen.push(farthest);
        crowd.meet(farthest, &mut near);
    }
    for _ in 0..ROUNDS {
        let better = crowd.middles(&chosen, &near);
        let mut nearer: Vec<Near> = vec![Vec::new(); used.len()];
        better.iter().for_each(|&j| crowd.meet(j, &mut nearer));
        if worst(&nearer) >= worst(&near) {
            break;
        }
        (chosen, near) = (better, nearer);
    }
    (0..used.len()).map(|k| crowd.blend(k, &near[k])).collect()
}

/// The chosen joints that move most as one does, with how far from it, the nearest first.
type Near = Vec<(f64, usize)>;

fn worst(near: &[Near]) -> f64 {
    near.iter().map(|n| n[0].0).fold(0.0, f64::max)
}

/// Joints with what tells how they move.
struct Crowd<'a> {
    probes: Vec<Probe>,
    used: &'a [u32],
    samples: &'a [Vec<DAffine3>],
    /// Where the probes of each joint are in all samples.
    own: Vec<Vec<[DVec3; 4]>>,
}

impl<'a> Crowd<'a> {
    fn new(probes: Vec<Probe>, used: &'a [u32], samples: &'a [Vec<DAffine3>]) -> Self {
        let of_joint = |(probe, &j): (&Probe, &u32)| {
            let of_sample = |maps: &Vec<DAffine3>| probe.under(&maps[j as usize]);
            samples.iter().map(of_sample).collect()
        };
        Crowd {
            own: probes.iter().zip(used).map(of_joint).collect(),
            probes,
            used,
            samples,
        }
    }

    /// How far what follows `k` would move at most if it followed `j`.
    fn distance(&self, k: usize, j: usize) -> f64 {
        if k == j {
            return 0.0;
        }
        let (probe, joint) = (&self.probes[k], self.used[j] as usize);
        let mut away: f64 = 0.0;
        for (own, maps) in self.own[k].iter().zip(self.samples) {
            let other = probe.under(&maps[joint]);
            for (p, q) in own.iter().zip(other) {
                away = away.max(p.distance_squared(q));
            }
        }
        probe.weight * away.sqrt()
    }

    /// Adds a chosen joint to what is near to each.
    fn meet(&self, chosen: usize, near: &mut [Near]) {
        for (k, near) in near.iter_mut().enumerate() {
            let distance = self.distance(k, chosen);
            let at = near.partition_point(|n| n.0 <= distance);
            if at < NEAR {
                near.insert(at, (distance, chosen));
                near.truncate(NEAR);
            }
        }
    }

    /// For each chosen joint the one among those nearest to it that is least far from all of them.
    fn middles(&self, chosen: &[usize], near: &[Near]) -> Vec<usize> {
        let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (k, near) in near.iter().enumerate() {
            members.entry(near[0].1).or_default().push(k);
        }
        let middle = |&j: &usize| {
            let Some(members) = members.get(&j) else {
                return j;
            };
            let some = || members.iter().step_by(members.len().div_ceil(CANDIDATES));
            let farthest = |c: usize| some().map(|&k| self.distance(k, c)).fold(0.0, f64::max);
            let measured = some().map(|&c| (farthest(c), c)).chain([(farthest(j), j)]);
            measured
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .map_or(j, |m| m.1)
        };
        chosen.iter().map(middle).collect()
    }

    /// The blend of the nearest and one other of `near` that is nearest to `k` in the mean.
    fn blend(&self, k: usize, near: &[(f64, usize)]) -> Shares {
        let Some(&(distance, nearest)) = near.first() else {
            return [(k, 1.0), (k, 0.0)];
        };
        let mut best = (f64::INFINITY, [(nearest, 1.0), (nearest, 0.0)]);
        if distance == 0.0 {
            return best.1;
        }
        let places = |j: usize| {
            let joint = self.used[j] as usize;
            let of_sample = move |maps: &Vec<DAffine3>| self.probes[k].under(&maps[joint]);
            self.samples.iter().flat_map(of_sample)
        };
        let own = self.own[k].as_flattened().iter().copied();
        let own: Vec<(DVec3, DVec3)> = own.zip(places(nearest)).collect();
        for &(_, other) in &near[1..] {
            let (mut along, mut length, mut square) = (0.0, 0.0, 0.0);
            for ((p, a), b) in own.iter().zip(places(other)) {
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
            let left = square + share * (share * length - 2.0 * along);
            if left < best.0 {
                best = (left, [(nearest, 1.0 - share), (other, share)]);
            }
        }
        best.1
    }
}

/// Where a joint has its say.
#[derive(Clone, Copy, Default)]
struct Probe {
    /// The middle of its vertices, and points beside it as far as they are wide: four points tell a map.
    points: [DVec3; 4],
    /// Its largest weight in a vertex.
    weight: f64,
    /// Its weights in all.
    total: f64,
}

impl Probe {
    /// Its points where a joint has this map.
    fn under(&self, map: &DAffine3) -> [DVec3; 4] {
        self.points.map(|p| map.transform_point3(p))
    }
}

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
