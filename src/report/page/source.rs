//! The data of a report, opened.

use std::path::{Path, PathBuf};

use crate::analysis::{
    AnalysisError, Inputs, LoadedLoadCases, LoadedSession, OpenSettings, VectorSession,
    open_together,
};
use crate::stiffness::{Branches, StiffnessTable};

use super::session::PageSession;

/// The sessions of a report, opened.
#[derive(Debug, Default)]
pub struct PageSource {
    /// The sessions, in the order in which they were named. Each is called by its identifier or file name, wherever it lies.
    pub sessions: Vec<LoadedSession>,
    /// Load cases, if the report is of them; it has no sessions with readings along the load then.
    pub load_cases: Vec<LoadedLoadCases>,
    pub(super) tables: Vec<StiffnessTable>,
    pub(super) parts: Vec<PageSession>,
}

impl PageSource {
    /// Opens sessions and computes their stiffness.
    ///
    /// # Errors
    /// For data that are not there or cannot be read, and a table that differs from its journal.
    pub fn open(paths: &[PathBuf], options: &OpenSettings) -> Result<Self, AnalysisError> {
        let opened: Result<Vec<_>, _> = paths.iter().map(|path| open(path, options)).collect();
        Self::of(opened?)
    }

    /// Opens sessions, or load cases, of one robot that are fitted and diagnosed together.
    ///
    /// # Errors
    /// As [`open`](Self::open), and for sessions that do not go together.
    pub fn open_joined(paths: &[PathBuf], options: &OpenSettings) -> Result<Self, AnalysisError> {
        let Some((first, further)) = paths.split_first() else {
            return Self::of(Vec::new());
        };
        if LoadedLoadCases::is_at(first) {
            return Self::of_load_cases(paths, options);
        }
        let first = LoadedSession::open(first, options)?;
        let opened = open_together(first, further, options)?;
        Self::of(opened.into_iter().map(called_by_short_name).collect())
    }

    fn of(sessions: Vec<LoadedSession>) -> Result<Self, AnalysisError> {
        let mut source = Self::default();
        for session in &sessions {
            let table = session.stiffness(Branches::LoadingOnly)?;
            let history = session.history()?;
            let files = session.file_hashes()?;
            let part = PageSession::new(session, table.clone(), history.as_ref(), &files);
            source.parts.push(part);
            source.tables.push(table);
        }
        Ok(Self { sessions, ..source })
    }

    fn of_load_cases(paths: &[PathBuf], options: &OpenSettings) -> Result<Self, AnalysisError> {
        let mut source = Self::default();
        for path in paths {
            let vectors = VectorSession::open(path, options)?;
            let mut loaded = LoadedLoadCases::open(path, options)?;
            let short = loaded.short_name();
            loaded.warnings = with_short_name(&loaded.warnings, &loaded.name, &short);
            loaded.name = short;
            let history = loaded.history()?;
            let files = loaded.file_hashes()?;
            let part =
                PageSession::of_load_cases(&loaded, vectors.as_ref(), history.as_ref(), &files);
            source.parts.push(part);
            source.load_cases.push(loaded);
        }
        Ok(source)
    }

    /// What the report is made of.
    #[must_use]
    pub fn inputs(&self) -> Inputs {
        let inputs = self
            .sessions
            .iter()
            .fold(Inputs::default(), Inputs::with_session);
        self.load_cases.iter().fold(inputs, Inputs::with_load_cases)
    }

    /// What a user should know of the data.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let of_sessions = self.sessions.iter().flat_map(|one| &one.warnings);
        let of_load_cases = self.load_cases.iter().flat_map(|one| &one.warnings);
        of_sessions.chain(of_load_cases).cloned().collect()
    }

    /// Gauges whose calibration had run out when they were used.
    #[must_use]
    pub fn overdue(&self) -> Vec<String> {
        let gauges = self.parts.iter().flat_map(|part| {
            let overdue = part.gauges.iter().filter(|gauge| gauge.overdue);
            overdue.map(|gauge| format!("{} of {} (due {})", gauge.name, part.name, gauge.due))
        });
        gauges.collect()
    }

    /// What a reader must not overlook, each with a sentence.
    pub(super) fn marks(&self) -> Vec<(&'static str, &'static str)> {
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
                any(&|part| part.complete == Some(false)),
                "PARTIAL",
                "The session is not complete: planned readings are missing.",
            ),
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
        true_ones.map(|(_, mark, words)| (mark, words)).collect()
    }
}

fn open(path: &Path, options: &OpenSettings) -> Result<LoadedSession, AnalysisError> {
    LoadedSession::open(path, options).map(called_by_short_name)
}

/// The session called by its identifier, in its notes too, so that a report is the same wherever the session lies.
fn called_by_short_name(mut session: LoadedSession) -> LoadedSession {
    let short = session.short_name();
    let path = std::mem::replace(&mut session.name, short.clone());
    session.warnings = with_short_name(&session.warnings, &path, &short);
    session
}

/// Notes with a path put under another name.
fn with_short_name(notes: &[String], path: &str, short: &str) -> Vec<String> {
    notes
        .iter()
        .map(|note| renamed(note, path, short))
        .collect()
}

/// A text with a path, where it stands as a word, put under another name.
fn renamed(text: &str, path: &str, name: &str) -> String {
    let is_edge = |c: Option<char>| !c.is_some_and(|c| c.is_alphanumeric() || "-_.".contains(c));
    let (mut renamed, mut rest) = (String::new(), text);
    while let Some(at) = rest.find(path).filter(|_| !path.is_empty()) {
        let (before, behind) = (&rest[..at], &rest[at + path.len()..]);
        let before_it = before.chars().last().or_else(|| renamed.chars().last());
        let is_word = is_edge(before_it) && is_edge(behind.chars().next());
        renamed.push_str(before);
        renamed.push_str(if is_word { name } else { path });
        rest = behind;
    }
    renamed + rest
}

#[cfg(test)]
mod tests {
    use super::renamed;

    #[test]
    fn a_path_is_renamed_as_a_word_only() {
        let text = "e/readings.csv:3: the value e is held; see/e.toml";
        let expected = "id/readings.csv:3: the value id is held; see/e.toml";
        assert_eq!(renamed(text, "e", "id"), expected);
        assert_eq!(renamed("a b", "", "id"), "a b");
    }
}
