//! Several sessions of one robot, diagnosed and fitted together.

use serde_json::Value;

use super::desk;

/// A springy joint that one pose cannot separate from others.
const SPRINGY: &str = "--effect joint-compliance@A3:c=2urad/(N*m)";

fn strings(value: &Value) -> Vec<&str> {
    let all = value.as_array().unwrap().iter();
    all.map(|one| one.as_str().unwrap()).collect()
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
    let members = |data: &Value| data["findings"].as_array().unwrap().len();
    assert!(members(data) < members(&alone["data"]) / 2, "{data}");
    let finding = data["findings"]
        .as_array()
        .unwrap()
        .iter()
        .find(|one| one["physics"] == "joint-compliance" && one["place"]["joint"] == "A3");
    let ends = finding.unwrap()["parameters"]["c"]["ci95"]
        .as_array()
        .unwrap();
    assert!(
        ends[0].as_f64().unwrap() < 2e-6 && 2e-6 < ends[1].as_f64().unwrap(),
        "{ends:?}"
    );
    let sessions = data["sessions"].as_array().unwrap();
    assert_eq!(sessions.len(), 2);
    let sd = |session: usize| sessions[session]["reading_sd_um"].as_f64().unwrap();
    assert!(
        (2.4..3.9).contains(&sd(0)) && (4.8..7.5).contains(&sd(1)),
        "{sessions:?}"
    );
    assert!(members(&alone["data"]) == strings(&sessions[0]["open_before"]).len());
    assert_eq!(together["inputs"]["data"].as_array().unwrap().len(), 2);
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
    for words in ["SESSIONS, EACH", "left open", "decide for", "simulated-91"] {
        assert!(page.contains(words), "{words}: {page}");
    }
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
    let file = desk.folder.path().join("second/readings.csv");
    let text = std::fs::read_to_string(&file).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let column = lines[0]
        .split(',')
        .position(|name| name == "displacement_um")
        .unwrap();
    let mut cells: Vec<String> = lines[40].split(',').map(str::to_owned).collect();
    let moved = cells[column].parse::<f64>().unwrap() + 300.0;
    cells[column] = moved.to_string();
    lines[40] = cells.join(",");
    std::fs::write(&file, lines.join("\n") + "\n").unwrap();
    let run = desk.run("diagnose first second --no-figures --json --trust-csv");
    let data = run.succeeds().json()["data"].clone();
    assert_eq!(data["verdict"], "nothing-missing");
    let found = data["data_findings"].as_array().unwrap();
    assert_eq!(found.len(), 1);
    assert_eq!(found[0]["lines"][0], 41);
    assert_eq!(found[0]["file"], "second");
    assert_eq!(found[0]["place"]["reading"]["pose"], "simulated-2/P1");
    let bad: Vec<u64> = data["sessions"]
        .as_array()
        .unwrap()
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
        let ends = fit["factors"]["beam"]["Iy"]["ci95"].as_array().unwrap();
        (ends[1].as_f64().unwrap() / ends[0].as_f64().unwrap()).ln()
    };
    let both = fit("one other");
    assert!(width(&both) < 0.9 * width(&fit("one")).min(width(&fit("other"))));
    let poses: Vec<String> = both["cells"]
        .as_array()
        .unwrap()
        .iter()
        .map(|cell| {
            format!(
                "{}/{}",
                cell["session"].as_str().unwrap(),
                cell["pose"].as_str().unwrap()
            )
        })
        .collect();
    assert_eq!(poses.len(), 12);
    assert_eq!(poses[0], "simulated-1/P1");
    assert_eq!(poses[11], "simulated-2/P3");
    assert_eq!(both["sessions"][1]["cells"], 6);
    let text = desk.run("fit one other").succeeds().stdout;
    assert!(
        text.contains("Session simulated-2: 6 cells") && text.contains("simulated-1/P2"),
        "{text}"
    );
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
