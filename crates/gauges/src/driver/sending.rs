//! What is sent to the gauge, and what is done when nothing comes back.

use crate::{Effect, Expect, LinkState, Role};

use super::exchange::{Job, Phase, Standing, unanswered};
use super::machine::{Driver, SILENT_PAUSE_S};
use super::{Acquisition, Deed, Moment};

/// Values that come late without one in time between them, after which the gauge is slow and no single answer was lost.
const LATE_IN_A_ROW: u32 = 5;

impl Driver {
    /// The line is quiet, or will not be.
    pub(super) fn drained(
        &mut self,
        dropped: usize,
        reason: &'static str,
        again: Option<Job>,
        now: Moment,
        deeds: &mut Vec<Deed>,
    ) {
        let is_quiet = self
            .last_byte
            .is_none_or(|last| now.real_s >= last.real_s + self.description.timing().drain_s);
        self.decoder.reset();
        self.idle_told = true;
        if dropped > 0 {
            deeds.push(Deed::Unused {
                count: dropped,
                reason,
            });
            self.note(
                now,
                deeds,
                &format!(
                    "{dropped} values came while the line was drained ({reason}) and are not used"
                ),
            );
        }
        deeds.push(Deed::Reset);
        if !is_quiet {
            self.note(now, deeds, "the gauge keeps sending and cannot be stopped over the line: stop it at the gauge, or read it as a stream");
        }
        if let Some(job) = again {
            self.send(job, now, deeds);
        }
    }

    /// Drains the line and asks again, or gives up on this question.
    pub(super) fn retry(
        &mut self,
        job: Job,
        reason: &'static str,
        now: Moment,
        deeds: &mut Vec<Deed>,
    ) {
        let timing = self.description.timing();
        let repeatable = self
            .description
            .command(job.role)
            .is_some_and(|command| matches!(command.effect, Effect::Reads | Effect::Sets));
        if repeatable && job.tries <= timing.retries {
            let text = format!(
                "{reason} to {} (try {} of {}): line drained, asked again",
                job.role,
                job.tries,
                timing.retries + 1
            );
            self.note(now, deeds, &text);
            self.drain(reason, Some(job), now);
            return;
        }
        self.give_up(&job, now, deeds);
        self.drain(reason, None, now);
    }

    /// A command was sent as often as it may be.
    fn give_up(&mut self, job: &Job, now: Moment, deeds: &mut Vec<Deed>) {
        if job.role == Role::Read {
            self.fall_silent(now, deeds);
        } else if let Some(ask) = job.ask {
            self.said.clear();
            self.drop_rest(job);
            let why = format!("no answer after {} tries; {}", job.tries, unanswered(ask));
            self.answer(ask, Err(why.into()), deeds);
        } else if job.role == Role::Identify && self.manner.expected.is_some() {
            // Nothing counts before it is known who answers.
            self.fall_silent(now, deeds);
            self.jobs.push_front(Job::own(Role::Identify));
        } else {
            let text = format!("no answer to {}; going on without", job.role);
            self.note(now, deeds, &text);
        }
    }

    /// Takes the commands back that belong to the same question as one that failed; the same question asked again stays.
    pub(super) fn drop_rest(&mut self, failed: &Job) {
        let mut more = failed.more;
        while more && let Some(place) = self.jobs.iter().position(|job| job.ask == failed.ask) {
            more = self.jobs.remove(place).is_some_and(|job| job.more);
        }
    }

    pub(super) fn fall_silent(&mut self, now: Moment, deeds: &mut Vec<Deed>) {
        self.next_poll_s = now.real_s + self.pause_s;
        self.pause_s = (self.pause_s * 2.0).min(SILENT_PAUSE_S[1]);
        if self.standing != Standing::Silent {
            self.standing = Standing::Silent;
            let state = if self.late > 0 {
                LinkState::Slow {
                    reason: self.too_late().into(),
                }
            } else {
                LinkState::Silent
            };
            self.link(state, now, deeds);
        }
    }

    /// A value came later than it is waited for; a gauge that is always late is reported.
    pub(super) fn came_late(&mut self, now: Moment, deeds: &mut Vec<Deed>) {
        self.late += 1;
        if self.late.is_multiple_of(LATE_IN_A_ROW) {
            self.note(now, deeds, &self.too_late());
        }
    }

    fn too_late(&self) -> String {
        format!(
            "{} answers later than the {} s that its description waits: give it a longer timing.reply_deadline_s, or a gauge or adapter setting that answers sooner",
            self.description.name,
            self.description.timing().reply_deadline_s
        )
    }

    pub(super) fn drain(&mut self, reason: &'static str, again: Option<Job>, now: Moment) {
        self.phase = Phase::Draining {
            since_s: now.real_s,
            dropped: 0,
            reason,
            again,
        };
    }

    /// When the next command may and should be sent.
    pub(super) fn next_job_s(&self) -> f64 {
        let wanted_s = match (self.jobs.front(), self.manner.acquisition) {
            (Some(_), _) if self.standing != Standing::Silent => f64::NEG_INFINITY,
            (Some(_), _) | (None, Acquisition::Poll { .. }) => self.next_poll_s,
            (None, _) => return f64::INFINITY,
        };
        wanted_s.max(self.last_sent_s + self.description.timing().gap_s)
    }

    pub(super) fn next_job(&mut self, now: Moment, deeds: &mut Vec<Deed>) {
        if let Some(job) = self.jobs.pop_front() {
            self.send(job, now, deeds);
            return;
        }
        self.next_poll_s =
            (self.next_poll_s + self.interval_s).max(now.real_s + self.interval_s / 2.0);
        let mut job = Job::own(Role::Read);
        if self.standing == Standing::Silent {
            // One try at a time, without a message: its silence has been reported.
            job.tries = self.description.timing().retries;
        }
        self.send(job, now, deeds);
    }

    pub(super) fn send(&mut self, mut job: Job, now: Moment, deeds: &mut Vec<Deed>) {
        let Some(command) = self.description.command(job.role) else {
            return;
        };
        let expects = command.expects;
        deeds.push(Deed::Send {
            role: job.role,
            bytes: command.bytes.clone(),
        });
        job.tries += 1;
        self.last_sent_s = now.real_s;
        self.decoder.asked(job.role);
        if job.role == Role::StreamStop || job.role == Role::Resynchronise {
            // What was under way may still come.
            self.drain("what was sent before", None, now);
        } else if expects == Expect::Nothing {
            self.done(&job, Ok(String::new()), now, deeds);
        } else if job.role == Role::StreamStart && expects == Expect::Value {
            self.last_value_s = now.real_s;
        } else {
            self.phase = Phase::Waiting {
                job,
                sent_s: now.real_s,
            };
        }
    }

    /// How long a stream may be silent, s.
    pub(super) fn patience_s(&self) -> f64 {
        let silent_s = self.description.timing().silent_after_s;
        if self.standing == Standing::Silent {
            silent_s + self.pause_s
        } else {
            silent_s
        }
    }

    pub(super) fn watch_silence(&mut self, now: Moment, deeds: &mut Vec<Deed>) {
        if matches!(self.manner.acquisition, Acquisition::Poll { .. })
            || now.real_s < self.last_value_s + self.patience_s()
        {
            return;
        }
        self.fall_silent(now, deeds);
        self.last_value_s = now.real_s;
        if self.manner.acquisition == Acquisition::Stream
            && self.phase == Phase::Resting
            && self.jobs.is_empty()
        {
            self.next_poll_s = now.real_s;
            if self.restarts < self.description.timing().retries {
                self.restarts += 1;
                self.note(
                    now,
                    deeds,
                    "the stream is silent: the start command is sent again",
                );
            }
            self.jobs.push_back(Job::own(Role::StreamStart));
        }
    }
}
