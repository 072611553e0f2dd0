//! What the program refuses: the code of the error, the exit code, and what it tells the user to do.

use super::{Ran, desk};
use crate::support::{Contains, Json};

/// A reader that has seen enough (`| head`) is no failure; a full disk is one.
#[cfg(target_os = "linux")]
#[test]
fn standard_output_that_takes_no_more() {
    use std::io::Read;
    use std::process::{Command, Stdio};

    let program = env!("CARGO_BIN_EXE_stiffbench");
    // More text than a pipe holds, so that the program writes into a pipe that nobody reads any more.
    let mut child = Command::new(program)
        .args(["completions", "bash"])
        // Of the tests: no setting of the program.
        .env_remove("STIFFBENCH_GOLDENS")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut first = [0; 10];
    let mut stdout = child.stdout.take().unwrap();
    stdout.read_exact(&mut first).unwrap();
    drop(stdout);
    let output = child.wait_with_output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert!(output.status.success());

    let full = std::fs::OpenOptions::new()
        .write(true)
        .open("/dev/full")
        .unwrap();
    let output = Command::new(program)
        .args(["robot", "show"])
        .stdout(full)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(14));
    String::from_utf8_lossy(&output.stderr).must_contain(&["standard output"]);
}

#[test]
fn a_robot_file_in_another_folder_is_found_from_anywhere() {
    let desk = desk();
    let robot = include_str!("../../data/robots/serial-arm.toml");
    desk.write(
        "robots/mine.toml",
        &robot.replacen("plain three-link serial arm", "my own arm", 1),
    );
    let robot = desk.path("robots/mine.toml");
    let robot = robot.display();
    let ran = desk.run(&format!("robot show {robot}")).succeeds();
    assert!(
        ran.stdout.starts_with("Robot: my own arm ("),
        "{}",
        ran.stdout
    );
    desk.run(&format!("simulate deep/er/session --robot {robot}"))
        .succeeds();
    // The session keeps its own copy, and is read with it from any other folder.
    let mut elsewhere = desk.command("fit ../session --json");
    std::fs::create_dir(desk.path("deep/er/elsewhere")).unwrap();
    let fit = Ran::of(elsewhere.current_dir(desk.path("deep/er/elsewhere")))
        .succeeds()
        .json();
    assert_eq!(fit["data"]["mechanism"], "A");
    assert_eq!(fit["data"]["cells"].list().len(), 12);
    // A robot that was changed after the session is used only if it is named, and that is said.
    let changed = desk.read("deep/er/session/robot.toml") + "\n# changed\n";
    desk.write("deep/er/session/robot.toml", &changed);
    desk.refusal("fit deep/er/session", 10, "stiffbench::robot::other_file");
    let named = "fit deep/er/session --robot deep/er/session/robot.toml";
    let ran = desk.run(named).succeeds();
    ran.stderr.must_contain(&["SHA-256 differs"]);
}
