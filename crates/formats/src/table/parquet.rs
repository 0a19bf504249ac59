//! Apache Parquet: one row group with required columns. Units and meanings are in the key-value metadata of the file, as
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
use std::sync::Arc;

/// Writes a table.
pub(super) fn write(table: &Table, file: InFile) -> Result<Vec<u8>, FormatError> {
    encode(table).map_err(|e| file.unwritable(e, "a table that Parquet can represent"))
}

fn encode(table: &Table) -> Result<Vec<u8>, ParquetError> {
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
                .with_repetition(Repetition::REQUIRED)
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
    let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for column in &table.columns {
        let Some(mut out) = group.next_column()? else {
            break;
        };
        match &column.values {
            Values::F64(v) => out.typed::<DoubleType>().write_batch(v, None, None)?,
            Values::Text(v) => {
                let texts: Vec<ByteArray> = v.iter().map(|t| t.as_str().into()).collect();
                out.typed::<ByteArrayType>()
                    .write_batch(&texts, None, None)?
            }
            Values::U8(v) => {
                let widened: Vec<i32> = v.iter().map(|&x| x.into()).collect();
                out.typed::<Int32Type>().write_batch(&widened, None, None)?
            }
            Values::U32(v) => {
                let same_bits: Vec<i32> = v.iter().map(|&x| x as i32).collect();
                out.typed::<Int32Type>()
                    .write_batch(&same_bits, None, None)?
            }
        };
        out.close()?;
    }
    group.close()?;
    writer.into_inner()
}
