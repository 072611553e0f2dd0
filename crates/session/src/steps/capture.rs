//! Taking a reading: when it may be taken, and what must be asked before.

use crate::event::{Event, TakenReading};
use crate::operator::{Bell, Prompt};
use stiffbench_gauges::Channel;
use stiffbench_units_and_text::test_point::Branch;

use super::answers::Why;
use super::{Action, Applied, Machine};

/// A displacement text that stays the same while the force moves by this many tolerances is asked about.
const FROZEN_TOLERANCES: f64 = 4.0;

/// Or while the end must have moved by this many steps of the last digit.
const FROZEN_DIGITS: f64 = 5.0;

/// A displacement is far from its repeats beyond this many settling spreads and this share of their mean.
const FAR_FROM_REPEATS: (f64, f64) = (10.0, 0.25);

/// It is far from what the other loads of the cell let expect beyond this many settling spreads and this share.
const FAR_FROM_LINE: (f64, f64) = (20.0, 0.5);

/// Why a reading is not taken without a question.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Doubt {
    /// The rule, and the id of the prompt.
    pub(super) rule: &'static str,
    text: String,
}

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
            return settle.settled;
        };
        let held_s = load
            .reached_s
            .map_or(0.0, |reached_s| self.now_s - reached_s);
        let good = self.feeds.iter().all(|feed| feed.is_good(self.now_s));
        good && held_s >= hold_s && settle.dwell_s >= settle.dwell_needed_s
    }

    /// Takes the reading, or asks what has to be asked first.
    pub(super) fn capture(&mut self, cell: usize, index: usize, out: &mut Vec<Action>) {
        let Some(taken) = self.reading(cell, index) else {
            return;
        };
        let accepted = self.load.as_ref().map_or(&[][..], |load| &load.accepted);
        let doubts = self.doubts(&taken);
        let open = doubts
            .into_iter()
            .find(|doubt| !accepted.contains(&doubt.rule));
        if let Some(doubt) = open {
            self.ask_doubt(&doubt, out);
            return;
        }
        self.applied = Some(Applied {
            cell,
            repeat: taken.repeat,
            step: taken.step,
        });
        self.note_shown();
        let text = format!(
            "reading {}: {:.2} N, {:.1} um",
            taken.number,
            taken.force_n,
            taken.displacement_m * 1e6
        );
        self.record(Event::Reading(Box::new(taken)), out);
        out.push(Action::Bell(Bell::Captured));
        self.say(text, out);
        self.done();
    }

    /// What would be kept now; `None` if a gauge has nothing that stands for now.
    fn reading(&self, cell: usize, index: usize) -> Option<TakenReading> {
        let place = &self.plan.cells[cell];
        let planned = &place.readings[index];
        let load = self.load.as_ref()?;
        let zero = &self.state.zero.as_ref()?.set;
        let last = |channel: Channel| self.feed(channel).last.as_ref();
        let (force, displacement) = (last(Channel::Force)?, last(Channel::Displacement)?);
        let force_n = tidy(self.value(Channel::Force)?, force.resolution_si);
        let displacement_m = tidy(
            self.value(Channel::Displacement)?,
            displacement.resolution_si,
        );
        let flags: Vec<String> = load
            .accepted
            .iter()
            .map(|rule| format!("{rule}: accepted by the operator"))
            .collect();
        Some(TakenReading {
            number: self.state.readings.len() as u32 + 1,
            cell,
            index,
            pose: place.pose.to_string(),
            direction: place.direction,
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
            samples_at_s: [force.at_s, displacement.at_s],
            hold_s: load
                .reached_s
                .map_or(0.0, |reached_s| self.now_s - reached_s),
            approached_from_n: load.from_n.unwrap_or(0.0),
            overshoot_n: load.overshoot_n,
            temperature_deg_c: self.state.temperature_deg_c,
            flag: flags.join("; "),
        })
    }

    /// What speaks against taking a reading silently.
    fn doubts(&self, taken: &TakenReading) -> Vec<Doubt> {
        let rules = [
            self.frozen(taken),
            self.wrong_way(taken),
            self.implausible(taken),
        ];
        rules.into_iter().flatten().collect()
    }

    fn frozen(&self, taken: &TakenReading) -> Option<Doubt> {
        let ([force_before, _], at_s) = self.before?;
        let settle = &self.plan.procedure.settle;
        let force = self.feed(Channel::Force).last.as_ref()?;
        let moved_n = (force.value_si - force_before).abs();
        let displacement = self.feed(Channel::Displacement);
        let since_s = displacement.same_since_s;
        let digit_m = displacement.last.as_ref()?.resolution_si;
        let seen = self
            .compliance_m_per_n(taken.cell)
            .is_some_and(|compliance| {
                moved_n > settle.force_tolerance_n && compliance * moved_n > FROZEN_DIGITS * digit_m
            });
        let much = moved_n > FROZEN_TOLERANCES * settle.force_tolerance_n;
        let frozen = since_s <= at_s && (much || seen);
        frozen.then(|| Doubt {
            rule: "frozen",
            text: format!(
                "The displacement gauge has shown {} for {:.0} s while the force moved by {moved_n:.1} N: hold, or not touching?",
                taken.displacement_raw,
                self.now_s - since_s
            ),
        })
    }

    /// About how far the end of a cell gives way, as far as its readings or the push by hand told, m/N.
    fn compliance_m_per_n(&self, cell: usize) -> Option<f64> {
        let tolerance_n = self.plan.procedure.settle.force_tolerance_n;
        let kept = self.state.readings.iter().rev();
        let mut loaded = kept
            .filter(|kept| kept.superseded.is_none() && kept.taken.cell == cell)
            .filter(|kept| kept.taken.force_n.abs() > FROZEN_TOLERANCES * tolerance_n);
        let measured = loaded
            .next()
            .map(|kept| (kept.taken.displacement_m / kept.taken.force_n).abs());
        let pushed = self.pushed.filter(|(pushed, _)| *pushed == cell);
        measured.or(pushed.map(|(_, compliance)| compliance))
    }

    fn wrong_way(&self, taken: &TakenReading) -> Option<Doubt> {
        let settle = &self.plan.procedure.settle;
        // The displacement counts from the preload: without load the end has moved back.
        let moved_n = taken.force_n - self.plan.procedure.preload_n;
        let clear = moved_n.abs() > settle.force_tolerance_n
            && taken.displacement_m.abs() > FAR_FROM_REPEATS.0 * settle.spread_m;
        let against = moved_n * taken.displacement_m < 0.0;
        (clear && against).then(|| Doubt {
            rule: "displacement-sign",
            text: format!(
                "The end moves by {:.1} um against a force of {:.1} N.",
                taken.displacement_m * 1e6,
                taken.force_n
            ),
        })
    }

    fn implausible(&self, taken: &TakenReading) -> Option<Doubt> {
        let spread_m = self.plan.procedure.settle.spread_m;
        let accepted = || {
            let all = self
                .state
                .readings
                .iter()
                .filter(|k| k.superseded.is_none());
            all.map(|kept| &kept.taken)
                .filter(|other| other.cell == taken.cell)
        };
        let repeats: Vec<f64> = accepted()
            .filter(|other| (other.step, other.branch) == (taken.step, taken.branch))
            .filter(|other| other.target_n == taken.target_n)
            .map(|other| other.displacement_m)
            .collect();
        let (expected_m, (spreads, share), what) = if repeats.len() >= 2 {
            let mean_m = repeats.iter().sum::<f64>() / repeats.len() as f64;
            (mean_m, FAR_FROM_REPEATS, "its repeats")
        } else {
            let loading = accepted().filter(|other| other.branch == Branch::Loading);
            let points = loading.map(|other| (other.force_n, other.displacement_m));
            let line_m = on_line(&points.collect::<Vec<_>>(), taken.force_n)?;
            (line_m, FAR_FROM_LINE, "the other loads")
        };
        let off_m = (taken.displacement_m - expected_m).abs();
        let far = off_m > (spreads * spread_m).max(share * expected_m.abs());
        far.then(|| Doubt {
            rule: "implausible",
            text: format!(
                "{:.1} um at {:.1} N is {:.0} um off what {what} let expect.",
                taken.displacement_m * 1e6,
                taken.force_n,
                off_m * 1e6
            ),
        })
    }

    fn ask_doubt(&mut self, doubt: &Doubt, out: &mut Vec<Action>) {
        let accept = ("accept", "take it as it is; the reading is flagged");
        let again = (
            "again",
            "something was wrong and is put right: settle again",
        );
        let skip = ("skip", "leave this reading out");
        let flip = ("flip", "the gauge stands on the other side: turn its sign");
        let mut choices = vec![accept, again, skip];
        if doubt.rule == "displacement-sign" && !self.has_loaded_readings() {
            choices.push(flip);
        }
        let prompt = Prompt::choice(doubt.rule, doubt.text.clone(), &choices);
        self.ask(prompt, Why::Doubt(doubt.rule), out);
    }

    /// Whether readings under load stand on the zero in use: their sign can no longer be turned.
    fn has_loaded_readings(&self) -> bool {
        let Some(zero) = self.state.zero.as_ref() else {
            return false;
        };
        let tolerance_n = self.plan.procedure.settle.force_tolerance_n;
        self.state.readings.iter().any(|kept| {
            kept.superseded.is_none()
                && kept.taken.cell == zero.set.cell
                && kept.taken.zero == zero.set.label
                && kept.taken.target_n.abs() > tolerance_n
        })
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

/// Where the least-squares line through (force, displacement) lies at a force; `None` below three points or with forces all alike.
fn on_line(points: &[(f64, f64)], force_n: f64) -> Option<f64> {
    let n = points.len() as f64;
    let mean_n = points.iter().map(|point| point.0).sum::<f64>() / n;
    let mean_m = points.iter().map(|point| point.1).sum::<f64>() / n;
    let sxx: f64 = points.iter().map(|point| (point.0 - mean_n).powi(2)).sum();
    let sxy: f64 = points
        .iter()
        .map(|point| (point.0 - mean_n) * (point.1 - mean_m))
        .sum();
    let told = points.len() >= 3 && sxx > 1.0;
    told.then(|| mean_m + sxy / sxx * (force_n - mean_n))
}
