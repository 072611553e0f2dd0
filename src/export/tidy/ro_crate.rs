//! The description of exported tables as an RO-Crate.

use serde_json::{Value, json};

use super::package::{PackageResource, TableProvenance};

/// `ro-crate-metadata.json` (RO-Crate 1.1): the files with their hashes, and the program that made them. It names no licence: that is for the
/// owner of the data.
///
/// # Arguments
/// - `published`: day of the export, `2026-11-26`.
#[must_use]
pub fn ro_crate(
    about: &TableProvenance,
    resources: &[PackageResource<'_>],
    published: &str,
) -> Value {
    let names = resources.iter().map(|resource| resource.file);
    let names: Vec<&str> = names.chain(["datapackage.json"]).collect();
    let ids: Vec<Value> = names.iter().map(|name| json!({ "@id": name })).collect();
    let mut dataset = json!({
        "@id": "./",
        "@type": "Dataset",
        "name": about.title,
        "description": format!("readings, stiffness and uncertainty of {}", about.name),
        "datePublished": published,
        "hasPart": ids,
        "mentions": { "@id": "#export" },
    });
    if let Some(time) = &about.measured_until {
        dataset["temporalCoverage"] = json!(time);
    }
    let mut graph = vec![
        json!({
            "@id": "ro-crate-metadata.json",
            "@type": "CreativeWork",
            "conformsTo": { "@id": "https://w3id.org/ro/crate/1.1" },
            "about": { "@id": "./" },
        }),
        dataset,
        json!({
            "@id": "#export",
            "@type": "CreateAction",
            "name": "export of tables",
            "instrument": { "@id": "#program" },
            "result": ids,
        }),
        json!({
            "@id": "#program",
            "@type": "SoftwareApplication",
            "name": "stiffbench",
            "softwareVersion": env!("PROGRAM_VERSION"),
        }),
        json!({
            "@id": "datapackage.json",
            "@type": "File",
            "name": "columns, units and sources of the tables",
            "encodingFormat": "application/json",
        }),
    ];
    graph.extend(resources.iter().map(|resource| {
        json!({
            "@id": resource.file,
            "@type": "File",
            "name": resource.table.title,
            "encodingFormat": media_type(resource.format),
            "contentSize": resource.bytes.to_string(),
            "sha256": resource.sha256,
        })
    }));
    json!({ "@context": "https://w3id.org/ro/crate/1.1/context", "@graph": graph })
}

fn media_type(format: &str) -> &'static str {
    match format {
        "csv" => "text/csv",
        "xlsx" => "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet",
        _ => "application/vnd.apache.parquet",
    }
}
