//! Apache Parquet: one row group with required columns, or many with columns in which values may be missing. Units and meanings are in the key-value metadata of the file, as
//! `NAME.unit` and `NAME.meaning`, and the table's own metadata under their names.

use crate::error::{FormatError, InFile};
use greenstick_geometry::{Table, Values};
use parquet::basic::{ConvertedType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int32Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::io::Write;
use std::sync::Arc;

/// Writes a table.
pub(super) fn write(table: &Table, file: InFile) -> Result<Vec<u8>, FormatError> {
    encode(table).map_err(|e| unwritable(e, file))
}

fn encode(table: &Table) -> Result<Vec<u8>, ParquetError> {
    let mut writer = begin(Vec::new(), table, Repetition::REQUIRED)?;
    write_rows(&mut writer, table, Repetition::REQUIRED)?;
    writer.into_inner()
}

fn unwritable(error: ParquetError, file: InFile) -> FormatError {
    file.unwritable(error, "a table that Parquet can represent")
}

/// A Parquet file that is written in groups of rows, so that not all of them need to be in memory. Numbers that are missing
/// (NaN) and empty texts are nulls.
pub struct ParquetStream<W: Write + Send> {
    writer: SerializedFileWriter<W>,
    name: String,
}

impl<W: Write + Send> ParquetStream<W> {
    /// Begins a file with the columns and the metadata of a table, whose rows are not written. `name` is for messages.
    ///
    /// # Errors
    /// [`FormatError::Unwritable`] if the table is invalid or its beginning cannot be written.
    pub fn new(to: W, table: &Table, name: &str) -> Result<Self, FormatError> {
        let file = InFile(name);
        if let Some(fault) = table.fault() {
            return Err(file.faulty_table(fault));
        }
        let writer = begin(to, table, Repetition::OPTIONAL).map_err(|e| unwritable(e, file))?;
        Ok(ParquetStream {
            writer,
            name: name.to_owned(),
        })
    }

    /// Writes the rows of a table with the same columns.
    ///
    /// # Errors
    /// As [`ParquetStream::new`].
    pub fn write(&mut self, table: &Table) -> Result<(), FormatError> {
        write_rows(&mut self.writer, table, Repetition::OPTIONAL)
            .map_err(|e| unwritable(e, InFile(&self.name)))
    }

    /// Ends the file.
    ///
    /// # Errors
    /// As [`ParquetStream::new`].
    pub fn finish(self) -> Result<(), FormatError> {
        let closed = self.writer.into_inner();
        closed
            .map(drop)
            .map_err(|e| unwritable(e, InFile(&self.name)))
    }
}

fn begin<W: Write + Send>(
    to: W,
    table: &Table,
    repetition: Repetition,
) -> Result<SerializedFileWriter<W>, ParquetError> {
    let fields = table
        .columns
        .iter()
        .map(|c| {
            let (physical, converted) = match c.values {
                Values::U8(_) => (Physical::INT32, ConvertedType::UINT_8),
                Values::U32(_) => (Physical::INT32, ConvertedType::UINT_32),
                Values::F64(_) => (Physical::DOUBLE, ConvertedType::NONE),
                Values::Text(_) => (Physical::BYTE_ARRAY, ConvertedType::UTF8),
            };
            Type::primitive_type_builder(&c.heading(), physical)
                .with_repetition(repetition)
                .with_converted_type(converted)
                .build()
                .map(Arc::new)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let schema = Type::group_type_builder("table")
        .with_fields(fields)
        .build()?;
    let metadata = table.columns.iter().flat_map(|c| {
        let heading = c.heading();
        [
            KeyValue::new(format!("{heading}.unit"), c.unit.clone()),
            KeyValue::new(format!("{heading}.meaning"), c.meaning.clone()),
        ]
    });
    let entries = table.metadata.entries.iter();
    let provenance = entries.map(|e| KeyValue::new(e.name.clone(), e.text.clone()));
    let metadata = metadata.chain(provenance);
    let properties = WriterProperties::builder()
        .set_created_by("Greenstick".to_owned())
        .set_key_value_metadata(Some(metadata.collect()))
        .build();
    SerializedFileWriter::new(to, Arc::new(schema), Arc::new(properties))
}

/// Writes a group of rows.
fn write_rows<W: Write + Send>(
    writer: &mut SerializedFileWriter<W>,
    table: &Table,
    repetition: Repetition,
) -> Result<(), ParquetError> {
    // Which values are there, where some may be missing: 1 for those that are.
    let levels = |is_there: Vec<bool>| {
        (repetition == Repetition::OPTIONAL)
            .then(|| is_there.into_iter().map(i16::from).collect::<Vec<i16>>())
    };
    let mut group = writer.next_row_group()?;
    for column in &table.columns {
        let Some(mut out) = group.next_column()? else {
            break;
        };
        match &column.values {
            Values::F64(v) => {
                let there = levels(v.iter().map(|x| !x.is_nan()).collect());
                let kept: Vec<f64> = v
                    .iter()
                    .copied()
                    .filter(|x| there.is_none() || !x.is_nan())
                    .collect();
                out.typed::<DoubleType>()
                    .write_batch(&kept, there.as_deref(), None)?
            }
            Values::Text(v) => {
                let there = levels(v.iter().map(|t| !t.is_empty()).collect());
                let kept = v.iter().filter(|t| there.is_none() || !t.is_empty());
                let texts: Vec<ByteArray> = kept.map(|t| t.as_str().into()).collect();
                out.typed::<ByteArrayType>()
                    .write_batch(&texts, there.as_deref(), None)?
            }
            Values::U8(v) => {
                let there = levels(vec![true; v.len()]);
                let widened: Vec<i32> = v.iter().map(|&x| x.into()).collect();
                out.typed::<Int32Type>()
                    .write_batch(&widened, there.as_deref(), None)?
            }
            Values::U32(v) => {
                let there = levels(vec![true; v.len()]);
                let same_bits: Vec<i32> = v.iter().map(|&x| x as i32).collect();
                out.typed::<Int32Type>()
                    .write_batch(&same_bits, there.as_deref(), None)?
            }
        };
        out.close()?;
    }
    group.close()?;
    Ok(())
}
