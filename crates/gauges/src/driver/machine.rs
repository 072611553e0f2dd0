//! The state machine of the talk with one gauge.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::{Ask, CommandRole, Decoded, Decoder, GaugeEvent, InstrumentDescription, LinkState};

use super::exchange::{GaugePresence, PendingCommand, Phase, no_command};
use super::{Acquisition, AcquisitionSettings, DriverAction, DriverTimestamp};

/// A line that is not quiet after this is not drained by waiting longer, s.
const LONGEST_DRAIN_S: f64 = 3.0;
/// Pause between two tries at a gauge that has fallen silent, s: from the first to the last; it doubles.
pub(super) const SILENT_PAUSE_S: [f64; 2] = [0.5, 4.0];

/// The exchange with one gauge.
#[derive(Debug)]
pub struct Driver {
    pub(super) description: Arc<InstrumentDescription>,
    pub(super) decoder: Decoder,
    pub(super) acquisition_settings: AcquisitionSettings,
    pub(super) port: Box<str>,
    pub(super) identity: Option<Box<str>>,
    pub(super) phase: Phase,
    pub(super) jobs: VecDeque<PendingCommand>,
    pub(super) said: Vec<String>,
    pub(super) standing: GaugePresence,
    pub(super) skip: u32,
    /// A reply did not come: the next value is held until it is sure that no second one follows.
    pub(super) doubtful: bool,
    /// Values that came too late since the last one that came in time.
    pub(super) late: u32,
    pub(super) last_byte: Option<DriverTimestamp>,
    pub(super) idle_told: bool,
    pub(super) last_sent_s: f64,
    pub(super) last_value_s: f64,
    pub(super) next_poll_s: f64,
    pub(super) interval_s: f64,
    pub(super) pause_s: f64,
    pub(super) restarts: u32,
    /// Packets that are no value, before the first that is one.
    pub(super) strange: u32,
    pub(super) decoded: Vec<Decoded>,
}

impl Driver {
    /// A driver for a gauge on a port that was just opened and cleared.
    ///
    #[must_use]
    pub fn new(
        description: Arc<InstrumentDescription>,
        decoder: Decoder,
        acquisition_settings: AcquisitionSettings,
        port: &str,
        now: DriverTimestamp,
    ) -> Self {
        let jobs = match acquisition_settings.acquisition {
            Acquisition::Listen => Vec::new(),
            Acquisition::Poll { .. } => {
                PendingCommand::of_opening(&description, acquisition_settings.keep_awake)
            }
            Acquisition::Stream => {
                let mut jobs =
                    PendingCommand::of_opening(&description, acquisition_settings.keep_awake);
                jobs.push(PendingCommand::own(CommandRole::StreamStart));
                jobs
            }
        };
        let rate_per_s = match acquisition_settings.acquisition {
            Acquisition::Poll { most_per_s } => most_per_s.min(description.timing().most_per_s),
            _ => description.timing().most_per_s,
        };
        Self {
            skip: description.timing().discard_after_open,
            decoder,
            acquisition_settings,
            port: port.into(),
            identity: None,
            phase: Phase::Resting,
            jobs: jobs.into(),
            interval_s: 1.0 / rate_per_s,
            said: Vec::new(),
            standing: GaugePresence::Unproven,
            doubtful: false,
            late: 0,
            last_byte: None,
            idle_told: true,
            last_sent_s: f64::NEG_INFINITY,
            last_value_s: now.real_s,
            next_poll_s: now.real_s,
            pause_s: SILENT_PAUSE_S[0],
            restarts: 0,
            strange: 0,
            decoded: Vec::new(),
            description,
        }
    }

    /// The reply of the gauge to the identity request.
    #[must_use]
    pub fn identity(&self) -> Option<&str> {
        self.identity.as_deref()
    }

    /// Whether the gauge has shown that it is the one that was expected.
    #[must_use]
    pub fn is_up(&self) -> bool {
        self.standing == GaugePresence::Up
    }

    /// Bytes arrived.
    pub fn received(
        &mut self,
        bytes: &[u8],
        now: DriverTimestamp,
        actions: &mut Vec<DriverAction>,
    ) {
        self.close_packet(now, actions);
        let mut decoded = std::mem::take(&mut self.decoded);
        self.decoder.push(bytes, now.at_s, &mut decoded);
        self.last_byte = Some(now);
        self.idle_told = false;
        self.take(&mut decoded, now, actions);
        self.decoded = decoded;
    }

    /// Does what is due by now. To be called at [`Driver::due_s`], and after every call of the others.
    pub fn wake(&mut self, now: DriverTimestamp, actions: &mut Vec<DriverAction>) {
        self.close_packet(now, actions);
        if now.real_s >= self.phase_due_s() {
            match std::mem::replace(&mut self.phase, Phase::Resting) {
                Phase::Draining {
                    dropped,
                    reason,
                    again,
                    ..
                } => {
                    self.drained(dropped, reason, again, now, actions);
                }
                Phase::Waiting { job, .. } => {
                    self.doubtful = true;
                    self.retry(job, "no answer in time", now, actions);
                }
                Phase::Confirming { held, .. } => {
                    self.doubtful = false;
                    self.report_value(held, now, actions);
                }
                Phase::Resting => {}
            }
        }
        self.watch_silence(now, actions);
        while self.phase == Phase::Resting && now.real_s >= self.next_job_s() {
            self.next_job(now, actions);
        }
    }

    /// When [`Driver::wake`] has something to do next, real seconds; infinite if nothing is due.
    #[must_use]
    pub fn due_s(&self) -> f64 {
        let phase_s = match &self.phase {
            Phase::Resting => self.next_job_s(),
            _ => self.phase_due_s(),
        };
        let idle_s = match self.last_byte {
            Some(last) if !self.idle_told => last.real_s + self.description.idle_gap_s(),
            _ => f64::INFINITY,
        };
        let silence_s = match (self.acquisition_settings.acquisition, self.standing) {
            (Acquisition::Poll { .. }, _) => f64::INFINITY,
            (Acquisition::Listen, GaugePresence::Silent) => f64::INFINITY,
            _ => self.last_value_s + self.timeout_s(),
        };
        phase_s.min(idle_s).min(silence_s)
    }

    /// When what is under way is over, real seconds: the same sums that [`Driver::wake`] uses.
    fn phase_due_s(&self) -> f64 {
        let timing = self.description.timing();
        match &self.phase {
            Phase::Draining { since_s, .. } => {
                self.quiet_since_s(*since_s)
                    .min(since_s + LONGEST_DRAIN_S - timing.drain_s)
                    + timing.drain_s
            }
            Phase::Waiting { sent_s, .. } => sent_s + timing.reply_deadline_s,
            Phase::Confirming { until_s, .. } => *until_s,
            Phase::Resting => f64::INFINITY,
        }
    }

    /// Since when nothing came, of the time after `since_s`.
    fn quiet_since_s(&self, since_s: f64) -> f64 {
        self.last_byte
            .map_or(since_s, |last| last.real_s.max(since_s))
    }

    /// A request to the gauge: a question, or setting its zero.
    pub fn ask(&mut self, ask: Ask, actions: &mut Vec<DriverAction>) {
        let jobs = PendingCommand::of_ask(&self.description, ask);
        if jobs.is_empty() {
            self.answer(ask, Err(no_command(ask).into()), actions);
        }
        self.jobs.extend(jobs);
    }

    /// The questions that are still open when the port is lost.
    pub fn abandon(&mut self, actions: &mut Vec<DriverAction>) {
        let under_way = match std::mem::replace(&mut self.phase, Phase::Resting) {
            Phase::Waiting { job, .. }
            | Phase::Draining {
                again: Some(job), ..
            } => Some(job),
            _ => None,
        };
        let asks = under_way
            .into_iter()
            .chain(self.jobs.drain(..).collect::<Vec<_>>());
        for ask in asks.filter(|job| !job.more).filter_map(|job| job.ask) {
            self.answer(
                ask,
                Err("the line was lost before the gauge answered".into()),
                actions,
            );
        }
    }

    /// Informs the decoder that nothing came for long enough to end a packet.
    fn close_packet(&mut self, now: DriverTimestamp, actions: &mut Vec<DriverAction>) {
        let Some(last) = self.last_byte else { return };
        if self.idle_told || now.real_s < last.real_s + self.description.idle_gap_s() {
            return;
        }
        self.idle_told = true;
        let mut decoded = std::mem::take(&mut self.decoded);
        self.decoder.idle(last.at_s, &mut decoded);
        self.take(&mut decoded, now, actions);
        self.decoded = decoded;
    }

    fn take(
        &mut self,
        decoded: &mut Vec<Decoded>,
        now: DriverTimestamp,
        actions: &mut Vec<DriverAction>,
    ) {
        for item in decoded.drain(..) {
            match item {
                Decoded::Sample(sample) => self.value(sample, now, actions),
                Decoded::Reply(reply) => self.reply(reply, now, actions),
                Decoded::Rejected(rejected) => self.rejected(rejected, now, actions),
            }
        }
    }

    pub(super) fn answer(
        &self,
        ask: Ask,
        answer: Result<Box<str>, Box<str>>,
        actions: &mut Vec<DriverAction>,
    ) {
        actions.push(DriverAction::Tell(GaugeEvent::Answered {
            channel: self.description.channel,
            ask,
            answer,
        }));
    }

    pub(super) fn note(&self, now: DriverTimestamp, actions: &mut Vec<DriverAction>, text: &str) {
        actions.push(DriverAction::Tell(GaugeEvent::Note {
            channel: self.description.channel,
            text: text.into(),
            at_s: now.at_s,
        }));
    }

    pub(super) fn link(
        &self,
        state: LinkState,
        now: DriverTimestamp,
        actions: &mut Vec<DriverAction>,
    ) {
        actions.push(DriverAction::Tell(GaugeEvent::Link {
            channel: self.description.channel,
            state,
            at_s: now.at_s,
        }));
    }
}
