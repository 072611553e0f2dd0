//! Logs of gauges, line by line as the gauge sends them, as a table that `import` reads.

use std::fmt::Write as _;

use clap::Args;
use miette::Diagnostic;

use crate::analysis::ArgumentError;
use crate::instrument::{Decoded, Decoder, InstrumentDescription, Rejected, Sample};
use crate::quantity::Kind;

use super::descriptions::{ProtocolsArgs, find_description};
use super::{reply_reason, require_permission};
use crate::cli::failure::Failure;
use crate::count::counted;

/// By which descriptions the lines of logs are decoded.
#[derive(Debug, Args)]
pub(in crate::cli) struct GaugeLineArgs {
    /// Decode FILE, lines of this gauge with a time before each: name of an instrument description, or a file
    #[arg(long, value_name = "NAME|FILE")]
    instrument: Option<String>,
    /// Decode the log of --displacement-log: description of the displacement gauge
    #[arg(long, value_name = "NAME|FILE", requires = "displacement_log")]
    displacement_instrument: Option<String>,
    /// Use an unverified description
    #[arg(long)]
    allow_unverified: bool,
    /// More descriptions.
    #[command(flatten)]
    protocols: ProtocolsArgs,
}

impl GaugeLineArgs {
    /// The descriptions that are named, with their options.
    pub(in crate::cli) fn named(&self) -> [(&'static str, &Option<String>); 2] {
        [
            ("instrument", &self.instrument),
            ("displacement-instrument", &self.displacement_instrument),
        ]
    }

    /// The description that an option names for a log of this quantity.
    pub(in crate::cli) fn description(
        &self,
        kind: Kind,
    ) -> Result<Option<InstrumentDescription>, Failure> {
        let (option, name) = match kind {
            Kind::Force => ("--instrument", &self.instrument),
            _ => ("--displacement-instrument", &self.displacement_instrument),
        };
        let Some(name) = name else { return Ok(None) };
        let description = find_description(name, &self.protocols)?.description;
        require_permission(&description, self.allow_unverified)?;
        if description.channel.kind() != kind {
            return ArgumentError::refuse(
                format!("{option} {name}"),
                format!("this gauge measures {}", description.channel),
                "FILE is the log of the force gauge with --instrument; that of the other belongs to --displacement-log with --displacement-instrument",
            );
        }
        Ok(Some(description))
    }
}

/// No line of a log is a value of the gauge.
#[derive(Debug, thiserror::Error, Diagnostic)]
#[error("{file}, line {line}: no line is a value of {instrument}; here: {reason}")]
#[diagnostic(
    code(stiffbench::import::no_packets),
    help(
        "compare the line with `stiffbench gauge show {instrument}`, or name another description"
    )
)]
struct NoPackets {
    file: String,
    line: usize,
    instrument: String,
    reason: String,
}

/// A log as a table: each line with a value is a row of it, and stays in its line.
pub(in crate::cli) struct GaugeTable {
    /// The table.
    pub(in crate::cli) bytes: Vec<u8>,
    /// What a user should know of lines without a value.
    pub(in crate::cli) note: Option<String>,
}

/// Decodes a log.
///
/// # Arguments
/// - `unit`: the unit of packets that carry none.
///
/// # Errors
/// For a unit that the gauge cannot have, and a log without any value.
pub(in crate::cli) fn table_of(
    file: &str,
    bytes: &[u8],
    description: &InstrumentDescription,
    unit: Option<&str>,
) -> Result<GaugeTable, Failure> {
    let decoder = Decoder::new(description, unit)?;
    let end = if bytes.contains(&b'\n') { b'\n' } else { b'\r' };
    let mut text = String::new();
    let mut has_time = None;
    let mut left_out: Option<(usize, usize, String)> = None;
    for (index, line) in bytes.split(|byte| *byte == end).enumerate() {
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        let read = decoded_line(&decoder, line);
        let read = read.and_then(|(time, samples)| {
            let has = time.is_some();
            if *has_time.get_or_insert(has) == has {
                Ok((time, samples))
            } else {
                Err("other lines differ in that they have a time, or have none".to_owned())
            }
        });
        match read {
            Ok((time, samples)) => text.push_str(&row(time, &samples)),
            Err(_) if line.trim_ascii().is_empty() => {}
            Err(reason) => {
                text.push('#');
                left_out.get_or_insert((0, index + 1, reason)).0 += 1;
            }
        }
        text.push('\n');
    }
    let file = file.to_owned();
    let instrument = description.name.clone();
    if has_time.is_none() {
        let (_, line, reason) = left_out.unwrap_or((0, 1, "the file is empty".to_owned()));
        let none = NoPackets {
            file,
            line,
            instrument,
            reason,
        };
        return Err(none.into());
    }
    let note = left_out.map(|(count, line, reason)| {
        format!(
            "{file}: left out as no value of {instrument}: {}, the first is line {line}: {reason}",
            counted(count, "line")
        )
    });
    Ok(GaugeTable {
        bytes: text.into_bytes(),
        note,
    })
}

/// A row: the time, then each value with its unit and the digits that were sent.
fn row(time: Option<&str>, samples: &[Sample]) -> String {
    let mut row = time.map_or_else(String::new, |time| match number(time) {
        Some(seconds) => format!("{seconds} s"),
        None => time.to_owned(),
    });
    for sample in samples {
        let step = sample.resolution_si / sample.kind.si_factor(&sample.unit).unwrap_or(1.0);
        let decimals = (-step.log10() - 1e-9).ceil().clamp(0.0, 15.0) as usize;
        let delimiter = if row.is_empty() { "" } else { ";" };
        // Writing to a String does not fail.
        let _ = write!(
            row,
            "{delimiter}{:.decimals$} {}",
            sample.value, sample.unit
        );
    }
    row
}

/// The time before the packet of a line, and its values; else why it has none.
///
/// The packet is all of the line, or all behind a time: the description must cover it completely.
fn decoded_line<'l>(
    decoder: &Decoder,
    line: &'l [u8],
) -> Result<(Option<&'l str>, Vec<Sample>), String> {
    let behind = line.iter().enumerate().filter_map(|(place, byte)| {
        let before = std::str::from_utf8(&line[..place]).ok()?;
        let time = before.trim_matches([' ', '\t', '[', ']', ';', ',']);
        let is_end = matches!(byte, b' ' | b'\t' | b';' | b',' | b']');
        (is_end && is_time(time)).then_some((Some(time), &line[place + 1..]))
    });
    let mut why = String::new();
    for (time, packet) in [(None, line)].into_iter().chain(behind) {
        match values(decoder, packet) {
            Ok(samples) => return Ok((time, samples)),
            Err(reason) => why = reason,
        }
    }
    Err(why)
}

/// The values of a packet, with whichever end its gauge sends.
fn values(decoder: &Decoder, packet: &[u8]) -> Result<Vec<Sample>, String> {
    let mut why = None;
    for end in ["\r\n", "\r", "\n", ""] {
        let mut decoder = decoder.clone();
        let mut decoded = Vec::new();
        decoder.push(&[packet, end.as_bytes()].concat(), 0.0, &mut decoded);
        decoder.idle(0.0, &mut decoded);
        let samples = decoded.into_iter().map(|one| match one {
            Decoded::Sample(sample) => Ok(sample),
            Decoded::Rejected(Rejected { reason, .. }) => Err(reason.to_string()),
            Decoded::Reply(reply) => Err(reply_reason(&reply)),
        });
        match samples.collect::<Result<Vec<_>, _>>() {
            Ok(samples) if !samples.is_empty() => return Ok(samples),
            Ok(_) => {}
            Err(reason) => {
                why.get_or_insert(reason);
            }
        }
    }
    Err(why.unwrap_or_else(|| "no packet".to_owned()))
}

/// Whether a text is a number of seconds, a time of day, or a date with one.
fn is_time(text: &str) -> bool {
    let is = |part: &str, mark: char| {
        part.matches(mark).count() >= 1
            && part.starts_with(|c: char| c.is_ascii_digit())
            && part
                .chars()
                .all(|c| c.is_ascii_digit() || ":.,-/+Zz".contains(c))
    };
    let mut parts = text.split([' ', 'T', 't']).filter(|part| !part.is_empty());
    let parts: [Option<&str>; 4] = std::array::from_fn(|_| parts.next());
    match parts {
        [Some(one), None, ..] => is(one, ':') || number(one).is_some(),
        [Some(clock), Some("AM" | "PM"), None, _] => is(clock, ':'),
        [Some(date), Some(clock), None | Some("AM" | "PM"), None] => {
            ['-', '.', '/'].iter().any(|mark| is(date, *mark)) && is(clock, ':')
        }
        _ => false,
    }
}

/// A number of seconds with a decimal point.
fn number(text: &str) -> Option<String> {
    let text = text.replace(',', ".");
    let is_plain = text.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    (is_plain && text.parse::<f64>().is_ok()).then_some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_before_packets() {
        for text in [
            "10:00:00.250",
            "10:00:00,250",
            "2026-03-02T10:00:00Z",
            "02.03.2026 10:00:00",
            "3/2/2026 10:00:00 AM",
            "0.25",
            "1772445600",
        ] {
            assert!(is_time(text), "{text}");
        }
        for text in ["", "N", "2026-03-02", "10:00:00 12.5", "-1.5", "1.2.3"] {
            assert!(!is_time(text), "{text}");
        }
    }
}
