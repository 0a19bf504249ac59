//! Converts a mesh file: `convert INPUT OUTPUT [UNIT]`, where UNIT is mm, cm or m, in both files; OUTPUT may be USD too.

use greenstick_formats::{Format, LengthUnit, OutputFormat, read, write_as};
use std::error::Error;
use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [input, output, rest @ ..] = arguments.as_slice() else {
        return Err("expected: convert INPUT OUTPUT [mm|cm|m]".into());
    };
    let unit: Option<LengthUnit> = rest.first().map(|u| u.parse()).transpose()?;
    let (input, output) = (Path::new(input), Path::new(output));
    let unknown = |path: &Path, all: Vec<&str>| {
        let (path, all) = (path.display(), all.join(", "));
        format!("{path}: unknown extension; expected one of {all}")
    };
    let read_as = Format::from_path(input)
        .ok_or_else(|| unknown(input, Format::ALL.map(Format::extension).to_vec()))?;
    let written_as = OutputFormat::from_path(output).ok_or_else(|| {
        let all = OutputFormat::all().into_iter().map(OutputFormat::extension);
        unknown(output, all.collect())
    })?;
    let folder = |path: &Path| path.parent().unwrap_or(Path::new("")).to_owned();
    let name_of = |path: &Path| {
        path.file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned()
    };
    let bytes = std::fs::read(input)?;
    let resolve = |name: &str| std::fs::read(folder(input).join(name));
    let start = Instant::now();
    let scene = read(read_as, &bytes, &name_of(input), unit, &resolve)?;
    let reading = start.elapsed();
    let start = Instant::now();
    let unit = unit.unwrap_or_default();
    let files = write_as(written_as, &scene, &name_of(output), unit)?;
    let writing = start.elapsed();
    for file in files {
        std::fs::write(folder(output).join(file.name), file.bytes)?;
    }
    for note in &scene.notes {
        println!("{note}");
    }
    let triangles: usize = scene.nodes.iter().map(|n| n.mesh.triangles.len()).sum();
    println!("{triangles} triangles; read in {reading:.1?}, written in {writing:.1?}");
    Ok(())
}
