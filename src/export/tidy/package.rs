//! The description of tables as a Data Package with Table Schemas.

use serde_json::{Map, Value, json};

use super::table::TidyTable;

/// Where tables come from.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct TableProvenance {
    /// Short name of the data.
    pub name: String,
    /// What the tables are, in one line.
    pub title: String,
    /// Time of the last reading, RFC 3339; `None` if the readings have no times.
    pub measured_until: Option<String>,
    /// SHA-256 of the readings file, in hexadecimal.
    pub source_sha256: String,
    /// Facts by name: program, session, robot, gauges.
    pub facts: Vec<(String, String)>,
    /// What a user should know of the data.
    pub notes: Vec<String>,
}

/// A table in a file.
#[derive(Debug, Clone, Copy)]
pub struct PackageResource<'a> {
    /// The table.
    pub table: &'a TidyTable,
    /// Name of the file, beside the description.
    pub file: &'a str,
    /// Format of the file, its ending too.
    pub format: &'a str,
    /// Size of the file, bytes.
    pub bytes: usize,
    /// SHA-256 of the file, in hexadecimal.
    pub sha256: &'a str,
}

/// `datapackage.json`: sources, and for each file its hash and a Table Schema with units. It names no licence: that is for the owner of the data.
#[must_use]
pub fn data_package(about: &TableProvenance, resources: &[PackageResource<'_>]) -> Value {
    let facts = about
        .facts
        .iter()
        .map(|(name, fact)| (name.clone(), json!(fact)));
    let facts: Map<String, Value> = facts.collect();
    let mut package = json!({
        "profile": "data-package",
        "name": slug(&about.name),
        "title": about.title,
        "sources": [{ "title": format!("readings of {}", about.name), "sha256": about.source_sha256 }],
        "stiffbench": facts,
        "notes": about.notes,
        "resources": resources.iter().map(resource).collect::<Vec<_>>(),
    });
    if let Some(time) = &about.measured_until {
        package["created"] = json!(time);
    }
    package
}

/// A name of lower-case letters, digits, `.`, `-` and `_`.
#[must_use]
pub(super) fn slug(name: &str) -> String {
    let plain = |c: char| {
        let kept = c.is_ascii_alphanumeric() || matches!(c, '.' | '_');
        if kept { c.to_ascii_lowercase() } else { '-' }
    };
    let name: String = name.chars().map(plain).collect();
    let name = name.trim_matches('-');
    if name.is_empty() {
        "measurement".to_owned()
    } else {
        name.to_owned()
    }
}

fn resource(resource: &PackageResource<'_>) -> Value {
    let is_csv = resource.format == "csv";
    let name = resource.table.name;
    let mut object = json!({
        "name": if is_csv { name.to_owned() } else { format!("{name}-{}", resource.format) },
        "title": resource.table.title,
        "path": resource.file,
        "profile": if is_csv { "tabular-data-resource" } else { "data-resource" },
        "format": resource.format,
        "bytes": resource.bytes,
        "hash": format!("sha256:{}", resource.sha256),
        "schema": schema(resource.table),
    });
    if is_csv {
        object["mediatype"] = json!("text/csv");
        object["encoding"] = json!("utf-8");
        object["dialect"] = json!({ "delimiter": ",", "lineTerminator": "\n", "doubleQuote": true, "header": true });
    }
    object
}

fn schema(table: &TidyTable) -> Value {
    let fields = table.columns.iter().map(|column| {
        let mut field = json!({
            "name": column.name,
            "type": column.kind.name(),
            "description": column.meaning,
        });
        if !column.unit.is_empty() {
            field["unit"] = json!(column.unit);
        }
        field
    });
    json!({ "fields": fields.collect::<Vec<_>>(), "missingValues": [""] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_no_other_characters() {
        assert_eq!(slug("Messung 3 (Ölkühler)"), "messung-3---lk-hler");
        assert_eq!(slug("…"), "measurement");
        assert_eq!(slug("bench-2026.11_a"), "bench-2026.11_a");
    }
}
