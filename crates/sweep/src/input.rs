//! Loading of inputs: meshes as they are, point clouds as the bark of the stem that they show.

use greenstick::fibre::scene::UpChoice;
use greenstick::files::{self, FileError};
use greenstick::formats::{Content, InputFormat, LengthUnit};
use greenstick::geometry::{Cancelled, Context, ErrorKind, PointCloud, Scene};
use greenstick::scanning::{ScanParameters, ScannedReport, cloud_from_scene, scan_to_scene};
use greenstick::wood::stem::StemLocation;
use greenstick::{BreakRequest, Broken, Error, RequestFile, built_in_branch};
use std::path::{Path, PathBuf};

/// The fraction of loading a cloud that reading its file takes.
const READING: f64 = 0.3;

/// Why an input cannot be loaded.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// A file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// No stem can be made of a scan.
    #[error("{}: {error}", path.display())]
    Scan {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        error: Box<Error>,
    },
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl InputError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            InputError::File(error) => error.kind(),
            InputError::Scan { error, .. } => error.kind(),
            InputError::Cancelled(_) => ErrorKind::Cancelled,
        }
    }
}

/// A loaded input.
#[derive(Debug, Clone)]
pub struct Input {
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

impl Input {
    /// A scene that is in memory already.
    pub fn of_scene(scene: Scene, place: StemLocation) -> Self {
        Input {
            scene,
            place,
            scan: None,
            cleaned: None,
            files: Vec::new(),
        }
    }

    /// Loads a mesh as it is, and a cloud as the bark of the stem at `place`.
    ///
    /// # Errors
    /// [`InputError`] where a file cannot be read, or a cloud shows no stem at the place.
    pub fn load(
        path: &Path,
        place: StemLocation,
        unit: Option<LengthUnit>,
        parameters: &ScanParameters,
        context: &Context,
    ) -> Result<Self, InputError> {
        context.report(0.0)?;
        let (content, files) = files::load_content(path, unit)?;
        let cloud = match content {
            Content::Mesh(scene) if !parameters.as_scan => {
                let input = Input::of_scene(scene, place);
                return Ok(Input { files, ..input });
            }
            Content::Mesh(scene) => cloud_from_scene(&scene),
            Content::Cloud(cloud) => cloud,
        };
        let request = parameters.request();
        let scanned = scan_to_scene(&cloud, &place, &request, &context.part(READING, 1.0));
        let scanned = scanned.map_err(|error| InputError::Scan {
            path: path.to_owned(),
            error: error.into(),
        })?;
        Ok(Input {
            scene: scanned.scene,
            place: scanned.location,
            scan: Some(scanned.report),
            cleaned: Some(scanned.cleaned),
            files,
        })
    }

    /// Loads the input of a request from `path`, or without one the branch that comes with the library.
    ///
    /// # Errors
    /// As [`Input::load`].
    pub fn of_request(
        file: &RequestFile,
        path: Option<&Path>,
        context: &Context,
    ) -> Result<Self, InputError> {
        let first = file.breaks.first().unwrap_or(&file.common);
        match path {
            Some(path) => Input::load(path, first.place, file.unit, &file.scan, context),
            None => {
                context.report(0.0)?;
                Ok(Input::of_scene(built_in_branch(), first.place))
            }
        }
    }

    /// Returns the request of a file, with places that are those of this input: a scan moves to its own origin.
    pub fn request(&self, file: &RequestFile) -> BreakRequest {
        let mut request = file.request();
        let origin = self.scan.as_ref().map_or([0.0; 3], |s| s.origin_m);
        for (number, one) in request.breaks.iter_mut().enumerate() {
            match &mut one.place {
                place if number == 0 => *place = self.place,
                StemLocation::Point(p) => {
                    (p.x, p.y, p.z) = (p.x - origin[0], p.y - origin[1], p.z - origin[2]);
                }
                _ => {}
            }
        }
        request
    }

    /// Notes in broken wood where it comes from: the request, the name of the input at `path`, and the scan.
    pub fn note_origin(&self, broken: &mut Broken, file: &RequestFile, path: Option<&Path>) {
        let name = path.and_then(Path::file_name);
        let name = name.map(|name| name.to_string_lossy().into_owned());
        let provenance = file.provenance(name.as_deref(), self.scan.as_ref());
        broken.scene.metadata = provenance.metadata();
        broken.report.scan = self.scan.clone();
    }
}

/// The axis that points up in a file, by its format.
pub fn up_axis(path: &Path) -> Option<UpChoice> {
    let format = InputFormat::from_path(path)?;
    Some(if format.is_z_up() {
        UpChoice::Z
    } else {
        UpChoice::Y
    })
}
