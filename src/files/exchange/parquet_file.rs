//! Tables as Apache Parquet.

use std::{io::Write, sync::Arc};

use parquet::{
    basic::{LogicalType, Repetition, Type as Physical},
    column::writer::ColumnWriter,
    data_type::ByteArray,
    errors::{ParquetError, Result},
    file::{
        metadata::KeyValue,
        properties::{EnabledStatistics, WriterProperties},
        writer::{SerializedFileWriter, SerializedRowGroupWriter},
    },
    schema::types::Type,
};

use super::table::{Cell, Column, Kind, SCHEMA, Table};

/// A table as a Parquet file, written part by part, with the columns of the CSV file: `double`, `int64` or UTF-8, null where
/// a cell is missing. Each part is a row group.
///
/// The file's key-value metadata hold the version of the columns (`kinetostat.schema`) and the unit of every column that
/// has one (`unit.COLUMN`), since Parquet keeps no units itself.
pub struct ParquetFile<W: Write + Send> {
    writer: SerializedFileWriter<W>,
}

impl<W: Write + Send> ParquetFile<W> {
    /// Starts a file with `columns` that writes to `out`; `Err` when the library refuses the schema or the output fails.
    pub fn new(columns: &[Column], out: W) -> Result<Self> {
        let fields = columns.iter().map(|column| parquet_field(column).map(Arc::new)).collect::<Result<Vec<_>>>()?;
        let schema = Type::group_type_builder("table").with_fields(fields).build()?;
        let mut metadata = vec![KeyValue::new("kinetostat.schema".into(), SCHEMA.to_string())];
        for column in columns {
            metadata.extend(column.unit().map(|unit| KeyValue::new(format!("unit.{}", column.name), unit.to_string())));
        }
        let properties = WriterProperties::builder()
            .set_created_by(concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION")).into())
            .set_key_value_metadata(Some(metadata))
            // Their size grows with the number of row groups, all of it in memory.
            .set_statistics_enabled(EnabledStatistics::Chunk)
            .set_offset_index_disabled(true)
            .build();
        Ok(Self { writer: SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties))? })
    }

    /// Adds the rows of `table`, which has the columns of the file; `Err` when the library refuses them or the output fails.
    pub fn add(&mut self, table: &Table) -> Result<()> {
        let mut group = self.writer.next_row_group()?;
        for index in 0..table.columns().len() {
            write_column(&mut group, table.rows().iter().map(|row| &row[index]))?;
        }
        group.close()?;
        Ok(())
    }

    /// Returns the output after everything is written to it; `Err` when that fails.
    pub fn finish(self) -> Result<W> {
        self.writer.into_inner()
    }
}

/// Returns the whole table as the bytes of a Parquet file; `Err` when the library refuses the data.
pub fn parquet(table: &Table) -> Result<Vec<u8>> {
    let mut file = ParquetFile::new(table.columns(), Vec::new())?;
    file.add(table)?;
    file.finish()
}

/// Returns the Parquet type of a column.
fn parquet_field(column: &Column) -> Result<Type> {
    let (physical, logical) = match column.kind {
        Kind::Number => (Physical::DOUBLE, None),
        Kind::Count => (Physical::INT64, None),
        Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    };
    Type::primitive_type_builder(&column.name, physical)
        .with_logical_type(logical)
        .with_repetition(Repetition::OPTIONAL)
        .build()
}

/// Writes `cells` as the next column of `group`, `Cell::Missing` as null. Fails where the schema has no further column, or a count exceeds i64.
fn write_column<'a, W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    cells: impl Iterator<Item = &'a Cell> + Clone,
) -> Result<()> {
    let Some(mut column) = group.next_column()? else {
        return Err(ParquetError::General("more columns than the schema has".into()));
    };
    let present: Vec<i16> = cells.clone().map(|cell| i16::from(*cell != Cell::Missing)).collect();
    let definition_levels = Some(present.as_slice());
    match column.untyped() {
        ColumnWriter::DoubleColumnWriter(writer) => {
            let values: Vec<f64> =
                cells.filter_map(|c| if let Cell::Number(v) = c { Some(*v) } else { None }).collect();
            writer.write_batch(&values, definition_levels, None)?;
        }
        ColumnWriter::Int64ColumnWriter(writer) => {
            let counts = cells.filter_map(|c| if let Cell::Count(v) = c { Some(i64::try_from(*v)) } else { None });
            let values = counts.collect::<std::result::Result<Vec<_>, _>>();
            let values = values.map_err(|e| ParquetError::General(e.to_string()))?;
            writer.write_batch(&values, definition_levels, None)?;
        }
        ColumnWriter::ByteArrayColumnWriter(writer) => {
            let texts =
                cells.filter_map(|c| if let Cell::Text(v) = c { Some(ByteArray::from(v.as_str())) } else { None });
            writer.write_batch(&texts.collect::<Vec<_>>(), definition_levels, None)?;
        }
        _ => return Err(ParquetError::General("a column is neither number, count nor text".into())),
    }
    column.close()
}
