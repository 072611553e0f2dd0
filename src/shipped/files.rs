//! The robots, procedures and instrument descriptions that come with the program.

use crate::source_text::SourceText;

/// A file that comes with the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShippedText {
    /// Its name.
    pub name: &'static str,
    /// Its text.
    pub text: &'static str,
}

macro_rules! shipped {
    ($folder:literal: $($name:literal),* $(,)?) => {
        &[$(ShippedText {
            name: $name,
            text: include_str!(concat!("../../", $folder, "/", $name, ".toml")),
        }),*]
    };
}

/// The first is the default.
const ROBOTS: &[ShippedText] = shipped![
    "data/robots":
    "hp-robot",
    "hp-robot-host-dominant",
    "serial-arm",
    "scara",
    "four-bar",
    "gantry",
    "fanuc-r2000ic",
    "franka-panda",
];

/// The shipped procedure that is followed where none is named.
pub const DEFAULT_PROCEDURE: &str = "sweeps";

const PROCEDURES: &[ShippedText] = shipped![
    "protocols/procedures":
    "paper",
    "sweeps",
    "load-unload",
    "load-hold-unload",
    "shuffled",
    "iso-9283-static-compliance",
];

/// In the order in which they are listed: force gauges, then displacement gauges, each with the best known first.
const INSTRUMENTS: &[ShippedText] = shipped![
    "protocols/instruments":
    "mark10-series5",
    "sauter-fh",
    "imada-ds2",
    "aikoh-rx",
    "imada-zts",
    "nidec-shimpo-fg7000",
    "lutron-fg",
    "hp-modbus",
    "generic-ascii",
    "mitutoyo-01a",
    "sylvac-opto-rs",
    "mahr-dk-u1",
    "cdi-logic",
    "heidenhain-nd28x",
    "magnescale-lt20a",
    "shahe-modbus",
    "generic-ascii-displacement",
];

fn source(files: &[ShippedText], name: &str) -> Option<SourceText> {
    let found = files.iter().find(|file| file.name == name)?;
    Some(SourceText::new(found.name, found.text))
}

/// Names of the shipped robots, the default first.
pub fn shipped_robots() -> impl Iterator<Item = &'static str> + Clone {
    ROBOTS.iter().map(|file| file.name)
}

/// Text of a shipped robot.
#[must_use]
pub fn shipped_robot(name: &str) -> Option<SourceText> {
    source(ROBOTS, name)
}

/// Names of the shipped procedures.
pub fn shipped_procedures() -> impl Iterator<Item = &'static str> + Clone {
    PROCEDURES.iter().map(|file| file.name)
}

/// Text of a shipped procedure.
#[must_use]
pub fn shipped_procedure(name: &str) -> Option<SourceText> {
    source(PROCEDURES, name)
}

/// The shipped instrument descriptions.
#[must_use]
pub fn shipped_instruments() -> &'static [ShippedText] {
    INSTRUMENTS
}
