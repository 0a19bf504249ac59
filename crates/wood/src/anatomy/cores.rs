//! Ring widths along radii of a section, as increment cores have them.

use super::model::Anatomy;
use super::sections::TransverseSection;
use crate::rings::RingSource;
use crate::tissue::Zone;
use greenstick_geometry::{Column, Table, Values};
use std::f64::consts::TAU;

/// The rings of the wood along one radius, from the pith to the bark.
#[derive(Debug, Clone, PartialEq)]
pub struct Core {
    /// Direction from the pith, rad, from the section's direction x.
    pub angle: f64,
    /// Widths, m.
    pub widths: Vec<f64>,
    /// Widths of the latewood in them, m.
    pub latewood: Vec<f64>,
    /// Tissues.
    pub tissues: Vec<Zone>,
}

impl Anatomy<'_> {
    /// Returns cores in `count` directions of a section at equal angles, the first along its direction x. None of a board and of
    /// eroded rings, which have no width along a radius.
    pub fn cores(&self, section: &TransverseSection, count: u32) -> Vec<Core> {
        if self.is_board() || self.is_eroded() {
            return Vec::new();
        }
        let rings = self.rings();
        let wood: Vec<usize> = (0..rings.ring_count())
            .filter(|&k| rings.tissues()[k] <= Zone::Sapwood && rings.unfinished() != Some(k))
            .collect();
        (0..count)
            .map(|k| {
                let turn = f64::from(k) / f64::from(count);
                let angle = if turn > 0.5 { turn - 1.0 } else { turn } * TAU;
                let radius = |rho: f64| section.field.radius(rho, angle);
                let edges = || wood.iter().map(|&ring| rings.ring(ring));
                Core {
                    angle: turn * TAU,
                    widths: edges().map(|e| radius(e.outer) - radius(e.inner)).collect(),
                    latewood: edges()
                        .map(|e| radius(e.outer) - radius(e.latewood))
                        .collect(),
                    tissues: wood.iter().map(|&ring| rings.tissues()[ring]).collect(),
                }
            })
            .collect()
    }
}

/// Cores as a table, a ring a row, from the pith outwards. `last_year` is that of the outermost ring.
pub fn core_table(cores: &[Core], last_year: Option<i32>) -> Table {
    let rows = || {
        let numbered = cores.iter();
        numbered.flat_map(|core| (0..core.widths.len()).map(move |ring| (core, ring)))
    };
    let count = |core: &Core| core.widths.len();
    let mut columns = vec![
        Column::new(
            "direction",
            "rad",
            "of the radius from the pith, counter-clockwise seen against the growth, from the section's direction x",
            Values::F64(rows().map(|(core, _)| core.angle).collect()),
        ),
        Column::new(
            "ring",
            "",
            "counted from 1 at the pith",
            Values::U32(rows().map(|(_, ring)| ring as u32 + 1).collect()),
        ),
        Column::new(
            "ring_from_bark",
            "",
            "counted from 1 at the bark",
            Values::U32(
                rows()
                    .map(|(core, ring)| (count(core) - ring) as u32)
                    .collect(),
            ),
        ),
    ];
    if let Some(last) = last_year {
        let year = |core: &Core, ring: usize| f64::from(last) - (count(core) - 1 - ring) as f64;
        let years = rows().map(|(core, ring)| year(core, ring)).collect();
        let meaning = "calendar year in which it grew";
        columns.push(Column::new("year", "", meaning, Values::F64(years)));
    }
    let inner = |core: &Core, ring: usize| {
        core.widths[..ring]
            .iter()
            .fold(0.0, |sum, width| sum + width)
    };
    columns.extend([
        Column::new(
            "inner_radius",
            "m",
            "distance of its inner edge from the pith",
            Values::F64(rows().map(|(core, ring)| inner(core, ring)).collect()),
        ),
        Column::new(
            "width",
            "m",
            "width along the radius",
            Values::F64(rows().map(|(core, ring)| core.widths[ring]).collect()),
        ),
        Column::new(
            "latewood_width",
            "m",
            "width of its latewood along the radius",
            Values::F64(rows().map(|(core, ring)| core.latewood[ring]).collect()),
        ),
        Column::new(
            "zone",
            "",
            "0 pith, 1 heartwood, 2 sapwood",
            Values::U8(
                rows()
                    .map(|(core, ring)| core.tissues[ring].code())
                    .collect(),
            ),
        ),
    ]);
    Table {
        columns,
        ..Table::default()
    }
}
