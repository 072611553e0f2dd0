//! From the text of a procedure file to the plan.

use std::ops::Range;

use crate::readings::ProcedureRecord;
use stiffbench_units_and_text::nearest::nearest;
use stiffbench_units_and_text::source_text::{SourceText, Step};

use super::plan::Procedure;
use super::problem::{ProcedureError, ProcedureProblem};

/// Keys of a procedure file, as they are written.
pub(super) const KEYS: [&str; 20] = [
    "schema",
    "name",
    "text",
    "poses",
    "directions",
    "loads_N",
    "branches",
    "repeats",
    "repeat_order",
    "load_order",
    "seed",
    "zero",
    "preload_N",
    "holds_s",
    "settle",
    "settle.force_tolerance_N",
    "settle.dwell_s",
    "settle.spread_um",
    "settle.slope_um_per_s",
    "force_tolerance_N",
];

impl Procedure {
    /// Reads a procedure file, schema `stiffbench/procedure/1`; also gives a warning for each key that means nothing.
    ///
    /// Every key but `schema` may be absent; what is absent takes the value of [`Procedure::default`], and the name of the file for the name.
    ///
    /// # Errors
    /// [`ProcedureError::File`] for a text that is not TOML, not a procedure or a newer one, a value or a unit of the wrong kind;
    /// [`ProcedureError::Plan`] for a plan that cannot be followed. Both show the place.
    pub fn parse(source: &SourceText) -> Result<(Self, Vec<String>), ProcedureError> {
        let text = source.text.strip_prefix('\u{feff}').unwrap_or(&source.text);
        let source = SourceText::new(source.name.as_str(), text);
        let (mut record, unknown) = ProcedureRecord::from_toml(&source.name, &source.text)
            .map_err(|problem| ProcedureError::File {
                file: source.name.clone(),
                problem: Box::new(problem),
            })?;
        record.name.get_or_insert_with(|| stem(&source.name));
        let plan = listed_nothing(&source, &record).map_or_else(
            || Self::from_record(&record),
            |key| Err(ProcedureProblem::Empty { key }),
        );
        let plan = plan.map_err(|problem| plan_error(&source, problem))?;
        let warnings = unknown.iter().map(|unknown| {
            let advice = nearest_key(&unknown.key)
                .map_or_else(String::new, |near| format!("; is `{near}` meant?"));
            format!(
                "{}: line {}: key `{}` is not known and was not used{advice}",
                source.name, unknown.line, unknown.key
            )
        });
        Ok((plan, warnings.collect()))
    }
}

/// The key of the same table that is nearest to an unknown one.
fn nearest_key(unknown: &str) -> Option<&'static str> {
    let table = |key: &str| key.rsplit_once('.').map(|(table, _)| table.to_owned());
    let known = KEYS.into_iter();
    nearest(unknown, known.filter(|key| table(key) == table(unknown)))
}

/// The name of a file without its folders and `.toml`.
fn stem(name: &str) -> String {
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    file.strip_suffix(".toml").unwrap_or(file).to_owned()
}

/// A list that is written down and empty, where an absent one would take its default.
fn listed_nothing(source: &SourceText, record: &ProcedureRecord) -> Option<&'static str> {
    [
        ("poses", record.poses.is_empty()),
        ("directions", record.directions.is_empty()),
        ("loads", record.loads_n.is_empty()),
        ("branches", record.branches.is_empty()),
    ]
    .into_iter()
    .find(|(key, empty)| *empty && !key_span(source, key).is_empty())
    .map(|(key, _)| key)
}

/// Bytes of a key, whatever unit it is written with; empty if it does not stand in the text.
fn key_span(source: &SourceText, key: &str) -> Range<usize> {
    let (table, stem) = match key.split_once('.') {
        Some((table, stem)) => (Some(table), stem),
        None => (None, key),
    };
    let path: Vec<Step<'_>> = table.map(Step::Key).into_iter().collect();
    let keys = source.toml_keys(&path);
    let found = keys.iter().find(|found| {
        let unit = found.strip_prefix(stem);
        unit.is_some_and(|unit| unit.is_empty() || unit.starts_with('_'))
    });
    match (found, table) {
        (Some(found), _) => source.toml_key_span(&[&path[..], &[Step::Key(found)]].concat()),
        // A short header has the tolerance without the table around it.
        (None, Some(_)) => key_span(source, stem),
        (None, None) => 0..0,
    }
}

fn plan_error(source: &SourceText, problem: ProcedureProblem) -> ProcedureError {
    let at = key_span(source, problem.key());
    ProcedureError::Plan {
        file: source.name.clone(),
        line: source.line_and_column(at.start).0,
        problem: Box::new(problem),
        source_text: source.named_source(),
        at: at.into(),
    }
}
