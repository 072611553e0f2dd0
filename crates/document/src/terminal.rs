//! A document as a terminal shows it.

use crate::{Document, DocumentBlock};

/// Width of paragraphs and lists.
const WIDTH: usize = 100;

impl Document {
    /// As a terminal shows it, each line ended: headings in capitals, an empty line between blocks but behind a heading and between
    /// a paragraph and its list, pairs or lines, and lines and their list.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::new();
        let mut last: Option<&DocumentBlock> = None;
        for block in self.blocks() {
            let goes_on = matches!(
                (last, block),
                (Some(DocumentBlock::Heading { .. }), _)
                    | (
                        Some(DocumentBlock::Paragraph { .. } | DocumentBlock::Note { .. }),
                        DocumentBlock::List { .. }
                            | DocumentBlock::Pairs { .. }
                            | DocumentBlock::Lines { .. }
                    )
                    | (
                        Some(DocumentBlock::Lines { .. }),
                        DocumentBlock::List { .. }
                    )
            );
            if last.is_some() && !goes_on {
                text.push('\n');
            }
            last = Some(block);
            match block {
                DocumentBlock::Heading { text: words, .. } => {
                    text.push_str(&words.to_uppercase());
                    text.push('\n');
                }
                DocumentBlock::Paragraph { text: words }
                | DocumentBlock::Note { text: words, .. } => {
                    text.push_str(&wrapped(words, WIDTH, "", ""));
                    text.push('\n');
                }
                DocumentBlock::List { items } => {
                    for item in items {
                        text.push_str(&wrapped(item, WIDTH, "- ", "  "));
                        text.push('\n');
                    }
                }
                DocumentBlock::Pairs { pairs } => {
                    let names = pairs.iter().map(|(name, _)| name.chars().count());
                    let indent = names.max().unwrap_or_default() + 2;
                    for (name, value) in pairs {
                        let first = format!("{name:<indent$}");
                        text.push_str(&wrapped(value, WIDTH, &first, &" ".repeat(indent)));
                        text.push('\n');
                    }
                }
                DocumentBlock::Lines { lines } => {
                    for line in lines {
                        text.push_str(line);
                        text.push('\n');
                    }
                }
                DocumentBlock::Figure { title, .. } => {
                    text.push_str(&wrapped(title, WIDTH, "Figure: ", "  "));
                    text.push('\n');
                }
                DocumentBlock::Table(table) => text.push_str(&table.text()),
            }
        }
        text
    }
}

impl From<Document> for String {
    fn from(document: Document) -> Self {
        document.text()
    }
}

/// A text in lines of at most so many characters, each after `indent`; the first after `first`.
fn wrapped(text: &str, width: usize, first: &str, indent: &str) -> String {
    let mut out = String::new();
    let mut line = first.to_owned();
    let mut empty = true;
    // A no-break space holds a number and its unit together.
    let words = text.split([' ', '\n', '\t']);
    for word in words.filter(|word| !word.is_empty()) {
        if !empty && line.chars().count() + 1 + word.chars().count() > width {
            out.push_str(line.trim_end());
            out.push('\n');
            indent.clone_into(&mut line);
            empty = true;
        }
        if !empty {
            line.push(' ');
        }
        line.push_str(word);
        empty = false;
    }
    out + line.trim_end()
}

#[cfg(test)]
mod tests {
    use insta::assert_snapshot;

    use super::*;
    use crate::Table;

    #[test]
    fn blocks_are_apart() {
        let mut document = Document::under("What is missing");
        document.paragraph("One of these.");
        document.item("first");
        document.item("second");
        document.table(Table::of([1]).numbers("a", |a| *a).numbers("b", |a| a + 1));
        document.paragraph("A note.");
        assert_snapshot!(document.text(), @r"
        WHAT IS MISSING
        One of these.
        - first
        - second

        | a | b |
        |---|---|
        | 1 | 2 |

        A note.
        ");
    }

    #[test]
    fn long_sentences_are_broken_and_indented() {
        let broken = wrapped("no line has more than so many characters", 20, "- ", "  ");
        assert_snapshot!(broken, @r"
        - no line has more
          than so many
          characters
        ");
    }

    #[test]
    fn pairs_are_aligned_and_lines_stand_as_they_are() {
        let mut document = Document::of("Files:");
        document.pair("a", "one");
        document.pair("longer", "word ".repeat(30));
        document.lines("a  line");
        document.item("entry");
        document.next("fit a");
        let text = document.text();
        assert!(text.starts_with("Files:\na       one\nlonger  word word"));
        assert!(text.contains("\n        word"));
        assert!(text.ends_with("\n\na  line\n- entry\n\nNext: stiffbench fit a\n"));
    }

    #[test]
    fn no_line_ends_between_a_number_and_its_unit() {
        let broken = wrapped(&"1\u{a0}N ".repeat(30), WIDTH, "", "");
        assert!(broken.lines().all(|line| line.ends_with('N')));
    }
}
