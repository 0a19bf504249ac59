//! The file layer: mesh files with their companions in, several files out at once or not at all.
//!
//! This is the one place in the libraries that touches the file system; all stages work on scenes.

#[cfg(feature = "simulate")]
pub mod run;

use greenstick_formats::{
    CloudFormat, Content, Encoded, Format, FormatError, InputFormat, LengthUnit,
};
use greenstick_geometry::{ImageSource, Scene};
use std::cell::RefCell;
use std::fs;
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};

/// Why files could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// A file could not be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A name whose ending is that of no format.
    #[error("{}: {}; expected a name that ends in {}", path.display(), ending_of(path), expected)]
    UnknownEnding {
        /// The file.
        path: PathBuf,
        /// The endings that are known.
        expected: String,
    },
    /// The content is no sound mesh.
    #[error(transparent)]
    Content(FormatError),
    /// The scene does not fit the format.
    #[error(transparent)]
    Encoding(FormatError),
    /// A file could not be written; nothing was.
    #[error("{}: cannot be written: {source}; nothing was written", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Two outputs would be the same file, or one would replace a file that was read.
    #[error("{}: would overwrite {what}; choose another name for the output", path.display())]
    WouldOverwrite {
        /// The file.
        path: PathBuf,
        /// What it is already.
        what: &'static str,
    },
}

impl FileError {
    /// Whether other input or other names would help; otherwise the place failed.
    pub fn is_in_the_request(&self) -> bool {
        !matches!(self, FileError::Unwritable { .. } | FileError::Encoding(_))
    }
}

fn ending_of(path: &Path) -> String {
    match path.extension() {
        Some(ending) => format!("unknown ending .{}", ending.display()),
        None => "the name has no ending".to_owned(),
    }
}

/// Endings of mesh files, as messages list them.
pub fn mesh_endings() -> String {
    Format::ALL
        .map(|f| format!(".{}", f.extension()))
        .join(", ")
}

/// A scene and the files it was read from.
#[derive(Debug, Clone)]
pub struct Source {
    /// The scene.
    pub scene: Scene,
    /// The main file, then its companions, each once.
    pub files: Vec<PathBuf>,
}

/// A file that is to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Output {
    /// Where.
    pub path: PathBuf,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// Reads a mesh file. `unit` is what one unit of length in it stands for (see [`greenstick_formats::read`]).
///
/// # Errors
/// [`FileError`] where the file or a companion that it needs is not there or is no sound mesh.
pub fn read(path: &Path, unit: Option<LengthUnit>) -> Result<Scene, FileError> {
    load(path, unit).map(|source| source.scene)
}

/// As [`read`], with the names of all files that were read.
///
/// # Errors
/// As [`read`].
pub fn load(path: &Path, unit: Option<LengthUnit>) -> Result<Source, FileError> {
    let format = Format::from_path(path).ok_or_else(|| FileError::UnknownEnding {
        path: path.to_owned(),
        expected: mesh_endings(),
    });
    let (scene, files) = fetch(path, |bytes, name, resolve| {
        greenstick_formats::read(format?, bytes, name, unit, resolve).map_err(FileError::Content)
    })?;
    Ok(Source { scene, files })
}

/// As [`load`], of meshes and of point clouds.
///
/// # Errors
/// As [`read`].
pub fn load_content(
    path: &Path,
    unit: Option<LengthUnit>,
) -> Result<(Content, Vec<PathBuf>), FileError> {
    let clouds = CloudFormat::ALL.iter().flat_map(|f| f.extensions());
    let format = InputFormat::from_path(path).ok_or_else(|| FileError::UnknownEnding {
        path: path.to_owned(),
        expected: clouds.fold(mesh_endings(), |all, e| format!("{all}, .{e}")),
    });
    fetch(path, |bytes, name, resolve| {
        greenstick_formats::read_content(format?, bytes, name, unit, resolve)
            .map_err(FileError::Content)
    })
}

/// Hands the bytes of a file and the way to its companions to `read`; gives what that makes and all files it took.
fn fetch<T>(
    path: &Path,
    read: impl FnOnce(&[u8], &str, greenstick_formats::Resolve) -> Result<T, FileError>,
) -> Result<(T, Vec<PathBuf>), FileError> {
    let unreadable = |source| FileError::Unreadable {
        path: path.to_owned(),
        source,
    };
    let about = fs::metadata(path).map_err(unreadable)?;
    if about.is_dir() {
        return Err(unreadable(io::Error::other(
            "it is a folder, not a mesh file",
        )));
    }
    let bytes = fs::read(path).map_err(unreadable)?;
    let files = RefCell::new(vec![path.to_owned()]);
    let resolve = |reference: &str| {
        let companion = companion(path, reference)?;
        let bytes = fs::read(&companion)?;
        let mut files = files.borrow_mut();
        if !files.contains(&companion) {
            files.push(companion);
        }
        Ok(bytes)
    };
    let made = read(&bytes, &path.to_string_lossy(), &resolve)?;
    Ok((made, files.into_inner()))
}

/// The file that `main` refers to. References may leave the folder of `main` (`../textures/bark.png`) but must be
/// relative and name a plain file, so that a mesh file can make nobody read a device or a folder of the system.
fn companion(main: &Path, reference: &str) -> io::Result<PathBuf> {
    let refuse = |why: &str| io::Error::new(io::ErrorKind::InvalidInput, why.to_owned());
    // Files from Windows have backslashes; no sane name on other systems does.
    let reference = reference.replace('\\', "/");
    let relative = Path::new(&reference);
    let drive = reference.as_bytes().get(1) == Some(&b':');
    if reference.contains("://") || drive || relative.is_absolute() {
        return Err(refuse("only references relative to the file are followed"));
    }
    if relative.components().all(|c| c == Component::CurDir) {
        return Err(refuse("the reference names no file"));
    }
    let path = main.parent().unwrap_or(Path::new("")).join(relative);
    if !fs::metadata(&path)?.is_file() {
        return Err(refuse("it is not a plain file"));
    }
    Ok(path)
}

/// Makes references to images hold when the scene, read from `source`, is written to `target`: where the folder is
/// another one, images that exist are taken into the scene. A note names each that does not exist and stays a reference.
pub fn carry_images(scene: &mut Scene, source: &Path, target: &Path) {
    let folder = |path: &Path| fs::canonicalize(folder_of(path)).ok();
    let same = folder(source).is_some() && folder(source) == folder(target);
    for image in &mut scene.images {
        let ImageSource::Reference(reference) = &image.source else {
            continue;
        };
        if reference.is_empty() || reference.starts_with("data:") {
            continue;
        }
        let found = companion(source, &percent_decoded(reference))
            .or_else(|_| companion(source, reference));
        match found.and_then(|path| if same { Ok(Vec::new()) } else { fs::read(path) }) {
            Ok(_) if same => {}
            Ok(bytes) => {
                if let Some(mime_type) = mime_type(&bytes) {
                    image.mime_type = mime_type.to_owned();
                    if image.name.is_empty() {
                        let name = Path::new(reference).file_stem().unwrap_or_default();
                        image.name = name.to_string_lossy().into_owned();
                    }
                    image.source = ImageSource::Bytes(bytes);
                }
            }
            Err(error) => {
                let note = format!("texture {reference} is kept as a reference: {error}");
                if !scene.notes.contains(&note) {
                    scene.notes.push(note);
                }
            }
        }
    }
}

/// `bark 1.png` of `bark%201.png`.
fn percent_decoded(uri: &str) -> String {
    let bytes = uri.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while i < bytes.len() {
        let code = (bytes[i] == b'%')
            .then(|| uri.get(i + 1..i + 3))
            .flatten()
            .and_then(|hex| u8::from_str_radix(hex, 16).ok());
        decoded.push(code.unwrap_or(bytes[i]));
        i += if code.is_some() { 3 } else { 1 };
    }
    String::from_utf8(decoded).unwrap_or_else(|_| uri.to_owned())
}

/// Media type of an image that glTF knows.
fn mime_type(bytes: &[u8]) -> Option<&'static str> {
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        Some("image/png")
    } else if bytes.starts_with(b"\xff\xd8\xff") {
        Some("image/jpeg")
    } else {
        None
    }
}

/// The scene as files: the one at `path`, in the format of its ending, then its companions beside it.
///
/// # Errors
/// [`FileError`] where the ending is unknown or the scene does not fit the format.
pub fn encode(scene: &Scene, path: &Path, unit: LengthUnit) -> Result<Vec<Output>, FileError> {
    let unknown = || FileError::UnknownEnding {
        path: path.to_owned(),
        expected: mesh_endings(),
    };
    let format = Format::from_path(path).ok_or_else(unknown)?;
    let name = path.file_name().ok_or_else(unknown)?.to_string_lossy();
    let encoded = greenstick_formats::write(format, scene, &name, unit);
    let place = |(i, Encoded { name, bytes }): (usize, Encoded)| Output {
        path: if i == 0 {
            path.to_owned()
        } else {
            path.with_file_name(name)
        },
        bytes,
    };
    Ok(encoded
        .map_err(FileError::Encoding)?
        .into_iter()
        .enumerate()
        .map(place)
        .collect())
}

/// Checks that a file could be written at `path`, without leaving anything there: for programs that would rather know
/// before they work than after.
///
/// # Errors
/// [`FileError::Unwritable`] where not.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    let staged = Staged::new(path, &[])?;
    drop(staged);
    Ok(())
}

/// Refuses outputs that are the same file as one that was read, or as each other.
///
/// # Errors
/// [`FileError::WouldOverwrite`].
pub fn check_distinct(outputs: &[&Path], inputs: &[PathBuf]) -> Result<(), FileError> {
    let real = |path: &Path| match (fs::canonicalize(path), path.file_name()) {
        (Ok(path), _) => path,
        (Err(_), Some(name)) => {
            fs::canonicalize(folder_of(path)).map_or_else(|_| path.to_owned(), |f| f.join(name))
        }
        (Err(_), None) => path.to_owned(),
    };
    let read: Vec<PathBuf> = inputs.iter().map(|p| real(p)).collect();
    let mut taken = Vec::new();
    for path in outputs {
        let this = real(path);
        let refuse = |what| FileError::WouldOverwrite {
            path: path.to_path_buf(),
            what,
        };
        if read.contains(&this) {
            return Err(refuse("an input file"));
        }
        if taken.contains(&this) {
            return Err(refuse("another output"));
        }
        taken.push(this);
    }
    Ok(())
}

/// Writes all files or none: each beside its place first, and only when all are there they take their names, companions
/// before the main file. No reader sees half a file, and what was there before is put back where a step fails.
///
/// # Errors
/// [`FileError::Unwritable`] with the file that failed.
pub fn write_all(outputs: &[Output]) -> Result<(), FileError> {
    let mut batch = Batch::default();
    outputs.iter().try_for_each(|output| batch.add(output))?;
    batch.finish()
}

/// Writes one file as `write` makes it, beside its place first. Where `write` fails nothing is left of it.
///
/// # Errors
/// Those of `write`, and [`FileError::Unwritable`].
pub fn write_streamed<T, E: From<FileError>>(
    path: &Path,
    write: impl FnOnce(&mut io::BufWriter<fs::File>) -> Result<T, E>,
) -> Result<T, E> {
    let mut batch = Batch::default();
    let written = batch.stream(path, write)?;
    batch.finish()?;
    Ok(written)
}

/// Files that are written one after the other beside their places, and take their names together at the end. Where that
/// is not reached nothing is left of them.
#[derive(Default)]
pub struct Batch(Vec<Staged>);

impl Batch {
    /// Writes a file.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn add(&mut self, output: &Output) -> Result<(), FileError> {
        self.0.push(Staged::new(&output.path, &output.bytes)?);
        Ok(())
    }

    /// Writes a file as `write` makes it.
    ///
    /// # Errors
    /// Those of `write`, and [`FileError::Unwritable`].
    pub fn stream<T, E: From<FileError>>(
        &mut self,
        path: &Path,
        write: impl FnOnce(&mut io::BufWriter<fs::File>) -> Result<T, E>,
    ) -> Result<T, E> {
        let (staged, file) = Staged::begin(path)?;
        let mut file = io::BufWriter::new(file);
        let written = write(&mut file)?;
        file.flush().map_err(|source| FileError::Unwritable {
            path: path.to_owned(),
            source,
        })?;
        self.0.push(staged);
        Ok(written)
    }

    /// Gives all files their names, those that came last first. What was there before is put back where a step fails.
    ///
    /// # Errors
    /// [`FileError::Unwritable`] with the file that failed.
    pub fn finish(mut self) -> Result<(), FileError> {
        for i in (0..self.0.len()).rev() {
            if let Err(error) = self.0[i].take_place() {
                self.0.iter_mut().for_each(Staged::undo);
                return Err(error);
            }
        }
        self.0.iter_mut().for_each(Staged::keep);
        Ok(())
    }
}

/// Checks that a file `name` could be written into a folder, which need not be there yet.
///
/// # Errors
/// [`FileError::Unwritable`] where not.
pub fn check_folder(folder: &Path, name: &str) -> Result<(), FileError> {
    let mut there = folder;
    while !there.exists() {
        there = match there.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        };
    }
    check_writable(&there.join(name))
}

/// Writes all files into a folder or none; makes the folder where it is not there, and takes it away again where a file
/// cannot be written.
///
/// # Errors
/// [`FileError::Unwritable`] with what failed.
pub fn write_folder(folder: &Path, files: Vec<Encoded>) -> Result<Vec<Output>, FileError> {
    let made = !folder.exists();
    fs::create_dir_all(folder).map_err(|source| FileError::Unwritable {
        path: folder.to_owned(),
        source,
    })?;
    let outputs: Vec<Output> = files
        .into_iter()
        .map(|Encoded { name, bytes }| Output {
            path: folder.join(name),
            bytes,
        })
        .collect();
    match write_all(&outputs) {
        Ok(()) => Ok(outputs),
        Err(error) => {
            if made {
                // Only an empty folder goes.
                let _ = fs::remove_dir(folder);
            }
            Err(error)
        }
    }
}

/// A file beside its place. Dropping it removes what lies beside.
struct Staged {
    place: PathBuf,
    beside: Option<PathBuf>,
    /// A second name of the file that was at the place before.
    before: Option<PathBuf>,
    placed: bool,
}

impl Staged {
    fn new(place: &Path, bytes: &[u8]) -> Result<Self, FileError> {
        let (staged, mut file) = Staged::begin(place)?;
        file.write_all(bytes)
            .and_then(|()| file.flush())
            .map_err(|source| FileError::Unwritable {
                path: place.to_owned(),
                source,
            })?;
        Ok(staged)
    }

    /// An empty file beside a place.
    fn begin(place: &Path) -> Result<(Self, fs::File), FileError> {
        let unwritable = |source| FileError::Unwritable {
            path: place.to_owned(),
            source,
        };
        if place.is_dir() {
            return Err(unwritable(io::Error::other("a folder has this name")));
        }
        if place.file_name().is_none() {
            return Err(unwritable(io::Error::other("it names no file")));
        }
        if !folder_of(place).is_dir() {
            let missing = format!("there is no folder {}", folder_of(place).display());
            return Err(unwritable(io::Error::new(io::ErrorKind::NotFound, missing)));
        }
        let (beside, file) =
            free_name(place, |path| fs::File::create_new(path)).map_err(unwritable)?;
        let staged = Staged {
            place: place.to_owned(),
            beside: Some(beside),
            before: None,
            placed: false,
        };
        Ok((staged, file))
    }

    fn take_place(&mut self) -> Result<(), FileError> {
        let Some(beside) = &self.beside else {
            return Ok(());
        };
        if self.place.exists() {
            // File systems without second names go without the way back.
            let kept = free_name(&self.place, |path| fs::hard_link(&self.place, path));
            self.before = kept.ok().map(|(path, ())| path);
        }
        fs::rename(beside, &self.place).map_err(|source| FileError::Unwritable {
            path: self.place.clone(),
            source,
        })?;
        (self.beside, self.placed) = (None, true);
        Ok(())
    }

    /// Puts things back as they were. What cannot be put back stays as it is: there is nobody left to tell.
    fn undo(&mut self) {
        match self.before.take() {
            Some(before) if self.placed => drop(fs::rename(before, &self.place)),
            Some(before) => drop(fs::remove_file(before)),
            None if self.placed => drop(fs::remove_file(&self.place)),
            None => {}
        }
        self.placed = false;
    }

    fn keep(&mut self) {
        if let Some(before) = self.before.take() {
            drop(fs::remove_file(before));
        }
    }
}

impl Drop for Staged {
    fn drop(&mut self) {
        if let Some(beside) = self.beside.take() {
            drop(fs::remove_file(beside));
        }
        if let Some(before) = self.before.take() {
            drop(fs::remove_file(before));
        }
    }
}

/// Tries names beside `place` until `make` finds one free.
fn free_name<T>(place: &Path, make: impl Fn(&Path) -> io::Result<T>) -> io::Result<(PathBuf, T)> {
    const TRIES: u32 = 100;
    let name = place.file_name().unwrap_or_default().to_string_lossy();
    let process = std::process::id();
    let mut last = io::Error::other("no free name");
    for i in 0..TRIES {
        let path = place.with_file_name(format!(".{name}.{process}-{i}.part"));
        match make(&path) {
            Ok(made) => return Ok((path, made)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => last = error,
            Err(error) => return Err(error),
        }
    }
    Err(last)
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests;
