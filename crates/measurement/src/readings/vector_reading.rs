//! Readings whose force and displacement are vectors along the base axes, and the table of them: `readings.csv` of `stiffbench/session/2`.

use std::io::Write;

use super::error::ReadingsError;
use super::formula::keep_quote;
use super::joint_values::JointColumn;
use super::number::decimal;
use super::reading::ReadingStatus;
use super::write::{csv_writer, failed, refuse_not_finite};
use stiffbench_units_and_text::test_point::{Branch, PoseId};

/// One reading of up to three displacement gauges along the base axes.
#[derive(Debug, Clone, PartialEq)]
pub struct VectorReading {
    /// Line of the file, from 1; 0 if there is none.
    pub line: u32,
    /// Number in the session, from 1.
    pub seq: u32,
    /// The pose held.
    pub pose: PoseId,
    /// Name of the direction of the load.
    pub direction: String,
    /// Loading or unloading.
    pub branch: Branch,
    /// Place in the load sequence, from 0.
    pub step: u32,
    /// n-th application, from 1.
    pub repeat: u32,
    /// n-th try, from 1.
    pub attempt: u32,
    /// Whether it counts.
    pub status: ReadingStatus,
    /// Target along the load, N, signed.
    pub target_n: f64,
    /// Values of the joint columns of its table, rad or m; `None` where they are not stated.
    pub joints: Vec<Option<f64>>,
    /// Force along the base axes, N.
    pub force_n: [f64; 3],
    /// Displacement from the zero along the base axes, m; `None` along an axis without a gauge.
    pub displacement_m: [Option<f64>; 3],
    /// Label of its run.
    pub run: String,
    /// Label of its gauge zero.
    pub zero: String,
    /// Seconds since the session began.
    pub time_s: Option<f64>,
    /// Seconds under this load.
    pub hold_s: Option<f64>,
    /// Temperature, °C.
    pub temperature_deg_c: Option<f64>,
    /// When, UTC.
    pub utc: String,
    /// The force gauge's own text.
    pub force_raw: String,
    /// What the force gauge showed unloaded, N in the sign as sent.
    pub force_zero_n: Option<f64>,
    /// The displacement gauges' own texts.
    pub displacement_raw: [String; 3],
    /// What the displacement gauges showed at their zero, m in the sign as sent.
    pub displacement_zero_m: [Option<f64>; 3],
    /// Checks that it fails, separated by semicolons.
    pub flag: String,
    /// Anything else.
    pub note: String,
}

impl VectorReading {
    /// Size of the force, N.
    pub(crate) fn force_size_n(&self) -> f64 {
        let [x, y, z] = self.force_n;
        x.hypot(y).hypot(z)
    }
}

/// The reading with the largest force, and the direction of its load, along which loads count, against it below zero; `None` if all forces are zero.
pub(crate) fn largest_load<'r>(
    readings: &[&'r VectorReading],
) -> Option<(&'r VectorReading, [f64; 3])> {
    let largest = readings.iter().copied();
    let largest = largest.max_by(|a, b| a.force_size_n().total_cmp(&b.force_size_n()))?;
    let largest_n = largest.force_size_n();
    let sense = if largest.target_n < 0.0 { -1.0 } else { 1.0 };
    // Without a minus in front of zero.
    let unit = largest.force_n.map(|part| sense * part / largest_n + 0.0);
    (largest_n != 0.0).then_some((largest, unit))
}

/// Columns that hold the analyst's own marks; all others make the result.
pub const MARK_COLUMNS: [&str; 3] = ["status", "flag", "note"];

/// Columns before those of the joints, in the order in which they are written.
const COLUMNS_BEFORE_JOINTS: [&str; 13] = [
    "session",
    "seq",
    "utc",
    "t_s",
    "pose",
    "direction",
    "branch",
    "step",
    "target_N",
    "repeat",
    "attempt",
    "run",
    "zero_id",
];

/// Columns behind those of the joints; `origin` follows in readings that were not measured.
const COLUMNS_AFTER_JOINTS: [&str; 20] = [
    "axes",
    "force_x_N",
    "force_y_N",
    "force_z_N",
    "force_raw",
    "force_zero_N",
    "displacement_x_um",
    "displacement_x_raw",
    "displacement_x_zero_um",
    "displacement_y_um",
    "displacement_y_raw",
    "displacement_y_zero_um",
    "displacement_z_um",
    "displacement_z_raw",
    "displacement_z_zero_um",
    "hold_s",
    "temp_degC",
    "status",
    "flag",
    "note",
];

/// Axes of all components.
pub(super) const BASE_AXES: &str = "base";

/// Writes readings of vectors one by one, so that a session can add each as it is made.
///
/// Numbers are written with up to 15 significant digits, the instruments' own texts as they were; a component without a gauge is empty.
pub struct VectorReadingsWriter<W: Write> {
    output: csv::Writer<W>,
    session: String,
    origin: Option<String>,
    joints: Vec<JointColumn>,
}

impl<W: Write> VectorReadingsWriter<W> {
    /// Writes the header; `session` and `origin` go into every row. Readings that were measured have no origin and no such column.
    ///
    /// # Arguments
    /// - `joints`: the columns of joint values, those of [`VectorReading::joints`].
    ///
    /// # Errors
    /// [`ReadingsError::Write`] if the output fails.
    pub fn new(
        output: W,
        session: Option<&str>,
        origin: Option<&str>,
        joints: &[JointColumn],
    ) -> Result<Self, ReadingsError> {
        let mut writer = Self::continuing(output, session, origin, joints);
        let mut columns = COLUMNS_BEFORE_JOINTS.map(str::to_owned).to_vec();
        columns.extend(joints.iter().map(JointColumn::name));
        columns.extend(COLUMNS_AFTER_JOINTS.map(str::to_owned));
        columns.extend(origin.map(|_| "origin".to_owned()));
        writer.output.write_record(columns).map_err(failed)?;
        Ok(writer)
    }

    /// The same behind rows that are there already: no header is written.
    #[must_use]
    pub fn continuing(
        output: W,
        session: Option<&str>,
        origin: Option<&str>,
        joints: &[JointColumn],
    ) -> Self {
        Self {
            output: csv_writer(output),
            session: session.unwrap_or_default().to_owned(),
            origin: origin.map(str::to_owned),
            joints: joints.to_vec(),
        }
    }

    /// Writes one reading.
    ///
    /// # Errors
    /// [`ReadingsError::NotWritable`] for a number that is not finite, before anything of the row is written;
    /// [`ReadingsError::Write`] if the output fails.
    pub fn write(&mut self, reading: &VectorReading) -> Result<(), ReadingsError> {
        check_finite(reading)?;
        let mut row = vec![
            self.session.clone(),
            reading.seq.to_string(),
            reading.utc.clone(),
            optional(reading.time_s, 0),
            reading.pose.to_string(),
            reading.direction.clone(),
            reading.branch.to_string(),
            reading.step.to_string(),
            decimal(reading.target_n, 0),
            reading.repeat.to_string(),
            reading.attempt.to_string(),
            reading.run.clone(),
            reading.zero.clone(),
        ];
        for (place, joint) in self.joints.iter().enumerate() {
            let value = reading.joints.get(place).copied().flatten();
            row.push(value.map_or_else(String::new, |value| joint.unit.written(value)));
        }
        row.push(BASE_AXES.to_owned());
        row.extend(reading.force_n.map(|part| decimal(part, 0)));
        row.push(reading.force_raw.clone());
        row.push(optional(reading.force_zero_n, 0));
        for axis in 0..3 {
            row.push(optional(reading.displacement_m[axis], 6));
            row.push(reading.displacement_raw[axis].clone());
            row.push(optional(reading.displacement_zero_m[axis], 6));
        }
        row.push(optional(reading.hold_s, 0));
        row.push(optional(reading.temperature_deg_c, 0));
        row.push(reading.status.to_string());
        row.extend([reading.flag.clone(), reading.note.clone()]);
        row.extend(self.origin.clone());
        let row = row.iter().map(|text| keep_quote(text).into_owned());
        self.output.write_record(row).map_err(failed)
    }

    /// Hands everything written so far to the output.
    ///
    /// # Errors
    /// [`ReadingsError::Write`] if the output fails.
    pub fn flush(&mut self) -> Result<(), ReadingsError> {
        self.output.flush().map_err(|error| failed(error.into()))
    }
}

fn optional(value: Option<f64>, shift: i32) -> String {
    value.map_or_else(String::new, |value| decimal(value, shift))
}

fn check_finite(reading: &VectorReading) -> Result<(), ReadingsError> {
    let [force_x, force_y, force_z] = reading.force_n.map(Some);
    let [x, y, z] = reading.displacement_m;
    let [zero_x, zero_y, zero_z] = reading.displacement_zero_m;
    let joints = reading.joints.iter().map(|value| ("joint", *value));
    let numbers = [
        ("target_N", Some(reading.target_n)),
        ("force_x_N", force_x),
        ("force_y_N", force_y),
        ("force_z_N", force_z),
        ("force_zero_N", reading.force_zero_n),
        ("displacement_x_um", x),
        ("displacement_y_um", y),
        ("displacement_z_um", z),
        ("displacement_x_zero_um", zero_x),
        ("displacement_y_zero_um", zero_y),
        ("displacement_z_zero_um", zero_z),
        ("t_s", reading.time_s),
        ("hold_s", reading.hold_s),
        ("temp_degC", reading.temperature_deg_c),
    ];
    refuse_not_finite(reading.seq, numbers.into_iter().chain(joints))
}
