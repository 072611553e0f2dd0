//! The example of `docs/robot-file-1.md`, which the tests of robot files change.

use stiffbench_beams::robot::Robot;
use stiffbench_units_and_text::source_text::SourceText;

pub(crate) fn text() -> &'static str {
    stiffbench_test_files::example("docs/robot-file-1.md", "toml")
}

/// The example with one piece of text replaced, which must be there.
pub(crate) fn with(find: &str, replacement: &str) -> String {
    assert!(text().contains(find), "the example has no {find}");
    text().replacen(find, replacement, 1)
}

/// The robot of the example with one piece of text replaced.
pub(crate) fn robot_with(find: &str, replacement: &str) -> Robot {
    Robot::parse(&SourceText::new("arm.toml", with(find, replacement))).unwrap()
}
