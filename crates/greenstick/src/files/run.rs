//! Runs in folders: `scene.toml`, `energy.csv`, `events.csv`, `forces.csv`, `frames.gsf`, `checkpoint.bin`, `origin.json` and
//! `csv-metadata.json`.
//!
//! Tables and frames are only appended to. The checkpoint, which is written beside its place and renamed, says how long they
//! were when it was made.

use super::{FileError, Output};
use greenstick_fibre::Event;
use greenstick_fibre::scene::Scene;
use greenstick_fibre::store::{
    CHECKPOINT_FILE, Checkpoint, EnergyRow, ForceRow, Frame, FrameTimes, IndexedFrames, Progress,
    Record, RecordLengths, RunError, RunSink, RunSource, SCENE_FILE, StoreError, event_line,
    parse_energies, parse_events, parse_forces,
};
use greenstick_formats::{CSVW_FILE, DescribedTable, LengthUnit, Reach, write_csv_metadata};
use greenstick_geometry::{Metadata, Provenance};
use serde::{Deserialize, Serialize};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

const ORIGIN_FILE: &str = "origin.json";
/// Locked while a program records the run.
const LOCK_FILE: &str = "run.lock";
/// The bark of the scan that the run is of, where it is of one.
const SCAN_FILE: &str = "scan.glb";
/// The columns of a run's tables that hold texts.
const TEXT_COLUMNS: [&str; 3] = ["kind", "cause", "holder"];

/// Where the files of a run came from, so that what is made of the run later finds them again.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    /// The mesh that the run is of, where it is of one; relative to the run's folder.
    pub input: Option<PathBuf>,
    /// Unit of length in the mesh, `mm`, `cm` or `m`, where one was named.
    pub unit: Option<String>,
    /// The folder that files of bodies are relative to.
    pub beside: PathBuf,
}

impl Origin {
    /// Returns the origin of a run on the mesh file `input`, with its unit, and with files of bodies relative to `beside`. Its
    /// paths are absolute.
    pub fn new(input: Option<(&Path, Option<LengthUnit>)>, beside: &Path) -> Self {
        let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let is_here = beside.as_os_str().is_empty();
        let beside = if is_here { Path::new(".") } else { beside };
        Origin {
            input: input.map(|(path, _)| absolute(path)),
            unit: input.and_then(|(_, unit)| unit).map(|u| u.to_string()),
            beside: absolute(beside),
        }
    }

    /// Reads the origin of the run in `folder`; an empty one where the folder has none.
    ///
    /// # Errors
    /// [`FileError::Unreadable`] where it is there and cannot be read.
    pub fn read(folder: &Path) -> Result<Self, FileError> {
        let path = folder.join(ORIGIN_FILE);
        if !path.exists() {
            return Ok(Origin::default());
        }
        let unreadable = FileError::unreadable(&path);
        let text = fs::read_to_string(&path).map_err(&unreadable)?;
        let mut origin: Origin = serde_json::from_str(&text).map_err(|e| unreadable(e.into()))?;
        origin.input = origin.input.map(|input| folder.join(input));
        Ok(origin)
    }

    /// Returns the mesh file and its unit.
    pub fn input_file(&self) -> Option<(PathBuf, Option<LengthUnit>)> {
        let unit = || self.unit.as_deref()?.parse().ok();
        Some((self.input.clone()?, unit()))
    }
}

/// Reads the mesh of each body of a scene that names a file, relative to the folder `beside` and no farther than `reach`.
///
/// # Errors
/// [`FileError`] for files that are missing or are no sound meshes.
pub fn read_body_meshes(
    scene: &Scene,
    beside: &Path,
    reach: Reach,
) -> Result<Vec<Option<greenstick_geometry::Scene>>, FileError> {
    let read = |file: &String| match file.as_str() {
        "" => Ok(None),
        file => {
            let named = super::whole::named_file(beside, file, reach);
            let path = named.map_err(FileError::unreadable(&beside.join(file)))?;
            super::read(&path, None).map(Some)
        }
    };
    scene.body.iter().map(|body| read(&body.file)).collect()
}

/// A file that only grows.
struct GrowingFile {
    path: PathBuf,
    file: BufWriter<File>,
    length: u64,
}

impl GrowingFile {
    /// Opens a file for appending, cut to `length`.
    fn open(path: PathBuf, length: u64) -> Result<Self, RunError> {
        let fail = |source| unwritable(&path, source);
        let file = OpenOptions::new().create(true).append(true).open(&path);
        let file = file.map_err(fail)?;
        let found = file.metadata().map_err(fail)?.len();
        if found < length {
            return Err(RunError::Short {
                location: path.display().to_string(),
                unit: "bytes",
                found,
                expected: length,
            });
        }
        file.set_len(length).map_err(fail)?;
        Ok(GrowingFile {
            file: BufWriter::new(file),
            path,
            length,
        })
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), RunError> {
        self.length += bytes.len() as u64;
        let written = self.file.write_all(bytes);
        written.map_err(|source| unwritable(&self.path, source))
    }

    /// Flushes the file. Returns its length.
    fn flush(&mut self) -> Result<u64, RunError> {
        let flushed = self.file.flush();
        flushed.map_err(|source| unwritable(&self.path, source))?;
        Ok(self.length)
    }
}

/// The growing files of a run, in the order of [`Record::ALL`].
struct Records(Vec<GrowingFile>);

impl Records {
    fn open(folder: &Path, lengths: &RecordLengths) -> Result<Self, RunError> {
        let open =
            |record: Record| GrowingFile::open(folder.join(record.file_name()), lengths.of(record));
        let files: Result<_, RunError> = Record::ALL.into_iter().map(open).collect();
        files.map(Records)
    }

    fn write(&mut self, record: Record, bytes: &[u8]) -> Result<(), RunError> {
        self.0[record as usize].write(bytes)
    }

    fn flush(&mut self) -> Result<RecordLengths, RunError> {
        let mut flush = |record: Record| self.0[record as usize].flush();
        Ok(RecordLengths {
            energies: flush(Record::Energies)?,
            events: flush(Record::Events)?,
            frames: flush(Record::Frames)?,
            forces: flush(Record::Forces)?,
        })
    }
}

/// The frames of a run, whose file is open.
type OpenFrames = IndexedFrames<BufReader<File>>;

/// A run in a folder.
pub struct RunFolder {
    path: PathBuf,
    origin: Origin,
    /// Where the run comes from.
    metadata: Metadata,
    /// The bark of the scan that it is of, as a GLB file.
    scan: Option<Vec<u8>>,
    /// Open while the run is recorded.
    records: Option<Records>,
    /// Held while the run is recorded; the system lets go of it when the program ends, however it does.
    lock: Option<File>,
    /// Open while frames are read.
    frames: Mutex<Option<OpenFrames>>,
}

impl RunFolder {
    /// Returns the run in the folder `path`. Nothing is read or written yet. A run that begins there notes its `origin`.
    pub fn new(path: impl Into<PathBuf>, origin: Origin) -> Self {
        RunFolder {
            path: path.into(),
            origin,
            metadata: Metadata::default(),
            scan: None,
            records: None,
            lock: None,
            frames: Mutex::new(None),
        }
    }

    /// Returns the same folder; a run that begins there says in its scene and beside its tables where it comes from.
    #[must_use]
    pub fn made_by(mut self, provenance: &Provenance) -> Self {
        self.metadata = provenance.metadata();
        self
    }

    /// Returns the same folder; a run that begins there is of the bark of a scan, a GLB file, which is written into it.
    #[must_use]
    pub fn of_scan(mut self, bark: Vec<u8>) -> Self {
        (self.origin.input, self.origin.unit) = (Some(SCAN_FILE.into()), None);
        self.scan = Some(bark);
        self
    }

    /// Returns the scene as it is written, after comments that say where it comes from.
    fn scene_text(&self, scene: &Scene) -> String {
        let lines = self.metadata.lines().map(|line| format!("# {line}\n"));
        lines.chain([scene.to_toml()]).collect()
    }

    /// Returns the units of all tables and where they come from.
    fn table_metadata(&self) -> Vec<u8> {
        let tables = [Record::Energies, Record::Events, Record::Forces].map(|record| {
            let header = record.header();
            let heading = String::from_utf8_lossy(&header);
            DescribedTable::from_heading(&heading, &TEXT_COLUMNS, record.file_name())
        });
        write_csv_metadata(&tables, &self.metadata).bytes
    }

    /// Returns the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Makes sure that no other program writes into the folder.
    fn hold(&mut self) -> Result<(), RunError> {
        if self.lock.is_some() {
            return Ok(());
        }
        fs::create_dir_all(&self.path).map_err(|source| unwritable(&self.path, source))?;
        let path = self.path.join(LOCK_FILE);
        let lock = File::create(&path).map_err(|source| unwritable(&path, source))?;
        match lock.try_lock() {
            Err(TryLockError::WouldBlock) => {
                let location = self.name();
                return Err(RunError::Busy { location });
            }
            // Some file systems have no locks.
            Ok(()) | Err(TryLockError::Error(_)) => self.lock = Some(lock),
        }
        Ok(())
    }

    fn records(&mut self) -> Result<&mut Records, RunError> {
        let name = self.name();
        self.records.as_mut().ok_or(RunError::NoRun {
            location: name,
            problem: "the run has neither begun nor been resumed".into(),
        })
    }

    fn write(&mut self, record: Record, bytes: &[u8]) -> Result<(), RunError> {
        self.records()?.write(record, bytes)
    }

    fn forget_frames(&mut self) {
        *self
            .frames
            .get_mut()
            .unwrap_or_else(PoisonError::into_inner) = None;
    }

    fn read_text(&self, record: Record) -> Result<String, RunError> {
        let path = self.path.join(record.file_name());
        fs::read_to_string(&path).map_err(|source| RunError::Unreadable {
            location: path.display().to_string(),
            source,
        })
    }

    /// Hands the open frames to `read`.
    fn with_frames<T>(
        &self,
        read: impl FnOnce(&mut OpenFrames) -> Result<T, StoreError>,
    ) -> Result<T, RunError> {
        let path = self.path.join(Record::Frames.file_name());
        let open = || IndexedFrames::open(BufReader::new(File::open(&path)?));
        let mut frames = self.frames.lock().unwrap_or_else(PoisonError::into_inner);
        let result = match &mut *frames {
            Some(frames) => read(frames),
            none => open().and_then(|frames| read(none.insert(frames))),
        };
        result.map_err(|error| RunError::Store {
            location: path.display().to_string(),
            error,
        })
    }
}

impl RunSink for RunFolder {
    fn begin(&mut self, scene: &Scene) -> Result<(), RunError> {
        self.hold()?;
        // Paths and words always fit.
        let origin = serde_json::to_vec_pretty(&self.origin).unwrap_or_default();
        let outputs = [
            (SCENE_FILE, self.scene_text(scene).into_bytes()),
            (ORIGIN_FILE, origin),
            (CSVW_FILE, self.table_metadata()),
        ];
        let scan = self.scan.take().map(|bark| (SCAN_FILE, bark));
        let outputs = outputs.into_iter().chain(scan).map(|(name, bytes)| Output {
            path: self.path.join(name),
            bytes,
        });
        super::write_all(&outputs.collect::<Vec<_>>()).map_err(not_written)?;
        self.forget_frames();
        let mut records = Records::open(&self.path, &RecordLengths::default())?;
        for record in Record::ALL {
            records.write(record, &record.header())?;
        }
        self.records = Some(records);
        Ok(())
    }

    fn resume(&mut self, progress: &Progress) -> Result<(), RunError> {
        self.hold()?;
        self.forget_frames();
        self.records = Some(Records::open(&self.path, &progress.lengths)?);
        Ok(())
    }

    fn energy(&mut self, row: &EnergyRow) -> Result<(), RunError> {
        self.write(Record::Energies, row.line().as_bytes())
    }

    fn event(&mut self, event: &Event) -> Result<(), RunError> {
        self.write(Record::Events, event_line(event).as_bytes())
    }

    fn force(&mut self, row: &ForceRow) -> Result<(), RunError> {
        self.write(Record::Forces, row.line().as_bytes())
    }

    fn frame(&mut self, frame: Frame) -> Result<(), RunError> {
        self.forget_frames();
        self.write(Record::Frames, &frame.to_bytes())
    }

    fn save(&mut self, mut checkpoint: Checkpoint) -> Result<(), RunError> {
        checkpoint.progress.lengths = self.records()?.flush()?;
        let path = self.path.join(CHECKPOINT_FILE);
        let bytes = checkpoint.to_bytes().map_err(|error| RunError::Store {
            location: path.display().to_string(),
            error,
        })?;
        super::write_all(&[Output { path, bytes }]).map_err(not_written)
    }

    fn outputs(&self) -> Vec<String> {
        let records = Record::ALL.map(Record::file_name).into_iter();
        let scan =
            (self.origin.input.as_deref() == Some(Path::new(SCAN_FILE))).then_some(SCAN_FILE);
        let names = records
            .chain([CHECKPOINT_FILE, SCENE_FILE, CSVW_FILE])
            .chain(scan);
        names
            .map(|name| self.path.join(name).display().to_string())
            .collect()
    }
}

impl RunSource for RunFolder {
    fn name(&self) -> String {
        self.path.display().to_string()
    }

    fn scene(&self) -> Result<Scene, RunError> {
        let path = self.path.join(SCENE_FILE);
        let text = fs::read_to_string(&path).map_err(|error| RunError::NoRun {
            location: self.name(),
            problem: format!("{SCENE_FILE} cannot be read ({error})"),
        })?;
        Scene::read(&text).map_err(|error| RunError::Scene {
            location: path.display().to_string(),
            error,
        })
    }

    fn checkpoint(&self) -> Result<Option<Checkpoint>, RunError> {
        let path = self.path.join(CHECKPOINT_FILE);
        let location = || path.display().to_string();
        let bytes = match fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(source) => {
                return Err(RunError::Unreadable {
                    location: location(),
                    source,
                });
            }
        };
        let checkpoint = Checkpoint::from_bytes(&bytes).map_err(|error| RunError::Store {
            location: location(),
            error,
        })?;
        Ok(Some(checkpoint))
    }

    fn energies(&self) -> Result<Vec<EnergyRow>, RunError> {
        Ok(parse_energies(&self.read_text(Record::Energies)?))
    }

    fn events(&self) -> Result<Vec<Event>, RunError> {
        Ok(parse_events(&self.read_text(Record::Events)?))
    }

    fn forces(&self) -> Result<Vec<ForceRow>, RunError> {
        Ok(parse_forces(&self.read_text(Record::Forces)?))
    }

    fn frames(&self) -> Result<FrameTimes, RunError> {
        self.with_frames(|frames| {
            Ok(FrameTimes {
                times: (0..frames.count()).map(|n| frames.time(n)).collect(),
                trailing_bytes: frames.trailing_bytes(),
            })
        })
    }

    fn frame(&self, number: usize) -> Result<Arc<Frame>, RunError> {
        let (frame, count) =
            self.with_frames(|frames| Ok((frames.read(number)?, frames.count())))?;
        frame
            .map(Arc::new)
            .ok_or(RunError::NoSuchFrame { number, count })
    }
}

fn unwritable(path: &Path, source: io::Error) -> RunError {
    RunError::Unwritable {
        location: path.display().to_string(),
        source,
    }
}

fn not_written(error: FileError) -> RunError {
    match error {
        FileError::Unwritable { path, source } => unwritable(&path, source),
        other => RunError::Other(Box::new(other)),
    }
}
