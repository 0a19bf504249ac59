//! `greenstick anatomy`: the inside of a stem as files.

use crate::arguments::AnatomyOptions;
use crate::break_wood::{doubt_about_unit, size, use_threads};
use crate::failure::{Failure, print};
use crate::outcome::{Written, spent, written};
use crate::progress::{Progress, StageTime};
use crate::scan::{self, Loaded};
use crate::values;
use greenstick::anatomy::{AnatomyReport, AnatomyRequest};
use greenstick::files;
use greenstick::formats::LengthUnit;
use greenstick::geometry::Context;
use greenstick::scanning::ScannedReport;
use greenstick::wood::stem::StemLocation;
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;

/// The file that is always written.
const MAIN: &str = "anatomy.json";

/// The library's report but for its long lists, which are in the file, and what was written.
#[derive(Serialize)]
struct Told<'a> {
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
    segments: &'a [greenstick::anatomy::SegmentReport],
    notes: &'a [String],
    #[serde(skip_serializing_if = "Option::is_none")]
    scan: Option<&'a ScannedReport>,
    outputs: &'a [Written],
    stages: &'a [StageTime],
}

pub fn run(options: &AnatomyOptions) -> Result<ExitCode, Failure> {
    let unit = options.unit.map(LengthUnit::from);
    let mut request = request(options, unit.unwrap_or_default())?;
    use_threads(options.telling.threads)?;
    let progress = Progress::start(options.telling.quiet);
    let [read, work, write] = progress.split([("read", 1.0), ("anatomy", 8.0), ("write", 1.0)]);
    let source = load(options, request.place, unit, &read)?;
    request.place = source.place;
    files::check_folder(&options.output, MAIN)?;
    let mut inside = greenstick::anatomy::anatomy(&source.scene, &request, &work)?;
    let doubt = doubt_about_unit(
        options.input.as_deref(),
        options.unit,
        inside.report.length_m,
    );
    if let Some(doubt) = doubt {
        inside.note(doubt)?;
    }
    write.report(0.0)?;
    let planned: Vec<_> = inside
        .files
        .iter()
        .map(|f| options.output.join(&f.name))
        .collect();
    let planned: Vec<&Path> = planned.iter().map(|p| p.as_path()).collect();
    files::check_distinct(&planned, &source.files)?;
    let outputs = files::write_folder(&options.output, inside.files)?;
    let stages = progress.finish();
    if options.telling.reports() {
        let written = written(&outputs);
        print(&told(
            &inside.report,
            source.scan.as_ref(),
            &written,
            &stages,
            options.telling.json,
        )?)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The scene of an input, a cloud's as the bark of its stem, or the branch that comes with the program.
fn load(
    options: &AnatomyOptions,
    place: StemLocation,
    unit: Option<LengthUnit>,
    context: &Context,
) -> Result<Loaded, Failure> {
    match &options.input {
        Some(path) => scan::load(path, place, unit, &options.scan, context),
        None => Ok(Loaded {
            scene: greenstick::built_in_branch(),
            place,
            scan: None,
            files: Vec::new(),
        }),
    }
}

fn request(options: &AnatomyOptions, unit: LengthUnit) -> Result<AnatomyRequest, Failure> {
    Ok(AnatomyRequest {
        place: values::place(&options.at, unit).map_err(Failure::request)?,
        stem: options.stem.options(unit)?,
        species: options.species.clone(),
        resolution: options.resolution,
        rings_by: options.source.rings_by(options.rings.map(|_| "--rings"))?,
        rings: options.rings,
        sectors: options.sectors,
        layers: options.layers,
        bundles: options.bundles.into(),
        sections: options.sections,
        surface_ring: options.surface_ring,
        colours: options.colours.into(),
        parts: options.only.iter().map(|&word| word.into()).collect(),
    })
}

fn told(
    report: &AnatomyReport,
    scan: Option<&ScannedReport>,
    outputs: &[Written],
    stages: &[StageTime],
    json: bool,
) -> Result<String, Failure> {
    if json {
        let told = Told {
            schema: report.schema,
            version: report.version,
            kind: report.kind,
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
        let text = serde_json::to_string_pretty(&told)
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
