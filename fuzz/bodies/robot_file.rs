//! Any text as a robot file: no panic, and what is read can be placed, weighed and solved, or refused.
use stiffbench::analysis::check_robot;
use stiffbench::robot::Robot;
use stiffbench::source_text::SourceText;

/// Tries some bytes; those that are no text are left out.
pub(crate) fn run(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    let source = SourceText::new("fuzz.toml", text);
    if let Ok(robot) = Robot::parse(&source) {
        // A robot that cannot be solved is refused; what matters is that nothing panics or hangs.
        let _ = check_robot(&robot, &source);
    }
}
