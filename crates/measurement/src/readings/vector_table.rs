//! Reads `readings.csv` of sessions with displacement gauges along the base axes (`stiffbench/session/2`): a reading for each gauge.

use std::collections::HashMap;

use indexmap::IndexMap;

use super::column::{Column, split_unit};
use super::error::TableError;
use super::header::ColumnHeader;
use super::joint_values::{PlacedJointColumn, PoseJoints};
use super::number::Conversion;
use super::reading::{Reading, ReadingText};
use super::row::RowReader;
use super::table::{FieldRow, FileFields, ReadingTable, RunKey};
use super::text_table::RecordTable;
use stiffbench_numeric::vector::dot;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::quantity::Kind;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

/// Columns without which a table is none of a session with gauges along the base axes.
const NEEDED: [&str; 11] = [
    "seq",
    "pose",
    "direction",
    "branch",
    "step",
    "repeat",
    "run",
    "zero_id",
    FORCES[0],
    FORCES[1],
    FORCES[2],
];

/// Columns of the force along x, y, z.
pub(super) const FORCES: [&str; 3] = ["force_x_N", "force_y_N", "force_z_N"];

/// Columns of the displacements along x, y, z, of which at least one has values, each with the gauge's own text and zero.
pub(super) const DISPLACEMENTS: [[&str; 3]; 3] = [
    [
        "displacement_x_um",
        "displacement_x_raw",
        "displacement_x_zero_um",
    ],
    [
        "displacement_y_um",
        "displacement_y_raw",
        "displacement_y_zero_um",
    ],
    [
        "displacement_z_um",
        "displacement_z_raw",
        "displacement_z_zero_um",
    ],
];

/// How columns begin that a session does not have: left out in silence their loads would be none.
const OTHER_KINDS: [&str; 2] = ["moment_", "rotation_"];

/// Axes of all components.
pub(super) const BASE_AXES: &str = "base";

/// Whether a table has the columns of a session with gauges along the base axes; a text that is no table has not.
#[must_use]
pub fn is_vector_table(bytes: &[u8]) -> bool {
    are_of_vectors(&RecordTable::names_of(bytes))
}

/// The same by the names of its columns.
pub(super) fn are_of_vectors(names: &[String]) -> bool {
    let mut needed = NEEDED.iter();
    needed.all(|needed| names.iter().any(|name| name == needed))
}

/// Whether the first record of a text is that of readings of one gauge, or of a list of stiffness values.
#[must_use]
pub fn is_readings_header(bytes: &[u8]) -> bool {
    let names = RecordTable::names_of(bytes);
    let has = |wanted: &str| names.iter().any(|name| name == wanted);
    has("direction") && (has("force_N") || has("stiffness_N_per_um"))
}

/// Reads a table with a row for each load, as [`super::write_rows`] writes it along the base axes.
///
/// Each gauge has its reading: its displacement, and the amount of the load along its direction, that of the largest load of its pose and
/// name. The readings of one load share [`Reading::seq`] and [`Reading::run`]; each gauge has its own zero.
pub(super) fn read_vectors(mut text: RecordTable<'_>) -> Result<ReadingTable, TableError> {
    let (header, _) = ColumnHeader::find(&text)?;
    let columns = VectorColumns::find(&text)?;
    let mut reader = RowReader::new(&header);
    let mut table = ReadingTable {
        source: text.file(),
        fields: FileFields {
            names: text.names.clone(),
            rows: Vec::new(),
        },
        ..ReadingTable::default()
    };
    let mut loads = Vec::new();
    while text.next_record()? {
        let load = columns.load(&mut reader, &mut text)?;
        let fields = (0..text.names.len()).map(|at| text.text(text.field(at)).into_owned());
        table.fields.rows.push(FieldRow {
            line: text.line,
            seq: load.common.seq,
            fields: fields.collect(),
        });
        table.add_joints(&load, &columns.joints);
        loads.push(load);
    }
    if loads.is_empty() {
        return Err(text.no_readings());
    }
    table.origin = reader.origin;
    table.add_loads(loads);
    table.take_stock();
    Ok(table)
}

/// A row, before the direction of its load is known.
struct LoadRow {
    /// What its readings have in common.
    common: Reading,
    /// Displacement, m, text and zero of each gauge.
    gauges: Vec<(Direction, f64, ReadingText)>,
    /// Name of the direction of the load.
    direction: String,
    /// Along the base axes, N.
    force_n: [f64; 3],
    run: String,
    zero: String,
    /// Of each joint column, rad or m.
    joints: Vec<Option<f64>>,
}

impl LoadRow {
    fn force_size_n(&self) -> f64 {
        let [x, y, z] = self.force_n;
        x.hypot(y).hypot(z)
    }

    /// The direction along which the loads of its series count, if it is the largest of them, under its name; `None` without a load.
    fn load_direction(&self) -> Option<LoadDirection> {
        let largest_n = self.force_size_n();
        let sense = if self.common.target_n < 0.0 {
            -1.0
        } else {
            1.0
        };
        let unit = self.force_n.map(|part| sense * part / largest_n);
        let direction = LoadDirection::from_vector(unit).ok()?;
        let is_called_so = direction.called().as_str() == self.direction;
        Some(if direction.axis().is_some() || is_called_so {
            direction
        } else {
            direction.named(&self.direction)
        })
    }
}

impl ReadingTable {
    /// The joint values of a pose, by its first reading that has all of them.
    fn add_joints(&mut self, load: &LoadRow, columns: &[PlacedJointColumn]) {
        let pose = &load.common.pose;
        let is_new = self.pose_joints.iter().all(|known| known.pose != *pose);
        let values: Option<Vec<f64>> = load.joints.iter().copied().collect();
        if let Some(values) = values.filter(|values| is_new && !values.is_empty()) {
            let columns = columns.iter().map(|column| column.column.clone());
            self.pose_joints.push(PoseJoints {
                pose: pose.clone(),
                values: columns.zip(values).collect(),
            });
        }
    }

    /// Adds the readings of all loads.
    fn add_loads(&mut self, loads: Vec<LoadRow>) {
        // The largest load of each pose and direction.
        let mut series: IndexMap<(&PoseId, &str), &LoadRow> = IndexMap::new();
        let mut places = Vec::with_capacity(loads.len());
        for load in &loads {
            let entry = series.entry((&load.common.pose, load.direction.as_str()));
            places.push(entry.index());
            let largest = entry.or_insert(load);
            if load.force_size_n() >= largest.force_size_n() {
                *largest = load;
            }
        }
        let directions: Vec<_> = series.values().map(|load| load.load_direction()).collect();
        let mut runs: HashMap<(usize, String), u32> = HashMap::new();
        let mut zeros: HashMap<(usize, String, Direction), u32> = HashMap::new();
        for (load, series) in loads.into_iter().zip(places) {
            let Some(along) = &directions[series] else {
                let mut texts = load.gauges.into_iter().map(|(.., text)| Box::new(text));
                self.unloaded.push(Reading {
                    text: texts.next(),
                    ..load.common
                });
                continue;
            };
            let force_n = dot(load.force_n, along.unit_vector());
            for (direction, displacement_m, text) in load.gauges {
                let key = |label: &str| RunKey {
                    pose: load.common.pose.clone(),
                    direction,
                    repeat: load.common.repeat,
                    label: Some(label.into()),
                };
                let run = *runs.entry((series, load.run.clone())).or_insert_with(|| {
                    self.runs.push(key(&load.run));
                    self.load_names.push(load.direction.clone());
                    self.runs.len() as u32 - 1
                });
                let zero = (series, load.zero.clone(), direction);
                let zero = *zeros.entry(zero).or_insert_with(|| {
                    self.zeros.push(key(&load.zero));
                    self.zeros.len() as u32 - 1
                });
                let other = (*along != direction).then(|| self.place_of(along));
                self.readings.push(Reading {
                    direction,
                    load: other,
                    run,
                    zero,
                    force_n,
                    displacement_m,
                    text: Some(Box::new(text)),
                    ..load.common.clone()
                });
            }
        }
    }
}

/// The columns `joint_VARIABLE_UNIT`.
fn joint_columns(text: &RecordTable<'_>) -> Result<Vec<PlacedJointColumn>, TableError> {
    let mut columns = Vec::new();
    for (index, name) in text.names.iter().enumerate() {
        let Some(named) = name.strip_prefix("joint_") else {
            continue;
        };
        let (variable, unit) =
            split_unit(named).map_or((named, None), |(stem, unit)| (stem, Some(unit)));
        PlacedJointColumn::add(&mut columns, text, index, variable, unit)?;
    }
    Ok(columns)
}

/// Where the columns are that a table along one load does not have.
struct VectorColumns {
    forces: [usize; 3],
    /// Displacement, text and zero of each gauge.
    gauges: [[Option<usize>; 3]; 3],
    axes: Option<usize>,
    joints: Vec<PlacedJointColumn>,
    /// See [`OTHER_KINDS`].
    others: Vec<usize>,
}

impl VectorColumns {
    fn find(text: &RecordTable<'_>) -> Result<Self, TableError> {
        let place = |name: &str| text.names.iter().position(|known| known == name);
        let is_other = |index: &usize| {
            let name = &text.names[*index];
            OTHER_KINDS.iter().any(|kind| name.starts_with(kind))
        };
        Ok(Self {
            forces: FORCES.map(|name| place(name).unwrap_or_default()),
            gauges: DISPLACEMENTS.map(|names| names.map(place)),
            axes: place("axes"),
            joints: joint_columns(text)?,
            others: (0..text.names.len()).filter(is_other).collect(),
        })
    }

    /// The current record.
    fn load(
        &self,
        reader: &mut RowReader<'_>,
        text: &mut RecordTable<'_>,
    ) -> Result<LoadRow, TableError> {
        let um = Conversion::from_unit(Kind::Displacement, "um").unwrap_or(Conversion::NONE);
        let mut force_n = [0.0; 3];
        for (part, index) in force_n.iter_mut().zip(self.forces) {
            let number = text.number(index, Conversion::NONE)?;
            *part = number.ok_or_else(|| text.missing(&text.names[index], "a number"))?;
        }
        let wrong =
            |index: usize, expected| text.bad(&text.names[index], text.field(index), expected);
        let is_base = |field: &[u8]| field.is_empty() || field == BASE_AXES.as_bytes();
        if let Some(axes) = self.axes.filter(|axes| !is_base(text.field(*axes))) {
            return Err(wrong(axes, "`base`"));
        }
        let is_none = |field: &[u8]| {
            let value = std::str::from_utf8(field).map(str::parse);
            field.is_empty() || value == Ok(Ok(0.0))
        };
        if let Some(other) = self.others.iter().find(|at| !is_none(text.field(**at))) {
            let expected = "no value: moments and rotations belong to a table of load cases";
            return Err(wrong(*other, expected));
        }
        let mut numbers = [[None; 2]; 3];
        for (numbers, [value, _, zero]) in numbers.iter_mut().zip(self.gauges) {
            for (number, index) in numbers.iter_mut().zip([value, zero]) {
                *number = index.map_or(Ok(None), |index| text.number(index, um))?;
            }
        }
        if numbers.iter().all(|[value, _]| value.is_none()) {
            let [[column, ..], ..] = DISPLACEMENTS;
            return Err(text.missing(column, "a displacement along x, y or z"));
        }
        let mut joints = Vec::with_capacity(self.joints.len());
        for joint in &self.joints {
            joints.push(text.number(joint.index, joint.conversion)?);
        }
        let pose = reader.pose(text)?;
        let repeat = reader.count(text, Column::Repeat)?.unwrap_or(1);
        let common = reader.common(text, pose, repeat)?;
        let of_load = reader.texts(text)?.unwrap_or_default();
        let gauges = Direction::ALL.into_iter().filter_map(|axis| {
            let [displacement_m, zero_m] = numbers[axis.index()];
            let raw = self.gauges[axis.index()][1].map_or(&[][..], |raw| text.raw(raw));
            let of_gauge = ReadingText {
                displacement_raw: text.text(raw).into(),
                zero_si: [of_load.zero_si[0], zero_m],
                ..(*of_load).clone()
            };
            Some((axis, displacement_m?, of_gauge))
        });
        Ok(LoadRow {
            gauges: gauges.collect(),
            force_n,
            direction: reader.text(text, Column::Direction).unwrap_or_default(),
            run: reader.text(text, Column::Run).unwrap_or_default(),
            zero: reader.text(text, Column::Zero).unwrap_or_default(),
            joints,
            common,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A table of rows `seq,direction,target_N,force_x_N,force_y_N,force_z_N,displacement_x_um,displacement_y_um,displacement_z_um`.
    fn of(rows: &[&str]) -> ReadingTable {
        let mut text = "pose,branch,step,repeat,run,zero_id,seq,direction,target_N,force_x_N,force_y_N,force_z_N,\
                        displacement_x_um,displacement_y_um,displacement_z_um\n"
            .to_owned();
        for row in rows {
            text.push_str("P1,loading,0,1,1,1,");
            text.push_str(row);
            text.push('\n');
        }
        crate::readings::read_readings("readings.csv", text.as_bytes()).unwrap()
    }

    #[test]
    fn each_gauge_has_its_reading_its_zero_and_the_amount_of_the_load() {
        let table = of(&["1,oblique,0,0,0,0,0,,0", "2,oblique,-10,-6,0,-8,-3,,5"]);
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
        let table = of(&["1,y,-10,0,-10,0,,-3,", "2,z,-20,0,0,-20,,,-4"]);
        assert!(table.is_of_one_gauge());
        let directions: Vec<Direction> = table.readings.iter().map(|one| one.direction).collect();
        assert_eq!(directions, [Direction::Y, Direction::Z]);
        assert!(table.readings.iter().all(|one| one.load.is_none()));
        assert_eq!(table.readings[1].force_n, -20.0);
        // Without a load there is no direction, and nothing to say; the reading is kept.
        let table = of(&["1,y,0,0,0,0,,0,"]);
        assert!(table.readings.is_empty() && table.runs.is_empty());
        assert_eq!(table.one_of_each_load().count(), 1);
        assert_eq!(table.fields.rows.len(), 1);
    }
}
