//! What can go wrong, in words and as an exit code: 1 where the work failed, 2 where the request was wrong, 130 where
//! the user stopped it.

use greenstick::files::FileError;
use greenstick::film::FilmError;
use greenstick::formats::FormatError;
use greenstick::fracture::cracks::CrackError;
use greenstick::geometry::Cancelled;
use greenstick::picture::PictureError;
use greenstick::scanning::ScanningError;
use greenstick::schema::{ParameterError, closest_names};
use greenstick::simulate::{RunError, SimulateError};
use greenstick::skin::film;
use greenstick::skin::texture::TextureError;
use greenstick::wood::anatomy::AnatomyError;
use greenstick::wood::scan::ScanError;
use greenstick::wood::stem::{StemError, StemLocation};
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;

/// Code of work that the user stopped.
const STOPPED: u8 = 130;

/// Why the program ends without having done its work.
#[derive(Debug)]
pub struct Failure {
    code: u8,
    message: String,
    hint: Option<String>,
}

impl Failure {
    /// Something in the request must be changed.
    pub fn request(message: impl ToString) -> Self {
        Failure {
            code: 2,
            message: message.to_string(),
            hint: None,
        }
    }

    /// The request was right, but the work could not be done.
    pub fn work(message: impl ToString) -> Self {
        Failure {
            code: 1,
            ..Failure::request(message)
        }
    }

    /// The user stopped the work.
    pub fn stopped(message: impl ToString) -> Self {
        Failure {
            code: STOPPED,
            ..Failure::request(message)
        }
    }

    /// Where the user stopped the work, says so in other words.
    pub fn or_stopped(self, message: impl ToString) -> Self {
        if self.code == STOPPED {
            Failure::stopped(message)
        } else {
            self
        }
    }

    /// A parameter that is wrong, by the option that gave it.
    pub fn parameter(option: &str, error: &ParameterError) -> Self {
        let text = error.to_string();
        let message = match (error, error.key()) {
            (ParameterError::Format { problem, .. }, _) => format!("{option}: {problem}"),
            (_, Some(key)) if text.starts_with(key) => format!("{option}{}", &text[key.len()..]),
            _ => format!("{option}: {text}"),
        };
        Failure::request(message).hint(parameter_hint(error))
    }

    /// Names the file that it is about.
    pub fn about(self, file: &std::path::Path) -> Self {
        Failure {
            message: format!("{}: {}", file.display(), self.message),
            ..self
        }
    }

    /// Adds what to do next.
    pub fn hint(self, hint: impl ToString) -> Self {
        Failure {
            hint: Some(hint.to_string()),
            ..self
        }
    }

    /// Prints the failure; returns its exit code.
    pub fn tell(self) -> ExitCode {
        let mut errors = std::io::stderr().lock();
        let colored = errors.is_terminal() && std::env::var_os("NO_COLOR").is_none();
        let head = match (self.code, colored) {
            (STOPPED, _) => "",
            (_, true) => "\x1b[1;31merror:\x1b[0m ",
            (_, false) => "error: ",
        };
        let hint = self
            .hint
            .map_or(String::new(), |h| format!("\n  hint: {h}"));
        // With stderr closed there is nobody to tell.
        let _ = writeln!(errors, "{head}{}{hint}", self.message);
        ExitCode::from(self.code)
    }
}

impl From<Cancelled> for Failure {
    fn from(_: Cancelled) -> Self {
        Failure {
            code: STOPPED,
            message: "stopped; nothing was written".to_owned(),
            hint: None,
        }
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        let failure = if error.is_in_the_request() {
            Failure::request(&error)
        } else {
            Failure::work(&error)
        };
        match error {
            FileError::Unwritable { .. } => {
                failure.hint("name another place with -o or --picture, or create the folder")
            }
            FileError::Unreadable { path, .. } => match near(&path) {
                Some(name) => failure.hint(format!("there is a file {name}")),
                None => failure,
            },
            FileError::Content(FormatError::Truncated { .. } | FormatError::Empty { .. }) => {
                failure.hint("export or download the file again")
            }
            _ => failure,
        }
    }
}

impl From<greenstick::Error> for Failure {
    fn from(error: greenstick::Error) -> Self {
        use greenstick::Error;
        let point = "a point of the limb works on any mesh: --at x,y,z in metres";
        match &error {
            Error::Cancelled(_)
            | Error::Stem(StemError::Cancelled(_))
            | Error::Texture(TextureError::Cancelled(_)) => Cancelled.into(),
            Error::Stem(
                StemError::OffStem { nearest, .. }
                | StemError::Unusable { nearest, .. }
                | StemError::FarFromWood { nearest, .. },
            ) => Failure::request(&error).hint(format!("try --at {}", typed(nearest))),
            Error::Anatomy(AnatomyError::TooLong { .. }) => Failure::work(&error).hint(point),
            Error::Stem(StemError::Empty | StemError::Invalid { .. })
            | Error::Species(_)
            | Error::Amount(_)
            | Error::Anatomy(
                AnatomyError::Resolution(_)
                | AnatomyError::BoardErosion
                | AnatomyError::InnerCircle(_)
                | AnatomyError::TooManyParticles(_),
            ) => {
                Failure::request(&error)
            }
            Error::Stem(StemError::NoStem { .. }) => Failure::work(&error).hint(format!(
                "{point}; `greenstick check FILE` lists holes and other faults"
            )),
            Error::Stem(StemError::NowhereFree { .. }) => Failure::work(&error).hint(point),
            Error::Scan(error) => scan_failure(error),
            Error::Cut { .. } => Failure::work(&error).hint(
                "`greenstick check FILE` lists where a mesh is open or not a manifold; another --at may do",
            ),
            Error::Crack(CrackError::TooShort { .. }) => Failure::work(&error)
                .hint("a smaller --at breaks nearer to the base; --set crack_groups.end=break cracks the break itself"),
            _ => Failure::work(&error),
        }
    }
}

impl From<FilmError> for Failure {
    fn from(error: FilmError) -> Self {
        match error {
            FilmError::Cancelled(cancelled) => cancelled.into(),
            FilmError::File(error) => error.into(),
            FilmError::Write(_) => Failure::work(error),
            FilmError::Work(error) => error.into(),
            FilmError::Simulate(SimulateError::NoInput) => {
                Failure::request("the run was of a mesh, and it is not known which")
                    .hint("name it behind the folder: greenstick skin run pole.ply -o film.glb")
            }
            FilmError::Skin(film::FilmError::Run(RunError::NoRun { .. })) => {
                Failure::request(error).hint("greenstick simulate SCENE -o FOLDER makes one")
            }
            FilmError::Skin(film::FilmError::NoFrames { .. }) => Failure::request(error)
                .hint("the command that simulated it, with --resume, goes on with the run"),
            _ => Failure::request(error),
        }
    }
}

impl From<film::FilmError> for Failure {
    fn from(error: film::FilmError) -> Self {
        FilmError::from(error).into()
    }
}

fn scan_failure(error: &ScanningError) -> Failure {
    use greenstick::geometry::cloud::CleanError;
    use greenstick::scanning::ScanningError as Why;
    match error {
        Why::Scan(ScanError::Cancelled(c)) | Why::Clean(CleanError::Cancelled(c)) => (*c).into(),
        Why::Scan(ScanError::LowCoverage { .. }) => {
            Failure::work(error).hint("another --at may do, or a smaller --least-cover")
        }
        Why::Scan(ScanError::NotStarShaped { .. }) => Failure::work(error)
            .hint("another --at, where every ray from the pith meets the bark once"),
        Why::Scan(ScanError::NoStem { .. }) => {
            Failure::work(error).hint("--at x,y,z in the file's coordinates names the stem")
        }
        Why::Scan(_) => Failure::request(error),
        Why::Clean(_) => Failure::request(error).hint(
            "--no-outliers, --no-isolated and --no-duplicates leave steps of the cleaning out",
        ),
    }
}

impl From<PictureError> for Failure {
    fn from(error: PictureError) -> Self {
        match error {
            PictureError::Cancelled(cancelled) => cancelled.into(),
            PictureError::Size { .. } | PictureError::Samples { .. } | PictureError::View(_) => {
                Failure::request(error)
            }
            _ => Failure::work(error),
        }
    }
}

/// Where what is right can be looked up.
pub fn parameter_hint(error: &ParameterError) -> &'static str {
    match error {
        ParameterError::Format { key, .. } if key.ends_with("species") => {
            "`greenstick species` lists them"
        }
        ParameterError::OutOfRange { key, .. } if key.ends_with("moisture") => {
            "12 is air-dry, 30 and more is green"
        }
        ParameterError::NotANumber { required: true, .. } => "such as 3cm, 12mm or 0.1m",
        _ => "`--help` says what each option takes",
    }
}

/// A file in the folder of one that is not there, with nearly its name.
fn near(path: &Path) -> Option<String> {
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .ok()?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .collect();
    names.sort();
    let wanted = path.file_name()?.to_string_lossy();
    let near = closest_names(&wanted, names.iter().map(String::as_str));
    let found = near.into_iter().find(|name| *name != wanted)?;
    Some(path.with_file_name(found).display().to_string())
}

/// A place as it can be typed whatever the unit of the file.
fn typed(place: &StemLocation) -> String {
    match place {
        StemLocation::Point(p) => format!("{:.4}m,{:.4}m,{:.4}m", p.x, p.y, p.z),
        other => other.to_string(),
    }
}

/// Prints to stdout. A reader that has gone away (`| head`) is no failure.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::work(format!("cannot print to stdout: {error}")))
        }
        _ => Ok(()),
    }
}
