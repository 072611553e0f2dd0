//! Every exit code of the table, provoked: by a command that ends with it for its reason.

use std::collections::BTreeSet;

use stiffbench::cli::failure::EXIT_CODE_MEANINGS;

use super::{Desk, Ran, desk, five_columns};
use crate::support::Json;

/// Exit codes that are provoked in a test of their own: they need a port, a signal or a lack of rights.
const ELSEWHERE: [u8; 5] = [21, 22, 23, 70, 130];

/// A desk with what the commands of [`CASES`] need.
fn prepared() -> Desk {
    let desk = desk();
    let readings = five_columns(&["P1", "P2"], 5);
    desk.write("readings.csv", &readings);
    desk.write(
        "outlier.csv",
        &readings.replacen("P1,x,3,-40,-3997\n", "P1,x,3,-40,-3497\n", 1),
    );
    desk.write("one.csv", &five_columns(&["P1"], 2));
    desk.write("two.csv", "Kraft;Weg\n0;0\n1;2\n2;4\n3;6\n");
    desk.write("bad/stiffbench.toml", "robott = \"a\"\n");
    desk.write("overdue/readings.csv", &readings);
    desk.write(
        "overdue/session.toml",
        "schema = \"stiffbench/session/1\"\n[instruments.force]\nmodel = \"spring\"\nresolution_N = 0.1\ncalibrated = 2001-01-01\ndue = 2002-01-01\n",
    );
    desk.write("file", "");
    desk.write("nothing/journal.jsonl", "no line of a journal\n");
    desk.write(
        "nothing/session.toml",
        "schema = \"stiffbench/session/1\"\n",
    );
    desk.run("simulate session --seed 4 --poses P1 --directions x")
        .succeeds();
    desk.run("report session --no-diagnosis --out page.html")
        .succeeds();
    let page = desk.read("page.html");
    desk.write("changed.html", &page.replacen("N/µm", "N/mm", 1));
    desk
}

/// Exit code, and the command that ends with it.
const CASES: &[(u8, &str)] = &[
    (0, "stiffness readings.csv"),
    (1, "stiffness outlier.csv --strict"),
    (2, "stiffness"),
    (2, "fit readings.csv"),
    (3, "import two.csv --out two --no-input"),
    (10, "session plan --robot file"),
    (10, "simulate s --repeats 0"),
    (11, "stiffness nowhere"),
    (11, "stiffness file"),
    (12, "stiffness overdue --strict"),
    (13, "simulate session --seed 4"),
    (14, "robot compliance --figures file"),
    (20, "gauge read mark10-series5 --port nowhere"),
    (30, "report verify changed.html"),
    (31, "session verify nothing"),
    (40, "fit one.csv --robot hp-robot"),
    (41, "fit paper-experiment --train P1,P3 --strict"),
];

#[test]
fn every_exit_code_is_provoked() {
    let desk = prepared();
    for (code, arguments) in CASES {
        let text = desk.run(arguments);
        assert_eq!(text.code, i32::from(*code), "{arguments}: {}", text.stderr);
        if *code == 13 || *code == 20 || *code > 1 && *code < 30 {
            let error = desk.run(&format!("{arguments} --json")).json()["error"].take();
            assert_eq!(error["exit_code"], *code, "{arguments}: {error}");
        }
    }
    let tested = CASES.iter().map(|(code, _)| *code).chain(ELSEWHERE);
    let tested: BTreeSet<u8> = tested.collect();
    let known: BTreeSet<u8> = EXIT_CODE_MEANINGS.iter().map(|(code, _)| *code).collect();
    assert_eq!(tested, known);
}

#[test]
fn the_page_of_commands_has_the_table() {
    let page = include_str!("../../docs/commands.md");
    for (code, means) in EXIT_CODE_MEANINGS {
        assert!(
            page.contains(&format!("| {code} | {means}")),
            "{code} {means}"
        );
    }
}

/// Whatever is wrong with a configuration file, it is the configuration.
#[test]
fn a_configuration_that_cannot_be_used_exits_with_10() {
    let desk = desk();
    for bytes in [
        &b"robott = 1\n"[..],
        b"operator = \n",
        b"operator = \"M\xfcller\"\n",
        b"progress = \"loud\"\n",
    ] {
        std::fs::write(desk.path("stiffbench.toml"), bytes).unwrap();
        let error = desk.run("robot show --json").exits_with(10).json();
        let code = error["error"]["code"].word();
        assert!(code.starts_with("stiffbench::config::"), "{code}");
        assert!(error["error"]["help"].is_string(), "{error}");
    }
    std::fs::remove_file(desk.path("stiffbench.toml")).unwrap();
    let mut command = desk.command("robot show");
    command.env("STIFFBENCH_CONFIG", "none.toml");
    Ran::of(&mut command).exits_with(10);
}

#[cfg(unix)]
mod with_ports_and_signals {
    use std::process::{Child, Command, Stdio};
    use std::time::{Duration, Instant};

    use super::super::session::EMULATED;
    use super::{Desk, desk};
    use crate::support::Contains;

    /// A command in the background.
    fn begun(desk: &Desk, arguments: &str) -> Child {
        Command::new(env!("CARGO_BIN_EXE_stiffbench"))
            .current_dir(&desk.folder)
            .args(arguments.split_whitespace())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap()
    }

    fn wait_until(what: &str, is_so: impl Fn() -> bool) {
        let began = Instant::now();
        while !is_so() {
            assert!(began.elapsed() < Duration::from_secs(60), "{what}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    #[test]
    fn a_session_in_use_exits_with_21_and_an_interrupted_one_with_130() {
        let desk = desk();
        let mut session = begun(
            &desk,
            "session run s --emulated --speed 1 --no-input --procedure sweeps --poses P1",
        );
        wait_until("the journal", || desk.path("s/session.lock").exists());
        wait_until("a reading", || {
            let journal = std::fs::read_to_string(desk.path("s/journal.jsonl"));
            journal.is_ok_and(|journal| journal.contains("\"kind\":\"reading\""))
        });
        let resume = format!("session resume s {EMULATED}");
        desk.refusal(&resume, 21, "stiffbench::session::in_use");
        let id = session.id().to_string();
        let killed = Command::new("kill").args(["-INT", &id]).status().unwrap();
        assert!(killed.success());
        assert_eq!(session.wait().unwrap().code(), Some(130));
        assert_eq!(desk.data("session verify s")["whole"], true);
    }

    /// The gauge is another process: nothing of this one keeps its port open.
    #[test]
    fn a_gauge_that_is_pulled_out_exits_with_22() {
        let desk = desk();
        let mut gauge = begun(
            &desk,
            "gauge emulate --link ports --stay --force-instrument mark10-series5 --poses P1 --directions x --loads-n 0,-10 --repeats 1",
        );
        wait_until("the port", || desk.path("ports/force").exists());
        let mut reading = begun(
            &desk,
            "gauge record mark10-series5 --port ports/force --out a.trace",
        );
        wait_until("bytes", || {
            std::fs::metadata(desk.path("a.trace")).is_ok_and(|file| file.len() > 1000)
        });
        gauge.kill().unwrap();
        gauge.wait().unwrap();
        assert_eq!(reading.wait().unwrap().code(), Some(22));
    }

    /// Pseudo-terminals that cannot be made are no mistake of the user. What other tests have open at the moment is closed first.
    #[test]
    fn an_emulation_without_pseudo_terminals_exits_with_70() {
        let desk = desk();
        let program = env!("CARGO_BIN_EXE_stiffbench");
        let script = format!(
            "exec 3>&- 4>&-; ulimit -n 5; exec {program} gauge emulate --poses P1 --directions x --json"
        );
        let output = Command::new("sh")
            .args(["-c", &script])
            .current_dir(&desk.folder)
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&output.stdout);
        assert_eq!(output.status.code(), Some(70), "{text}");
        text.must_contain(&["stiffbench::emulator::"]);
    }
}
