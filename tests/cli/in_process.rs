//! Commands that other programs run in their own process, against the program.

use std::ffi::OsString;

use serde_json::Value;
use stiffbench::cli::{json_of, tables_of};
use stiffbench::export::tidy::csv;

use super::desk_with_session;

fn words(text: &str) -> Vec<OsString> {
    text.split(' ').map(OsString::from).collect()
}

#[test]
fn the_object_is_the_one_that_is_printed() {
    let desk = desk_with_session();
    let session = desk.path("session").display().to_string();
    for command in [
        format!("stiffness {session} --branches both --budget"),
        format!("fit {session} --train=P1,P3"),
        format!("diagnose {session} --out {session}/d --no-figures"),
    ] {
        let printed = desk.run(&format!("{command} --json")).succeeds().json();
        assert_eq!(json_of(words(&command)).unwrap(), printed, "{command}");
    }
    for command in [
        "stiffness no-such-session".to_owned(),
        format!("stiffness {session} --branches some"),
        format!("fit {session} --train P1,P9"),
        format!("fit {session} --robot serial-arm"),
        "no-such-command".to_owned(),
    ] {
        let ran = desk.run(&format!("{command} --json"));
        let printed: Value = serde_json::from_str(&ran.stdout).unwrap();
        assert_eq!(printed["error"]["exit_code"], ran.code);
        assert_eq!(json_of(words(&command)).unwrap_err(), printed, "{command}");
    }
}

#[test]
fn the_tables_are_those_of_export() {
    let desk = desk_with_session();
    let session = desk.path("session").display().to_string();
    desk.run("export session --branches both --out tables")
        .succeeds();
    let tables = tables_of(words(&format!("{session} --branches both"))).unwrap();
    assert_eq!(tables.len(), 5);
    for table in tables {
        let written = desk.read(&format!("tables/{}.csv", table.name));
        assert_eq!(String::from_utf8(csv(&table)).unwrap(), written);
    }
    let missing = tables_of(words("no-such-session")).unwrap_err();
    assert_eq!(missing["error"]["code"], "stiffbench::input::not_found");
}
