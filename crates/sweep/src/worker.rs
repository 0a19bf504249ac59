//! Making variants, one after the other: breaks here, the others in `trials`.

use crate::error::SweepError;
use crate::figures::{BreakFigures, Figures};
use crate::input::Input;
use crate::journal::Record;
use crate::making::{CELL, CELL_SAMPLES, Trouble};
use crate::plan::{PieceFormat, Sweep};
use crate::trials::{Simulator, bend_figures};
use crate::variant::Variant;
use greenstick::files::{self, FileError, Output};
use greenstick::formats::{LengthUnit, OutputFormat};
use greenstick::geometry::{Cancelled, Context};
use greenstick::scanning::ScanParameters;
use greenstick::wood::stem::StemLocation;
use greenstick::{BreakSession, Broken, RequestFile, picture_of_break};
use std::fs;
use std::path::{Path, PathBuf};

/// The folder of the pieces in that of a sweep.
const VARIANTS: &str = "variants";
/// The folder of the small pictures in that of a sweep.
const SHEET: &str = "sheet";
/// Variants whose files are in one folder: file systems and people are slow with many more.
const IN_FOLDER: u64 = 1000;
/// The name of the pieces of a variant, relative to the folder of the sweep; `None` where none are written.
pub fn piece_file(sweep: &Sweep, number: u64) -> Option<String> {
    let ending = match sweep.settings.piece_format() {
        PieceFormat::None => return None,
        format => format.word(),
    };
    let folder = number / IN_FOLDER;
    Some(format!("{VARIANTS}/{folder:04}/{number:07}.{ending}"))
}

/// The name of the small picture of a variant, relative to the folder of the sweep.
pub fn cell_file(number: u64) -> String {
    format!("{SHEET}/{number:07}.png")
}

/// Removes what a process that was killed left in the folder of a sweep: files that were not renamed yet. The journal must be
/// open, so that no other process writes there.
pub fn remove_leftovers(folder: &Path) {
    let entries = |folder: &Path| fs::read_dir(folder).into_iter().flatten().flatten();
    let mut folders = vec![folder.to_owned(), folder.join(SHEET)];
    folders.extend(entries(&folder.join(VARIANTS)).map(|entry| entry.path()));
    for entry in folders.iter().flat_map(|folder| entries(folder)) {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with('.') && name.ends_with(".part") {
            // One that stays is only litter.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// What decides how an input is loaded.
#[derive(Debug, Clone, PartialEq)]
struct Loading {
    path: Option<PathBuf>,
    unit: Option<LengthUnit>,
    scan: ScanParameters,
    /// The first place, which scans are made about.
    place: StemLocation,
}

/// An input and the session that breaks it.
#[derive(Debug)]
struct Loaded {
    loading: Loading,
    input: Input,
    session: BreakSession,
}

/// Makes variants of a sweep. It keeps the stages of the last one; what it makes does not depend on that. Each thread has its
/// own.
#[derive(Debug)]
pub struct Worker<'a> {
    sweep: &'a Sweep,
    folder: &'a Path,
    loaded: Option<Loaded>,
    simulator: Simulator,
}

impl<'a> Worker<'a> {
    /// A worker that writes into the folder of a sweep.
    pub fn new(sweep: &'a Sweep, folder: &'a Path) -> Self {
        Worker {
            sweep,
            folder,
            loaded: None,
            simulator: Simulator::default(),
        }
    }

    /// Makes a variant and writes its files. The time in the record is left to the caller. A variant that cannot be made has a
    /// record that says why.
    ///
    /// # Errors
    /// [`SweepError`] where the sweep cannot go on: a file cannot be written, or the caller cancelled.
    pub fn make(&mut self, number: u64, context: &Context) -> Result<Record, SweepError> {
        let made = match self.sweep.variant(number)? {
            Ok(Variant::Break(_)) if self.stays_whole(number) => Ok(None),
            Ok(Variant::Break(file)) => self.broken_wood(number, &file, context).map(Some),
            Ok(Variant::Scene(scene)) => {
                let (shown, file) = (self.sweep.is_shown(number), piece_file(self.sweep, number));
                let target = file.map(|file| self.folder.join(file));
                let made =
                    self.simulator
                        .run(self.sweep, *scene, (target.as_deref(), shown), context);
                made.and_then(|made| {
                    let mut outputs = made.pieces;
                    outputs.extend(made.cell.map(|bytes| self.cell_output(number, bytes)));
                    self.write(&outputs, context)?;
                    Ok(Some(Figures::Run(made.figures)))
                })
            }
            Ok(Variant::Bend(file)) => {
                let figures = bend_figures(&file, context);
                figures.map(|figures| Some(Figures::Bend(figures)))
            }
            Err(error) => Err(Trouble::Variant(error)),
        };
        let (figures, error) = match made {
            Ok(figures) => (figures, None),
            Err(Trouble::Variant(error)) => (None, Some(error)),
            Err(Trouble::Stop(error)) => return Err(error),
        };
        let file = piece_file(self.sweep, number).filter(|_| figures.is_some());
        Ok(Record {
            variant: number,
            seconds: 0.0,
            file,
            figures,
            error,
        })
    }

    /// Whether a variant is a tree that is not to break.
    fn stays_whole(&self, number: u64) -> bool {
        let tree = (self.sweep.forest()).map(|forest| &forest.trees()[number as usize]);
        tree.is_some_and(|tree| !tree.breaks)
    }

    /// The small picture of a variant as a file.
    fn cell_output(&self, number: u64, bytes: Vec<u8>) -> Output {
        let path = self.folder.join(cell_file(number));
        Output { path, bytes }
    }

    /// Writes files, and the folders that they are in.
    fn write(&self, outputs: &[Output], context: &Context) -> Result<(), Trouble> {
        context.check()?;
        for output in outputs {
            make_folder_of(&output.path)?;
        }
        Ok(files::write_all(outputs)?)
    }

    fn broken_wood(
        &mut self,
        number: u64,
        file: &RequestFile,
        context: &Context,
    ) -> Result<Figures, Trouble> {
        let name = piece_file(self.sweep, number);
        let target = name.map(|name| self.folder.join(name));
        let broken = match self.sweep.forest() {
            Some(forest) => {
                let (tree, textures) = (
                    &forest.trees()[number as usize],
                    self.sweep.settings.bakes_textures(),
                );
                forest.broken(tree, (file, textures), context)?
            }
            None => self.broken(file, target.as_deref(), context)?,
        };
        let mut outputs = Vec::new();
        if let Some(target) = &target {
            make_folder_of(target)?;
            let unit = file.unit.unwrap_or_default();
            outputs.extend(files::encode(&broken.scene, target, unit)?);
        }
        if self.sweep.is_shown(number)
            && let Some(bytes) = cell(&broken, file, context)?
        {
            outputs.push(self.cell_output(number, bytes));
        }
        self.write(&outputs, context)?;
        Ok(Figures::Break(BreakFigures::from(&broken.report)))
    }

    /// Breaks the input of a request, which is loaded where it is not that of the last one.
    fn broken(
        &mut self,
        file: &RequestFile,
        target: Option<&Path>,
        context: &Context,
    ) -> Result<Broken, Trouble> {
        let path = file.input.as_ref().map(|name| self.sweep.folder.join(name));
        let first = file.breaks.first().unwrap_or(&file.common).place;
        let mut loading = Loading {
            path: path.clone(),
            unit: file.unit,
            scan: file.scan.clone(),
            place: first,
        };
        if let Some(last) = &self.loaded
            && last.input.scan.is_none()
            && !file.scan.as_scan
        {
            // Meshes are the same wherever they are broken.
            loading.place = last.loading.place;
        }
        let mut loaded = match self.loaded.take() {
            Some(last) if last.loading == loading => last,
            _ => {
                let mut input = Input::of_request(file, path.as_deref(), context)?;
                if let (Some(path), Some(target)) = (&path, target) {
                    files::carry_images(&mut input.scene, path, target);
                }
                let session = BreakSession::new(std::mem::take(&mut input.scene));
                Loaded {
                    loading,
                    input,
                    session,
                }
            }
        };
        if loaded.input.scan.is_none() {
            loaded.input.place = first;
        }
        let mut request = loaded.input.request(file);
        request.texture_width = match self.sweep.settings.bakes_textures() {
            true => OutputFormat::texture_width(target, request.texture_width),
            false => 0,
        };
        let broken = loaded.session.broken(&request, context);
        let mut broken = match broken {
            Ok(broken) => broken,
            Err(error) => {
                self.loaded = Some(loaded);
                return Err(error.into());
            }
        };
        loaded.input.note_origin(&mut broken, file, path.as_deref());
        self.loaded = Some(loaded);
        Ok(broken)
    }
}

/// Creates the folder of a file.
fn make_folder_of(path: &Path) -> Result<(), Trouble> {
    let folder = path.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder).map_err(|source| {
        let path = folder.to_owned();
        Trouble::Stop(FileError::Unwritable { path, source }.into())
    })
}

/// The small picture of a break as PNG; `None` where none can be taken.
fn cell(
    broken: &Broken,
    file: &RequestFile,
    context: &Context,
) -> Result<Option<Vec<u8>>, Cancelled> {
    let mut options = file.picture.options();
    [options.width, options.height] = CELL;
    options.samples = CELL_SAMPLES;
    let picture = picture_of_break(broken, &options, context);
    context.check()?;
    Ok(picture.ok().map(|picture| picture.png()))
}
