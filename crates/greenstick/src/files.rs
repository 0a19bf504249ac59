//! Reading and writing of files: mesh files with their companions in, several files out together or not at all.
//!
//! This is the only module of the libraries that accesses the file system; all stages work on scenes.

#[cfg(feature = "simulate")]
pub mod run;

use greenstick_formats::{
    CloudFormat, Content, Encoded, Format, FormatError, InputFormat, LengthUnit,
};
use greenstick_geometry::{ErrorKind, ImageSource, Scene};
use std::cell::RefCell;
use std::fs;
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};

/// Why files cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// A file cannot be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The ending of a name is that of no format.
    #[error("{}: {}; expected a name that ends in {}", path.display(), ending_of(path), expected)]
    UnknownEnding {
        /// The file.
        path: PathBuf,
        /// The known endings.
        expected: String,
    },
    /// The content is invalid.
    #[error(transparent)]
    Content(FormatError),
    /// The format cannot represent the scene.
    #[error(transparent)]
    Encoding(FormatError),
    /// A file cannot be written; no other file was written either.
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
        /// What the file already is.
        what: &'static str,
    },
}

impl FileError {
    /// Returns the kind of the error: [`ErrorKind::Request`] if other input or other names would help.
    pub fn kind(&self) -> ErrorKind {
        match self {
            FileError::Unwritable { .. } | FileError::Encoding(_) => ErrorKind::Work,
            _ => ErrorKind::Request,
        }
    }
}

fn ending_of(path: &Path) -> String {
    match path.extension() {
        Some(ending) => format!("unknown ending .{}", ending.display()),
        None => "the name has no ending".to_owned(),
    }
}

/// Lists the endings of mesh files for messages.
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
    /// Its path.
    pub path: PathBuf,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// Reads a mesh file. `unit` is the unit of length in it (see [`greenstick_formats::read`]).
///
/// # Errors
/// [`FileError`] if the file or a companion that it needs does not exist or is invalid.
pub fn read(path: &Path, unit: Option<LengthUnit>) -> Result<Scene, FileError> {
    load(path, unit).map(|source| source.scene)
}

/// Reads a mesh file as [`read`] does, and lists all files that were read.
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

/// Reads a file with a mesh or a point cloud, and lists all files that were read.
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

/// Calls `read` with the bytes of a file and a function that reads its companions. Returns the result and all files read.
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

/// Returns the file that `main` refers to. References may leave the folder of `main` (`../textures/bark.png`) but must be
/// relative and name a regular file, so that no mesh file causes a device or a system folder to be read.
fn companion(main: &Path, reference: &str) -> io::Result<PathBuf> {
    let refuse = |why: &str| io::Error::new(io::ErrorKind::InvalidInput, why.to_owned());
    // Files from Windows have backslashes, which names on other systems hardly ever have.
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

/// Keeps references to images valid when the scene, read from `source`, is written to `target`: if the folders differ,
/// images that exist are embedded in the scene. Images that do not exist stay references, and a note names each.
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
                let note = format!("texture {reference} remains a reference: {error}");
                if !scene.notes.contains(&note) {
                    scene.notes.push(note);
                }
            }
        }
    }
}

/// Decodes percent-encoded bytes: `bark%201.png` is `bark 1.png`.
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

/// Returns the media type of an image, if glTF supports it.
fn mime_type(bytes: &[u8]) -> Option<&'static str> {
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        Some("image/png")
    } else if bytes.starts_with(b"\xff\xd8\xff") {
        Some("image/jpeg")
    } else {
        None
    }
}

/// Encodes a scene as files: the one at `path`, in the format of its ending, then its companions in the same folder.
///
/// # Errors
/// [`FileError`] if the ending is unknown or the format cannot represent the scene.
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

/// Checks that a file can be written at `path`, without leaving anything there, so that a program can fail before its
/// work instead of after it.
///
/// # Errors
/// [`FileError::Unwritable`] if not.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    let staged = Staged::new(path, &[])?;
    drop(staged);
    Ok(())
}

/// Checks that no output is the same file as an input or another output.
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

/// Writes all files or none: each under a temporary name in its folder first; when all are complete they are renamed,
/// companions before the main file. No reader sees half a file, and earlier files are restored if a step fails.
///
/// # Errors
/// [`FileError::Unwritable`] with the file that failed.
pub fn write_all(outputs: &[Output]) -> Result<(), FileError> {
    let mut batch = Batch::default();
    outputs.iter().try_for_each(|output| batch.add(output))?;
    batch.finish()
}

/// Writes one file in a stream, under a temporary name first. If `write` fails, nothing is left of it.
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

/// Files that are written one after the other under temporary names and renamed together at the end. If the batch is
/// dropped unfinished, nothing is left of them.
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

    /// Writes a file in a stream.
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

    /// Renames all files, the last one first. Earlier files are restored if a step fails.
    ///
    /// # Errors
    /// [`FileError::Unwritable`] with the file that failed.
    pub fn finish(mut self) -> Result<(), FileError> {
        for i in (0..self.0.len()).rev() {
            if let Err(error) = self.0[i].rename() {
                self.0.iter_mut().for_each(Staged::undo);
                return Err(error);
            }
        }
        self.0.iter_mut().for_each(Staged::commit);
        Ok(())
    }
}

/// Checks that a file `name` can be written into a folder, which need not exist yet.
///
/// # Errors
/// [`FileError::Unwritable`] if not.
pub fn check_folder(folder: &Path, name: &str) -> Result<(), FileError> {
    let mut existing = folder;
    while !existing.exists() {
        existing = match existing.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        };
    }
    check_writable(&existing.join(name))
}

/// Writes all files into a folder or none. The folder is created if it does not exist, and then removed again if a file
/// cannot be written.
///
/// # Errors
/// [`FileError::Unwritable`] with what failed.
pub fn write_folder(folder: &Path, files: Vec<Encoded>) -> Result<Vec<Output>, FileError> {
    let is_new = !folder.exists();
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
            if is_new {
                // Fails unless the folder is empty.
                let _ = fs::remove_dir(folder);
            }
            Err(error)
        }
    }
}

/// A file under a temporary name. Dropping it removes the temporary file and the backup.
struct Staged {
    target: PathBuf,
    temporary: Option<PathBuf>,
    /// A second name of the file that the target was before.
    backup: Option<PathBuf>,
    renamed: bool,
}

impl Staged {
    fn new(target: &Path, bytes: &[u8]) -> Result<Self, FileError> {
        let (staged, mut file) = Staged::begin(target)?;
        file.write_all(bytes)
            .and_then(|()| file.flush())
            .map_err(|source| FileError::Unwritable {
                path: target.to_owned(),
                source,
            })?;
        Ok(staged)
    }

    /// Creates an empty temporary file for a target.
    fn begin(target: &Path) -> Result<(Self, fs::File), FileError> {
        let unwritable = |source| FileError::Unwritable {
            path: target.to_owned(),
            source,
        };
        if target.is_dir() {
            return Err(unwritable(io::Error::other("a folder has this name")));
        }
        if target.file_name().is_none() {
            return Err(unwritable(io::Error::other("it names no file")));
        }
        if !folder_of(target).is_dir() {
            let missing = format!("there is no folder {}", folder_of(target).display());
            return Err(unwritable(io::Error::new(io::ErrorKind::NotFound, missing)));
        }
        let (temporary, file) =
            free_name(target, |path| fs::File::create_new(path)).map_err(unwritable)?;
        let staged = Staged {
            target: target.to_owned(),
            temporary: Some(temporary),
            backup: None,
            renamed: false,
        };
        Ok((staged, file))
    }

    fn rename(&mut self) -> Result<(), FileError> {
        let Some(temporary) = &self.temporary else {
            return Ok(());
        };
        if self.target.exists() {
            // Without hard links in the file system there is no backup.
            let backup = free_name(&self.target, |path| fs::hard_link(&self.target, path));
            self.backup = backup.ok().map(|(path, ())| path);
        }
        fs::rename(temporary, &self.target).map_err(|source| FileError::Unwritable {
            path: self.target.clone(),
            source,
        })?;
        (self.temporary, self.renamed) = (None, true);
        Ok(())
    }

    /// Restores what was there before, as far as possible.
    fn undo(&mut self) {
        match self.backup.take() {
            Some(backup) if self.renamed => drop(fs::rename(backup, &self.target)),
            Some(backup) => drop(fs::remove_file(backup)),
            None if self.renamed => drop(fs::remove_file(&self.target)),
            None => {}
        }
        self.renamed = false;
    }

    /// Removes the backup of the file that was replaced.
    fn commit(&mut self) {
        if let Some(backup) = self.backup.take() {
            drop(fs::remove_file(backup));
        }
    }
}

impl Drop for Staged {
    fn drop(&mut self) {
        if let Some(temporary) = self.temporary.take() {
            drop(fs::remove_file(temporary));
        }
        if let Some(backup) = self.backup.take() {
            drop(fs::remove_file(backup));
        }
    }
}

/// Tries temporary names in the folder of `target` until `make` succeeds with one.
fn free_name<T>(target: &Path, make: impl Fn(&Path) -> io::Result<T>) -> io::Result<(PathBuf, T)> {
    const TRIES: u32 = 100;
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    let process = std::process::id();
    let mut last = io::Error::other("no free name");
    for i in 0..TRIES {
        let path = target.with_file_name(format!(".{name}.{process}-{i}.part"));
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
