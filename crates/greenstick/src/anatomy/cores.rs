//! Ring widths along radii as files.

use super::outputs::Outputs;
use crate::Error;
use greenstick_formats::TableFormat;
use greenstick_formats::tucson::{RingWidthSeries, TucsonHeader, write_tucson};
use greenstick_geometry::Provenance;
use greenstick_wood::anatomy::{Anatomy, AnatomyRequest, Core, core_table};
use std::f64::consts::TAU;

/// The number of the site, which is ours to choose.
const SITE: &str = "GRNSTK";

/// Writes the cores of the section at the location. A note where there are none.
pub(super) fn write<E: From<Error>>(
    anatomy: &Anatomy,
    request: &AnatomyRequest,
    provenance: &Provenance,
    outputs: &mut Outputs<E>,
) -> Result<Option<String>, E> {
    let sections = anatomy.sections();
    let section = sections.section(sections.stem().location);
    let cores = section.map_or(Vec::new(), |s| anatomy.cores(&s, request.mensuration.cores));
    if cores.is_empty() {
        return Ok(Some(
            "no ring widths were written: boards and eroded rings have none along a radius"
                .to_owned(),
        ));
    }
    let last_year = request.mensuration.last_year.map(|year| year as i32);
    outputs.table(
        core_table(&cores, last_year),
        "ring_widths",
        TableFormat::Csv,
    )?;
    let count = cores[0].widths.len() as i32;
    let first_year = last_year.map_or(1, |last| last - count + 1);
    let outwards = |core: &Core| series(core, first_year, core.widths.clone());
    let inwards = |core: &Core| series(core, 1, core.widths.iter().rev().copied().collect());
    let all = |series: &dyn Fn(&Core) -> RingWidthSeries| cores.iter().map(series).collect();
    let back = "bark to pith, not in calendar years";
    for (all, name, numbering) in [
        (all(&outwards), "rings.rwl", "pith to bark"),
        (all(&inwards), "rings_inwards.rwl", back),
    ] {
        let all: Vec<RingWidthSeries> = all;
        let header = TucsonHeader {
            site: SITE.to_owned(),
            site_name: format!("{} {numbering}", input_name(provenance)),
            species: request.species.clone().unwrap_or_default(),
            investigator: format!(
                "{} {} {} {}",
                provenance.program,
                provenance.version,
                provenance.command,
                provenance.parameters.join(" ")
            ),
        };
        outputs.add(write_tucson(&header, &all, name).map_err(Error::from)?)?;
    }
    Ok(None)
}

fn input_name(provenance: &Provenance) -> &str {
    provenance.input.as_deref().unwrap_or("built-in branch")
}

/// The series of a radius, named by its direction in degrees.
fn series(core: &Core, first_year: i32, widths: Vec<f64>) -> RingWidthSeries {
    let degrees = (360.0 * core.angle / TAU).round();
    RingWidthSeries {
        name: format!("R{degrees:03}"),
        first_year,
        widths,
    }
}
