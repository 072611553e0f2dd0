//! The journal: `journal.jsonl`, one event a line, each with a sequence number, its time and a checksum.
//!
//! A line is a JSON object that ends in `,"crc":"xxxxxxxx"}`: the CRC-32C, in hexadecimal, of all bytes of the line before that. A record
//! counts once its line break is on the disk; what stands behind the last one was never acknowledged.

use std::io::{self, Write};

use jiff::Timestamp;
use miette::Diagnostic;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::event::{Event, Noted};

/// Bytes of `,"crc":"xxxxxxxx"}`.
const SEAL_BYTES: usize = 18;

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
    /// A line without a line break behind the last: the program or the machine stopped while writing it. It was never acknowledged.
    Cut {
        /// Its bytes.
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
    #[error("it is whole but not understood ({what}): a newer version may have written it")]
    NotUnderstood {
        /// The error of the reader.
        what: String,
    },
    /// A record is missing, or stands here twice.
    #[error("its sequence number is {found}, expected {expected}")]
    Sequence {
        /// As written.
        found: u64,
        /// What was due.
        expected: u64,
    },
}

/// Reads a journal. Takes any bytes. A record counts if its checksum holds and it follows those before it, so that one damaged line costs one
/// record and no more.
#[must_use]
pub fn read_journal(bytes: &[u8]) -> ReadJournal {
    let mut records: Vec<Record> = Vec::new();
    let mut damage: Option<(usize, usize, Damage)> = None;
    // Records that are lost, and damaged lines since the last good one, which stand for some of them.
    let (mut lost, mut damaged_lines) = (0, 0);
    let (mut at, mut line) = (0, 0);
    while let Some(length) = bytes[at..].iter().position(|&byte| byte == b'\n') {
        line += 1;
        let last = records.last().map_or(0, |record| record.seq);
        let read = read_line(&bytes[at..at + length]);
        let problem = match &read {
            Err(problem) => Some(problem.clone()),
            Ok(record) => (record.seq != last + 1).then_some(Damage::Sequence {
                found: record.seq,
                expected: last + 1,
            }),
        };
        match read {
            Ok(record) if record.seq > last => {
                lost += damaged_lines.max((record.seq - last - 1) as usize);
                damaged_lines = 0;
                records.push(record);
            }
            _ => damaged_lines += 1,
        }
        if let Some(problem) = problem {
            damage.get_or_insert((line, at, problem));
        }
        at += length + 1;
    }
    let (good_bytes, end) = match (damage, bytes.len() - at) {
        (Some((line, good_bytes, problem)), _) => {
            let lines = lost + damaged_lines;
            let end = JournalEnd::Damaged {
                line,
                problem,
                lines,
            };
            (good_bytes, end)
        }
        (None, 0) => (at, JournalEnd::Clean),
        (None, bytes) => (at, JournalEnd::Cut { bytes }),
    };
    ReadJournal {
        records,
        good_bytes,
        end,
    }
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
    let made = crc32c::crc32c(body);
    if found != made {
        return Err(Damage::Checksum { found, made });
    }
    let mut object = body.to_vec();
    object.push(b'}');
    serde_json::from_slice(&object).map_err(|error| Damage::NotUnderstood {
        what: error.to_string(),
    })
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
    let crc = crc32c::crc32c(&line);
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
