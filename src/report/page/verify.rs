//! Reports verified: from the page alone, and against the sessions it was made of.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::analysis::sha256;
use crate::report::AlignedTable;

use super::build::SCHEMA;
use super::error::ReportError;
use super::markup::{foreign_in_drawing, foreign_in_page};
use super::packed::unpack_all;
use super::template::{DATA_BEGINS, DATA_ENDS, PageTemplate, embedded};
use super::values::ValueComparison;
use super::{PageSettings, ReportPage};
use crate::count::counted;

/// So many differences are listed; the others are counted.
const LISTED: usize = 20;
/// What is found out with sessions.
const VERIFIED: &str =
    "Verified: the report worked out again from its readings has the same bytes.";
/// What is found out without them.
const CONSISTENT: &str = "Consistent: every printed text, number and figure is that of the embedded data, and these agree with their SHA-256 and \
                          the number of the report.";
/// What is found out of a page that this program did not render.
const OTHER_PROGRAM: &str = "NOT VERIFIED as a page: every value that could be worked out again from the readings agrees, but another program or \
                             template rendered the page.";
/// What to do for a template that is not known.
const OTHER_TEMPLATE: &str = "Its printed text and figures were not compared with its data: name the template with --template FILE.";
/// What a page states of the program that rendered it.
const OF_PROGRAM: [&str; 3] = [
    "/program/version",
    "/program/commit",
    "/program/template_sha256",
];

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

    /// Holds every printed text, number and figure against the data, and the data against their SHA-256 and the number of the report.
    ///
    /// # Errors
    /// [`ReportError::OtherTemplate`] for a page of another template in which nothing else is wrong, and errors of the template.
    pub fn check(&self, template: &PageTemplate) -> Result<PageCheck, ReportError> {
        let (differences, printed_compared) = self.compare_printed(template)?;
        if !printed_compared && differences.is_empty() {
            return Err(ReportError::OtherTemplate {
                page: self.name.clone(),
                sha256: self.stated("/program/template_sha256"),
                version: self.stated("/program/version"),
            });
        }
        let values = vec![format!(
            "the data themselves; stiffbench report verify {} SESSION works them out again",
            self.name
        )];
        Ok(self.found(differences, values, [false, true, printed_compared]))
    }

    /// Where the page itself is wrong, and whether its printed text was compared with its data: a template that is not known cannot be filled.
    fn compare_printed(
        &self,
        template: &PageTemplate,
    ) -> Result<(Vec<PageDifference>, bool), ReportError> {
        let mut differences = self.check_data();
        if self.stated("/program/template_sha256") != template.sha256() {
            let data = format!(
                "<script type=\"application/json\" {DATA_BEGINS}{}{DATA_ENDS}",
                self.json
            );
            let markup = foreign_in_page(&self.text.replacen(&data, "", 1));
            differences.extend(markup.map(|tag| foreign("markup of the page".to_owned(), tag)));
            return Ok((differences, false));
        }
        // A page whose data were changed may not fit its template any more.
        match template.render_json(&self.json) {
            Ok(expected) => {
                differences.extend(compare_lines(&self.text, &expected.text));
            }
            Err(error) if differences.is_empty() => return Err(error),
            Err(_) => {}
        }
        Ok((differences, true))
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
        let schema = self.stated("/schema");
        if schema != SCHEMA {
            differences.push(PageDifference {
                place: "/schema".to_owned(),
                printed: schema,
                expected: SCHEMA.to_owned(),
            });
        }
        if embedded(data) != self.json {
            differences.push(PageDifference {
                place: format!("line {line}, embedded data"),
                printed: "another form".to_owned(),
                expected: "each key once, in the form that the program writes".to_owned(),
            });
        }
        let mut drawn = data.clone();
        unpack_all(&mut drawn);
        for (section, figures) in drawn["figures"].as_object().into_iter().flatten() {
            for (place, figure) in figures.as_array().into_iter().flatten().enumerate() {
                let markup = foreign_in_drawing(figure["svg"].as_str().unwrap_or_default());
                let place = format!("/figures/{section}/{place}/svg");
                differences.extend(markup.map(|tag| foreign(place, tag)));
            }
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
    /// Those of the template. A page of another template or program is compared value by value.
    pub fn check_against(
        &self,
        again: &ReportPage,
        template: &PageTemplate,
    ) -> Result<PageCheck, ReportError> {
        let (mut differences, printed_compared) = self.compare_printed(template)?;
        if self.settings.is_none() {
            differences.push(PageDifference {
                place: "/settings".to_owned(),
                printed: "cannot be read".to_owned(),
                expected: "the options of the report, by which it is worked out again".to_owned(),
            });
        }
        let printed = self.data.clone().unwrap_or_default();
        let mut expected = serde_json::to_value(again).unwrap_or_default();
        let mut not_verified = Vec::new();
        let same_program = printed.get("program") == expected.get("program");
        if !same_program {
            // Of another program everything is worked out but its own name; the number follows from that.
            for path in OF_PROGRAM.iter().copied().chain(["/number"]) {
                let (own, other) = (printed.pointer(path), expected.pointer_mut(path));
                if let (Some(own), Some(other)) = (own, other)
                    && own != other
                {
                    not_verified.push(path.to_owned());
                    *other = own.clone();
                }
            }
            set_number(&mut expected, &self.stated("/number"));
        }
        let mut compared = ValueComparison {
            same_program,
            differences,
            not_verified,
        };
        compared.compare("", Some(&printed), Some(&expected));
        if same_program
            && compared.differences.is_empty()
            && template.render(again)?.text != self.text
        {
            compared.differences.push(PageDifference {
                place: "bytes of the page".to_owned(),
                printed: "another order of the data".to_owned(),
                expected: "that of the program".to_owned(),
            });
        }
        let settings = self.settings.clone().unwrap_or_default();
        let settings = serde_json::to_value(settings).unwrap_or_default();
        for key in ["details", "issued", "amends", "calibration"] {
            stated_keys(key, &settings[key], &mut compared.not_verified);
        }
        let how = [true, same_program, printed_compared];
        Ok(self.found(compared.differences, compared.not_verified, how))
    }

    fn found(
        &self,
        differences: Vec<PageDifference>,
        not_verified: Vec<String>,
        [from_session, byte_by_byte, printed_compared]: [bool; 3],
    ) -> PageCheck {
        PageCheck {
            page: self.name.clone(),
            number: self.stated("/number"),
            rendered_by: self.stated("/program/version"),
            from_session,
            byte_by_byte,
            printed_compared,
            good: differences.is_empty() && byte_by_byte && printed_compared,
            not_verified,
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
        let head = format!("{page}: report {number}, rendered by version {rendered_by}");
        let answer = match (self.differing, self.good) {
            (0, true) if self.from_session => VERIFIED.to_owned(),
            (0, true) => CONSISTENT.to_owned(),
            (0, false) if self.printed_compared => OTHER_PROGRAM.to_owned(),
            (0, false) => format!("{OTHER_PROGRAM} {OTHER_TEMPLATE}"),
            (count, _) => {
                let mut rows = AlignedTable::new(&["place", "on the page", "expected"]);
                for one in &self.differences {
                    rows.row([&one.place, &one.printed, &one.expected].map(String::clone));
                }
                let (count_in_words, rows) = (counted(count, "difference"), rows.text());
                let more = match count - self.differences.len() {
                    0 => String::new(),
                    more => format!("\nand {more} more"),
                };
                format!(
                    "NOT VERIFIED: {count_in_words}.\n\n{}{more}",
                    rows.trim_end()
                )
            }
        };
        let rest = match self.not_verified.as_slice() {
            [] => String::new(),
            all => format!("Not verified: {}\n", all.join(", ")),
        };
        format!("{head}\n{answer}\n{rest}")
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
    set_number(&mut bare, "");
    super::page_number(&day, &bare.to_string())
}

/// States a number among the items of data.
fn set_number(data: &mut Value, number: &str) {
    let items = data.get_mut("items").and_then(Value::as_array_mut);
    for item in items.into_iter().flatten() {
        if item.get("key").and_then(Value::as_str) == Some("") {
            item["value"] = Value::String(number.to_owned());
        }
    }
}

/// The keys of a value that state something.
fn stated_keys(path: &str, value: &Value, keys: &mut Vec<String>) {
    match value {
        Value::Null => {}
        Value::Array(all) if all.is_empty() => {}
        Value::Object(map) => {
            for (key, value) in map {
                stated_keys(&format!("{path}.{key}"), value, keys);
            }
        }
        _ => keys.push(path.to_owned()),
    }
}

/// A difference for a tag that has no place where it stands.
fn foreign(place: String, printed: String) -> PageDifference {
    PageDifference {
        place,
        printed,
        expected: "text and drawings, no script".to_owned(),
    }
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
            let [printed, expected] = words_around(ours.unwrap_or(""), theirs.unwrap_or(""));
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
