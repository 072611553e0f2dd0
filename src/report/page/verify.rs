//! Reports verified: from the page alone, and against the sessions it was made of.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::analysis::sha256;
use crate::report::AlignedTable;

use super::error::ReportError;
use super::template::{DATA_BEGINS, DATA_ENDS, PageTemplate};
use super::{PageSettings, ReportPage};
use crate::count::counted;

/// So many differences are listed; the others are counted.
const LISTED: usize = 20;

/// A page with its data taken out.
#[derive(Debug, Clone)]
pub struct ReadPage {
    /// What the file is called.
    pub name: String,
    text: String,
    /// The data as they stand in the page.
    json: String,
    /// The same, if they are JSON.
    data: Option<Value>,
    /// Options, if they can be read.
    pub settings: Option<PageSettings>,
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
    /// Whether it was compared byte by byte with that; else value by value.
    pub byte_by_byte: bool,
    /// Whether the printed text was compared with the data; it cannot be where the page has another template.
    pub printed_compared: bool,
    /// Whether nothing differs.
    pub good: bool,
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
    let data: Option<Value> = serde_json::from_str(&json).ok();
    let settings = data.as_ref().and_then(|data| data.get("settings"));
    let settings = settings.and_then(|settings| PageSettings::deserialize(settings).ok());
    Ok(ReadPage {
        name: name.to_owned(),
        text,
        json,
        data,
        settings,
    })
}

impl ReadPage {
    /// Calibrations that the page states as overdue, in words.
    #[must_use]
    pub fn overdue(&self) -> Vec<String> {
        let listed = |value: &Value, key: &str| value[key].as_array().cloned().unwrap_or_default();
        let sessions = self.data.iter().flat_map(|data| listed(data, "sessions"));
        let gauges = sessions.flat_map(|session| listed(&session, "gauges"));
        let overdue = gauges.filter(|gauge| gauge["overdue"] == true);
        let word = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        overdue
            .map(|gauge| {
                let (name, due) = (word(&gauge["name"]), word(&gauge["due"]));
                format!("calibration overdue: {name} (due {due})")
            })
            .collect()
    }

    /// A text of the data; empty where there is none.
    fn stated(&self, pointer: &str) -> String {
        let value = self.data.as_ref().and_then(|data| data.pointer(pointer));
        value
            .and_then(Value::as_str)
            .map_or_else(String::new, str::to_owned)
    }

    /// Whether it is the comparison of two sessions.
    #[must_use]
    pub fn is_comparison(&self) -> bool {
        let comparison = self.data.as_ref().and_then(|data| data.get("comparison"));
        comparison.is_some_and(|comparison| !comparison.is_null())
    }

    /// Holds every printed number against the data, and the data against their SHA-256 and the number of the report.
    ///
    /// # Errors
    /// [`ReportError::OtherTemplate`] for a whole page of another template, and errors of the template.
    pub fn check(&self, template: &PageTemplate) -> Result<PageCheck, ReportError> {
        let mut differences = self.check_data();
        let sha256 = self.stated("/program/template_sha256");
        let same_template = sha256 == template.sha256();
        if !same_template && differences.is_empty() {
            return Err(ReportError::OtherTemplate {
                page: self.name.clone(),
                sha256,
                version: self.stated("/program/version"),
            });
        }
        // A page whose data were changed may not fit its template any more.
        match template.render_json(&self.json) {
            Ok(expected) => {
                differences.extend(compare_lines(&self.text, &expected.text));
                if differences.is_empty() && self.text != expected.text {
                    differences.push(PageDifference {
                        place: "ends of lines".to_owned(),
                        printed: format!("{} bytes", self.text.len()),
                        expected: format!("{} bytes", expected.text.len()),
                    });
                }
            }
            Err(error) if differences.is_empty() => return Err(error),
            Err(_) => {}
        }
        Ok(self.found(differences))
    }

    /// The data against the SHA-256 that is printed, and against the number of the report.
    fn check_data(&self) -> Vec<PageDifference> {
        let line = line_of(&self.text, DATA_BEGINS);
        let Some(data) = &self.data else {
            let problem = serde_json::from_str::<Value>(&self.json).err();
            return vec![PageDifference {
                place: format!("line {line}, embedded data"),
                printed: problem.map_or_else(String::new, |problem| problem.to_string()),
                expected: "JSON".to_owned(),
            }];
        };
        let mut differences = Vec::new();
        let digest = sha256(&self.json);
        let visible = self.text.replacen(&self.json, "", 1);
        if !visible.contains(&digest) {
            differences.push(PageDifference {
                place: format!("line {line}, SHA-256 of the embedded data"),
                printed: "another one".to_owned(),
                expected: digest,
            });
        }
        let number = self.stated("/number");
        let expected = number_of(data);
        if number != expected {
            differences.push(PageDifference {
                place: "number of the report".to_owned(),
                printed: number,
                expected,
            });
        }
        differences
    }

    /// Holds the page against a report that was worked out again from its sessions.
    ///
    /// # Errors
    /// As [`check`](Self::check), but for another template: the values are compared then.
    pub fn check_against(
        &self,
        again: &ReportPage,
        template: &PageTemplate,
    ) -> Result<PageCheck, ReportError> {
        let same_program = self.stated("/program/version") == again.program.version
            && self.stated("/program/commit") == again.program.commit
            && self.stated("/program/template_sha256") == again.program.template_sha256;
        let (mut differences, printed_compared) = match self.check(template) {
            Ok(check) => (check.differences, true),
            Err(ReportError::OtherTemplate { .. }) => (self.check_data(), false),
            Err(error) => return Err(error),
        };
        if self.settings.is_none() {
            differences.push(PageDifference {
                place: "/settings".to_owned(),
                printed: "cannot be read".to_owned(),
                expected: "the options of the report, by which it is worked out again".to_owned(),
            });
        }
        let rendered = template.render(again)?;
        let equal = same_program && rendered.text == self.text;
        if !equal {
            let expected = serde_json::to_value(again).unwrap_or_default();
            let printed = self.data.clone().unwrap_or_default();
            compare_values("", &printed, &expected, same_program, &mut differences);
        }
        Ok(PageCheck {
            from_session: true,
            byte_by_byte: same_program,
            printed_compared,
            ..self.found(differences)
        })
    }

    fn found(&self, differences: Vec<PageDifference>) -> PageCheck {
        PageCheck {
            page: self.name.clone(),
            number: self.stated("/number"),
            rendered_by: self.stated("/program/version"),
            from_session: false,
            byte_by_byte: true,
            printed_compared: true,
            good: differences.is_empty(),
            differing: differences.len(),
            differences: differences.into_iter().take(LISTED).collect(),
        }
    }
}

impl PageCheck {
    /// For people.
    #[must_use]
    pub fn text(&self) -> String {
        let Self {
            page,
            number,
            rendered_by,
            ..
        } = self;
        let against = match (self.from_session, self.byte_by_byte) {
            (false, _) => {
                "every printed number agrees with the embedded data, and these with their SHA-256"
            }
            (true, true) => "the report worked out again from its readings has the same bytes",
            (true, false) => "every value worked out again from the readings agrees",
        };
        let head = format!("{page}: report {number}, rendered by version {rendered_by}\n");
        if self.good && !self.printed_compared {
            return format!(
                "{head}NOT VERIFIED as a page: {against}, but the page has another template, so that its printed text and figures were not \
                 compared. Name the template with --template FILE.\n"
            );
        }
        if self.good {
            return format!("{head}Verified: {against}.\n");
        }
        let mut rows = AlignedTable::new(&["place", "on the page", "expected"]);
        for one in &self.differences {
            rows.row([&one.place, &one.printed, &one.expected].map(|text| text.replace('|', "/")));
        }
        let more = self.differing - self.differences.len();
        let more = match more {
            0 => String::new(),
            more => format!("and {more} more\n"),
        };
        format!(
            "{head}NOT VERIFIED: {}.\n\n{}{more}",
            counted(self.differing, "difference"),
            rows.text()
        )
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
    let items = bare.get_mut("items").and_then(Value::as_array_mut);
    for item in items.into_iter().flatten() {
        if item.get("key").and_then(Value::as_str) == Some("") {
            item["value"] = Value::String(String::new());
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
        let (ours, theirs) = match (ours.next(), theirs.next()) {
            (None, None) => return differences,
            (ours, theirs) => (ours.unwrap_or(""), theirs.unwrap_or("")),
        };
        if ours != theirs {
            let [printed, expected] = words_around(ours, theirs);
            differences.push(PageDifference {
                place: format!("line {line}"),
                printed,
                expected,
            });
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

/// Values that differ, by their paths. Of another program its own name, the number, drawings, words and values that only one of the two
/// programs gives are passed over.
fn compare_values(
    path: &str,
    printed: &Value,
    expected: &Value,
    same_program: bool,
    differences: &mut Vec<PageDifference>,
) {
    const OF_PROGRAM: [&str; 3] = ["/program", "/number", "/items/3"];
    let is_drawing = path.starts_with("/figures/") && path.ends_with("/svg");
    let is_words = path.ends_with("/text");
    if !same_program && (is_drawing || is_words || OF_PROGRAM.contains(&path)) {
        return;
    }
    match (printed, expected) {
        (Value::Object(ours), Value::Object(theirs)) => {
            let only_theirs = theirs.keys().filter(|key| !ours.contains_key(*key));
            let is_common = |key: &&String| ours.contains_key(*key) && theirs.contains_key(*key);
            let keys = ours.keys().chain(only_theirs);
            for key in keys.filter(|key| same_program || is_common(key)) {
                let [a, b] = [ours, theirs].map(|map| map.get(key).unwrap_or(&Value::Null));
                compare_values(&format!("{path}/{key}"), a, b, same_program, differences);
            }
        }
        (Value::Array(ours), Value::Array(theirs)) => {
            for place in 0..ours.len().max(theirs.len()) {
                let [a, b] = [ours, theirs].map(|all| all.get(place).unwrap_or(&Value::Null));
                compare_values(&format!("{path}/{place}"), a, b, same_program, differences);
            }
        }
        _ if printed == expected => {}
        _ => differences.push(PageDifference {
            place: path.to_owned(),
            printed: shortened(printed),
            expected: shortened(expected),
        }),
    }
}

fn shortened(value: &Value) -> String {
    value.to_string().chars().take(60).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn pages_of_another_program_are_compared_by_the_values_that_both_give() {
        let printed = json!({
            "program": { "version": "1" },
            "fit": { "text": ["old words"], "numbers": { "K": 1.0 } },
            "figures": [{ "title": "a", "svg": "<svg/>" }],
        });
        let mut expected = json!({
            "program": { "version": "2" },
            "fit": { "text": ["new words", "more"], "numbers": { "K": 1.0, "rank": 4 } },
            "figures": [{ "title": "a", "svg": "<svg></svg>" }],
        });
        let places = |expected: &Value, same| {
            let mut differences = Vec::new();
            compare_values("", &printed, expected, same, &mut differences);
            let places = differences.into_iter().map(|one| one.place);
            places.collect::<Vec<String>>()
        };
        assert_eq!(places(&expected, false), [] as [&str; 0]);
        assert_eq!(places(&expected, true).len(), 5);
        expected["fit"]["numbers"]["K"] = json!(1.1);
        assert_eq!(places(&expected, false), ["/fit/numbers/K"]);
    }
}
