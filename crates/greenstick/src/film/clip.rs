//! Sawing a mesh across a stem: the triangles that one plane crosses about the stem are parted, and nothing else.

use glam::{DVec2, DVec3};
use greenstick_geometry::{Attribute, Mesh};
use greenstick_wood::polygon::area_and_centroid;
use greenstick_wood::stem::Frame;
use std::collections::BTreeMap;

/// Vertices nearer to the plane than this part of the radius make it move.
const CLOSE: f64 = 1e-9;
/// How far it moves at a time, in radii, and how often at most.
const STEP: f64 = 1e-7;
const STEPS: usize = 1000;

/// Where a mesh is sawn.
pub(super) struct Saw {
    /// Its plane is across the frame's tangent.
    pub frame: Frame,
    /// Centroid (m, in the frame) and area (m²) of the section that is expected there.
    pub expected: (DVec2, f64),
    /// Radius of the stem, m.
    pub radius: f64,
}

/// A closed loop of cuts.
#[derive(Debug, Clone, Default)]
pub(super) struct Loop {
    /// The new vertices of the mesh on it; several lie at one place where the mesh has a seam.
    pub vertices: Vec<u32>,
    /// Places along it, m, and in the section.
    pub places: Vec<DVec3>,
    pub section: Vec<DVec2>,
}

type Edge = (u32, u32);

/// The loops in which the plane crosses the triangles of `which`, as edges between points; only closed ones.
fn loops(crossed: &[(usize, [Edge; 2])]) -> Vec<Vec<Edge>> {
    let mut at: BTreeMap<Edge, Vec<usize>> = BTreeMap::new();
    for (k, (_, edges)) in crossed.iter().enumerate() {
        edges.iter().for_each(|e| at.entry(*e).or_default().push(k));
    }
    let mut used = vec![false; crossed.len()];
    let mut found = Vec::new();
    for start in 0..crossed.len() {
        let mut edges = Vec::new();
        let (mut k, mut from) = (start, crossed[start].1[0]);
        while !used[k] {
            used[k] = true;
            edges.push(from);
            let [a, b] = crossed[k].1;
            from = if a == from { b } else { a };
            match at[&from][..] {
                [x, y] => k = if x == k { y } else { x },
                // An open border, or more than two triangles at an edge.
                _ => break,
            }
        }
        if edges.len() > 2 && k == start && from == edges[0] {
            found.push(edges);
        }
    }
    found
}

/// Saws the triangles of `mesh` that `own` marks, where the plane of `saw` runs about the stem: those triangles are parted
/// into one on one side and two on the other. `own` grows with the mesh. `None`, and nothing is changed, where no closed
/// loop is about what a section of the stem is.
pub(super) fn saw(mesh: &mut Mesh, own: &mut Vec<bool>, saw: &Saw) -> Option<Loop> {
    let (points, count) = mesh.points();
    let mut place = vec![DVec3::ZERO; count];
    for (&point, &p) in points.iter().zip(&mesh.positions) {
        place[point as usize] = p;
    }
    let Saw { frame, radius, .. } = saw;
    let mut height: Vec<f64> = (place.iter())
        .map(|&p| (p - frame.origin).dot(frame.tangent))
        .collect();
    // Through no vertex, so that every crossed triangle is parted into three.
    let free = (0..STEPS).map(|k| STEP * radius * k as f64);
    let by = free
        .into_iter()
        .find(|by| height.iter().all(|h| (h - by).abs() > CLOSE * radius))?;
    height.iter_mut().for_each(|h| *h -= by);
    let edge = |a: u32, b: u32| (a.min(b), a.max(b));
    let mut crossed: Vec<(usize, [Edge; 2])> = Vec::new();
    for (t, corners) in mesh.triangles.iter().enumerate().filter(|(t, _)| own[*t]) {
        let p = corners.map(|v| points[v as usize]);
        if let Some(k) = alone(p.map(|p| height[p as usize] > 0.0)) {
            let (a, b, c) = (p[k], p[(k + 1) % 3], p[(k + 2) % 3]);
            if a != b && b != c && c != a {
                crossed.push((t, [edge(a, b), edge(a, c)]));
            }
        }
    }
    let share = |(a, b): Edge| height[a as usize] / (height[a as usize] - height[b as usize]);
    let cut = |e: Edge| place[e.0 as usize].lerp(place[e.1 as usize], share(e));
    let flat = |p: DVec3| {
        DVec2::new(
            (p - frame.origin).dot(frame.x),
            (p - frame.origin).dot(frame.y),
        )
    };
    let (centre, area) = saw.expected;
    let strange = |edges: &Vec<Edge>| {
        let section: Vec<DVec2> = edges.iter().map(|&e| flat(cut(e))).collect();
        let (own_area, middle) = area_and_centroid(&section);
        let ratio = (own_area.abs() / area).max(1e-300);
        libm::log(ratio).abs() + middle.distance(centre) / radius
    };
    let chosen = (loops(&crossed).into_iter())
        .map(|edges| (strange(&edges), edges))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(strange, _)| *strange < 1.0)?
        .1;
    let mut sorted = chosen.clone();
    sorted.sort_unstable();
    crossed.retain(|(_, edges)| sorted.binary_search(&edges[0]).is_ok());
    let mut made = Loop {
        places: chosen.iter().map(|&e| cut(e)).collect(),
        ..Loop::default()
    };
    made.section = made.places.iter().map(|&p| flat(p)).collect();
    if area_and_centroid(&made.section).0 < 0.0 {
        made.places.reverse();
        made.section.reverse();
    }
    let mut new: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    for (t, _) in crossed {
        let corners = mesh.triangles[t];
        let Some(k) = alone(corners.map(|v| height[points[v as usize] as usize] > 0.0)) else {
            continue;
        };
        let [a, b, c] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
        let [p, q] = [b, c].map(|other| {
            // In the order of the points, so that both sides of a seam get the same bits.
            let first_point = points[a as usize] < points[other as usize];
            let (v, w) = if first_point { (a, other) } else { (other, a) };
            *new.entry((v, w)).or_insert_with(|| {
                let ends = (points[v as usize], points[w as usize]);
                made.vertices.push(mesh.positions.len() as u32);
                push_between(mesh, (v, w), share(ends), cut(ends))
            })
        });
        mesh.triangles[t] = [a, p, q];
        mesh.triangles.extend([[p, b, c], [p, c, q]]);
        if !mesh.materials.is_empty() {
            let material = mesh.materials[t];
            mesh.materials.extend([material; 2]);
        }
        own.extend([true; 2]);
    }
    Some(made)
}

/// The corner that is on the other side than the two others.
fn alone([a, b, c]: [bool; 3]) -> Option<usize> {
    match (a == b, b == c) {
        (true, true) => None,
        (true, false) => Some(2),
        (false, true) => Some(0),
        (false, false) => Some(1),
    }
}

/// Adds the vertex at `place`, the share `t` of the way between two others.
fn push_between(mesh: &mut Mesh, (v, w): (u32, u32), t: f64, place: DVec3) -> u32 {
    for (name, Attribute { width, data }) in &mut mesh.attributes {
        let (v, w) = (v as usize * *width, w as usize * *width);
        let first = data.len();
        for k in 0..*width {
            let (a, b) = (f64::from(data[v + k]), f64::from(data[w + k]));
            data.push((a + (b - a) * t) as f32);
        }
        if matches!(name.as_str(), "NORMAL" | "TANGENT") && *width >= 3 {
            let made = &mut data[first..];
            let n = DVec3::new(made[0].into(), made[1].into(), made[2].into());
            let unit = n.normalize_or_zero().as_vec3().to_array();
            made[..3].copy_from_slice(&unit);
            if let Some(hand) = made.get_mut(3) {
                *hand = hand.signum();
            }
        }
    }
    mesh.positions.push(place);
    mesh.positions.len() as u32 - 1
}
