//! A document as a terminal shows it.

use crate::{Document, DocumentBlock};

/// Width of paragraphs and lists.
const WIDTH: usize = 100;

impl Document {
    /// As a terminal shows it, each line ended: headings in capitals, an empty line between blocks but behind a heading and before a list.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::new();
        let mut last: Option<&DocumentBlock> = None;
        for block in self.blocks() {
            let goes_on = matches!(
                (last, block),
                (Some(DocumentBlock::Heading { .. }), _)
                    | (
                        Some(DocumentBlock::Paragraph { .. }),
                        DocumentBlock::List { .. }
                    )
            );
            if last.is_some() && !goes_on {
                text.push('\n');
            }
            last = Some(block);
            match block {
                DocumentBlock::Heading { text: words } => {
                    text.push_str(&words.to_uppercase());
                    text.push('\n');
                }
                DocumentBlock::Paragraph { text: words } => {
                    text.push_str(&wrapped(words, WIDTH, "", ""));
                    text.push('\n');
                }
                DocumentBlock::List { items } => {
                    for item in items {
                        text.push_str(&wrapped(item, WIDTH, "- ", "  "));
                        text.push('\n');
                    }
                }
                DocumentBlock::Table(table) => text.push_str(&table.text()),
            }
        }
        text
    }
}

/// A text in lines of at most so many characters, each after `indent`; the first after `first`.
#[must_use]
pub fn wrapped(text: &str, width: usize, first: &str, indent: &str) -> String {
    let mut out = String::new();
    let mut line = first.to_owned();
    let mut empty = true;
    for word in text.split_whitespace() {
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
        let mut table = Table::new(&["a", "b"]);
        table.row(["1".to_owned(), "2".to_owned()]);
        document.table(table);
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
}
