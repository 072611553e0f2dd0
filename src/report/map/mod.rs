//! Maps of the stiffness over the workspace, for people, for programs, and as files for others to draw.

mod design;
mod figures;
mod json;
mod paper;
#[cfg(feature = "parquet")]
mod parquet;
mod points;
mod shifts;
mod text;

use crate::distribution::{MapColumn, MechanismStudy, Sampling, StudyPoses};
use crate::plot::BinValue;
use crate::quantity::NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE;
use crate::robot::Robot;

pub use design::{JointDerivatives, SectionDerivatives, SensitivityReport, sensitivity_document};
pub use json::{
    DirectionMap, EndMatrix, ExtremeStiffness, FailedPose, FittedStiffness, MapAnswers, MapResult,
    MapSummary, MechanismMap, RefinedExtremeJson, RefinedPose, RegionPlace, SampledStiffness,
    Sensitivities, StiffnessQuantile, StiffnessRegion,
};
pub use paper::PaperCell;
#[cfg(feature = "parquet")]
pub use parquet::points_parquet;
pub use points::points_csv;
pub use shifts::{
    LoadAtEnd, MechanismShift, MechanismWeight, ShiftCause, ShiftReport, ShiftStatistics,
    ShiftSummary, WorstPose,
};
pub(super) use text::statistics_table;

/// Maps of some mechanisms of a robot over the same poses.
#[derive(Debug)]
pub struct MapReport<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// Name of the factors.
    pub factors_name: String,
    /// Seed of the poses.
    pub seed: u64,
    /// The poses.
    pub poses: &'a StudyPoses,
    /// One entry a mechanism, with the effects beside its beams.
    pub mechanisms: Vec<(Vec<String>, MechanismStudy)>,
    /// Load at which laws that are not linear are taken, N.
    pub at_load_n: Option<f64>,
    /// What a square of a figure shows of its poses; `None` takes the mean where at most two variables vary, else the least.
    pub cell: Option<BinValue>,
}

/// The unit in which a column is stated, and what it is in SI.
fn unit_of(column: &MapColumn) -> (&'static str, f64) {
    if column.is_rotational() {
        ("N*m/rad", 1.0)
    } else {
        ("N/um", NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE)
    }
}

impl MapReport<'_> {
    /// What a square of a figure shows of its poses: where a place in the plane has many postures, the least, which holds for all.
    fn bin_value(&self) -> BinValue {
        let single = self.poses.set.free.len() <= 2;
        let usual = if single {
            BinValue::Mean
        } else {
            BinValue::Least
        };
        self.cell.unwrap_or(usual)
    }

    /// How the poses were chosen, in words.
    fn sampling_words(&self) -> String {
        let set = &self.poses.set;
        let many = set.len();
        let chosen = match self.poses.sampling {
            Sampling::MonteCarlo => format!("{many} random poses (seed {})", self.seed),
            Sampling::LowDiscrepancy => {
                format!("{many} low-discrepancy poses (seed {})", self.seed)
            }
            Sampling::Grid => format!("{many} poses of a grid"),
        };
        let names = |free: bool| -> Vec<&str> {
            let all = self.robot.variables.iter().enumerate();
            all.filter(|(index, _)| set.free.contains(index) == free)
                .map(|(_, variable)| variable.name.as_str())
                .collect()
        };
        let (free, held) = (names(true), names(false));
        let mut words = format!("{chosen} within the limits, of {} points", set.drawn);
        if !free.is_empty() {
            words += "; varied: ";
            words += &free.join(", ");
        }
        if !held.is_empty() {
            words += "; at nominal values: ";
            words += &held.join(", ");
        }
        words
    }

    /// The paper's Tables VII to X beside these maps, cell by cell; empty for a robot that is not the paper's.
    #[must_use]
    pub fn paper_cells(&self) -> Vec<PaperCell> {
        // Only the robots of the paper state its points.
        if self
            .robot
            .poses
            .iter()
            .all(|pose| pose.stated_zy_m.is_none())
        {
            return Vec::new();
        }
        paper::cells(&self.mechanisms)
    }
}
