use schemars::JsonSchema;
use serde::Deserialize;

use super::*;
use crate::quantity::Kind;
use crate::source_text::{PlacedError, SourceText};

const NESTED: &str = "a = 1\nlist = [\n  { x = 2, y = \"µ\" },\n  { x = 3 },\n]\n[t.u]\nv = 4\n";

#[test]
fn finds_values_and_keys_in_nested_toml() {
    use DocumentStep::{Index, Key};
    let source = SourceText::new("f", NESTED);
    let value = |path: &[DocumentStep<'_>]| source.line_and_column(source.toml_span(path).start);
    assert_eq!(value(&[Key("list"), Index(1), Key("x")]), (4, 9));
    assert_eq!(value(&[Key("t"), Key("u"), Key("v")]), (7, 5));
    // A path that leads nowhere points at the last thing that exists.
    assert_eq!(value(&[Key("list"), Index(0), Key("z")]), (3, 3));
    assert_eq!(source.toml_span(&[Index(0)]), 0..0);
    let key = |path: &[DocumentStep<'_>]| source.line_and_column(source.toml_key_span(path).start);
    assert_eq!(key(&[Key("list"), Index(0), Key("y")]), (3, 12));
    assert_eq!(key(&[Key("t"), Key("u"), Key("v")]), (7, 1));
    assert_eq!(key(&[Key("list"), Index(1), Key("z")]), (4, 3));
}

#[test]
fn values_are_read_with_their_places() {
    let text = "\u{feff}n = 1_000.5\nw = 0x10\nserial = 0042\nd_mm = 3\n[t]\nnames = [\"a\", 7]\n";
    let text = text.replace("0042", "42");
    let source = SourceText::new("f.toml", text);
    let document = TomlDocument::parse(&source).unwrap();
    let root = document.root();
    assert_eq!(root.read("n", TomlValue::number).unwrap(), Some(1000.5));
    assert_eq!(root.read("w", TomlValue::count).unwrap(), Some(16_u8));
    let serial = root.read("serial", TomlValue::text_or_digits).unwrap();
    assert_eq!(serial.as_deref(), Some("42"));
    let (key, unit, value) = root.find_with_unit("d", "", Kind::Displacement).unwrap();
    assert_eq!((unit, value.digits().unwrap()), ("mm", "3"));
    let unit = root.wrong_unit(key, &value, unit, Kind::Force);
    assert_eq!(unit.0.place(), "f.toml:4:1");
    let table = root.require("t").unwrap().table().unwrap();
    let error = table.read_all("names", TomlValue::text).unwrap_err().0;
    assert_eq!(
        error.to_string(),
        "f.toml:6:15: `t.names` is `7`, expected a text in quotes"
    );
    let missing = table.require("x").unwrap_err().0.to_string();
    assert_eq!(missing, "f.toml:5:1: `x` is missing in `t`");
    let n = root.require("n").unwrap().text().unwrap_err().0;
    assert_eq!((n.line, n.column), (1, 5));
}

#[test]
fn an_unknown_key_is_reported_with_the_nearest_known_key() {
    let source = SourceText::new("f", "[a]\ndwel_s = 1\ncolour = 2\nname = 3\n");
    let document = TomlDocument::parse(&source).unwrap();
    let table = document.root().require("a").unwrap().table().unwrap();
    assert!(table.find_with_unit("dwell", "", Kind::Time).is_none());
    assert!(table.get("name").is_some());
    let warnings: Vec<String> = table.unknown().iter().map(|key| key.warning("f")).collect();
    assert_eq!(
        warnings,
        [
            "f:2:1: key `a.dwel_s` is not known and was not used; is `a.dwell_s` meant?",
            "f:3:1: key `a.colour` is not known and was not used",
        ]
    );
    let refused = table.only(&["dwell_s", "name"]).unwrap_err().0;
    assert_eq!(refused.help.as_deref(), Some("did you mean `dwell_s`?"));
}

#[test]
fn schemas_are_older_newer_or_other() {
    let check = |text: &str, required| {
        let source = SourceText::new("f", text);
        let document = TomlDocument::parse(&source).unwrap();
        let checked = document.root().check_schema("s/f/2", required);
        checked.map_err(|error| error.0.problem.word())
    };
    assert_eq!(check("schema = \"s/f/1\"", true), Ok(()));
    assert_eq!(check("", false), Ok(()));
    assert_eq!(check("", true), Err("no_schema"));
    assert_eq!(check("schema = \"s/f/3\"", true), Err("newer_schema"));
    assert_eq!(check("schema = \"s/g/1\"", true), Err("other_schema"));
    assert_eq!(check("schema = 1", false), Err("wrong_value"));
}

#[derive(Debug, PartialEq, Deserialize, JsonSchema)]
struct Format {
    name: String,
    line: Option<Line>,
}

#[derive(Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Line {
    baud: u32,
}

#[test]
fn types_are_read_in_words_of_toml() {
    let wrong = |text: &str| {
        let error: PlacedError<_> = read::<Format>(&SourceText::new("f", text)).unwrap_err().0;
        error.to_string()
    };
    let (format, unknown) = read::<Format>(&SourceText::new("f", "name = \"a\"\nnam = 1")).unwrap();
    assert_eq!(format.name, "a");
    assert_eq!(unknown[0].meant.as_deref(), Some("name"));
    assert_eq!(wrong(""), "f:1:1: missing key `name`");
    assert!(wrong("name =").starts_with("f:1:7: "));
    assert_eq!(
        wrong("name = \"a\"\nline = { baut = 1 }"),
        "f:2:10: unknown key `baut`, expected `baud`; is `baud` meant?"
    );
    assert!(wrong("name = \"a\"\nline = 3").ends_with("expected a table"));
}
