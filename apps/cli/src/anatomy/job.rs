//! The inside of one stem: from the input to its files and its report.

use crate::break_files::size;
use crate::break_wood::unit_warning;
use crate::failure::Failure;
use crate::outcome::{Written, spent};
use crate::progress::{StageTime, split};
use greenstick::anatomy::{ANATOMY_FILE, AnatomyFile, AnatomyInput, report_file};
use greenstick::files::{self, Batch, FileError, Output};
use greenstick::formats::Encoded;
use greenstick::geometry::{Context, Provenance};
use greenstick::scanning::{ScannedReport, outline_error};
use greenstick::wood::anatomy::{
    AnatomyReport, ElementsReport, LimbReport, MassReport, MensurationReport, SegmentReport,
};
use greenstick_sweep::Input;
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// What `--json` prints: the library's report without its long lists, which are in the file, and the files written.
#[derive(Serialize)]
pub struct PrintedReport<'a> {
    schema: &'a str,
    version: u32,
    kind: &'a str,
    provenance: &'a Provenance,
    length_m: f64,
    radius_m: f64,
    rings: u16,
    layers: usize,
    particles: usize,
    bundle_area_m2: [f64; 2],
    mesh_volume_m3: Option<f64>,
    voxel_volume_m3: Option<f64>,
    measures: &'a MensurationReport,
    mass: Option<&'a MassReport>,
    limbs: &'a [LimbReport],
    elements: Option<&'a ElementsReport>,
    segments: &'a [SegmentReport],
    notes: &'a [String],
    #[serde(skip_serializing_if = "Option::is_none")]
    scan: Option<&'a ScannedReport>,
    outputs: &'a [Written],
    stages: &'a [StageTime],
}

/// The inside of one stem that is to be made.
pub struct Job<'a> {
    /// The input file; the branch that comes with the program where absent.
    pub input: Option<&'a Path>,
    /// The folder for its files.
    pub output: &'a Path,
    /// What is wanted.
    pub file: &'a AnatomyFile,
}

/// The inside of one stem.
pub struct Done {
    pub report: AnatomyReport,
    scan: Option<ScannedReport>,
    outputs: Vec<Written>,
    /// What the work took; filled in by whoever measured it.
    pub stages: Vec<StageTime>,
}

impl Job<'_> {
    /// Reads the input and writes all files, or none.
    pub fn run(&self, context: &Context) -> Result<Done, Failure> {
        let [read, work, write] = split(context, [("read", 1.0), ("anatomy", 8.0), ("write", 1.0)]);
        let mut file = self.file.clone();
        file.input = self.input.map(file_name);
        let source = load(self.input, &file, &read)?;
        let provenance = file.provenance(source.scan.as_ref());
        let request = &mut file.request;
        request.location = source.place;
        let outline_error = source.scan.as_ref().and_then(outline_error);
        request.smoothing = request.smoothing.or(outline_error);
        let mut folder = OutputFolder::new(self.output, source.files)?;
        let input = AnatomyInput {
            scene: &source.scene,
            scan: source.scan.as_ref(),
            cleaned: source.cleaned.as_ref(),
            provenance,
        };
        let mut report =
            greenstick::anatomy::anatomy(&input, &file.request, &work, |file| folder.add(file))?;
        let warning = unit_warning(self.input, file.unit, report.length_m);
        report.notes.extend(warning);
        write.report(0.0)?;
        folder.add(report_file(&report)?)?;
        Ok(Done {
            report,
            outputs: folder.finish()?,
            scan: source.scan,
            stages: Vec::new(),
        })
    }
}

/// The name of a file without its folders.
pub fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// A folder into which files are written one after the other, all or none. It is created if it does not exist, and then
/// removed again if the files are not finished.
struct OutputFolder {
    path: PathBuf,
    is_new: bool,
    /// Files that were read, which none may overwrite.
    inputs: Vec<PathBuf>,
    /// `None` once it is finished.
    batch: Option<Batch>,
    written: Vec<Written>,
}

impl OutputFolder {
    fn new(path: &Path, inputs: Vec<PathBuf>) -> Result<Self, FileError> {
        files::check_folder(path, ANATOMY_FILE)?;
        Ok(OutputFolder {
            path: path.to_owned(),
            is_new: !path.exists(),
            inputs,
            batch: Some(Batch::default()),
            written: Vec::new(),
        })
    }

    fn add(&mut self, file: Encoded) -> Result<(), Failure> {
        let output = Output {
            path: self.path.join(file.name),
            bytes: file.bytes,
        };
        files::check_distinct(&[&output.path], &self.inputs)?;
        std::fs::create_dir_all(&self.path).map_err(|source| FileError::Unwritable {
            path: self.path.clone(),
            source,
        })?;
        if let Some(batch) = &mut self.batch {
            batch.add(&output)?;
        }
        self.written.push(Written {
            path: output.path.display().to_string(),
            bytes: output.bytes.len(),
        });
        Ok(())
    }

    fn finish(mut self) -> Result<Vec<Written>, FileError> {
        if let Some(batch) = self.batch.take() {
            batch.finish()?;
        }
        self.is_new = false;
        Ok(std::mem::take(&mut self.written))
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        // Staged files are removed first.
        self.batch = None;
        if self.is_new {
            // Fails unless the folder is empty.
            let _ = std::fs::remove_dir(&self.path);
        }
    }
}

/// Loads the scene of an input, of a cloud the bark of its stem, or the branch that comes with the program.
fn load(input: Option<&Path>, file: &AnatomyFile, context: &Context) -> Result<Input, Failure> {
    let place = file.request.location;
    match input {
        Some(path) => Ok(Input::load(path, place, file.unit, &file.scan, context)?),
        None => Ok(Input::of_scene(greenstick::built_in_branch(), place)),
    }
}

impl Done {
    /// What `--json` prints.
    pub fn printed(&self) -> PrintedReport<'_> {
        let report = &self.report;
        PrintedReport {
            schema: &report.schema,
            version: report.version,
            kind: &report.kind,
            provenance: &report.provenance,
            length_m: report.length_m,
            radius_m: report.radius_m,
            rings: report.rings,
            layers: report.layers,
            particles: report.particles,
            bundle_area_m2: report.bundle_area_m2,
            mesh_volume_m3: report.mesh_volume_m3,
            voxel_volume_m3: report.voxel_volume_m3,
            measures: &report.measures,
            mass: report.mass.as_ref(),
            limbs: &report.limbs,
            elements: report.elements.as_ref(),
            segments: &report.segments,
            notes: &report.notes,
            scan: self.scan.as_ref(),
            outputs: &self.outputs,
            stages: &self.stages,
        }
    }

    /// The report as text or as JSON.
    pub fn format(&self, json: bool) -> Result<String, Failure> {
        if json {
            return to_json(&self.printed());
        }
        let mut text = self
            .scan
            .as_ref()
            .map(ToString::to_string)
            .unwrap_or_default();
        text += &self.report.to_string();
        for file in &self.outputs {
            let _ = writeln!(text, "wrote     {}, {}", file.path, size(file.bytes));
        }
        let total: f64 = self.stages.iter().map(|s| s.seconds).sum();
        let _ = writeln!(text, "time      {total:.2} s: {}", spent(&self.stages));
        Ok(text)
    }
}

/// A report as JSON, and a line feed.
pub fn to_json(report: &impl Serialize) -> Result<String, Failure> {
    let text = serde_json::to_string_pretty(report)
        .map_err(|e| Failure::work(format!("the report cannot be put into JSON: {e}")))?;
    Ok(text + "\n")
}
