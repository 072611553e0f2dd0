//! A tidy table as a Parquet file, without compression; its metadata state units and provenance.

use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;

use super::package::TableProvenance;
use super::table::{FieldKind, TidyColumn, TidyTable};

/// The table as a Parquet file.
///
/// # Errors
/// [`ParquetError`] only if the writer refuses its own schema.
pub fn parquet(about: &TableProvenance, table: &TidyTable) -> Result<Vec<u8>, ParquetError> {
    let fields = table.columns.iter().map(field);
    let metadata = Some(metadata(about, table));
    write_parquet("table", fields, metadata, |place, writer| {
        let present = |row: &Vec<String>| i16::from(!row[place].is_empty());
        let levels: Vec<i16> = table.rows.iter().map(present).collect();
        let given = table.rows.iter().map(|row| row[place].as_str());
        let given = given.filter(|field| !field.is_empty());
        match table.columns[place].kind {
            FieldKind::Integer => {
                let values: Vec<i64> = given.filter_map(|field| field.parse().ok()).collect();
                writer
                    .typed::<Int64Type>()
                    .write_batch(&values, Some(&levels), None)
            }
            FieldKind::Number => {
                let values: Vec<f64> = given.filter_map(|field| field.parse().ok()).collect();
                writer
                    .typed::<DoubleType>()
                    .write_batch(&values, Some(&levels), None)
            }
            FieldKind::Text | FieldKind::DateTime => {
                let values: Vec<ByteArray> = given.map(ByteArray::from).collect();
                writer
                    .typed::<ByteArrayType>()
                    .write_batch(&values, Some(&levels), None)
            }
        }
    })
}

/// A Parquet file of one group of columns, each of which `write` writes by its place.
pub(crate) fn write_parquet(
    name: &str,
    fields: impl Iterator<Item = Result<Type, ParquetError>>,
    metadata: Option<Vec<KeyValue>>,
    mut write: impl FnMut(usize, &mut SerializedColumnWriter<'_>) -> Result<usize, ParquetError>,
) -> Result<Vec<u8>, ParquetError> {
    let fields = fields.map(|field| field.map(Arc::new));
    let fields = fields.collect::<Result<Vec<_>, ParquetError>>()?;
    let schema = Type::group_type_builder(name).with_fields(fields).build()?;
    let properties = WriterProperties::builder()
        .set_key_value_metadata(metadata)
        .build();
    let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    let mut place = 0;
    while let Some(mut column) = group.next_column()? {
        write(place, &mut column)?;
        column.close()?;
        place += 1;
    }
    group.close()?;
    writer.into_inner()
}

fn field(column: &TidyColumn) -> Result<Type, ParquetError> {
    let (physical, logical) = match column.kind {
        FieldKind::Integer => (Physical::INT64, None),
        FieldKind::Number => (Physical::DOUBLE, None),
        FieldKind::Text | FieldKind::DateTime => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    };
    Type::primitive_type_builder(&column.name, physical)
        .with_repetition(Repetition::OPTIONAL)
        .with_logical_type(logical)
        .build()
}

/// Facts, and the unit of each column that has one under `unit:COLUMN`.
fn metadata(about: &TableProvenance, table: &TidyTable) -> Vec<KeyValue> {
    let facts = about.facts.iter().cloned();
    let units = table
        .columns
        .iter()
        .filter(|column| !column.unit.is_empty());
    let units = units.map(|column| (format!("unit:{}", column.name), column.unit.clone()));
    let pairs = facts.chain(units);
    pairs
        .map(|(key, value)| KeyValue::new(key, value))
        .collect()
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    use super::*;

    #[test]
    fn a_reader_finds_every_field() {
        let column = |name: &str, kind, unit: &str| TidyColumn {
            name: name.to_owned(),
            kind,
            unit: unit.to_owned(),
            meaning: String::new(),
        };
        let columns = vec![
            column("pose", FieldKind::Text, ""),
            column("seq", FieldKind::Integer, ""),
            column("force_N", FieldKind::Number, "N"),
        ];
        let row = |fields: [&str; 3]| fields.map(str::to_owned).to_vec();
        let rows = vec![row(["P1", "1", "-2.5"]), row(["P2", "", ""])];
        let table = TidyTable::new("t", "a row", columns, rows);
        let mut file = tempfile::tempfile().unwrap();
        let bytes = parquet(&TableProvenance::default(), &table).unwrap();
        file.write_all(&bytes).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let pairs = reader
            .metadata()
            .file_metadata()
            .key_value_metadata()
            .unwrap();
        assert_eq!(
            pairs[0],
            KeyValue::new("unit:force_N".to_owned(), "N".to_owned())
        );
        let rows: Vec<Vec<Field>> = reader
            .get_row_iter(None)
            .unwrap()
            .map(|row| {
                row.unwrap()
                    .into_columns()
                    .into_iter()
                    .map(|(_, field)| field)
                    .collect()
            })
            .collect();
        let text = |text: &str| Field::Str(text.to_owned());
        assert_eq!(rows[0], [text("P1"), Field::Long(1), Field::Double(-2.5)]);
        assert_eq!(rows[1], [text("P2"), Field::Null, Field::Null]);
    }
}
