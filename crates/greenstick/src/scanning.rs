//! Reconstruction of a stem's bark from a point cloud, or from a mesh that is treated as one.

pub use greenstick_geometry::cloud::points_table as cleaned_table;
pub use greenstick_wood::scan::{
    ScanParameters, ScanRequest, ScannedReport, ScanningError, outline_error,
};

use crate::Error;
use glam::{DAffine3, DVec3};
use greenstick_formats::CloudFile;
use greenstick_geometry::cloud::sample_meshes;
use greenstick_geometry::{Context, Mesh, Node, PointCloud, Scene};
use greenstick_wood::scan::clean_and_reconstruct;
use greenstick_wood::stem::StemLocation;

/// A scan as a scene.
#[derive(Debug, Clone)]
pub struct Scanned {
    /// One node, `bark`, in metres.
    pub scene: Scene,
    /// Where the requested location lies on it.
    pub location: StemLocation,
    /// Points of the centreline from the base, m.
    pub centreline: Vec<DVec3>,
    /// The points that were left after cleaning, in the coordinates of the scene.
    pub cleaned: PointCloud,
    /// The report.
    pub report: ScannedReport,
}

/// Reconstructs the bark of the stem at a location of a cloud. A point as location is in the file's coordinates.
///
/// # Errors
/// [`Error::Scan`] if the cloud cannot be cleaned or has no stem there.
pub fn scan_to_scene(
    file: &CloudFile,
    location: &StemLocation,
    request: &ScanRequest,
    context: &Context,
) -> Result<Scanned, Error> {
    let location = match *location {
        StemLocation::Point(p) => StemLocation::Point(p - file.origin),
        other => other,
    };
    let (clean, bark, cleaned) = clean_and_reconstruct(&file.cloud, &location, request, context)?;
    let mut notes = file.notes.clone();
    notes.extend(bark.report.notes.iter().cloned());
    let report = ScannedReport {
        clean,
        triangles: bark.mesh.triangles.len(),
        origin_m: file.origin.to_array(),
        notes,
        bark: Some(bark.report),
    };
    Ok(Scanned {
        scene: Scene {
            nodes: vec![Node::new("bark", DAffine3::IDENTITY, bark.mesh)],
            ..Scene::default()
        },
        location: bark.location,
        centreline: bark.centreline,
        cleaned,
        report,
    })
}

/// Approximate number of points sampled on a scene; more if it has more triangles.
const SAMPLED_POINTS: f64 = 50_000.0;

/// Samples the meshes of a scene as a cloud, so that a mesh with holes can be treated as a scan.
pub fn cloud_from_scene(scene: &Scene) -> CloudFile {
    let nodes = scene.nodes.iter();
    let meshes: Vec<Mesh> = nodes.map(|n| n.mesh.transformed(&n.transform)).collect();
    CloudFile {
        cloud: sample_meshes(&meshes, SAMPLED_POINTS),
        origin: DVec3::ZERO,
        notes: scene.notes.clone(),
    }
}
