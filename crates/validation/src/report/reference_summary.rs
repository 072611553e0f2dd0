//! A reference of solids and its comparison with fitted beams, for programs.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use crate::reference::{ReferenceCell, ReferenceModel, RunBy};

use super::reference::{ReferencePose, ReferenceReport, ReferenceRow};
use super::table_iv::PaperTableIv;

/// A model that was written.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ReferenceExport {
    /// Its folder.
    pub folder: PathBuf,
    /// The model.
    pub model: ReferenceModel,
}

/// What CalculiX made of a model.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ReferenceRun {
    /// Folder of the model.
    pub folder: PathBuf,
    /// Program, version and machine.
    pub run: RunBy,
    /// Displacements.
    pub cells: Vec<ReferenceCell>,
}

/// Fitted beams beside a reference, and the paper's table of the same.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ReferenceSummary {
    /// The model.
    pub reference: ReferenceModel,
    /// Program, version and machine.
    pub run: RunBy,
    /// Each pose.
    pub poses: Vec<ReferencePoseSummary>,
    /// Time of one solution of the fitted beams, s.
    #[serde(rename = "fitted_s")]
    pub seconds_per_solve: f64,
    /// What the paper prints.
    pub paper: PaperReferenceSummary,
}

/// One pose of a reference.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ReferencePoseSummary {
    /// Name.
    pub pose: String,
    /// Solid elements.
    pub elements: usize,
    /// Their nodes.
    pub nodes: usize,
    /// Beam elements.
    pub beams: usize,
    /// Factors fitted to the smallest loads.
    pub factors: ReferenceFactors,
    /// Directions that no value of their factor brings to the reference.
    pub misses: Vec<String>,
    /// Each load.
    pub rows: Vec<ReferenceRowSummary>,
    /// Largest distance of the fitted beams from the reference, percent; `null` without a load.
    pub largest_difference_percent: Option<f64>,
    /// Fewest percent of the reference's time that the fitted beams save.
    pub time_saved_percent: f64,
}

/// Factors of one pose.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
#[serde(rename_all = "PascalCase")]
pub struct ReferenceFactors {
    /// Of the area.
    pub a: f64,
    /// Of the second moment about y.
    pub iy: f64,
    /// Of the second moment about z.
    pub iz: f64,
    /// Of the torsion constant.
    pub j: f64,
}

/// Displacement under one load, by each model.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ReferenceRowSummary {
    /// Direction of force.
    pub direction: String,
    /// Force, N.
    #[serde(rename = "force_N")]
    pub force_n: f64,
    /// By the reference, µm.
    pub reference_um: f64,
    /// By the fitted beams, µm.
    pub fitted_um: f64,
    /// How far the fitted beams lie from the reference, percent.
    pub difference_percent: f64,
    /// By the beams with the factors that the reference was written with, µm.
    pub unfitted_um: f64,
    /// By beams with the constants of the prisms and with shear, µm.
    pub prisms_um: f64,
    /// Time of the reference, s.
    pub reference_s: f64,
}

/// The paper's own reference and fitted beams.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct PaperReferenceSummary {
    /// Elements of its reference.
    pub elements: usize,
    /// Beam elements.
    pub beams: usize,
    /// Fewest percent of the reference's time that its beams save.
    pub time_saved_percent: f64,
    /// Largest distance of its beams from its reference, percent.
    pub largest_difference_percent: f64,
}

impl ReferenceSummary {
    /// The same as the text of a report.
    #[must_use]
    pub fn new(report: &ReferenceReport) -> Self {
        let paper = PaperTableIv::printed();
        let [elements, beams] = paper.cells;
        let pose = |pose: &ReferencePose| {
            let [a, iy, iz, j] = pose.factors;
            ReferencePoseSummary {
                pose: pose.model.pose.clone(),
                elements: pose.model.elements,
                nodes: pose.model.nodes,
                beams: report.record.model.beams,
                factors: ReferenceFactors { a, iy, iz, j },
                misses: pose.misses.clone(),
                rows: pose.rows.iter().map(ReferenceRowSummary::from).collect(),
                largest_difference_percent: pose
                    .largest()
                    .map(|row| row.difference_percent().abs()),
                time_saved_percent: pose.time_saved_percent(report.seconds_per_solve),
            }
        };
        Self {
            reference: report.record.model.clone(),
            run: report.record.run.clone(),
            poses: report.poses.iter().map(pose).collect(),
            seconds_per_solve: report.seconds_per_solve,
            paper: PaperReferenceSummary {
                elements,
                beams,
                time_saved_percent: paper.time_saved_percent(),
                largest_difference_percent: paper.largest_percent(),
            },
        }
    }
}

impl From<&ReferenceRow> for ReferenceRowSummary {
    fn from(row: &ReferenceRow) -> Self {
        Self {
            direction: row.reference.direction.clone(),
            force_n: row.reference.force_n,
            reference_um: row.reference_um,
            fitted_um: row.fitted_um,
            difference_percent: row.difference_percent(),
            unfitted_um: row.unfitted_um,
            prisms_um: row.prisms_um,
            reference_s: row.reference.seconds,
        }
    }
}
