//! The examples run, and print what they should.

#[allow(dead_code, reason = "here `report` is called, not `main`")]
#[path = "../examples/decode_packet.rs"]
mod decode_packet;
#[allow(dead_code, reason = "here `report` is called, not `main`")]
#[path = "../examples/diagnose.rs"]
mod diagnose;
#[allow(dead_code, reason = "here `report` is called, not `main`")]
#[path = "../examples/fit.rs"]
mod fit;
#[allow(dead_code, reason = "here `report` is called, not `main`")]
#[path = "../examples/solve_pose.rs"]
mod solve_pose;
#[allow(dead_code, reason = "here `report` is called, not `main`")]
#[path = "../examples/stiffness_of_csv.rs"]
mod stiffness_of_csv;

#[test]
fn a_packet_is_decoded_and_a_damaged_one_rejected() {
    let text = decode_packet::report().unwrap();
    let expected = "4.285 N = 4.285000 N\n-12.5 lbf = -55.602770 N\nrejected: 4.2#5 N\n";
    assert_eq!(text, expected);
}

#[test]
fn a_pose_is_solved() {
    let text = solve_pose::report().unwrap();
    assert!(
        text.ends_with("in P1\nx: 0.0105 N/µm\ny: 0.0271 N/µm\nz: 0.2083 N/µm\n"),
        "{text}"
    );
}

#[test]
fn readings_become_stiffness() {
    let text = stiffness_of_csv::report().unwrap();
    assert!(text.starts_with("480 readings\nP1 x: 9.7"), "{text}");
}

#[test]
fn factors_are_fitted_and_tested() {
    let text = fit::report().unwrap();
    assert!(
        text.starts_with("beam.A: 0.0035, 95 % 0.0034 to 0.0036\n"),
        "{text}"
    );
    // Of the pose that was held out; its cells are known to some 0.3 %.
    let error = text.trim_end().strip_suffix(" %").unwrap();
    let error: f64 = error.rsplit(' ').next().unwrap().parse().unwrap();
    assert!(error < 1.0, "{text}");
}

#[test]
fn play_in_a_joint_is_found() {
    let text = diagnose::report().unwrap();
    assert!(
        text.starts_with("verdict: explained\njoint-backlash at joint A3: "),
        "{text}"
    );
}
