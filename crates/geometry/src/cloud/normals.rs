//! Normals of a cloud by principal components of each point's neighbours, and their orientation (Hoppe et al. 1992).

use super::{Neighbours, eigen};
use crate::Unions;
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Unit normals of planes through the `k` nearest neighbours of each point. Their sign is arbitrary.
pub fn normals(points: &[DVec3], tree: &Neighbours, k: usize) -> Vec<DVec3> {
    points
        .par_iter()
        .map(|p| {
            let near = tree.nearest(*p, k.max(3));
            let place = |n: &(f64, u32)| points[n.1 as usize];
            let mean = near.iter().map(place).sum::<DVec3>() / near.len().max(1) as f64;
            let mut spread = DMat3::ZERO;
            for n in &near {
                let d = place(n) - mean;
                spread += DMat3::from_cols(d * d.x, d * d.y, d * d.z);
            }
            eigen(spread)[0].1
        })
        .collect()
}

/// Turns normals away from `centre` of each point: outward from a stem's axis.
pub fn orient_from(points: &[DVec3], normals: &mut [DVec3], centre: impl Fn(DVec3) -> DVec3) {
    for (p, n) in points.iter().zip(normals) {
        if n.dot(*p - centre(*p)) < 0.0 {
            *n = -*n;
        }
    }
}

/// Orients normals consistently along a minimum spanning tree of the `k` nearest neighbours, in which neighbours whose
/// normals are parallel are near. In each connected part the point farthest from the part's middle looks outwards.
pub fn orient_along_tree(points: &[DVec3], normals: &mut [DVec3], tree: &Neighbours, k: usize) {
    let directions = &*normals;
    let mut edges: Vec<(f64, u32, u32)> = (0..points.len() as u32)
        .into_par_iter()
        .flat_map_iter(|i| {
            let near = tree.nearest(points[i as usize], k + 1);
            near.into_iter()
                .filter(move |n| n.1 != i)
                .map(move |(_, j)| {
                    let parallel = directions[i as usize].dot(directions[j as usize]).abs();
                    (1.0 - parallel, i.min(j), i.max(j))
                })
        })
        .collect();
    edges.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    edges.dedup();
    // Kruskal's algorithm.
    let mut trees = Unions::new(points.len());
    let mut links: Vec<Vec<u32>> = vec![Vec::new(); points.len()];
    for (_, a, b) in edges {
        if trees.join(a, b) {
            links[a as usize].push(b);
            links[b as usize].push(a);
        }
    }
    let mut seen = vec![false; points.len()];
    for start in 0..points.len() {
        if !seen[start] {
            let part = collect(start as u32, &links, &mut seen);
            orient_part(&part, points, normals, &links);
        }
    }
}

fn collect(start: u32, links: &[Vec<u32>], seen: &mut [bool]) -> Vec<u32> {
    let mut part = vec![start];
    seen[start as usize] = true;
    let mut next = 0;
    while next < part.len() {
        for &j in &links[part[next] as usize] {
            if !std::mem::replace(&mut seen[j as usize], true) {
                part.push(j);
            }
        }
        next += 1;
    }
    part
}

fn orient_part(part: &[u32], points: &[DVec3], normals: &mut [DVec3], links: &[Vec<u32>]) {
    let middle = part.iter().map(|&i| points[i as usize]).sum::<DVec3>() / part.len() as f64;
    let distance = |i: &&u32| points[**i as usize].distance_squared(middle);
    let Some(&first) = part
        .iter()
        .max_by(|a, b| distance(a).total_cmp(&distance(b)).then(b.cmp(a)))
    else {
        return;
    };
    let out = points[first as usize] - middle;
    if normals[first as usize].dot(out) < 0.0 {
        normals[first as usize] = -normals[first as usize];
    }
    let mut stack = vec![(first, u32::MAX)];
    while let Some((i, from)) = stack.pop() {
        for &j in links[i as usize].iter().filter(|&&j| j != from) {
            if normals[j as usize].dot(normals[i as usize]) < 0.0 {
                normals[j as usize] = -normals[j as usize];
            }
            stack.push((j, i));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_of_a_ball_look_outwards() {
        // Fibonacci's lattice on a sphere about a point that is not the origin.
        let middle = DVec3::new(3.0, -2.0, 1.0);
        let points: Vec<DVec3> = (0..2000)
            .map(|i| {
                let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 2000.0;
                let angle = f64::from(i) * 2.399_963_229_728_653;
                let r = (1.0 - z * z).sqrt();
                middle + DVec3::new(r * angle.cos(), r * angle.sin(), z)
            })
            .collect();
        let tree = Neighbours::new(&points);
        let mut found = normals(&points, &tree, 10);
        orient_along_tree(&points, &mut found, &tree, 8);
        for (p, n) in points.iter().zip(&found) {
            assert!(n.dot(*p - middle) > 0.99, "{n} at {p}");
        }
        found.iter_mut().step_by(2).for_each(|n| *n = -*n);
        orient_from(&points, &mut found, |_| middle);
        assert!(
            points
                .iter()
                .zip(&found)
                .all(|(p, n)| n.dot(*p - middle) > 0.99)
        );
    }
}
