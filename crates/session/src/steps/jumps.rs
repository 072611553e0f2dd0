//! Jumps of one gauge that the other does not explain.

use crate::gauge_stream::GaugeStream;
use stiffbench_gauges::Channel;

use super::Machine;
use super::plausibility::{ALONG_SHARE, share_along};

/// A gauge that jumps alone does so by more than this many steps of its last digit and this many settling spreads.
const ALONE: (f64, f64) = (12.0, 5.0);

/// It may move so many times as far as the other lets expect, or this part of it against the other.
const JUMP_TIMES: f64 = 3.0;
const JUMP_AGAINST: f64 = 0.3;

/// A jump is over within so many samples, and this time, s.
const JUMP_SAMPLES: usize = 3;
const JUMP_S: f64 = 0.35;

/// One gauge that moved while the other did not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MovedAlone {
    pub(super) channel: Channel,
    /// By how much, N or m.
    pub(super) by: f64,
}

impl Machine {
    /// A gauge that jumped since the last certain moment while the other stood still, or against it, and has not come back: zero key, unit
    /// key, stand moved, hold released.
    pub(super) fn moved_alone(&self, cell: usize) -> Option<MovedAlone> {
        self.displacements()
            .find_map(|channel| self.moved_alone_of(cell, channel))
    }

    /// The same of force and one displacement gauge.
    fn moved_alone_of(&self, cell: usize, channel: Channel) -> Option<MovedAlone> {
        let (_, from_s) = self.before.filter(|_| self.lag_s.is_finite())?;
        let (compliance, _) = self.compliance_m_per_n(cell, channel)?;
        let (force, displacement) = (self.stream(Channel::Force), self.stream(channel));
        let digit_m = displacement.last.as_ref()?.resolution_si;
        let digit_n = force.last.as_ref()?.resolution_si;
        let spread_m = self.plan.procedure.settle.spread_m;
        let (digits, spreads) = ALONE;
        let least_m = (digits * digit_m)
            .max(spreads * spread_m)
            .max(compliance * digits * digit_n);
        let sign = |channel: Channel| self.state.axis(channel).0;
        // Both in metres toward the load, so that they are alike; which way an end moves across the load is not known.
        let share = share_along(&self.plan.cells[cell].direction, channel);
        let sense = share.signum();
        let is_along = share.abs() > ALONG_SHARE;
        let scales = [sign(Channel::Force) * compliance, sense * sign(channel)];
        let jumped = |of: &GaugeStream, scale: f64, other: &GaugeStream, other_scale: f64| {
            let lag_s = self.lag_s.max(other.period_s().unwrap_or(0.0));
            let other = Scaled {
                stream: other,
                scale: other_scale,
            };
            net_jump(
                &Scaled { stream: of, scale },
                &other,
                from_s,
                lag_s,
                least_m,
                is_along,
            )
        };
        let by_m = jumped(displacement, scales[1], force, scales[0]);
        if by_m.abs() > least_m {
            return Some(MovedAlone {
                channel,
                by: sense * by_m,
            });
        }
        let by_m = jumped(force, scales[0], displacement, scales[1]);
        (by_m.abs() > least_m).then_some(MovedAlone {
            channel: Channel::Force,
            by: by_m / compliance,
        })
    }
}

/// A gauge whose values are multiplied.
struct Scaled<'a> {
    stream: &'a GaugeStream,
    scale: f64,
}

/// The sum of the jumps of one gauge since `from_s` that the other cannot explain. From one sample to one of the next three it may go as far as
/// the other did, `lag_s` before and after included, some times over in the same direction and a part of it in the other; where they need not go
/// the same way, some times over in both.
fn net_jump(
    of: &Scaled<'_>,
    other: &Scaled<'_>,
    from_s: f64,
    lag_s: f64,
    least: f64,
    same_way: bool,
) -> f64 {
    let values: Vec<(f64, f64)> = of
        .stream
        .between(from_s - lag_s, f64::INFINITY)
        .map(|(at_s, value)| (at_s, of.scale * value))
        .collect();
    let mut sum = 0.0;
    let mut at = 0;
    while at + 1 < values.len() {
        let (begin_s, begin) = values[at];
        let next = values[at + 1..].iter().take(JUMP_SAMPLES).enumerate();
        let jump = next
            .take_while(|(_, (end_s, _))| end_s - begin_s <= JUMP_S)
            .find(|(_, (end_s, end))| {
                let step = end - begin;
                let (from_s, to_s) = (begin_s - lag_s, end_s + lag_s);
                let near = other.stream.range(from_s, to_s) * other.scale.abs();
                let ends = other
                    .stream
                    .value_at(from_s)
                    .zip(other.stream.value_at(to_s));
                let way = ends.map_or(0.0, |(a, b)| (b - a) * other.scale);
                let forward = way.abs() > near / 2.0 && way * step > 0.0;
                let times = if forward || !same_way || way.abs() <= near / 2.0 {
                    JUMP_TIMES
                } else {
                    JUMP_AGAINST
                };
                step.abs() > least + times * near
            });
        match jump {
            Some((more, (_, end))) => {
                sum += end - begin;
                at += more + 1;
            }
            None => at += 1,
        }
    }
    sum
}
