//! Readings of several displacement gauges as readings of one component each: what analyses work on.

use std::collections::HashMap;

use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::column::Column;
use super::joint_values::PoseJoints;
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

    /// The direction of the load of a reading.
    #[must_use]
    pub fn load_direction(&self, reading: &Reading) -> LoadDirection {
        let other = reading.load.map(usize::from);
        let other = other.and_then(|place| self.load_directions.get(place));
        other.cloned().unwrap_or(reading.direction.into())
    }

    /// The place of a direction among those of loads.
    fn place_of(&mut self, load: &LoadDirection) -> u16 {
        let known = self.load_directions.iter().position(|known| known == load);
        let place = known.unwrap_or_else(|| {
            self.load_directions.push(load.clone());
            self.load_directions.len() - 1
        });
        u16::try_from(place).unwrap_or(u16::MAX)
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
