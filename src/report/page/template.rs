//! Templates: data to HTML, Markdown or Typst.

use std::fmt::Write;

use minijinja::{
    AutoEscape, Environment, Output, State, UndefinedBehavior, Value, context, escape_formatter,
};
use serde::Serialize;
use serde_json::Value as Json;

use crate::analysis::sha256;

use super::ReportPage;
use super::error::ReportError;
use super::packed::unpack_all;

/// What stands before the data in a page.
pub(super) const DATA_BEGINS: &str = "id=\"stiffbench-data\">";
/// What stands behind them.
pub(super) const DATA_ENDS: &str = "</script>";

/// A template of reports.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PageTemplate {
    /// Its name, for messages.
    pub name: String,
    /// Its text.
    pub text: String,
    /// What it makes.
    pub format: PageFormat,
}

/// The form of a report; one of HTML can be verified.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum PageFormat {
    /// One HTML file with figures and data.
    Html,
    /// Text with tables, for pasting.
    Markdown,
    /// Source for PDF by the typesetter Typst.
    Typst,
}

impl PageFormat {
    /// How the name of a file ends, without the dot.
    #[must_use]
    pub fn ending(self) -> &'static str {
        match self {
            Self::Html => "html",
            Self::Markdown => "md",
            Self::Typst => "typ",
        }
    }

    /// The template that comes with the program.
    #[must_use]
    pub fn template(self) -> PageTemplate {
        let text = match self {
            Self::Html => include_str!("../../../data/report/report.html"),
            Self::Markdown => include_str!("../../../data/report/report.md"),
            Self::Typst => include_str!("../../../data/report/report.typ"),
        };
        PageTemplate {
            name: format!("report.{}", self.ending()),
            text: text.to_owned(),
            format: self,
        }
    }

    /// Where templates of this form are rendered: what they print is escaped, each text in one place.
    fn environment(self) -> Environment<'static> {
        let mut environment = Environment::new();
        environment.set_undefined_behavior(UndefinedBehavior::SemiStrict);
        environment.set_trim_blocks(true);
        environment.set_lstrip_blocks(true);
        let escape = match self {
            PageFormat::Html => AutoEscape::Html,
            PageFormat::Markdown => AutoEscape::Custom("markdown"),
            PageFormat::Typst => AutoEscape::Custom("typst"),
        };
        environment.set_auto_escape_callback(move |_| escape);
        // Templates of earlier versions name it.
        environment.add_filter("cell", |value: Value| value);
        let write = match self {
            PageFormat::Html => escape_formatter,
            PageFormat::Markdown => write_markdown,
            PageFormat::Typst => write_typst,
        };
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
        environment
    }
}

/// A report as a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RenderedPage {
    /// The text of the file.
    pub text: String,
    /// SHA-256 of its data, as printed on it.
    pub data_sha256: String,
}

impl PageTemplate {
    /// SHA-256 of its text.
    #[must_use]
    pub fn sha256(&self) -> String {
        sha256(&self.text)
    }

    /// A report as a file.
    ///
    /// # Errors
    /// [`ReportError::Template`] with the line, and [`ReportError::TemplateLacks`] if the page could not be verified.
    pub fn render(&self, page: &ReportPage) -> Result<RenderedPage, ReportError> {
        let json = embedded(page);
        let rendered = self.render_json(&json)?;
        let lacks = |part| ReportError::TemplateLacks {
            template: self.name.clone(),
            part,
        };
        if self.format == PageFormat::Html {
            let (_, rest) = rendered
                .text
                .split_once(DATA_BEGINS)
                .ok_or_else(|| lacks("the data of the report"))?;
            if !rest.starts_with(&json) {
                return Err(lacks("the data of the report"));
            }
            if !rendered.text.contains(&rendered.data_sha256) {
                return Err(lacks("the SHA-256 of the data"));
            }
        }
        Ok(rendered)
    }

    /// The page of data as they stand in one.
    pub(super) fn render_json(&self, json: &str) -> Result<RenderedPage, ReportError> {
        let mut data: Json = serde_json::from_str(json).map_err(|error| ReportError::Template {
            place: self.name.clone(),
            problem: error.to_string(),
        })?;
        unpack_all(&mut data);
        let data_sha256 = sha256(json);
        let environment = self.format.environment();
        let text = environment
            .render_named_str(
                &self.name,
                &self.text,
                context! {
                    data_json => json,
                    data_sha256 => data_sha256,
                    ..Value::from_serialize(&data)
                },
            )
            .map_err(|error| self.error(&error))?;
        Ok(RenderedPage { text, data_sha256 })
    }

    /// An error of the template with its place.
    fn error(&self, error: &minijinja::Error) -> ReportError {
        let name = error.name().unwrap_or(&self.name);
        let place = error
            .line()
            .map_or_else(|| name.to_owned(), |line| format!("{name}:{line}"));
        let kind = error.kind().to_string();
        ReportError::Template {
            place,
            problem: error
                .detail()
                .map_or_else(|| kind.clone(), |detail| format!("{kind}: {detail}")),
        }
    }
}

/// The data as they stand in a page: no `<`, so that no element ends them, and nothing that is printed as another text.
pub(super) fn embedded(page: &impl Serialize) -> String {
    let json = serde_json::to_string(page).unwrap_or_default();
    let mut text = String::with_capacity(json.len());
    for c in json.chars() {
        if c == '<' || misleads(c) {
            let _ = write!(text, "\\u{:04x}", u32::from(c));
        } else {
            text.push(c);
        }
    }
    text
}

/// Whether a character makes a reader see something else than is written: controls, and marks that turn the direction of text.
fn misleads(c: char) -> bool {
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
    use stiffbench_document::{Document, Table};

    use super::*;

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
                    for (_, part) in block.iter().filter(|(key, _)| *key != "kind") {
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

    fn rendered(format: PageFormat, document: &Document) -> String {
        let template = format.template().text;
        let begins = template.find("{% macro blocks").unwrap();
        let ends = template.find("{% endmacro %}").unwrap();
        let bullets = template
            .split("{% macro bullets")
            .nth(1)
            .map_or_else(String::new, |rest| {
                format!(
                    "{{% macro bullets{}{{% endmacro %}}",
                    rest.split("{% endmacro %}").next().unwrap()
                )
            });
        let text = format!(
            "{bullets}{}{{% endmacro %}}{{{{ blocks(all) }}}}",
            &template[begins..ends]
        );
        let environment = format.environment();
        environment
            .render_str(&text, context! { all => document })
            .unwrap()
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
            let mut table = Table::new(&["name", "value", "unit"]);
            for row in rows.chunks(3) {
                table.row(row.to_vec());
            }
            document.table(table);
            let own: Vec<String> = texts(&document).iter().map(|text| shown(text)).collect();
            let page: Vec<String> = read_html(&rendered(PageFormat::Html, &document)).iter().map(|text| shown(text)).collect();
            prop_assert_eq!(&page, &own);
            let markdown = read_markdown(&rendered(PageFormat::Markdown, &document));
            let markdown: Vec<&str> = markdown.iter().map(|text| text.trim().trim_start_matches("- ")).collect();
            prop_assert_eq!(&markdown, &own);
            for (name, value) in &pairs {
                document.pair(name, value);
            }
            let typst = rendered(PageFormat::Typst, &document);
            for text in texts(&document) {
                let text = text.replace(misleads, "\u{fffd}").replace('\\', "\\\\").replace('"', "\\\"");
                let quoted = format!("\"{text}\"");
                prop_assert!(typst.contains(&quoted), "{} is not in {}", quoted, typst);
            }
        }
    }
}
