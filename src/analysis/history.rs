//! What the journal of a session tells besides its readings, and the hashes of its files.

use std::collections::BTreeMap;

use jiff::Timestamp;

use crate::session::{Event, Record, SessionEnd, SessionState, read_journal};
use crate::stiffness::{ZeroChange, ZeroDrifts};
use crate::test_point::{Cell, PoseId};

use super::files::{ReadError, read_bytes, session_file};
use super::hash::sha256;
use super::session_table::SessionTable;
use crate::count::counted;

/// Files of a session folder that a report names, if they are there.
const FILES: [&str; 9] = [
    "session.toml",
    "readings.csv",
    "journal.jsonl",
    "robot.toml",
    "raw/force.trace",
    "raw/displacement.trace",
    "raw/displacement-x.trace",
    "raw/displacement-y.trace",
    "raw/displacement-z.trace",
];

/// What the journal of a session tells.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionHistory {
    /// Where the session stands.
    pub state: SessionState,
    /// When it began.
    pub began: Option<Timestamp>,
    /// Interruptions, lost lines and what else was not as planned, in the order of the journal.
    pub incidents: Vec<String>,
    /// What the checks of the displacement zero found.
    pub zero_drifts: ZeroDrifts,
}

impl SessionHistory {
    /// Whether every planned reading was taken or left out.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        let ended = self.state.ended.as_ref();
        ended.is_some_and(|ended| ended.outcome == SessionEnd::Complete)
    }
}

impl<T> SessionTable<T> {
    /// What its journal tells; `None` without a journal.
    ///
    /// # Errors
    /// For a journal that cannot be read.
    pub fn history(&self) -> Result<Option<SessionHistory>, ReadError> {
        let path = session_file(&self.folder, "journal.jsonl")?;
        let Some(path) = path.filter(|_| self.header.is_some()) else {
            return Ok(None);
        };
        let journal = read_journal(&read_bytes(&path)?);
        let records = &journal.records;
        Ok(Some(SessionHistory {
            state: SessionState::fold(records),
            began: records.first().map(|record| record.utc),
            incidents: records
                .iter()
                .filter_map(|record| incident(&record.event))
                .collect(),
            zero_drifts: zero_drifts(records),
        }))
    }

    /// Name and SHA-256 of its files; of a single file that one.
    ///
    /// # Errors
    /// For a file that cannot be read.
    pub fn file_hashes(&self) -> Result<Vec<(String, String)>, ReadError> {
        if self.header.is_none() {
            return Ok(vec![(self.short_name(), self.sha256.clone())]);
        }
        let hashes = FILES.iter().filter_map(|name| {
            let path = session_file(&self.folder, name).transpose()?;
            let bytes = path.and_then(|path| read_bytes(&path));
            Some(bytes.map(|bytes| ((*name).to_owned(), sha256(bytes))))
        });
        hashes.collect()
    }
}

/// The largest changes that the checks of the zeros found in each cell.
fn zero_drifts(records: &[Record]) -> ZeroDrifts {
    let (mut cells, mut changes) = (BTreeMap::new(), BTreeMap::<usize, ZeroChange>::new());
    for record in records {
        match &record.event {
            Event::Reading(taken) => {
                if let Some(direction) = taken.direction.axis() {
                    let pose = PoseId::new(&taken.pose);
                    cells.insert(taken.cell, Cell::new(pose, direction));
                }
            }
            Event::Zero(zero) => {
                let change = changes.entry(zero.cell).or_default();
                change.take(zero.drift_m, zero.force_drift_n);
            }
            _ => {}
        }
    }
    let known = cells.into_iter();
    known
        .filter_map(|(number, cell)| Some((cell, *changes.get(&number)?)))
        .collect()
}

/// An event that was not planned, in words.
fn incident(event: &Event) -> Option<String> {
    match event {
        Event::Resumed(_) => Some("the session was interrupted and resumed".to_owned()),
        Event::Superseded(one) => Some(format!(
            "reading {} was repeated: {}",
            one.number, one.reason
        )),
        Event::Flagged(flagged) => Some(format!(
            "flag on {}: {}",
            counted(flagged.numbers.len(), "reading"),
            flagged.flag
        )),
        Event::Link(link) if link.lost => Some(format!("{} gauge: {}", link.channel, link.text)),
        Event::Gap(gap) => Some(format!("nothing ran for {:.0} s", gap.seconds)),
        Event::ClockJump(jump) => Some(format!("the clock was set by {:.0} s", jump.seconds)),
        Event::CalibrationWarning(warning) => Some(warning.text.clone()),
        _ => None,
    }
}
