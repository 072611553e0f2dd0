//! Several sessions of one robot, diagnosed and fitted together.

use serde_json::Value;

use super::desk;
use crate::support::tables::Table;
use crate::support::{Contains, Json};

/// A springy joint that one pose cannot separate from others.
const SPRINGY: &str = "--effect joint-compliance@A3:c=2urad/(N*m)";

fn strings(value: &Value) -> Vec<&str> {
    let all = value.list().iter();
    all.map(Json::word).collect()
}

#[test]
fn what_one_session_leaves_open_the_proposed_one_narrows() {
    let desk = desk();
    let simulate = |name: &str, options: &str| {
        desk.run(&format!("simulate {name} {SPRINGY} {options}"))
            .succeeds();
    };
    simulate("first", "--poses P1 --seed 1");
    let alone = desk
        .run("diagnose first --no-figures --json")
        .succeeds()
        .json();
    assert_eq!(alone["data"]["verdict"], "ambiguous");
    assert!(alone["data"]["sessions"].is_null());
    // Another day, another gauge.
    simulate(
        "second",
        "--procedure first/diagnosis/next-1.toml --seed 91 --displacement-step-um 2 --reading-sd-um 6",
    );
    let run = desk.run("diagnose first second --no-figures --json");
    let together = run.succeeds().json();
    let data = &together["data"];
    let members = |data: &Value| data["findings"].list().len();
    assert!(members(data) < members(&alone["data"]) / 2, "{data}");
    let finding = data["findings"]
        .list()
        .iter()
        .find(|one| one["physics"] == "joint-compliance" && one["place"]["joint"] == "A3");
    let ends = finding.unwrap()["parameters"]["c"]["ci95"].list();
    assert!(
        ends[0].number() < 2e-6 && 2e-6 < ends[1].number(),
        "{ends:?}"
    );
    let sessions = data["sessions"].list();
    assert_eq!(sessions.len(), 2);
    let sd = |session: usize| sessions[session]["reading_sd_um"].number();
    assert!(
        (2.4..3.9).contains(&sd(0)) && (4.8..7.5).contains(&sd(1)),
        "{sessions:?}"
    );
    assert!(members(&alone["data"]) == strings(&sessions[0]["open_before"]).len());
    assert_eq!(together["inputs"]["data"].list().len(), 2);
    // The diagnosis of the first alone stays; that of both stands beside the last.
    let page = |session: &str| {
        let file = desk
            .folder
            .path()
            .join(session)
            .join("diagnosis/verdict.txt");
        std::fs::read_to_string(file).unwrap()
    };
    assert!(!page("first").contains("SESSIONS, EACH"));
    let page = page("second");
    page.must_contain(&["SESSIONS, EACH", "left open", "decide for", "simulated-91"]);
}

#[test]
fn a_bad_reading_and_a_slip_stay_in_their_session() {
    let desk = desk();
    for (name, seed) in [("first", 1), ("second", 2)] {
        desk.run(&format!(
            "simulate {name} --mechanism A --poses P1 --seed {seed}"
        ))
        .succeeds();
    }
    let mut table = Table::parse(&desk.read("second/readings.csv"));
    table.change(39, "displacement_um", |read| read + 300.0);
    desk.write("second/readings.csv", &table.text());
    let data = desk.data("diagnose first second --no-figures --trust-csv");
    assert_eq!(data["verdict"], "nothing-missing");
    let found = data["data_findings"].list();
    assert_eq!(found.len(), 1);
    assert_eq!(found[0]["lines"][0], 41);
    assert_eq!(found[0]["file"], "second");
    assert_eq!(found[0]["place"]["reading"]["pose"], "simulated-2/P1");
    let bad: Vec<u64> = data["sessions"]
        .list()
        .iter()
        .map(|one| one["bad_readings"].as_u64().unwrap())
        .collect();
    assert_eq!(bad, [0, 1]);
}

#[test]
fn a_fit_of_several_sessions_determines_more_than_each() {
    let desk = desk();
    desk.run("simulate one --mechanism A --poses P1,P2 --seed 1")
        .succeeds();
    desk.run("simulate other --mechanism A --poses P2,P3 --seed 2")
        .succeeds();
    let fit = |sessions: &str| {
        let run = desk.run(&format!("fit {sessions} --json"));
        run.succeeds().json()["data"].clone()
    };
    let width = |fit: &Value| {
        let ends = fit["factors"]["beam"]["Iy"]["ci95"].list();
        (ends[1].number() / ends[0].number()).ln()
    };
    let both = fit("one other");
    assert!(width(&both) < 0.9 * width(&fit("one")).min(width(&fit("other"))));
    let poses: Vec<String> = both["cells"]
        .list()
        .iter()
        .map(|cell| format!("{}/{}", cell["session"].word(), cell["pose"].word()))
        .collect();
    assert_eq!(poses.len(), 12);
    assert_eq!(poses[0], "simulated-1/P1");
    assert_eq!(poses[11], "simulated-2/P3");
    assert_eq!(both["sessions"][1]["cells"], 6);
    let text = desk.run("fit one other").succeeds().stdout;
    text.must_contain(&["Session simulated-2: 6 cells", "simulated-1/P2"]);
    for arguments in [
        "fit one one",
        "fit one other --bootstrap 20",
        "fit paper-experiment one",
    ] {
        let error = desk
            .run(&format!("{arguments} --json"))
            .exits_with(2)
            .json();
        assert_eq!(
            error["error"]["code"], "stiffbench::usage::argument",
            "{error}"
        );
    }
}
