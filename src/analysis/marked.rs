//! Readings that carry a mark: those that do not count, and those that were flagged.

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::readings::{ReadingStatus, ReadingTable};

/// Readings of one session with the same status and the same flag.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ReadingMark {
    /// The session, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub session: Option<String>,
    /// `rejected` or `superseded`: left out; `accepted`: used though flagged.
    pub status: String,
    /// Rule and reason as in the column `flag`; empty if there is none.
    pub flag: String,
    /// Their sequence numbers.
    pub readings: Vec<u32>,
}

impl ReadingMark {
    /// The marked readings of a table, in the order in which status and flag first appear.
    pub(super) fn of(table: &ReadingTable, session: Option<&str>) -> Vec<Self> {
        let mut groups: IndexMap<(String, String), Vec<u32>> = IndexMap::new();
        for reading in &table.readings {
            let flag = reading.text.as_ref().map_or("", |text| &text.flag);
            if reading.status != ReadingStatus::Accepted || !flag.is_empty() {
                let key = (reading.status.to_string(), flag.to_owned());
                groups.entry(key).or_default().push(reading.seq);
            }
        }
        let marked = groups.into_iter().map(|((status, flag), readings)| Self {
            session: session.map(str::to_owned),
            status,
            flag,
            readings,
        });
        marked.collect()
    }
}
