//! Ids are checked against the procedure before anything is made, and a typo is answered with what was meant.

use super::desk;
use super::session::SHORT;

#[test]
fn a_mistyped_specimen_pose_direction_or_question_is_answered_with_the_nearest() {
    let desk = desk();
    desk.write(
        "mine.toml",
        "schema = \"stiffbench/procedure/1\"\nspecimens = [\"arm-A\", \"arm-B\"]\nposes = [\"P1\"]\ndirections = [\"x\"]\nloads_N = [0, -30]\nrepeats = 1\n",
    );
    let asked = "schema = \"stiffbench/procedure/1\"\n[answer_within]\nsetp_s = 20\n";
    desk.write("asked.toml", asked);
    for (arguments, meant) in [
        ("--procedure mine.toml --specimen-id arm-a", "arm-A"),
        ("--procedure mine.toml", "arm-A, arm-B"),
        ("--procedure sweeps --poses PP1", "P1"),
        ("--procedure sweeps --directions vertcal", "`y`"),
        ("--procedure asked.toml", "did you mean setup?"),
    ] {
        let refused = desk.run(&format!("session run s {arguments}"));
        assert_ne!(refused.code, 0, "{arguments}");
        assert!(
            refused.stderr.contains(meant),
            "{arguments}: {}",
            refused.stderr
        );
        assert!(!desk.path("s").exists());
    }
}

#[cfg(unix)]
#[test]
fn the_specimen_stands_in_the_record() {
    let desk = desk();
    desk.run(&format!(
        "session run s {SHORT} --emulated --speed 50 --no-input --specimen-id arm-7"
    ))
    .succeeds();
    assert!(desk.read("s/session.toml").contains("specimen = \"arm-7\""));
}
