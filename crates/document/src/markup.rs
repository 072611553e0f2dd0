//! A document in HTML, Markdown and Typst. Every text is escaped, each in one place.

use std::fmt::Write;

use minijinja::{
    AutoEscape, Environment, Output, State, UndefinedBehavior, Value, context, escape_formatter,
};

use crate::Document;

/// What a document is rendered to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Markup {
    /// HTML.
    Html,
    /// Markdown with tables.
    Markdown,
    /// Source for the typesetter Typst.
    Typst,
}

/// What the template of blocks is called.
const BLOCKS: &str = "blocks";

impl Markup {
    /// Renders templates of this markup. A template imports the macro `blocks` from the template of the same name; it takes the blocks of a
    /// document. Of Typst it calls `rows`, `pairs`, `drawing` and one function for each kind of note.
    #[must_use]
    pub fn environment(self) -> Environment<'static> {
        let mut environment = Environment::new();
        environment.set_undefined_behavior(UndefinedBehavior::SemiStrict);
        environment.set_trim_blocks(true);
        environment.set_lstrip_blocks(true);
        let (escape, write, blocks): (_, fn(&mut Output<'_>, &State<'_, '_>, &Value) -> _, _) =
            match self {
                Self::Html => (
                    AutoEscape::Html,
                    escape_formatter,
                    include_str!("blocks/blocks.html"),
                ),
                Self::Markdown => (
                    AutoEscape::Custom("markdown"),
                    write_markdown,
                    include_str!("blocks/blocks.md"),
                ),
                Self::Typst => (
                    AutoEscape::Custom("typst"),
                    write_typst,
                    include_str!("blocks/blocks.typ"),
                ),
            };
        environment.set_auto_escape_callback(move |_| escape);
        environment.set_formatter(move |output, state, value| match value.as_str() {
            Some(text) if text.contains(misleads) => {
                let clean = text.replace(misleads, "\u{fffd}");
                let value = if value.is_safe() {
                    Value::from_safe_string(clean)
                } else {
                    Value::from(clean)
                };
                write(output, state, &value)
            }
            _ => write(output, state, value),
        });
        #[expect(clippy::expect_used, reason = "the templates come with the crate")]
        environment
            .add_template(BLOCKS, blocks)
            .expect("the blocks of a document have a template");
        environment
    }
}

impl Document {
    /// In a markup, without what stands around it.
    ///
    /// # Errors
    /// Those of the template.
    pub fn rendered(&self, markup: Markup) -> Result<String, minijinja::Error> {
        let frame = "{% from \"blocks\" import blocks %}{{ blocks(all) }}";
        markup
            .environment()
            .render_str(frame, context! { all => self })
    }
}

/// Whether a character makes a reader see something else than is written: controls, and marks that turn the direction of text.
#[must_use]
pub fn misleads(c: char) -> bool {
    c.is_control() && !matches!(c, '\n' | '\t')
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}
/// A text as a string of Typst, in which no sign of markup counts; other values as they are.
fn write_typst(
    output: &mut Output<'_>,
    _: &State<'_, '_>,
    value: &Value,
) -> Result<(), minijinja::Error> {
    match value.as_str().filter(|_| !value.is_safe()) {
        Some(text) => {
            let text = text.replace('\\', "\\\\").replace('"', "\\\"");
            write!(output, "\"{text}\"")?;
        }
        None => write!(output, "{value}")?,
    }
    Ok(())
}

/// A text as one line of Markdown in which no sign of markup, HTML or link counts; other values as they are.
fn write_markdown(
    output: &mut Output<'_>,
    _: &State<'_, '_>,
    value: &Value,
) -> Result<(), minijinja::Error> {
    let Some(text) = value.as_str().filter(|_| !value.is_safe()) else {
        return Ok(write!(output, "{value}")?);
    };
    let mut line = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\n' => line.push(' '),
            '<' | '>' | '&' | '[' | ']' => write!(line, "&#{};", u32::from(c))?,
            _ if "\\`*_|~#$".contains(c) => line.extend(['\\', c]),
            _ => line.push(c),
        }
    }
    // Addresses are links without any markup.
    let line = line.replace("://", "&#58;//").replace("www.", "www&#46;");
    Ok(output.write_str(&line)?)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use serde_json::Value as Json;

    use super::*;
    use crate::{NoteKind, Table, TableCell};

    /// Texts that some form cannot hold as they are.
    fn any_text() -> impl Strategy<Value = String> {
        let odd = prop_oneof![
            Just("|"),
            Just("\n"),
            Just("<b>"),
            Just("&amp;"),
            Just("=SUM(A1)"),
            Just("[a](javascript:b)"),
            Just("\u{202e}"),
            Just("\u{1}"),
            Just("`*_~#$"),
            Just("\\"),
            Just("\""),
            Just("µm"),
            Just("NaN"),
            Just("{{ x }}"),
            Just("-"),
        ];
        let plain = "[a-z0-9.]{1,12}".prop_map(String::from);
        let part = prop_oneof![odd.prop_map(str::to_owned), plain];
        proptest::collection::vec(part, 1..6).prop_map(|parts| format!("x{}y", parts.concat()))
    }

    /// A text as every form may show it: one line, and a sign for what would mislead.
    fn shown(text: &str) -> String {
        text.replace('\n', " ").replace(misleads, "\u{fffd}")
    }

    /// What stands in the blocks of a document, in their order.
    fn texts(document: &Document) -> Vec<String> {
        fn all(value: &Json, texts: &mut Vec<String>) {
            match value {
                Json::String(text) => texts.push(text.clone()),
                Json::Array(list) => {
                    for one in list {
                        all(one, texts);
                    }
                }
                Json::Object(block) => {
                    for (_, part) in block
                        .iter()
                        .filter(|(key, _)| !["kind", "note"].contains(&key.as_str()))
                    {
                        all(part, texts);
                    }
                }
                _ => {}
            }
        }
        let mut texts = Vec::new();
        all(&serde_json::to_value(document).unwrap(), &mut texts);
        texts
    }

    /// The texts between the marks of HTML.
    fn read_html(page: &str) -> Vec<String> {
        let inside = page.split('<').filter_map(|piece| piece.split_once('>'));
        let inside = inside.map(|(_, text)| text);
        let texts = inside.map(|text| {
            let text = text
                .replace("&lt;", "<")
                .replace("&gt;", ">")
                .replace("&quot;", "\"")
                .replace("&#x27;", "'");
            text.replace("&#x2f;", "/")
                .replace("&amp;", "&")
                .trim_end_matches('\n')
                .to_owned()
        });
        texts.filter(|text| !text.trim().is_empty()).collect()
    }

    /// The texts of Markdown: a reader of it takes backslashes and codes of characters back.
    fn read_markdown(text: &str) -> Vec<String> {
        let is_rule = |line: &str| line.starts_with("|---");
        let mut all = Vec::new();
        for line in text
            .lines()
            .filter(|line| !line.trim().is_empty() && !is_rule(line))
        {
            let mut cells = vec![String::new()];
            let mut signs = line.chars();
            while let Some(sign) = signs.next() {
                let cell = cells.last_mut().unwrap();
                match sign {
                    '\\' => cell.extend(signs.next()),
                    '|' => cells.push(String::new()),
                    '&' => {
                        let code: String = signs.by_ref().take_while(|sign| *sign != ';').collect();
                        let code: u32 = code.trim_start_matches('#').parse().unwrap();
                        cell.extend(char::from_u32(code));
                    }
                    sign => cell.push(sign),
                }
            }
            all.extend(cells.into_iter().filter(|cell| !cell.is_empty()));
        }
        all
    }

    proptest! {
        /// Every text of a document stands in every form, and no text becomes a mark of it.
        #[test]
        fn every_form_holds_the_texts_of_a_document(
            paragraph in any_text(), items in proptest::collection::vec(any_text(), 1..4), pairs in proptest::collection::vec((any_text(), any_text()), 1..4),
            rows in proptest::collection::vec(any_text(), 6..=6),
        ) {
            let mut document = Document::of(paragraph);
            for item in &items {
                document.item(item);
            }
            document.table(Table::of(rows.chunks(3)).words("name", |row| &row[0]).words("value", |row| &row[1]).words("unit", |row| &row[2]));
            document.table(Table::of(&items).words("state", |item| TableCell::marked(item.as_str())));
            document.heading(&items[0]);
            document.note(NoteKind::Remark, &items[0]);
            document.note(NoteKind::Warning, &items[0]);
            let own: Vec<String> = texts(&document).iter().map(|text| shown(text)).collect();
            let page: Vec<String> = read_html(&document.rendered(Markup::Html).unwrap()).iter().map(|text| shown(text)).collect();
            prop_assert_eq!(&page, &own);
            let markdown = read_markdown(&document.rendered(Markup::Markdown).unwrap());
            let markdown: Vec<&str> = markdown.iter().map(|text| text.trim().trim_start_matches("- ").trim_start_matches("## ").trim_matches('*')).collect();
            prop_assert_eq!(&markdown, &own);
            for (name, value) in &pairs {
                document.pair(name, value);
            }
            let typst = document.rendered(Markup::Typst).unwrap();
            for text in texts(&document) {
                let text = text.replace(misleads, "\u{fffd}").replace('\\', "\\\\").replace('"', "\\\"");
                let quoted = format!("\"{text}\"");
                prop_assert!(typst.contains(&quoted), "{} is not in {}", quoted, typst);
            }
        }
    }
}
