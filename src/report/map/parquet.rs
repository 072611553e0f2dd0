//! The points of a map as Parquet: the columns of the table, exact, without compression.

use std::sync::Arc;

use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::{DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::distribution::{PoseSet, StiffnessMap};
use crate::robot::Robot;

use super::points::{point_heads, point_values};

/// The map as a Parquet file.
///
/// # Errors
/// [`ParquetError`] only if the writer refuses its own schema.
pub fn points_parquet(
    robot: &Robot,
    poses: &PoseSet,
    map: &StiffnessMap,
) -> Result<Vec<u8>, ParquetError> {
    let heads = point_heads(robot, poses, &map.columns);
    let fields = heads.iter().enumerate().map(|(place, head)| {
        let kind = if place == 0 {
            Physical::INT64
        } else {
            Physical::DOUBLE
        };
        let field = Type::primitive_type_builder(head, kind);
        Ok(Arc::new(
            field.with_repetition(Repetition::REQUIRED).build()?,
        ))
    });
    let fields = fields.collect::<Result<Vec<_>, ParquetError>>()?;
    let schema = Arc::new(
        Type::group_type_builder("map")
            .with_fields(fields)
            .build()?,
    );
    let properties = Arc::new(WriterProperties::builder().build());
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, properties)?;
    let mut group = writer.next_row_group()?;
    let mut place = 0;
    while let Some(mut column) = group.next_column()? {
        if place == 0 {
            let ids = map
                .places
                .iter()
                .map(|&place| poses.ids[place as usize] as i64);
            let ids: Vec<i64> = ids.collect();
            column.typed::<Int64Type>().write_batch(&ids, None, None)?;
        } else {
            let values =
                (0..map.len()).filter_map(|row| point_values(poses, map, row).nth(place - 1));
            let values: Vec<f64> = values.collect();
            column
                .typed::<DoubleType>()
                .write_batch(&values, None, None)?;
        }
        column.close()?;
        place += 1;
    }
    group.close()?;
    writer.into_inner()
}
