//! The table of a sweep: a row for every variant that is done, in their order, as Parquet. It is written in groups of rows, so
//! that its memory does not grow with the number of variants.

use crate::axis::Axis;
use crate::error::SweepError;
use crate::figures::{self, BEND_COLUMNS, BREAK_COLUMNS, Figures, RUN_COLUMNS, RunFigures};
use crate::journal::{Journal, Record};
use crate::plan::{Sweep, SweepKind};
use greenstick::files::{self, FileError};
use greenstick::formats::ParquetStream;
use greenstick::geometry::{Column, Context, Table, Values};
use greenstick::schema::{Kind, Value};
use std::path::Path;

/// Name of the table in the folder of a sweep.
pub const TABLE_FILE: &str = "variants.parquet";
/// Rows that are in memory at a time.
const ROWS: usize = 20_000;

/// Writes the table of all variants that are done into the folder of a sweep, beside its place first.
///
/// # Errors
/// [`SweepError`] where the journal cannot be read or the table cannot be written, or the caller cancelled.
pub fn write_table(
    sweep: &Sweep,
    journal: &Journal,
    folder: &Path,
    context: &Context,
) -> Result<(), SweepError> {
    let places = journal.places()?;
    let done: Vec<u64> = places.into_iter().flatten().collect();
    let path = folder.join(TABLE_FILE);
    let name = path.display().to_string();
    files::write_streamed(&path, |file| {
        let encoding = |e| SweepError::File(FileError::Encoding(e));
        let mut stream = ParquetStream::new(file, &rows(sweep, &[]), &name).map_err(encoding)?;
        let count = done.len().div_ceil(ROWS);
        for (at, part) in done.chunks(ROWS).enumerate() {
            context.item(at, count).report(0.0)?;
            let records = part.iter().map(|place| journal.at(*place));
            let records: Vec<Record> = records.collect::<Result<_, _>>()?;
            stream.write(&rows(sweep, &records)).map_err(encoding)?;
        }
        stream.finish().map_err(encoding)
    })
}

/// The rows of some variants.
fn rows(sweep: &Sweep, records: &[Record]) -> Table {
    let numbers = records.iter().map(|r| r.variant as u32).collect();
    let mut columns = vec![Column::new(
        "variant",
        "",
        "number of the variant",
        Values::U32(numbers),
    )];
    columns.extend(tree_columns(sweep, records));
    let values: Vec<Vec<Value>> = records.iter().map(|r| sweep.values(r.variant)).collect();
    for (k, axis) in sweep.axes.iter().enumerate() {
        columns.push(varied(axis, values.iter().map(|row| &row[k])));
    }
    let (key, seed) = sweep.base.seed();
    if sweep.axes.iter().all(|axis| axis.info.key != key) {
        // Every tree has a seed of its own.
        let seed =
            |record: &Record| (sweep.forest()).map_or(seed, |f| f.seed(seed, record.variant));
        let seeds = Values::Text(records.iter().map(|r| seed(r).to_string()).collect());
        columns.push(Column::new("seed", "", "seed of the variant", seeds));
    }
    columns.extend(figures(sweep, records));
    let text = |get: fn(&Record) -> &Option<String>| {
        let texts = records.iter().map(|r| get(r).clone().unwrap_or_default());
        Values::Text(texts.collect())
    };
    let seconds = records.iter().map(|r| r.seconds).collect();
    columns.push(Column::new(
        "file",
        "",
        "file of the pieces",
        text(|r| &r.file),
    ));
    columns.push(Column::new(
        "seconds",
        "s",
        "time it took",
        Values::F64(seconds),
    ));
    columns.push(Column::new(
        "error",
        "",
        "why it failed",
        text(|r| &r.error),
    ));
    // What varies in it is in the columns.
    let input = sweep.input_path(&sweep.base);
    let name = input.as_deref().and_then(Path::file_name);
    let name = name.map(|name| name.to_string_lossy().into_owned());
    Table {
        columns,
        metadata: sweep.base.provenance(name.as_deref()).metadata(),
    }
}

/// The name of each tree of a forest, and whether it broke.
fn tree_columns(sweep: &Sweep, records: &[Record]) -> Vec<Column> {
    let Some(forest) = sweep.forest() else {
        return Vec::new();
    };
    let names = records.iter().map(|r| {
        let tree = &forest.trees()[r.variant as usize];
        tree.name.clone()
    });
    let broken = records.iter().map(|r| u32::from(r.figures.is_some()));
    vec![
        Column::new(
            "tree",
            "",
            "name of the tree's node",
            Values::Text(names.collect()),
        ),
        Column::new(
            "broken",
            "",
            "1 where it broke, 0 where it stayed whole",
            Values::U32(broken.collect()),
        ),
    ]
}

/// The figures of reports, a column each.
fn figures(sweep: &Sweep, records: &[Record]) -> Vec<Column> {
    match sweep.settings.kind {
        SweepKind::Break | SweepKind::Forest => {
            numbers(records, BREAK_COLUMNS, |figures| match figures {
                Figures::Break(figures) => Some(figures),
                _ => None,
            })
        }
        SweepKind::Scene => {
            fn run(figures: &Figures) -> Option<&RunFigures> {
                match figures {
                    Figures::Run(figures) => Some(figures),
                    _ => None,
                }
            }
            let modes = records.iter().map(|record| {
                let figures = record.figures.as_ref().and_then(run);
                figures.map_or_else(String::new, |f: &RunFigures| f.mode.clone())
            });
            let modes = Values::Text(modes.collect());
            let mut columns = vec![Column::new("mode", "", "how the wood broke", modes)];
            columns.extend(numbers(records, RUN_COLUMNS, run));
            columns
        }
        SweepKind::BendTest => numbers(records, BEND_COLUMNS, |figures| match figures {
            Figures::Bend(figures) => Some(figures),
            _ => None,
        }),
    }
}

/// Figures of one kind.
fn numbers<F>(
    records: &[Record],
    columns: &[figures::Column<F>],
    kind: impl Fn(&Figures) -> Option<&F>,
) -> Vec<Column> {
    let column = |(name, unit, meaning, get): &figures::Column<F>| {
        let numbers = records.iter().map(|record| {
            let figures = record.figures.as_ref().and_then(&kind);
            figures.map_or(f64::NAN, get)
        });
        Column::new(name, unit, meaning, Values::F64(numbers.collect()))
    };
    columns.iter().map(column).collect()
}

/// The column of a key that varies: numbers as numbers, and all else as texts.
fn varied<'a>(axis: &Axis, values: impl Iterator<Item = &'a Value>) -> Column {
    let key = axis
        .info
        .key
        .strip_prefix("break.")
        .unwrap_or(&axis.info.key);
    let name = format!("vary_{}", key.replace('.', "_"));
    let unit = match axis.info.unit() {
        "%" => "percent",
        "°" => "degree",
        unit if unit.bytes().all(|b| b.is_ascii_alphanumeric()) => unit,
        _ => "",
    };
    let values = if axis.is_small() {
        let whole = |value: &Value| match value {
            Value::Integer(n) => u32::try_from(*n).unwrap_or_default(),
            _ => 0,
        };
        Values::U32(values.map(whole).collect())
    } else if matches!(axis.info.kind, Kind::Number { .. }) {
        let number = |value: &Value| match value {
            Value::Number(x) => *x,
            _ => f64::NAN,
        };
        Values::F64(values.map(number).collect())
    } else {
        Values::Text(values.map(ToString::to_string).collect())
    };
    Column::new(&name, unit, &axis.info.doc, values)
}
