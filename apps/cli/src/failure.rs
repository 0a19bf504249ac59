//! Messages of errors, with a hint and an exit code: 1 if the work failed, 2 if the request was wrong, 130 if the user
//! stopped the program.

use greenstick::ErrorKind;
use greenstick::files::FileError;
use greenstick::film::FilmError;
use greenstick::formats::{FormatError, RefusedReference};
use greenstick::fracture::cracks::CrackError;
use greenstick::geometry::Cancelled;
use greenstick::geometry::text::{one_line, printable};
use greenstick::picture::PictureError;
use greenstick::scanning::ScanningError;
use greenstick::schema::{ParameterError, closest_names};
use greenstick::simulate::{RunError, SimulateError};
use greenstick::skin::film;
use greenstick::wood::anatomy::AnatomyError;
use greenstick::wood::scan::ScanError;
use greenstick::wood::stem::{StemError, StemLocation};
use greenstick_sweep::shown::ShowError;
use greenstick_sweep::{InputError, SweepError};
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;

/// What helps where lengths are absurd.
const UNIT_HINT: &str = "--unit mm, cm or m says what a file without units means";

/// Why the program ends without having done its work.
#[derive(Debug)]
pub struct Failure {
    kind: ErrorKind,
    message: String,
    hint: Option<String>,
}

impl Failure {
    /// A failure of a kind. If the user stopped the work, `error` is not printed.
    pub fn new(kind: ErrorKind, error: impl ToString) -> Self {
        let message = match kind {
            ErrorKind::Cancelled => "stopped; nothing was written".to_owned(),
            ErrorKind::Request | ErrorKind::Work => error.to_string(),
        };
        Failure {
            kind,
            message,
            hint: None,
        }
    }

    /// The request is wrong: something in it must change.
    pub fn request(message: impl ToString) -> Self {
        Failure::new(ErrorKind::Request, message)
    }

    /// The request is valid, but the work failed.
    pub fn work(message: impl ToString) -> Self {
        Failure::new(ErrorKind::Work, message)
    }

    /// The user stopped the work.
    pub fn cancelled(message: impl ToString) -> Self {
        Failure {
            kind: ErrorKind::Cancelled,
            message: message.to_string(),
            hint: None,
        }
    }

    /// Replaces the message if the user stopped the work.
    pub fn or_cancelled(self, message: impl ToString) -> Self {
        match self.kind {
            ErrorKind::Cancelled => Failure::cancelled(message),
            ErrorKind::Request | ErrorKind::Work => self,
        }
    }

    /// A wrong parameter, named by the option that set it.
    pub fn parameter(option: &str, error: &ParameterError) -> Self {
        let text = error.to_string();
        let message = match (error, error.key()) {
            (ParameterError::Format { problem, .. }, _) => format!("{option}: {problem}"),
            (_, Some(key)) if text.starts_with(key) => format!("{option}{}", &text[key.len()..]),
            _ => format!("{option}: {text}"),
        };
        Failure::request(message).hint(parameter_hint(error))
    }

    /// Puts the name of a file before the message.
    pub fn about(self, file: &std::path::Path) -> Self {
        Failure {
            message: format!("{}: {}", file.display(), self.message),
            ..self
        }
    }

    /// Puts the name of a file before the message unless it is there.
    pub fn about_once(self, file: &std::path::Path) -> Self {
        if self.message.contains(&file.display().to_string()) {
            self
        } else {
            self.about(file)
        }
    }

    /// Adds a hint at what to do next.
    pub fn hint(self, hint: impl ToString) -> Self {
        Failure {
            hint: Some(hint.to_string()),
            ..self
        }
    }

    /// The kind of the failure.
    pub fn kind(&self) -> ErrorKind {
        self.kind
    }

    /// What went wrong.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// Prints the failure and returns its exit code.
    pub fn report(self) -> ExitCode {
        self.print();
        ExitCode::from(exit_code(self.kind))
    }

    /// Prints the failure.
    pub fn print(&self) {
        let mut errors = std::io::stderr().lock();
        let colored = errors.is_terminal() && std::env::var_os("NO_COLOR").is_none();
        let head = match (self.kind, colored) {
            (ErrorKind::Cancelled, _) => "",
            (_, true) => "\x1b[1;31merror:\x1b[0m ",
            (_, false) => "error: ",
        };
        let hint = self.hint.as_ref();
        let hint = hint.map_or(String::new(), |h| format!("\n  hint: {}", one_line(h)));
        // Further lines are set back: none passes for a message of its own.
        let message = printable(&self.message).replace('\n', "\n  ");
        // If stderr is closed, nobody reads the message.
        let _ = writeln!(errors, "{head}{message}{hint}");
    }
}

/// The exit code of a kind of error.
fn exit_code(kind: ErrorKind) -> u8 {
    match kind {
        ErrorKind::Work => 1,
        ErrorKind::Request => 2,
        ErrorKind::Cancelled => 130,
    }
}

impl From<Cancelled> for Failure {
    fn from(cancelled: Cancelled) -> Self {
        Failure::new(ErrorKind::Cancelled, cancelled)
    }
}

/// Converts errors of the library: the kind decides the exit code, and a function may add a hint.
macro_rules! from_errors {
    ($($error:ty => $hint:expr),* $(,)?) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                let hint: fn(&$error) -> Option<String> = $hint;
                Failure {
                    hint: hint(&error),
                    ..Failure::new(error.kind(), &error)
                }
            }
        })*
    };
}

from_errors! {
    greenstick::Error => break_hint,
    FileError => file_hint,
    PictureError => |_| None,
    FilmError => film_hint,
    SimulateError => simulate_hint,
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        match error {
            InputError::File(error) => error.into(),
            InputError::Scan { path, error } => Failure::from(*error).about(&path),
            InputError::Cancelled(cancelled) => cancelled.into(),
        }
    }
}

impl From<ShowError> for Failure {
    fn from(error: ShowError) -> Self {
        match error {
            ShowError::Film(error) => error.into(),
            ShowError::Faces(error) => error.into(),
            ShowError::Cancelled(cancelled) => cancelled.into(),
        }
    }
}

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        let resume = "the same command goes on with what is missing";
        let full = match &error {
            SweepError::File(FileError::Unwritable { source, .. })
            | SweepError::Io { source, .. } => room_hint(source),
            _ => None,
        };
        if let Some(room) = full {
            return Failure::work(error).hint(format!("{room}; then {resume}"));
        }
        match error {
            SweepError::File(error) => error.into(),
            SweepError::Another { .. } => {
                Failure::request(error).hint("-o names another folder for this one")
            }
            other => Failure::new(other.kind(), other),
        }
    }
}

impl From<film::FilmError> for Failure {
    fn from(error: film::FilmError) -> Self {
        FilmError::from(error).into()
    }
}

/// What helps where a file could not be written because there is no room for it.
pub fn room_hint(error: &std::io::Error) -> Option<&'static str> {
    use std::io::ErrorKind::{FileTooLarge, QuotaExceeded, StorageFull};
    match error.kind() {
        StorageFull | QuotaExceeded => Some("make room on the disk"),
        FileTooLarge => Some("let files be larger (`ulimit -f`)"),
        _ => None,
    }
}

fn file_hint(error: &FileError) -> Option<String> {
    match error {
        FileError::Unwritable { source, .. } => Some(match room_hint(source) {
            Some(room) => format!("{room}, or name another place with -o"),
            None => "name another place with -o or --picture, or create the folder".to_owned(),
        }),
        FileError::Unreadable { path, source } => {
            let inner = source.get_ref().and_then(|e| e.downcast_ref());
            if inner == Some(&RefusedReference::Outside) {
                return Some(
                    "--allow-outside lets a scene name files outside of its folder".to_owned(),
                );
            }
            let similar = similar_file(path).map(|name| format!("there is a file {name}"));
            match source.kind() {
                std::io::ErrorKind::NotFound => similar.or_else(|| looked_for(path)),
                _ => similar,
            }
        }
        FileError::Content(FormatError::Truncated { .. } | FormatError::Empty { .. }) => {
            Some("export or download the file again".to_owned())
        }
        _ => None,
    }
}

fn film_hint(error: &FilmError) -> Option<String> {
    let hint = match error {
        FilmError::File(error) => return file_hint(error),
        FilmError::Work(error) => return break_hint(error),
        FilmError::Simulate(SimulateError::NoInput) => {
            "name the mesh of the run behind its folder: greenstick skin run pole.ply -o film.glb"
        }
        FilmError::Skin(film::FilmError::Run(RunError::NoRun { .. })) => {
            "greenstick simulate SCENE -o FOLDER makes one"
        }
        FilmError::Skin(film::FilmError::NoFrames { .. }) => {
            "the command that simulated it, with --resume, continues the run"
        }
        _ => return None,
    };
    Some(hint.to_owned())
}

fn simulate_hint(error: &SimulateError) -> Option<String> {
    match error {
        SimulateError::Run(RunError::Unwritable { .. }) => {
            Some("name another place with -o, or create the folder".to_owned())
        }
        SimulateError::Length { .. } => Some(UNIT_HINT.to_owned()),
        _ => None,
    }
}

fn break_hint(error: &greenstick::Error) -> Option<String> {
    use greenstick::Error;
    let point = "a point of the limb works on any mesh: --at x,y,z in metres";
    let hint = match error {
        Error::Stem(
            StemError::OffStem { nearest, .. }
            | StemError::Unusable { nearest, .. }
            | StemError::FarFromWood { nearest, .. },
        ) => format!("try --at {}", option_text(nearest)),
        Error::Stem(StemError::Extent { .. }) => UNIT_HINT.to_owned(),
        Error::Stem(StemError::Open { .. }) => {
            "--as-scan lays the bark over what there is and completes the rest".to_owned()
        }
        Error::Stem(StemError::NoStem { .. }) => {
            format!("{point}; `greenstick check FILE` lists holes and other faults")
        }
        Error::Stem(StemError::NowhereFree { .. })
        | Error::Anatomy(AnatomyError::TooLong { .. }) => point.to_owned(),
        Error::Scan(error) => scan_hint(error)?.to_owned(),
        Error::Cut { .. } => "`greenstick check FILE` lists where a mesh is open or not a manifold; another --at may work"
            .to_owned(),
        Error::Crack(CrackError::TooShort { .. }) => {
            "another --at breaks farther from that end; --set crack_groups.end=break cracks the break itself".to_owned()
        }
        _ => return None,
    };
    Some(hint)
}

fn scan_hint(error: &ScanningError) -> Option<&'static str> {
    match error {
        ScanningError::Scan(ScanError::LowCoverage { .. }) => {
            Some("another --at may work, or a smaller --least-cover")
        }
        ScanningError::Scan(ScanError::NotStarShaped { .. }) => {
            Some("another --at, where every ray from the pith meets the bark once")
        }
        ScanningError::Scan(ScanError::NoStem { .. }) => {
            Some("--at x,y,z in the file's coordinates names the stem")
        }
        ScanningError::Scan(ScanError::Extent { .. }) => Some(UNIT_HINT),
        ScanningError::Scan(_) => None,
        ScanningError::Clean(_) => {
            Some("--no-outliers, --no-isolated and --no-duplicates skip steps of the cleaning")
        }
    }
}

/// Returns where the right values are listed.
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

/// Finds a file with a similar name in the folder of one that does not exist.
fn similar_file(path: &Path) -> Option<String> {
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

/// Says where a file that does not exist was looked for.
fn looked_for(path: &Path) -> Option<String> {
    let whole = std::path::absolute(path).ok()?;
    let folder = whole.parent()?;
    let problem = match folder.is_dir() {
        true => "it was looked for in",
        false => "there is no folder",
    };
    let folder = folder.display();
    Some(format!("{problem} {folder}; name it by its whole path"))
}

/// Formats a location so that it can be typed, whatever the unit of the file.
fn option_text(location: &StemLocation) -> String {
    match location {
        StemLocation::Point(p) => format!("{:.4}m,{:.4}m,{:.4}m", p.x, p.y, p.z),
        other => other.to_string(),
    }
}

/// Prints to stdout, with what a terminal would obey escaped. It is no failure if the reader has closed the pipe (`| head`).
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out
        .write_all(printable(text).as_bytes())
        .and_then(|()| out.flush())
    {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::work(format!("cannot print to stdout: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints what the reader of arguments says: help and versions to stdout, errors to stderr. Errors repeat arguments, in which
/// what a terminal would obey, or what would pass for a line of ours, is escaped.
pub fn print_usage(message: &clap::Error) -> std::io::Result<()> {
    let arguments = std::env::args_os().map(|argument| argument.to_string_lossy().into_owned());
    match escaped_usage(&message.render().to_string(), arguments) {
        Some(text) if message.use_stderr() => std::io::stderr().write_all(text.as_bytes()),
        _ => message.print(),
    }
}

/// The text of a message with the arguments in it escaped; none where none of them needs it.
fn escaped_usage(text: &str, arguments: impl Iterator<Item = String>) -> Option<String> {
    let mut escaped = None;
    for argument in arguments {
        // Of `--option=value`, messages repeat the value alone.
        let value = argument.split_once('=').map(|(_, value)| value);
        for part in [Some(argument.as_str()), value].into_iter().flatten() {
            let shown = one_line(part);
            if shown != part {
                let before: &str = escaped.as_deref().unwrap_or(text);
                escaped = Some(before.replace(part, &shown));
            }
        }
    }
    escaped.map(|text: String| printable(&text).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    #[test]
    fn what_there_is_no_room_for_has_a_hint_at_room() {
        use std::io::{Error, ErrorKind};
        let hint = |source: Error| {
            let path = PathBuf::from("wood.glb");
            let failure = Failure::from(FileError::Unwritable { path, source });
            assert_eq!(exit_code(failure.kind()), 1);
            failure.hint.unwrap()
        };
        let disk = "make room on the disk, or name another place with -o";
        assert_eq!(hint(ErrorKind::StorageFull.into()), disk);
        assert_eq!(hint(ErrorKind::QuotaExceeded.into()), disk);
        assert!(hint(ErrorKind::FileTooLarge.into()).starts_with("let files be larger"));
        assert!(hint(ErrorKind::PermissionDenied.into()).contains("create the folder"));
        // A device that is always full, where there is one.
        if let Ok(mut full) = std::fs::OpenOptions::new().write(true).open("/dev/full") {
            assert_eq!(hint(full.write_all(b"wood").unwrap_err()), disk);
        }
        let sweep = |source: Error| {
            let path = PathBuf::from("journal");
            Failure::from(SweepError::File(FileError::Unwritable { path, source })).hint
        };
        let full = sweep(ErrorKind::StorageFull.into()).unwrap();
        assert!(
            full.contains("make room") && full.contains("goes on"),
            "{full}"
        );
        let other = sweep(ErrorKind::PermissionDenied.into()).unwrap();
        assert!(!other.contains("room"), "{other}");
    }

    #[test]
    fn a_file_that_is_nowhere_has_a_hint_at_where_it_was_looked_for() {
        let hint = |path: &Path| {
            let source = std::io::ErrorKind::NotFound.into();
            let path = path.to_owned();
            Failure::from(FileError::Unreadable { path, source })
                .hint
                .unwrap()
        };
        let folder = std::env::temp_dir();
        let there = hint(&folder.join("no file of such a name is here.glb"));
        let whole = "; name it by its whole path";
        assert!(there.starts_with("it was looked for in") && there.ends_with(whole));
        let nowhere = hint(&folder.join("no folder of such a name/wood.glb"));
        assert!(nowhere.starts_with("there is no folder") && nowhere.ends_with(whole));
    }

    #[test]
    fn usage_errors_escape_arguments() {
        let words = [
            "greenstick",
            "break",
            "--at=0.4\nerror: \u{1b}[31mowned",
            "--plain",
        ];
        let arguments = words.map(str::to_owned).into_iter();
        let text = "error: invalid value '0.4\nerror: \u{1b}[31mowned' for '--at <PLACE>'\n";
        let shown = escaped_usage(text, arguments).unwrap();
        assert_eq!(
            shown,
            "error: invalid value '0.4\\nerror: \\u{1b}[31mowned' for '--at <PLACE>'\n"
        );
        let plain = ["greenstick", "--at=0.4"].map(str::to_owned).into_iter();
        assert_eq!(escaped_usage("error: invalid", plain), None);
    }
}
