//! Readings to measured stiffness with its uncertainty.
//!
//! Per cell (pose and direction) two stiffnesses: the paper's, the mean of F/δ over the loads, and 1/slope of displacement on force
//! with a free intercept per gauge zero. They differ where something besides elasticity is at work: an offset or dead zone
//! lowers the first, curvature lowers the second more.
//!
//! Readings of one run share a zero and a slope, so the run is the unit whose scatter counts; a calibration error is shared by
//! all readings of a gauge, so it neither shrinks with repeats nor stays within a cell. Readings that look wrong are flagged, none
//! is removed.

mod budget;
mod budget_row;
mod checks;
mod compare;
mod contributions;
mod covariance;
mod curve;
mod display_step;
mod estimate;
#[cfg(test)]
mod flag_tests;
mod flags;
mod gauges;
mod grouping;
mod hysteresis;
mod hysteresis_report;
mod line;
mod outliers;
#[cfg(test)]
mod property_tests;
mod report;
mod rounding;
mod run_slope;
#[cfg(test)]
mod sample;
mod scatter;
mod significance;
#[cfg(test)]
mod simulation_tests;
mod straight_part;
mod straightness;
mod table;
mod zeros;

pub use budget::{Budget, StiffnessEstimate};
pub use budget_row::{BudgetRow, Distribution, EvaluationType, RowUse, UncertaintySource};
pub use compare::{
    CellChange, Comparison, DECISION_RULE, LoopChange, NotCompared, OverallTest, SameGauges,
    StiffnessAgreement, compare,
};
pub use covariance::{LnParts, LnStiffnessCovariance};
pub use curve::{Branches, CurvePoint, LoadCurve, LoadMean, Run, Spread};
pub use display_step::step_of;
pub use estimate::{Method, ScatterBasis, stiffness_value};
pub use flags::{Flag, ReadingPlace};
pub use gauges::{GaugePair, GaugeTerms, StiffnessError, is_factor_of_limits, read_off_words};
pub use grouping::LeftOut;
pub use hysteresis::{Hysteresis, LargestWidth, LoopWidth, NoHysteresis};
pub use hysteresis_report::{HysteresisReport, LargestWidthReport, LoopWidthReport};
pub use line::{LineFit, NoStiffness, RunSums, TypeA};
pub use report::{
    BudgetRowReport, FlagReport, LeftOutReport, LoadMeanReport, PooledScatterReport,
    SkippedCellReport, StiffnessCellReport, StiffnessReport, StraightPartReport, UncertaintyReport,
};
pub use rounding::{RoundedValue, format_value_uncertainty};
pub use run_slope::PooledRunSlope;
pub use scatter::PooledScatter;
pub use significance::TestStatistic;
pub use straight_part::StraightPart;
pub use table::{
    CellStiffness, SkipReason, SkippedCell, StiffnessOptions, StiffnessTable, stiffness_table,
    stiffness_table_with_drifts,
};
pub use zeros::{ZeroChange, ZeroDrifts};
