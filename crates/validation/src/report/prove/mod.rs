//! The proof as tables, JSON and figures.

mod calibration;
mod concealed;
mod doors;
mod forced;
mod idealised;
mod power;
mod recordings;
mod verdicts;

pub use calibration::{CalibrationReport, calibration_text};
pub use concealed::{ConcealedList, ConcealedMode, ConcealedReport};
pub use doors::{DoorsReport, doors_text};
pub use forced::forced_text;
pub use idealised::idealised_text;
pub use power::{PowerReport, power_figure, power_text};
pub use recordings::{RecordingTotals, RecordingVerdict, RecordingsReport, recordings_text};
pub use verdicts::blind_verdicts;

use schemars::JsonSchema;
use serde::Serialize;

use crate::prove::{AcceptanceCriterion, ForcedPoint, IdealisedErrors, Share, Target};

use stiffbench::report::Table;

/// The parts of a validation that were run, for programs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ProveReport {
    /// Whether only a sample was run.
    pub quick: bool,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Earlier sessions that the noise was estimated from too.
    pub earlier_sessions: usize,
    /// Time it took, s.
    pub seconds: f64,
    /// Threads.
    pub threads: usize,
    /// The parts.
    pub parts: ProveParts,
}

/// Parts of a validation; those that were not run are absent.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub struct ProveParts {
    /// Blind verdicts on concealed sessions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub concealed: Option<ConcealedReport>,
    /// False alarms and coverage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub calibration: Option<CalibrationReport>,
    /// Power and right names.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power: Option<PowerReport>,
    /// Standard errors beside those of an idealised bench.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub errors: Option<Vec<IdealisedErrors>>,
    /// The same readings by every door.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub doors: Option<DoorsReport>,
    /// Intervals where a law is stated and not searched.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forced: Option<Vec<ForcedPoint>>,
}

/// A share with its interval, percent.
fn share_words(share: &Share) -> [String; 3] {
    let percent = |value: f64| format!("{:.1}", 100.0 * value);
    [
        format!("{}/{}", share.hits, share.trials),
        share.value().map_or_else(|| "-".to_owned(), percent),
        share.interval_95().map_or_else(
            || "-".to_owned(),
            |[low, high]| format!("{} to {}", percent(low), percent(high)),
        ),
    ]
}

fn target_words(target: Option<Target>) -> String {
    match target {
        None => "counted".to_owned(),
        Some(Target::AtLeast(least)) => format!("at least {:.0}", 100.0 * least),
        Some(Target::AtMost(most)) => format!("at most {:.1}", 100.0 * most),
        Some(Target::Between(least, most)) => {
            format!("{:.0} to {:.0}", 100.0 * least, 100.0 * most)
        }
    }
}

/// Promises beside what became of them.
fn criteria_table(criteria: &[AcceptanceCriterion]) -> String {
    let kept = |one: &&AcceptanceCriterion| match one.target.map(|target| target.is_met(&one.share))
    {
        None | Some(None) => "-",
        Some(Some(true)) => "yes",
        Some(Some(false)) => "NO",
    };
    Table::of(criteria)
        .words("promise", |one| one.what)
        .numbers("target, %", |one| target_words(one.target))
        .numbers_each(["hits", "%", "95 % interval"], |one| {
            share_words(&one.share)
        })
        .words("kept", kept)
        .text()
}
