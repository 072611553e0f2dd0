//! A recorded session is replayed through decoder and session logic, and gives its readings again.

use super::desk;
use super::session::{EMULATED, SHORT};

#[cfg(unix)]
#[test]
fn a_recorded_session_gives_its_readings_again() {
    let desk = desk();
    desk.run(&format!(
        "session run s {SHORT} {EMULATED} --answer temperature=21 --answer humidity=40"
    ))
    .succeeds();
    let replayed = desk.data("session replay s --out t");
    assert_eq!(
        (&replayed["recorded"], &replayed["replayed"]),
        (&4.into(), &4.into())
    );
    assert!(
        replayed["largest_difference_N"].as_f64().unwrap() <= 0.2,
        "{replayed}"
    );
    assert!(
        replayed["largest_difference_um"].as_f64().unwrap() <= 3.0,
        "{replayed}"
    );
    let status = desk.data("session status t");
    assert_eq!(status["outcome"], "complete");
    assert_eq!(desk.data("session verify t")["whole"], true);
    assert!(desk.read("t/session.toml").contains("replay of s-"));
    let log = desk.run("session log t").succeeds().stdout;
    assert!(
        log.contains("21 degC, 40 % relative humidity at the start"),
        "{log}"
    );
    // At a pace, the same: as a function of the traces alone.
    let paced = desk.data("session replay s --out u --speed 50");
    assert_eq!(
        paced["largest_difference_um"],
        replayed["largest_difference_um"]
    );
    assert_eq!(desk.read("u/readings.csv").lines().count(), 5);
    // Without traces there is nothing to replay.
    std::fs::remove_dir_all(desk.path("s/raw")).unwrap();
    assert_ne!(desk.run("session replay s --out v").code, 0);
}
