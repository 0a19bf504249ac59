//! Bark that folds back over itself, so that it is no surface over angle and length: screened Poisson reconstruction of the
//! points with their normals, cut off square to the stem at both ends.

use super::points::Addressed;
use super::report::{ScanError, ScanOptions, ScanReport, ScannedBark};
use super::surface::{covers, span};
use super::{Followed, MOST_FOLDED};
use crate::stem::Place;
use glam::DVec3;
use greenstick_geometry::cloud::{KdTree, MAX_NODES, orient_along_tree, poisson, try_normals};
use greenstick_geometry::{Attribute, Bvh, Cancelled, Context, Mesh, PointCloud};

/// Points in a cell on average, at least.
const PER_CELL: f64 = 4.0;
/// Part of the most nodes that a grid uses.
const NODES: f64 = 0.3;
/// Neighbours of a normal, and of the tree along which normals are oriented.
const NEAR: usize = 12;
const LINKED: usize = 8;
/// Points whose distance from the surface is taken.
const JUDGED: usize = 4000;

/// The bark about the place at length `at`, folds and all.
pub(super) fn bark(
    cloud: &PointCloud,
    followed: &Followed,
    at: f64,
    options: &ScanOptions,
    context: &Context,
) -> Result<ScannedBark, ScanError> {
    // With what lies off the median form, which is bark here.
    let mut addressed = Addressed::new(cloud, followed, options.bark_only);
    let length = followed.axis.length();
    let cover = covers(&addressed, followed);
    let (from, to) = span(&addressed, &cover, at, length, options.least_cover, 1.0)?;
    let margin = 2.0 * followed.mean_radius();
    addressed
        .points
        .retain(|p| (from - margin..=to + margin).contains(&p.s));
    let points: Vec<DVec3> = addressed
        .points
        .iter()
        .map(|p| cloud.points[p.number as usize])
        .collect();
    let directions = directions(&addressed, &points, context)?;
    let mean_cover = cover
        .iter()
        .map(|c| c.share * (c.to_m - c.from_m))
        .sum::<f64>()
        / length;
    let radius = followed.mean_radius();
    let area = followed.section.girth(radius) * (to - from) * mean_cover;
    let (low, high) = points
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| {
            (a.min(*p), b.max(*p))
        });
    let extent = (high - low + 2.0 * radius).to_array();
    let cell = (PER_CELL * area / points.len().max(1) as f64)
        .sqrt()
        .max((extent.iter().product::<f64>() / (NODES * MAX_NODES)).cbrt());
    let [base, end] = [from, to].map(|s| followed.axis.frame(s));
    let inside = |p: DVec3| {
        let ahead = (p - base.origin).dot(base.tangent);
        ahead.min((end.origin - p).dot(end.tangent))
    };
    let mut mesh = largest(poisson(&points, &directions, cell, inside, context)?);
    if mesh.triangles.is_empty() {
        return Err(ScanError::NoStem {
            points: points.len(),
        });
    }
    let noise_m = noise(&mesh, &points, &addressed, (from, to));
    if !cloud.colours.is_empty() {
        let tree = KdTree::new(&points);
        let data = mesh.positions.iter().flat_map(|p| {
            let near = tree.nearest(*p, 1).first().map_or(0, |n| n.1 as usize);
            let number = addressed.points[near].number as usize;
            cloud.colours[number].map(|c| f32::from(c) / 255.0)
        });
        let colours = Attribute {
            width: 3,
            data: data.collect(),
        };
        mesh.attributes.insert("COLOR_0".to_owned(), colours);
    }
    let frame = followed.axis.frame(at);
    let aim = frame.origin + frame.x * followed.radius(at);
    let off = |p: &&DVec3| p.distance_squared(aim);
    let place = mesh
        .positions
        .iter()
        .min_by(|a, b| off(a).total_cmp(&off(b)));
    let around = followed.section.girth(radius) / cell;
    let mut report = ScanReport {
        points: points.len(),
        strangers: 0,
        fracture_points: addressed.face,
        stem_length_m: length,
        span_m: [from, to],
        radius_m: (mesh.volume() / (std::f64::consts::PI * (to - from))).sqrt(),
        mean_cover,
        completed: 1.0 - mean_cover,
        noise_m,
        cells: [around, (to - from) / cell].map(|n| n.round() as usize),
        ..ScanReport::default()
    };
    report.cover = cover;
    Ok(ScannedBark {
        place: Place::Point(place.copied().unwrap_or(aim)),
        mesh,
        centreline: followed.axis.points().to_vec(),
        report,
    })
}

/// What is told of a bark that was made this way. `folded` is the share of the sections' parts with folds.
pub(super) fn note(from: f64, to: f64, folded: f64) -> String {
    format!(
        "from {from:.2} to {to:.2} m along the stem a ray from the pith meets {:.0} % of the sections' parts more than once, \
         and {:.0} % is the most for a surface over angle and length: the bark was closed by screened Poisson reconstruction",
        100.0 * folded,
        100.0 * MOST_FOLDED
    )
}

/// Normals of the points out of the wood: the cloud's own, or those of their neighbourhoods.
fn directions(
    addressed: &Addressed,
    points: &[DVec3],
    context: &Context,
) -> Result<Vec<DVec3>, Cancelled> {
    let own = &addressed.cloud.normals;
    if !own.is_empty() {
        let numbers = addressed.points.iter().map(|p| p.number as usize);
        return Ok(numbers.map(|n| own[n]).collect());
    }
    let tree = KdTree::try_new(points, context)?;
    let mut found = try_normals(points, &tree, NEAR, context)?;
    orient_along_tree(points, &mut found, &tree, LINKED, context)?;
    Ok(found)
}

/// The connected part of a closed mesh that holds most.
fn largest(mesh: Mesh) -> Mesh {
    let shells = mesh.shells();
    let mut volumes = vec![0.0; shells.count];
    let origin = mesh.positions.first().copied().unwrap_or_default();
    for (t, &shell) in shells.of_triangle.iter().enumerate() {
        let [a, b, c] = mesh.corners(t).map(|p| p - origin);
        volumes[shell as usize] += a.dot(b.cross(c));
    }
    let best = (0..shells.count).max_by(|a, b| volumes[*a].total_cmp(&volumes[*b]));
    let mut new = vec![u32::MAX; mesh.positions.len()];
    let mut part = Mesh::default();
    for (t, &shell) in shells.of_triangle.iter().enumerate() {
        if Some(shell as usize) != best {
            continue;
        }
        part.triangles.push(mesh.triangles[t].map(|v| {
            if new[v as usize] == u32::MAX {
                new[v as usize] = part.positions.len() as u32;
                part.positions.push(mesh.positions[v as usize]);
            }
            new[v as usize]
        }));
    }
    part
}

/// Standard deviation of the points from the surface.
fn noise(mesh: &Mesh, points: &[DVec3], addressed: &Addressed, span: (f64, f64)) -> f64 {
    let bvh = Bvh::from_mesh(mesh);
    let stride = points.len().div_ceil(JUDGED).max(1);
    let (mut squares, mut count) = (0.0, 0usize);
    for (p, a) in points.iter().zip(&addressed.points).step_by(stride) {
        if (span.0..=span.1).contains(&a.s)
            && let Some(near) = bvh.nearest_on_mesh(mesh, *p, f64::INFINITY)
        {
            squares += near.point.distance_squared(*p);
            count += 1;
        }
    }
    (squares / count.max(1) as f64).sqrt()
}
