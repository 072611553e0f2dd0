//! Guided sessions for programs: plan, progress, integrity.

use std::borrow::Cow;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_document::{Document, Table, sign_of};

use crate::fit::{BestPoses, ProposedWithin};
use crate::load_direction::LoadDirection;
use crate::session::{
    OmittedReadings, QUESTIONS, Question, RawCheck, Record, SessionCell, SessionEnd, SessionPlan,
    Undone,
};
use crate::test_point::PoseId;

use super::fit::{kept_words, tool_words};
use super::text::significant;

/// What happened in a session.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SessionLog {
    /// The records of its journal, in order.
    pub events: Vec<Record>,
}

/// What a session will ask for.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct PlanReport {
    /// Name of the procedure.
    pub procedure: String,
    /// Number of readings.
    pub readings: usize,
    /// Minutes that it takes.
    pub minutes: f64,
    /// The poses and directions in their order.
    pub cells: Vec<SessionCell>,
    /// The questions that can come.
    pub prompts: Vec<Question>,
    /// The files that a session makes.
    pub files: Vec<Cow<'static, str>>,
    /// What the poses determine, where they were chosen for it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub determines: Vec<ExpectedParameter>,
    /// The tool centre in each pose that was chosen for it, in the axes of the base, m, in the order of the poses.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tools_m: Vec<[f64; 3]>,
    /// What these poses keep.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub within: Option<ProposedWithin>,
}

/// How well planned poses determine a parameter.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ExpectedParameter {
    /// Its name.
    pub name: String,
    /// Unit of the standard error; of a factor it is that of its logarithm.
    pub unit: Cow<'static, str>,
    /// Standard error to be expected with the noise of `simulate`: the Cramér-Rao limit; `null` of a spring that no load acts on.
    pub se: Option<f64>,
    /// Why there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub words: Option<Cow<'static, str>>,
}

impl PlanReport {
    /// The plan of a session that takes so many seconds and makes these files.
    #[must_use]
    pub fn new(plan: &SessionPlan, seconds: f64, files: Vec<&'static str>) -> Self {
        Self {
            procedure: plan.procedure.name.clone(),
            readings: plan.len(),
            minutes: (seconds / 60.0).round(),
            cells: plan.cells.clone(),
            prompts: QUESTIONS.to_vec(),
            files: files.into_iter().map(Into::into).collect(),
            determines: Vec::new(),
            tools_m: Vec::new(),
            within: None,
        }
    }

    /// With what poses determine that were chosen for it.
    #[must_use]
    pub fn with_best_poses(mut self, best: Option<&BestPoses>) -> Self {
        let errors = best.iter().flat_map(|best| &best.errors);
        let determines = errors.map(|(parameter, se)| ExpectedParameter {
            name: parameter.to_string(),
            unit: parameter.unit().into(),
            se: *se,
            words: se.is_none().then(|| parameter.unloaded_words().into()),
        });
        self.determines = determines.collect();
        self.tools_m = best.map_or_else(Vec::new, |best| best.tools_m.clone());
        self.within = best.map(|best| best.within.clone());
        self
    }
}

/// The standard errors to be expected in poses that were chosen for it, as a table.
#[must_use]
pub fn best_poses_document(best: &BestPoses) -> Document {
    let mut document = Document::of(format!(
        "Poses that best determine the parameters, of {} candidates:",
        best.tried
    ));
    document.table(
        Table::of(best.poses.iter().zip(&best.tools_m))
            .words("pose", |(named, _)| &named.id)
            .numbers("tool at x, y, z, mm", |(_, tool_m)| tool_words(**tool_m)),
    );
    document.paragraph(kept_words(&best.within));
    document.paragraph("Standard errors with the noise of simulate (Cramér-Rao limit):");
    document.table(
        Table::of(&best.errors)
            .words("parameter", |(parameter, _)| parameter)
            .numbers("expected standard error", |(parameter, error)| {
                let unloaded = || parameter.unloaded_words().to_owned();
                error.map_or_else(unloaded, |error| significant(error, 2))
            })
            .words("unit", |(parameter, _)| sign_of(parameter.unit())),
    );
    document
}

/// How a session ended, or that it has not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SessionOutcome {
    /// Every planned reading was taken or skipped.
    Complete,
    /// Stopped at a safe point; it can be resumed.
    Partial,
    /// Stopped at once; it can be resumed.
    Aborted,
    /// A process has it.
    Running,
    /// No event states that it ended, and no process has it.
    Crashed,
    /// No event states that it ended, and the system does not say whether a process has it.
    RunningOrCrashed,
}

impl From<SessionEnd> for SessionOutcome {
    fn from(outcome: SessionEnd) -> Self {
        match outcome {
            SessionEnd::Complete => Self::Complete,
            SessionEnd::Partial => Self::Partial,
            SessionEnd::Aborted => Self::Aborted,
        }
    }
}

impl SessionOutcome {
    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::Partial => "partial",
            Self::Aborted => "aborted",
            Self::Running => "running",
            Self::Crashed => "crashed",
            Self::RunningOrCrashed => "running or crashed",
        }
    }
}

/// The progress of a session.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct StatusReport {
    /// Its folder.
    pub folder: PathBuf,
    /// Its identifier.
    pub session: Option<String>,
    /// How it ended.
    pub outcome: SessionOutcome,
    /// Readings planned.
    pub planned: usize,
    /// Readings that count.
    pub accepted: usize,
    /// Readings that were left out.
    pub skipped: usize,
    /// What was left out, and why.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<OmittedReadings>,
    /// Readings that were replaced by others.
    pub superseded: usize,
    /// Minutes that the rest takes.
    pub minutes_left: f64,
    /// By whom it was ended: the operator or the program; `null` if it has not ended or an older version ended it.
    pub ended_by: Option<String>,
    /// Why it ended; `null` if it has not.
    pub reason: Option<String>,
    /// What is done once more when it is resumed.
    pub repeats: Vec<String>,
    /// The next reading; `null` if there is none.
    pub next: Option<NextReading>,
}

/// The reading that comes next.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct NextReading {
    /// The pose.
    pub pose: PoseId,
    /// The direction.
    pub direction: LoadDirection,
    /// The load to set, N.
    #[serde(rename = "target_N")]
    pub target_n: f64,
    /// Application of the sequence, from 1.
    pub repeat: u32,
}

/// What a run of a session came to.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct RunReport {
    /// Its folder.
    pub folder: PathBuf,
    /// How it ended.
    pub outcome: SessionOutcome,
    /// Readings planned.
    pub planned: usize,
    /// Readings that count.
    pub accepted: usize,
    /// Readings that were left out.
    pub skipped: usize,
    /// Readings that were replaced by others.
    pub superseded: usize,
}

/// What was taken back of a session.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct UndoReport {
    /// Its folder.
    pub folder: PathBuf,
    /// Sequence number of the event that takes it back.
    pub event: u64,
    /// What was taken back.
    pub undone: Undone,
    /// The same in words.
    pub text: String,
    /// Readings planned.
    pub planned: usize,
    /// Readings that count.
    pub accepted: usize,
    /// Readings that are left out.
    pub skipped: usize,
}

/// A session that was replayed, beside the one that was recorded.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SessionReplayReport {
    /// The new folder.
    pub folder: PathBuf,
    /// Readings that count in the recorded session.
    pub recorded: usize,
    /// Those of them that the replay took too.
    pub replayed: usize,
    /// Largest difference of a force, N.
    #[serde(rename = "largest_difference_N")]
    pub largest_difference_n: f64,
    /// Largest difference of a displacement, µm.
    pub largest_difference_um: f64,
}

/// The journal of a session, as far as it can be read.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct JournalReport {
    /// Whether journal and table are whole.
    pub whole: bool,
    /// Number of events.
    pub events: usize,
    /// Number of readings.
    pub readings: usize,
    /// Number of readings that count.
    pub accepted: usize,
    /// Number of lines that are lost.
    pub lost_lines: usize,
    /// What is wrong with the journal, in words.
    pub finding: String,
}

/// A session checked against its journal.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct VerifyReport {
    /// Whether journal and table are whole, and the journal; only `whole` where there is no journal.
    #[serde(flatten)]
    pub journal: VerifiedJournal,
    /// The table of readings.
    pub table: crate::analysis::TableCheck,
    /// Whether `robot.toml` is not the robot that the journal has the SHA-256 of.
    pub robot_changed: bool,
    /// Files that cannot be verified, for the journal has no SHA-256 of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_verified: Vec<Cow<'static, str>>,
    /// The bytes of the readings in the traces of the gauges; absent where the journal does not state where they are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub raw: Option<RawCheck>,
}

/// The journal of a session that is checked.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum VerifiedJournal {
    /// There is one.
    Read(JournalReport),
    /// There is none.
    None {
        /// Nothing contradicts the table.
        whole: bool,
    },
}
