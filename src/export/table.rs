//! The parameters of a model with units and intervals, and its compliance, as a table.

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::Serialize;

use crate::fit::StatusWord;
use crate::robot::ModelParameter;
use crate::structure::Compliance6;

use super::tidy::csv_of;
use super::xml::{number, rounded};

/// What an export is made of.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ExportTable {
    /// Name of the robot.
    pub robot: String,
    /// The mechanism.
    pub mechanism: String,
    /// Name of the factors.
    pub factors: String,
    /// Every parameter: factors of sections, springs, values of laws.
    pub parameters: Vec<ParameterRow>,
    /// Poses with the compliance of the end.
    pub poses: Vec<PoseRow>,
    /// What acts and is not among the parameters, or is known in part.
    pub notes: Vec<String>,
}

/// A parameter of a model.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ParameterRow {
    /// Its name, for example `beam.Iy`, `joint.J2` or `joint-friction@J2:friction_moment`.
    pub name: String,
    /// Its value in `unit`; `null` of a spring that has none yet.
    pub value: Option<f64>,
    /// ASCII unit.
    pub unit: String,
    /// 95 % interval in `unit`; `null` where it is not known.
    pub ci95: Option<[f64; 2]>,
    /// What a fit did with it, if the values are those of a fit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub status: Option<StatusWord>,
    /// The stiffness of a spring, whose value is its compliance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<SpringStiffness>,
}

/// The stiffness of a spring.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SpringStiffness {
    /// Its value in `unit`; `null` of a rigid spring.
    pub value: Option<f64>,
    /// ASCII unit.
    pub unit: &'static str,
    /// Lower end of the 95 % interval; `null` where it is not known.
    pub low95: Option<f64>,
    /// Upper end; `null` also where it reaches infinity.
    pub high95: Option<f64>,
}

/// The compliance of the end in a pose.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PoseRow {
    /// The pose.
    pub pose: String,
    /// Its variables, degrees or, of those that slide, m.
    pub variables: IndexMap<String, f64>,
    /// Position of the end, m.
    pub end_m: [f64; 3],
    /// Displacements and rotations of the end (rows ux, uy, uz, rx, ry, rz) per force and moment, SI; without joints that stick or have
    /// play, as under the smallest load. `null` where they depend on a spring that has no value yet.
    pub compliance: [[Option<f64>; 6]; 6],
}

impl ParameterRow {
    /// A parameter; the compliance of a spring has a stiffness too, but for one without a value.
    #[must_use]
    pub fn new(name: String, value: Option<f64>, unit: &str, ci95: Option<[f64; 2]>) -> Self {
        let unit_of_stiffness = match unit {
            "rad/(N*m)" => Some("N*m/rad"),
            "m/N" => Some("N/m"),
            _ => None,
        };
        let inverse = |c: f64| (c > 0.0).then(|| rounded(1.0 / c));
        Self {
            name,
            value: value.map(rounded),
            unit: unit.to_owned(),
            ci95: ci95.map(|ends| ends.map(rounded)),
            status: None,
            stiffness: unit_of_stiffness
                .zip(value)
                .map(|(unit, value)| SpringStiffness {
                    value: inverse(value),
                    unit,
                    low95: ci95.and_then(|[_, high]| inverse(high)),
                    high95: ci95.and_then(|[low, _]| inverse(low)),
                }),
        }
    }

    /// A parameter of the robot, without an interval.
    pub(super) fn of(parameter: &ModelParameter, value: Option<f64>) -> Self {
        Self::new(parameter.to_string(), value, parameter.unit(), None)
    }

    /// In a line, for comments.
    #[must_use]
    pub fn in_words(&self) -> String {
        let unit = match self.unit.as_str() {
            "1" => String::new(),
            unit => format!(" {unit}"),
        };
        let interval = |low: f64, high: Option<f64>| {
            let high = high.map_or_else(|| "infinity".to_owned(), number);
            format!(", 95 % {} to {high}", number(low))
        };
        let Some(value) = self.value else {
            return format!("{}: {}", self.name, ModelParameter::UNKNOWN);
        };
        let mut parts = vec![format!("{} = {}{unit}", self.name, number(value))];
        parts.push(match self.ci95 {
            Some([low, high]) => interval(low, Some(high)) + &unit,
            None => ", no interval".to_owned(),
        });
        if let Some(status) = self.status {
            parts.push(format!(", {status}"));
        }
        if let Some(spring) = &self.stiffness
            && let Some(value) = spring.value
        {
            parts.push(format!("; stiffness {} {}", number(value), spring.unit));
            parts.extend(spring.low95.map(|low| interval(low, spring.high95)));
        }
        parts.concat()
    }
}

impl ExportTable {
    /// One row a value: `pose,name,value,unit,ci95_low,ci95_high,status`; the pose is empty for parameters.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut rows: Vec<Vec<String>> = Vec::new();
        for parameter in &self.parameters {
            rows.extend(parameter.csv_rows());
        }
        for pose in &self.poses {
            for (i, row) in pose.compliance.iter().enumerate() {
                for (j, entry) in row.iter().enumerate() {
                    let (moved, load) = (Compliance6::DISPLACEMENTS[i], Compliance6::LOADS[j]);
                    let name = format!("compliance.{moved}.{load}");
                    let fields = [
                        pose.pose.clone(),
                        name,
                        known(*entry),
                        unit(i, j).to_owned(),
                    ];
                    rows.push([&fields[..], &[const { String::new() }; 3]].concat());
                }
            }
        }
        let heads = "pose,name,value,unit,ci95_low,ci95_high,status".split(',');
        csv_of(heads, &rows)
    }
}

/// A number; empty where it is not known.
fn known(value: Option<f64>) -> String {
    value.map_or_else(String::new, number)
}

impl ParameterRow {
    /// The parameter and, of a spring, its stiffness.
    fn csv_rows(&self) -> Vec<Vec<String>> {
        let row = |name: &str, value: String, unit: &str, [low, high]: [String; 2]| {
            let status = self.status.map_or("", StatusWord::key).to_owned();
            let unit = unit.to_owned();
            vec![
                String::new(),
                name.to_owned(),
                value,
                unit,
                low,
                high,
                status,
            ]
        };
        let ends = [0, 1].map(|end: usize| known(self.ci95.map(|ends| ends[end])));
        let mut rows = vec![row(&self.name, known(self.value), &self.unit, ends)];
        if let Some(spring) = &self.stiffness {
            let or_infinite = |value: Option<f64>| value.map_or_else(|| "inf".to_owned(), number);
            let high = spring.low95.map(|_| or_infinite(spring.high95));
            let ends = [known(spring.low95), high.unwrap_or_default()];
            let name = format!("{}.stiffness", self.name);
            rows.push(row(&name, or_infinite(spring.value), spring.unit, ends));
        }
        rows
    }
}

/// Unit of an entry of a compliance.
fn unit(row: usize, column: usize) -> &'static str {
    match (row < 3, column < 3) {
        (true, true) => "m/N",
        (true, false) => "m/(N*m)",
        (false, true) => "rad/N",
        (false, false) => "rad/(N*m)",
    }
}
