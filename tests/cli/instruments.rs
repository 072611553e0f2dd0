//! `instrument`: what is known of gauges, and bytes to samples.

use serde_json::{Value, json};

use super::{Desk, Ran, assert_output_contains, desk};
use crate::support::{Contains, Json};

/// Decodes bytes on standard input.
fn decode(desk: &Desk, arguments: &str, bytes: &[u8]) -> Ran {
    let mut command = desk.command(&format!("gauge decode {arguments}"));
    Ran::of(command.write_stdin(bytes))
}

fn decoded(desk: &Desk, arguments: &str, bytes: &[u8]) -> Value {
    let ran = decode(desk, &format!("{arguments} --json"), bytes);
    ran.succeeds().json()["data"].take()
}

#[test]
fn bytes_become_samples_in_the_unit_that_is_named_and_the_sign_as_sent() {
    let desk = desk();
    let data = decoded(
        &desk,
        "mark10-series5 --unit N",
        b"4.285 N\r\n-1.0 lbF\r\n*10\r\n1 lbFin\r\n\x80\r\n",
    );
    assert_eq!(
        data["samples"],
        json!([
            { "value": 4.285, "unit": "N", "raw": "4.285 N", "marks": [] },
            { "value": -4.448_221_615_260_5, "unit": "N", "raw": "-1.0 lbF", "marks": [] },
        ])
    );
    let rejected = data["rejected"].list();
    let raw: Vec<&Value> = rejected.iter().map(|one| &one["raw"]).collect();
    assert_eq!(raw, ["*10", "1 lbFin", "\\x80"]);
    let data = decoded(&desk, "imada-ds2 --unit N", b"-056.7NTL\r-056.7NPL\r");
    assert_eq!(data["samples"][0]["value"], -56.7);
    assert_eq!(data["samples"][0]["marks"], json!(["below-limit"]));
    data["rejected"][0]["reason"]
        .word()
        .must_contain(&["peak mode"]);
}

#[test]
fn a_description_of_ones_own_is_checked_listed_and_used() {
    let desk = desk();
    let shown = desk
        .run("gauge show generic-ascii --toml")
        .succeeds()
        .stdout;
    let own = shown.replace("name = \"generic-ascii\"", "name = \"my-gauge\"");
    desk.write("own/instruments/my-gauge.toml", &own);
    let check = desk
        .run("gauge check own/instruments/my-gauge.toml")
        .succeeds();
    check
        .stderr
        .must_contain(&["overloaded", "capacity", "resolution"]);
    let data = desk.data("gauge list --protocols own");
    assert_eq!(data["instruments"][0]["name"], "my-gauge");
    let data = decoded(&desk, "my-gauge --protocols own --unit N", b"1.5 kgf\n");
    assert_eq!(data["samples"][0]["value"], 14.709_975);
    // A session is rehearsed with it: its description plays the gauge.
    desk.run("session run s --emulated --no-input --speed 50 --protocols own --force-instrument my-gauge --poses P1 --directions x --repeats 1")
        .succeeds();
    let data = desk.data("session verify s");
    assert_eq!(data["readings"], 9, "{data}");
    assert!(!desk.read("s/session.toml").contains("resolution"));
    // The step of its display, where it is known, goes into the session and so into U.
    desk.write(
        "stated/instruments/my-gauge.toml",
        &format!("{own}\n[physical.resolution]\nN = 0.02\n"),
    );
    desk.run("session run t --emulated --no-input --speed 50 --protocols stated --force-instrument my-gauge --poses P1 --directions x --repeats 1 --loads-n=0,-20")
        .succeeds();
    let header = desk.read("t/session.toml");
    header.must_contain(&["resolution_N = 0.02"]);
    assert!(
        desk.read("s/readings.csv").contains("0N,0,"),
        "the gauge's own text"
    );
    desk.write(
        "own/instruments/broken.toml",
        &own.replace("baud = 9600", "baud = 9"),
    );
    let error = desk.refusal(
        "gauge check own/instruments/broken.toml",
        10,
        "stiffbench::instrument::description",
    );
    assert_output_contains(&error, &["broken.toml:", "`line.baud` is 9"]);
    let list = desk.run("gauge list --protocols own").succeeds();
    list.stderr.must_contain(&["left out: "]);
}
