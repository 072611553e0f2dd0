//! What is sent to the gauge, and what is done when nothing comes back.

use crate::{CommandEffect, CommandRole, Expect, LinkState};
use stiffbench_units_and_text::count::counted;

use super::exchange::{GaugePresence, PendingCommand, Phase, unanswered};
use super::machine::{Driver, SILENT_PAUSE_S};
use super::{Acquisition, DriverAction, DriverTimestamp};

/// Values that come late without one in time between them, after which the gauge is slow and no single answer was lost.
const LATE_IN_A_ROW: u32 = 5;

impl Driver {
    /// The line is quiet, or will not be.
    pub(super) fn drained(
        &mut self,
        dropped: usize,
        reason: &'static str,
        again: Option<PendingCommand>,
        now: DriverTimestamp,
        actions: &mut Vec<DriverAction>,
    ) {
        let is_quiet = self
            .last_byte
            .is_none_or(|last| now.real_s >= last.real_s + self.description.timing().drain_s);
        self.decoder.reset();
        self.idle_told = true;
        if dropped > 0 {
            actions.push(DriverAction::Unused {
                count: dropped,
                reason,
            });
            self.note(
                now,
                actions,
                &format!(
                    "not used, because the line was drained ({reason}): {}",
                    counted(dropped, "value")
                ),
            );
        }
        actions.push(DriverAction::Reset);
        if !is_quiet {
            self.note(now, actions, "the gauge keeps sending and cannot be stopped over the line: stop it at the gauge, or read it as a stream");
        }
        if let Some(job) = again {
            self.send(job, now, actions);
        }
    }

    /// Drains the line and asks again, or gives up on this question.
    pub(super) fn retry(
        &mut self,
        job: PendingCommand,
        reason: &'static str,
        now: DriverTimestamp,
        actions: &mut Vec<DriverAction>,
    ) {
        let timing = self.description.timing();
        let repeatable = self.description.command(job.role).is_some_and(|command| {
            matches!(command.effect, CommandEffect::Reads | CommandEffect::Sets)
        });
        if repeatable && job.tries <= timing.retries {
            let text = format!(
                "{reason} to {} (try {} of {}): line drained, asked again",
                job.role,
                job.tries,
                timing.retries + 1
            );
            self.note(now, actions, &text);
            self.drain(reason, Some(job), now);
            return;
        }
        self.give_up(&job, now, actions);
        self.drain(reason, None, now);
    }

    /// A command was sent as often as it may be.
    fn give_up(
        &mut self,
        job: &PendingCommand,
        now: DriverTimestamp,
        actions: &mut Vec<DriverAction>,
    ) {
        if job.role == CommandRole::Read {
            self.fall_silent(now, actions);
        } else if let Some(ask) = job.ask {
            self.said.clear();
            self.drop_rest(job);
            let why = format!("no answer after {} tries; {}", job.tries, unanswered(ask));
            self.answer(ask, Err(why.into()), actions);
        } else if job.role == CommandRole::Identify && self.acquisition_settings.expected.is_some()
        {
            // Nothing counts before it is known who answers.
            self.fall_silent(now, actions);
            self.jobs
                .push_front(PendingCommand::own(CommandRole::Identify));
        } else {
            let text = format!("no answer to {}; continuing without it", job.role);
            self.note(now, actions, &text);
        }
    }

    /// Takes the commands back that belong to the same question as one that failed; the same question asked again stays.
    pub(super) fn drop_rest(&mut self, failed: &PendingCommand) {
        let mut more = failed.more;
        while more && let Some(place) = self.jobs.iter().position(|job| job.ask == failed.ask) {
            more = self.jobs.remove(place).is_some_and(|job| job.more);
        }
    }

    pub(super) fn fall_silent(&mut self, now: DriverTimestamp, actions: &mut Vec<DriverAction>) {
        self.next_poll_s = now.real_s + self.pause_s;
        self.pause_s = (self.pause_s * 2.0).min(SILENT_PAUSE_S[1]);
        if self.standing != GaugePresence::Silent {
            self.standing = GaugePresence::Silent;
            let state = if self.late > 0 {
                LinkState::Slow {
                    reason: self.too_late().into(),
                }
            } else {
                LinkState::Silent
            };
            self.link(state, now, actions);
        }
    }

    /// A value came later than it is waited for; a gauge that is always late is reported.
    pub(super) fn came_late(&mut self, now: DriverTimestamp, actions: &mut Vec<DriverAction>) {
        self.late += 1;
        if self.late.is_multiple_of(LATE_IN_A_ROW) {
            self.note(now, actions, &self.too_late());
        }
    }

    fn too_late(&self) -> String {
        format!(
            "{} answers later than the {} s that its description waits: give it a longer timing.reply_deadline_s, or a gauge or adapter setting that answers sooner",
            self.description.name,
            self.description.timing().reply_deadline_s
        )
    }

    pub(super) fn drain(
        &mut self,
        reason: &'static str,
        again: Option<PendingCommand>,
        now: DriverTimestamp,
    ) {
        self.phase = Phase::Draining {
            since_s: now.real_s,
            dropped: 0,
            reason,
            again,
        };
    }

    /// When the next command may and should be sent.
    pub(super) fn next_job_s(&self) -> f64 {
        let wanted_s = match (self.jobs.front(), self.acquisition_settings.acquisition) {
            (Some(_), _) if self.standing != GaugePresence::Silent => f64::NEG_INFINITY,
            (Some(_), _) | (None, Acquisition::Poll { .. }) => self.next_poll_s,
            (None, _) => return f64::INFINITY,
        };
        wanted_s.max(self.last_sent_s + self.description.timing().gap_s)
    }

    pub(super) fn next_job(&mut self, now: DriverTimestamp, actions: &mut Vec<DriverAction>) {
        if let Some(job) = self.jobs.pop_front() {
            self.send(job, now, actions);
            return;
        }
        self.next_poll_s =
            (self.next_poll_s + self.interval_s).max(now.real_s + self.interval_s / 2.0);
        let mut job = PendingCommand::own(CommandRole::Read);
        if self.standing == GaugePresence::Silent {
            // One try at a time, without a message: its silence has been reported.
            job.tries = self.description.timing().retries;
        }
        self.send(job, now, actions);
    }

    pub(super) fn send(
        &mut self,
        mut job: PendingCommand,
        now: DriverTimestamp,
        actions: &mut Vec<DriverAction>,
    ) {
        let Some(command) = self.description.command(job.role) else {
            return;
        };
        let expects = command.expects;
        actions.push(DriverAction::Send {
            role: job.role,
            bytes: command.bytes.clone(),
        });
        job.tries += 1;
        self.last_sent_s = now.real_s;
        self.decoder.asked(job.role);
        if job.role == CommandRole::StreamStop || job.role == CommandRole::Resynchronise {
            // What was under way may still come.
            self.drain("what was sent before", None, now);
        } else if expects == Expect::Nothing {
            self.done(&job, Ok(String::new()), now, actions);
        } else if job.role == CommandRole::StreamStart && expects == Expect::Value {
            self.last_value_s = now.real_s;
        } else {
            self.phase = Phase::Waiting {
                job,
                sent_s: now.real_s,
            };
        }
    }

    /// How long a stream may be silent, s.
    pub(super) fn timeout_s(&self) -> f64 {
        let silent_s = self.description.timing().silent_after_s;
        if self.standing == GaugePresence::Silent {
            silent_s + self.pause_s
        } else {
            silent_s
        }
    }

    pub(super) fn watch_silence(&mut self, now: DriverTimestamp, actions: &mut Vec<DriverAction>) {
        if matches!(
            self.acquisition_settings.acquisition,
            Acquisition::Poll { .. }
        ) || now.real_s < self.last_value_s + self.timeout_s()
        {
            return;
        }
        self.fall_silent(now, actions);
        self.last_value_s = now.real_s;
        if self.acquisition_settings.acquisition == Acquisition::Stream
            && self.phase == Phase::Resting
            && self.jobs.is_empty()
        {
            self.next_poll_s = now.real_s;
            if self.restarts < self.description.timing().retries {
                self.restarts += 1;
                self.note(
                    now,
                    actions,
                    "the stream is silent: the start command is sent again",
                );
            }
            self.jobs
                .push_back(PendingCommand::own(CommandRole::StreamStart));
        }
    }
}
