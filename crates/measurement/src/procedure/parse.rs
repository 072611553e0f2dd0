//! From the text of a procedure file to the plan.

use std::ops::Range;

use crate::readings::ProcedureRecord;
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::toml_text::{TomlDocument, TomlTable};

use super::plan::Procedure;
use super::problem::{ProcedureError, ProcedureProblem};

impl Procedure {
    /// Reads a procedure file, schema `stiffbench/procedure/1`; also gives a warning for each key that means nothing.
    ///
    /// Every key but `schema` may be absent; what is absent takes the value of [`Procedure::default`], and the name of the file for the name.
    ///
    /// # Errors
    /// A text that is not TOML, not a procedure or a newer one, a value or a unit of the wrong kind; a plan that cannot be followed.
    pub fn parse(source: &SourceText) -> Result<(Self, Vec<String>), ProcedureError> {
        let (mut record, unknown) = ProcedureRecord::from_toml(source)?;
        record.name.get_or_insert_with(|| stem(&source.name));
        let plan = listed_nothing(source, &record).map_or_else(
            || Self::from_record(&record),
            |key| Err(ProcedureProblem::empty(key)),
        );
        let plan = plan.map_err(|problem| {
            let at = key_span(source, problem.key);
            ProcedureError::new(source, at, problem)
        })?;
        let warnings = unknown.iter().map(|key| key.warning(&source.name));
        Ok((plan, warnings.collect()))
    }
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
        ("displacement_axes", record.displacement_axes.is_empty()),
        ("loads", record.loads_n.is_empty()),
        ("branches", record.branches.is_empty()),
    ]
    .into_iter()
    .find(|(key, empty)| *empty && !key_span(source, key).is_empty())
    .map(|(key, _)| key)
}

/// Bytes of a key, whatever unit it is written with; empty if it does not stand in the text.
fn key_span(source: &SourceText, key: &str) -> Range<usize> {
    let Ok(document) = TomlDocument::parse(source) else {
        return 0..0;
    };
    let root = document.root();
    let of = |table: &TomlTable<'_>, stem: &str| {
        let mut keys = table.entries();
        keys.find_map(|(key, span, _)| {
            let unit = key.strip_prefix(stem)?;
            (unit.is_empty() || unit.starts_with('_')).then_some(span)
        })
    };
    let (table, stem) = key.split_once('.').unwrap_or(("", key));
    let inner = root.get(table).and_then(|value| value.table().ok());
    // A short header has the tolerance without the table around it.
    let found = inner.and_then(|inner| of(&inner, stem));
    found.or_else(|| of(&root, stem)).unwrap_or(0..0)
}
