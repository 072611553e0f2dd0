//! Any text as a URDF and as a Denavit-Hartenberg table: no panic, and what is imported is a robot file or is refused.
use stiffbench::analysis::{DhSettings, UrdfSettings, robot_from_dh, robot_from_urdf};
use stiffbench::robot::Robot;
use stiffbench::source_text::SourceText;

/// Tries some bytes; those that are no text are left out.
pub(crate) fn run(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    let file = |name: &str| SourceText::new(name, text);
    let settings = DhSettings::default();
    let made = [
        robot_from_urdf(&file("fuzz.urdf"), &UrdfSettings::default()),
        robot_from_dh(&file("fuzz.csv"), &settings),
        robot_from_dh(&file("fuzz.toml"), &settings),
    ];
    for robot in made.into_iter().flatten() {
        let _ = Robot::parse(&SourceText::new("made.toml", robot.text));
    }
}
