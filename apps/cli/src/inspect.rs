//! `greenstick check` and `greenstick picture`: for any mesh, broken or not.

use crate::arguments::{CheckOptions, PictureOptions};
use crate::break_files::check_png;
use crate::break_wood::{file_name, use_threads};
use crate::failure::{Failure, print};
use crate::progress::Progress;
use greenstick::files::{self, Output};
use greenstick::geometry::text::one_line;
use greenstick::geometry::{CheckOptions as How, Report};
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;

/// The report on one file.
#[derive(Serialize)]
struct FileReport {
    file: String,
    meshes: Vec<MeshReport>,
    notes: Vec<String>,
}

/// The report on one mesh, in metres of the world.
#[derive(Serialize)]
struct MeshReport {
    name: String,
    solid: bool,
    #[serde(flatten)]
    report: Report,
}

pub fn check(options: &CheckOptions) -> Result<ExitCode, Failure> {
    let mut reports = Vec::new();
    for path in &options.files {
        reports.push(check_file(path, options)?);
    }
    if options.json {
        let text = serde_json::to_string_pretty(&reports)
            .map_err(|e| Failure::work(format!("the report cannot be put into JSON: {e}")))?;
        print(&(text + "\n"))?;
    } else {
        reports.iter().try_for_each(|r| print(&format_report(r)))?;
    }
    let sound = reports.iter().flat_map(|r| &r.meshes).all(|m| m.solid);
    Ok(ExitCode::from(u8::from(options.strict && !sound)))
}

fn check_file(path: &Path, options: &CheckOptions) -> Result<FileReport, Failure> {
    let scene = files::read(path, options.unit.map(Into::into))?;
    // Strands of torn fibre lie across each other.
    let how = |is_detail: bool| How {
        self_intersections: !options.fast && !is_detail,
    };
    let meshes = scene
        .nodes
        .iter()
        .filter(|node| !node.mesh.triangles.is_empty())
        .map(|node| {
            let report = node
                .mesh
                .transformed(&node.transform)
                .check_with(how(node.is_detail));
            MeshReport {
                name: node.name.clone(),
                solid: report.is_solid(),
                report,
            }
        })
        .collect();
    Ok(FileReport {
        file: path.display().to_string(),
        meshes,
        notes: scene.notes,
    })
}

/// Formats the report on a file.
fn format_report(file: &FileReport) -> String {
    let mut text = format!("{}\n", one_line(&file.file));
    for note in &file.notes {
        let _ = writeln!(text, "  note: {}", one_line(note));
    }
    for mesh in &file.meshes {
        let verdict = if mesh.solid {
            "a sound solid"
        } else {
            "not a sound solid"
        };
        let _ = writeln!(text, "  {}: {verdict}", one_line(&mesh.name));
        for line in mesh.report.to_string().lines() {
            let _ = writeln!(text, "    {line}");
        }
    }
    text
}

pub fn picture(options: &PictureOptions) -> Result<ExitCode, Failure> {
    check_png(&options.output)?;
    let parameters = options.picture_parameters.set()?;
    if parameters.close_up.is_some() {
        return Err(Failure::request(
            "--close-up shows a break from near, and a file does not say where it is broken",
        )
        .hint("take it with `greenstick break`, `simulate` or `skin`"));
    }
    use_threads(options.threads)?;
    let progress = Progress::start(options.quiet);
    let [read, work, write] = progress.split([("read", 1.0), ("picture", 8.0), ("write", 0.1)]);
    read.report(0.0)?;
    let mut source = files::load(&options.file, options.unit.map(Into::into))?;
    files::check_distinct(&[&options.output], &source.files)?;
    files::check_writable(&options.output)?;
    files::embed_images(&mut source.scene, &options.file);
    let how = parameters.options();
    let picture = greenstick::picture_of_scene(&source.scene, &how, &work)?;
    write.report(0.0)?;
    let input = file_name(Some(&options.file));
    let made = greenstick::provenance("picture", input.as_deref(), &parameters);
    let bytes = picture.png_with(&made.metadata());
    files::write_all(&[Output {
        path: options.output.clone(),
        bytes,
    }])?;
    progress.finish();
    if !options.quiet {
        print(&format!(
            "wrote {}, {} × {} pixels\n",
            options.output.display(),
            picture.width,
            picture.height
        ))?;
    }
    Ok(ExitCode::SUCCESS)
}
