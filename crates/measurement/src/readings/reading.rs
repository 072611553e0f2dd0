//! One reading: a force and a displacement of one test point.

use std::fmt;

use serde::{Deserialize, Serialize};

use stiffbench_units_and_text::test_point::{Branch, Cell, Direction, PoseId};

/// Whether a reading counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ReadingStatus {
    /// Counts.
    #[default]
    Accepted,
    /// Taken again later; kept.
    Superseded,
    /// Refused by the operator or a rule; kept, with its reason in `flag`.
    Rejected,
}

/// Words of a column `status`.
pub(crate) const STATUS_WORDS: [(&str, ReadingStatus); 3] = [
    ("accepted", ReadingStatus::Accepted),
    ("superseded", ReadingStatus::Superseded),
    ("rejected", ReadingStatus::Rejected),
];

/// Words of a column of branches.
pub(crate) const BRANCH_WORDS: [(&str, Branch); 4] = [
    ("loading", Branch::Loading),
    ("load", Branch::Loading),
    ("unloading", Branch::Unloading),
    ("unload", Branch::Unloading),
];

/// What a word means among those that are known; capitals do not count.
pub(crate) fn meaning_of<T: Copy>(word: &[u8], known: &[(&str, T)]) -> Option<T> {
    let mut known = known.iter();
    let found = known.find(|(known, _)| word.eq_ignore_ascii_case(known.as_bytes()));
    found.map(|(_, meaning)| *meaning)
}

impl fmt::Display for ReadingStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// Force and displacement of one test point, in SI, with where they came from.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// Line of the file this reading stands on, from 1; 0 for a reading that never was in a file.
    pub line: u32,
    /// Sequence number in its session.
    pub seq: u32,
    /// The pose held.
    pub pose: PoseId,
    /// Direction of the displacement, and of the load where it has no other.
    pub direction: Direction,
    /// Direction of the load where it is another one: its place among [`ReadingTable::load_directions`](super::ReadingTable::load_directions).
    pub load: Option<u16>,
    /// Loading or unloading.
    pub branch: Branch,
    /// Place in the load sequence from 0, counted on through unloading.
    pub step: u32,
    /// n-th application of the sequence or load, from 1.
    pub repeat: u32,
    /// n-th try of this reading, from 1.
    pub attempt: u32,
    /// Index of the run in its table: readings with one virgin history.
    pub run: u32,
    /// Index of the gauge zero in its table: readings with one zero.
    pub zero: u32,
    /// Whether it counts.
    pub status: ReadingStatus,
    /// The load that was aimed at, N.
    pub target_n: f64,
    /// Signed force as measured, N.
    pub force_n: f64,
    /// Signed displacement from the gauge zero, m.
    pub displacement_m: f64,
    /// Seconds since the session began, if known.
    pub time_s: Option<f64>,
    /// Seconds under this load before capture, if known.
    pub hold_s: Option<f64>,
    /// Temperature, °C, if known.
    pub temperature_deg_c: Option<f64>,
    /// The instruments' own text of force and displacement, the rule that flagged the reading, a note, and the UTC time.
    pub text: Option<Box<ReadingText>>,
}

/// What a session keeps with a reading besides the numbers that are worked with.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReadingText {
    /// RFC 3339 time.
    pub utc: Box<str>,
    /// Force as the instrument wrote it.
    pub force_raw: Box<str>,
    /// Displacement as the instrument wrote it.
    pub displacement_raw: Box<str>,
    /// What the gauges showed at their zero, N and m in the sign as sent: it was taken off. `None` where that is not recorded.
    pub zero_si: [Option<f64>; 2],
    /// Rule id and reason.
    pub flag: Box<str>,
    /// Free text.
    pub note: Box<str>,
}

impl Reading {
    /// The cell this reading belongs to, its load along the displacement ([`ReadingTable::cell`](super::ReadingTable::cell) for any load).
    #[must_use]
    pub fn cell(&self) -> Cell {
        Cell::new(self.pose.clone(), self.direction)
    }

    /// Whether this reading counts.
    #[must_use]
    pub fn is_accepted(&self) -> bool {
        self.status == ReadingStatus::Accepted
    }
}
