//! What comes from the gauge, and what it answers.

use crate::{CommandRole, GaugeEvent, LinkState, Meaning, Rejected, Reply, Sample};

use super::exchange::{GaugePresence, PendingCommand, Phase, unanswered};
use super::machine::{Driver, SILENT_PAUSE_S};
use super::{DriverAction, DriverTimestamp};

/// Packets in a row that are no value, before there was any, after which another gauge is likelier than noise at the start.
const STRANGE_PACKETS: u32 = 5;

impl Driver {
    /// Bytes that are no value.
    pub(super) fn rejected(
        &mut self,
        rejected: Rejected,
        now: DriverTimestamp,
        actions: &mut Vec<DriverAction>,
    ) {
        self.strange += 1;
        if self.standing != GaugePresence::Up && self.strange == STRANGE_PACKETS {
            let reason = format!(
                "no value of {} was received, but {} ({}): is another gauge on this port, or is it not ready?",
                self.description.name, rejected.raw, rejected.reason
            );
            let reason = reason.into();
            self.link(LinkState::WrongDevice { reason }, now, actions);
        }
        let channel = self.description.channel;
        actions.push(DriverAction::Tell(GaugeEvent::Rejected {
            channel,
            rejected,
        }));
        // It may be the answer, or the wreck of it: nothing else is believed before the line is quiet.
        if matches!(&self.phase, Phase::Waiting { job, .. } if job.role == CommandRole::Read) {
            self.drain("bytes that are no value", None, now);
        }
    }

    pub(super) fn value(
        &mut self,
        sample: Sample,
        now: DriverTimestamp,
        actions: &mut Vec<DriverAction>,
    ) {
        let channel = self.description.channel;
        if sample.kind != channel.kind() && !matches!(self.phase, Phase::Draining { .. }) {
            // The other number of a packet: what its own number answers, it answers too.
            actions.push(DriverAction::Tell(GaugeEvent::Sample { channel, sample }));
            return;
        }
        self.last_value_s = now.real_s;
        let is_answer =
            matches!(&self.phase, Phase::Waiting { job, .. } if job.role == CommandRole::Read);
        match std::mem::replace(&mut self.phase, Phase::Resting) {
            Phase::Draining {
                since_s,
                dropped,
                reason,
                again,
            } => {
                self.came_late(now, actions);
                self.phase = Phase::Draining {
                    since_s,
                    dropped: dropped + 1,
                    reason,
                    again,
                };
                return;
            }
            Phase::Confirming { job, .. } => {
                self.note(now, actions, "two values arrived for one request, one of them late: neither is used; the request is repeated");
                actions.push(DriverAction::Unused {
                    count: 2,
                    reason: "one of two is late",
                });
                self.retry(job, "a late value", now, actions);
                return;
            }
            Phase::Waiting { job, .. } if is_answer && self.doubtful => {
                self.came_late(now, actions);
                let until_s = now.real_s + self.description.timing().drain_s;
                self.phase = Phase::Confirming {
                    held: sample,
                    until_s,
                    job,
                };
                return;
            }
            Phase::Waiting { .. } if is_answer => self.late = 0,
            phase => self.phase = phase,
        }
        self.report_value(sample, now, actions);
    }

    pub(super) fn report_value(
        &mut self,
        sample: Sample,
        now: DriverTimestamp,
        actions: &mut Vec<DriverAction>,
    ) {
        self.restarts = 0;
        self.strange = 0;
        self.pause_s = SILENT_PAUSE_S[0];
        if self.standing != GaugePresence::Up {
            self.standing = GaugePresence::Up;
            self.link(
                LinkState::Connected {
                    port: self.port.clone(),
                },
                now,
                actions,
            );
        }
        if self.skip > 0 {
            self.skip -= 1;
            actions.push(DriverAction::Unused {
                count: 1,
                reason: "first after opening",
            });
            return;
        }
        actions.push(DriverAction::Tell(GaugeEvent::Sample {
            channel: self.description.channel,
            sample,
        }));
    }

    pub(super) fn reply(
        &mut self,
        reply: Reply,
        now: DriverTimestamp,
        actions: &mut Vec<DriverAction>,
    ) {
        let job = match std::mem::replace(&mut self.phase, Phase::Resting) {
            Phase::Waiting { job, .. } if answers(&reply.meaning, job.role) => job,
            phase => {
                // While a command is out, what does not answer it is its echo.
                let is_unasked = matches!(phase, Phase::Resting | Phase::Confirming { .. });
                self.phase = phase;
                if is_unasked {
                    self.note(
                        now,
                        actions,
                        &format!("the gauge sent {} without a request", reply.raw),
                    );
                }
                return;
            }
        };
        let said = match reply.meaning {
            Meaning::Refused(why) => Err(why),
            Meaning::Acknowledged => Ok(String::new()),
            Meaning::Identity(text)
            | Meaning::Unit(text)
            | Meaning::State(text)
            | Meaning::Text(text) => Ok(text),
        };
        self.doubtful = false;
        self.next_poll_s = self.next_poll_s.min(now.real_s);
        self.done(&job, said, now, actions);
    }

    /// A command has its answer.
    pub(super) fn done(
        &mut self,
        job: &PendingCommand,
        said: Result<String, String>,
        now: DriverTimestamp,
        actions: &mut Vec<DriverAction>,
    ) {
        if job.role == CommandRole::Identify && !self.is_expected(said.as_ref().ok(), actions) {
            return;
        }
        let Some(ask) = job.ask else {
            match said {
                Ok(text) if !text.is_empty() => {
                    self.note(now, actions, &format!("the gauge reports {text}"));
                }
                Ok(_) => {}
                Err(why) => self.note(
                    now,
                    actions,
                    &format!("the gauge refuses {}: {why}", job.role),
                ),
            }
            return;
        };
        match said {
            Ok(text) if job.more => self.said.push(text),
            Ok(text) => {
                self.said.push(text);
                let text = std::mem::take(&mut self.said).join("; ");
                self.answer(ask, Ok(text.into()), actions);
            }
            Err(why) => {
                self.said.clear();
                self.drop_rest(job);
                self.answer(
                    ask,
                    Err(format!("the gauge refuses: {why}; {}", unanswered(ask)).into()),
                    actions,
                );
            }
        }
    }

    /// Whether the gauge is the one that was expected, by the identity that it reports.
    pub(super) fn is_expected(
        &mut self,
        said: Option<&String>,
        actions: &mut Vec<DriverAction>,
    ) -> bool {
        let found: Option<Box<str>> = said.map(|text| text.trim().into());
        let same = match (&self.acquisition_settings.expected, &found) {
            (Some(expected), Some(found)) => expected.trim() == &**found,
            (Some(_), None) => false,
            (None, _) => true,
        };
        if !same && let Some(expected) = &self.acquisition_settings.expected {
            let found = found
                .as_deref()
                .unwrap_or("an instrument that does not know this query");
            actions.push(DriverAction::Refuse {
                reason: format!("expected {expected}, but {found} answered").into(),
            });
            return false;
        }
        self.identity = found;
        true
    }
}

/// Whether a reply can be the answer to a command: a request for a value is answered by a value, and a question by more than its echo.
fn answers(meaning: &Meaning, role: CommandRole) -> bool {
    match role {
        CommandRole::Read => false,
        CommandRole::Identify | CommandRole::QueryUnit | CommandRole::QueryMode => {
            !matches!(meaning, Meaning::Text(_))
        }
        _ => true,
    }
}
