//! What was decided about readings: replaced, flagged, left out, and what of that was taken back.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::event::Event;
use super::journal::Record;
use super::state::SessionState;

/// A reading that no longer counts.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Superseded {
    /// Number of the reading.
    pub number: u32,
    /// Why.
    pub reason: String,
}

/// Readings that are doubtful, found out after they were taken.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Flagged {
    /// Numbers of the readings.
    pub numbers: Vec<u32>,
    /// Why.
    pub flag: String,
    /// Whether the operator decided it; else the program found it out.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub by_operator: bool,
}

/// A planned reading that is left out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Skipped {
    /// Place of the cell in the plan, from 0.
    pub cell: usize,
    /// Place in the readings planned for that cell, from 0.
    pub index: usize,
    /// Why.
    pub reason: String,
}

/// Decisions that were taken back; their events stay in the journal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Undone {
    /// Sequence numbers of the events that are taken back, in order.
    pub events: Vec<u64>,
    /// What they were.
    pub action: UndoneAction,
}

/// What was taken back.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum UndoneAction {
    /// A reading: it no longer counts and is open again.
    Reading {
        /// Its number.
        number: u32,
    },
    /// A skip: the readings are open again.
    Skip {
        /// Place of the cell in the plan, from 0.
        cell: usize,
        /// Places in the readings planned for that cell, from 0.
        indices: Vec<usize>,
        /// Why they had been left out.
        reason: String,
    },
    /// A flag that the operator had set.
    Flag {
        /// Numbers of the readings.
        numbers: Vec<u32>,
        /// The flag.
        flag: String,
    },
}

/// The last decision that still holds: an accepted reading, a skip, or a flag of the operator. `None` if there is none.
///
/// # Arguments
/// - `state`: the fold of `records`.
#[must_use]
pub fn last_decision(records: &[Record], state: &SessionState) -> Option<Undone> {
    let mut earlier = records.iter().rev();
    while let Some(record) = earlier.next() {
        let (events, action) = match &record.event {
            Event::Reading(taken) if state.counts(taken.number) => {
                let number = taken.number;
                (vec![record.seq], UndoneAction::Reading { number })
            }
            Event::Flagged(flagged) if flagged.by_operator && state.is_flagged(flagged) => {
                let (numbers, flag) = (flagged.numbers.clone(), flagged.flag.clone());
                (vec![record.seq], UndoneAction::Flag { numbers, flag })
            }
            Event::Skipped(last) if state.skipped.contains_key(&(last.cell, last.index)) => {
                // The rest of a cell is left out by one event for each reading.
                let others = earlier.map_while(|record| match &record.event {
                    Event::Skipped(skipped) if skipped.is_of_one_decision(last) => {
                        Some((record.seq, skipped.index))
                    }
                    _ => None,
                });
                let mut all: Vec<(u64, usize)> = others.collect();
                all.reverse();
                all.push((record.seq, last.index));
                let (events, indices) = all.into_iter().unzip();
                let (cell, reason) = (last.cell, last.reason.clone());
                let action = UndoneAction::Skip {
                    cell,
                    indices,
                    reason,
                };
                (events, action)
            }
            _ => continue,
        };
        return Some(Undone { events, action });
    }
    None
}

impl Skipped {
    fn is_of_one_decision(&self, last: &Self) -> bool {
        (self.cell, &self.reason) == (last.cell, &last.reason)
    }
}
