//! Point clouds as input: the arguments about them, which several commands share, and the way from a file to a scene.

use crate::failure::Failure;
use crate::values;
use clap::Args;
use greenstick::files;
use greenstick::formats::{Content, LengthUnit};
use greenstick::geometry::cloud::CleanOptions;
use greenstick::geometry::{Context, Scene};
use greenstick::scanning::{ScanRequest, ScannedReport, cloud_from_scene, scan_to_scene};
use greenstick::wood::scan::ScanOptions;
use greenstick::wood::stem::StemLocation;
use std::path::{Path, PathBuf};
use std::sync::Once;

/// The part of loading a cloud that reading its file takes.
const READ: f64 = 0.3;

const HEADING: &str = "Point clouds";

/// What may be asked of a scan.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = HEADING)]
pub struct ScanArguments {
    /// Treat a mesh as a scan, too: its bark is made anew and its holes are closed
    #[arg(long)]
    pub as_scan: bool,
    /// Keep points farther from their neighbours than the others are from theirs
    #[arg(long, conflicts_with = "outliers")]
    pub no_outliers: bool,
    /// Drop points whose mean distance to their neighbours exceeds the cloud's by so many standard deviations
    /// [default: 3]
    #[arg(long, value_name = "NUMBER", value_parser = values::positive)]
    pub outliers: Option<f64>,
    /// Keep points without others near them
    #[arg(long, conflicts_with = "isolated")]
    pub no_isolated: bool,
    /// Drop points without two others within so many spacings of the cloud [default: 8]
    #[arg(long, value_name = "NUMBER", value_parser = values::positive)]
    pub isolated: Option<f64>,
    /// Keep several points at one place
    #[arg(long)]
    pub no_duplicates: bool,
    /// Refuse points whose coordinates are not finite instead of dropping them
    #[arg(long)]
    pub all_finite: bool,
    /// Thin the cloud to this spacing, such as 5mm
    #[arg(long, value_name = "DISTANCE", value_parser = values::distance)]
    pub spacing: Option<f64>,
    /// Cut off the points of a fracture surface and keep the bark
    #[arg(long)]
    pub bark_only: bool,
    /// Share of the girth that must have been seen, 0 to 1, along the metre of the place and those kept beside it
    /// [default: 0.3]
    #[arg(long, value_name = "SHARE", value_parser = values::amount)]
    pub least_cover: Option<f64>,
}

impl ScanArguments {
    /// The request that these arguments make.
    pub fn request(&self) -> ScanRequest {
        let usual = CleanOptions::default();
        let choice = |left_out: bool, given: Option<f64>, usual: Option<f64>| {
            given.or(usual).filter(|_| !left_out)
        };
        let scan = ScanOptions::default();
        ScanRequest {
            clean: CleanOptions {
                not_finite: !self.all_finite,
                duplicates: !self.no_duplicates,
                outliers: choice(self.no_outliers, self.outliers, usual.outliers),
                isolated: choice(self.no_isolated, self.isolated, usual.isolated),
                spacing: self.spacing.filter(|s| *s > 0.0),
            },
            scan: ScanOptions {
                bark_only: self.bark_only,
                min_coverage: self.least_cover.unwrap_or(scan.min_coverage),
                ..scan
            },
        }
    }
}

/// What an input file gave.
pub struct Loaded {
    /// The meshes, or the bark of the scan.
    pub scene: Scene,
    /// The place asked for, in that scene.
    pub place: StemLocation,
    /// What was made of the scan, where it was one.
    pub scan: Option<ScannedReport>,
    /// The files that were read.
    pub files: Vec<PathBuf>,
}

/// Reads a mesh as it is and a cloud as the bark of the stem at `place`.
pub fn load(
    path: &Path,
    place: StemLocation,
    unit: Option<LengthUnit>,
    arguments: &ScanArguments,
    context: &Context,
) -> Result<Loaded, Failure> {
    context.report(0.0)?;
    keep_decompressor_quiet();
    let (content, files) = files::load_content(path, unit)?;
    let cloud = match content {
        Content::Mesh(scene) if !arguments.as_scan => {
            return Ok(Loaded {
                scene,
                place,
                scan: None,
                files,
            });
        }
        Content::Mesh(scene) => cloud_from_scene(&scene),
        Content::Cloud(cloud) => cloud,
    };
    let request = arguments.request();
    let scanned = scan_to_scene(&cloud, &place, &request, &context.part(READ, 1.0))
        .map_err(|failure| Failure::from(failure).about(path))?;
    Ok(Loaded {
        scene: scanned.scene,
        place: scanned.location,
        scan: Some(scanned.report),
        files,
    })
}

/// Keeps panics of the LAZ decompressor off the screen: the reader catches them and says that the file is damaged.
fn keep_decompressor_quiet() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let usual = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            let theirs =
                |place: &std::panic::Location| place.file().replace('\\', "/").contains("/laz-");
            if !panic.location().is_some_and(theirs) {
                usual(panic);
            }
        }));
    });
}
