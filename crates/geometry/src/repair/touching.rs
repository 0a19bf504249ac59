//! Points that rounding brings to one position although no edge joins them: left there, two sheets of a surface would hang together in a
//! point or along an edge that belongs to four triangles.

use crate::Mesh;
use crate::unions::Unions;
use glam::DVec3;
use rustc_hash::FxHashMap;

/// Positions that are not those of `f32`, with the vertices that have them, ascending.
pub(super) fn inexact(mesh: &Mesh) -> Vec<(u32, DVec3)> {
    let numbered = (0..).zip(&mesh.positions);
    let inexact = numbered.filter(|(_, p)| p.as_vec3().as_dvec3() != **p);
    inexact.map(|(v, p)| (v, *p)).collect()
}

/// Vertices of one point that had one position before rounding, or are joined to such by an edge that is gone.
struct Sheet {
    /// Where they were.
    from: DVec3,
    vertices: Vec<u32>,
}

/// Moves points of a rounded mesh apart that rounding has brought together without an edge between them, by one step of `f32` towards
/// where they were. `points` are the numbers of the vertices' points, `before` is what [`inexact`] gave. Returns whether any moved.
pub(super) fn part_touching(mesh: &mut Mesh, points: &[u32], before: &[(u32, DVec3)]) -> bool {
    let mut groups = brought_together(mesh, points, before);
    if groups.is_empty() {
        return false;
    }
    join_along_edges(mesh, points, &mut groups);
    groups.retain(|_, sheets| sheets.len() > 1);
    let mut groups: Vec<(u32, Vec<Sheet>)> = groups.into_iter().collect();
    groups.sort_by_key(|g| g.0);
    for (_, mut sheets) in groups.iter_mut().map(|(p, s)| (p, std::mem::take(s))) {
        // What lies at the rounded position stays there.
        let at = mesh.positions[sheets[0].vertices[0] as usize];
        sheets.sort_by(|a, b| {
            let off = |s: &Sheet| s.from.distance_squared(at);
            off(a).total_cmp(&off(b)).then(a.vertices.cmp(&b.vertices))
        });
        for sheet in &sheets[1..] {
            let to = step_towards(at, sheet.from);
            for &v in &sheet.vertices {
                mesh.positions[v as usize] = to;
            }
        }
    }
    !groups.is_empty()
}

/// Returns the points whose vertices had more than one position before rounding, each with its sheets. They are few: all else is
/// told by one number for each point.
fn brought_together(
    mesh: &Mesh,
    points: &[u32],
    before: &[(u32, DVec3)],
) -> FxHashMap<u32, Vec<Sheet>> {
    // Where the first vertex of each point was: an index into `before`, or `STAYED`.
    const UNSEEN: u32 = u32::MAX;
    const STAYED: u32 = u32::MAX - 1;
    let mut first = vec![UNSEEN; points.len()];
    let mut groups: FxHashMap<u32, Vec<Sheet>> = FxHashMap::default();
    let mut moved = (0u32..).zip(before).peekable();
    for (v, &point) in (0..).zip(points) {
        let index = moved.next_if(|(_, b)| b.0 == v).map_or(STAYED, |(i, _)| i);
        let first = &mut first[point as usize];
        if *first == UNSEEN {
            *first = index;
        }
        let same = *first == index
            || (*first != STAYED
                && index != STAYED
                && before[*first as usize].1 == before[index as usize].1);
        if !same {
            groups.entry(point).or_default();
        }
    }
    if groups.is_empty() {
        return groups;
    }
    for &(v, from) in before {
        if let Some(sheets) = groups.get_mut(&points[v as usize]) {
            add(sheets, v, from);
        }
    }
    let mut moved = before.iter().map(|b| b.0).peekable();
    for (v, point) in (0..).zip(points) {
        if moved.next_if_eq(&v).is_none()
            && let Some(sheets) = groups.get_mut(point)
        {
            add(sheets, v, mesh.positions[v as usize]);
        }
    }
    groups
}

fn add(sheets: &mut Vec<Sheet>, vertex: u32, from: DVec3) {
    match sheets.iter_mut().find(|s| s.from == from) {
        Some(sheet) => sheet.vertices.push(vertex),
        None => sheets.push(Sheet {
            from,
            vertices: vec![vertex],
        }),
    }
}

/// Joins the sheets of each point that an edge between two of its vertices joins: what collapses to a point is one.
fn join_along_edges(mesh: &Mesh, points: &[u32], groups: &mut FxHashMap<u32, Vec<Sheet>>) {
    let mut joined: FxHashMap<u32, Vec<[u32; 2]>> = FxHashMap::default();
    for t in &mesh.triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            let point = points[a as usize];
            if point == points[b as usize] && groups.contains_key(&point) {
                joined.entry(point).or_default().push([a, b]);
            }
        }
    }
    for (point, edges) in joined {
        let Some(sheets) = groups.get_mut(&point) else {
            continue;
        };
        let number = |v: u32| sheets.iter().position(|s| s.vertices.contains(&v));
        let mut sets = Unions::new(sheets.len());
        for [a, b] in edges {
            if let (Some(a), Some(b)) = (number(a), number(b)) {
                sets.join(a as u32, b as u32);
            }
        }
        for i in (0..sheets.len()).rev() {
            let root = sets.root(i as u32) as usize;
            if root != i {
                let sheet = sheets.remove(i);
                sheets[root].vertices.extend(sheet.vertices);
            }
        }
    }
}

/// Returns the neighbour of a position of `f32` along the axis on which `from` is farthest from it.
fn step_towards(at: DVec3, from: DVec3) -> DVec3 {
    let off = from - at;
    let axis = (0..3).fold(0, |best, k| {
        if off[k].abs() > off[best].abs() {
            k
        } else {
            best
        }
    });
    let mut to = at;
    let near = at[axis] as f32;
    let next = if off[axis] > 0.0 {
        near.next_up()
    } else {
        near.next_down()
    };
    to[axis] = f64::from(next);
    to
}
