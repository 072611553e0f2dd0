//! Reads `readings.csv` of sessions with displacement gauges along the base axes (`stiffbench/session/2`): a reading for each gauge.

use std::collections::HashMap;
use std::io::Read;

use indexmap::IndexMap;

use super::column::{Column, split_unit};
use super::error::TableError;
use super::joint_values::{PlacedJointColumn, PoseJoints};
use super::number::Conversion;
use super::reading::{Reading, ReadingStatus, ReadingText};
use super::table::{FieldRow, FileFields, ReadingTable, RunKey};
use super::text_table::{ReadOptions, RecordTable};
use stiffbench_numeric::vector::dot;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::quantity::Kind;
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};

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
    let names = RecordTable::names_of(bytes);
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
///
/// # Errors
/// [`TableError`] with line, column, value and what was expected, for the first thing that is wrong.
pub fn read_vector_readings(source: &str, input: impl Read) -> Result<ReadingTable, TableError> {
    let mut text = RecordTable::open(source, input, ReadOptions::default())?;
    text.next_header()?;
    for column in NEEDED {
        if !text.names.iter().any(|name| name == column) {
            let advice =
                "take the readings.csv of a session with displacement gauges along base axes";
            return Err(text.missing_columns(vec![column.to_owned()], advice.to_owned()));
        }
    }
    let mut table = ReadingTable {
        source: source.to_owned(),
        fields: FileFields {
            names: text.names.clone(),
            rows: Vec::new(),
        },
        ..ReadingTable::default()
    };
    let joints = joint_columns(&text)?;
    let is_other = |name: &&String| OTHER_KINDS.iter().any(|kind| name.starts_with(kind));
    let others: Vec<String> = text.names.iter().filter(is_other).cloned().collect();
    let mut loads = Vec::new();
    while text.next_record()? {
        let mut row = VectorRow {
            text: &mut text,
            joints: &joints,
        };
        let load = row.load()?;
        for column in &others {
            let value = row.text_of(column);
            if !value.is_empty() && value.parse() != Ok(0.0) {
                let expected = "no value: moments and rotations belong to a table of load cases";
                return Err(row.bad(column, expected));
            }
        }
        table.origin = table
            .origin
            .or_else(|| Some(row.text_of("origin")).filter(|of| !of.is_empty()));
        let fields = (0..text.names.len()).map(|at| text.text(text.field(at)).into_owned());
        table.fields.rows.push(FieldRow {
            line: text.line,
            seq: load.common.seq,
            fields: fields.collect(),
        });
        table.add_joints(&load, &joints);
        loads.push(load);
    }
    if loads.is_empty() {
        return Err(text.no_readings());
    }
    table.columns = columns(&loads);
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

/// The columns of one gauge that a table of several stands for.
fn columns(loads: &[LoadRow]) -> Vec<Column> {
    let any = |known: fn(&Reading) -> bool| loads.iter().any(|load| known(&load.common));
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

/// The current record.
struct VectorRow<'t, 'a> {
    text: &'t mut RecordTable<'a>,
    joints: &'t [PlacedJointColumn],
}

impl VectorRow<'_, '_> {
    fn load(&mut self) -> Result<LoadRow, TableError> {
        let mut force_n = [0.0; 3];
        for (part, column) in force_n.iter_mut().zip(FORCES) {
            *part = self
                .number(column, Conversion::NONE)?
                .ok_or_else(|| self.text.missing(column, "a number"))?;
        }
        let axes = self.text_of("axes");
        if !matches!(axes.as_str(), "" | BASE_AXES) {
            return Err(self.bad("axes", "`base`"));
        }
        let displacement_m = self.micrometres(DISPLACEMENTS.map(|[value, ..]| value))?;
        if displacement_m == [None; 3] {
            let [[column, ..], ..] = DISPLACEMENTS;
            return Err(self.text.missing(column, "a displacement along x, y or z"));
        }
        let zero_m = self.micrometres(DISPLACEMENTS.map(|[.., zero]| zero))?;
        let mut joints = Vec::with_capacity(self.joints.len());
        for joint in self.joints {
            let value = self.text.number(joint.index, joint.conversion)?;
            joints.push(value);
        }
        let pose = self.text_of("pose");
        if pose.is_empty() {
            return Err(self.text.missing("pose", "the name of a pose"));
        }
        let common = Reading {
            line: self.text.line,
            seq: self.count("seq")?,
            pose: PoseId::new(&pose),
            direction: Direction::X,
            load: None,
            branch: match self.index("branch") {
                Some(index) => self.text.branch(index)?,
                None => Branch::Loading,
            },
            step: self.count("step")?,
            repeat: self.count("repeat")?,
            attempt: self.count("attempt")?,
            run: 0,
            zero: 0,
            status: match self.index("status") {
                Some(index) => self.text.status(index)?,
                None => ReadingStatus::Accepted,
            },
            target_n: self.number("target_N", Conversion::NONE)?.unwrap_or(0.0),
            force_n: 0.0,
            displacement_m: 0.0,
            time_s: self.number("t_s", Conversion::NONE)?,
            hold_s: self.number("hold_s", Conversion::NONE)?,
            temperature_deg_c: self.number("temp_degC", Conversion::NONE)?,
            text: None,
        };
        let force_zero_n = self.number("force_zero_N", Conversion::NONE)?;
        let text = |axis: usize| ReadingText {
            utc: self.text_of("utc").into(),
            force_raw: self.text_of("force_raw").into(),
            displacement_raw: self.text_of(DISPLACEMENTS[axis][1]).into(),
            zero_si: [force_zero_n, zero_m[axis]],
            flag: self.text_of("flag").into(),
            note: self.text_of("note").into(),
        };
        let read = Direction::ALL.into_iter().filter_map(|axis| {
            let displacement_m = displacement_m[axis.index()]?;
            Some((axis, displacement_m, text(axis.index())))
        });
        Ok(LoadRow {
            gauges: read.collect(),
            common,
            direction: self.text_of("direction"),
            force_n,
            run: self.text_of("run"),
            zero: self.text_of("zero_id"),
            joints,
        })
    }

    /// Displacements in SI, one of each column.
    fn micrometres(&mut self, columns: [&str; 3]) -> Result<[Option<f64>; 3], TableError> {
        let um = Conversion::from_unit(Kind::Displacement, "um").unwrap_or(Conversion::NONE);
        let mut parts = [None; 3];
        for (part, column) in parts.iter_mut().zip(columns) {
            *part = self.number(column, um)?;
        }
        Ok(parts)
    }

    fn index(&self, column: &str) -> Option<usize> {
        self.text.names.iter().position(|name| name == column)
    }

    /// A field without blanks around it; empty without the column.
    fn text_of(&self, column: &str) -> String {
        let index = self.index(column);
        index.map_or_else(String::new, |at| {
            self.text.text(self.text.field(at)).into_owned()
        })
    }

    fn number(&mut self, column: &str, conversion: Conversion) -> Result<Option<f64>, TableError> {
        let index = self.index(column);
        index.map_or(Ok(None), |index| self.text.number(index, conversion))
    }

    /// A whole number; 1 without a column or value, as one reading of a table by hand is the first of its kind.
    fn count(&self, column: &str) -> Result<u32, TableError> {
        let index = self.index(column);
        let count = index.map_or(Ok(None), |index| self.text.count(index, 0))?;
        Ok(count.unwrap_or(1))
    }

    fn bad(&self, column: &str, expected: &'static str) -> TableError {
        let value = self.text_of(column);
        self.text.bad(column, value.as_bytes(), expected)
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
        read_vector_readings("readings.csv", text.as_bytes()).unwrap()
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
