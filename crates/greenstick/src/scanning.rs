//! From a point cloud, or a mesh that is to be treated as one, to a scene with the bark of a stem, and a report.

use crate::Error;
use glam::{DAffine3, DVec3};
use greenstick_formats::CloudFile;
use greenstick_geometry::cloud::{
    CleanError, CleanOptions, CleanReport, Neighbours, clean, normals, orient_along_tree, spacing,
};
use greenstick_geometry::{Context, Mesh, Node, PointCloud, Scene};
use greenstick_poisson::PoissonError;
use greenstick_wood::scan::{ScanError, ScanOptions, ScanReport, scanned_bark};
use greenstick_wood::stem::Place;
use serde::Serialize;
use std::fmt;

/// How the surface is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Surfacing {
    /// Over angle and length; by Poisson's equation where sections are folded.
    #[default]
    Automatic,
    /// Over angle and length.
    Sections,
    /// By screened Poisson reconstruction of the whole cloud.
    Poisson,
}

/// What is asked of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ScanRequest {
    /// Steps of the cleaning.
    pub clean: CleanOptions,
    /// How the bark is made.
    pub scan: ScanOptions,
    /// By which way.
    pub surfacing: Surfacing,
}

/// Everything that is worth knowing of a scan.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct ScannedReport {
    /// The cleaning.
    pub clean: CleanReport,
    /// `sections` or `Poisson`.
    pub surfaced_by: String,
    /// The bark; none where it was made by Poisson's equation.
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
    pub place: Place,
    /// Points of the centreline from the base, m; empty where the surface was made by Poisson's equation.
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
    /// There is no surface.
    #[error(transparent)]
    Poisson(#[from] PoissonError),
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
    place: &Place,
    request: &ScanRequest,
    context: &Context,
) -> Result<Scanned, Error> {
    let place = match *place {
        Place::Point(p) => Place::Point(p - file.origin),
        other => other,
    };
    let made = surfaced(&file.cloud, &place, request, context)?;
    let (mesh, place, centreline, mut report) = made;
    report.origin_m = file.origin.to_array();
    report.notes.splice(0..0, file.notes.iter().cloned());
    report.triangles = mesh.triangles.len();
    let node = Node {
        name: "bark".to_owned(),
        transform: DAffine3::IDENTITY,
        mesh,
        parent: None,
    };
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

type Made = (Mesh, Place, Vec<DVec3>, ScannedReport);

fn surfaced(
    cloud: &PointCloud,
    place: &Place,
    request: &ScanRequest,
    context: &Context,
) -> Result<Made, ScanningError> {
    let (cloud, cleaned) = clean(cloud, &request.clean, context)?;
    let mut report = ScannedReport {
        clean: cleaned,
        surfaced_by: "sections".to_owned(),
        ..ScannedReport::default()
    };
    if request.surfacing != Surfacing::Poisson {
        match scanned_bark(&cloud, place, &request.scan, context) {
            Ok(bark) => {
                report.notes.extend(bark.report.notes.iter().cloned());
                report.bark = Some(bark.report);
                return Ok((bark.mesh, bark.place, bark.centreline, report));
            }
            Err(ScanError::NotStarShaped { share, .. })
                if request.surfacing == Surfacing::Automatic =>
            {
                report.notes.push(format!(
                    "{:.0} % of the sections are folded: the surface was made by Poisson's equation",
                    share * 100.0
                ));
            }
            Err(error) => return Err(error.into()),
        }
    }
    let mesh = by_poisson(cloud, report.clean.spacing_m, context)?;
    report.surfaced_by = "Poisson".to_owned();
    Ok((mesh, *place, Vec::new(), report))
}

/// Neighbours that a normal is estimated from, and along which normals are oriented.
const NEIGHBOURS: usize = 12;

fn by_poisson(
    mut cloud: PointCloud,
    spacing: f64,
    context: &Context,
) -> Result<Mesh, ScanningError> {
    context.step("normals", 0.0)?;
    if cloud.normals.is_empty() {
        let tree = Neighbours::new(&cloud.points);
        cloud.normals = normals(&cloud.points, &tree, NEIGHBOURS);
        context.step("normals", 0.5)?;
        orient_along_tree(&cloud.points, &mut cloud.normals, &tree, NEIGHBOURS);
    }
    Ok(greenstick_poisson::surface(&cloud, spacing, context)?)
}

/// Points of the meshes of a scene as a cloud: the vertices, and where triangles are wide also points on them, so that a
/// mesh with holes can be treated as a scan.
pub fn cloud_of(scene: &Scene) -> CloudFile {
    let mut cloud = PointCloud::default();
    for node in &scene.nodes {
        let mesh = node.mesh.transformed(&node.transform);
        let step = spacing(&mesh.positions);
        cloud.points.extend(&mesh.positions);
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(t);
            let side = a.distance(b).max(b.distance(c)).max(c.distance(a));
            // A triangle of a hundred steps has five thousand points; wider ones get no more.
            let parts = if step > 0.0 {
                (side / step).ceil().clamp(1.0, 100.0) as usize
            } else {
                1
            };
            for i in 0..parts {
                for j in 0..parts - i {
                    let (u, v) = (
                        (i as f64 + 1.0 / 3.0) / parts as f64,
                        (j as f64 + 1.0 / 3.0) / parts as f64,
                    );
                    cloud.points.push(a + (b - a) * u + (c - a) * v);
                }
            }
        }
    }
    CloudFile {
        cloud,
        origin: DVec3::ZERO,
        notes: scene.notes.clone(),
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
                b.strangers,
                b.fracture_points
            )?;
            let parts: Vec<String> = b
                .cover
                .iter()
                .map(|c| format!("{:.0}", c.share * 100.0))
                .collect();
            writeln!(
                f,
                "cover    {:.0} % of the girth seen; metre by metre {} %",
                b.mean_cover * 100.0,
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
        writeln!(
            f,
            "surface  by {}, {} triangles",
            self.surfaced_by, self.triangles
        )?;
        for note in &self.notes {
            writeln!(f, "note     {note}")?;
        }
        Ok(())
    }
}
