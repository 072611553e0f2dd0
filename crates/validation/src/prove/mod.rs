//! The proof that a diagnosis can be trusted: blind verdicts on concealed sessions, error rates counted on benches with a known
//! answer, recordings by others, standard errors beside those of an idealised bench, and the same readings by
//! every door.
//!
//! Opens no file: sessions, answers and recordings are passed in as texts, and the sealed answers only after every verdict is there.

mod answer_text;
mod answers;
mod blind;
mod calibration;
mod cases;
mod criteria;
mod doors;
mod error;
mod ideal;
mod idealised;
mod observer;
mod pose_errors;
mod pose_search;
mod power;
mod recording_score;
mod recording_table;
mod recordings;
mod score;
mod sealed;
mod session;
mod share;
mod trial_bench;

pub use answer_text::{answer_words, diagnosis_words};
pub use answers::{
    Expected, KnownRival, SealedAnswer, SealedAnswers, SealedSets, Set, TrueEffect, TrueNoise,
    TrueParameter,
};
pub use blind::{BlindVerdict, diagnose_all};
pub use calibration::{
    CalibrationPlan, CalibrationRow, FalseAlarm, Variant, calibrate, calibration_plans,
};
pub use cases::{UNKNOWN_SCALE, may_be};
pub use criteria::criteria;
pub use doors::{
    CoverageRow, DoorAnswer, DoorBench, DoorBenches, DoorJudge, DoorLedger, ForcedPoint,
    JudgedCase, PartBench, coverage, differences, disagreements, is_named, stated_values,
    vector_table,
};
pub use error::ProveError;
pub use idealised::{ErrorsOfPlan, IDEALISED_UM, IdealisedErrors, beside_idealised};
pub use observer::Observer;
pub use pose_errors::score_pose_errors;
pub use power::{IdealPoint, PowerCase, PowerOptions, PowerPoint, power};
pub use recording_score::{
    ComparedFigure, RecordingOutcome, RecordingScore, assess, score_recording,
};
pub use recording_table::{ChosenRows, ComputedColumn};
pub use recordings::{Recording, RecordingFile, Recordings};
pub use score::{
    APART, APART_SHARE, Distances, INSEPARABLE, NamedCause, SEPARABLE, Score, TruthScore,
    UNKNOWN_FROM, VerdictOutcome, score,
};
pub use sealed::unseal;
pub use session::{SessionTexts, ValidationSession, fewer_readings};
pub use share::{AcceptanceCriterion, Share, Target};
