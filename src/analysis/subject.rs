//! What a diagnosis is of.

use crate::mismatch::PartUnits;
use crate::robot::FittingFactors;
use crate::table_files::FileLayout;

/// What a diagnosis is of.
#[derive(Debug, Clone)]
pub enum Subject {
    /// A robot.
    Robot(RobotSubject),
    /// A part without a robot file.
    Part {
        /// The units of its table.
        units: PartUnits,
        /// What in the table was taken for what.
        layout: FileLayout,
    },
}

/// A robot as it was diagnosed.
#[derive(Debug, Clone)]
pub struct RobotSubject {
    /// Its name.
    pub robot: String,
    /// Name of the mechanism.
    pub mechanism: String,
    /// Name of the factors that the search started from.
    pub start_factors: String,
    /// The factors with what was found.
    pub fitted_factors: FittingFactors,
}
