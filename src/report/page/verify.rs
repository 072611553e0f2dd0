//! Reports verified: from the page alone, and against the sessions it was made of.

use schemars::JsonSchema;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use stiffbench_document::{Document, Table};

use crate::analysis::sha256;

use super::build::SCHEMA;
use super::error::ReportError;
use super::packed::foreign_markup;
use super::template::{DATA_BEGINS, DATA_ENDS, PageTemplate, embedded};
use super::{PageProgram, PageSettings, ReportPage};
use crate::count::counted;

/// So many differences are listed; the others are counted.
const LISTED: usize = 20;
/// Paths at which another program states its own: its name, and the number, which follows from its words.
const OF_PROGRAM: [&str; 4] = [
    "/program/version",
    "/program/commit",
    "/program/template_sha256",
    "/number",
];

/// What the paths of words in the blocks of a document hold: another program may choose others, with the same digits.
const WORDS: [&str; 4] = ["/text", "/title", "/items/", "/lines/"];

/// A page with its data taken out.
#[derive(Debug, Clone)]
pub struct ReadPage {
    /// What the file is called.
    pub name: String,
    text: String,
    /// The data as they stand in the page.
    json: String,
    /// What they state of the report; nothing if they cannot be read.
    stated: PageStatement,
}

/// What the data of a page state of the report itself.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
struct PageStatement {
    schema: String,
    number: String,
    program: PageProgram,
    settings: PageSettings,
    comparison: Option<IgnoredAny>,
    sessions: Vec<StatedSession>,
}

/// What they state of a session.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
struct StatedSession {
    overdue: Vec<String>,
}

/// One thing that is not as it should be.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PageDifference {
    /// Line of the page, or path of the value in the data.
    pub place: String,
    /// What the page has.
    pub printed: String,
    /// What it should have.
    pub expected: String,
}

/// What the verification of a page found.
#[expect(
    clippy::struct_excessive_bools,
    reason = "each states one thing that was done or found"
)]
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PageCheck {
    /// The file.
    pub page: String,
    /// Number of the report.
    pub number: String,
    /// Version of the program that rendered it.
    pub rendered_by: String,
    /// Whether the report was worked out again from its sessions.
    pub from_session: bool,
    /// Whether it was compared byte by byte with that; else value by value, because another program rendered the page.
    pub byte_by_byte: bool,
    /// Whether the printed text was compared with the data; it cannot be where the page has another template.
    pub printed_compared: bool,
    /// Whether nothing differs and the whole page was compared.
    pub good: bool,
    /// What was not verified: paths of values that only the program of the page could work out again, and what nothing but the page states.
    pub not_verified: Vec<String>,
    /// Number of differences.
    pub differing: usize,
    /// The first of them.
    pub differences: Vec<PageDifference>,
}

/// Takes the data out of a page.
///
/// # Errors
/// [`ReportError::NotAReport`] for a file without data.
pub fn read_page(name: &str, text: String) -> Result<ReadPage, ReportError> {
    let json = text
        .split_once(DATA_BEGINS)
        .and_then(|(_, rest)| rest.split_once(DATA_ENDS))
        .map(|(json, _)| json.to_owned());
    let Some(json) = json else {
        return Err(ReportError::NotAReport {
            page: name.to_owned(),
        });
    };
    let stated = serde_json::from_str(&json).unwrap_or_default();
    Ok(ReadPage {
        name: name.to_owned(),
        text,
        json,
        stated,
    })
}

impl ReadPage {
    /// The options that the page records.
    #[must_use]
    pub fn settings(&self) -> &PageSettings {
        &self.stated.settings
    }

    /// Calibrations that the page states as overdue, in words.
    #[must_use]
    pub fn overdue(&self) -> Vec<String> {
        let gauges = self.stated.sessions.iter().flat_map(|one| &one.overdue);
        gauges
            .map(|gauge| format!("calibration overdue: {gauge}"))
            .collect()
    }

    /// Whether it is the comparison of two sessions.
    #[must_use]
    pub fn is_comparison(&self) -> bool {
        self.stated.comparison.is_some()
    }

    /// Holds every printed text, number and figure against the data, and the data against their SHA-256, the number of the report and, if
    /// it was worked out again from its sessions, that.
    ///
    /// # Errors
    /// [`ReportError::OtherTemplate`] without sessions for a page of another template, and errors of the template.
    pub fn check(
        &self,
        template: &PageTemplate,
        again: Option<&ReportPage>,
    ) -> Result<PageCheck, ReportError> {
        let mut differences = self.check_data();
        let program = &self.stated.program;
        let printed_compared = program.template_sha256 == template.sha256();
        if !printed_compared {
            let foreign = foreign_markup(&self.text).into_iter();
            differences.extend(foreign.map(|(line, markup)| {
                let expected = "nothing that a report does not have: it may act, hide or fetch";
                difference(format!("line {line}"), markup, expected)
            }));
        }
        if printed_compared {
            // A page whose data were changed may not fit its template any more.
            match template.render_json(&self.json) {
                Ok(expected) => differences.extend(compare_lines(&self.text, &expected.text)),
                Err(error) if differences.is_empty() => return Err(error),
                Err(_) => {}
            }
        } else if again.is_none() && differences.is_empty() {
            return Err(ReportError::OtherTemplate {
                page: self.name.clone(),
                sha256: program.template_sha256.clone(),
                version: program.version.clone(),
            });
        }
        let mut compared = ValueComparison {
            same_program: true,
            differences,
            not_verified: Vec::new(),
        };
        if let Some(again) = again {
            let expected = serde_json::to_value(again).unwrap_or_default();
            let printed: Value = serde_json::from_str(&self.json).unwrap_or_default();
            compared.same_program = *program == again.program;
            compared.compare("", Some(&printed), Some(&expected));
            let is_whole = compared.same_program && compared.differences.is_empty();
            if is_whole && template.render(again)?.text != self.text {
                let place = "bytes of the page".to_owned();
                compared.add(place, "others", "those of the report computed again");
            }
            for key in ["details", "issued", "amends", "calibration"] {
                stated_keys(key, &printed["settings"][key], &mut compared.not_verified);
            }
        } else {
            let data = "the data themselves; name the session to compute them again";
            compared.not_verified.push(data.to_owned());
        }
        let (differences, same_program) = (compared.differences, compared.same_program);
        Ok(PageCheck {
            page: self.name.clone(),
            number: self.stated.number.clone(),
            rendered_by: program.version.clone(),
            from_session: again.is_some(),
            byte_by_byte: same_program,
            printed_compared,
            good: differences.is_empty() && same_program && printed_compared,
            not_verified: compared.not_verified,
            differing: differences.len(),
            differences: differences.into_iter().take(LISTED).collect(),
        })
    }

    /// The data against the SHA-256 that is printed, the number of the report, and the form in which the program writes them.
    fn check_data(&self) -> Vec<PageDifference> {
        let place = format!("line {}, embedded data", line_of(&self.text, DATA_BEGINS));
        let data = serde_json::from_str::<Value>(&self.json);
        let stated = serde_json::from_str::<PageStatement>(&self.json);
        let data = match stated.and(data) {
            Ok(data) => data,
            Err(problem) => {
                let expected = "the data of a report, in JSON";
                return vec![difference(place, problem.to_string(), expected)];
            }
        };
        let (digest, number) = (sha256(&self.json), number_of(&data));
        let visible = self.text.replacen(&self.json, "", 1);
        let mut differences = Vec::new();
        if !visible.contains(&digest) {
            let place = format!("{place}, SHA-256");
            differences.push(difference(place, "another one", digest));
        }
        if embedded(&data) != self.json {
            let form = "each key once, in the form that the program writes";
            differences.push(difference(place, "another form", form));
        }
        for (place, stated, expected) in [
            ("number of the report", &self.stated.number, number.as_str()),
            ("schema", &self.stated.schema, SCHEMA),
        ] {
            if stated != expected {
                differences.push(difference(place.to_owned(), stated, expected));
            }
        }
        differences
    }
}

impl PageCheck {
    /// For people.
    #[must_use]
    pub fn document(&self) -> Document {
        let mut document = Document::new();
        document.lines(format!(
            "{}: report {}, rendered by version {}",
            self.page, self.number, self.rendered_by
        ));
        let verdict = match (self.differing, self.good) {
            (0, true) if self.from_session => {
                "Verified: the report computed again from its readings is byte-identical."
            }
            (0, true) => {
                "Consistent: every printed text, number and figure is that of the embedded data, and these agree with their SHA-256."
            }
            (0, false) => {
                "NOT VERIFIED as a page: every value computed again from the readings agrees, but another program or template rendered the page."
            }
            _ => "",
        };
        if !verdict.is_empty() {
            document.paragraph(verdict);
        }
        if !self.printed_compared {
            document.paragraph("Its printed text and figures were not compared with its data: name its template with --template FILE.");
        }
        if self.differing > 0 {
            let count = counted(self.differing, "difference");
            document.paragraph(format!("NOT VERIFIED: {count}."));
            document.table(
                Table::of(&self.differences)
                    .words("place", |one| &one.place)
                    .words("on the page", |one| &one.printed)
                    .words("expected", |one| &one.expected),
            );
            let more = self.differing - self.differences.len();
            if more > 0 {
                document.paragraph(format!("and {more} more"));
            }
        }
        if !self.not_verified.is_empty() {
            document.paragraph(format!("Not verified: {}", self.not_verified.join(", ")));
        }
        document
    }
}

fn difference(
    place: String,
    printed: impl Into<String>,
    expected: impl Into<String>,
) -> PageDifference {
    PageDifference {
        place,
        printed: printed.into(),
        expected: expected.into(),
    }
}

/// The paths of what a value states.
fn stated_keys(path: &str, value: &Value, paths: &mut Vec<String>) {
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                stated_keys(&format!("{path}.{key}"), value, paths);
            }
        }
        Value::Null => {}
        Value::Array(all) if all.is_empty() => {}
        _ => paths.push(path.to_owned()),
    }
}

/// The number that follows from data.
fn number_of(data: &Value) -> String {
    let number = data.get("number").and_then(Value::as_str).unwrap_or("");
    let mut parts = number.split('-');
    let day = parts.nth(1).unwrap_or("").to_owned();
    let mut bare = data.clone();
    for path in ["/number", "/program/commit"] {
        if let Some(own) = bare.pointer_mut(path) {
            *own = Value::String(String::new());
        }
    }
    super::page_number(&day, &bare.to_string())
}

/// The line, from 1, on which a text stands.
fn line_of(page: &str, text: &str) -> usize {
    let before = page.split(text).next().unwrap_or("");
    before.matches('\n').count() + 1
}

/// Lines that differ, with the words around the first difference of each.
fn compare_lines(printed: &str, expected: &str) -> Vec<PageDifference> {
    let (mut ours, mut theirs) = (printed.split('\n'), expected.split('\n'));
    let mut differences = Vec::new();
    let mut line = 0;
    loop {
        line += 1;
        let (ours, theirs) = (ours.next(), theirs.next());
        if ours.is_none() && theirs.is_none() {
            return differences;
        }
        if ours != theirs {
            let [ours, theirs] = words_around(ours.unwrap_or(""), theirs.unwrap_or(""));
            differences.push(difference(format!("line {line}"), ours, theirs));
        }
    }
}

/// The words of both lines around the first byte that differs.
fn words_around(ours: &str, theirs: &str) -> [String; 2] {
    let same = ours
        .char_indices()
        .zip(theirs.chars())
        .find(|((_, a), b)| a != b)
        .map_or_else(|| ours.len().min(theirs.len()), |((at, _), _)| at);
    let is_edge = |c: char| c.is_whitespace() || matches!(c, '<' | '>' | '"' | ',');
    let begin = ours
        .get(..same)
        .and_then(|before| before.rfind(is_edge))
        .map_or(0, |at| at + 1);
    [ours, theirs].map(|line| {
        let from = line.get(begin..).unwrap_or("");
        let after = same.saturating_sub(begin);
        let end = from
            .char_indices()
            .find(|(at, c)| *at >= after && is_edge(*c))
            .map_or(from.len(), |(at, _)| at);
        from.get(..end).unwrap_or(from).chars().take(80).collect()
    })
}

/// Values of a page beside those worked out again.
struct ValueComparison {
    /// Whether this program rendered the page.
    same_program: bool,
    differences: Vec<PageDifference>,
    /// What another program may have set otherwise, by its paths.
    not_verified: Vec<String>,
}

impl ValueComparison {
    fn add(&mut self, place: String, printed: &str, expected: &str) {
        self.differences.push(difference(place, printed, expected));
    }

    /// Compares every key of both, by its path.
    fn compare(&mut self, path: &str, printed: Option<&Value>, expected: Option<&Value>) {
        let is_drawing = path.starts_with("/figures/") && path.ends_with("/svg");
        let are_words = are_words(path) && digits(printed).eq(digits(expected));
        let is_own = is_drawing || are_words || OF_PROGRAM.contains(&path);
        match (printed, expected) {
            _ if printed == expected => {}
            (Some(_), Some(_)) if is_own && !self.same_program => {
                self.not_verified.push(path.to_owned());
            }
            (Some(Value::Object(ours)), Some(Value::Object(theirs))) => {
                let missing = theirs.keys().filter(|key| !ours.contains_key(*key));
                for key in ours.keys().chain(missing) {
                    self.compare(&format!("{path}/{key}"), ours.get(key), theirs.get(key));
                }
            }
            (Some(Value::Array(ours)), Some(Value::Array(theirs))) => {
                for place in 0..ours.len().max(theirs.len()) {
                    self.compare(
                        &format!("{path}/{place}"),
                        ours.get(place),
                        theirs.get(place),
                    );
                }
            }
            _ => self.add(path.to_owned(), &shortened(printed), &shortened(expected)),
        }
    }
}

/// Whether a path is that of words in a block of the document.
fn are_words(path: &str) -> bool {
    let of_document = path.starts_with("/answer/") || path.starts_with("/body/");
    of_document && WORDS.iter().any(|words| path.contains(words))
}

/// The digits of a text in their order.
fn digits(value: Option<&Value>) -> impl Iterator<Item = char> + '_ {
    let text = value.and_then(Value::as_str).unwrap_or_default();
    text.chars().filter(char::is_ascii_digit)
}

/// The beginning of a value; `nothing` where there is none.
fn shortened(value: Option<&Value>) -> String {
    let text = value.map_or_else(|| "nothing".to_owned(), Value::to_string);
    text.chars().take(60).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn of_another_program_every_key_is_compared_and_what_it_may_set_otherwise_is_named() {
        let printed = json!({
            "body": [{ "text": "old words, 95 %" }],
            "fit": { "numbers": { "K": 1.0, "only": null } },
            "figures": { "fit": [{ "title": "a", "svg": "<svg/>" }] },
        });
        let mut expected = json!({
            "body": [{ "text": "new words, 95 %" }],
            "fit": { "numbers": { "K": 1.0, "rank": 4 } },
            "figures": { "fit": [{ "title": "a", "svg": "<svg></svg>" }] },
        });
        let compared = |expected: &Value, same_program| {
            let mut compared = ValueComparison {
                same_program,
                differences: Vec::new(),
                not_verified: Vec::new(),
            };
            compared.compare("", Some(&printed), Some(expected));
            let places = compared.differences.into_iter().map(|one| one.place);
            (places.collect::<Vec<String>>(), compared.not_verified)
        };
        let (places, not_verified) = compared(&expected, false);
        assert_eq!(places, ["/fit/numbers/only", "/fit/numbers/rank"]);
        assert_eq!(not_verified, ["/body/0/text", "/figures/fit/0/svg"]);
        assert_eq!(compared(&expected, true).0.len(), 4);
        expected["fit"]["numbers"]["K"] = json!(1.1);
        expected["body"][0]["text"] = json!("new words, 99 %");
        assert_eq!(compared(&expected, false).0.len(), 4);
    }
}
