//! The checks before a session: each has a name, a state and, where it is not well, a remedy.

use super::desk;
use crate::support::Json;

#[test]
fn every_check_has_a_state_and_those_that_are_not_well_a_remedy() {
    let desk = desk();
    let data = desk.data("doctor");
    let checks = data["checks"].list();
    let names: Vec<&str> = checks.iter().map(|check| check["name"].word()).collect();
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
