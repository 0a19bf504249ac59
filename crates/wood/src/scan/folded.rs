//! Bark that folds back over itself, so that it is no surface over angle and length: screened Poisson reconstruction of the
//! points with their normals, cut off square to the stem at both ends.

use super::coverage::{MAX_FOLDED_SHARE, Requirements, coverage, mean_coverage, usable_span};
use super::points::StemPoints;
use super::report::{ScanError, ScanOptions, ScanReport, ScannedBark};
use super::traced::TracedStem;
use crate::stem::StemLocation;
use glam::DVec3;
use greenstick_geometry::cloud::{KdTree, MAX_NODES, orient_along_tree, poisson, try_normals};
use greenstick_geometry::{Attribute, Bvh, Cancelled, Context, Mesh, PointCloud};
use std::f64::consts::PI;

/// Points in a cell on average, at least.
const MIN_POINTS_PER_CELL: f64 = 4.0;
/// Part of the most nodes that a grid uses.
const NODE_BUDGET: f64 = 0.3;
/// Neighbours that a normal is estimated from, and neighbours along which normals are oriented.
const NORMAL_NEIGHBOURS: usize = 12;
const ORIENTATION_NEIGHBOURS: usize = 8;
/// Most points whose distance from the surface is measured.
const MAX_NOISE_SAMPLES: usize = 4000;

/// The bark about the location at length `at` (m), folds and all.
pub(super) fn bark(
    cloud: &PointCloud,
    stem: &TracedStem,
    at: f64,
    options: &ScanOptions,
    context: &Context,
) -> Result<ScannedBark, ScanError> {
    // With what lies off the median form, which is bark here.
    let mut points = StemPoints::new(cloud, stem, options.bark_only, context)?;
    let length = stem.axis.length();
    let coverage = coverage(&points, stem);
    let required = Requirements {
        min_coverage: options.min_coverage,
        max_folded: 1.0,
    };
    let span = usable_span(&points, &coverage, at, length, required)?;
    let (from, to) = span;
    let margin = 2.0 * stem.mean_radius();
    points
        .points
        .retain(|p| (from - margin..=to + margin).contains(&p.s));
    let positions: Vec<DVec3> = points
        .points
        .iter()
        .map(|p| cloud.points[p.number as usize])
        .collect();
    context.check()?;
    let directions = outward_normals(&points, &positions, context)?;
    let mean_coverage = mean_coverage(&coverage, length);
    let cell = cell_width(&positions, stem, to - from, mean_coverage);
    let [base, end] = [from, to].map(|s| stem.axis.frame(s));
    let inside = |p: DVec3| {
        let ahead = (p - base.origin).dot(base.tangent);
        ahead.min((end.origin - p).dot(end.tangent))
    };
    let mut mesh = largest_shell(poisson(&positions, &directions, cell, inside, context)?);
    if mesh.triangles.is_empty() {
        return Err(ScanError::NoStem {
            points: positions.len(),
        });
    }
    context.check()?;
    let noise_m = noise(&mesh, &positions, &points, span);
    if !cloud.colours.is_empty() {
        let colours = colours(&mesh, &positions, &points);
        mesh.attributes.insert("COLOR_0".to_owned(), colours);
    }
    let around = stem.shape.girth(stem.mean_radius()) / cell;
    let report = ScanReport {
        points: positions.len(),
        foreign_points: 0,
        fracture_points: points.fracture_points,
        stem_length_m: length,
        stem_length_error_m: stem.length_error,
        radius_error_m: stem.radius_error,
        span_m: [from, to],
        radius_m: (mesh.volume() / (PI * (to - from))).sqrt(),
        coverage,
        mean_coverage,
        completed: 1.0 - mean_coverage,
        noise_m,
        cells: [around, (to - from) / cell].map(|n| n.round() as usize),
        ..ScanReport::default()
    };
    Ok(ScannedBark {
        location: StemLocation::Point(vertex_at(&mesh, stem, at)),
        mesh,
        centreline: stem.axis.points().to_vec(),
        report,
    })
}

/// The note of a bark that was made this way. `folded` is the share of the sections' patches with folds.
pub(super) fn note(from: f64, to: f64, folded: f64) -> String {
    format!(
        "from {from:.2} to {to:.2} m along the stem a ray from the pith meets {:.0} % of the sections' patches more than \
         once, and {:.0} % is the most for a surface over angle and length: the bark was closed by screened Poisson \
         reconstruction",
        100.0 * folded,
        100.0 * MAX_FOLDED_SHARE
    )
}

/// Side of a cell (m): some points in each over `length` metres of the stem, and no more cells than the budget.
fn cell_width(positions: &[DVec3], stem: &TracedStem, length: f64, coverage: f64) -> f64 {
    let radius = stem.mean_radius();
    let area = stem.shape.girth(radius) * length * coverage;
    let (low, high) = positions
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| {
            (a.min(*p), b.max(*p))
        });
    let volume: f64 = (high - low + 2.0 * radius).to_array().iter().product();
    let by_points = (MIN_POINTS_PER_CELL * area / positions.len().max(1) as f64).sqrt();
    by_points.max((volume / (NODE_BUDGET * MAX_NODES)).cbrt())
}

/// The vertex nearest to the bark at length `at` (m) and angle 0.
fn vertex_at(mesh: &Mesh, stem: &TracedStem, at: f64) -> DVec3 {
    let frame = stem.axis.frame(at);
    let aim = frame.origin + frame.x * stem.radius(at);
    let distance = |p: &DVec3| p.distance_squared(aim);
    let nearest = mesh
        .positions
        .iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)));
    nearest.copied().unwrap_or(aim)
}

/// Colours of the nearest points.
fn colours(mesh: &Mesh, positions: &[DVec3], points: &StemPoints) -> Attribute {
    let tree = KdTree::new(positions);
    let data = mesh.positions.iter().flat_map(|p| {
        let near = tree.nearest(*p, 1).first().map_or(0, |n| n.1 as usize);
        let number = points.points[near].number as usize;
        points.cloud.colours[number].map(|c| f32::from(c) / 255.0)
    });
    Attribute {
        width: 3,
        data: data.collect(),
    }
}

/// Normals that point out of the wood: the cloud's own, or those of the points' neighbourhoods.
fn outward_normals(
    points: &StemPoints,
    positions: &[DVec3],
    context: &Context,
) -> Result<Vec<DVec3>, Cancelled> {
    let own = &points.cloud.normals;
    if !own.is_empty() {
        let numbers = points.points.iter().map(|p| p.number as usize);
        return Ok(numbers.map(|n| own[n]).collect());
    }
    let tree = KdTree::try_new(positions, context)?;
    let mut found = try_normals(positions, &tree, NORMAL_NEIGHBOURS, context)?;
    orient_along_tree(
        positions,
        &mut found,
        &tree,
        ORIENTATION_NEIGHBOURS,
        context,
    )?;
    Ok(found)
}

/// The connected part of a closed mesh with the largest volume.
fn largest_shell(mesh: Mesh) -> Mesh {
    let shells = mesh.shells();
    let mut volumes = vec![0.0; shells.count];
    let origin = mesh.positions.first().copied().unwrap_or_default();
    for (t, &shell) in shells.of_triangle.iter().enumerate() {
        let [a, b, c] = mesh.corners(t).map(|p| p - origin);
        volumes[shell as usize] += a.dot(b.cross(c));
    }
    let best = (0..shells.count).max_by(|a, b| volumes[*a].total_cmp(&volumes[*b]));
    let mut new = vec![u32::MAX; mesh.positions.len()];
    let mut largest = Mesh::default();
    for (t, &shell) in shells.of_triangle.iter().enumerate() {
        if Some(shell as usize) != best {
            continue;
        }
        largest.triangles.push(mesh.triangles[t].map(|v| {
            if new[v as usize] == u32::MAX {
                new[v as usize] = largest.positions.len() as u32;
                largest.positions.push(mesh.positions[v as usize]);
            }
            new[v as usize]
        }));
    }
    largest
}

/// Standard deviation of the points within `span` (m) from the surface.
fn noise(mesh: &Mesh, positions: &[DVec3], points: &StemPoints, span: (f64, f64)) -> f64 {
    let bvh = Bvh::from_mesh(mesh);
    let stride = positions.len().div_ceil(MAX_NOISE_SAMPLES).max(1);
    let (mut squares, mut count) = (0.0, 0usize);
    for (p, a) in positions.iter().zip(&points.points).step_by(stride) {
        if (span.0..=span.1).contains(&a.s)
            && let Some(near) = bvh.nearest_on_mesh(mesh, *p, f64::INFINITY)
        {
            squares += near.point.distance_squared(*p);
            count += 1;
        }
    }
    (squares / count.max(1) as f64).sqrt()
}
