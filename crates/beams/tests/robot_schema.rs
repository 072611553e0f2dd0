//! The published JSON Schema of the robot file is that of the reader, and knows a robot file when it sees one.

use crate::support::level_arm;
use serde_json::Value;
use stiffbench_beams::robot::file::json_schema;
use stiffbench_beams::robot::format2;
use stiffbench_test_files::{shipped_robot, shipped_robots};

/// A TOML text as the JSON value that a schema sees.
fn json(text: &str) -> Value {
    serde_json::to_value(toml::from_str::<toml::Value>(text).unwrap()).unwrap()
}

#[test]
fn the_shipped_schemas_are_those_of_the_readers() {
    for (file, schema, command) in [
        (
            "planar-linkage-robot",
            json_schema(),
            "robot show hp-robot --schema",
        ),
        ("robot-2", format2::json_schema(), "robot show --schema"),
    ] {
        let path = format!("data/robots/{file}.schema.json");
        let generated = format!("{schema:#}\n");
        assert!(
            stiffbench_test_files::text(&path) == generated,
            "write the schema anew: stiffbench {command} > {path}"
        );
        assert!(jsonschema::meta::is_valid(&schema), "{file}");
        assert!(!generated.contains("null"), "{file}: TOML has no null");
    }
}

#[test]
fn the_second_format_knows_its_units() {
    let validator = jsonschema::validator_for(&format2::json_schema()).unwrap();
    let robot = |joint: &str| {
        json(&format!(
            "schema = \"stiffbench/robot/2\"\nname = \"a\"\nup = \"z\"\n[joints]\nJ1 = {{ {joint} }}\n"
        ))
    };
    for joint in [
        "at_mm = [0, 0, 100]",
        "at = [0, 0, \"h\"]",
        "stiffness_Nm_per_rad = 1e5",
        "across = { y = \"free\", z = { compliance_urad_per_Nm = 2 } }",
        "angle = { J1 = -1, offset_deg = 90 }",
        "axis = [0, 1, 0]",
    ] {
        assert!(validator.is_valid(&robot(joint)), "{joint}");
    }
    for joint in [
        "at_inch = [0, 0, 100]",
        "at_mm = [0, 0]",
        "stiffness_Nm = 1e5",
        "spring = \"loose\"",
        "kind = \"prismatic\"",
    ] {
        assert!(!validator.is_valid(&robot(joint)), "{joint}");
    }
}

#[test]
fn shipped_robots_and_the_example_fit() {
    let formats = [json_schema(), format2::json_schema()];
    let validators = formats.map(|schema| jsonschema::validator_for(&schema).unwrap());
    let shipped = shipped_robots().map(|name| shipped_robot(name).unwrap().text);
    for text in shipped.chain([level_arm::text().to_owned()]) {
        let validator = &validators[usize::from(text.contains(format2::SCHEMA))];
        let errors: Vec<String> = validator
            .iter_errors(&json(&text))
            .map(|error| format!("{}: {error}", error.instance_path()))
            .collect();
        assert!(errors.is_empty(), "{errors:?}");
    }
}

#[test]
fn what_the_reader_refuses_by_shape_does_not_fit() {
    let validator = jsonschema::validator_for(&json_schema()).unwrap();
    for (find, replacement) in [
        (r#"class = "beam""#, r#"class = "bean""#),
        (r#"class = "beam", "#, ""),
        (r#"nodes = ["G", "O"]"#, r#"nodes = ["G", "O", "A"]"#),
        ("planar-linkage-robot/1", "planar-linkage-robot/2"),
        ("A = 3.0e-3", "A = \"thick\""),
        ("A = 3.0e-3\n", ""),
        ("[support]\nfixed = [\"G\"]\n", ""),
        (", plane = \"upright\", branch = -1", ""),
        (r#"["C", "arm"]"#, r#"["C"]"#),
        ("axis = [-1.0, 0.0, 0.0]", "axis = [-1.0, 0.0]"),
        ("lift = 45.0", "lift = true"),
        ("density = 7850.0", "density = \"steel\""),
        ("mass_per_m = 2.9", "mass_per_m = [2.9]"),
        ("E = 4.0", "E = \"4 kg\""),
    ] {
        let text = level_arm::with(find, replacement);
        assert!(!validator.is_valid(&json(&text)), "{replacement}");
    }
}
