//! Instrument descriptions as files: the published schema and the documentation are those of the reader, and errors show the place.

use serde_json::Value;
use stiffbench_gauges::description::json_schema;
use stiffbench_gauges::{CommandRole, Decoded, Decoder, InstrumentDescription, Mark};
use stiffbench_test_files::shipped_instruments;

use crate::support::samples;

/// The example of the documentation.
fn example() -> &'static str {
    stiffbench_test_files::example("docs/instrument-description.md", "toml")
}

/// The example with one piece of text replaced.
fn with(find: &str, replacement: &str) -> String {
    assert!(example().contains(find), "{find} is not in the example");
    example().replacen(find, replacement, 1)
}

/// A TOML text as the JSON value that a schema sees.
fn json(text: &str) -> Value {
    serde_json::to_value(toml::from_str::<toml::Value>(text).unwrap()).unwrap()
}

#[test]
fn the_published_schema_is_that_of_the_reader() {
    let published = stiffbench_test_files::text("docs/instrument-description.schema.json");
    let generated = format!("{:#}\n", json_schema());
    assert!(
        published == generated,
        "write the schema anew: stiffbench gauge show --schema > docs/instrument-description.schema.json"
    );
    assert!(jsonschema::meta::is_valid(&json_schema()));
    assert!(!generated.contains("null"));
}

#[test]
fn shipped_descriptions_and_the_example_fit_the_schema() {
    let validator = jsonschema::validator_for(&json_schema()).unwrap();
    let shipped = shipped_instruments().iter().map(|shipped| shipped.text);
    for text in shipped.chain([example()]) {
        let errors: Vec<String> = validator
            .iter_errors(&json(text))
            .map(|error| format!("{}: {error}", error.instance_path()))
            .collect();
        assert!(errors.is_empty(), "{errors:?}");
    }
    for (find, replacement) in [
        ("instrument/1", "instrument/2"),
        ("channel = \"force\"", "channel = \"torque\""),
        ("baud = 9600", "baud = \"fast\""),
        ("expects = \"value\"", "expects = \"values\""),
        ("[framing.line]\nend = [\"\\r\\n\"]\n", ""),
    ] {
        assert!(
            !validator.is_valid(&json(&with(find, replacement))),
            "{replacement}"
        );
    }
}

#[test]
fn shipped_descriptions_stand_under_their_names() {
    for shipped in shipped_instruments() {
        let (description, warnings) =
            InstrumentDescription::parse(shipped.text, shipped.name).unwrap();
        assert_eq!(description.name, shipped.name);
        assert!(warnings.is_empty(), "{warnings:?}");
    }
}

#[test]
fn the_documented_example_decodes_as_documented() {
    let (description, warnings) = InstrumentDescription::parse(example(), "example").unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(
        description.command(CommandRole::Read).unwrap().bytes,
        b"?\r\n"
    );
    let mut decoder = Decoder::new(&description, None).unwrap();
    let mut out = Vec::new();
    decoder.asked(CommandRole::Read);
    decoder.push(b"ST,+0012.34,kgf\r\n", 0.0, &mut out);
    decoder.asked(CommandRole::Read);
    decoder.push(
        b"US,-0012.34,kgf\r\nOL,+9999.99,kgf\r\nER\r\n",
        0.0,
        &mut out,
    );
    let [
        Decoded::Sample(ready),
        Decoded::Sample(moving),
        Decoded::Rejected(overload),
        Decoded::Rejected(refused),
    ] = &out[..]
    else {
        panic!("{out:?}");
    };
    assert_eq!(
        (ready.value, &*ready.unit, ready.marks.len()),
        (12.34, "kgf", 0)
    );
    assert_eq!(
        (moving.value, &moving.marks[..]),
        (-12.34, &[Mark::Unstable][..])
    );
    assert!(overload.reason.contains("overload"));
    assert!(refused.reason.contains("did not understand"));
}

#[test]
fn unknown_keys_are_named_with_the_one_that_is_meant() {
    let text = with("baud = 9600", "baud = 9600\nstop_bit = 2");
    let (_, warnings) = InstrumentDescription::parse(&text, "my-gauge.toml").unwrap();
    let [warning] = &warnings[..] else {
        panic!("{warnings:?}");
    };
    let words = [
        "my-gauge.toml:10:1",
        "line.stop_bit",
        "is `stop_bits` meant?",
    ];
    assert!(words.iter().all(|word| warning.contains(word)), "{warning}");
}

/// What is written for what in the example, and the words of the error.
#[rustfmt::skip]
const MISTAKES: [(&str, &str, &[&str]); 24] = [
    ("instrument/1", "instrument/2", &[":1:", "stiffbench/instrument/2", "version of this program"]),
    ("schema = \"stiffbench/instrument/1\"\n", "", &["missing key `schema`"]),
    ("my-gauge", "My Gauge", &[":2:", "`name`", "My Gauge", "lower-case"]),
    ("baud = 9600", "baud = 7", &[":9:", "`line.baud` is 7", "50 to 4000000"]),
    ("baud = 9600", "baud = 9600\ndata_bits = 9", &["`line.data_bits` is 9", "7 or 8"]),
    ("baud = 9600", "baud = 9600\nparity = \"evn\"", &["unknown word `evn`", "even"]),
    ("baud = 9600", "baud = 9600\nsettle_s = -1", &["`line.settle_s` is -1"]),
    ("[commands]", "[timing]\nmost_per_s = 0\n[commands]", &["`timing.most_per_s` is 0"]),
    ("send = \"?\", ", "", &["`commands.read.send` is missing"]),
    ("send = \"?\"", "send = \"?\", bytes = [63]", &["commands.read.send", "exclude"]),
    ("expects = \"value\"", "expects = \"text\"", &["`commands.read.expects` is text"]),
    ("end = [\"\\r\\n\"]", "end = []", &["`framing.line.end` is []"]),
    ("[framing.line]\nend = [\"\\r\\n\"]", "[framing.fixed]\nlength = 0", &["`framing.fixed.length` is 0"]),
    ("from = \"packet\"", "from = \"fixed\"", &["`unit.fixed` is missing"]),
    ("from = \"packet\"", "from = \"packet\"\ncodes = { kgm = \"Nm\" }", &["`unit.codes.kgm` is \"Nm\"", "kgf"]),
    ("count = [7]", "count = [7, 3]", &[":35:", "value[0].fields[3].number.count", "[7, 3]"]),
    ("count = [7]", "count = []", &["[how many] or [least, most]"]),
    ("minus = [\"-\"]", "minus = [\"+\"]", &["value[0].fields[2].sign", "different texts"]),
    ("{ literal = \"ER\" }", "{ literal = \"\" }", &["error[0].fields[0].literal", "at least one character"]),
    ("{ number = { count = [7], point = \"in-place\" } },\n", "", &["fields with 0 numbers", "one number"]),
    ("  { literal = \",\" },\n  { unit", "  { literal = \" \" },\n  { number = { count = [5], } },\n  { unit", &["fields with 2 numbers", "own quantity", "any"]),
    ("{ number = { count = [7], point = \"in-place\" } },\n", "{ hex = { count = 13 } },\n", &["value[0].fields[3].hex.count", "1 to 12"]),
    ("{ number = { count = [7], point = \"in-place\" } },\n", "{ integer = { bytes = 0 } },\n", &["value[0].fields[3].integer.bytes", "1 to 6"]),
    ("{ number = { count = [7], point = \"in-place\" } },\n", "{ hex = { count = 4, digits = \"0123456789abcdeF\", scale = 0.0 } },\n", &["hex.scale", "other than 0"]),
];

#[test]
fn errors_state_place_cause_and_remedy() {
    for (find, replacement, words) in MISTAKES {
        let error =
            InstrumentDescription::parse(&with(find, replacement), "my-gauge.toml").unwrap_err();
        let text = format!("{error} {}", error.help.as_deref().unwrap_or_default());
        assert!(text.starts_with("my-gauge.toml:"), "{text}");
        for word in words {
            assert!(text.contains(word), "{word} is not in {text}");
        }
    }
}

#[test]
fn registers_belong_to_modbus_and_fields_to_text() {
    let text = with(
        "text = \"state, number, unit\"\n",
        "registers = { first = 0, format = \"f32\" }\n",
    );
    let error = InstrumentDescription::parse(&text, "f").unwrap_err();
    assert!(error.to_string().contains("registers"), "{error}");
    let modbus = with(
        "[framing.line]\nend = [\"\\r\\n\"]",
        "[framing.modbus]\nregisters = 2",
    );
    let error = InstrumentDescription::parse(&modbus, "f").unwrap_err();
    assert!(
        error
            .to_string()
            .contains("`value[0].registers` is missing"),
        "{error}"
    );
    let hp = shipped_instruments()
        .iter()
        .find(|shipped| shipped.name == "hp-modbus")
        .unwrap();
    let beyond = hp.text.replace("first = 0", "first = 12");
    let error = InstrumentDescription::parse(&beyond, "f").unwrap_err();
    assert!(error.to_string().contains("within the 13"), "{error}");
}

/// A desktop gauge with a start mark, a sign and five bytes of which the low four bits count, as a public program reads it.
const LOW_FOUR_BITS: &str = r#"
schema = "stiffbench/instrument/1"
name = "desk-gauge"
text = "a desktop push-pull gauge"
channel = "force"
status = "implemented"
[line]
baud = 2400
[commands]
read = { send = "e", expects = "value" }
[framing.start]
mark = [0x55, 0x01]
length = 8
[sign]
compression = "ask"
[unit]
from = "fixed"
fixed = "N"
[physical]
capacity = { N = 500 }
plausible = { N = 600 }
resolution = { N = 0.001 }
[[value]]
fields = [
  { bytes = [0x55, 0x01] },
  { sign = { plus = ["+"], minus = ["-"] } },
  { hex = { count = 5, digits = "0123456789:;<=>?", decimals = 3 } },
]
"#;

#[test]
fn integers_in_digits_and_in_bytes_are_values() {
    let (description, _) = InstrumentDescription::parse(LOW_FOUR_BITS, "desk-gauge").unwrap();
    assert_eq!(description.warnings(), [""; 0]);
    let mut decoder = Decoder::new(&description, None).unwrap();
    let mut out = Vec::new();
    decoder.push(b"U\x01+00000U\x01-0271?U\x01+0G000", 0.0, &mut out);
    let values: Vec<_> = samples(&out)
        .iter()
        .map(|sample| (sample.value, sample.resolution_si))
        .collect();
    assert_eq!(values, [(0.0, 0.001), (-10.015, 0.001)]);

    let text = LOW_FOUR_BITS.replace(
        "  { sign = { plus = [\"+\"], minus = [\"-\"] } },\n  { hex = { count = 5, digits = \"0123456789:;<=>?\", decimals = 3 } },\n",
        "  { integer = { bytes = 3, order = \"low-first\", signed = true, scale = 0.0005 } },\n",
    );
    let text = text.replace("length = 8", "length = 5");
    let (description, _) = InstrumentDescription::parse(&text, "desk-gauge").unwrap();
    let mut decoder = Decoder::new(&description, None).unwrap();
    let mut out = Vec::new();
    decoder.push(&[0x55, 1, 0xfe, 0xff, 0xff], 0.0, &mut out);
    let [Decoded::Sample(sample)] = &out[..] else {
        panic!("{out:?}");
    };
    assert_eq!((sample.value, sample.resolution_si), (-0.001, 0.0005));
}

#[test]
fn open_values_of_a_description_are_required_from_the_user() {
    let (description, _) = InstrumentDescription::parse(example(), "example").unwrap();
    assert_eq!(description.warnings(), [""; 0], "the example of the page");
    let state = "{ choice = { good = [\"ST\"], note = { US = \"unstable\" }, refuse = { OL = \"overload: unload the gauge\" } } }";
    let error = "[[error]]\nmeaning = \"refused\"\ntext = \"the gauge did not understand\"\nfields = [{ literal = \"ER\" }]";
    #[rustfmt::skip]
    let cases = [
        (", refuse = { OL = \"overload: unload the gauge\" }", "", "overloaded is not described"),
        ("capacity = { kgf = 50 }\n", "", "physical.capacity"),
        ("resolution = { kgf = 0.01 }\n", "", "physical.resolution"),
        ("  { unit = { others = [1, 6] } },\n", "", "carries no unit"),
        // What could say something must not be passed over.
        (state, "{ any = { count = [2] } }", "skips letters"),
        ("{ sign = { plus = [\"+\"], minus = [\"-\"] } }", "{ any = { count = [1], of = \"+-\" } }", "may be a sign"),
        // One packet is taken for another.
        (error, "[[error]]\nmeaning = \"refused\"\ntext = \"any\"\nfields = [{ any = { count = [1, 40] } }]", "is refused"),
        ("[[value]]\n", "[[value]]\nfields = [{ literal = \"ST,\" }, { sign = { plus = [\"+\"], minus = [\"-\"] } }, { any = { count = [2], of = \"0\" } }, { number = { count = [5], point = \"none\", decimals = 1 } }, { literal = \",\" }, { unit = { others = [1, 6] } }]\n[[value]]\n", "value[0]"),
    ];
    for (find, replacement, part) in cases {
        let (description, _) = InstrumentDescription::parse(&with(find, replacement), "f").unwrap();
        let warnings = description.warnings();
        let named = warnings.iter().any(|warning| warning.contains(part));
        assert!(named, "{part} is not in {warnings:?}");
    }
}

#[test]
fn a_decimal_comma_is_distinguished_from_garbage() {
    let (description, _) = InstrumentDescription::parse(example(), "example").unwrap();
    let mut decoder = Decoder::new(&description, None).unwrap();
    let mut out = Vec::new();
    decoder.push(b"ST,+0012,34,kgf\r\nST,+001x,34,kgf\r\n", 0.0, &mut out);
    let [Decoded::Rejected(comma), Decoded::Rejected(garbage)] = &out[..] else {
        panic!("{out:?}");
    };
    assert!(comma.reason.contains("set `comma = true`"), "{comma:?}");
    assert!(garbage.reason.contains("garbled"), "{garbage:?}");
}
