//! Robot files to begin with.

/// Names and texts; dimensions in them are invented.
pub const TEMPLATES: [(&str, &str); 5] = [
    (
        "serial",
        include_str!("../../../data/templates/serial.toml"),
    ),
    ("scara", include_str!("../../../data/robots/scara.toml")),
    (
        "four-bar",
        include_str!("../../../data/robots/four-bar.toml"),
    ),
    (
        "parallelogram",
        include_str!("../../../data/templates/parallelogram.toml"),
    ),
    ("gantry", include_str!("../../../data/robots/gantry.toml")),
];

/// The text of a template.
#[must_use]
pub fn template(name: &str) -> Option<&'static str> {
    let found = TEMPLATES.iter().find(|(known, _)| *known == name);
    found.map(|(_, text)| *text)
}
