//! Gauges on pseudo-terminals, as a user reads, finds, binds and records them.

use super::{Desk, Ran, assert_output_contains, desk, misuse};
use crate::support::{Contains, Json};

#[path = "../../crates/gauges/tests/lines/device.rs"]
mod device;

use device::Device;

/// A force gauge that answers as the maker prints it: the n-th value is n.5 N.
pub(crate) fn mark10(desk: &Desk) -> Device {
    mark10_set_to(None, desk)
}

fn mark10_set_to(baud: Option<u32>, desk: &Desk) -> Device {
    let mut count = 0;
    Device::set_to(baud, &desk.path("gauge"), move |command| match command {
        "?C" => {
            count += 1;
            vec![format!("-{count}.5 N\r\n").into_bytes()]
        }
        "RS" => vec![b"3791204\r\n".to_vec()],
        "LIST" => vec![b"V1.00;N;CUR;FLTC8;FLTP1;AOUT00;AOFF5;FULL;MIT;POL;B0\r\n".to_vec()],
        "AOUT0" => Vec::new(),
        _ => vec![b"*10\r\n".to_vec()],
    })
}

#[test]
fn values_are_read_one_by_one() {
    let desk = desk();
    let _gauge = mark10(&desk);
    let data = desk.data("gauge read mark10-series5 --port gauge --count 3");
    assert_eq!(data["identity"], "3791204");
    let values: Vec<f64> = data["samples"]
        .list()
        .iter()
        .map(|sample| sample["value"].number())
        .collect();
    // The first after opening is left out.
    assert_eq!(values, [-2.5, -3.5, -4.5]);
    assert_eq!(data["samples"][0]["unit"], "N");
    assert_eq!(data["samples"][0]["raw"], "-2.5 N");
    let text = desk
        .run("gauge read mark10-series5 --port gauge")
        .succeeds()
        .stdout;
    text.must_contain(&["N\n", "1 value and"]);
}

#[test]
fn absent_busy_silent_and_wrong_gauges_are_distinguished() {
    let desk = desk();
    let error = desk.refusal(
        "gauge read mark10-series5 --port gauge",
        20,
        "stiffbench::port::absent",
    );
    assert_output_contains(&error, &["gauge does not exist", "stiffbench gauge ports"]);
    desk.write("file", "");
    let error = desk.refusal(
        "gauge read mark10-series5 --port file",
        20,
        "stiffbench::port::no_line",
    );
    assert_output_contains(&error, &["it is a file"]);
    let error = misuse(&desk, "gauge read mark10-series5");
    assert_output_contains(&error, &["--port", "stiffbench gauge bind"]);
    let _gauge = Device::at(&desk.path("gauge"), |_| Vec::new());
    let error = desk.refusal(
        "gauge read mark10-series5 --port gauge",
        20,
        "stiffbench::port::silent",
    );
    assert_output_contains(&error, &["nothing answers", "switch the gauge on"]);
    desk.write("stiffbench-bench.toml", "schema = \"stiffbench/bindings/1\"\n[force]\ninstrument = \"mark10-series5\"\nidentity = \"1\"\npath = \"other\"\n");
    let _other = Device::at(&desk.path("other"), |_| vec![b"3791204\r\n".to_vec()]);
    let error = desk.refusal(
        "gauge read mark10-series5",
        20,
        "stiffbench::port::wrong_device",
    );
    assert_output_contains(&error, &["expected 1", "3791204"]);
}

#[test]
fn what_is_on_a_port_is_found_and_bound() {
    let desk = desk();
    let _gauge = mark10(&desk);
    let data = desk.data("gauge probe gauge --instrument mark10-series5");
    assert_eq!(data["ports"][0]["match"], "mark10-series5", "{data}");
    assert_eq!(data["ports"][0]["instruments"][0]["identity"], "3791204");
    let data = desk.data("gauge bind force --port gauge --instrument mark10-series5");
    assert_eq!(data["binding"]["identity"], "3791204");
    let data = desk.data("gauge read mark10-series5");
    assert_eq!(data["samples"].list().len(), 1);
    // A speed that is the description's is not repeated.
    assert!(!desk.read("stiffbench-bench.toml").contains("baud"));
    let error = misuse(
        &desk,
        "gauge bind displacement --port gauge --instrument mark10-series5",
    );
    assert_output_contains(&error, &["is a force gauge"]);
    desk.refusal(
        "gauge bind force --within 0.2",
        20,
        "stiffbench::port::absent",
    );
    assert!(desk.data("gauge ports")["ports"].is_array());
}

#[test]
fn a_gauge_set_to_another_speed_is_found_and_read_at_it() {
    let desk = desk();
    let _gauge = mark10_set_to(Some(9600), &desk);
    let error = desk.refusal(
        "gauge read mark10-series5 --port gauge",
        20,
        "stiffbench::port::silent",
    );
    assert_output_contains(&error, &["gauge probe", "other speeds"]);
    let data = desk.data("gauge probe gauge --instrument mark10-series5");
    assert_eq!(data["ports"][0]["instruments"][0]["other_baud"], 9600);
    let data = desk.data("gauge bind force --port gauge --instrument mark10-series5");
    assert_eq!(data["binding"]["baud"], 9600, "{data}");
    let data = desk.data("gauge read mark10-series5");
    assert_eq!(data["samples"].list().len(), 1);
}

#[test]
fn what_is_recorded_is_shown_decoded_and_replayed() {
    let desk = desk();
    let gauge = mark10(&desk);
    let recorded = desk.data("gauge record mark10-series5 --port gauge --seconds 1 --out a.trace");
    let values = recorded["values"].as_u64().unwrap();
    assert!(values >= 2, "{recorded}");
    drop(gauge);
    desk.refusal(
        "gauge record mark10-series5 --port gauge --seconds 1 --out a.trace",
        13,
        "stiffbench::output::exists",
    );
    let shown = desk.data("gauge show a.trace");
    assert_eq!(shown["complete"], true);
    assert_eq!(shown["instrument"], "mark10-series5");
    let count = |data: &serde_json::Value| data["samples"].list().len() as u64;
    let decoded = desk.data("gauge decode a.trace");
    assert_eq!(count(&decoded), values);
    let replayed = desk.data("gauge replay a.trace --speed max");
    assert_eq!(count(&replayed), values);
    assert_eq!(replayed["samples"][0]["raw"], decoded["samples"][0]["raw"]);
    assert_eq!(count(&desk.data("gauge replay a.trace --speed 50")), values);
    // Cut in the middle of a line: what stands before counts, and that it was cut is said.
    let whole = desk.read("a.trace");
    desk.write("cut.trace", &whole[..whole.len() / 2]);
    let Ran { stderr, .. } = desk.run("gauge decode cut.trace").succeeds();
    stderr.must_contain(&["no end mark"]);
    let cut = count(&desk.data("gauge decode cut.trace"));
    assert!(0 < cut && cut < values, "{cut} of {values}");
    desk.write("none.trace", "force\n");
    desk.refusal("gauge show none.trace", 11, "stiffbench::trace::schema");
}
