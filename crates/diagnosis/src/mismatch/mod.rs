//! What the fitted structure cannot explain, and which physics would.
//!
//! Works on readings, never on stiffnesses. The run is the unit that repeats: noise is made white run by run ([`ReadingNoise`]), what
//! the factors can absorb is projected out, every law is tried at every place, and the best is believed only beyond a limit that the
//! whole search was calibrated to.
//!
//! Each folder is a room with one question, and imports only those before it in this list:
//!
//! - `observed`: what was measured.
//! - `baselines`: what the linear structure predicts.
//! - `noise`: how much readings scatter.
//! - `problem`: which parameters and effects fit the readings best.
//! - `screen`: what is wrong with the data themselves.
//! - `hold_out`: how well readings are predicted that the fit has not seen.
//! - `unexplained`: what a model leaves, and where.
//! - `candidates`: which laws at which places explain it.
//! - `verdict`: what is said in the end.
//! - `design`: what should be measured next.
//!
//! `diagnose.rs` leads through them.

mod baselines;
mod candidates;
mod design;
mod diagnose;
mod error;
mod hold_out;
mod noise;
mod observed;
mod problem;
mod screen;
mod unexplained;
mod verdict;

pub use crate::search::MOST_READINGS_OF_A_PART;
pub use baselines::{
    Baseline, BaselineParameter, ElementCompliance, Line, PartUnit, PartUnits, PoseSolver,
    RobotBaseline, StructureColumn, test_object,
};
pub use candidates::{
    ConfigurationSizes, Family, LawCriticalValues, TrialNoise, Truth, WhiteLaw, WhiteLawShape,
    scale_to, simulate, standard_errors, standard_errors_after_fit, standard_errors_between,
    standard_errors_of_readings, white_laws,
};
pub use design::{
    CAN_TELL, CANNOT_TELL, DesignBench, DesignReport, LawAtPlace, LawDesign, NearRival,
    NextMeasurement, USUAL_NOISE, Unseen, design_of_plan, next_measurements, poses_at_hand,
};
pub use diagnose::{diagnose, diagnose_and_locate};
pub use error::MismatchError;
pub(crate) use hold_out::folds_of;
pub use hold_out::{HeldOut, MisfitShares, MisfitSteps, NoShareReason, Quality};
pub use noise::{
    CellSlopes, EarlierNoise, EstimatedNoise, KnownNoise, NoiseBasis, SeriesSlopes, StatedScatter,
};
pub(crate) use noise::{ForceReading, NoiseCovariance, ReadForces, estimate_noise};
pub(crate) use observed::load_point;
pub use observed::{
    Beginnings, GaugeNoise, GaugeSteps, Observations, ObservedCell, ObservedReading, ObservedRun,
    ObservedSession, PlannedCell, PlannedLoad, ReadingNoise, Recorded,
};
pub use problem::{GivenNoise, SearchOptions, given_noise, noise_alone};
pub use screen::{BadReading, BadRun, OtherJointValue, ReadQuantity, ScreenedData, screen_data};
pub(crate) use screen::{
    Exchanged, FoundMistake, NamedValue, RecordedValues, ValueChange, ValueFit, ValueModel,
    ValueName, ValueScale, find_mistake, kept, misread_factor, usual_factors_of_lengths,
};
pub use unexplained::{
    Contrast, ExplainedShare, Located, Location, MapEntry, Omnibus, OmnibusTest, STRATUM_LEVEL,
    Spot, Stratum, StratumTest, SuspectComponent, Untested, locate,
};
pub use verdict::{
    DetectionLimit, Diagnosis, DiagnosisTrace, EffectTrace, EstimatedValue, FactorChange, Finding,
    Impossible, KnownEffect, PartBand, PartConfiguration, PartModel, ReadingTrace, Rival,
    ValueInterval, Verdict, VerdictGrade, reading_between_slips, trace,
};
