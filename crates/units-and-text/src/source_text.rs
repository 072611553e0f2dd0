//! Where in a text something stands, and errors that point at it.
//!
//! Leaf module.

use std::fmt::{self, Display};
use std::ops::Range;
use std::sync::Arc;

use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode, SourceSpan};

/// Lines that are longer are not quoted whole: who prints the error shows the part about its place.
const LONGEST_QUOTED: usize = 1000;

/// A named text: a file's content under the name the user knows it by.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourceText {
    /// Path or shipped name.
    pub name: String,
    /// The whole text.
    pub text: String,
}

impl SourceText {
    /// A text under a name.
    #[must_use]
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            text: text.into(),
        }
    }

    /// Line and column of a byte offset, both from 1; columns count characters, without a byte order mark.
    #[must_use]
    pub fn line_and_column(&self, offset: usize) -> (usize, usize) {
        let mut end = offset.min(self.text.len());
        while !self.text.is_char_boundary(end) {
            end -= 1;
        }
        let before = self.text[..end].trim_start_matches('\u{feff}');
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        (line, column)
    }

    /// This text in the form error reports quote from.
    #[must_use]
    pub fn named_source(&self) -> NamedSource<String> {
        NamedSource::new(&self.name, self.text.clone()).with_language("TOML")
    }
}

/// A problem at one place of a text: shown as `file:line:column: problem`, with the line quoted; code and help are the problem's.
#[derive(Debug, Clone)]
pub struct PlacedError<P> {
    /// Name of the file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What is wrong.
    pub problem: Box<P>,
    /// What to do about it.
    pub help: Option<String>,
    /// The text, where the lines about the place are short enough to be quoted.
    source_text: Option<Arc<NamedSource<String>>>,
    span: SourceSpan,
}

impl<P: Diagnostic> PlacedError<P> {
    /// A problem at a byte range of a text.
    #[must_use]
    pub fn new(source: &SourceText, span: Range<usize>, problem: P) -> Self {
        let (line, column) = source.line_and_column(span.start);
        let (last, _) = source.line_and_column(span.end);
        let quoted = source.text.lines().take(last + 1);
        let is_long = quoted
            .skip(line.saturating_sub(2))
            .any(|text| text.len() > LONGEST_QUOTED);
        Self {
            file: source.name.clone(),
            line,
            column,
            help: problem.help().map(|help| help.to_string()),
            problem: Box::new(problem),
            source_text: (!is_long).then(|| Arc::new(source.named_source())),
            span: span.into(),
        }
    }

    /// The same with other words on what to do, if there are any.
    #[must_use]
    pub fn with_help(mut self, help: Option<String>) -> Self {
        self.help = help.or(self.help);
        self
    }

    /// The same place with its problem stated differently.
    #[must_use]
    pub fn map<Q: Diagnostic>(self, told: impl FnOnce(P) -> Q) -> PlacedError<Q> {
        let problem = told(*self.problem);
        PlacedError {
            file: self.file,
            line: self.line,
            column: self.column,
            help: problem.help().map(|help| help.to_string()),
            problem: Box::new(problem),
            source_text: self.source_text,
            span: self.span,
        }
    }
}

impl<P> PlacedError<P> {
    /// `file:line:column`.
    #[must_use]
    pub fn place(&self) -> String {
        format!("{}:{}:{}", self.file, self.line, self.column)
    }
}

impl<P: Display> Display for PlacedError<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}:{}:{}: {}",
            self.file, self.line, self.column, self.problem
        )
    }
}

impl<P: Diagnostic> std::error::Error for PlacedError<P> {}

impl<P: Diagnostic> Diagnostic for PlacedError<P> {
    fn code<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        self.problem.code()
    }

    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(help) as _)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(self.source_text.as_deref()?)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let here = LabeledSpan::new_with_span(Some("here".to_owned()), self.span);
        Some(Box::new(std::iter::once(here)))
    }
}
