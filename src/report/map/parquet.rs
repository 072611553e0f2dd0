//! The points of a map as Parquet: the columns of the table, exact, without compression.

use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::{DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::schema::types::Type;

use crate::distribution::{PoseSample, StiffnessMap};
use crate::export::tidy::write_parquet;
use crate::robot::Robot;

use super::points::{point_heads, point_values};

/// The map as a Parquet file.
///
/// # Errors
/// [`ParquetError`] only if the writer refuses its own schema.
pub fn points_parquet(
    robot: &Robot,
    poses: &PoseSample,
    map: &StiffnessMap,
) -> Result<Vec<u8>, ParquetError> {
    let heads = point_heads(robot, poses, map);
    let fields = heads.iter().enumerate().map(|(place, head)| {
        let kind = if place == 0 {
            Physical::INT64
        } else {
            Physical::DOUBLE
        };
        let field = Type::primitive_type_builder(head, kind);
        field.with_repetition(Repetition::REQUIRED).build()
    });
    write_parquet("map", fields, None, |place, column| {
        if place == 0 {
            let ids = map
                .places
                .iter()
                .map(|&place| poses.ids[place as usize] as i64);
            let ids: Vec<i64> = ids.collect();
            column.typed::<Int64Type>().write_batch(&ids, None, None)
        } else {
            let values =
                (0..map.len()).filter_map(|row| point_values(poses, map, row).nth(place - 1));
            let values: Vec<f64> = values.collect();
            column
                .typed::<DoubleType>()
                .write_batch(&values, None, None)
        }
    })
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    use super::*;
    use crate::distribution::{MapColumn, MapModel, MatrixKind, PosePlan, Sampling, Shard};
    use crate::physics::ActingPhysics;
    use crate::report::points_csv;
    use crate::shipped::shipped_robot;

    #[test]
    fn a_reader_finds_every_number_of_the_table() {
        let robot = Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap();
        let physics = ActingPhysics::new(&robot, robot.mechanism(None).unwrap(), Vec::new());
        let (physics, factors) = (physics.unwrap(), robot.default_factors().1);
        let plan = PosePlan {
            sampling: Sampling::MonteCarlo,
            poses: 70,
            seed: 3,
            held: Vec::new(),
        };
        let poses = PoseSample::draw(&robot, &plan, Shard::WHOLE).unwrap();
        let model = MapModel::new(&robot, &physics, &factors, None).unwrap();
        let mut columns = MapColumn::axes();
        columns.extend(MapColumn::along("0,1,1", [0.0, 1.0, 1.0]));
        columns.extend(MapColumn::principal());
        let matrix = Some(MatrixKind::Stiffness);
        let map = StiffnessMap::with_matrix(&model, &poses, &columns, matrix).unwrap();

        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&points_parquet(&robot, &poses, &map).unwrap())
            .unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let table = points_csv(&robot, &poses, &map);
        let mut lines = table.lines();
        let heads: Vec<&str> = lines.next().unwrap().split(',').collect();
        let mut count = 0;
        for (row, line) in reader.get_row_iter(None).unwrap().zip(lines.by_ref()) {
            let row = row.unwrap();
            let fields: Vec<_> = row.get_column_iter().collect();
            assert_eq!(fields.len(), heads.len());
            for (((name, field), head), text) in fields.iter().zip(&heads).zip(line.split(',')) {
                assert_eq!(name, head);
                match field {
                    Field::Long(id) => assert_eq!(*id, text.parse::<i64>().unwrap()),
                    Field::Double(value) => assert_eq!(*value, text.parse::<f64>().unwrap()),
                    other => panic!("{name}: {other:?}"),
                }
            }
            count += 1;
        }
        assert_eq!((count, lines.next()), (70, None));
    }
}
