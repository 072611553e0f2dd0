//! Text pages as headings, paragraphs, lists and tables: what the terminal prints, for a document.

use schemars::JsonSchema;
use serde::Serialize;

/// A part of a text.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum TextBlock {
    /// A heading.
    Heading {
        /// Its words.
        text: String,
    },
    /// A paragraph.
    Paragraph {
        /// Its words.
        text: String,
    },
    /// A list.
    List {
        /// Its entries.
        items: Vec<String>,
    },
    /// A table.
    Table {
        /// Its column heads.
        head: Vec<String>,
        /// Its rows.
        rows: Vec<Vec<String>>,
    },
}

/// The parts of a text whose tables are Markdown and whose headings are capitals.
#[must_use]
pub fn text_blocks(text: &str) -> Vec<TextBlock> {
    let text = with_micro_signs(text);
    let mut blocks: Vec<TextBlock> = Vec::new();
    let mut continues = false;
    for line in text.lines() {
        let trimmed = line.trim();
        if trimmed.is_empty() {
            continues = false;
            continue;
        }
        if is_heading(trimmed) {
            let text = sentence_case(trimmed);
            blocks.push(TextBlock::Heading { text });
            continues = false;
        } else if let Some(cells) = table_row(trimmed) {
            add_row(&mut blocks, cells, continues);
            continues = true;
        } else if let Some(item) = trimmed.strip_prefix("- ").filter(|_| line.starts_with('-')) {
            match blocks.last_mut() {
                Some(TextBlock::List { items }) => items.push(item.to_owned()),
                _ => blocks.push(TextBlock::List {
                    items: vec![item.to_owned()],
                }),
            }
            continues = true;
        } else {
            add_words(&mut blocks, trimmed, continues);
            continues = true;
        }
    }
    blocks
}

/// A text whose units `um` and `urad`, as a terminal prints them, have the micro sign.
#[must_use]
pub(super) fn with_micro_signs(text: &str) -> String {
    let is_word = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, found)) = rest.split_once('u') {
        out.push_str(before);
        let begins = !is_word(out.chars().next_back());
        let mut ends = ["rad", "m"]
            .iter()
            .filter_map(|unit| found.strip_prefix(unit));
        let is_unit = begins && ends.any(|behind| !is_word(behind.chars().next()));
        out.push(if is_unit { 'µ' } else { 'u' });
        rest = found;
    }
    out + rest
}

/// Continues the last paragraph or entry, or begins a paragraph.
fn add_words(blocks: &mut Vec<TextBlock>, words: &str, continues: bool) {
    let open = blocks.last_mut().filter(|_| continues);
    let text = match open {
        Some(TextBlock::Paragraph { text }) => Some(text),
        Some(TextBlock::List { items }) => items.last_mut(),
        _ => None,
    };
    if let Some(text) = text {
        text.push(' ');
        text.push_str(words);
    } else {
        let text = words.to_owned();
        blocks.push(TextBlock::Paragraph { text });
    }
}

fn add_row(blocks: &mut Vec<TextBlock>, cells: Vec<String>, continues: bool) {
    let is_rule = cells.iter().all(|cell| cell.chars().all(|c| c == '-'));
    match blocks.last_mut() {
        Some(TextBlock::Table { .. }) if is_rule => {}
        Some(TextBlock::Table { rows, .. }) if continues => rows.push(cells),
        _ => blocks.push(TextBlock::Table {
            head: cells,
            rows: Vec::new(),
        }),
    }
}

fn table_row(line: &str) -> Option<Vec<String>> {
    let inner = line.strip_prefix('|')?.strip_suffix('|')?;
    // A bar behind a backslash stands in a cell.
    let inner = inner.replace("\\|", "\u{0}");
    let cells = inner
        .split('|')
        .map(|cell| cell.trim().replace('\u{0}', "|"));
    Some(cells.collect())
}

fn is_heading(line: &str) -> bool {
    let begins = line.chars().next().is_some_and(char::is_alphabetic);
    begins && line.chars().count() > 3 && !line.chars().any(char::is_lowercase)
}

fn sentence_case(line: &str) -> String {
    let mut letters = line.chars();
    let first: String = letters.next().into_iter().collect();
    first + &letters.as_str().to_lowercase()
}

/// The parts under the heading, up to the next one.
#[must_use]
pub(super) fn under<'a>(blocks: &'a [TextBlock], heading: &str) -> &'a [TextBlock] {
    let is_head = |block: &TextBlock| matches!(block, TextBlock::Heading { .. });
    let begin = blocks
        .iter()
        .position(|block| matches!(block, TextBlock::Heading { text } if text == heading));
    let Some(begin) = begin else { return &[] };
    let rest = &blocks[begin + 1..];
    let end = rest.iter().position(is_head).unwrap_or(rest.len());
    &rest[..end]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_units_get_the_micro_sign() {
        for (plain, set) in [
            (
                "play 18.5 urad, up to 31.4 um at the end",
                "play 18.5 µrad, up to 31.4 µm at the end",
            ),
            (
                "K, N/um; maximum, spread_um, um_x, humus",
                "K, N/µm; maximum, spread_um, um_x, humus",
            ),
            ("um", "µm"),
            ("", ""),
        ] {
            assert_eq!(with_micro_signs(plain), set);
        }
    }

    #[test]
    fn headings_paragraphs_lists_and_tables_are_found() {
        let text = "One\nsentence.\n\nWHAT IS MISSING\n- first\n  goes on\n- second\n\n| a | b |\n|---|---|\n| 1 | 2 |\nA note.\n";
        let blocks = text_blocks(text);
        assert_eq!(
            blocks[0],
            TextBlock::Paragraph {
                text: "One sentence.".to_owned()
            }
        );
        let items = vec!["first goes on".to_owned(), "second".to_owned()];
        assert_eq!(
            under(&blocks, "What is missing")[0],
            TextBlock::List { items }
        );
        let TextBlock::Table { head, rows } = &blocks[3] else {
            panic!("{blocks:?}");
        };
        assert_eq!((head.len(), rows.len()), (2, 1));
        assert_eq!(blocks.len(), 5);
    }
}
