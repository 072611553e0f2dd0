//! The bytes of a reading: where they lie in the trace of the gauge, and whether they are still there.

use std::collections::BTreeMap;
use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_gauges::trace::{GaugeTrace, What};
use stiffbench_gauges::{Channel, raw_text};

use super::event::TakenReading;
use super::inside::read_inside;
use super::state::SessionState;

/// Where the packet of a value lies among the bytes that a gauge sent.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct RawBytes {
    /// Which gauge.
    pub channel: Channel,
    /// The trace, a file in the folder `raw`.
    pub file: String,
    /// The first byte of the packet among those received in this trace, from 0.
    pub from: u64,
    /// The byte behind its last.
    pub to: u64,
}

/// The readings of a session beside the bytes of its gauges.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct RawCheck {
    /// Values whose bytes are in their trace.
    pub found: usize,
    /// Numbers of the last readings, whose bytes a session that was broken off had not written into the trace yet.
    pub behind: Vec<u32>,
    /// Values whose bytes are others, or are missing.
    pub wrong: Vec<WrongBytes>,
}

/// A value that its bytes do not confirm.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct WrongBytes {
    /// Number of the reading.
    pub number: u32,
    /// Which gauge.
    pub channel: Channel,
    /// What is wrong.
    pub problem: String,
}

/// The bytes that a trace holds from its gauge; `None` for a file that cannot be read.
struct Received {
    bytes: Vec<u8>,
    complete: bool,
    damaged: bool,
}

impl Received {
    fn read(folder: &Path, name: &str) -> Option<Self> {
        let bytes = read_inside(folder, Path::new("raw").join(name)).ok()?;
        let trace = GaugeTrace::parse(&bytes, name).ok()?;
        let received = trace.entries.iter().filter_map(|entry| match &entry.what {
            What::Received(bytes) => Some(bytes.as_slice()),
            _ => None,
        });
        let bytes = received.flatten().copied().collect();
        // Of a trace that was broken off the last line may be cut.
        let damaged = trace.damage.len() > usize::from(!trace.complete);
        Some(Self {
            bytes,
            complete: trace.complete,
            damaged,
        })
    }
}

/// Looks for the bytes of every reading in the traces of a session folder.
#[must_use]
pub fn check_raw_bytes(folder: &Path, state: &SessionState) -> RawCheck {
    let mut traces: BTreeMap<&str, Option<Received>> = BTreeMap::new();
    let mut check = RawCheck::default();
    for taken in state.readings.iter().map(|kept| &kept.taken) {
        for place in &taken.raw_bytes {
            let is_name = !place.file.contains(['/', '\\']);
            let trace = traces.entry(&place.file).or_insert_with(|| {
                is_name
                    .then(|| Received::read(folder, &place.file))
                    .flatten()
            });
            match problem(taken, place, trace.as_ref()) {
                Ok(true) => check.found += 1,
                Ok(false) if check.behind.last() == Some(&taken.number) => {}
                Ok(false) => check.behind.push(taken.number),
                Err(problem) => check.wrong.push(WrongBytes {
                    number: taken.number,
                    channel: place.channel,
                    problem,
                }),
            }
        }
    }
    check
}

/// Whether the bytes are there; `false` where the trace was broken off before them.
fn problem(
    taken: &TakenReading,
    place: &RawBytes,
    trace: Option<&Received>,
) -> Result<bool, String> {
    let Some(trace) = trace else {
        return Err(format!("raw/{} cannot be read", place.file));
    };
    let range = usize::try_from(place.from)
        .ok()
        .zip(usize::try_from(place.to).ok());
    let bytes = range.and_then(|(from, to)| trace.bytes.get(from..to));
    match bytes {
        Some(bytes) if raw_text(bytes).contains(taken.raw_of(place.channel)) => Ok(true),
        Some(bytes) => Err(format!(
            "bytes {} to {} of raw/{} are \"{}\", the reading has \"{}\"",
            place.from,
            place.to,
            place.file,
            raw_text(bytes),
            taken.raw_of(place.channel)
        )),
        None if trace.complete || trace.damaged => Err(format!(
            "raw/{} has no bytes {} to {}",
            place.file, place.from, place.to
        )),
        None => Ok(false),
    }
}
