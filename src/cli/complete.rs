//! `stiffbench __complete`: what the scripts of shells offer behind an option.

use clap::ValueEnum;

use crate::instrument::port::list_ports;
use crate::report::CompletedWords;
use crate::shipped::{shipped_instruments, shipped_procedures, shipped_robots};

use super::{Failure, Outcome};

/// What a shell may complete.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum CompletedWord {
    /// Serial ports that are there now
    Ports,
    /// Descriptions of gauges that are shipped
    Instruments,
    /// Procedures that are shipped
    Procedures,
    /// Robots that are shipped
    Robots,
}

/// What completes a word, one a line.
pub(super) fn run(of: CompletedWord) -> Result<Outcome, Failure> {
    let words: Vec<String> = match of {
        CompletedWord::Ports => list_ports()?.into_iter().map(|port| port.path).collect(),
        CompletedWord::Instruments => shipped_instruments()
            .iter()
            .map(|one| one.name.to_owned())
            .collect(),
        CompletedWord::Procedures => shipped_procedures().map(str::to_owned).collect(),
        CompletedWord::Robots => shipped_robots().map(str::to_owned).collect(),
    };
    let text = words.join("\n") + "\n";
    Ok(Outcome::new("complete", text, CompletedWords { words }))
}
