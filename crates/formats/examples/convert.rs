//! Converts a mesh file: `convert INPUT OUTPUT [UNIT]`, where UNIT is mm, cm or m, in both files; OUTPUT may be USD too.

use greenstick_formats::usd::{self, UsdFormat};
use greenstick_formats::{Format, LengthUnit, read, write};
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
    let format_of = |path: &Path| {
        Format::from_path(path).ok_or_else(|| {
            let extensions = Format::ALL.map(Format::extension).join(", ");
            format!(
                "{}: unknown extension; expected one of {extensions}",
                path.display()
            )
        })
    };
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
    let scene = read(format_of(input)?, &bytes, &name_of(input), unit, &resolve)?;
    let reading = start.elapsed();
    let start = Instant::now();
    let files = match UsdFormat::from_path(output) {
        Some(format) => usd::write(format, &scene, &name_of(output))?,
        None => write(
            format_of(output)?,
            &scene,
            &name_of(output),
            unit.unwrap_or_default(),
        )?,
    };
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
