//! Which way the gauges count: a push by hand, and the operator states which way it went.

use std::fmt::Write as _;

use crate::event::{Event, SignChecked};
use crate::operator::Prompt;
use stiffbench_gauges::Channel;
use stiffbench_units_and_text::load_direction::LoadDirection;

use super::answers::Why;
use super::plausibility::{ALONG_SHARE, share_along};
use super::{Action, Job, Machine};

/// Share of the largest load that a push by hand has to reach.
const PUSH_SHARE: f64 = 0.1;

/// Least push, N: clear of what a hand on the gauge does.
const LEAST_PUSH_N: f64 = 2.0;

/// Steps of the last digit that the displacement has to move.
const DIGITS: f64 = 3.0;

/// Pushes of the needed size after which a displacement that does not move is remarked on.
const NO_MOVE: f64 = 3.0;

/// Time without a push over which the gauges are observed before it, s.
const BASE_S: f64 = 1.0;

/// A push beside the force gauge has to move a displacement gauge by so many steps of its last digit, spreads before it, and settling
/// spreads.
const BESIDE: (f64, f64, f64) = (10.0, 5.0, 5.0);

/// Share of a push beside the force gauge that is left once the end has come back (1). One that does not come back shows no sign: it may be the
/// hand that lets go.
const CAME_BACK: f64 = 0.5;

/// A force that stays for so long is no hand on the gauge: it was zeroed, or its zero has moved, s. An end that stays away for as long was let go
/// of, or has moved.
const NO_HAND_S: f64 = 15.0;

/// Which way gauges counted under a push: 1 up, -1 down.
pub(super) type CountedWays = Vec<(Channel, f64)>;

/// What a push by hand is to show.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SignStage {
    /// Where to push.
    pub(super) along: LoadDirection,
    /// Whether on the force gauge, whose sign it shows; else on the robot beside it.
    pub(super) with_force: bool,
    /// The displacement gauge whose sign it shows.
    pub(super) gauge: Option<Channel>,
}

/// A push by hand, watched.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct SignWatch {
    /// What force and displacement gauge showed before, with the spread of the displacement.
    base: Option<[f64; 3]>,
    remarked: bool,
    /// When it began, s.
    since_s: f64,
    /// How far the end has gone at most beside the force gauge, as sent, m, and when that was enough for a sign, s.
    farthest_m: f64,
    enough_s: Option<f64>,
}

impl Machine {
    /// How hard a push by hand has to be, N along the axis, in the sense of the loads.
    pub(super) fn push_n(&self) -> f64 {
        let size_n = (PUSH_SHARE * self.plan.largest_n()).max(LEAST_PUSH_N);
        size_n * self.plan.procedure.load_sense()
    }

    /// What the next push is to show: the force gauge with the displacement gauge along the load, then each other gauge along its own axis.
    pub(super) fn sign_stage(&self, cell: usize) -> SignStage {
        let direction = &self.plan.cells[cell].direction;
        let is_known = |channel: Channel| self.state.signs[channel.index()].is_some();
        let is_along = |channel: &Channel| share_along(direction, *channel).abs() > ALONG_SHARE;
        let open = self.displacements().find(|channel| !is_known(*channel));
        match open {
            Some(channel) if is_known(Channel::Force) => SignStage {
                along: channel
                    .axis()
                    .map_or_else(|| direction.clone(), LoadDirection::Axis),
                with_force: channel.axis().is_none(),
                gauge: Some(channel),
            },
            _ => SignStage {
                along: direction.clone(),
                with_force: true,
                gauge: self.displacements().find(is_along),
            },
        }
    }

    pub(super) fn begin_sign_check(&mut self, cell: usize, out: &mut Vec<Action>) {
        self.watch = Some(SignWatch {
            since_s: self.now_s,
            ..SignWatch::default()
        });
        self.forget_windows();
        let stage = self.sign_stage(cell);
        let toward = toward(&stage.along, self.push_n());
        let size_n = self.push_n().abs();
        let text = if stage.with_force {
            format!("let go, then push by hand on the force gauge {toward}, {size_n:.0} N or more")
        } else {
            format!("let go, then push the end by hand {toward}, beside the force gauge")
        };
        self.notify(text, out);
    }

    pub(super) fn work_sign_check(&mut self, cell: usize, out: &mut Vec<Action>) {
        let Some(watch) = self.watch else {
            return;
        };
        let good = self.feeds.iter().all(|stream| stream.is_good(self.now_s));
        let stage = self.sign_stage(cell);
        let watched = self.watched(&stage);
        let shown = |channel: Channel| Some(self.stream(channel).last.as_ref()?.value_si);
        let (Some(force), Some(moved), true) = (shown(Channel::Force), shown(watched), good) else {
            return;
        };
        let Some([force_0, moved_0, noise]) = watch.base else {
            self.take_base(watched, stage.with_force, out);
            return;
        };
        let (force_n, moved_m) = (force - force_0, moved - moved_0);
        let digit = self.stream(watched).last.as_ref();
        let digit_m = digit.map_or(0.0, |last| last.resolution_si);
        if !stage.with_force {
            let (digits, spreads, settled) = BESIDE;
            let spread_m = self.plan.procedure.settle.spread_m;
            let least_m = (digits * digit_m)
                .max(spreads * noise)
                .max(settled * spread_m);
            self.watch_beside(cell, watched, moved_m, least_m, out);
            return;
        }
        let least_m = (DIGITS * digit_m).max(DIGITS * noise);
        let push_n = self.push_n().abs();
        if force_n.abs() < push_n {
            return;
        }
        let force_way = (Channel::Force, force_n.signum());
        if stage.gauge.is_none() {
            self.ask_which_way(cell, vec![force_way], out);
        } else if moved_m.abs() >= least_m {
            let way = vec![force_way, (watched, moved_m.signum())];
            self.ask_which_way(cell, way, out);
        } else if force_n.abs() > NO_MOVE * push_n && !watch.remarked {
            self.watch = Some(SignWatch {
                remarked: true,
                ..watch
            });
            let text = "the displacement gauge does not move: does its plunger touch the robot?";
            self.message(text.to_owned(), true, out);
        }
    }

    /// Follows a push beside the force gauge: it shows a sign once the end has gone far enough and come back.
    fn watch_beside(
        &mut self,
        cell: usize,
        watched: Channel,
        moved_m: f64,
        least_m: f64,
        out: &mut Vec<Action>,
    ) {
        let Some(watch) = self.watch.as_mut() else {
            return;
        };
        if moved_m.abs() > watch.farthest_m.abs() {
            watch.farthest_m = moved_m;
        }
        let farthest_m = watch.farthest_m;
        if farthest_m.abs() < least_m {
            return;
        }
        let Some(enough_s) = watch.enough_s else {
            watch.enough_s = Some(self.now_s);
            self.message("let go of the end".to_owned(), true, out);
            return;
        };
        if moved_m.abs() <= CAME_BACK * farthest_m.abs() {
            self.ask_which_way(cell, vec![(watched, farthest_m.signum())], out);
        } else if self.now_s - enough_s > NO_HAND_S {
            self.begin_sign_check(cell, out);
        }
    }

    /// Whether no hand is to push: what the gauges show without is not known yet, or the push was seen.
    pub(super) fn wants_no_hand(&self) -> bool {
        self.watch
            .is_some_and(|watch| watch.base.is_none() || watch.enough_s.is_some())
    }

    /// The displacement gauge that is watched under a push; one whose sign it does not show is at least to be at rest.
    fn watched(&self, stage: &SignStage) -> Channel {
        let first = || self.displacements().next();
        stage.gauge.or_else(first).unwrap_or(Channel::Displacement)
    }

    /// What the gauges show before the push, both at rest: beside a push that is not let go of yet no later one would count, and under one that
    /// is held the end moves as it is let go.
    fn take_base(&mut self, watched: Channel, with_force: bool, out: &mut Vec<Action>) {
        let window = |channel: Channel| {
            let stream = self.stream(channel);
            stream.window(stream.window_from_s(BASE_S, self.now_s))
        };
        let settle = self.plan.procedure.settle;
        let both = window(Channel::Force)
            .filter(|force| force.spread <= settle.force_tolerance_n)
            .zip(window(watched).filter(|moved| moved.spread <= settle.spread_m));
        let (Some((force, moved)), Some(mut watch)) = (both, self.watch) else {
            return;
        };
        let unpushed_n = self.unpushed_n.filter(|_| !with_force);
        let held_n = unpushed_n.map_or(0.0, |before_n| (force.mean - before_n).abs());
        if held_n > 0.5 * self.push_n().abs() && self.now_s - watch.since_s < NO_HAND_S {
            if !watch.remarked {
                let text = format!("let go first: the force gauge still shows {held_n:.1} N");
                self.message(text, true, out);
            }
            watch.remarked = true;
        } else {
            watch.base = Some([force.mean, moved.mean, moved.spread]);
            if with_force {
                self.unpushed_n = Some(force.mean);
            }
        }
        self.watch = Some(watch);
    }

    fn ask_which_way(&mut self, cell: usize, way: CountedWays, out: &mut Vec<Action>) {
        let planned = &self.plan.cells[cell];
        let direction = self.sign_stage(cell).along;
        let mut prompt = Prompt::choice(
            "sign-check",
            format!("Which way along {direction} did you push?"),
            &[
                ("minus", "toward its negative end"),
                ("plus", "toward its positive end"),
                ("again", "neither: watch again"),
            ],
        );
        prompt.key = Some(format!("{}.{direction}", planned.pose));
        let word = |sign: f64| if sign > 0.0 { "up" } else { "down" };
        let mut counted = way.iter();
        let mut details = counted.next().map_or_else(String::new, |(channel, sign)| {
            format!("The {channel} gauge counted {}", word(*sign))
        });
        for (channel, sign) in counted {
            let _ = write!(details, ", the {channel} gauge {}", word(*sign));
        }
        prompt.details = vec![details + "."];
        self.ask(prompt, Why::Way(way), out);
    }

    /// How far the end gave way, over all of the push and the way to the zero: at its first moments one gauge is behind the other.
    pub(super) fn learn_from_push(&mut self, cell: usize) {
        let range = |channel: Channel| self.stream(channel).range(f64::NEG_INFINITY, f64::INFINITY);
        let leading = self.plan.leading(cell);
        let direction = &self.plan.cells[cell].direction;
        let share = share_along(direction, leading);
        if share.abs() < ALONG_SHARE {
            return;
        }
        let (force_n, moved_m) = (range(Channel::Force), range(leading));
        if self.pushed.is_none() && force_n >= self.push_n().abs() {
            self.pushed = Some((cell, moved_m / force_n));
        }
    }

    /// The operator's answer on the direction of the push: `push` is 1 toward the positive end.
    pub(super) fn confirmed_sign(
        &mut self,
        push: f64,
        way: &[(Channel, f64)],
        out: &mut Vec<Action>,
    ) {
        let described = self.settings.compression_sign;
        let mut of_force = way.iter().filter(|(channel, _)| *channel == Channel::Force);
        if of_force.any(|(_, counted)| described.is_some_and(|sign| sign != *counted)) {
            let prompt = Prompt::choice(
                "sign-differs",
                "By its description the force gauge counts the other way under compression.",
                &[
                    ("use", "its sign was changed at the panel: take it as it is"),
                    ("again", "watch another push"),
                ],
            );
            let way = way.to_vec();
            self.ask(prompt, Why::SignDiffers { push, way }, out);
            return;
        }
        self.keep_signs(push, way, "hand push, as described", out);
    }

    pub(super) fn keep_signs(
        &mut self,
        push: f64,
        way: &[(Channel, f64)],
        basis: &str,
        out: &mut Vec<Action>,
    ) {
        let cell = match self.job {
            Some(Job::SignCheck(cell)) => cell,
            _ => self.focus,
        };
        let along = self.sign_stage(cell).along;
        for (channel, counted) in way {
            // A gauge counts along its axis, which a load may go against.
            let sense = share_along(&along, *channel).signum();
            let event = Event::SignCheck(SignChecked {
                channel: *channel,
                sign: push * counted * sense,
                basis: basis.to_owned(),
            });
            self.record(event, out);
        }
        let shown = |channel: &Channel| {
            self.state.signs[channel.index()].is_some() || way.iter().any(|(of, _)| of == channel)
        };
        self.signs_checked = self.channels.iter().all(shown);
        self.reroute();
    }

    /// The operator found that a gauge counts the other way round.
    pub(super) fn flip(&mut self, channel: Channel, basis: &str, out: &mut Vec<Action>) {
        let event = Event::SignCheck(SignChecked {
            channel,
            sign: -self.state.signs[channel.index()].unwrap_or(1.0),
            basis: basis.to_owned(),
        });
        self.record(event, out);
        self.left_band();
        if channel == Channel::Force {
            // The preload was on the wrong side, and the zero with it.
            self.reroute();
            if let Some((cell, index)) = self.plan.next_open(&self.state, self.focus) {
                self.queue = self.zero(cell, index);
            }
        }
    }
}

/// The way of a push along a direction: `force_n` below zero goes against it.
fn toward(along: &LoadDirection, force_n: f64) -> String {
    let word = along.to_string();
    match (word.strip_prefix('-'), force_n < 0.0) {
        (Some(axis), true) => format!("toward +{axis}"),
        (Some(axis), false) => format!("toward -{axis}"),
        (None, against) if along.axis().is_some() => {
            format!("toward {}{word}", if against { '-' } else { '+' })
        }
        (None, true) => format!("against {word}"),
        (None, false) => format!("along {word}"),
    }
}
