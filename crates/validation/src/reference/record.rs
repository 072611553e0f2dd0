//! What is kept of a reference: the model as it was written, and the displacements with how they were made.

use std::fmt::Write;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::ReferenceError;
use super::model::SolidMember;

const MODEL_SCHEMA: &str = "stiffbench/reference-model/1";
const RECORD_SCHEMA: &str = "stiffbench/reference/1";

/// A model as it was written: which robot, how meshed, in which files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReferenceModel {
    /// Format.
    pub schema: String,
    /// Version of this program that wrote it.
    pub software: String,
    /// Robot, by file or shipped name.
    pub robot: String,
    /// SHA-256 of the robot's text.
    pub robot_sha256: String,
    /// Mechanism.
    pub mechanism: String,
    /// Name of the factor set the sections were multiplied with.
    pub factors: String,
    /// The factors, A, Iy, Iz, J of beams and of links.
    pub factor_values: [[f64; 4]; 2],
    /// Beam elements of the structure.
    pub beams: usize,
    /// Kind of solid element.
    pub element: String,
    /// Longest side of a solid element, mm.
    pub size_mm: f64,
    /// Whether displacements were large (`NLGEOM`).
    pub large_displacements: bool,
    /// Poses.
    pub poses: Vec<PoseModel>,
    /// Members in the first pose.
    pub members: Vec<SolidMember>,
}

/// One pose of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PoseModel {
    /// Name.
    pub pose: String,
    /// File with the mesh.
    pub file: String,
    /// Solid elements.
    pub elements: usize,
    /// Nodes.
    pub nodes: usize,
    /// Cases of load.
    pub cases: Vec<ReferenceLoad>,
}

/// One case of load.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReferenceLoad {
    /// x, y or z.
    pub direction: String,
    /// Force, N.
    #[serde(rename = "force_N")]
    pub force_n: f64,
    /// Name of its file, without `.inp`.
    pub job: String,
}

/// What CalculiX made of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReferenceRecord {
    /// Format.
    pub schema: String,
    /// The model.
    pub model: ReferenceModel,
    /// Who computed it.
    pub run: RunBy,
    /// Displacements.
    pub cells: Vec<ReferenceCell>,
}

/// Program, version and machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunBy {
    /// Program with its version, as it prints it.
    pub program: String,
    /// Threads it was allowed.
    pub threads: usize,
    /// Date, UTC.
    pub date: String,
}

/// Displacement of the end under one load.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReferenceCell {
    /// Pose.
    pub pose: String,
    /// Direction of force.
    pub direction: String,
    /// Force, N.
    #[serde(rename = "force_N")]
    pub force_n: f64,
    /// Displacement along x, y, z, µm.
    pub displacement_um: [f64; 3],
    /// Time of the run, s.
    pub seconds: f64,
}

impl ReferenceCell {
    /// Whether it is the answer to a case.
    #[must_use]
    pub fn is_of(&self, pose: &PoseModel, case: &ReferenceLoad) -> bool {
        (&self.pose, &self.direction, self.force_n) == (&pose.pose, &case.direction, case.force_n)
    }

    /// Displacement along the force, µm.
    #[must_use]
    pub fn along_um(&self) -> Option<f64> {
        let axis = ["x", "y", "z"].iter().position(|d| *d == self.direction)?;
        Some(self.displacement_um[axis])
    }
}

impl ReferenceModel {
    /// The format's name.
    #[must_use]
    pub fn schema() -> String {
        MODEL_SCHEMA.to_owned()
    }

    /// Reads `model.json`.
    ///
    /// # Errors
    /// [`ReferenceError::Record`].
    pub fn parse(file: &str, text: &str) -> Result<Self, ReferenceError> {
        let model: Self = parse(file, text)?;
        check_schema(file, &model.schema, MODEL_SCHEMA)?;
        Ok(model)
    }
}

impl ReferenceRecord {
    /// The format's name.
    #[must_use]
    pub fn schema() -> String {
        RECORD_SCHEMA.to_owned()
    }

    /// Reads `reference.json`.
    ///
    /// # Errors
    /// [`ReferenceError::Record`].
    pub fn parse(file: &str, text: &str) -> Result<Self, ReferenceError> {
        let record: Self = parse(file, text)?;
        check_schema(file, &record.schema, RECORD_SCHEMA)?;
        check_schema(file, &record.model.schema, MODEL_SCHEMA)?;
        let wrong = record.cells.iter().find(|cell| {
            let along = cell.along_um();
            along.is_none_or(|um| um * cell.force_n <= 0.0)
        });
        match wrong {
            None => Ok(record),
            Some(cell) => Err(ReferenceError::Record {
                file: file.to_owned(),
                problem: format!(
                    "the displacement of {} {} under {} N is not in the sense of the force",
                    cell.pose, cell.direction, cell.force_n
                ),
            }),
        }
    }

    /// The cases of the model that have no displacement yet, as pose, direction and force.
    #[must_use]
    pub fn missing(&self) -> Vec<String> {
        let poses = self.model.poses.iter();
        let cases = poses.flat_map(|pose| pose.cases.iter().map(move |case| (pose, case)));
        cases
            .filter(|(pose, case)| !self.cells.iter().any(|cell| cell.is_of(pose, case)))
            .map(|(pose, case)| format!("{} {} {} N", pose.pose, case.direction, case.force_n))
            .collect()
    }

    /// Checks that every case of the model has its displacement.
    ///
    /// # Errors
    /// [`ReferenceError::Unfinished`].
    pub fn check_finished(&self, file: &str) -> Result<(), ReferenceError> {
        let missing = self.missing();
        let Some(first) = missing.first() else {
            return Ok(());
        };
        Err(ReferenceError::Unfinished {
            file: file.to_owned(),
            done: self.cells.len(),
            missing: missing.len(),
            first: first.clone(),
        })
    }

    /// The displacements as a list that `fit` takes.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text = "pose,direction,force_N,displacement_um\n".to_owned();
        for cell in &self.cells {
            let um = cell.along_um().unwrap_or(f64::NAN);
            let _ = writeln!(
                text,
                "{},{},{},{um}",
                cell.pose, cell.direction, cell.force_n
            );
        }
        text
    }
}

fn parse<T: serde::de::DeserializeOwned>(file: &str, text: &str) -> Result<T, ReferenceError> {
    serde_json::from_str(text).map_err(|error| ReferenceError::Record {
        file: file.to_owned(),
        problem: error.to_string(),
    })
}

fn check_schema(file: &str, found: &str, expected: &str) -> Result<(), ReferenceError> {
    if found == expected {
        return Ok(());
    }
    Err(ReferenceError::Record {
        file: file.to_owned(),
        problem: format!("its schema is {found}, this version reads {expected}"),
    })
}
