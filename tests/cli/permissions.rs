//! What a user may not touch: the program run by somebody who owns nothing.

use std::fs::{Permissions, metadata, read_dir, set_permissions};
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::Command;

use super::lines::mark10;
use super::session::{EMULATED, SHORT};
use super::{Desk, Ran, desk};
use crate::support::{Contains, Json};

/// The user `nobody`, who is in no group.
const NOBODY: u32 = 65_534;

/// Runs the program without rights: as root it is handed to somebody else, other users have no more rights than these modes give them.
fn run_without_rights(desk: &Desk, arguments: &str) -> Ran {
    // Copied, as not everybody may look into the folder it was built in.
    let program = desk.path("stiffbench");
    if !program.exists() {
        desk.install(env!("CARGO_BIN_EXE_stiffbench"), "stiffbench");
    }
    let mut command = Command::new(&program);
    command.current_dir(&desk.folder);
    command.args(arguments.split_whitespace());
    if metadata(&program).unwrap().uid() == 0 {
        command.uid(NOBODY).gid(NOBODY);
    }
    Ran::of(&mut assert_cmd::Command::from_std(command))
}

fn allow(path: &Path, mode: u32) {
    set_permissions(path, Permissions::from_mode(mode)).unwrap();
}

#[test]
fn a_port_that_this_user_may_not_open_is_neither_absent_nor_busy() {
    let desk = desk();
    let _gauge = mark10(&desk);
    allow(&desk.path("gauge"), 0o000);
    allow(desk.folder.path(), 0o755);
    let read = "gauge read mark10-series5 --port gauge --json";
    let error = &run_without_rights(&desk, read).exits_with(23).json()["error"];
    assert_eq!(error["code"], "stiffbench::port::not_allowed", "{error}");
    let help = error["help"].word();
    help.must_contain(&["(mode 000): a udev rule"]);
}

#[test]
fn a_folder_that_this_user_may_only_read_gets_no_session_and_loses_none() {
    let desk = desk();
    allow(desk.folder.path(), 0o555);
    let command = format!("session run s {SHORT} {EMULATED} --json");
    let error = &run_without_rights_in_read_only(&desk, &command)["error"];
    error["message"].word().must_contain(&["denied"]);

    allow(desk.folder.path(), 0o755);
    desk.run(&format!("session run s {SHORT} {EMULATED}"))
        .succeeds();
    let session = desk.path("s");
    let journal = desk.read("s/journal.jsonl");
    for entry in read_dir(&session).unwrap() {
        let path = entry.unwrap().path();
        allow(&path, if path.is_dir() { 0o555 } else { 0o444 });
    }
    allow(&session, 0o555);
    // What only reads works; what writes states where it may not.
    run_without_rights(&desk, "session status s").succeeds();
    run_without_rights(&desk, "session verify s").succeeds();
    let resume = format!("session resume s {EMULATED} --json");
    let error = &run_without_rights_in_read_only(&desk, &resume)["error"];
    error["message"].word().must_contain(&["denied"]);
    allow(&session, 0o755);
    assert_eq!(desk.read("s/journal.jsonl"), journal);
}

/// The output of a run that has to fail.
fn run_without_rights_in_read_only(desk: &Desk, arguments: &str) -> serde_json::Value {
    let ran = run_without_rights(desk, arguments);
    assert_ne!(ran.code, 0, "{}{}", ran.stdout, ran.stderr);
    assert!(!ran.stderr.contains("panicked"), "{}", ran.stderr);
    ran.json()
}
