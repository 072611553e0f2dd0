//! Which instrument is on a port: by listening first, then by asking what can be asked without changing anything.

use std::io::{ErrorKind, Read, Write};
use std::time::Duration;

use schemars::JsonSchema;
use serde::Serialize;
use serialport::{ClearBuffer, SerialPort};

use stiffbench_units_and_text::clock::Clock;

use super::decode::{Decoded, Decoder, Meaning};
use super::description::{CommandEffect, CommandRole, InstrumentDescription, LineSettings};
use super::port::{OpenPort, PortError, PortSettings, PortTimeouts, open};

/// How long is listened before anything is sent, s: a gauge that sends by itself does so at least every second.
const LISTEN_S: f64 = 1.2;

/// How well a description fits.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "InstrumentMatch")]
pub struct ProbeFinding {
    /// Name of the description.
    pub instrument: String,
    // 3 for each value that a pattern covers, up to three; 2 for an answer to its identity; 1 less for each packet that no pattern covers, up to
    // three.
    /// Points for it.
    pub points: i32,
    /// What came, as text.
    pub evidence: String,
    // The reply to the identity request.
    /// Its content.
    pub identity: Option<String>,
    /// Speed, bit/s, where it is not the description's.
    pub other_baud: Option<u32>,
}

/// Tries descriptions on a port; those with any evidence, the best first.
///
/// For each setting of the line the port is opened and listened to. Only if nothing comes, each description's request for a value is sent, and
/// its question for identity if a value came; commands that set, step or toggle are never sent. It ends as soon as one identifies itself. Where
/// there is evidence for none, the other speeds that the descriptions name are tried in the same way.
///
/// # Errors
/// [`PortError`] if the port cannot be opened, or is lost.
pub fn probe(
    path: &str,
    descriptions: &[InstrumentDescription],
    note: &mut dyn FnMut(String),
) -> Result<Vec<ProbeFinding>, PortError> {
    let mut findings = try_speeds(path, descriptions, usual_speed, note)?;
    if findings.is_empty() {
        findings = try_speeds(path, descriptions, other_speeds, note)?;
    }
    findings.sort_by_key(|finding| -finding.points);
    Ok(findings)
}

fn usual_speed(line: &LineSettings) -> &[u32] {
    std::slice::from_ref(&line.baud)
}

fn other_speeds(line: &LineSettings) -> &[u32] {
    &line.alternatives
}

/// Settings of the line with the descriptions that they may belong to, each setting once.
fn attempts(
    descriptions: &[InstrumentDescription],
    speeds: fn(&LineSettings) -> &[u32],
) -> Vec<(PortSettings, Vec<&InstrumentDescription>)> {
    let mut attempts: Vec<(PortSettings, Vec<&InstrumentDescription>)> = Vec::new();
    for description in descriptions {
        for &baud in speeds(&description.line) {
            let settings = PortSettings::of(&description.line, &description.modem).with_baud(baud);
            match attempts.iter_mut().find(|(known, _)| *known == settings) {
                Some((_, alike)) => alike.push(description),
                None => attempts.push((settings, vec![description])),
            }
        }
    }
    attempts
}

/// Evidence for descriptions at some of their speeds.
fn try_speeds(
    path: &str,
    descriptions: &[InstrumentDescription],
    speeds: fn(&LineSettings) -> &[u32],
    note: &mut dyn FnMut(String),
) -> Result<Vec<ProbeFinding>, PortError> {
    let mut findings = Vec::new();
    for (settings, alike) in attempts(descriptions, speeds) {
        let opened = open(path, &settings, &PortTimeouts::without_waiting(), note)?;
        let mut found = Probe::new(opened).try_all(&alike)?;
        for finding in &mut found {
            let named = alike.iter().find(|one| one.name == finding.instrument);
            let is_other = named.is_some_and(|named| named.line.baud != settings.baud);
            finding.other_baud = is_other.then_some(settings.baud);
        }
        findings.extend(found);
        if is_settled(&findings) {
            break;
        }
    }
    Ok(findings)
}

/// The finding that stands out, if one does: the only best one, by at least two values.
#[must_use]
pub fn clear_match(findings: &[ProbeFinding]) -> Option<&ProbeFinding> {
    match findings {
        [best, second, ..] if best.points <= second.points => None,
        [best, ..] if best.points >= 3 => Some(best),
        _ => None,
    }
}

/// Whether one has identified itself: then nothing more is sent that is meant for others.
fn is_settled(findings: &[ProbeFinding]) -> bool {
    findings.iter().any(|finding| finding.identity.is_some())
}

struct Probe {
    open: OpenPort,
    clock: Clock,
}

impl Probe {
    fn new(open: OpenPort) -> Self {
        Self {
            open,
            clock: Clock::default(),
        }
    }

    fn try_all(
        &mut self,
        descriptions: &[&InstrumentDescription],
    ) -> Result<Vec<ProbeFinding>, PortError> {
        let heard = self.listen(LISTEN_S, LISTEN_S)?;
        let mut findings = Vec::new();
        for description in descriptions {
            let finding = if heard.is_empty() {
                self.ask(description)?
            } else {
                assess(description, None, &heard)
            };
            findings.extend(finding.filter(|finding| finding.points > 0));
            if is_settled(&findings) {
                break;
            }
        }
        Ok(findings)
    }

    fn ask(
        &mut self,
        description: &InstrumentDescription,
    ) -> Result<Option<ProbeFinding>, PortError> {
        let mut finding = self.value(description)?;
        if finding.is_none() {
            // A request that was meant for another gauge may have had no end for this one, and have spoilt the next.
            finding = self.value(description)?;
        }
        let Some(mut finding) = finding else {
            return Ok(None);
        };
        if finding.points > 0
            && let Some(heard) = self.reply(description, CommandRole::Identify)?
            && let Some(identity) = identity(description, &heard)
        {
            finding.points += 2;
            finding.identity = Some(identity);
        }
        Ok(Some(finding))
    }

    /// What a request for a value brings; `None` if the gauge has none that only reads, or nothing comes that fits.
    fn value(
        &mut self,
        description: &InstrumentDescription,
    ) -> Result<Option<ProbeFinding>, PortError> {
        let heard = self.reply(description, CommandRole::Read)?;
        Ok(heard.and_then(|heard| assess(description, Some(CommandRole::Read), &heard)))
    }

    /// What comes of a command; `None` if the gauge has none that only reads, or nothing comes.
    fn reply(
        &mut self,
        description: &InstrumentDescription,
        role: CommandRole,
    ) -> Result<Option<Vec<u8>>, PortError> {
        let Some(command) = description
            .command(role)
            .filter(|command| command.effect == CommandEffect::Reads)
        else {
            return Ok(None);
        };
        let cleared = self.open.port.clear(ClearBuffer::Input);
        cleared.map_err(|error| self.lost(&error.to_string()))?;
        let written = self.open.port.write_all(&command.bytes);
        written.map_err(|error| self.lost(&error.to_string()))?;
        let timing = description.timing();
        let quiet_s = timing.drain_s.max(description.idle_gap_s());
        let heard = self.listen(timing.reply_deadline_s, quiet_s)?;
        Ok((!heard.is_empty()).then_some(heard))
    }

    /// What comes within `first_s`, and after it until nothing comes for `quiet_s`.
    fn listen(&mut self, first_s: f64, quiet_s: f64) -> Result<Vec<u8>, PortError> {
        let mut heard = Vec::new();
        let mut until_s = self.clock.now_s() + first_s;
        // A stream has no end; a second of it is enough.
        let end_s = until_s + 1.0;
        let mut buffer = [0; 256];
        loop {
            let left_s = until_s.min(end_s) - self.clock.now_s();
            if left_s <= 0.0 {
                return Ok(heard);
            }
            let waiting = self.open.port.set_timeout(Duration::from_secs_f64(left_s));
            waiting.map_err(|error| self.lost(&error.to_string()))?;
            match self.open.port.read(&mut buffer) {
                Ok(0) => return Err(self.lost("the system delivers no more bytes")),
                Ok(count) => {
                    heard.extend_from_slice(&buffer[..count]);
                    until_s = until_s.max(self.clock.now_s() + quiet_s);
                }
                Err(error)
                    if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {}
                Err(error) => return Err(self.lost(&error.to_string())),
            }
        }
    }

    fn lost(&self, problem: &str) -> PortError {
        PortError::Lost {
            port: self.open.path.clone(),
            problem: problem.to_owned(),
        }
    }
}

fn decoded(
    description: &InstrumentDescription,
    asked: Option<CommandRole>,
    heard: &[u8],
) -> Vec<Decoded> {
    let choices = description.unit_choices();
    let decoder = Decoder::new(description, None)
        .or_else(|_| Decoder::new(description, choices.first().copied()));
    let Ok(mut decoder) = decoder else {
        return Vec::new();
    };
    if let Some(role) = asked {
        decoder.asked(role);
    }
    let mut decoded = Vec::new();
    decoder.push(heard, 0.0, &mut decoded);
    decoder.idle(0.0, &mut decoded);
    decoded
}

/// How well a description fits what was heard.
fn assess(
    description: &InstrumentDescription,
    asked: Option<CommandRole>,
    heard: &[u8],
) -> Option<ProbeFinding> {
    let decoded = decoded(description, asked, heard);
    let values: Vec<String> = decoded
        .iter()
        .filter_map(|item| match item {
            Decoded::Sample(sample) => Some(sample.raw.to_string()),
            _ => None,
        })
        .collect();
    let wrong = decoded
        .iter()
        .filter(|item| matches!(item, Decoded::Rejected(_)))
        .count();
    let points = 3 * values.len().min(3) as i32 - wrong.min(3) as i32;
    values.first().map(|first| ProbeFinding {
        instrument: description.name.clone(),
        points,
        evidence: first.clone(),
        identity: None,
        other_baud: None,
    })
}

fn identity(description: &InstrumentDescription, heard: &[u8]) -> Option<String> {
    decoded(description, Some(CommandRole::Identify), heard)
        .into_iter()
        .find_map(|item| match item {
            Decoded::Reply(reply) => match reply.meaning {
                Meaning::Identity(text) => Some(text),
                _ => None,
            },
            _ => None,
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(instrument: &str, points: i32) -> ProbeFinding {
        ProbeFinding {
            instrument: instrument.to_owned(),
            points,
            evidence: String::new(),
            identity: None,
            other_baud: None,
        }
    }

    #[test]
    fn a_match_is_clear_if_it_stands_alone_at_the_top() {
        let [a, b, c] = [finding("a", 5), finding("b", 5), finding("c", 2)];
        assert_eq!(
            clear_match(&[a.clone(), c.clone()]).map(|best| &*best.instrument),
            Some("a")
        );
        assert_eq!(clear_match(&[a, b]), None);
        assert_eq!(clear_match(&[c]), None);
        assert_eq!(clear_match(&[]), None);
    }

    #[test]
    fn each_setting_of_a_line_is_tried_once_for_all_that_may_have_it() {
        let names = ["mark10-series5", "nidec-shimpo-fg7000", "cdi-logic"];
        let descriptions: Vec<InstrumentDescription> = names
            .iter()
            .map(|name| crate::shipped::shipped_instrument(name).unwrap())
            .collect();
        let listed = |speeds| -> Vec<(u32, usize)> {
            attempts(&descriptions, speeds)
                .iter()
                .map(|(settings, alike)| (settings.baud, alike.len()))
                .collect()
        };
        assert_eq!(listed(usual_speed), [(115_200, 1), (38_400, 1), (9600, 1)]);
        // Both the Mark-10 and the Shimpo may be set to 9600 8N1.
        assert_eq!(listed(other_speeds), [(9600, 2), (19_200, 1)]);
    }
}
