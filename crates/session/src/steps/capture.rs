//! Taking a reading: when it may be taken, and what must be asked before.

use crate::event::{AxisReading, Event, LimitCheck, TakenReading};
use crate::operator::{Bell, Prompt};
use crate::raw_bytes::RawBytes;
use stiffbench_gauges::Channel;

use super::answers::Why;
use super::plausibility::CaptureCheck;
use super::{Action, Applied, Machine};

/// The operator is asked about a failed check that may pass by itself after this many dwells under the load without a gap.
const PATIENT_DWELLS: f64 = 3.0;

impl Machine {
    pub(super) fn work_reading(&mut self, cell: usize, index: usize, out: &mut Vec<Action>) {
        if self.is_ready(cell, index) && self.settings.auto_capture {
            self.capture(cell, index, out);
        } else {
            self.ask_about_a_steady_force(out);
        }
    }

    /// Whether everything is as it must be: settled; or, for an extra reading, held long enough with the force in its band.
    pub(super) fn is_ready(&self, cell: usize, index: usize) -> bool {
        let planned = &self.plan.cells[cell].readings[index];
        let (Some(load), Some(settle)) = (&self.load, self.settle()) else {
            return false;
        };
        let Some(hold_s) = planned.extra_hold_s else {
            return settle.settled && self.last_values_are_typical();
        };
        let held_s = load
            .reached_s
            .map_or(0.0, |reached_s| self.now_s - reached_s);
        let good = self.feeds.iter().all(|stream| stream.is_good(self.now_s));
        good && held_s >= hold_s
            && settle.dwell_s >= settle.dwell_needed_s
            && self.last_values_are_typical()
    }

    /// Whether the last value of each gauge, which is kept, is like those of the dwell before it.
    fn last_values_are_typical(&self) -> bool {
        let dwell_s = self.plan.procedure.settle.dwell_s;
        let mut feeds = self.feeds.iter();
        feeds.all(|stream| stream.is_last_typical(stream.window_from_s(dwell_s, self.now_s)))
    }

    /// Takes the reading, or asks what has to be asked first.
    pub(super) fn capture(&mut self, cell: usize, index: usize, out: &mut Vec<Action>) {
        let Some(taken) = self.reading(cell, index) else {
            return;
        };
        let accepted = self.load.as_ref().map_or(&[][..], |load| &load.accepted);
        let mut failed_checks = self.failed_checks(&taken).into_iter();
        let open = failed_checks.find(|check| !accepted.contains(&(check.rule, check.channel)));
        if let Some(capture_check) = open {
            let patient_s = PATIENT_DWELLS * self.plan.procedure.settle.dwell_s;
            let dwelt_s = self
                .load
                .as_ref()
                .map_or(0.0, |load| load.dwell_s(self.now_s));
            if !capture_check.may_pass || dwelt_s >= patient_s {
                self.ask_capture_check(&capture_check, out);
            }
            return;
        }
        if self.checks_zero_after_a_jump(&taken, out) {
            return;
        }
        self.applied = Some(Applied {
            cell,
            repeat: taken.repeat,
            step: taken.step,
        });
        self.note_shown();
        let from_s = self.now_s - self.plan.procedure.settle.dwell_s;
        for stream in &mut self.feeds {
            stream.learn_flicker(from_s);
            stream.learn_digits();
        }
        let text = format!(
            "reading {}: {:.2} N, {}",
            taken.number,
            taken.force_n,
            taken.displacement_text()
        );
        if let Some(checked) = taken.limits.as_ref().filter(|of| !of.exceeded.is_empty()) {
            self.message(checked.exceeded.clone(), true, out);
        }
        self.record(Event::Reading(Box::new(taken)), out);
        out.push(Action::Bell(Bell::Captured));
        self.notify(text, out);
        self.done();
    }

    /// A gauge that jumped while the other stood still has lost its zero, or its stand was moved: back to the preload, once for each load.
    fn checks_zero_after_a_jump(&mut self, taken: &TakenReading, out: &mut Vec<Action>) -> bool {
        let jumped = self.moved_alone(taken.cell);
        let Some(jumped) = jumped.filter(|_| taken.flag.is_empty()) else {
            return false;
        };
        let by = match jumped.channel {
            Channel::Force => format!("{:.2} N", jumped.by),
            _ => format!("{:.1} um", jumped.by * 1e6),
        };
        let text = format!(
            "the {} gauge jumped by {by} while the other did not move: back to the preload to check its zero",
            jumped.channel
        );
        self.message(text, true, out);
        out.push(Action::Bell(Bell::Attention));
        self.unsure = true;
        self.jumped = true;
        self.reroute();
        true
    }

    /// Whether the value that would be kept now fails a check.
    pub(super) fn fails_a_check(&self, cell: usize, index: usize, rule: (&str, Channel)) -> bool {
        let taken = self.reading(cell, index);
        taken.is_none_or(|taken| {
            self.failed_checks(&taken)
                .iter()
                .any(|check| (check.rule, check.channel) == rule)
        })
    }

    /// What would be kept now; `None` if a gauge has nothing that stands for now.
    fn reading(&self, cell: usize, index: usize) -> Option<TakenReading> {
        let place = &self.plan.cells[cell];
        let planned = &place.readings[index];
        let load = self.load.as_ref()?;
        let zero = &self.state.zero.as_ref()?.set;
        let last = |channel: Channel| self.stream(channel).last.as_ref();
        let leading = self.plan.leading(cell);
        let (force, displacement) = (last(Channel::Force)?, last(leading)?);
        let force_n = tidy(self.value(Channel::Force)?, force.resolution_si);
        let displacement_m = tidy(self.value(leading)?, displacement.resolution_si);
        let along_axes = self
            .displacements()
            .filter(|channel| channel.axis().is_some());
        let gauges: Option<Vec<AxisReading>> = along_axes
            .map(|channel| {
                let sample = last(channel)?;
                let (_, zero_m) = self.state.axis(channel);
                Some(AxisReading {
                    channel,
                    displacement_m: tidy(self.value(channel)?, sample.resolution_si),
                    raw: sample.raw.to_string(),
                    zero_m: zero_m + 0.0,
                    at_s: sample.at_s,
                })
            })
            .collect();
        let (_, leading_zero_m) = self.state.axis(leading);
        let accepted = load.accepted.iter();
        let accepted = accepted.map(|(rule, channel)| match channel.axis() {
            None => format!("{rule}: accepted by the operator"),
            Some(axis) => format!("{rule} along {axis}: accepted by the operator"),
        });
        let standing = [self.standing_flag.clone(), zero.flag.clone()];
        let standing = standing.into_iter().filter(|flag| !flag.is_empty());
        let limits = &self.plan.procedure.limits;
        let others_m = gauges.iter().flatten().map(|gauge| gauge.displacement_m);
        let (verdict, exceeded) = limits.verdict(force_n, others_m.chain([displacement_m]));
        let checked = LimitCheck {
            verdict,
            exceeded: exceeded.unwrap_or_default(),
        };
        let flags: Vec<String> = accepted.chain(standing).collect();
        Some(TakenReading {
            number: self.state.readings.len() as u32 + 1,
            cell,
            index,
            pose: place.pose.to_string(),
            direction: place.direction.clone(),
            branch: planned.branch,
            step: planned.step,
            repeat: planned.repeat,
            attempt: self.state.attempts(cell, index) + 1,
            zero: zero.label.clone(),
            target_n: planned.target_n,
            force_n,
            force_raw: force.raw.to_string(),
            displacement_m,
            displacement_raw: displacement.raw.to_string(),
            zero_si: Some([zero.force_offset_n + 0.0, leading_zero_m + 0.0]),
            samples_at_s: [force.at_s, displacement.at_s],
            hold_s: load
                .reached_s
                .map_or(0.0, |reached_s| self.now_s - reached_s),
            approached_from_n: load.from_n.unwrap_or(0.0),
            overshoot_n: load.overshoot_n,
            temperature_deg_c: self.state.temperature_deg_c,
            flag: flags.join("; "),
            gauges: gauges?,
            raw_bytes: self.raw_bytes(),
            limits: (!limits.is_empty()).then_some(checked),
        })
    }

    /// Where the last values lie in the traces.
    fn raw_bytes(&self) -> Vec<RawBytes> {
        let kept = self.feeds.iter().filter_map(|stream| {
            let file = &self.settings.traces[stream.channel.index()];
            let sample = stream.last.as_ref().filter(|_| !file.is_empty())?;
            Some(RawBytes {
                channel: stream.channel,
                file: file.clone(),
                from: sample.bytes[0],
                to: sample.bytes[1],
            })
        });
        kept.collect()
    }

    fn ask_capture_check(&mut self, capture_check: &CaptureCheck, out: &mut Vec<Action>) {
        let accept = ("accept", "take it as it is; the reading is flagged");
        let again = (
            "again",
            "something was wrong and is corrected: settle again",
        );
        let skip = ("skip", "leave this reading out");
        let flip = ("flip", "the gauge is on the other side: reverse its sign");
        let mut choices = vec![again, accept, skip];
        if capture_check.rule == "displacement-sign" && !self.has_loaded_readings() {
            choices.push(flip);
        }
        self.stood_still = capture_check.still;
        let mut prompt = Prompt::choice(capture_check.rule, capture_check.text.clone(), &choices);
        let channel = capture_check.channel;
        prompt.key = channel.axis().map(|_| channel.to_string());
        self.ask(prompt, Why::CaptureCheck(capture_check.rule, channel), out);
    }

    /// Whether readings under load stand on the zero in use: their sign can no longer be turned.
    fn has_loaded_readings(&self) -> bool {
        let tolerance_n = self.plan.procedure.settle.force_tolerance_n;
        let mut on_it = self.state.on_zero();
        on_it.any(|kept| kept.taken.target_n.abs() > tolerance_n)
    }
}

/// A value without what taking off the zero left behind its last digits; a mean zero may stand between two of them.
fn tidy(value: f64, resolution: f64) -> f64 {
    let step = resolution / 1000.0;
    if step > 0.0 {
        (value / step).round() * step + 0.0
    } else {
        value
    }
}
