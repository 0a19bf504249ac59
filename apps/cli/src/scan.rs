//! Loading of inputs: meshes and point clouds.

use crate::failure::Failure;
use greenstick::files;
use greenstick::formats::{Content, LengthUnit};
use greenstick::geometry::{Context, PointCloud, Scene};
use greenstick::scanning::{ScanParameters, ScannedReport, cloud_from_scene, scan_to_scene};
use greenstick::wood::stem::StemLocation;
use std::path::{Path, PathBuf};

/// The fraction of loading a cloud that reading its file takes.
const READING: f64 = 0.3;

/// A loaded input.
pub struct Loaded {
    /// The meshes, or the bark of the scan.
    pub scene: Scene,
    /// The requested location, in that scene.
    pub place: StemLocation,
    /// The report on the scan, if the input was one.
    pub scan: Option<ScannedReport>,
    /// The points of the scan that were left after cleaning, if the input was one.
    pub cleaned: Option<PointCloud>,
    /// The files that were read.
    pub files: Vec<PathBuf>,
}

/// Loads a mesh as it is, and a cloud as the bark of the stem at `place`.
pub fn load(
    path: &Path,
    place: StemLocation,
    unit: Option<LengthUnit>,
    parameters: &ScanParameters,
    context: &Context,
) -> Result<Loaded, Failure> {
    context.report(0.0)?;
    let (content, files) = files::load_content(path, unit)?;
    let cloud = match content {
        Content::Mesh(scene) if !parameters.as_scan => {
            return Ok(Loaded {
                scene,
                place,
                scan: None,
                cleaned: None,
                files,
            });
        }
        Content::Mesh(scene) => cloud_from_scene(&scene),
        Content::Cloud(cloud) => cloud,
    };
    let request = parameters.request();
    let scanned = scan_to_scene(&cloud, &place, &request, &context.part(READING, 1.0))
        .map_err(|failure| Failure::from(failure).about(path))?;
    Ok(Loaded {
        scene: scanned.scene,
        place: scanned.location,
        scan: Some(scanned.report),
        cleaned: Some(scanned.cleaned),
        files,
    })
}
