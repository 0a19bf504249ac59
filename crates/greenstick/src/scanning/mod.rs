//! Reconstruction of a stem's bark from a point cloud, or from a mesh that is treated as one.

pub(crate) mod error;
mod parameters;
mod report;

pub use error::ScanningError;
pub use parameters::ScanParameters;
pub use report::ScannedReport;

use crate::Error;
use glam::{DAffine3, DVec3};
use greenstick_formats::CloudFile;
use greenstick_geometry::cloud::{CleanOptions, CleanReport, clean, sample_meshes};
use greenstick_geometry::{Context, Mesh, Node, PointCloud, Scene, Stage};
use greenstick_wood::scan::{ScanOptions, ScannedBark, reconstruct_bark};
use greenstick_wood::stem::StemLocation;

/// Everything that determines the bark of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ScanRequest {
    /// Steps of the cleaning.
    pub clean: CleanOptions,
    /// How the bark is reconstructed.
    pub scan: ScanOptions,
}

/// A scan as a scene.
#[derive(Debug, Clone)]
pub struct Scanned {
    /// One node, `bark`, in metres.
    pub scene: Scene,
    /// Where the requested location lies on it.
    pub location: StemLocation,
    /// Points of the centreline from the base, m.
    pub centreline: Vec<DVec3>,
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
    let (clean, bark) = clean_and_reconstruct(&file.cloud, &location, request, context)?;
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
        report,
    })
}

fn clean_and_reconstruct(
    cloud: &PointCloud,
    location: &StemLocation,
    request: &ScanRequest,
    context: &Context,
) -> Result<(CleanReport, ScannedBark), ScanningError> {
    let [cleaning, finding] =
        context.split([(Stage::new("clean"), 1.0), (Stage::new("bark"), 2.0)]);
    let (cloud, cleaned) = clean(cloud, &request.clean, &cleaning)?;
    let bark = reconstruct_bark(&cloud, location, &request.scan, &finding)?;
    Ok((cleaned, bark))
}

/// Approximate number of points sampled on a scene; more if it has more triangles.
const SAMPLED_POINTS: f64 = 50_000.0;

/// Samples the meshes of a scene as a cloud, so that a mesh with holes can be treated as a scan.
pub fn cloud_from_scene(scene: &Scene) -> CloudFile {
    let meshes: Vec<Mesh> = scene
        .nodes
        .iter()
        .map(|node| node.mesh.transformed(&node.transform))
        .collect();
    CloudFile {
        cloud: sample_meshes(&meshes, SAMPLED_POINTS),
        origin: DVec3::ZERO,
        notes: scene.notes.clone(),
    }
}
