//! The data of a report, opened.

use std::path::PathBuf;

use crate::analysis::{Data, Failure, Inputs, LoadedSession, OpenSettings, SessionTable};
use crate::count::counted;
use crate::stiffness::{Branches, StiffnessTable};

use super::session::PageSession;

/// Cells that a sentence on what is missing names.
const MISSING_NAMED: usize = 6;

/// The data of a report, opened.
#[derive(Debug)]
pub struct PageSource {
    /// The data, in the order in which they were named. Each is called by its identifier or file name, wherever it lies.
    pub(super) data: Data,
    pub(super) tables: Vec<StiffnessTable>,
    pub(super) parts: Vec<PageSession>,
}

impl PageSource {
    /// Opens sessions and computes their stiffness.
    ///
    /// # Errors
    /// For data that are not there or cannot be read, and a table that differs from its journal.
    pub fn open(paths: &[PathBuf], options: &OpenSettings) -> Result<Self, Failure> {
        let opened = paths.iter().map(|path| LoadedSession::open(path, options));
        Self::of(Data::Readings(opened.collect::<Result<_, Failure>>()?))
    }

    /// Opens sessions, or load cases, of one robot that are fitted and diagnosed together.
    ///
    /// # Errors
    /// As [`open`](Self::open), and for data that do not go together.
    pub fn open_joined(paths: &[PathBuf], options: &OpenSettings) -> Result<Self, Failure> {
        Self::of(match paths.split_first() {
            None => Data::Readings(Vec::new()),
            Some((first, further)) => {
                Data::open_readings(first, options)?.with(further, options)?
            }
        })
    }

    fn of(mut data: Data) -> Result<Self, Failure> {
        let (mut tables, mut parts) = (Vec::new(), Vec::new());
        match &mut data {
            Data::Readings(sessions) => {
                for session in sessions {
                    call_by_short_name(session);
                    let table = session.stiffness(Branches::LoadingOnly)?;
                    parts.push(PageSession::new(session, table.clone())?);
                    tables.push(table);
                }
            }
            Data::LoadCases(loaded) => {
                for one in loaded {
                    call_by_short_name(one);
                    parts.push(PageSession::of_load_cases(one)?);
                }
            }
            Data::Stiffness { .. } => {}
        }
        Ok(Self {
            data,
            tables,
            parts,
        })
    }

    /// The sessions; none of load cases.
    #[must_use]
    pub fn sessions(&self) -> &[LoadedSession] {
        match &self.data {
            Data::Readings(sessions) => sessions,
            Data::LoadCases(_) | Data::Stiffness { .. } => &[],
        }
    }

    /// What the report is made of.
    #[must_use]
    pub fn inputs(&self) -> Inputs {
        Inputs::default().with_data(&self.data)
    }

    /// What a user should know of the data.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        self.data.warnings()
    }

    /// Gauges whose calibration had run out when they were used.
    #[must_use]
    pub fn overdue(&self) -> Vec<String> {
        let several = self.parts.len() > 1;
        let gauges = self.parts.iter().flat_map(|part| {
            part.overdue.iter().map(move |gauge| {
                if several {
                    format!("{}: {gauge}", part.name)
                } else {
                    gauge.clone()
                }
            })
        });
        gauges.collect()
    }

    /// What a reader must not overlook, each with a sentence.
    pub(super) fn marks(&self) -> Vec<(&'static str, String)> {
        let any = |holds: &dyn Fn(&PageSession) -> bool| self.parts.iter().any(holds);
        let origin = |word: &str| {
            any(&|part| {
                part.origin
                    .as_ref()
                    .is_some_and(|origin| origin.contains(word))
            })
        };
        let imported = any(&|part| part.imported);
        // What was never measured needs no journal; one that it has must agree.
        let unprotected =
            any(&|part| !part.protected && (part.origin.is_none() || part.complete.is_some()));
        let marks = [
            (
                origin("emulated"),
                "EMULATED",
                "The readings come from emulated gauges; nothing was measured.",
            ),
            (
                origin("simulated"),
                "SIMULATED",
                "The readings were simulated; nothing was measured.",
            ),
            (
                imported,
                "IMPORTED, NOT PROTECTED",
                "The readings were imported from another program; no journal protects them.",
            ),
            (
                unprotected && !imported,
                "NOT PROTECTED",
                "No journal protects the readings, or they differ from it: they may have been changed.",
            ),
        ];
        let true_ones = marks.into_iter().filter(|(is_true, ..)| *is_true);
        let marks = true_ones.map(|(_, mark, words)| (mark, words.to_owned()));
        let partial = self.partial().map(|words| ("PARTIAL", words));
        let overdue = self.overdue();
        let overdue = (!overdue.is_empty()).then(|| {
            let words = format!(
                "The calibration had run out when the readings were taken, and U relies on it: {}.",
                overdue.join(", ")
            );
            ("CALIBRATION OVERDUE", words)
        });
        partial.into_iter().chain(marks).chain(overdue).collect()
    }

    /// What is missing of sessions that are not complete, in a sentence.
    fn partial(&self) -> Option<String> {
        let several = self.parts.len() > 1;
        let partial = self
            .parts
            .iter()
            .filter(|part| part.complete == Some(false));
        let missing = partial.map(|part| {
            let (named, further) = part.missing.split_at(part.missing.len().min(MISSING_NAMED));
            let mut words = named.to_vec();
            if named.is_empty() {
                words.push("planned readings".to_owned());
            }
            if !further.is_empty() {
                words.push(counted(further.len(), "further cell"));
            }
            let words = words.join(", ");
            if several {
                format!("{words} of {}", part.name)
            } else {
                words
            }
        });
        let missing: Vec<String> = missing.collect();
        (!missing.is_empty()).then(|| {
            format!(
                "The session is not complete; missing: {}.",
                missing.join("; ")
            )
        })
    }
}

/// Calls a session by its identifier, in its notes too, so that a report is the same wherever the session lies.
fn call_by_short_name<T>(session: &mut SessionTable<T>) {
    let short = session.short_name();
    let path = std::mem::replace(&mut session.name, short);
    for note in &mut session.warnings {
        *note = renamed(note, &path, &session.name);
    }
}

/// A text with a path put under another name where it stands as the place of something: before a file in it, a line or a comparison with the
/// journal. Elsewhere it may be a word of the sentence.
fn renamed(text: &str, path: &str, name: &str) -> String {
    let continues = |c: char| c.is_alphanumeric() || "-_./\\".contains(c);
    let (mut renamed, mut rest) = (String::new(), text);
    while let Some(at) = rest.find(path).filter(|_| !path.is_empty()) {
        let (before, behind) = (&rest[..at], &rest[at + path.len()..]);
        let before_it = before.chars().last().or_else(|| renamed.chars().last());
        let is_whole = !before_it.is_some_and(continues);
        renamed.push_str(before);
        renamed.push_str(if is_whole && is_place(behind) {
            name
        } else {
            path
        });
        rest = behind;
    }
    renamed + rest
}

/// Whether what stands behind a name makes a place of it.
fn is_place(behind: &str) -> bool {
    let is_number = |text: &str| text.starts_with(|c: char| c.is_ascii_digit());
    let is_line = [":", ", line "]
        .iter()
        .any(|mark| behind.strip_prefix(mark).is_some_and(is_number));
    let file = behind.strip_prefix(['/', '\\']).unwrap_or_default();
    let end = file.find(|c: char| !(c.is_alphanumeric() || "-_./\\".contains(c)));
    let file = &file[..end.unwrap_or(file.len())];
    let extension = file.rsplit_once('.').map_or("", |(_, extension)| extension);
    is_line || !extension.is_empty() || behind.starts_with(" differs from the journal")
}

#[cfg(test)]
mod tests {
    use super::renamed;

    #[test]
    fn a_path_is_renamed_where_it_is_a_place() {
        let text = "e/readings.csv:3: the value e is held; see/e.toml, e/session.toml:1:2 and tree/e/x.csv";
        let expected = "id/readings.csv:3: the value e is held; see/e.toml, id/session.toml:1:2 and tree/e/x.csv";
        assert_eq!(renamed(text, "e", "id"), expected);
        assert_eq!(renamed("a b", "", "id"), "a b");
        assert_eq!(
            renamed("is, line 4: no is", "is", "id"),
            "id, line 4: no is"
        );
        assert_eq!(renamed("a.csv:4: a.csv.", "a.csv", "id"), "id:4: a.csv.");
        let trusted = "--trust-csv: /data/s/readings.csv differs from the journal in 1 value(s)";
        let path = "/data/s/readings.csv";
        let expected = "--trust-csv: id differs from the journal in 1 value(s)";
        assert_eq!(renamed(trusted, path, "id"), expected);
        assert_eq!(
            renamed("is\\session.toml:1", "is", "id"),
            "id\\session.toml:1"
        );
    }

    #[test]
    fn words_of_a_sentence_are_no_paths() {
        let notes = [
            "assumed: no values of `run`: each pose, direction and repeat is a separate run",
            "the resolution of the force gauge is not stated: its readings are whole multiples of 0.01 N, which is taken",
            "forces/displacements are a pair. The rest is assumed",
        ];
        for note in notes {
            for path in ["is", "a", "assumed", "run", "forces", "displacements"] {
                assert_eq!(renamed(note, path, "id"), note, "{path}");
            }
        }
    }
}
