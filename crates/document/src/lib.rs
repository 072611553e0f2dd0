//! A result for people, once: headings, paragraphs, lists and tables. A terminal shows it as text that is Markdown at the same time, so that it can be
//! pasted; a report is the same blocks in HTML, Markdown or Typst.

mod markup;
mod table;
mod terminal;
mod units;

use schemars::JsonSchema;
use serde::Serialize;

pub use markup::{Markup, misleads};
pub use table::{ColumnKind, Table, TableCell, TableColumn, TableOf};
pub use units::{ascii_units, in_ascii, sign_of};

/// A part of a document.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum DocumentBlock {
    /// A heading.
    Heading {
        /// 1 for a section, 2 for a part of one, and so on.
        level: usize,
        /// Its words, as in a sentence.
        text: String,
    },
    /// A paragraph.
    Paragraph {
        /// Its words.
        text: String,
    },
    /// A paragraph that stands out.
    Note {
        /// What it is.
        note: NoteKind,
        /// Its words.
        text: String,
    },
    /// A list.
    List {
        /// Its entries.
        items: Vec<String>,
    },
    /// Names with their values.
    Pairs {
        /// Each name and its value.
        pairs: Vec<(String, String)>,
    },
    /// Lines that stand as they are: commands, names of files, bytes.
    Lines {
        /// The lines.
        lines: Vec<String>,
    },
    /// A figure. Its drawing is no text: it belongs to what holds the document, under the same name.
    Figure {
        /// Name, also of its file.
        name: String,
        /// What it shows.
        title: String,
        /// Whether it is higher than wide, so that it needs most of a printed page.
        tall: bool,
    },
    /// A table.
    Table(Table),
}

/// What a paragraph is that stands out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum NoteKind {
    /// A result.
    Answer,
    /// What follows from the results.
    Verdict,
    /// What no reader must overlook.
    Warning,
    /// What explains something else.
    Remark,
}

/// The blocks of a document in their order.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, JsonSchema)]
#[serde(transparent)]
pub struct Document {
    blocks: Vec<DocumentBlock>,
}

impl Document {
    /// A document without blocks.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A document that begins with a paragraph.
    #[must_use]
    pub fn of(paragraph: impl Into<String>) -> Self {
        let mut document = Self::new();
        document.paragraph(paragraph);
        document
    }

    /// A document that begins with a heading.
    #[must_use]
    pub fn under(heading: impl Into<String>) -> Self {
        let mut document = Self::new();
        document.heading(heading);
        document
    }

    /// A list under its heading; empty without entries.
    #[must_use]
    pub fn list_under(
        heading: impl Into<String>,
        texts: impl IntoIterator<Item: Into<String>>,
    ) -> Self {
        let (mut document, mut list) = (Self::new(), Self::new());
        list.items(texts);
        document.section(heading, list);
        document
    }

    /// Whether it has no block.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// Its blocks.
    #[must_use]
    pub fn blocks(&self) -> &[DocumentBlock] {
        &self.blocks
    }

    /// Adds a heading.
    pub fn heading(&mut self, text: impl Into<String>) {
        let text = text.into();
        self.blocks.push(DocumentBlock::Heading { level: 1, text });
    }

    /// Adds another document under a heading, its own headings a level lower; nothing if it has no block.
    pub fn section(&mut self, heading: impl Into<String>, mut inner: Self) {
        if inner.is_empty() {
            return;
        }
        for block in &mut inner.blocks {
            if let DocumentBlock::Heading { level, .. } = block {
                *level += 1;
            }
        }
        self.heading(heading);
        self.append(inner);
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: impl Into<String>) {
        let text = text.into();
        self.blocks.push(DocumentBlock::Paragraph { text });
    }

    /// Adds paragraphs.
    pub fn paragraphs(&mut self, texts: impl IntoIterator<Item: Into<String>>) {
        for text in texts {
            self.paragraph(text);
        }
    }

    /// Adds a paragraph that stands out.
    pub fn note(&mut self, note: NoteKind, text: impl Into<String>) {
        let text = text.into();
        self.blocks.push(DocumentBlock::Note { note, text });
    }

    /// Adds entries to the list at the end, or begins one.
    pub fn items(&mut self, texts: impl IntoIterator<Item: Into<String>>) {
        for text in texts {
            self.item(text);
        }
    }

    /// Adds an entry to the list at the end, or begins one.
    pub fn item(&mut self, text: impl Into<String>) {
        match self.blocks.last_mut() {
            Some(DocumentBlock::List { items }) => items.push(text.into()),
            _ => self.blocks.push(DocumentBlock::List {
                items: vec![text.into()],
            }),
        }
    }

    /// Adds a name with its value to the pairs at the end, or begins them.
    pub fn pair(&mut self, name: impl Into<String>, value: impl Into<String>) {
        let pair = (name.into(), value.into());
        match self.blocks.last_mut() {
            Some(DocumentBlock::Pairs { pairs }) => pairs.push(pair),
            _ => self.blocks.push(DocumentBlock::Pairs { pairs: vec![pair] }),
        }
    }

    /// Adds lines that stand as they are to those at the end, or begins them.
    pub fn lines(&mut self, text: impl AsRef<str>) {
        let new = text.as_ref().lines().map(str::to_owned);
        match self.blocks.last_mut() {
            Some(DocumentBlock::Lines { lines }) => lines.extend(new),
            _ => self.blocks.push(DocumentBlock::Lines {
                lines: new.collect(),
            }),
        }
    }

    /// Adds the command that comes next, without the name of the program.
    pub fn next(&mut self, command: impl std::fmt::Display) {
        self.lines(format!("Next: stiffbench {command}"));
    }

    /// Adds a figure.
    pub fn figure(&mut self, name: impl Into<String>, title: impl Into<String>, tall: bool) {
        let (name, title) = (name.into(), title.into());
        self.blocks
            .push(DocumentBlock::Figure { name, title, tall });
    }

    /// Adds a table.
    pub fn table(&mut self, table: impl Into<Table>) {
        self.blocks.push(DocumentBlock::Table(table.into()));
    }

    /// Adds another document; its list goes on the one at the end.
    pub fn append(&mut self, other: Self) {
        for block in other.blocks {
            match block {
                DocumentBlock::List { items } => items.into_iter().for_each(|item| self.item(item)),
                DocumentBlock::Lines { lines } => self.lines(lines.join("\n")),
                block => self.blocks.push(block),
            }
        }
    }
}
