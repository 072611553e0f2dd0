//! Templates: data to HTML, Markdown or Typst.

use std::fmt::Write;

use minijinja::{Value, context};
use serde::Serialize;
use serde_json::Value as Json;
use stiffbench_document::{Markup, misleads};

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

    fn markup(self) -> Markup {
        match self {
            Self::Html => Markup::Html,
            Self::Markdown => Markup::Markdown,
            Self::Typst => Markup::Typst,
        }
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
    ///
    /// # Errors
    /// As [`render`](Self::render) of the template, and for what is not JSON.
    pub fn render_json(&self, json: &str) -> Result<RenderedPage, ReportError> {
        let mut data: Json = serde_json::from_str(json).map_err(|error| ReportError::Template {
            place: self.name.clone(),
            problem: error.to_string(),
        })?;
        unpack_all(&mut data);
        let data_sha256 = sha256(json);
        let environment = self.format.markup().environment();
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
