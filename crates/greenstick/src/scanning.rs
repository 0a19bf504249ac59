//! From a point cloud, or a mesh that is to be treated as one, to a scene with the bark of a stem, and a report.

use crate::Error;
use glam::{DAffine3, DVec3};
use greenstick_formats::CloudFile;
use greenstick_geometry::cloud::{CleanError, CleanOptions, CleanReport, clean};
use greenstick_geometry::{Context, Mesh, Node, PointCloud, Scene, Stage};
use greenstick_wood::scan::{ScanError, ScanOptions, ScanReport, reconstruct_bark};
use greenstick_wood::stem::StemLocation;
use serde::Serialize;
use std::fmt;

/// What is asked of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ScanRequest {
    /// Steps of the cleaning.
    pub clean: CleanOptions,
    /// How the bark is made.
    pub scan: ScanOptions,
}

/// Everything that is worth knowing of a scan.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct ScannedReport {
    /// The cleaning.
    pub clean: CleanReport,
    /// The bark.
    pub bark: Option<ScanReport>,
    /// Triangles of the surface.
    pub triangles: usize,
    /// What was taken off the file's coordinates, m.
    pub origin_m: [f64; 3],
    /// How the file was understood and what was assumed, a sentence each.
    pub notes: Vec<String>,
}

/// A scan as a scene.
#[derive(Debug, Clone)]
pub struct Scanned {
    /// One node, `bark`, in metres.
    pub scene: Scene,
    /// Where the place asked for lies on it.
    pub place: StemLocation,
    /// Points of the centreline from the base, m.
    pub centreline: Vec<DVec3>,
    /// What was done.
    pub report: ScannedReport,
}

/// Why a scan gives no scene.
#[derive(Debug, thiserror::Error)]
pub enum ScanningError {
    /// The cloud cannot be cleaned.
    #[error(transparent)]
    Clean(#[from] CleanError),
    /// There is no bark.
    #[error(transparent)]
    Scan(#[from] ScanError),
}

impl From<greenstick_geometry::Cancelled> for ScanningError {
    fn from(cancelled: greenstick_geometry::Cancelled) -> Self {
        ScanningError::Scan(cancelled.into())
    }
}

/// The bark of the stem at `place` of a cloud. A point as place is in the file's coordinates.
///
/// # Errors
/// [`Error::Scan`] where the cloud cannot be cleaned or holds no stem there.
pub fn scan_to_scene(
    file: &CloudFile,
    place: &StemLocation,
    request: &ScanRequest,
    context: &Context,
) -> Result<Scanned, Error> {
    let place = match *place {
        StemLocation::Point(p) => StemLocation::Point(p - file.origin),
        other => other,
    };
    let made = surfaced(&file.cloud, &place, request, context)?;
    let (mesh, place, centreline, mut report) = made;
    report.origin_m = file.origin.to_array();
    report.notes.splice(0..0, file.notes.iter().cloned());
    report.triangles = mesh.triangles.len();
    let node = Node::new("bark", DAffine3::IDENTITY, mesh);
    let scene = Scene {
        nodes: vec![node],
        ..Scene::default()
    };
    Ok(Scanned {
        scene,
        place,
        centreline,
        report,
    })
}

type Made = (Mesh, StemLocation, Vec<DVec3>, ScannedReport);

fn surfaced(
    cloud: &PointCloud,
    place: &StemLocation,
    request: &ScanRequest,
    context: &Context,
) -> Result<Made, ScanningError> {
    let [cleaning, finding] =
        context.split([(Stage::new("clean"), 1.0), (Stage::new("bark"), 2.0)]);
    let (cloud, cleaned) = clean(cloud, &request.clean, &cleaning)?;
    let bark = reconstruct_bark(&cloud, place, &request.scan, &finding)?;
    let report = ScannedReport {
        clean: cleaned,
        notes: bark.report.notes.clone(),
        bark: Some(bark.report),
        ..ScannedReport::default()
    };
    Ok((bark.mesh, bark.location, bark.centreline, report))
}

/// Points on the triangles of a scene, about; more where there are more triangles. Of thin boards narrow sides show, too.
const SAMPLED: f64 = 50_000.0;

/// Points of the meshes of a scene as a cloud, so that a mesh with holes can be treated as a scan: the vertices, and on
/// every triangle as many as its area asks for, one at least. Normals are those of the triangles.
pub fn cloud_of(scene: &Scene) -> CloudFile {
    let mut cloud = PointCloud::default();
    let meshes: Vec<Mesh> = scene
        .nodes
        .iter()
        .map(|node| node.mesh.transformed(&node.transform))
        .collect();
    let share = meshes.iter().map(Mesh::area).sum::<f64>() / SAMPLED;
    for mesh in &meshes {
        let mut vertices = vec![DVec3::ZERO; mesh.positions.len()];
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = mesh.corners(t);
            let across = (b - a).cross(c - a);
            for &v in triangle {
                vertices[v as usize] += across;
            }
            let normal = across.normalize_or_zero();
            let count = (0.5 * across.length() / share).round().clamp(1.0, SAMPLED) as u32;
            for i in 0..count {
                let (u, v) = spread(i);
                cloud.points.push(a + (b - a) * u + (c - a) * v);
                cloud.normals.push(normal);
            }
        }
        // Vertices that no triangle has are no surface.
        for (p, n) in mesh.positions.iter().zip(vertices) {
            if let Some(normal) = n.try_normalize() {
                cloud.points.push(*p);
                cloud.normals.push(normal);
            }
        }
    }
    CloudFile {
        cloud,
        origin: DVec3::ZERO,
        notes: scene.notes.clone(),
    }
}

/// Place `i` of places that cover a triangle evenly, along two of its sides: a sequence of low discrepancy (Roberts 2018)
/// in the square, folded at its diagonal. The first is the middle.
fn spread(i: u32) -> (f64, f64) {
    const STEPS: (f64, f64) = (0.754_877_666_246_692_8, 0.569_840_290_998_053_3);
    let third = 1.0 / 3.0;
    let [u, v] = [STEPS.0, STEPS.1].map(|step| (third + step * f64::from(i)).fract());
    if u + v <= 1.0 {
        (u, v)
    } else {
        (1.0 - u, 1.0 - v)
    }
}

impl fmt::Display for ScannedReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let c = &self.clean;
        writeln!(
            f,
            "cloud    {} points, {:.2} mm apart",
            c.read,
            c.spacing_m * 1e3
        )?;
        for step in c.steps.iter().filter(|s| s.removed > 0) {
            writeln!(
                f,
                "clean    {}: {} points removed, {} left ({})",
                step.name, step.removed, step.left, step.why
            )?;
        }
        if let Some(b) = &self.bark {
            writeln!(
                f,
                "scan     stem of {:.2} m followed, {:.2} to {:.2} m kept, mean radius {:.1} cm; {} points, {} of other \
                 limbs, {} of fracture surfaces",
                b.stem_length_m,
                b.span_m[0],
                b.span_m[1],
                b.radius_m * 100.0,
                b.points,
                b.foreign_points,
                b.fracture_points
            )?;
            let parts: Vec<String> = b
                .coverage
                .iter()
                .map(|c| format!("{:.0}", c.share * 100.0))
                .collect();
            writeln!(
                f,
                "cover    {:.0} % of the girth seen; metre by metre {} %",
                b.mean_coverage * 100.0,
                parts.join(" ")
            )?;
            writeln!(
                f,
                "bark     {} × {} cells, {:.0} % completed, points {:.2} mm from it (standard deviation)",
                b.cells[0],
                b.cells[1],
                b.completed * 100.0,
                b.noise_m * 1e3
            )?;
        }
        writeln!(f, "surface  {} triangles", self.triangles)?;
        for note in &self.notes {
            writeln!(f, "note     {note}")?;
        }
        Ok(())
    }
}
