//! Normals of a cloud by principal components of each point's neighbours, and their orientation (Hoppe et al. 1992,
//! Surface Reconstruction from Unorganized Points).

use super::KdTree;
use super::batches::map_in_batches;
use crate::{Cancelled, Context, Unions, symmetric_eigen};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Computes unit normals of planes through the `k` nearest neighbours of each point. Their sign is arbitrary.
pub fn normals(points: &[DVec3], tree: &KdTree, k: usize) -> Vec<DVec3> {
    points
        .par_iter()
        .map(|p| normal(*p, points, tree, k))
        .collect()
}

/// Computes the normals as [`normals`] does, for as long as the caller does not ask to stop.
///
/// # Errors
/// [`Cancelled`] where the caller asked to stop.
pub fn try_normals(
    points: &[DVec3],
    tree: &KdTree,
    k: usize,
    context: &Context,
) -> Result<Vec<DVec3>, Cancelled> {
    map_in_batches(points, context, |p| normal(*p, points, tree, k))
}

/// The normal of the plane through the `k` nearest neighbours of a point.
fn normal(at: DVec3, points: &[DVec3], tree: &KdTree, k: usize) -> DVec3 {
    let near = tree.nearest(at, k.max(3));
    let position = |n: &(f64, u32)| points[n.1 as usize];
    let mean = near.iter().map(position).sum::<DVec3>() / near.len().max(1) as f64;
    let mut covariance = DMat3::ZERO;
    for n in &near {
        let d = position(n) - mean;
        covariance += DMat3::from_cols(d * d.x, d * d.y, d * d.z);
    }
    symmetric_eigen(covariance)[0].1
}

/// Flips normals so that they point away from `centre` of each point: outwards from a stem's axis.
pub fn orient_from(points: &[DVec3], normals: &mut [DVec3], centre: impl Fn(DVec3) -> DVec3) {
    for (p, n) in points.iter().zip(normals) {
        if n.dot(*p - centre(*p)) < 0.0 {
            *n = -*n;
        }
    }
}

/// An edge between two neighbours, the smaller number first.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Edge {
    /// 0 for parallel normals, 1 for perpendicular ones.
    weight: f64,
    a: u32,
    b: u32,
}

/// Orients normals consistently along a minimum spanning tree of the `k` nearest neighbours, in which neighbours with
/// parallel normals are near. In each connected part the normal of the point farthest from the centroid points outwards.
///
/// # Errors
/// [`Cancelled`] where the caller asked to stop.
pub fn orient_along_tree(
    points: &[DVec3],
    normals: &mut [DVec3],
    tree: &KdTree,
    k: usize,
    context: &Context,
) -> Result<(), Cancelled> {
    let mut trees = Unions::new(points.len());
    let mut links: Vec<Vec<u32>> = vec![Vec::new(); points.len()];
    // Kruskal's algorithm.
    for edges in sorted_edges(points, normals, tree, k, context)? {
        context.check()?;
        for Edge { a, b, .. } in edges {
            if trees.join(a, b) {
                links[a as usize].push(b);
                links[b as usize].push(a);
            }
        }
    }
    let mut seen = vec![false; points.len()];
    for start in 0..points.len() {
        if !seen[start] {
            context.check()?;
            let part = connected_part(start as u32, &links, &mut seen);
            orient_part(&part, points, normals, &links);
        }
    }
    Ok(())
}

/// Edges to the `k` nearest neighbours of each point, each once, sorted by weight: in groups, of which each has the
/// larger weights, so that the caller can stop between them.
fn sorted_edges(
    points: &[DVec3],
    normals: &[DVec3],
    tree: &KdTree,
    k: usize,
    context: &Context,
) -> Result<Vec<Vec<Edge>>, Cancelled> {
    let numbers: Vec<u32> = (0..points.len() as u32).collect();
    let edges = map_in_batches(&numbers, context, |&i| {
        let near = tree.nearest(points[i as usize], k + 1);
        let others = near.into_iter().map(|n| n.1).filter(|&j| j != i);
        others
            .map(|j| Edge {
                weight: 1.0 - normals[i as usize].dot(normals[j as usize]).abs(),
                a: i.min(j),
                b: i.max(j),
            })
            .collect::<Vec<Edge>>()
    })?;
    // The bits of positive numbers are ordered as the numbers are; the upper 16 of them are sign, exponent and 4 bits of
    // the fraction.
    let mut groups: Vec<Vec<Edge>> = vec![Vec::new(); 1 << 15];
    for edge in edges.into_iter().flatten() {
        groups[(edge.weight.max(0.0).to_bits() >> 48) as usize].push(edge);
    }
    groups.retain(|group| !group.is_empty());
    for group in &mut groups {
        context.check()?;
        let order = |x: &Edge, y: &Edge| {
            x.weight
                .total_cmp(&y.weight)
                .then((x.a, x.b).cmp(&(y.a, y.b)))
        };
        group.par_sort_unstable_by(order);
        group.dedup();
    }
    Ok(groups)
}

/// Collects the points that links connect to `start`, and marks them as seen.
fn connected_part(start: u32, links: &[Vec<u32>], seen: &mut [bool]) -> Vec<u32> {
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

/// Orients the normals of a connected part from its outermost point.
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
    fn normals_of_a_sphere_point_outwards() {
        // A Fibonacci lattice on a sphere about a point that is not the origin.
        let middle = DVec3::new(3.0, -2.0, 1.0);
        let points: Vec<DVec3> = (0..2000)
            .map(|i| {
                let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 2000.0;
                let angle = f64::from(i) * 2.399_963_229_728_653;
                let r = (1.0 - z * z).sqrt();
                middle + DVec3::new(r * angle.cos(), r * angle.sin(), z)
            })
            .collect();
        let context = Context::quiet();
        let tree = KdTree::new(&points);
        let mut found = normals(&points, &tree, 10);
        orient_along_tree(&points, &mut found, &tree, 8, &context).unwrap();
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
