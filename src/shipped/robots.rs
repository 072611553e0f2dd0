//! The robots that come with the program.

use crate::source_text::SourceText;

/// Shipped robots: name and text. The first is the default.
const SHIPPED: [(&str, &str); 8] = [
    ("hp-robot", include_str!("../../data/robots/hp-robot.toml")),
    (
        "hp-robot-host-dominant",
        include_str!("../../data/robots/hp-robot-host-dominant.toml"),
    ),
    (
        "serial-arm",
        include_str!("../../data/robots/serial-arm.toml"),
    ),
    ("scara", include_str!("../../data/robots/scara.toml")),
    ("four-bar", include_str!("../../data/robots/four-bar.toml")),
    ("gantry", include_str!("../../data/robots/gantry.toml")),
    (
        "fanuc-r2000ic",
        include_str!("../../data/robots/fanuc-r2000ic.toml"),
    ),
    (
        "franka-panda",
        include_str!("../../data/robots/franka-panda.toml"),
    ),
];

/// Names of the shipped robots, the default first.
pub fn shipped_robots() -> impl Iterator<Item = &'static str> {
    SHIPPED.iter().map(|(name, _)| *name)
}

/// Text of a shipped robot.
#[must_use]
pub fn shipped_robot(name: &str) -> Option<SourceText> {
    SHIPPED
        .iter()
        .find(|(shipped, _)| *shipped == name)
        .map(|(name, text)| SourceText::new(*name, *text))
}
