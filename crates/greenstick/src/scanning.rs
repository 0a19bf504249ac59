//! Reconstruction of a stem's bark from a point cloud, or from a mesh that is treated as one.

pub use greenstick_wood::scan::{ScanParameters, ScanRequest, ScannedReport, ScanningError};

use crate::Error;
use glam::{DAffine3, DVec3};
use greenstick_formats::CloudFile;
use greenstick_geometry::cloud::sample_meshes;
use greenstick_geometry::{Column, Context, Mesh, Node, PointCloud, Scene, Table, Values};
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

/// Returns points with what was measured at each as a table.
pub fn cleaned_table(cloud: &PointCloud) -> Table {
    let coordinates = |names: [&str; 3], meaning: &str, unit: &str, vectors: &[DVec3]| {
        let values = |k: usize| Values::F64(vectors.iter().map(|v| v[k]).collect());
        [0, 1, 2].map(|k| Column::new(names[k], unit, meaning, values(k)))
    };
    let mut columns =
        coordinates(["x", "y", "z"], "place in the world", "m", &cloud.points).to_vec();
    if !cloud.normals.is_empty() {
        columns.extend(coordinates(
            ["nx", "ny", "nz"],
            "normal",
            "",
            &cloud.normals,
        ));
    }
    if !cloud.colours.is_empty() {
        for (k, name) in ["red", "green", "blue"].into_iter().enumerate() {
            let values = Values::U8(cloud.colours.iter().map(|c| c[k]).collect());
            columns.push(Column::new(name, "", "colour, sRGB", values));
        }
    }
    Table {
        columns,
        ..Table::default()
    }
}

/// The error of a section's outline in a scan's cells, m: the points' noise over the root of their number in a cell that
/// was seen. `None` where the bark was not laid in cells.
pub fn outline_error(report: &ScannedReport) -> Option<f64> {
    let bark = report.bark.as_ref()?;
    let seen = bark.cells.iter().product::<usize>() as f64 * (1.0 - bark.completed);
    let points_per_cell = (bark.points as f64 / seen).max(1.0);
    let error = bark.noise_m / points_per_cell.sqrt();
    (seen > 0.0 && error.is_finite()).then_some(error)
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
