//! The proof that a diagnosis can be trusted: blind verdicts on concealed sessions, error rates counted on benches with a known
//! answer, recordings by others, the paper's own twelve stiffness values, and standard errors beside those of an idealised bench.
//!
//! Opens no file: sessions, answers and recordings are passed in as texts, and the sealed answers only after every verdict is there.

mod answers;
mod blind;
mod calibration;
mod cases;
mod error;
mod idealised;
mod linear_model;
mod pose_errors;
mod power;
mod promises;
mod recordings;
mod score;
mod sealed;
mod session;
mod share;
mod smallest;
mod trial_bench;
mod twelve_values;
mod words;

pub use answers::{Answer, Answers, Expected, KnownRival, Set, Sets, TrueEffect, TrueParameter};
pub use blind::{BlindVerdict, diagnose_all};
pub use calibration::{CalibrationPlan, CalibrationRow, Variant, calibrate, calibration_plans};
pub use cases::LARGEST_SIZE;
pub use error::ProveError;
pub use idealised::{ErrorRow, IDEALISED_UM, PlaceErrors, beside_idealised};
pub use pose_errors::score_pose_errors;
pub use power::{IdealPoint, PowerCase, PowerOptions, PowerPoint, power};
pub use promises::promises;
pub use recordings::{
    ComparedFigure, Recording, RecordingFile, RecordingScore, Recordings, judge, score_recording,
};
pub use score::{
    APART, APART_SHARE, INSEPARABLE, Named, Outcome, Score, TruthScore, UNKNOWN_FROM, score,
};
pub use sealed::unseal;
pub use session::{Session, SessionTexts, fewer_readings};
pub use share::{Promise, Share, Target};
pub use twelve_values::{FittedLaw, FurtherCell, TwelveValues, twelve_values};
pub use words::{answer_words, diagnosis_words};
