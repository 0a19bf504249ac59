//! The measures along a stem as a table.

use super::section_size::SectionSize;
use super::stem_measures::StemMeasures;
use greenstick_geometry::{Column, Table, Values};
use std::f64::consts::PI;

/// Builds columns, a value for each section.
struct Columns<'a> {
    measures: &'a StemMeasures,
    columns: Vec<Column>,
}

impl Columns<'_> {
    fn add(&mut self, name: &str, unit: &str, meaning: &str, value: impl Fn(&SectionSize) -> f64) {
        let values = self.measures.rows.iter().map(value).collect();
        let column = Column::new(name, unit, meaning, Values::F64(values));
        self.columns.push(column);
    }

    /// The standard errors of the column before, missing where `value` gives none.
    fn add_error(&mut self, unit: &str, value: impl Fn(&SectionSize) -> Option<f64>) {
        let before = self.columns.last().map_or("", |c| &c.name);
        let (name, meaning) = (
            format!("{before}_error"),
            format!("standard error of {before}; empty where the input is a mesh"),
        );
        self.add(&name, unit, &meaning, |size| {
            value(size).unwrap_or(f64::NAN)
        });
    }
}

impl StemMeasures {
    /// The sections as a table, a row each. Standard errors are missing where the stem is no scan's.
    pub fn table(&self) -> Table {
        let mut columns = Columns {
            measures: self,
            columns: Vec::new(),
        };
        add_places(&mut columns);
        add_diameters(&mut columns);
        add_shape(&mut columns);
        add_volumes(&mut columns);
        if self.years.len() == self.rows.len() {
            columns.columns.push(Column::new(
                "years",
                "",
                "annual rings: the butt's, less those for which the section is too thin",
                Values::U32(self.years.clone()),
            ));
        }
        Table {
            columns: columns.columns,
            ..Table::default()
        }
    }
}

fn add_places(c: &mut Columns) {
    c.add("length", "m", "along the stem's axis from its butt", |s| {
        s.length
    });
    c.add("x", "m", "centroid of the section", |s| s.centroid.x);
    c.add("y", "m", "centroid of the section", |s| s.centroid.y);
    c.add("z", "m", "centroid of the section", |s| s.centroid.z);
    let measures = c.measures;
    c.add(
        "girth_seen",
        "",
        "share of the girth that the input shows, 0 to 1",
        |s| measures.errors_at(s).map_or(1.0 - s.bridged, |e| e.seen),
    );
}

fn add_diameters(c: &mut Columns) {
    let measures = c.measures;
    let girth_error = |s: &SectionSize| measures.errors_at(s).map(|e| e.girth / PI);
    c.add(
        "diameter_by_area",
        "m",
        "of the circle of the section's area",
        SectionSize::diameter_by_area,
    );
    c.add_error("m", |s| measures.errors_at(s).map(|e| e.diameter));
    c.add(
        "diameter_by_girth",
        "m",
        "length of the outline with its relief over pi",
        SectionSize::diameter_by_girth,
    );
    c.add_error("m", girth_error);
    c.add(
        "diameter_by_tape",
        "m",
        "length of the convex hull over pi, as a diameter tape shows it",
        SectionSize::diameter_by_tape,
    );
    c.add_error("m", girth_error);
    c.add(
        "diameter_under_bark",
        "m",
        "of the circle of the wood's area; the bark is a share of the radius, which was not measured",
        SectionSize::diameter_under_bark,
    );
}

fn add_shape(c: &mut Columns) {
    let measures = c.measures;
    let [least, greatest] = ["least", "greatest"].map(|w| format!("{w} calliper diameter"));
    c.add("calliper_least", "m", &least, |s| s.calliper_diameters[0]);
    c.add("calliper_greatest", "m", &greatest, |s| {
        s.calliper_diameters[1]
    });
    c.add(
        "ovality",
        "",
        "1 less least over greatest calliper diameter",
        SectionSize::ovality,
    );
    c.add_error("", |s| measures.errors_at(s).map(|e| e.ovality));
    c.add("pith_offset", "m", "pith from the centroid", |s| {
        s.pith_offset
    });
    let column = c.columns.len();
    c.add_error("m", |s| Some(measures.pith_error(s)));
    c.columns[column].meaning =
        "standard error of pith_offset: how far a pith that was guessed is off; 0 where it was given".into();
    c.add(
        "pith_direction",
        "rad",
        "of the pith from the centroid, about the axis, from the section's direction x in anatomy.json",
        |s| s.pith_direction,
    );
    c.add("pith_x", "m", "pith", |s| s.pith.x);
    c.add("pith_y", "m", "pith", |s| s.pith.y);
    c.add("pith_z", "m", "pith", |s| s.pith.z);
}

fn add_volumes(c: &mut Columns) {
    let measures = c.measures;
    for (k, which) in ["over", "under"].into_iter().enumerate() {
        c.add(
            &format!("volume_{which}_bark"),
            "m3",
            &format!("{which} bark, from the butt to this section"),
            |s| measures.volumes(s.length)[k],
        );
        c.add_error("m3", |s| measures.volume_errors(s.length).map(|e| e[k]));
    }
}
