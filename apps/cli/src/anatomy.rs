//! `greenstick anatomy`: the inside of a stem as files.

use crate::arguments::{AnatomyOptions, Declared};
use crate::break_wood::{in_metres, size, unit_warning, use_threads};
use crate::failure::{Failure, parameter_hint, print};
use crate::outcome::{Written, spent};
use crate::progress::{Progress, StageTime};
use crate::scan::{self, Loaded};
use greenstick::anatomy::{ANATOMY_FILE, AnatomyFile, AnatomyOutput, report_file};
use greenstick::files::{self, Batch, FileError, Output};
use greenstick::formats::Encoded;
use greenstick::geometry::Context;
use greenstick::scanning::{ScannedReport, cleaned_file, outline_error};
use greenstick::schema::Parameters;
use greenstick::wood::anatomy::{AnatomyReport, SegmentReport};
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What `--json` prints: the library's report without its long lists, which are in the file, and the files written.
#[derive(Serialize)]
struct PrintedReport<'a> {
    schema: &'a str,
    version: u32,
    kind: &'a str,
    length_m: f64,
    radius_m: f64,
    rings: u16,
    layers: usize,
    particles: usize,
    bundle_area_m2: [f64; 2],
    mesh_volume_m3: Option<f64>,
    voxel_volume_m3: Option<f64>,
    segments: &'a [SegmentReport],
    notes: &'a [String],
    #[serde(skip_serializing_if = "Option::is_none")]
    scan: Option<&'a ScannedReport>,
    outputs: &'a [Written],
    stages: &'a [StageTime],
}

pub fn run(options: &AnatomyOptions) -> Result<ExitCode, Failure> {
    let mut file = AnatomyFile::default();
    apply_options(&mut file, &options.request)?;
    if let Some(path) = &options.rings_from {
        let rings = files::read_rings(path)?;
        let request = &mut file.request;
        request.series.ring_shares = Some(rings.shares);
        request.stem.eccentricity_onset =
            request.stem.eccentricity_onset.or(rings.eccentricity_onset);
    }
    file.check()
        .map_err(|error| Failure::request(&error).hint(parameter_hint(&error)))?;
    let unit = file.unit;
    use_threads(options.reporting.threads)?;
    let progress = Progress::start(options.reporting.quiet);
    let [read, work, write] = progress.split([("read", 1.0), ("anatomy", 8.0), ("write", 1.0)]);
    let source = load(options, &file, &read)?;
    file.request.location = source.place;
    let request = &mut file.request;
    request.smoothing = request
        .smoothing
        .or(source.scan.as_ref().and_then(outline_error));
    let mut folder = OutputFolder::new(&options.output, source.files)?;
    if let Some(cloud) = source
        .cleaned
        .filter(|_| file.request.wants(AnatomyOutput::Cleaned))
    {
        folder.add(cleaned_file(&cloud)?)?;
    }
    let mut report =
        greenstick::anatomy::anatomy(&source.scene, &file.request, &work, |file| folder.add(file))?;
    report.notes.extend(unit_warning(
        options.input.as_deref(),
        unit,
        report.length_m,
    ));
    write.report(0.0)?;
    folder.add(report_file(&report)?)?;
    let outputs = folder.finish()?;
    let stages = progress.finish();
    if options.reporting.prints_report() {
        print(&format_report(
            &report,
            source.scan.as_ref(),
            &outputs,
            &stages,
            options.reporting.json,
        )?)?;
    }
    Ok(ExitCode::SUCCESS)
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
fn load(
    options: &AnatomyOptions,
    file: &AnatomyFile,
    context: &Context,
) -> Result<Loaded, Failure> {
    let place = file.request.location;
    match &options.input {
        Some(path) => scan::load(path, place, file.unit, &file.scan, context),
        None => Ok(Loaded {
            scene: greenstick::built_in_branch(),
            place,
            scan: None,
            cleaned: None,
            files: Vec::new(),
        }),
    }
}

/// Applies options to a request. Points are in the unit of the file.
fn apply_options(file: &mut AnatomyFile, options: &Declared<AnatomyFile>) -> Result<(), Failure> {
    if let Some(word) = options.text("unit") {
        file.set_text("unit", word).map_err(Failure::request)?;
    }
    let unit = file.unit.unwrap_or_default();
    options.apply(file, |key, text| in_metres(key, text, unit))
}

/// Formats the report.
fn format_report(
    report: &AnatomyReport,
    scan: Option<&ScannedReport>,
    outputs: &[Written],
    stages: &[StageTime],
    json: bool,
) -> Result<String, Failure> {
    if json {
        let printed = PrintedReport {
            schema: &report.schema,
            version: report.version,
            kind: &report.kind,
            length_m: report.length_m,
            radius_m: report.radius_m,
            rings: report.rings,
            layers: report.layers,
            particles: report.particles,
            bundle_area_m2: report.bundle_area_m2,
            mesh_volume_m3: report.mesh_volume_m3,
            voxel_volume_m3: report.voxel_volume_m3,
            segments: &report.segments,
            notes: &report.notes,
            scan,
            outputs,
            stages,
        };
        let text = serde_json::to_string_pretty(&printed)
            .map_err(|e| Failure::work(format!("the report cannot be put into JSON: {e}")))?;
        return Ok(text + "\n");
    }
    let mut text = scan.map(ToString::to_string).unwrap_or_default();
    text += &report.to_string();
    for file in outputs {
        let _ = writeln!(text, "wrote     {}, {}", file.path, size(file.bytes));
    }
    let total: f64 = stages.iter().map(|s| s.seconds).sum();
    let _ = writeln!(text, "time      {total:.2} s: {}", spent(stages));
    Ok(text)
}
