//! A run as a series of VTK files: rods and bonds with their fields, for ParaView. In the scene's own axes, z up.

use super::error::FilmError;
use greenstick_fibre::store::Frame;
use greenstick_formats::Encoded;
use greenstick_formats::vtk::{Field, Polylines, TimedFile, collection, write_lines};
use greenstick_geometry::{Context, Metadata, Provenance, Values};
use greenstick_skin::film::{BondLines, Run};
use std::ops::Range;

/// Writes frames of a range as a series of a name, all of which say where they come from: hands every file to `put`, the
/// collection `NAME.pvd` last. Returns the number of files.
///
/// Rods have the fields `rod`, `part` and `diameter_m` for each line, and `vertex` and `strain` for each point (mean
/// of its edges); bonds `stretch` (length over that at rest) for each line.
///
/// # Errors
/// [`FilmError`], and the error of `put`.
pub fn write_series(
    run: &Run,
    range: Range<usize>,
    (name, provenance): (&str, &Provenance),
    mut put: impl FnMut(Encoded) -> Result<(), FilmError>,
    context: &Context,
) -> Result<usize, FilmError> {
    let mut files = Vec::new();
    let count = range.len();
    let metadata = provenance.metadata();
    for (done, number) in range.enumerate() {
        context.report(done as f64 / count as f64)?;
        let frame = run.frame(number)?;
        for file in [
            rods(
                run,
                &frame,
                &format!("{name}_{number:05}_rods.vtp"),
                &metadata,
            )?,
            bonds(
                run,
                &frame,
                &format!("{name}_{number:05}_bonds.vtp"),
                &metadata,
            )?,
        ] {
            files.push(TimedFile {
                time: frame.time,
                file: file.name.clone(),
            });
            put(file)?;
        }
    }
    put(Encoded {
        name: format!("{name}.pvd"),
        bytes: collection(&files).into_bytes(),
    })?;
    Ok(files.len() + 1)
}

fn rods(run: &Run, frame: &Frame, name: &str, metadata: &Metadata) -> Result<Encoded, FilmError> {
    let lines = run.rod_lines(frame);
    let corners: Vec<u32> = (0..lines.points.len() as u32).collect();
    let point_data = [
        Field::scalar("vertex", Values::U32(frame.origin.clone())),
        Field::scalar("strain", Values::F64(lines.strains)),
    ];
    let diameters = frame.diameter.iter().map(|&d| f64::from(d)).collect();
    let line_data = [
        Field::scalar("rod", Values::U32(frame.parent.clone())),
        Field::scalar("part", Values::U32(lines.parts)),
        Field::scalar("diameter_m", Values::F64(diameters)),
    ];
    let rods = Polylines {
        points: &lines.points,
        corners: &corners,
        ends: &frame.rod_offsets[1..],
        point_data: &point_data,
        line_data: &line_data,
        metadata: Some(metadata),
    };
    Ok(write_lines(&rods, name).map_err(crate::Error::from)?)
}

fn bonds(run: &Run, frame: &Frame, name: &str, metadata: &Metadata) -> Result<Encoded, FilmError> {
    let BondLines { points, stretch } = run.bond_lines(frame);
    let corners: Vec<u32> = (0..points.len() as u32).collect();
    let ends: Vec<u32> = (1..=stretch.len() as u32).map(|k| 2 * k).collect();
    let line_data = [Field::scalar("stretch", Values::F64(stretch))];
    let bonds = Polylines {
        points: &points,
        corners: &corners,
        ends: &ends,
        point_data: &[],
        line_data: &line_data,
        metadata: Some(metadata),
    };
    Ok(write_lines(&bonds, name).map_err(crate::Error::from)?)
}
