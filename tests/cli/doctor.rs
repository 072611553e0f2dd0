//! The checks before a session: each has a name, a state and, where it is not well, a remedy.

use stiffbench_test_files::desk::Ran;

use super::desk;

#[test]
fn every_check_has_a_state_and_those_that_are_not_well_a_remedy() {
    let desk = desk();
    let data = desk.data("doctor");
    let checks = data["checks"].as_array().unwrap();
    let names: Vec<&str> = checks
        .iter()
        .map(|check| check["name"].as_str().unwrap())
        .collect();
    for name in [
        "version",
        "clock",
        "configuration",
        "bindings",
        "locale",
        "terminal",
        "disk",
    ] {
        assert!(names.contains(&name), "{names:?}");
    }
    for check in checks {
        assert_eq!(check["state"] == "ok", check["remedy"].is_null(), "{check}");
    }
    let text = desk.run("doctor").succeeds().stdout;
    assert_eq!(
        text.matches("-> ").count(),
        checks.iter().filter(|check| check["state"] != "ok").count()
    );
    // It leaves nothing behind.
    assert_eq!(std::fs::read_dir(desk.folder.path()).unwrap().count(), 0);
}

/// Whether a line of a text has all these words.
pub(super) fn has(text: &str, words: &[&str]) -> bool {
    let mut lines = text.lines();
    lines.any(|line| words.iter().all(|word| line.contains(word)))
}

#[test]
fn a_locale_without_utf_8_is_a_warning_and_broken_bindings_fail() {
    let desk = desk();
    let mut command = desk.command("doctor");
    command.env("LC_ALL", "C");
    let text = Ran::of(&mut command).succeeds().stdout;
    assert!(has(&text, &["| warning", "| locale"]), "{text}");
    let mut command = desk.command("doctor");
    command.env("LC_ALL", "de_DE.UTF-8");
    let text = Ran::of(&mut command).succeeds().stdout;
    assert!(has(&text, &["| ok", "| locale", "| de_DE.UTF-8"]), "{text}");
    desk.write("stiffbench-bench.toml", "schema = \"other\"\n");
    let text = desk.run("doctor --strict").exits_with(1).stdout;
    assert!(
        has(&text, &["| FAILED", "| bindings"]) && text.contains("ports --wait"),
        "{text}"
    );
}
