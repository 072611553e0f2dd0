//! What was decided about readings: replaced, flagged, left out, and what of that was taken back.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_units_and_text::load_direction::LoadDirection;

use super::event::Event;
use super::journal::Record;
use super::state::SessionState;
use stiffbench_units_and_text::count::counted;

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
    /// What kind of reason; absent in journals of older programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub code: Option<SkipCode>,
    /// Why, in the operator's words; empty where the kind is enough.
    pub reason: String,
    /// The pose; absent in journals of older programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose: Option<String>,
    /// The direction of the load.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<LoadDirection>,
}

/// Why a reading is missing.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum SkipCode {
    /// A gauge, the jack or a cable.
    Instrument,
    /// The robot or the part that is measured.
    Specimen,
    /// The gauges or the jack cannot be put there.
    Unreachable,
    /// No time is left.
    Time,
    /// A check of the reading failed, and the operator left it out.
    Check,
    /// Something else: a few words are needed.
    Other,
}

impl SkipCode {
    /// Those that an operator can give.
    pub const GIVEN: [Self; 5] = [
        Self::Instrument,
        Self::Specimen,
        Self::Unreachable,
        Self::Time,
        Self::Other,
    ];

    /// Its word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Instrument => "instrument",
            Self::Specimen => "specimen",
            Self::Unreachable => "unreachable",
            Self::Time => "time",
            Self::Check => "check",
            Self::Other => "other",
        }
    }

    /// A reason as typed: one of the words, and more about it. Another first word belongs to the reason; `None` if nothing is stated.
    pub(crate) fn of_typed(text: &str) -> Option<(Self, &str)> {
        let text = text.trim();
        let (first, rest) = text.split_once([' ', ':', ',']).unwrap_or((text, ""));
        let code = Self::GIVEN.into_iter().find(|code| code.word() == first);
        let rest = rest.trim_start_matches([' ', ':', ',']);
        match code {
            Some(Self::Other) | None if text.is_empty() || (code.is_some() && rest.is_empty()) => {
                None
            }
            Some(code) => Some((code, rest)),
            None => Some((Self::Other, text)),
        }
    }
}

/// Planned readings of a cell that are left out for one reason.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
pub struct OmittedReadings {
    /// Pose and direction, or the number of the cell.
    pub cell: String,
    /// How many.
    pub readings: usize,
    /// What kind of reason; `null` in sessions of older versions.
    pub code: Option<SkipCode>,
    /// Why, in words.
    pub reason: String,
}

impl fmt::Display for OmittedReadings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} of {} left out: {}",
            counted(self.readings, "planned reading"),
            self.cell,
            self.reason
        )
    }
}

impl OmittedReadings {
    /// What is left out, by cell and reason, in the order of the plan.
    pub fn of<'a>(skipped: impl IntoIterator<Item = &'a Skipped>) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for one in skipped {
            let (cell, reason) = (one.cell_text(), one.words());
            match all
                .iter_mut()
                .find(|of| (&of.cell, &of.reason) == (&cell, &reason))
            {
                Some(of) => of.readings += 1,
                None => all.push(Self {
                    cell,
                    readings: 1,
                    code: one.code,
                    reason,
                }),
            }
        }
        all
    }
}

impl Skipped {
    /// The reason, its kind first.
    #[must_use]
    pub fn words(&self) -> String {
        match (self.code, self.reason.as_str()) {
            (None, reason) => reason.to_owned(),
            (Some(code), "") => code.word().to_owned(),
            (Some(code), reason) => format!("{}: {reason}", code.word()),
        }
    }

    /// Pose and direction, or the number of the cell in journals of older programs.
    #[must_use]
    pub fn cell_text(&self) -> String {
        match (&self.pose, &self.direction) {
            (Some(pose), Some(direction)) => format!("{pose} {direction}"),
            _ => format!("cell {}", self.cell + 1),
        }
    }

    fn is_of_one_decision(&self, last: &Self) -> bool {
        (self.cell, self.words()) == (last.cell, last.words())
    }
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
                let (cell, reason) = (last.cell, last.words());
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reason_begins_with_its_kind_and_other_needs_words() {
        let typed = SkipCode::of_typed;
        assert_eq!(
            typed("instrument: cable"),
            Some((SkipCode::Instrument, "cable"))
        );
        assert_eq!(typed(" time "), Some((SkipCode::Time, "")));
        assert_eq!(
            typed("a cable in the way"),
            Some((SkipCode::Other, "a cable in the way"))
        );
        assert_eq!(
            typed("other it rained"),
            Some((SkipCode::Other, "it rained"))
        );
        assert_eq!(typed("other"), None);
        assert_eq!(typed("  "), None);
    }
}
