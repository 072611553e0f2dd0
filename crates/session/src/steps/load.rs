//! Bringing the force to a target, and what settled means.

use crate::event::{Event, Superseded, ZeroMoment};
use crate::feed::Window;
use crate::operator::Prompt;
use crate::view::{Purpose, SettleView};
use stiffbench_gauges::Channel;

use super::answers::Why;
use super::{Action, Job, Machine};

/// Share of the largest load within which an unloaded gauge may be off before it is zeroed.
const FREE_SHARE: f64 = 0.05;

/// A force that is steady this many dwells long outside its band is asked about.
const STEADY_DWELLS: f64 = 3.0;

/// The force on its way to a target.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Loading {
    pub(super) target_n: f64,
    pub(super) tolerance_n: f64,
    pub(super) purpose: Purpose,
    /// The force when it began, N.
    pub(super) from_n: Option<f64>,
    began_s: f64,
    in_band_since_s: Option<f64>,
    /// When the band was first reached.
    pub(super) reached_s: Option<f64>,
    pub(super) overshoot_n: f64,
    /// Questions that have been asked once already.
    pub(super) asked: bool,
    /// Doubts that the operator has accepted.
    pub(super) accepted: Vec<&'static str>,
}

impl Loading {
    pub(super) fn is_in_band(&self) -> bool {
        self.in_band_since_s.is_some()
    }

    /// The dwell begins anew.
    pub(super) fn left_band(&mut self) {
        self.in_band_since_s = None;
    }

    /// Time without a break in the band, s.
    pub(super) fn dwell_s(&self, now_s: f64) -> f64 {
        self.in_band_since_s.map_or(0.0, |since_s| now_s - since_s)
    }

    /// Takes in a force, N.
    fn force(&mut self, force_n: f64, at_s: f64) {
        let from_n = *self.from_n.get_or_insert(force_n);
        if (force_n - self.target_n).abs() <= self.tolerance_n {
            self.in_band_since_s.get_or_insert(at_s);
            self.reached_s.get_or_insert(at_s);
        } else {
            self.in_band_since_s = None;
        }
        let past_n = (force_n - self.target_n) * (self.target_n - from_n).signum();
        if self.target_n != from_n {
            self.overshoot_n = self.overshoot_n.max(past_n);
        }
    }
}

impl Machine {
    pub(super) fn begin_load(&mut self, target_n: f64, purpose: Purpose, out: &mut Vec<Action>) {
        let on = self.load.take();
        // A hold goes on under the load that is on already: its time counts from when that was reached.
        let same = on.filter(|on| {
            purpose == Purpose::Reading && on.purpose == purpose && on.target_n == target_n
        });
        let tolerance_n = self.tolerance_n(purpose);
        self.loaded |= matches!(purpose, Purpose::Reading | Purpose::Again);
        if purpose == Purpose::Again {
            let text = format!("apply {target_n} N again; it is not recorded");
            self.say(text, out);
        }
        self.load = Some(match same.filter(|_| self.continues_a_load()) {
            Some(on) => Loading {
                accepted: Vec::new(),
                asked: false,
                ..on
            },
            None => Loading {
                target_n,
                tolerance_n,
                purpose,
                from_n: self.value(Channel::Force),
                began_s: self.now_s,
                in_band_since_s: None,
                reached_s: None,
                overshoot_n: 0.0,
                asked: false,
                accepted: Vec::new(),
            },
        });
    }

    /// Whether the reading to be taken is under the load of the reading before.
    fn continues_a_load(&self) -> bool {
        let Some(Job::Read { cell, index }) = self.job else {
            return false;
        };
        let wanted = &self.plan.cells[cell].readings[index];
        let on = self.applied;
        on.is_some_and(|on| (on.cell, on.repeat, on.step) == (cell, wanted.repeat, wanted.step))
    }

    fn tolerance_n(&self, purpose: Purpose) -> f64 {
        let tolerance_n = self.plan.procedure.settle.force_tolerance_n;
        match purpose {
            // The zero of the gauge is not known yet.
            Purpose::Free => tolerance_n.max(FREE_SHARE * self.plan.largest_n()),
            _ => tolerance_n,
        }
    }

    /// Takes in the last sample of a gauge.
    pub(super) fn watch_load(&mut self, channel: Channel) {
        let Some(force) = self.feed(channel).last.as_ref() else {
            return;
        };
        let (at_s, value_si) = (force.at_s, force.value_si);
        if channel == Channel::Force {
            let force_n = self.along(channel, value_si);
            if let Some(load) = &mut self.load {
                load.force(force_n, at_s);
            }
        }
    }

    pub(super) fn left_band(&mut self) {
        if let Some(load) = &mut self.load {
            load.left_band();
        }
    }

    /// How far the gauges have settled under the load; `None` without one.
    pub(super) fn settle(&self) -> Option<SettleView> {
        let load = self.load.as_ref()?;
        let limits = &self.plan.procedure.settle;
        let dwell_needed_s = limits.dwell_s;
        let in_band_s = load.in_band_since_s;
        let window = |channel: Channel| {
            let feed = self.feed(channel);
            let from_s = feed.window_from_s(dwell_needed_s, self.now_s);
            feed.window(in_band_s?.max(from_s))
        };
        let (force, displacement) = (window(Channel::Force), window(Channel::Displacement));
        let force_spread_limit_n = 2.0 * load.tolerance_n;
        // Across the band within one dwell.
        let force_slope_limit = force_spread_limit_n / dwell_needed_s.max(0.1);
        let dwell_s = load.dwell_s(self.now_s);
        let fresh = self.feeds.iter().all(|feed| feed.is_good(self.now_s));
        let quiet = |window: Option<Window>, spread: f64, slope: f64| {
            window.is_some_and(|w| w.spread <= spread && w.slope_per_s.abs() <= slope)
        };
        let settled = fresh
            && dwell_s >= dwell_needed_s
            && quiet(force, force_spread_limit_n, force_slope_limit)
            && quiet(displacement, limits.spread_m, limits.slope_m_per_s);
        Some(SettleView {
            dwell_s,
            dwell_needed_s,
            force_spread_n: force.map(|w| w.spread),
            force_spread_limit_n,
            force_slope_n_per_s: force.map(|w| w.slope_per_s),
            force_slope_limit_n_per_s: force_slope_limit,
            spread_m: displacement.map(|w| w.spread),
            spread_limit_m: limits.spread_m,
            slope_m_per_s: displacement.map(|w| w.slope_per_s),
            slope_limit_m_per_s: limits.slope_m_per_s,
            settled,
        })
    }

    /// Whether the load is as it must be for what it is for: a load on the way only needs to be reached and held.
    pub(super) fn is_settled(&self) -> bool {
        let (Some(load), Some(settle)) = (&self.load, self.settle()) else {
            return false;
        };
        match load.purpose {
            Purpose::Release => load.is_in_band() && self.feed(Channel::Force).is_good(self.now_s),
            Purpose::Again | Purpose::Free => {
                let fresh = self.feeds.iter().all(|feed| feed.is_good(self.now_s));
                fresh && settle.dwell_s >= settle.dwell_needed_s
            }
            Purpose::Preload | Purpose::Reading | Purpose::ZeroCheck => settle.settled,
        }
    }

    pub(super) fn work_load(&mut self, purpose: Purpose, out: &mut Vec<Action>) {
        if self.is_settled() {
            match purpose {
                Purpose::Again | Purpose::Reading => {}
                Purpose::Release | Purpose::Free | Purpose::Preload => self.released(),
                Purpose::ZeroCheck => {
                    self.released();
                    self.zero_looked_at(out);
                    return;
                }
            }
            self.done();
            return;
        }
        self.ask_about_a_steady_force(out);
    }

    fn released(&mut self) {
        self.applied = None;
        self.loaded = false;
    }

    /// A force that stays steady where it should not be: a gauge that is off, or one whose sign is the other way round.
    pub(super) fn ask_about_a_steady_force(&mut self, out: &mut Vec<Action>) {
        let Some(load) = self.load.as_ref().filter(|load| !load.asked) else {
            return;
        };
        let steady_s = STEADY_DWELLS * self.plan.procedure.settle.dwell_s;
        if load.is_in_band() || self.now_s - load.began_s < steady_s {
            return;
        }
        let feed = self.feed(Channel::Force);
        let window = feed.window(self.now_s - steady_s);
        let Some(window) = window.filter(|w| w.spread <= load.tolerance_n) else {
            return;
        };
        let force_n = self.along(Channel::Force, window.mean);
        let (target_n, purpose) = (load.target_n, load.purpose);
        let opposite = force_n * target_n < 0.0
            && (force_n + target_n).abs() <= (0.3 * target_n.abs()).max(load.tolerance_n);
        let asked = match purpose {
            Purpose::Free if feed.is_good(self.now_s) => {
                let prompt = Prompt::choice(
                    "force-offset",
                    format!("The force gauge shows {force_n:.2} N. Is it hanging free?"),
                    &[("zero", "it is free: zero it here"), ("wait", "wait")],
                );
                self.ask(prompt, Why::ForceOffset, out);
                true
            }
            Purpose::Reading | Purpose::Again | Purpose::Preload if opposite => {
                let prompt = Prompt::choice(
                    "force-sign",
                    format!("The force is {force_n:.1} N where {target_n:.1} N is wanted."),
                    &[
                        ("flip", "the gauge counts the other way round"),
                        ("wait", "the load is applied the wrong way: wait"),
                    ],
                );
                self.ask(prompt, Why::ForceSign, out);
                true
            }
            _ => false,
        };
        if let Some(load) = self.load.as_mut().filter(|_| asked) {
            load.asked = true;
        }
    }

    /// The zero was looked at: its drift is kept, and asked about where it is large.
    fn zero_looked_at(&mut self, out: &mut Vec<Action>) {
        let length_s = self.plan.procedure.settle.dwell_s;
        let feed = self.feed(Channel::Displacement);
        let window = feed.window(feed.window_from_s(length_s, self.now_s));
        let Some(zero) = self.state.zero.as_ref() else {
            self.done();
            return;
        };
        let Some(window) = window else {
            return;
        };
        let drift_m = self.along(Channel::Displacement, window.mean);
        let after_interruption = self.state.unconfirmed;
        let mut zeroed = zero.set.clone();
        let limit_m = self.settings.drift_limit_m;
        zeroed.drift_m = Some(drift_m);
        zeroed.moment = if after_interruption {
            ZeroMoment::Kept
        } else {
            ZeroMoment::After
        };
        let text = format!("the zero has moved by {:.1} um", drift_m * 1e6);
        if after_interruption && drift_m.abs() > limit_m {
            self.say(format!("{text}: the gauges are zeroed anew"), out);
            let mut jobs = Vec::new();
            if let Some((cell, index)) = self.plan.next_open(&self.state, self.focus) {
                self.zero(cell, index, &mut jobs);
            }
            self.queue = jobs.into();
            self.done();
            return;
        }
        self.say(text.clone(), out);
        self.record(Event::Zero(zeroed), out);
        self.done();
        if drift_m.abs() > limit_m {
            let prompt = Prompt::choice(
                "drift",
                format!("{text}, more than {:.0} um.", limit_m * 1e6),
                &[
                    ("keep", "keep the readings; the drift is in the record"),
                    ("redo", "take the readings on this zero once more"),
                ],
            );
            self.ask(prompt, Why::Drift, out);
        }
    }

    /// Every reading on the zero in use is to be taken once more.
    pub(super) fn redo_zero(&mut self, out: &mut Vec<Action>) {
        let Some(zero) = self.state.zero.as_ref() else {
            return;
        };
        let (cell, scope) = (zero.set.cell, zero.set.scope.clone());
        let label = zero.set.label.clone();
        let on_it = self.state.readings.iter().filter(|kept| {
            kept.superseded.is_none() && kept.taken.cell == cell && kept.taken.zero == label
        });
        let numbers: Vec<u32> = on_it.map(|kept| kept.taken.number).collect();
        for number in numbers {
            let reason = "the zero moved".to_owned();
            self.record(Event::Superseded(Superseded { number, reason }), out);
        }
        let readings = self.plan.cells[cell].readings.iter();
        let first = readings
            .map(|reading| self.plan.zero_scope(reading))
            .position(|of| of == scope);
        let mut jobs = Vec::new();
        self.zero(cell, first.unwrap_or(0), &mut jobs);
        self.reroute();
        self.queue = jobs.into();
    }
}
