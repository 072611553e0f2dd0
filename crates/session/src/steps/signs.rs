//! Which way the gauges count: a push by hand, and the operator states which way it went.

use crate::event::{Event, SignChecked};
use crate::operator::Prompt;
use stiffbench_gauges::Channel;

use super::answers::Why;
use super::{Action, Machine};

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

/// A push by hand, watched.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct SignWatch {
    /// What the gauges showed before, with the spread of the displacement.
    base: Option<[f64; 3]>,
    remarked: bool,
}

impl Machine {
    /// How hard a push by hand has to be, N along the axis, in the sense of the loads.
    pub(super) fn push_n(&self) -> f64 {
        let size_n = (PUSH_SHARE * self.plan.largest_n()).max(LEAST_PUSH_N);
        size_n * self.plan.load_sense()
    }

    pub(super) fn begin_sign_check(&mut self, cell: usize, out: &mut Vec<Action>) {
        self.watch = Some(SignWatch::default());
        self.forget_windows();
        let direction = self.plan.cells[cell].direction;
        let way = if self.push_n() < 0.0 { '-' } else { '+' };
        let size_n = self.push_n().abs();
        let text = format!(
            "let go, then push by hand on the force gauge toward {way}{direction}, {size_n:.0} N or more"
        );
        self.notify(text, out);
    }

    pub(super) fn work_sign_check(&mut self, cell: usize, out: &mut Vec<Action>) {
        let Some(watch) = self.watch else {
            return;
        };
        let good = self.feeds.iter().all(|stream| stream.is_good(self.now_s));
        let shown = |channel: Channel| Some(self.stream(channel).last.as_ref()?.value_si);
        let (Some(force), Some(moved), true) =
            (shown(Channel::Force), shown(Channel::Displacement), good)
        else {
            return;
        };
        let Some([force_0, moved_0, noise]) = watch.base else {
            self.take_base();
            return;
        };
        let (force_n, moved_m) = (force - force_0, moved - moved_0);
        let digit = self.stream(Channel::Displacement).last.as_ref();
        let least_m = (DIGITS * digit.map_or(0.0, |last| last.resolution_si)).max(DIGITS * noise);
        let push_n = self.push_n().abs();
        if force_n.abs() < push_n {
            return;
        }
        if moved_m.abs() >= least_m {
            let way = [force_n.signum(), moved_m.signum()];
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

    /// Whether it is not known yet what the gauges show without a push.
    pub(super) fn waits_for_base(&self) -> bool {
        self.watch.is_some_and(|watch| watch.base.is_none())
    }

    /// What the gauges show before the push.
    fn take_base(&mut self) {
        let window = |channel: Channel| {
            let stream = self.stream(channel);
            stream.window(stream.window_from_s(BASE_S, self.now_s))
        };
        let quiet_n = self.plan.procedure.settle.force_tolerance_n;
        let both = window(Channel::Force)
            .filter(|force| force.spread <= quiet_n)
            .zip(window(Channel::Displacement));
        let base = both.map(|(force, moved)| [force.mean, moved.mean, moved.spread]);
        if let Some(watch) = &mut self.watch {
            watch.base = base;
        }
    }

    fn ask_which_way(&mut self, cell: usize, way: [f64; 2], out: &mut Vec<Action>) {
        let planned = &self.plan.cells[cell];
        let direction = planned.direction;
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
        prompt.details = vec![format!(
            "The force gauge counted {}, the displacement gauge {}.",
            word(way[0]),
            word(way[1])
        )];
        self.ask(prompt, Why::Way(way), out);
    }

    /// How far the end gave way, over all of the push and the way to the zero: at its first moments one gauge is behind the other.
    pub(super) fn learn_from_push(&mut self, cell: usize) {
        let range = |channel: Channel| self.stream(channel).range(f64::NEG_INFINITY, f64::INFINITY);
        let (force_n, moved_m) = (range(Channel::Force), range(Channel::Displacement));
        if self.pushed.is_none() && force_n >= self.push_n().abs() {
            self.pushed = Some((cell, moved_m / force_n));
        }
    }

    /// The operator's answer on the direction of the push: `push` is 1 toward the positive end.
    pub(super) fn confirmed_sign(&mut self, push: f64, way: [f64; 2], out: &mut Vec<Action>) {
        let described = self.settings.compression_sign;
        if described.is_some_and(|sign| sign != way[0]) {
            let prompt = Prompt::choice(
                "sign-differs",
                "By its description the force gauge counts the other way under compression.",
                &[
                    ("use", "its sign was changed at the panel: take it as it is"),
                    ("again", "watch another push"),
                ],
            );
            self.ask(prompt, Why::SignDiffers { push, way }, out);
            return;
        }
        self.keep_signs(push, way, "hand push, as described", out);
    }

    pub(super) fn keep_signs(
        &mut self,
        push: f64,
        way: [f64; 2],
        basis: &str,
        out: &mut Vec<Action>,
    ) {
        for channel in Channel::ALL {
            let event = Event::SignCheck(SignChecked {
                channel,
                sign: push * way[channel.index()],
                basis: basis.to_owned(),
            });
            self.record(event, out);
        }
        self.signs_checked = true;
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
                let mut jobs = Vec::new();
                self.zero(cell, index, &mut jobs);
                self.queue = jobs.into();
            }
        }
    }
}
