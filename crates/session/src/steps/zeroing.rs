//! Setting the zero: by the gauge where it has a command for it, else by taking off what it shows.

use crate::event::{AxisZero, Event, ZeroOccasion, Zeroed};
use crate::operator::Prompt;
use crate::view::Purpose;
use stiffbench_gauges::{Ask, Channel};

use super::answers::Why;
use super::{Action, Machine, ZeroDraft};

/// Steps of the last digit that a gauge may show right after it was zeroed.
const ZERO_DIGITS: f64 = 5.0;

/// Dwells that a zero which still changes is waited for; what then remains is drift, and taken off as it is.
const LEVEL_DWELLS: f64 = 3.0;

impl Machine {
    pub(super) fn begin_zero(&mut self, channel: Channel, out: &mut Vec<Action>) {
        // Before the zero commands make the displays jump.
        if let (Some(cell), Channel::Force) = (self.mounted, channel) {
            self.learn_from_push(cell);
        }
        let (_, offset_n) = self.state.axis(Channel::Force);
        let mut offsets_si = [0.0; Channel::COUNT];
        offsets_si[Channel::Force.index()] = offset_n;
        let left_on = match channel {
            Channel::Force => self.force_left_on(),
            _ => None,
        };
        let draft = self.draft.get_or_insert(ZeroDraft {
            offsets_si,
            by_gauge: [false; Channel::COUNT],
            left_on_n: None,
            since_s: None,
        });
        draft.left_on_n = left_on.or(draft.left_on_n);
        draft.since_s = None;
        out.push(Action::Ask(channel, Ask::Zero));
    }

    /// The force that is still on while the force gauge is said to hang free, N: it shows it, and the end stands where this force brings it.
    fn force_left_on(&self) -> Option<f64> {
        let set = &self.state.zero.as_ref()?.set;
        let (cell, preload_n) = (
            self.mounted.filter(|cell| *cell == set.cell)?,
            set.preload_n?,
        );
        let leading = self.plan.leading(cell);
        let slope = self.slope_m_per_n(cell, leading)?;
        let force_n = self.mean_force_n()?;
        let moved_m = self.value(leading)? + slope * preload_n;
        let is_on = (moved_m - slope * force_n).abs() < 0.5 * (slope * force_n).abs();
        let clear = force_n.abs() > self.tolerance_n(Purpose::Free)
            && moved_m.abs() > self.drift_limit_m(leading);
        (is_on && clear).then_some(force_n)
    }

    /// The gauge has set its zero, or cannot.
    pub(super) fn zero_answered(
        &mut self,
        channel: Channel,
        answer: Result<Box<str>, Box<str>>,
        out: &mut Vec<Action>,
    ) {
        let now_s = self.now_s;
        let Some(draft) = &mut self.draft else {
            return;
        };
        draft.since_s = Some(now_s);
        draft.by_gauge[channel.index()] = answer.is_ok();
        self.stream_mut(channel).forget();
        if let Err(reason) = answer {
            self.notify(
                format!("the {channel} gauge is zeroed by subtracting what it shows ({reason})"),
                out,
            );
        }
    }

    /// Waits until the gauge stands still on its zero, then keeps what is left to be taken off.
    pub(super) fn work_zero(
        &mut self,
        channel: Channel,
        at: (usize, usize),
        out: &mut Vec<Action>,
    ) {
        let Some((draft, since_s)) = self.draft.and_then(|draft| Some((draft, draft.since_s?)))
        else {
            return;
        };
        let settle = self.plan.procedure.settle;
        let stream = self.stream(channel);
        let waited_s = self.now_s - since_s;
        let by_gauge = draft.by_gauge;
        // No sooner than this gauge has once needed.
        let takes_s = if by_gauge[channel.index()] {
            self.zero_takes_s[channel.index()]
        } else {
            0.0
        };
        let dwelt = waited_s >= settle.dwell_s.max(takes_s);
        let from_s = since_s.max(stream.window_from_s(settle.dwell_s, self.now_s));
        let (Some(window), true) = (stream.window(from_s), dwelt && stream.is_good(self.now_s))
        else {
            return;
        };
        let limit = match channel {
            Channel::Force => 2.0 * settle.force_tolerance_n,
            _ => settle.spread_m,
        };
        if window.spread > limit {
            return;
        }
        let digit = stream.last.as_ref().map_or(0.0, |last| last.resolution_si);
        // A gauge may acknowledge at once and set its zero a second later.
        let last = |share: f64| stream.window(self.now_s - share * settle.dwell_s);
        if by_gauge[channel.index()]
            && waited_s < LEVEL_DWELLS * settle.dwell_s
            && last(0.25).or(last(0.5)).is_some_and(|later| {
                let step = window.mean - later.mean;
                step.abs() > (later.spread / 2.0).max(2.0 * digit)
            })
        {
            return;
        }
        let at_zero = window.mean.abs() <= (ZERO_DIGITS * digit).max(window.spread / 2.0);
        if by_gauge[channel.index()] && !at_zero && waited_s < LEVEL_DWELLS * settle.dwell_s {
            self.zero_takes_s[channel.index()] = takes_s.max(waited_s);
            return;
        }
        let near_zero = window.mean.abs() <= (ZERO_DIGITS * digit).max(limit);
        if by_gauge[channel.index()] && !near_zero {
            self.ask_zero_not_shown(channel, out);
            return;
        }
        // A zero by the gauge is a near zero: what it leaves is taken off too.
        let mut draft = ZeroDraft {
            since_s: None,
            ..draft
        };
        draft.offsets_si[channel.index()] = window.mean;
        self.draft = Some(draft);
        if self.channels.last() == Some(&channel) {
            self.keep_zero(at, &draft, out);
        }
        self.done();
    }

    /// A gauge that confirms its zero and shows another value holds its display, or its keys are locked.
    fn ask_zero_not_shown(&mut self, channel: Channel, out: &mut Vec<Action>) {
        let shown = self.stream(channel).last.as_ref();
        let shown = shown.map_or_else(String::new, |last| last.raw.trim().to_owned());
        let text =
            format!("The {channel} gauge confirmed its zero, but shows {shown}: hold, or locked?");
        let choices = [
            ("again", "it is corrected: zero it again"),
            ("subtract", "it is right: subtract what it shows"),
        ];
        let prompt = Prompt::choice("zero-not-shown", text, &choices);
        self.ask(prompt, Why::ZeroNotShown(channel), out);
    }

    /// The operator's decision on a zero that is not displayed.
    pub(super) fn zero_not_shown(&mut self, channel: Channel, word: &str, out: &mut Vec<Action>) {
        if word == "again" {
            self.begin_zero(channel, out);
        } else if let Some(draft) = &mut self.draft {
            draft.by_gauge[channel.index()] = false;
        }
    }

    fn keep_zero(
        &mut self,
        (cell, index): (usize, usize),
        draft: &ZeroDraft,
        out: &mut Vec<Action>,
    ) {
        let scope = self.plan.zero_scope(&self.plan.cells[cell].readings[index]);
        let preload_n = self.mean_force_n();
        let earlier = self.state.zeros.get(&(cell, scope.clone()));
        let label = match earlier {
            None | Some(0) => scope.clone(),
            Some(n) => format!("{scope}-{}", n + 1),
        };
        self.draft = None;
        self.unsure = false;
        let from_s = self.now_s - self.plan.procedure.settle.dwell_s;
        for stream in &mut self.feeds {
            stream.learn_flicker(from_s);
            stream.learn_digits();
        }
        self.begin_histories();
        self.note_shown();
        let of = |channel: Channel| {
            (
                draft.offsets_si[channel.index()],
                draft.by_gauge[channel.index()],
            )
        };
        let first = self.displacements().next().unwrap_or(Channel::Displacement);
        let (force_offset_n, force_by_gauge) = of(Channel::Force);
        let (displacement_offset_m, displacement_by_gauge) = of(first);
        let along_axes = self
            .displacements()
            .filter(|channel| channel.axis().is_some());
        let gauges = along_axes.map(|channel| {
            let (offset_m, by_gauge) = of(channel);
            AxisZero {
                channel,
                offset_m,
                by_gauge,
                drift_m: None,
            }
        });
        let event = Event::Zero(Zeroed {
            cell,
            scope,
            label: label.clone(),
            moment: ZeroOccasion::Before,
            force_offset_n,
            displacement_offset_m,
            by_gauge: [force_by_gauge, displacement_by_gauge],
            preload_n,
            drift_m: None,
            force_drift_n: None,
            flag: draft.left_on_n.map_or_else(String::new, |left_n| {
                format!("{left_n:.1} N were still on when the force gauge was zeroed")
            }),
            gauges: gauges.collect(),
        });
        self.record(event, out);
        self.notify(format!("zero {label} is set"), out);
    }

    /// Mean force over the last dwell, N along the axis.
    pub(super) fn mean_force_n(&self) -> Option<f64> {
        let stream = self.stream(Channel::Force);
        let dwell_s = self.plan.procedure.settle.dwell_s;
        let window = stream.window(stream.window_from_s(dwell_s, self.now_s))?;
        Some(self.along(Channel::Force, window.mean))
    }

    /// Keeps what the gauges show now, to detect a frozen one later.
    pub(super) fn note_shown(&mut self) {
        let mut shown = [0.0; Channel::COUNT];
        for stream in &self.feeds {
            let Some(last) = &stream.last else {
                self.before = None;
                return;
            };
            shown[stream.channel.index()] = last.value_si;
        }
        self.before = Some((shown, self.now_s));
    }
}
