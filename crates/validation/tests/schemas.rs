//! The published schemas are those of the result structs; what the commands print is held to them wherever a test reads it.

use serde_json::json;

use stiffbench_test_files::schemas::are_published;
use stiffbench_validation::report::schemas;

#[test]
fn the_schemas_are_published() {
    let schemas = schemas().into_iter();
    are_published(
        "docs/schemas/validate",
        schemas.map(|(kind, schema)| (kind, json!(schema))),
    );
}
