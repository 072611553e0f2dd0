//! One gauge as a session sees it: what came lately, how old it is, and why it may not be used.

use std::collections::VecDeque;

use stiffbench_gauges::{Channel, LinkState, Rejected, Sample};

use super::digits::{FewDigits, LastDigits};
use super::flicker::Flicker;
use super::link_text::link_text;

/// Values kept for a window, at most: 20 s at the 250 a second that the fastest gauges stream.
const MOST_KEPT: usize = 5000;

/// Intervals between samples that the period is the median of.
const INTERVALS: usize = 15;

/// A gauge is stale after this many sample periods without a value.
const STALE_PERIODS: f64 = 3.0;

/// Time for which a trouble that comes again and again is shown after each time, s.
const TROUBLE_STAYS_S: f64 = 1.5;

/// A trouble that was absent for so long is reported again, s.
const SAID_AGAIN_S: f64 = 10.0;

/// Two steps of the last digit that differ by less than this share are the same.
const SAME_DIGIT: f64 = 0.01;

/// A unit that stays for so many packets was set at the panel; one that comes in turn with another does not stay.
const PACKETS_OF_A_SETTING: u32 = 3;

/// Changes of the unit, none of which stayed, from which a gauge sends its units in turn: nobody turns a panel so often so fast.
const TURNS: u32 = 3;

/// A value that is further from the middle than this many times the usual distance stands apart: four standard deviations of normal noise
/// are 5.9 times the median distance.
const TYPICAL: f64 = 6.0;

/// And further than this many steps of the last digit: a gauge without noise flickers by one.
const TYPICAL_DIGITS: f64 = 3.0;

/// Summary of a window of samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Window {
    /// Number of samples.
    pub(super) n: usize,
    /// Mean, N or m in the sign as sent.
    pub(super) mean: f64,
    /// Largest minus smallest, N or m.
    pub(super) spread: f64,
    /// Least-squares slope, N/s or m/s; 0 for samples at one time.
    pub(super) slope_per_s: f64,
}

/// One gauge, live.
#[derive(Debug, Clone)]
pub(super) struct GaugeStream {
    pub(super) channel: Channel,
    /// Time and value as sent, oldest first.
    kept: VecDeque<(f64, f64)>,
    intervals: VecDeque<f64>,
    pub(super) last: Option<Sample>,
    /// Its last digits.
    digits: LastDigits,
    /// When its text changed since the last certain moment, s.
    changes: VecDeque<f64>,
    flicker: Flicker,
    /// Why nothing of this gauge may be used.
    pub(super) blocked: Option<String>,
    /// Why something of it was last refused, and when, s.
    refused: Option<(String, f64)>,
    /// Whether its values are refused, not its line gone.
    rejects: bool,
    /// The unit it has to be in.
    pub(super) unit: Option<Box<str>>,
    /// The step of its last digit that it began with, N or m.
    digit: Option<f64>,
    /// The unit of its last packet, for how many packets it stayed, and how many changes came before of which none stayed.
    turns: (Box<str>, u32, u32),
    /// Time and value as sent since the last certain moment, oldest first; no gap clears them.
    history: VecDeque<(f64, f64)>,
    /// Smallest and largest value since the task began, as sent.
    extremes: Option<[f64; 2]>,
    /// Shortest time after which a gauge counts as stale, s.
    pub(super) least_stale_s: f64,
}

impl GaugeStream {
    pub(super) fn new(channel: Channel, least_stale_s: f64) -> Self {
        Self {
            channel,
            kept: VecDeque::new(),
            intervals: VecDeque::new(),
            last: None,
            digits: LastDigits::default(),
            changes: VecDeque::new(),
            flicker: Flicker::default(),
            blocked: None,
            refused: None,
            rejects: false,
            unit: None,
            digit: None,
            turns: Default::default(),
            history: VecDeque::new(),
            extremes: None,
            least_stale_s,
        }
    }

    /// Whether it has another unit or number of decimals than before.
    pub(super) fn is_set_otherwise(&self, sample: &Sample) -> bool {
        let unit = self.unit.as_ref().is_some_and(|unit| *unit != sample.unit);
        let other = |digit: f64| (sample.resolution_si / digit - 1.0).abs() > SAME_DIGIT;
        unit || self.digit.is_some_and(other)
    }

    /// Whether a value is in the other unit of a gauge that sends two in turn, as dual displays do: the session stays with the unit it has.
    pub(super) fn is_of_another_turn(&mut self, sample: &Sample) -> bool {
        let (unit, stayed, turns) = &mut self.turns;
        if *unit == sample.unit {
            *stayed += 1;
            if *stayed >= PACKETS_OF_A_SETTING {
                *turns = 0;
            }
        } else {
            *turns += u32::from(!unit.is_empty());
            *unit = sample.unit.clone();
            *stayed = 1;
        }
        *turns >= TURNS && self.unit.as_ref().is_some_and(|own| *own != sample.unit)
    }

    /// Takes a value; `Err` with the reason if the gauge has changed its unit or its number of decimals.
    pub(super) fn sample(&mut self, sample: Sample) -> Result<(), String> {
        if let Some(unit) = self.unit.as_ref().filter(|unit| **unit != sample.unit) {
            return Err(format!(
                "the {} gauge sends {} and was in {unit}: set it back to {unit} at its panel",
                self.channel, sample.unit
            ));
        }
        self.unit.get_or_insert_with(|| sample.unit.clone());
        let digit = *self.digit.get_or_insert(sample.resolution_si);
        if (sample.resolution_si / digit - 1.0).abs() > SAME_DIGIT {
            return Err(format!(
                "the {} gauge sends {} and had another number of decimals: set its unit and its resolution back at its panel",
                self.channel,
                sample.raw.trim()
            ));
        }
        if let Some(last) = &self.last {
            let interval_s = sample.at_s - last.at_s;
            if interval_s > self.stale_after_s() || interval_s < 0.0 {
                self.kept.clear();
            }
            if interval_s >= 0.0 {
                self.intervals.push_back(interval_s);
            }
            if self.intervals.len() > INTERVALS {
                self.intervals.pop_front();
            }
            if last.raw != sample.raw {
                if self.changes.len() == MOST_KEPT {
                    self.changes.pop_front();
                }
                self.changes.push_back(sample.at_s);
                self.digits
                    .change(sample.at_s, sample.value_si, sample.resolution_si);
            }
        }
        if self.kept.len() == MOST_KEPT {
            self.kept.pop_front();
        }
        let value = sample.value_si;
        if self.history.len() == MOST_KEPT {
            self.history.pop_front();
        }
        self.history.push_back((sample.at_s, value));
        self.kept.push_back((sample.at_s, value));
        let [low, high] = self.extremes.unwrap_or([value, value]);
        self.extremes = Some([low.min(value), high.max(value)]);
        self.last = Some(sample);
        self.blocked = None;
        self.rejects = false;
        Ok(())
    }

    /// Takes bytes that are no value: nothing before them counts any more.
    pub(super) fn reject(&mut self, rejected: &Rejected, now_s: f64) {
        self.refuse(
            format!("{} gauge: {}", self.channel, rejected.reason),
            now_s,
        );
    }

    /// Whether it has a line and its values are refused.
    pub(super) fn is_refused(&self) -> bool {
        self.blocked.is_some() && self.rejects
    }

    /// Whether a reason was reported already and still holds.
    pub(super) fn is_reported(&self, reason: &str, now_s: f64) -> bool {
        let refused = self.refused.as_ref();
        refused.is_some_and(|(said, at_s)| said.contains(reason) && now_s - at_s < SAID_AGAIN_S)
    }

    /// What is wrong with it now, or was until a moment ago.
    pub(super) fn trouble(&self, now_s: f64) -> Option<&str> {
        let refused = self.refused.as_ref();
        let lately = refused.filter(|(_, at_s)| now_s - at_s < TROUBLE_STAYS_S);
        let lately = lately.map(|(reason, _)| reason.as_str());
        self.blocked.as_deref().or(lately)
    }

    /// Takes a change of the line.
    pub(super) fn link(&mut self, state: &LinkState, now_s: f64) {
        let text = link_text(state);
        match state {
            LinkState::Connected { .. } => {
                self.blocked = None;
                self.forget();
            }
            _ => self.block(format!("{} gauge: {text}", self.channel), now_s),
        }
    }

    /// Its values must not be used, and it may be asked why.
    pub(super) fn refuse(&mut self, reason: String, now_s: f64) {
        self.block(reason, now_s);
        self.rejects = true;
    }

    fn block(&mut self, reason: String, now_s: f64) {
        self.blocked = Some(reason.clone());
        self.refused = Some((reason, now_s));
        self.rejects = false;
        self.forget();
    }

    /// Starts the window afresh: what came before does not belong to what comes now.
    pub(super) fn forget(&mut self) {
        self.kept.clear();
        self.extremes = None;
    }

    /// Earlier values do not apply to later ones: the gauge was zeroed, or was away.
    pub(super) fn begin_history(&mut self) {
        self.history.clear();
        self.changes.clear();
    }

    /// The unit and the step of the last digit that it had when the session was interrupted.
    pub(super) fn expect(&mut self, unit: &str, digit: f64) {
        self.unit = Some(unit.into());
        self.digit = (digit > 0.0).then_some(digit);
    }

    /// Another gauge, or another unit, from the next value on.
    pub(super) fn forget_settings(&mut self) {
        self.unit = None;
        self.digit = None;
    }

    /// The values from `from_s` to `to_s`, those on the limits included.
    pub(super) fn between(&self, from_s: f64, to_s: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        let first = self.history.partition_point(|(at_s, _)| *at_s < from_s);
        let values = self.history.range(first..).copied();
        values.take_while(move |(at_s, _)| *at_s <= to_s)
    }

    /// The value that stood at a time, or the first there is.
    pub(super) fn value_at(&self, at_s: f64) -> Option<f64> {
        let behind = self.history.partition_point(|(of_s, _)| *of_s <= at_s);
        let (_, value) = self.history.get(behind.saturating_sub(1))?;
        Some(*value)
    }

    /// How many values there are since `from_s`, and how many of them differ from the one before.
    fn changed(&self, from_s: f64) -> (usize, usize) {
        let values = self.between(from_s, f64::INFINITY).count();
        let changes = self.changes.len() - self.changes.partition_point(|at_s| *at_s < from_s);
        (values, changes)
    }

    /// Keeps the last digits of a display at rest.
    pub(super) fn learn_digits(&mut self) {
        if let Some(last) = &self.last {
            self.digits
                .rest(last.at_s, last.value_si, last.resolution_si);
        }
    }

    /// Whether it uses few last digits, apart from the values where it is wanted to stand.
    pub(super) fn few_digits(&self, is_wanted: impl Fn(f64) -> bool) -> Option<FewDigits> {
        let last = self.last.as_ref()?;
        self.digits
            .coarse_steps(last.value_si, last.resolution_si, is_wanted)
    }

    /// Learns how a display that stands still flickers, from a rest that began at `from_s`.
    pub(super) fn learn_flicker(&mut self, from_s: f64) {
        let (values, changes) = self.changed(from_s);
        let digit = self.last.as_ref().map_or(0.0, |last| last.resolution_si);
        let digits = self.range(from_s, f64::INFINITY) / digit;
        self.flicker.learn(values, changes, digits);
    }

    /// How likely it is that a display that flickers as this one does changes its text so seldom since `from_s`, or no more.
    pub(super) fn chance_of_stillness(&self, from_s: f64) -> f64 {
        let (values, changes) = self.changed(from_s);
        let changed_s = self.changes.back().map_or(from_s, |at_s| at_s.max(from_s));
        let still = self.between(changed_s, f64::INFINITY).skip(1).count();
        self.flicker.chance(values, changes, still)
    }

    /// Since when it has shown its last value, give or take `band`.
    pub(super) fn still_since_s(&self, band: f64) -> Option<f64> {
        let now = self.last.as_ref()?.value_si;
        let mut since_s = None;
        for (at_s, value) in self.history.iter().rev() {
            if (value - now).abs() > band {
                break;
            }
            since_s = Some(*at_s);
        }
        since_s
    }

    /// The middle value from `from_s` to `to_s`; `None` for fewer than two.
    pub(super) fn median(&self, from_s: f64, to_s: f64) -> Option<f64> {
        let mut values: Vec<f64> = self.between(from_s, to_s).map(|(_, value)| value).collect();
        values.sort_by(f64::total_cmp);
        (values.len() >= 2).then(|| values[values.len() / 2])
    }

    /// Largest less smallest value from `from_s` to `to_s`.
    pub(super) fn range(&self, from_s: f64, to_s: f64) -> f64 {
        let values = self.between(from_s, to_s).map(|(_, value)| value);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        (high - low).max(0.0)
    }

    /// Whether the last value lies among those since `from_s`: one that stands apart is an error of the line, or not settled.
    pub(super) fn is_last_typical(&self, from_s: f64) -> bool {
        let Some(last) = &self.last else {
            return false;
        };
        let Some(median) = self.median(from_s, last.at_s) else {
            return false;
        };
        let mut off: Vec<f64> = self
            .between(from_s, last.at_s)
            .map(|(_, value)| (value - median).abs())
            .collect();
        off.sort_by(f64::total_cmp);
        let usual = off[off.len() / 2];
        (last.value_si - median).abs() <= TYPICAL * usual + TYPICAL_DIGITS * last.resolution_si
    }

    /// Time since the last value, s.
    pub(super) fn age_s(&self, now_s: f64) -> Option<f64> {
        self.last.as_ref().map(|last| (now_s - last.at_s).max(0.0))
    }

    /// Median interval between values, s.
    pub(super) fn period_s(&self) -> Option<f64> {
        let mut intervals: Vec<f64> = self.intervals.iter().copied().collect();
        intervals.sort_by(f64::total_cmp);
        intervals.get(intervals.len() / 2).copied()
    }

    fn stale_after_s(&self) -> f64 {
        let periods_s = self
            .period_s()
            .map_or(0.0, |period_s| STALE_PERIODS * period_s);
        periods_s.max(self.least_stale_s)
    }

    /// Whether the last value is too old to stand for now; true without any.
    pub(super) fn is_stale(&self, now_s: f64) -> bool {
        self.age_s(now_s)
            .is_none_or(|age_s| age_s > self.stale_after_s())
    }

    /// Whether there is a value that stands for now.
    pub(super) fn is_good(&self, now_s: f64) -> bool {
        self.blocked.is_none() && !self.is_stale(now_s) && !self.kept.is_empty()
    }

    /// Smallest and largest value since the task began, as sent.
    pub(super) fn extremes(&self) -> Option<[f64; 2]> {
        self.extremes
    }

    /// Summary of the samples from `from_s` on; `None` below three.
    pub(super) fn window(&self, from_s: f64) -> Option<Window> {
        let first = self.kept.partition_point(|(at_s, _)| *at_s < from_s);
        let n = self.kept.len() - first;
        if n < 3 {
            return None;
        }
        let window = || self.kept.range(first..);
        let count = n as f64;
        let mean_s = window().map(|(at_s, _)| at_s).sum::<f64>() / count;
        let mean = window().map(|(_, value)| value).sum::<f64>() / count;
        let (mut stt, mut stv) = (0.0, 0.0);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (at_s, value) in window() {
            stt += (at_s - mean_s).powi(2);
            stv += (at_s - mean_s) * (value - mean);
            (low, high) = (low.min(*value), high.max(*value));
        }
        Some(Window {
            n,
            mean,
            spread: high - low,
            slope_per_s: if stt > 0.0 { stv / stt } else { 0.0 },
        })
    }

    /// Where a window of `length_s` that ends now has to begin, so that it holds at least three samples.
    pub(super) fn window_from_s(&self, length_s: f64, now_s: f64) -> f64 {
        let third = self
            .kept
            .len()
            .checked_sub(3)
            .and_then(|at| self.kept.get(at));
        third.map_or(now_s - length_s, |(at_s, _)| at_s.min(now_s - length_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiffbench_units_and_text::quantity::Kind;

    fn sample(at_s: f64, value: f64) -> Sample {
        Sample {
            kind: Kind::Displacement,
            value_si: value,
            resolution_si: 1e-6,
            value: value * 1e3,
            unit: "mm".into(),
            raw: format!("{:.3} mm", value * 1e3).into(),
            at_s,
            bytes: [0; 2],
            marks: Vec::new(),
        }
    }

    #[test]
    fn slope_and_spread_by_hand() {
        let mut stream = GaugeStream::new(Channel::Displacement, 0.5);
        for (at_s, value) in [(0.0, 9.0), (1.0, 1.0), (2.0, 3.0), (3.0, 5.0), (4.0, 5.0)] {
            stream.least_stale_s = 2.0;
            stream.sample(sample(at_s, value)).unwrap();
        }
        let window = stream.window(1.0).unwrap();
        // Times 1 2 3 4 about 2.5, values 1 3 5 5 about 3.5: (3.75 + 0.25 + 0.75 + 2.25)/5.
        assert_eq!((window.n, window.mean, window.spread), (4, 3.5, 4.0));
        assert!((window.slope_per_s - 1.4).abs() < 1e-12);
        assert_eq!(stream.window(3.0), None);
    }

    #[test]
    fn a_gauge_is_stale_after_three_periods_and_a_gap_clears_the_window() {
        let mut stream = GaugeStream::new(Channel::Force, 0.1);
        assert!(stream.is_stale(0.0));
        for i in 0..10 {
            stream.sample(sample(f64::from(i) * 0.1, 0.0)).unwrap();
        }
        assert!(!stream.is_stale(1.15) && stream.is_stale(1.25));
        assert!(stream.window(0.0).is_some());
        stream.sample(sample(2.0, 0.0)).unwrap();
        assert_eq!(stream.window(0.0), None);
    }

    #[test]
    fn another_unit_is_refused_and_a_value_clears_what_was_wrong() {
        let mut stream = GaugeStream::new(Channel::Displacement, 0.1);
        stream.sample(sample(0.0, 1.0)).unwrap();
        let mut inch = sample(0.1, 1.0);
        inch.unit = "in".into();
        let reason = stream.sample(inch).unwrap_err();
        assert!(reason.contains("sends in and was in mm"), "{reason}");
        stream.block(reason, 0.1);
        assert!(!stream.is_good(0.1));
        stream.sample(sample(0.2, 1.0)).unwrap();
        assert!(stream.is_good(0.2));
    }

    #[test]
    fn of_two_units_in_turn_the_first_is_read_until_one_stays() {
        let mut stream = GaugeStream::new(Channel::Displacement, 0.1);
        let mut left_out = |unit: &str| {
            let mut value = sample(0.0, 1.0);
            value.unit = unit.into();
            let left_out = stream.is_of_another_turn(&value);
            if unit == "mm" {
                stream.sample(value).unwrap();
            }
            left_out
        };
        let turns = ["mm", "in", "mm", "in", "mm", "in", "in"];
        let expected = [false, false, false, true, false, true, true];
        assert_eq!(turns.map(&mut left_out), expected);
        // The third of a unit in a row: it was set at the panel.
        assert_eq!(["in", "mm", "in"].map(left_out), [false; 3]);
    }
}
