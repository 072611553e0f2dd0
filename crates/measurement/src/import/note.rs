//! What an import decided.

use super::runs::RunDoubt;

/// What the file leaves open and the import decided, in sentences.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ImportNotes {
    /// The sentences.
    pub texts: Vec<String>,
    /// Whether one of them puts the result in doubt.
    pub are_doubtful: bool,
}

impl ImportNotes {
    pub(super) fn note(&mut self, text: impl Into<String>) {
        self.texts.push(text.into());
    }

    /// Notes what puts the result in doubt.
    pub(super) fn doubt(&mut self, text: impl Into<String>) {
        self.note(text);
        self.are_doubtful = true;
    }

    /// Notes that it was guessed where the runs begin, and may be guessed wrongly.
    ///
    /// # Arguments
    /// - `column`: that numbers them; `None` where they were found in the path of the load.
    /// - `cell`: the first pose and direction with such runs.
    pub(super) fn doubt_runs(&mut self, column: Option<&str>, cell: &str, why: RunDoubt) {
        self.doubt(match column {
            None => format!(
                "the runs are uncertain, first in {cell}: {why}; number them in a column and name it with --map repeat=COLUMN"
            ),
            Some(column) => format!(
                "the runs of column `{column}` are uncertain, first in {cell}: {why}; if poses or directions share their numbers, name those columns with --map pose=COLUMN,direction=COLUMN"
            ),
        });
    }
}
