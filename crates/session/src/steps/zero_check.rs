//! Checking the zero again: whether it has moved, and what that means for the readings on it.

use crate::event::{Event, ZeroOccasion};
use crate::operator::Prompt;
use stiffbench_gauges::Channel;

use super::answers::Why;
use super::{Action, Job, Machine};

/// Share of the largest displacement on a zero that the zero may have moved by.
const DRIFT_SHARE: f64 = 0.02;

/// Share of the largest load that the force zero may have moved by: the error of a stiffness from it.
const FORCE_DRIFT_SHARE: f64 = 0.005;

/// Steps of the last digit below which a drift cannot be determined.
const DRIFT_DIGITS: f64 = 3.0;

/// How often readings are taken once more for a zero that moved, before they are kept with a flag.
const MOST_REDONE: u32 = 3;

impl Machine {
    /// What a displacement gauge shows under the preload is how far its zero has moved, apart from what the force yields by which this preload
    /// is another than that at the zero.
    pub(super) fn displacement_zeros_checked(&mut self) {
        let length_s = self.plan.procedure.settle.dwell_s;
        let set = self.state.zero.as_ref().map(|zero| &zero.set);
        let more_n = set.and_then(|set| Some(self.mean_force_n()? - set.preload_n?));
        let drift = |channel: Channel| {
            let stream = self.stream(channel);
            let window = stream.window(stream.window_from_s(length_s, self.now_s))?;
            let slope = set.and_then(|set| self.slope_m_per_n(set.cell, channel));
            let yielded_m = more_n
                .zip(slope)
                .map_or(0.0, |(more_n, slope)| more_n * slope);
            Some((channel, self.along(channel, window.mean) - yielded_m))
        };
        let drifts: Option<Vec<(Channel, f64)>> = self.displacements().map(drift).collect();
        let Some(drifts) = drifts else {
            return;
        };
        self.drifts_m = drifts;
        self.done();
    }

    /// What the force gauge shows hanging free is how far its zero has moved: both drifts are kept, and asked about where they are large.
    pub(super) fn work_zero_check(&mut self, out: &mut Vec<Action>) {
        let stream = self.stream(Channel::Force);
        // On the way to hanging free it was inside the wide band already: a dwell of its own.
        let dwelt = self.now_s - self.look_since_s >= self.plan.procedure.settle.dwell_s;
        let window = stream
            .window(self.look_since_s)
            .filter(|_| dwelt && stream.is_good(self.now_s));
        let (Some(zero), Some(&(_, first_m))) = (self.state.zero.as_ref(), self.drifts_m.first())
        else {
            self.done();
            return;
        };
        let quiet_n = 2.0 * self.plan.procedure.settle.force_tolerance_n;
        let Some(window) = window else {
            return;
        };
        if window.spread > quiet_n {
            self.look_since_s = self.now_s;
            return;
        }
        let mut zeroed = zero.set.clone();
        let drift_n = self.along(Channel::Force, window.mean);
        let limit_n = self.drift_limit_n();
        let (mut moved, limits) = self.moved_zeros();
        let drifts = self.drifts_m.iter();
        let drifts: Vec<String> = drifts
            .map(|(_, drift_m)| format!("{:.1} um", rounded(drift_m * 1e6, 10.0)))
            .collect();
        if drift_n.abs() > limit_n {
            moved.push(format!("the force zero moved by {drift_n:.2} N"));
        }
        let goes_on = self.zero_is_unsure();
        zeroed.drift_m = Some(first_m);
        for gauge in &mut zeroed.gauges {
            let mut drifts = self.drifts_m.iter();
            let drift = drifts.find(|(channel, _)| *channel == gauge.channel);
            gauge.drift_m = drift.map(|(_, drift_m)| *drift_m);
        }
        zeroed.force_drift_n = Some(drift_n);
        zeroed.flag = moved.join(" and ");
        zeroed.moment = if goes_on {
            ZeroOccasion::Kept
        } else {
            ZeroOccasion::After
        };
        self.notify(
            format!(
                "zero drift: {}, {:.2} N",
                drifts.join(", "),
                rounded(drift_n, 100.0)
            ),
            out,
        );
        self.record(Event::Zero(zeroed), out);
        for channel in self.channels.clone() {
            self.flag_few_digits(channel, out);
            self.stream_mut(channel).learn_digits();
        }
        self.unsure = false;
        if std::mem::take(&mut self.jumped) && moved.is_empty() {
            self.lag_s *= 2.0;
        }
        self.drifts_m.clear();
        self.begin_histories();
        self.done();
        if moved.is_empty() {
            self.note_shown();
            return;
        }
        let text = moved.join(" and ");
        if goes_on {
            self.message(
                format!("{text}: the readings since its last check are flagged"),
                true,
                out,
            );
            // Where the next reading is in another cell or on another zero, that is set on the way to it.
            let open = self.plan.next_open(&self.state, self.focus);
            if let Some((cell, index)) = open.filter(|(cell, index)| self.has_zero(*cell, *index)) {
                self.queue = self.zero(cell, index);
            }
            return;
        }
        self.zero_decided = self.times_redone() >= MOST_REDONE;
        if self.zero_decided {
            self.message(
                format!("{text}, as before: taken {MOST_REDONE} times more, the readings are kept and flagged"),
                true,
                out,
            );
            return;
        }
        let allowed = format!("allowed are {} and {limit_n:.2} N", limits.join(", "));
        self.ask_about_zero(&format!("{text}; {allowed}."), out);
    }

    fn ask_about_zero(&mut self, text: &str, out: &mut Vec<Action>) {
        let prompt = Prompt::choice(
            "drift",
            text,
            &[
                ("keep", "keep the readings; they are flagged"),
                ("redo", "take the readings on this zero once more"),
            ],
        );
        self.ask(prompt, Why::Drift, out);
    }

    /// How far the last zero moved, in words, while the operator has not decided about it.
    pub(super) fn open_zero_question(&self) -> Option<&str> {
        let moved = self.state.undecided.as_deref();
        moved.filter(|_| !self.zero_decided)
    }

    /// The session was interrupted at this question.
    pub(super) fn ask_again_about_zero(&mut self, out: &mut Vec<Action>) {
        let moved = self.open_zero_question().unwrap_or_default();
        let text = format!("Before the interruption {moved}.");
        self.ask_about_zero(&text, out);
    }

    pub(super) fn drift_answered(&mut self, word: &str, out: &mut Vec<Action>) {
        self.zero_decided = true;
        if self.job == Some(Job::ZeroMoved) {
            self.done();
        }
        if word == "redo" {
            self.redo_zero(out);
        }
    }

    /// How often the readings on the zero in use were taken once more because it moved.
    fn times_redone(&self) -> u32 {
        let zero = self.state.zero.as_ref();
        let redone = self.redone.as_ref().filter(|((cell, scope), _)| {
            zero.is_some_and(|zero| (zero.set.cell, &zero.set.scope) == (*cell, scope))
        });
        redone.map_or(0, |(_, times)| *times)
    }

    /// The displacement zeros that moved too far, and the limits of all, in words.
    fn moved_zeros(&self) -> (Vec<String>, Vec<String>) {
        let mut moved = Vec::new();
        let mut limits = Vec::new();
        for &(channel, drift_m) in &self.drifts_m {
            let limit_m = self.drift_limit_m(channel);
            limits.push(format!("{:.1} um", limit_m * 1e6));
            if drift_m.abs() > limit_m {
                moved.push(format!(
                    "the {channel} zero moved by {:.1} um",
                    drift_m * 1e6
                ));
            }
        }
        (moved, limits)
    }

    /// Drift of a displacement zero that matters: a share of what is measured on it, no less than the gauge can show.
    pub(super) fn drift_limit_m(&self, channel: Channel) -> f64 {
        let settle = &self.plan.procedure.settle;
        let digit_m = self.stream(channel).last.as_ref();
        let digit_m = digit_m.map_or(0.0, |last| last.resolution_si);
        let least_m = settle.spread_m.max(DRIFT_DIGITS * digit_m);
        let zero = self.state.zero.as_ref();
        let on_it = self.state.readings.iter().filter(|kept| {
            zero.is_some_and(|zero| {
                (kept.taken.cell, &kept.taken.zero) == (zero.set.cell, &zero.set.label)
            })
        });
        let largest_m = on_it
            .filter_map(|kept| kept.taken.displacement_of(channel))
            .map(f64::abs)
            .fold(0.0, f64::max);
        (DRIFT_SHARE * largest_m)
            .min(self.settings.drift_limit_m)
            .max(least_m)
    }

    /// Drift of the force zero that matters.
    fn drift_limit_n(&self) -> f64 {
        let digit_n = self.stream(Channel::Force).last.as_ref();
        let digit_n = digit_n.map_or(0.0, |last| last.resolution_si);
        (FORCE_DRIFT_SHARE * self.plan.largest_n()).max(DRIFT_DIGITS * digit_n)
    }

    /// Whether the zero in use has to be checked before the next reading.
    pub(super) fn zero_is_unsure(&self) -> bool {
        self.state.unconfirmed || self.unsure
    }

    /// Every reading on the zero in use is to be taken once more.
    pub(super) fn redo_zero(&mut self, out: &mut Vec<Action>) {
        let Some(zero) = self.state.zero.as_ref() else {
            return;
        };
        let (cell, scope) = (zero.set.cell, zero.set.scope.clone());
        self.redone = Some(((cell, scope.clone()), self.times_redone() + 1));
        let on_it = self.state.on_zero();
        let numbers: Vec<u32> = on_it.map(|kept| kept.taken.number).collect();
        self.supersede(numbers, "the zero moved", out);
        let readings = self.plan.cells[cell].readings.iter();
        let first = readings
            .map(|reading| self.plan.zero_scope(reading))
            .position(|of| of == scope);
        let jobs = self.zero(cell, first.unwrap_or(0));
        self.reroute();
        self.queue = jobs;
    }
}

/// A number for print, rounded to so many parts of one; a rounded zero has no sign.
fn rounded(value: f64, parts: f64) -> f64 {
    (value * parts).round() / parts + 0.0
}
