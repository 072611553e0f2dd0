//! What the reader left out.

use std::fmt;

use crate::readings::left_out;

/// A row without a value that it must have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Incomplete {
    /// Its line.
    pub line: u32,
    /// The first column without a value.
    pub column: String,
}

/// Lines that gave no reading: nothing is dropped silently.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ExcludedLines {
    /// Rows without a value that they must have.
    pub incomplete: Vec<Incomplete>,
    /// Lines without any value.
    pub blank: Vec<u32>,
    /// Comment lines.
    pub comments: Vec<u32>,
}

impl fmt::Display for ExcludedLines {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let incomplete = self.incomplete.first().map(|row| row.line);
        let groups = [
            ("incomplete", self.incomplete.len(), incomplete),
            ("blank", self.blank.len(), self.blank.first().copied()),
            (
                "comments",
                self.comments.len(),
                self.comments.first().copied(),
            ),
        ];
        f.write_str(&left_out(&groups))
    }
}
