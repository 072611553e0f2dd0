//! The port of a gauge that nobody named: the one on which it answers.

use crate::analysis::ArgumentError;
use crate::cli::failure::Failure;
use crate::cli::gauge::ProtocolsArgs;
use crate::cli::gauge::descriptions::{all_descriptions, find_description};
use crate::cli::outcome::print_error;
use crate::count::counted;
use crate::instrument::Channel;
use crate::instrument::port::list_ports;
use crate::instrument::probe::{clear_match, probe};

/// A gauge that answered.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct AnsweringGauge {
    /// Name of its description.
    pub(super) instrument: String,
    /// Its port.
    pub(super) path: String,
    /// The speed at which it answers, where that is not that of its description.
    pub(super) other_baud: Option<u32>,
    /// What it sent.
    evidence: String,
}

impl AnsweringGauge {
    /// What a user should know.
    pub(super) fn note(&self, channel: Channel) -> String {
        format!(
            "no port is named for the {channel} gauge: {} answers on {} ({}) and is used",
            self.instrument, self.path, self.evidence
        )
    }
}

/// Asks the ports that no other gauge has; `None` where no gauge answers clearly.
///
/// # Arguments
/// - `name`: the description, where it is known; else every one of this kind is tried.
/// - `taken`: ports of the other gauges.
pub(super) fn who_answers(
    channel: Channel,
    name: Option<&str>,
    protocols: &ProtocolsArgs,
    taken: &[String],
) -> Result<Option<AnsweringGauge>, Failure> {
    let is_free = |path: &str| !taken.iter().any(|taken| taken == path);
    let mut ports = list_ports().unwrap_or_default();
    ports.retain(|port| {
        let is_taken = taken.iter().any(|taken| port.answers_to(taken));
        !is_taken && is_free(port.stable_path())
    });
    if ports.is_empty() {
        return Ok(None);
    }
    let found = match name {
        Some(name) => vec![find_description(name, protocols)?],
        None => all_descriptions(protocols)?.0,
    };
    let descriptions: Vec<_> = found
        .into_iter()
        .map(|found| found.description)
        .filter(|description| description.channel.kind() == channel.kind())
        .collect();
    print_error(&format!(
        "note: no port is named for the {channel} gauge: asking {} for a value",
        counted(ports.len(), "port")
    ));
    let mut answering = Vec::new();
    for port in &ports {
        let mut note = |text: String| print_error(&format!("note: {text}"));
        // A port that is busy or forbidden has no gauge for this session.
        let Ok(findings) = probe(port.stable_path(), &descriptions, &mut note) else {
            continue;
        };
        answering.extend(clear_match(&findings).map(|found| AnsweringGauge {
            instrument: found.instrument.clone(),
            path: port.stable_path().to_owned(),
            other_baud: found.other_baud,
            evidence: found.evidence.clone(),
        }));
    }
    Ok(only_one(channel, answering)?)
}

/// The one gauge that answered; several are refused.
fn only_one(
    channel: Channel,
    mut answering: Vec<AnsweringGauge>,
) -> Result<Option<AnsweringGauge>, ArgumentError> {
    if answering.len() < 2 {
        return Ok(answering.pop());
    }
    let all = answering.iter();
    let all: Vec<String> = all
        .map(|found| format!("{} on {}", found.instrument, found.path))
        .collect();
    let option = if channel == Channel::Force {
        "force"
    } else {
        "displacement"
    };
    Err(ArgumentError::new(
        format!("--{option} port=PORT"),
        format!("more than one {channel} gauge answers: {}", all.join(", ")),
        "name the port that is meant, or bind the gauge once with stiffbench gauge bind",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_gauge_that_answers_is_used_and_named_and_several_are_refused() {
        let gauge = |path: &str| AnsweringGauge {
            instrument: "mark10-series5".to_owned(),
            path: path.to_owned(),
            other_baud: None,
            evidence: "-0.02 N".to_owned(),
        };
        let (one, other) = (gauge("/dev/ttyUSB0"), gauge("/dev/ttyUSB1"));
        assert_eq!(only_one(Channel::Force, Vec::new()).ok(), Some(None));
        let found = only_one(Channel::Force, vec![one.clone()]).ok().flatten();
        let note = found.map(|found| found.note(Channel::Force));
        let note = note.unwrap_or_default();
        assert!(
            note.contains("mark10-series5 answers on /dev/ttyUSB0 (-0.02 N)"),
            "{note}"
        );
        let error = only_one(Channel::Force, vec![one, other]);
        let text = error.map_or_else(|error| error.to_string(), |_| String::new());
        assert!(
            text.contains("/dev/ttyUSB0") && text.contains("/dev/ttyUSB1"),
            "{text}"
        );
    }
}
