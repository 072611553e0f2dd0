//! The journal: `journal.jsonl`, one event a line, each with a sequence number, its time and a checksum.
//!
//! A line is a JSON object that ends in `,"crc":"xxxxxxxx"}`: the CRC-32C, in hexadecimal, of all bytes of the line before that. A record
//! is confirmed once its line break is on the disk; a part of one behind the last record was never acknowledged.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, Write};

use jiff::Timestamp;
use miette::Diagnostic;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use stiffbench_units_and_text::count::counted;

use super::event::{Event, Noted};

/// How a record begins. No text in a record can hold it, for quotes are escaped there.
const START: &[u8] = b"{\"seq\":";

/// How the checksum at its end begins.
const SEAL: &[u8] = b",\"crc\":\"";

/// Bytes of `,"crc":"xxxxxxxx"}`.
const SEAL_BYTES: usize = 18;

/// More events than a session has; a number beyond was forged.
const MOST_EVENTS: u64 = 1 << 22;

/// One event with its place in the session.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Record {
    /// 1 for the first event of a session, then counted on without a gap.
    pub seq: u64,
    /// When, by the system's clock.
    #[serde(serialize_with = "write_time", deserialize_with = "read_time")]
    #[schemars(with = "String")]
    pub utc: Timestamp,
    /// When, s since the session began.
    pub t_s: f64,
    /// What happened.
    #[serde(flatten)]
    pub event: Event,
}

fn write_time<S: serde::Serializer>(time: &Timestamp, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(time)
}

fn read_time<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Timestamp, D::Error> {
    let text = String::deserialize(deserializer)?;
    text.parse().map_err(serde::de::Error::custom)
}

/// A journal as read.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadJournal {
    /// The records that are whole, in order. Where one was lost, sequence numbers are missing.
    pub records: Vec<Record>,
    /// Bytes before the first that is damaged or cut.
    pub good_bytes: usize,
    /// What else stands there.
    pub end: JournalEnd,
}

/// What stands in a journal besides whole records.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum JournalEnd {
    /// Nothing.
    Clean,
    /// A part of a record behind the last: the program or the machine stopped while writing it. It was never acknowledged.
    Cut {
        /// Its bytes; 0 where only the line break behind the last record is missing.
        bytes: usize,
    },
    /// Damaged records.
    Damaged {
        /// Line of the first, from 1.
        line: usize,
        /// What is wrong with it.
        problem: Damage,
        /// How many records are lost.
        lines: usize,
    },
}

/// What is wrong with a record.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Damage {
    /// No checksum at its end.
    #[error("it does not end in a checksum")]
    NotSealed,
    /// The checksum is that of other bytes.
    #[error("its checksum is {found:08x}, its bytes make {made:08x}")]
    Checksum {
        /// As written.
        found: u32,
        /// As computed.
        made: u32,
    },
    /// The checksum is right, but the event cannot be read: a newer program wrote it.
    #[error("it is intact but not understood ({what}): a newer version may have written it")]
    NotUnderstood {
        /// The error of the reader.
        what: String,
    },
    /// A record is missing, stands elsewhere, or stands here twice.
    #[error("its sequence number is {found}, expected {expected}")]
    Sequence {
        /// As written.
        found: u64,
        /// What was due.
        expected: u64,
    },
    /// More than a record and its line break.
    #[error("it holds {what}, which this program never writes")]
    Foreign {
        /// The first of it, with escapes.
        what: String,
    },
}

impl JournalEnd {
    /// What was found behind the whole records, in words.
    #[must_use]
    pub fn finding(&self) -> String {
        match self {
            Self::Clean => "the journal is intact".to_owned(),
            Self::Cut { bytes: 0 } => "the last line has no line break; nothing is lost".to_owned(),
            Self::Cut { bytes } => {
                format!("after them {bytes} bytes of a record that was never confirmed")
            }
            Self::Damaged {
                line,
                problem,
                lines,
            } => format!(
                "line {line} is damaged: {problem}; lost: {}",
                counted(lines, "event")
            ),
        }
    }

    /// What a user of the readings should know of it.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let remedy = match self {
            Self::Clean => return None,
            Self::Cut { .. } => "",
            Self::Damaged { .. } => "; stiffbench session recover writes an intact one",
        };
        Some(format!("journal.jsonl: {}{remedy}", self.finding()))
    }
}

/// Reads a journal. Takes any bytes. A record counts if its checksum holds, wherever it stands and whatever stands beside it, so that one
/// damaged line costs one record and no more.
#[must_use]
pub fn read_journal(bytes: &[u8]) -> ReadJournal {
    let text = as_utf8(bytes);
    let mut records: BTreeMap<u64, Record> = BTreeMap::new();
    // Records that are lost for sure, and what stands behind the last record and may have been one.
    let (mut lost, mut lost_behind) = (0, 0);
    let (mut damage, mut cut, mut at) = (None, None, 0);
    while at < text.len() {
        let next = find(&text[at + 1..], START).map_or(text.len(), |more| at + 1 + more);
        let (read, rest) = split_record(&text[at..next]);
        let tail = match read {
            Ok(_) if !rest.is_empty() => rest.strip_prefix(b"\n"),
            _ => Some(rest),
        };
        let torn = tail.filter(|tail| next == text.len() && is_torn(tail));
        let problem = match read {
            Ok(record) => {
                let found = record.seq;
                let expected = records.keys().next_back().map_or(1, |last| last + 1);
                if (1..=MOST_EVENTS).contains(&found) {
                    lost_behind = if found < expected { lost_behind } else { 0 };
                    let kept = records.entry(found).or_insert_with(|| record.clone());
                    lost += usize::from(*kept != record);
                }
                let seal = &text[next - rest.len() - SEAL_BYTES..next - rest.len()];
                let capital = seal.iter().position(u8::is_ascii_uppercase);
                let sequence = Damage::Sequence { found, expected };
                (found != expected)
                    .then_some(sequence)
                    .or(capital.map(|place| foreign(&seal[place..=place])))
            }
            Err(problem) => Some(problem).filter(|_| torn.is_none()),
        };
        let behind = next - tail.unwrap_or(rest).len();
        let place = if problem.is_some() { at } else { behind };
        let foreign = (torn.is_none() && rest != b"\n").then(|| foreign(rest));
        if let Some(problem) = problem.or(foreign) {
            damage.get_or_insert((place, problem));
            lost_behind += usize::from(rest.trim_ascii().len() >= SEAL_BYTES);
        }
        cut = torn.filter(|_| rest != b"\n").map(|_| behind);
        at = next;
    }
    let events = records.keys().next_back().map_or(0, |last| *last as usize);
    let lines = lost + events - records.len() + lost_behind;
    let (good_bytes, end) = match (damage, cut) {
        (Some((place, problem)), _) => {
            let line = text[..place].split(|byte| *byte == b'\n').count();
            let end = JournalEnd::Damaged {
                line,
                problem,
                lines,
            };
            (place, end)
        }
        (None, Some(place)) => {
            let bytes = text.len() - place;
            (place, JournalEnd::Cut { bytes })
        }
        (None, None) => (text.len(), JournalEnd::Clean),
    };
    ReadJournal {
        records: records.into_values().collect(),
        good_bytes,
        end,
    }
}

fn find(bytes: &[u8], part: &[u8]) -> Option<usize> {
    bytes.windows(part.len()).position(|there| there == part)
}

/// A file that was saved as UTF-16 with its mark, as it was.
fn as_utf8(bytes: &[u8]) -> Cow<'_, [u8]> {
    let unit = match bytes {
        [0xff, 0xfe, ..] => u16::from_le_bytes,
        [0xfe, 0xff, ..] => u16::from_be_bytes,
        _ => return bytes.into(),
    };
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    let units: Vec<u16> = units.collect();
    String::from_utf16_lossy(&units).into_bytes().into()
}

/// The record that a text begins with, and what stands behind it; all of it if there is none.
fn split_record(text: &[u8]) -> (Result<Record, Damage>, &[u8]) {
    if !text.starts_with(START) {
        return (Err(foreign(text)), text);
    }
    let end = find(text, SEAL).map(|seal| seal + SEAL_BYTES);
    let parts = end.and_then(|end| text.split_at_checked(end));
    let (record, rest) = parts.unwrap_or((text, b""));
    match read_line(record) {
        Ok(record) => (Ok(record), rest),
        Err(problem) => (Err(problem), text),
    }
}

/// Whether the last bytes of a journal are what a record begins with, or what a power cut leaves in the place of one.
fn is_torn(tail: &[u8]) -> bool {
    let begins = tail.starts_with(START) && !tail.contains(&b'\n');
    begins || START.starts_with(tail) || tail.iter().all(|byte| *byte == 0)
}

fn foreign(text: &[u8]) -> Damage {
    let shown = text[..text.len().min(16)].escape_ascii();
    let what = match text {
        [] => "two records".to_owned(),
        _ => format!("\"{shown}\""),
    };
    Damage::Foreign { what }
}

/// The lines of a journal that holds these records, with a note in place of each that is lost.
///
/// # Errors
/// As [`write_line`].
pub fn write_lines(records: &[Record]) -> Result<Vec<u8>, JournalError> {
    let mut lines = Vec::new();
    let mut last = 0;
    for record in records {
        for seq in last + 1..record.seq {
            let text = format!("event {seq} was lost: its line in the journal was damaged");
            lines.extend(write_line(&Record {
                seq,
                utc: record.utc,
                t_s: record.t_s,
                event: Event::Note(Noted { cell: None, text }),
            })?);
        }
        lines.extend(write_line(record)?);
        last = record.seq;
    }
    Ok(lines)
}

fn read_line(line: &[u8]) -> Result<Record, Damage> {
    let at = line
        .len()
        .checked_sub(SEAL_BYTES)
        .ok_or(Damage::NotSealed)?;
    let (body, seal) = line.split_at(at);
    let found = seal
        .strip_prefix(b",\"crc\":\"")
        .and_then(|rest| rest.strip_suffix(b"\"}"))
        .and_then(|digits| std::str::from_utf8(digits).ok())
        .filter(|digits| digits.bytes().all(|digit| digit.is_ascii_hexdigit()))
        .and_then(|digits| u32::from_str_radix(digits, 16).ok())
        .ok_or(Damage::NotSealed)?;
    let made = checksum(body);
    if found != made {
        return Err(Damage::Checksum { found, made });
    }
    let mut object = body.to_vec();
    object.push(b'}');
    serde_json::from_slice(&object).map_err(|error| Damage::NotUnderstood {
        what: error.to_string(),
    })
}

/// The checksum of a line, CRC-32C (Castagnoli).
#[must_use]
pub fn checksum(bytes: &[u8]) -> u32 {
    const CASTAGNOLI: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISCSI);
    CASTAGNOLI.checksum(bytes)
}

/// The line of a record, line break included.
///
/// # Errors
/// [`JournalError::NotWritable`] for a number that is not finite, which JSON has no word for.
pub fn write_line(record: &Record) -> Result<Vec<u8>, JournalError> {
    let not_writable = |what: String| JournalError::NotWritable { what };
    let mut line = serde_json::to_vec(record).map_err(|error| not_writable(error.to_string()))?;
    // The closing brace comes behind the checksum.
    line.pop();
    let crc = checksum(&line);
    line.extend_from_slice(format!(",\"crc\":\"{crc:08x}\"}}\n").as_bytes());
    match read_line(&line[..line.len() - 1]) {
        Ok(back) if back == *record => Ok(line),
        Ok(_) => Err(not_writable("a number is not finite".to_owned())),
        Err(damage) => Err(not_writable(damage.to_string())),
    }
}

/// Why a record is not in the journal.
#[derive(Debug, Error, Diagnostic)]
pub enum JournalError {
    /// A record that would not come back as it was.
    #[error("an event cannot be written to the journal: {what}")]
    #[diagnostic(code(stiffbench::session::not_writable))]
    NotWritable {
        /// The error of the writer.
        what: String,
    },
    /// The file took no more.
    #[error("the journal could not be written: {source}")]
    #[diagnostic(
        code(stiffbench::session::journal_write),
        help(
            "nothing that was confirmed is lost. Make room on the disk, or make the folder writable, then: stiffbench session resume FOLDER"
        )
    )]
    Write {
        /// The error of the operating system.
        source: io::Error,
    },
    /// An earlier record could not be written, so nothing may follow it.
    #[error("the journal is closed, since an earlier event could not be written")]
    #[diagnostic(
        code(stiffbench::session::journal_closed),
        help("stiffbench session resume FOLDER takes the session up again")
    )]
    Closed,
}

/// Where journal lines go: a file, or a double of tests.
pub trait Store: Write {
    /// Returns once everything written so far is on the disk.
    ///
    /// # Errors
    /// The error of the operating system.
    fn sync(&mut self) -> io::Result<()>;
}

impl Store for Vec<u8> {
    fn sync(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The end of a journal, where events are added.
#[derive(Debug)]
pub struct Journal<S: Store> {
    store: S,
    next: u64,
    failed: bool,
}

impl<S: Store> Journal<S> {
    /// A journal that goes on behind `records` records.
    pub fn behind(store: S, records: u64) -> Self {
        Self {
            store,
            next: records + 1,
            failed: false,
        }
    }

    /// Adds an event and returns once it is on the disk.
    ///
    /// # Errors
    /// [`JournalError`]; the event then does not count, and nothing can be added any more, since half a line may stand there.
    pub fn append(
        &mut self,
        event: Event,
        utc: Timestamp,
        t_s: f64,
    ) -> Result<Record, JournalError> {
        if self.failed {
            return Err(JournalError::Closed);
        }
        let seq = self.next;
        let record = Record {
            seq,
            utc,
            t_s,
            event,
        };
        let line = write_line(&record)?;
        let written = self.store.write_all(&line);
        let synced = written
            .and_then(|()| self.store.flush())
            .and_then(|()| self.store.sync());
        if let Err(source) = synced {
            self.failed = true;
            return Err(JournalError::Write { source });
        }
        self.next += 1;
        Ok(record)
    }

    /// What the lines went to.
    pub fn into_store(self) -> S {
        self.store
    }
}
