//! Settings come from options, variables, the file of the folder, the file of the user and the program, in this order; results state them.

use serde_json::Value;
use stiffbench_test_files::desk::{Desk, Ran};

use super::{assert_output_contains, desk, five_columns};
use crate::support::{Contains, Json};

/// A desk whose user has no configuration but what a test writes to `home`.
fn run(desk: &Desk, folder: &str, variables: &[(&str, &str)], arguments: &str) -> Ran {
    let mut command = desk.command(arguments);
    command.current_dir(desk.path(folder));
    command.env("XDG_CONFIG_HOME", desk.path("home"));
    for (name, value) in variables {
        command.env(name, value);
    }
    Ran::of(&mut command)
}

fn setting(ran: &Ran, name: &str) -> Value {
    ran.json()["data"]["settings"].named(name).clone()
}

#[test]
fn each_layer_goes_before_those_below_it() {
    let desk = desk();
    desk.write("work/deep/x", "");
    let show = |variables: &[(&str, &str)], more: &str| {
        let ran = run(
            &desk,
            "work/deep",
            variables,
            &format!("config show --json {more}"),
        );
        setting(&ran.succeeds(), "progress")
    };
    let is = |found: &Value, value: &str, origin: &str| {
        assert_eq!(found["value"], value);
        assert_eq!(found["origin"], origin);
    };
    is(&show(&[], ""), "auto", "default");
    desk.write(
        "home/stiffbench/config.toml",
        "progress = \"bar\"\noperator = \"operator 7\"\n",
    );
    is(&show(&[], ""), "bar", "user");
    desk.write("work/stiffbench.toml", "progress = \"text\"\n");
    is(&show(&[], ""), "text", "folder");
    is(
        &show(&[("STIFFBENCH_PROGRESS", "none")], ""),
        "none",
        "environment",
    );
    is(
        &show(&[("STIFFBENCH_PROGRESS", "none")], "--progress bar"),
        "bar",
        "option",
    );
    // What only a lower layer states is kept.
    let ran = run(&desk, "work/deep", &[], "config show --json");
    assert_eq!(setting(&ran, "operator")["value"], "operator 7");
    for (variables, option) in [
        (&[][..], "--no-config"),
        (&[("STIFFBENCH_CONFIG", "none")][..], ""),
    ] {
        is(&show(variables, option), "auto", "default");
    }
    desk.write("other.toml", "progress = \"bar\"\n");
    let other = desk.path("other.toml").display().to_string();
    is(&show(&[("STIFFBENCH_CONFIG", &other)], ""), "bar", "folder");
    let text = run(&desk, "work/deep", &[], "config show --origin")
        .succeeds()
        .stdout;
    text.must_contain(&["stiffbench.toml", "default"]);
    let paths = run(&desk, "work/deep", &[], "config path")
        .succeeds()
        .stdout;
    assert!(
        paths
            .lines()
            .next()
            .unwrap()
            .ends_with("work/stiffbench.toml (exists)"),
        "{paths}"
    );
}

#[test]
fn a_session_goes_before_files_and_variables() {
    let desk = desk();
    desk.write(
        "s/session.toml",
        "schema = \"stiffbench/session/1\"\nrobot = \"robot.toml\"\nplace = \"Hall 3\"\n",
    );
    desk.write(
        "stiffbench.toml",
        "place = \"Hall 1\"\noperator = \"operator 7\"\n",
    );
    let variables = [("STIFFBENCH_PLACE", "Hall 2")];
    let of_session = run(&desk, ".", &variables, "config show s --json").succeeds();
    let place = setting(&of_session, "place");
    assert_eq!(place["value"], "Hall 3");
    assert_eq!(place["origin"], "session");
    assert_eq!(setting(&of_session, "robot")["origin"], "session");
    assert_eq!(setting(&of_session, "operator")["origin"], "folder");
    let text = run(&desk, ".", &variables, "config show s --origin")
        .succeeds()
        .stdout;
    text.must_contain(&["session s/session.toml"]);
    let none = run(&desk, ".", &[], "config show home --json").succeeds();
    assert_eq!(none.json()["warnings"][0], "home has no session.toml");
}

#[test]
fn a_configured_robot_is_used_where_nothing_names_one_and_is_stated() {
    let desk = desk();
    desk.write("readings.csv", &five_columns(&["P1", "P2"], 3));
    let fit = "fit readings.csv";
    let code = "stiffbench::usage::no_robot";
    desk.refusal(fit, 2, code);
    desk.write("stiffbench.toml", "robot = \"hp-robot\"\n");
    let ran = run(&desk, "", &[], fit).succeeds();
    ran.stdout.must_contain(&["stiffbench.toml, mechanism F"]);
    for leading in ["--no-input", "--progress none", "--color=never -vv"] {
        let ran = run(&desk, "", &[], &format!("{leading} {fit}")).succeeds();
        ran.stdout.must_contain(&["stiffbench.toml, mechanism F"]);
    }
    let json = run(&desk, "", &[], "fit readings.csv --json")
        .succeeds()
        .json();
    assert!(
        json["inputs"]["robot"]["from"]
            .word()
            .ends_with("stiffbench.toml")
    );
    // An option goes first, and a session has its own robot.
    let json = run(&desk, "", &[], "fit readings.csv --robot hp-robot --json")
        .succeeds()
        .json();
    assert_eq!(json["inputs"]["robot"].get("from"), None);
    desk.write("stiffbench.toml", "robot = \"serial-arm\"\n");
    desk.run("simulate session --robot hp-robot --poses P1,P2 --no-config")
        .succeeds();
    let json = run(&desk, "", &[], "fit session --json").succeeds().json();
    json["inputs"]["robot"]["name"]
        .word()
        .must_contain(&["palletising"]);
    run(&desk, "", &[], "fit readings.csv --no-config").exits_with(2);
}

#[test]
fn paths_are_relative_to_the_file_and_used_settings_are_noted() {
    let desk = desk();
    desk.write(
        "lab/stiffbench.toml",
        "protocols = \"gauges\"\nrobot = \"arm.toml\"\n",
    );
    desk.write("lab/gauges/instruments/note.txt", "");
    desk.run("robot show hp-robot").succeeds();
    let ran = run(&desk, "lab/gauges", &[], "gauge list").succeeds();
    ran.stderr.must_contain(&["note: protocols ", "lab/gauges"]);
    let quiet = run(&desk, "lab/gauges", &[], "gauge list --quiet").succeeds();
    assert_eq!(quiet.stderr, "");
    let given = run(&desk, "lab/gauges", &[], "gauge list --protocols .").succeeds();
    assert!(!given.stderr.contains("protocols"), "{}", given.stderr);
    let ran = run(&desk, "lab", &[], "config show --json");
    assert_eq!(setting(&ran, "robot")["value"], "arm.toml");
}

#[test]
fn mistakes_are_errors_with_their_place() {
    let desk = desk();
    #[rustfmt::skip]
    let cases = [
        ("robott = \"a\"\n", "unknown_key", ["stiffbench.toml:1:1", "did you mean robot"]),
        ("\noperator = 3\n", "syntax", ["stiffbench.toml:2:12", "expected a string"]),
        ("operator = \n", "syntax", ["stiffbench.toml:1", "--no-config"]),
        ("progress = \"loud\"\n", "value", ["stiffbench.toml:1:12: progress is `loud`", "one of auto, bar, text and none"]),
        ("\nplace = \" \"\n", "value", ["stiffbench.toml:2:9: place", "not empty"]),
    ];
    for (text, code, words) in cases {
        desk.write("stiffbench.toml", text);
        let code = format!("stiffbench::config::{code}");
        let error = desk.refusal("robot show", 10, &code);
        assert_output_contains(&error, &words);
        // What shows or explains goes on working, and doctor states it.
        desk.run("explain config::value").succeeds();
        desk.run("robot show --no-config").succeeds();
        let doctor = desk.data("doctor");
        assert_eq!(doctor["failed"], 1, "{doctor}");
        desk.run("doctor --strict").exits_with(1);
    }
    let ran = run(
        &desk,
        "",
        &[("STIFFBENCH_CONFIG", "none.toml")],
        "robot show",
    );
    ran.exits_with(10).stderr.must_contain(&["none.toml"]);
}

#[test]
fn paths_are_shown_though_a_file_is_wrong() {
    let desk = desk();
    desk.write("stiffbench.toml", "robott = \"a\"\n");
    let ran = desk.run("config path").succeeds();
    ran.stdout.must_contain(&["stiffbench.toml (exists)"]);
    ran.stderr.must_contain(&["no setting `robott`"]);
    let json = desk.run("config path --json").succeeds().json();
    assert_eq!(json["data"]["files"][0]["exists"], true);
    desk.refusal("config show", 10, "stiffbench::config::unknown_key");
    // Of a computer with its own settings the file counts least.
    let files = json["data"]["files"].list();
    let last = if cfg!(unix) { "system" } else { "user" };
    assert_eq!(files.last().unwrap()["layer"], last);
}

#[test]
fn a_variable_that_sets_nothing_is_noted_with_the_nearest() {
    let desk = desk();
    let variables = [
        ("STIFFBENCH_ROBOTS", "a"),
        ("STIFFBENCH_BENCH_TEMPERATURE", "b"),
    ];
    for command in ["robot show", "config show", "fit nowhere"] {
        let stderr = run(&desk, "", &variables, command).stderr;
        stderr.must_contain(&[
            "note: STIFFBENCH_ROBOTS sets nothing; did you mean STIFFBENCH_ROBOT?",
            "STIFFBENCH_BENCH_TEMPERATURE sets nothing; stiffbench config show",
        ]);
    }
    for quiet in ["robot show --quiet", "robot show --no-config"] {
        let stderr = run(&desk, "", &variables, quiet).succeeds().stderr;
        assert_eq!(stderr, "");
    }
    let doctor = run(&desk, "", &variables, "doctor").succeeds().stdout;
    let warns = |line: &str| line.contains("| warning") && line.contains("| variable");
    assert!(doctor.lines().any(warns), "{doctor}");
}

#[test]
fn the_schema_of_files_names_every_setting() {
    let desk = desk();
    let schema = desk.data("config show --schema");
    let settings = desk.data("config show");
    for setting in settings["settings"].list() {
        let property = &schema["properties"][setting["name"].word()];
        assert!(property["description"].is_string(), "{setting}");
    }
    assert_eq!(schema["additionalProperties"], false);
}
