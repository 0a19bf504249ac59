//! Closing of seams: borders that lie on each other but for the last digits, as where texture coordinates end and begin again
//! and either side worked out its positions by itself. Sine and cosine of 0 and of a whole turn differ so.

use crate::{Cancelled, Context, Mesh, Unions};
use glam::DVec3;
use rayon::slice::ParallelSliceMut;
use rustc_hash::FxHashSet;

/// How far the sides of a seam may be apart, as a part of the mesh's diagonal: some steps of single precision, and far below
/// what a mesh shows.
pub const SEAM_TOLERANCE: f64 = 1e-6;

/// What [`close_seams`] found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosedSeams {
    /// Number of vertices that were moved.
    pub moved: usize,
    /// Within which distance they lay, in the mesh's unit.
    pub tolerance: f64,
    /// Whether an edge of the mesh as it came has more than two triangles.
    pub is_crowded: bool,
}

/// Moves vertices at borders of a mesh onto those of another border that lie within [`SEAM_TOLERANCE`] of its size. Vertices
/// stay apart, with attributes of their own; triangles keep their area.
///
/// # Errors
/// [`Cancelled`].
pub fn close_seams(mesh: &mut Mesh, context: &Context) -> Result<ClosedSeams, Cancelled> {
    let tolerance = mesh
        .bounds()
        .map_or(0.0, |(low, high)| SEAM_TOLERANCE * low.distance(high));
    let (points, count) = mesh.points();
    context.check()?;
    let mut places = vec![DVec3::ZERO; count];
    for (v, &p) in points.iter().enumerate() {
        places[p as usize] = mesh.positions[v];
    }
    let sides: Vec<[u32; 2]> = (mesh.triangles.iter())
        .map(|t| t.map(|v| points[v as usize]))
        .flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    context.check()?;
    let mut sorted = sides.clone();
    sorted.par_sort_unstable();
    context.check()?;
    let is_crowded = sorted.windows(3).any(|w| w[0] == w[2]);
    let lone = sorted.chunk_by(|a, b| a == b).filter(|e| e.len() == 1);
    let mut border: Vec<u32> = lone.flat_map(|e| e[0]).collect();
    border.sort_unstable();
    border.dedup();
    let mut joined = Unions::new(count);
    let any = join_near(&border, &places, tolerance, &mut joined);
    let mut closed = ClosedSeams {
        moved: 0,
        tolerance,
        is_crowded,
    };
    if !any {
        return Ok(closed);
    }
    // Nothing is moved where a side of a triangle would vanish.
    let sides = sides.iter().filter(|[a, b]| a != b);
    let vanishing: FxHashSet<u32> = sides
        .filter_map(|[a, b]| Some(joined.root(*a)).filter(|r| *r == joined.root(*b)))
        .collect();
    for (v, &p) in points.iter().enumerate() {
        let root = joined.root(p);
        if root != p && !vanishing.contains(&root) {
            mesh.positions[v] = places[root as usize];
            closed.moved += 1;
        }
    }
    Ok(closed)
}

/// Joins those of the `border` that lie within a tolerance of each other, as numbers of `places`. Returns whether there are any. The
/// time follows from the size of the border, however many lie together.
fn join_near(border: &[u32], places: &[DVec3], tolerance: f64, joined: &mut Unions) -> bool {
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return false;
    }
    // In a cell of this size all are near each other, and those near to one are at most two cells away along each axis.
    let cell = tolerance / 3f64.sqrt() * (1.0 - 1e-9);
    let at = |v: u32| places[v as usize];
    let low = (border.iter()).fold(DVec3::INFINITY, |low, &v| low.min(at(v)));
    let number = |v: u32| ((at(v) - low) / cell).to_array().map(|x| x as i64);
    let mut numbered: Vec<([i64; 3], u32)> = border.iter().map(|&v| (number(v), v)).collect();
    numbered.sort_unstable();
    let cells: Vec<&[([i64; 3], u32)]> = numbered.chunk_by(|a, b| a.0 == b.0).collect();
    let mut any = false;
    for cell in &cells {
        for &(_, v) in &cell[1..] {
            any |= joined.join(cell[0].1, v);
        }
    }
    // Each pair of cells is looked at from the one that comes first.
    let rows = [(0, 0), (0, 1), (0, 2)].into_iter();
    let rows = rows.chain((1..=2).flat_map(|i| (-2..=2).map(move |j| (i, j))));
    for (i, j) in rows {
        let mut from = 0;
        for (place, one) in cells.iter().enumerate() {
            let [x, y, z] = one[0].0;
            let least = if (i, j) == (0, 0) { z + 1 } else { z - 2 };
            from = from.max(place);
            while from < cells.len() && cells[from][0].0 < [x + i, y + j, least] {
                from += 1;
            }
            let others = cells[from..].iter();
            for other in others.take_while(|other| other[0].0 <= [x + i, y + j, z + 2]) {
                let near = |&(_, a): &([i64; 3], u32)| {
                    (other.iter()).any(|&(_, b)| at(a).distance(at(b)) <= tolerance)
                };
                if joined.root(one[0].1) != joined.root(other[0].1) && one.iter().any(near) {
                    any |= joined.join(one[0].1, other[0].1);
                }
            }
        }
    }
    any
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares side by side, the second one `gap` off the first.
    fn squares(gap: f64) -> Mesh {
        let square = |x: f64| [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(u, v)| (x + u, v));
        Mesh {
            positions: [square(0.0), square(1.0 + gap)]
                .concat()
                .into_iter()
                .map(|(x, y)| DVec3::new(x, y, 0.0))
                .collect(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
            ..Mesh::default()
        }
    }

    #[test]
    fn sides_within_the_tolerance_meet() {
        let mut near = squares(1e-9);
        assert_eq!(close_seams(&mut near, &Context::quiet()).unwrap().moved, 2);
        assert_eq!(near.points().1, 6);
        let mut far = squares(1e-4);
        assert_eq!(close_seams(&mut far, &Context::quiet()).unwrap().moved, 0);
        assert_eq!(far, squares(1e-4));
    }

    #[test]
    fn the_same_are_joined_as_by_comparing_all() {
        let mut state = 1u64;
        let mut next = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 40) as f64 / (1u64 << 24) as f64
        };
        // Sparse, dense, and so crowded that all lie in a few cells; across the axes too.
        for (size, tolerance) in [
            (DVec3::ONE, 0.03),
            (DVec3::new(0.2, 1.0, 0.01), 0.1),
            (DVec3::ONE, 1.5),
        ] {
            let places: Vec<DVec3> = (0..300)
                .map(|_| DVec3::new(next(), next(), next()) * size - 0.5)
                .collect();
            let border: Vec<u32> = (0..300).filter(|v| v % 7 != 0).collect();
            let (mut expected, mut found) = (Unions::new(300), Unions::new(300));
            let mut any = false;
            for (i, &a) in border.iter().enumerate() {
                for &b in &border[i + 1..] {
                    if places[a as usize].distance(places[b as usize]) <= tolerance {
                        any |= expected.join(a, b);
                    }
                }
            }
            assert!(any);
            assert!(join_near(&border, &places, tolerance, &mut found));
            for v in 0..300 {
                assert_eq!(found.root(v), expected.root(v), "{size} {tolerance}");
            }
        }
    }

    #[test]
    fn many_that_lie_together_take_little_time() {
        // Ten thousand triangles apart in a plane across the first axis, and all of them within the tolerance of one that is far away.
        let mut mesh = Mesh::default();
        for i in 0..10_000 {
            let corner = DVec3::new(0.0, f64::from(i % 100), f64::from(i / 100));
            let first = mesh.positions.len() as u32;
            let corners = [
                DVec3::ZERO,
                DVec3::new(0.0, 0.4, 0.0),
                DVec3::new(0.0, 0.0, 0.4),
            ];
            mesh.positions.extend(corners.map(|c| corner + c));
            mesh.triangles.push([first, first + 1, first + 2]);
        }
        assert_eq!(close_seams(&mut mesh, &Context::quiet()).unwrap().moved, 0);
        mesh.positions[0].x = 1e30;
        let all = mesh.clone();
        // Corners of one triangle are not put together.
        assert_eq!(close_seams(&mut mesh, &Context::quiet()).unwrap().moved, 0);
        assert_eq!(mesh, all);
    }

    #[test]
    fn slivers_keep_their_corners() {
        let mut sliver = Mesh {
            positions: [(0., 0.), (1e-9, 0.), (0., 1.)]
                .map(|(x, y)| DVec3::new(x, y, 0.0))
                .to_vec(),
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        assert_eq!(
            close_seams(&mut sliver, &Context::quiet()).unwrap().moved,
            0
        );
    }
}
