//! Readings of several displacement gauges as readings of one component each: what analyses work on.

use std::collections::HashMap;

use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::{Cell, Direction, PoseId};

use super::column::Column;
use super::joint_values::{JointColumn, PoseJoints};
use super::reading::{Reading, ReadingText};
use super::table::{ReadingTable, RunKey};
use super::vector_reading::{VectorReading, largest_load};
use super::vector_table::VectorTable;
use stiffbench_numeric::vector::dot;

/// What readings of one pose and direction of load are told by.
type SeriesKey<'t> = (&'t PoseId, &'t str);

impl ReadingTable {
    /// A reading for each gauge that was read: its displacement, and the amount of the load along its direction. The readings of one load share
    /// [`Reading::seq`] and [`Reading::run`]; each gauge has its own zero.
    ///
    /// The direction of a series is that of its largest load.
    #[must_use]
    pub fn of_vectors(vectors: &VectorTable) -> Self {
        let mut table = Self {
            source: vectors.source.clone(),
            origin: vectors.origin.clone(),
            columns: columns(vectors),
            pose_joints: pose_joints(vectors),
            ..Self::default()
        };
        let mut series: HashMap<SeriesKey<'_>, Vec<&VectorReading>> = HashMap::new();
        for reading in &vectors.readings {
            let key = (&reading.pose, reading.direction.as_str());
            series.entry(key).or_default().push(reading);
        }
        let loads: HashMap<SeriesKey<'_>, LoadDirection> = series
            .into_iter()
            .filter_map(|(key, readings)| Some((key, load_direction(key.1, &readings)?)))
            .collect();
        let mut runs: HashMap<(SeriesKey<'_>, &str), u32> = HashMap::new();
        let mut zeros: HashMap<(SeriesKey<'_>, &str, Direction), u32> = HashMap::new();
        for reading in &vectors.readings {
            let key = (&reading.pose, reading.direction.as_str());
            let Some(load) = loads.get(&key) else {
                continue;
            };
            for axis in Direction::ALL {
                let Some(displacement_m) = reading.displacement_m[axis.index()] else {
                    continue;
                };
                let named = |label: &str| RunKey {
                    pose: reading.pose.clone(),
                    direction: axis,
                    repeat: reading.repeat,
                    label: Some(label.into()),
                };
                let run = *runs.entry((key, &reading.run)).or_insert_with(|| {
                    table.runs.push(named(&reading.run));
                    table.runs.len() as u32 - 1
                });
                let zero = *zeros.entry((key, &reading.zero, axis)).or_insert_with(|| {
                    table.zeros.push(named(&reading.zero));
                    table.zeros.len() as u32 - 1
                });
                let load = (*load != axis).then(|| table.place_of(load));
                let force_n = dot(reading.force_n, loads[&key].unit_vector());
                table.readings.push(component(
                    reading,
                    (axis, displacement_m),
                    (load, force_n),
                    [run, zero],
                ));
            }
        }
        table.take_stock();
        table
    }

    /// Whether each load was read by one gauge, along the load.
    #[must_use]
    pub fn is_of_one_gauge(&self) -> bool {
        let at_once = self
            .readings
            .windows(2)
            .any(|pair| pair[0].seq == pair[1].seq);
        self.load_directions.is_empty() && !at_once
    }

    /// The cell of a reading.
    #[must_use]
    pub fn cell(&self, reading: &Reading) -> Cell {
        let other = reading.load.map(|_| self.load_direction(reading).called());
        Cell {
            load: other,
            ..reading.cell()
        }
    }

    /// The direction of the load of a reading.
    #[must_use]
    pub fn load_direction(&self, reading: &Reading) -> LoadDirection {
        let other = reading.load.map(usize::from);
        let other = other.and_then(|place| self.load_directions.get(place));
        other.cloned().unwrap_or(reading.direction.into())
    }

    /// The place of a direction among those of loads that are not along the displacement.
    pub fn place_of(&mut self, load: &LoadDirection) -> u16 {
        let known = self.load_directions.iter().position(|known| known == load);
        let place = known.unwrap_or_else(|| {
            self.load_directions.push(load.clone());
            self.load_directions.len() - 1
        });
        u16::try_from(place).unwrap_or(u16::MAX)
    }
}

impl VectorTable {
    /// The readings of each load together again, as [`ReadingTable::of_vectors`] took them apart; of one gauge those along its load.
    ///
    /// # Panics
    /// If a reading's run or zero is not in the table's lists.
    #[must_use]
    pub fn of_components(table: &ReadingTable) -> Self {
        let mut joints: Vec<JointColumn> = Vec::new();
        for (column, _) in table.pose_joints.iter().flat_map(|pose| &pose.values) {
            if !joints.contains(column) {
                joints.push(column.clone());
            }
        }
        let loads = table.readings.chunk_by(|a, b| a.seq == b.seq);
        Self {
            source: table.source.clone(),
            origin: table.origin.clone(),
            readings: loads
                .map(|components| together(table, &joints, components))
                .collect(),
            joints,
            ..Self::default()
        }
    }
}

/// The readings of one load as one.
fn together(table: &ReadingTable, joints: &[JointColumn], components: &[Reading]) -> VectorReading {
    let first = &components[0];
    let load = table.load_direction(first);
    let label = |key: &RunKey| match &key.label {
        Some(label) => label.to_string(),
        None => key.repeat.to_string(),
    };
    let stated = table.pose_joints.iter();
    let stated = stated.filter(|stated| stated.pose == first.pose);
    let stated: Vec<&(JointColumn, f64)> = stated.flat_map(|stated| &stated.values).collect();
    let value = |joint: &JointColumn| Some(stated.iter().find(|(of, _)| of == joint)?.1);
    let none = ReadingText::default();
    let texts = Direction::ALL.map(|axis| {
        let mut read = components.iter();
        let read = read.find(|reading| reading.direction == axis)?;
        Some((read.displacement_m, read.text.as_deref().unwrap_or(&none)))
    });
    let text = first.text.as_deref().unwrap_or(&none);
    VectorReading {
        line: first.line,
        seq: first.seq,
        pose: first.pose.clone(),
        direction: load.to_string(),
        branch: first.branch,
        step: first.step,
        repeat: first.repeat,
        attempt: first.attempt,
        status: first.status,
        target_n: first.target_n,
        joints: joints.iter().map(value).collect(),
        // Without a minus in front of zero.
        force_n: load.unit_vector().map(|part| part * first.force_n + 0.0),
        displacement_m: texts.map(|read| Some(read?.0)),
        run: label(&table.runs[first.run as usize]),
        zero: label(&table.zeros[first.zero as usize]),
        time_s: first.time_s,
        hold_s: first.hold_s,
        temperature_deg_c: first.temperature_deg_c,
        utc: text.utc.to_string(),
        force_raw: text.force_raw.to_string(),
        force_zero_n: text.zero_si[0],
        displacement_raw: texts.map(|read| {
            read.map_or_else(String::new, |(_, text)| text.displacement_raw.to_string())
        }),
        displacement_zero_m: texts.map(|read| read?.1.zero_si[1]),
        flag: text.flag.to_string(),
        note: text.note.to_string(),
    }
}

/// The direction along which the loads of a series count, under its name; `None` without a load.
fn load_direction(name: &str, readings: &[&VectorReading]) -> Option<LoadDirection> {
    let (_, unit) = largest_load(readings)?;
    let direction = LoadDirection::from_vector(unit).ok()?;
    Some(match direction.axis() {
        Some(_) => direction,
        None if direction.called().as_str() == name => direction,
        None => direction.named(name),
    })
}

/// The joint values of each pose, by its first reading that has all of them.
fn pose_joints(vectors: &VectorTable) -> Vec<PoseJoints> {
    let mut poses: Vec<PoseJoints> = Vec::new();
    if vectors.joints.is_empty() {
        return poses;
    }
    for reading in &vectors.readings {
        let stated: Option<Vec<f64>> = reading.joints.iter().copied().collect();
        let is_new = poses.iter().all(|known| known.pose != reading.pose);
        if let Some(stated) = stated.filter(|_| is_new) {
            poses.push(PoseJoints {
                pose: reading.pose.clone(),
                values: vectors.joints.iter().cloned().zip(stated).collect(),
            });
        }
    }
    poses
}

/// The columns of one gauge that a table of several stands for.
fn columns(vectors: &VectorTable) -> Vec<Column> {
    let any = |known: fn(&VectorReading) -> bool| vectors.readings.iter().any(known);
    let recorded = [
        (Column::Time, any(|reading| reading.time_s.is_some())),
        (Column::Hold, any(|reading| reading.hold_s.is_some())),
        (
            Column::Temperature,
            any(|reading| reading.temperature_deg_c.is_some()),
        ),
    ];
    let recorded = recorded.into_iter().filter(|(_, is_there)| *is_there);
    let always = [
        Column::Seq,
        Column::Pose,
        Column::Direction,
        Column::Branch,
        Column::Step,
        Column::Target,
        Column::Repeat,
        Column::Run,
        Column::Zero,
        Column::Force,
        Column::Displacement,
    ];
    always
        .into_iter()
        .chain(recorded.map(|(column, _)| column))
        .collect()
}

fn component(
    of: &VectorReading,
    (direction, displacement_m): (Direction, f64),
    (load, force_n): (Option<u16>, f64),
    [run, zero]: [u32; 2],
) -> Reading {
    let axis = direction.index();
    Reading {
        line: of.line,
        seq: of.seq,
        pose: of.pose.clone(),
        direction,
        load,
        branch: of.branch,
        step: of.step,
        repeat: of.repeat,
        attempt: of.attempt,
        run,
        zero,
        status: of.status,
        target_n: of.target_n,
        force_n,
        displacement_m,
        time_s: of.time_s,
        hold_s: of.hold_s,
        temperature_deg_c: of.temperature_deg_c,
        text: Some(Box::new(ReadingText {
            utc: of.utc.as_str().into(),
            force_raw: of.force_raw.as_str().into(),
            displacement_raw: of.displacement_raw[axis].as_str().into(),
            zero_si: [of.force_zero_n, of.displacement_zero_m[axis]],
            flag: of.flag.as_str().into(),
            note: of.note.as_str().into(),
        })),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::readings::{ReadingStatus, VectorReading};
    use stiffbench_units_and_text::test_point::Branch;

    /// A reading under a load of `target_n` along a direction, with displacements along x, y, z in µm.
    fn reading(
        seq: u32,
        (direction, unit): (&str, [f64; 3]),
        target_n: f64,
        displacement_um: [Option<f64>; 3],
    ) -> VectorReading {
        VectorReading {
            line: seq + 1,
            seq,
            pose: PoseId::new("P1"),
            direction: direction.to_owned(),
            branch: Branch::Loading,
            step: seq,
            repeat: 1,
            attempt: 1,
            status: ReadingStatus::Accepted,
            target_n,
            joints: Vec::new(),
            force_n: unit.map(|part| part * target_n),
            displacement_m: displacement_um.map(|um| um.map(|um| 1e-6 * um)),
            run: "1".to_owned(),
            zero: "1".to_owned(),
            time_s: Some(10.0 * f64::from(seq)),
            hold_s: None,
            temperature_deg_c: None,
            utc: String::new(),
            force_raw: String::new(),
            force_zero_n: None,
            displacement_raw: <[String; 3]>::default(),
            displacement_zero_m: [None; 3],
            flag: String::new(),
            note: String::new(),
        }
    }

    fn of(readings: Vec<VectorReading>) -> ReadingTable {
        ReadingTable::of_vectors(&VectorTable {
            readings,
            ..VectorTable::default()
        })
    }

    #[test]
    fn each_gauge_has_its_reading_its_zero_and_the_amount_of_the_load() {
        let oblique = ("oblique", [0.6, 0.0, 0.8]);
        let table = of(vec![
            reading(1, oblique, 0.0, [Some(0.0), None, Some(0.0)]),
            reading(2, oblique, -10.0, [Some(-3.0), None, Some(5.0)]),
        ]);
        assert!(!table.is_of_one_gauge());
        let cells: Vec<String> = table
            .readings
            .iter()
            .map(|one| table.cell(one).to_string())
            .collect();
        assert_eq!(
            cells,
            ["P1 x under oblique", "P1 z under oblique"].repeat(2)
        );
        let [_, _, x, z] = &table.readings[..] else {
            panic!("{table:?}")
        };
        assert_eq!(
            (x.seq, z.seq, x.run == z.run, x.zero == z.zero),
            (2, 2, true, false)
        );
        assert!((x.force_n + 10.0).abs() < 1e-12 && (x.displacement_m + 3e-6).abs() < 1e-18);
        assert!((z.displacement_m - 5e-6).abs() < 1e-18);
        let load = table.load_direction(x);
        assert!((load.along(Direction::Z) - 0.8).abs() < 1e-12, "{load:?}");
    }

    #[test]
    fn a_gauge_along_the_load_is_that_of_a_session_with_one() {
        let axes = [("y", [0.0, 1.0, 0.0]), ("z", [0.0, 0.0, 1.0])];
        let table = of(vec![
            reading(1, axes[0], -10.0, [None, Some(-3.0), None]),
            reading(2, axes[1], -20.0, [None, None, Some(-4.0)]),
        ]);
        assert!(table.is_of_one_gauge());
        let directions: Vec<Direction> = table.readings.iter().map(|one| one.direction).collect();
        assert_eq!(directions, [Direction::Y, Direction::Z]);
        assert!(table.readings.iter().all(|one| one.load.is_none()));
        assert_eq!(table.readings[1].force_n, -20.0);
        // Without a load there is no direction, and nothing to say.
        assert!(
            of(vec![reading(1, axes[0], 0.0, [None, Some(0.0), None])])
                .readings
                .is_empty()
        );
    }
}
