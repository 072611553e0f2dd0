//! One gauge as a session sees it: what came lately, how old it is, and why it may not be used.

use std::collections::VecDeque;

use stiffbench_gauges::{Channel, LinkState, Rejected, Sample};

/// Values kept for a window, at most: 20 s at the 250 a second that the fastest gauges stream.
const MOST_KEPT: usize = 5000;

/// Intervals between samples that the period is the median of.
const INTERVALS: usize = 15;

/// A gauge is stale after this many sample periods without a value.
const STALE_PERIODS: f64 = 3.0;

/// What a window of samples says.
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
pub(super) struct Feed {
    pub(super) channel: Channel,
    /// Time and value as sent, oldest first.
    kept: VecDeque<(f64, f64)>,
    intervals: VecDeque<f64>,
    pub(super) last: Option<Sample>,
    /// Why nothing of this gauge may be used.
    pub(super) blocked: Option<String>,
    /// The unit it has to be in.
    pub(super) unit: Option<Box<str>>,
    /// Since when it has sent the same text, and the text.
    pub(super) same_since_s: f64,
    /// Smallest and largest value since the task began, as sent.
    extremes: Option<[f64; 2]>,
    /// Shortest time after which a gauge counts as stale, s.
    pub(super) least_stale_s: f64,
}

impl Feed {
    pub(super) fn new(channel: Channel, least_stale_s: f64) -> Self {
        Self {
            channel,
            kept: VecDeque::new(),
            intervals: VecDeque::new(),
            last: None,
            blocked: None,
            unit: None,
            same_since_s: 0.0,
            extremes: None,
            least_stale_s,
        }
    }

    /// Takes a value; `Err` with the reason if the gauge has changed its unit.
    pub(super) fn sample(&mut self, sample: Sample) -> Result<(), String> {
        if let Some(unit) = self.unit.as_ref().filter(|unit| **unit != sample.unit) {
            return Err(format!(
                "the {} gauge sends {} and was in {unit}: set it back to {unit} at its panel",
                self.channel, sample.unit
            ));
        }
        self.unit.get_or_insert_with(|| sample.unit.clone());
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
                self.same_since_s = sample.at_s;
            }
        } else {
            self.same_since_s = sample.at_s;
        }
        if self.kept.len() == MOST_KEPT {
            self.kept.pop_front();
        }
        let value = sample.value_si;
        self.kept.push_back((sample.at_s, value));
        let [low, high] = self.extremes.unwrap_or([value, value]);
        self.extremes = Some([low.min(value), high.max(value)]);
        self.last = Some(sample);
        self.blocked = None;
        Ok(())
    }

    /// Takes bytes that are no value: nothing before them counts any more.
    pub(super) fn reject(&mut self, rejected: &Rejected) {
        self.block(format!("{} gauge: {}", self.channel, rejected.reason));
    }

    /// Takes a change of the line.
    pub(super) fn link(&mut self, state: &LinkState) {
        let text = link_text(state);
        match state {
            LinkState::Connected { .. } => {
                self.blocked = None;
                self.forget();
            }
            _ => self.block(format!("{} gauge: {text}", self.channel)),
        }
    }

    pub(super) fn block(&mut self, reason: String) {
        self.blocked = Some(reason);
        self.forget();
    }

    /// Starts the window afresh: what came before does not belong to what comes now.
    pub(super) fn forget(&mut self) {
        self.kept.clear();
        self.extremes = None;
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

    /// What the samples from `from_s` on say; `None` below three.
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

/// How a line stands, in words.
pub(super) fn link_text(state: &LinkState) -> String {
    match state {
        LinkState::Connected { port } => format!("connected on {port}"),
        LinkState::Silent => {
            "connected, but nothing comes: switched off, asleep or in a menu?".to_owned()
        }
        LinkState::Lost { reason } => {
            format!("the line is gone ({reason}): check cable and adapter")
        }
        LinkState::Reconnecting { attempt } => format!("looking for it again, try {attempt}"),
        LinkState::WrongDevice { reason } => format!("something else answers: {reason}"),
        LinkState::GivenUp => {
            "not found again; plug it in and press p to look once more".to_owned()
        }
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
            marks: Vec::new(),
        }
    }

    #[test]
    fn slope_and_spread_by_hand() {
        let mut feed = Feed::new(Channel::Displacement, 0.5);
        for (at_s, value) in [(0.0, 9.0), (1.0, 1.0), (2.0, 3.0), (3.0, 5.0), (4.0, 5.0)] {
            feed.least_stale_s = 2.0;
            feed.sample(sample(at_s, value)).unwrap();
        }
        let window = feed.window(1.0).unwrap();
        // Times 1 2 3 4 about 2.5, values 1 3 5 5 about 3.5: (3.75 + 0.25 + 0.75 + 2.25)/5.
        assert_eq!((window.n, window.mean, window.spread), (4, 3.5, 4.0));
        assert!((window.slope_per_s - 1.4).abs() < 1e-12);
        assert_eq!(feed.window(3.0), None);
    }

    #[test]
    fn a_gauge_is_stale_after_three_periods_and_a_gap_clears_the_window() {
        let mut feed = Feed::new(Channel::Force, 0.1);
        assert!(feed.is_stale(0.0));
        for i in 0..10 {
            feed.sample(sample(f64::from(i) * 0.1, 0.0)).unwrap();
        }
        assert!(!feed.is_stale(1.15) && feed.is_stale(1.25));
        assert!(feed.window(0.0).is_some());
        feed.sample(sample(2.0, 0.0)).unwrap();
        assert_eq!(feed.window(0.0), None);
    }

    #[test]
    fn another_unit_is_refused_and_a_value_clears_what_was_wrong() {
        let mut feed = Feed::new(Channel::Displacement, 0.1);
        feed.sample(sample(0.0, 1.0)).unwrap();
        let mut inch = sample(0.1, 1.0);
        inch.unit = "in".into();
        let reason = feed.sample(inch).unwrap_err();
        assert!(reason.contains("sends in and was in mm"), "{reason}");
        feed.block(reason);
        assert!(!feed.is_good(0.1));
        feed.sample(sample(0.2, 1.0)).unwrap();
        assert!(feed.is_good(0.2));
    }
}
