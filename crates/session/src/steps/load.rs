//! Bringing the force to a target, and what settled means.

use crate::gauge_stream::Window;
use crate::operator::Prompt;
use crate::view::{Purpose, SettleView};
use stiffbench_gauges::Channel;
use stiffbench_units_and_text::test_point::Branch;

use super::answers::Why;
use super::{Action, Job, Machine};

/// Share of the largest load within which an unloaded gauge may be off before it is zeroed.
const FREE_SHARE: f64 = 0.05;

/// A load that is applied again gives the displacement of before within this share: play and creep.
const BEFORE_SHARE: f64 = 0.03;

/// A force that has left its band so often is unsteady, or its gauge is.
const UNSTEADY: u32 = 6;

/// A force that is steady this many dwells long outside its band is asked about.
const STEADY_DWELLS: f64 = 3.0;

/// The force on its way to a target.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LoadApproach {
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
    /// How often the force has left its band again.
    left: u32,
    /// Questions that have been asked once already.
    pub(super) asked: bool,
    /// Failed checks that the operator has accepted.
    pub(super) accepted: Vec<(&'static str, Channel)>,
}

impl LoadApproach {
    pub(super) fn is_in_band(&self) -> bool {
        self.in_band_since_s.is_some()
    }

    /// Whether the force goes in and out of its band.
    pub(super) fn is_unsteady(&self) -> bool {
        self.left >= UNSTEADY
    }

    /// The dwell restarts.
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
        } else if self.in_band_since_s.take().is_some() {
            self.left += 1;
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
            self.notify(text, out);
        }
        self.load = Some(match same.filter(|_| self.continues_a_load()) {
            Some(on) => LoadApproach {
                accepted: Vec::new(),
                asked: false,
                ..on
            },
            None => LoadApproach {
                target_n,
                tolerance_n,
                purpose,
                from_n: self.value(Channel::Force),
                began_s: self.now_s,
                in_band_since_s: None,
                reached_s: None,
                overshoot_n: 0.0,
                left: 0,
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

    pub(super) fn tolerance_n(&self, purpose: Purpose) -> f64 {
        let tolerance_n = self.plan.procedure.settle.force_tolerance_n;
        match purpose {
            // The zero of the gauge is not known yet.
            Purpose::Free => tolerance_n.max(FREE_SHARE * self.plan.largest_n()),
            _ => tolerance_n,
        }
    }

    /// Takes in the last sample of a gauge.
    pub(super) fn watch_load(&mut self, channel: Channel) {
        let Some(force) = self.stream(channel).last.as_ref() else {
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
            let stream = self.stream(channel);
            let from_s = stream.window_from_s(dwell_needed_s, self.now_s);
            stream.window(in_band_s?.max(from_s))
        };
        let force = window(Channel::Force);
        let displacements: Vec<Option<Window>> = self.displacements().map(window).collect();
        let force_spread_limit_n = 2.0 * load.tolerance_n;
        // Across the band within one dwell.
        let force_slope_limit = force_spread_limit_n / dwell_needed_s.max(0.1);
        let dwell_s = load.dwell_s(self.now_s);
        let fresh = self.feeds.iter().all(|stream| stream.is_good(self.now_s));
        let quiet = |window: Option<Window>, spread: f64, slope: f64| {
            window.is_some_and(|w| w.spread <= spread && w.slope_per_s.abs() <= slope)
        };
        let settled = fresh
            && dwell_s >= dwell_needed_s
            && quiet(force, force_spread_limit_n, force_slope_limit)
            && displacements
                .iter()
                .all(|window| quiet(*window, limits.spread_m, limits.slope_m_per_s));
        // The worst of several gauges; none while one has no window.
        let worst = |of: fn(&Window) -> f64| {
            let all: Option<Vec<f64>> = displacements
                .iter()
                .map(|window| window.as_ref().map(of))
                .collect();
            let largest_first = |a: &f64, b: &f64| b.abs().total_cmp(&a.abs());
            all?.into_iter().min_by(largest_first)
        };
        Some(SettleView {
            dwell_s,
            dwell_needed_s,
            force_spread_n: force.map(|w| w.spread),
            force_spread_limit_n,
            force_slope_n_per_s: force.map(|w| w.slope_per_s),
            force_slope_limit_n_per_s: force_slope_limit,
            spread_m: worst(|w| w.spread),
            spread_limit_m: limits.spread_m,
            slope_m_per_s: worst(|w| w.slope_per_s),
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
            Purpose::Release => {
                load.is_in_band() && self.stream(Channel::Force).is_good(self.now_s)
            }
            Purpose::Again | Purpose::Free => {
                let fresh = self.feeds.iter().all(|stream| stream.is_good(self.now_s));
                fresh && settle.dwell_s >= settle.dwell_needed_s
            }
            Purpose::Preload | Purpose::Reading | Purpose::ZeroCheck => settle.settled,
        }
    }

    pub(super) fn work_load(&mut self, purpose: Purpose, out: &mut Vec<Action>) {
        if self.is_settled() {
            match purpose {
                Purpose::Again if self.compares && !self.compare_with_before(out) => return,
                Purpose::Again | Purpose::Reading => {}
                Purpose::Release | Purpose::Free | Purpose::Preload => self.released(),
                Purpose::ZeroCheck => {
                    self.released();
                    self.displacement_zeros_checked();
                    return;
                }
            }
            self.done();
            return;
        }
        self.ask_about_a_steady_force(out);
    }

    /// Holds a load that was applied again after an interruption against its reading of before; whether to go on.
    fn compare_with_before(&mut self, out: &mut Vec<Action>) -> bool {
        let (Some(load), Some(Job::Load { .. })) = (&self.load, self.job) else {
            return true;
        };
        let Some((cell, index)) = self.plan.next_open(&self.state, self.focus) else {
            return true;
        };
        let repeat = self.plan.cells[cell].readings[index].repeat;
        let before = self.state.accepted().rev().find(|kept| {
            let taken = &kept.taken;
            (taken.cell, taken.repeat) == (cell, repeat)
                && taken.target_n == load.target_n
                && taken.branch == Branch::Loading
        });
        let (Some(before), Some(force_n)) = (before, self.value(Channel::Force)) else {
            return true;
        };
        let taken = &before.taken;
        let from_preload_n = taken.force_n - self.plan.procedure.preload_n;
        if from_preload_n.abs() <= 4.0 * load.tolerance_n {
            return true;
        }
        let pairs: Option<Vec<(Channel, f64, f64)>> = self
            .displacements()
            .map(|channel| {
                Some((
                    channel,
                    taken.displacement_of(channel)?,
                    self.value(channel)?,
                ))
            })
            .collect();
        let Some(pairs) = pairs else {
            return true;
        };
        // What a gauge across the load shows is small beside what a slightly other load direction gives.
        let moved_m = pairs.iter().map(|(_, before_m, _)| before_m.abs());
        let largest_m = moved_m.fold(0.0, f64::max);
        let other = pairs.into_iter().find(|(channel, before_m, now_m)| {
            // Corrected for what the force is off.
            let compliance = before_m / from_preload_n;
            let expected_m = before_m + compliance * (force_n - taken.force_n);
            let limit_m = (BEFORE_SHARE * largest_m).max(self.drift_limit_m(*channel));
            (now_m - expected_m).abs() > limit_m
        });
        let Some((channel, before_m, now_m)) = other else {
            self.compares = false;
            return true;
        };
        let text = format!(
            "Before the interruption {:.1} N gave {:.1} um{}, now {:.1} um: unit key, another gauge, or the robot has moved?",
            taken.force_n,
            before_m * 1e6,
            channel
                .axis()
                .map_or_else(String::new, |axis| format!(" along {axis}")),
            now_m * 1e6
        );
        self.compares = false;
        let prompt = Prompt::choice(
            "changed",
            text,
            &[
                ("again", "it is fixed: check the zero and load again"),
                ("flag", "continue; all readings from now on are flagged"),
            ],
        );
        self.ask(prompt, Why::Changed, out);
        false
    }

    /// What was changed is put right, or stays as it is.
    pub(super) fn changed_answered(&mut self, word: &str) {
        if word == "flag" {
            "not as before the interruption".clone_into(&mut self.standing_flag);
            self.done();
        } else {
            self.compares = true;
            self.unsure = true;
            self.reroute();
        }
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
        let stream = self.stream(Channel::Force);
        let window = stream.window(self.now_s - steady_s);
        let Some(window) = window.filter(|w| w.spread <= load.tolerance_n) else {
            return;
        };
        let force_n = self.along(Channel::Force, window.mean);
        let (target_n, purpose) = (load.target_n, load.purpose);
        // It is where it should be; what is waited for is the other gauge, whose gap restarted the dwell.
        if (force_n - target_n).abs() <= load.tolerance_n {
            return;
        }
        let opposite = force_n * target_n < 0.0
            && (force_n + target_n).abs() <= (0.3 * target_n.abs()).max(load.tolerance_n);
        let asked = match purpose {
            Purpose::Free if stream.is_good(self.now_s) => {
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
                    format!("The force is {force_n:.1} N; the target is {target_n:.1} N."),
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
}
