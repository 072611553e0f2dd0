//! Plausibility checks of a reading: each gauge is compared with the other, and the reading with earlier readings of the cell.

use crate::digits::FewDigits;
use crate::event::TakenReading;
use crate::gauge_stream::GaugeStream;
use crate::run_scatter::{check_of, gauge_number, is_unflagged, load_reading};
use stiffbench_gauges::Channel;
use stiffbench_units_and_text::load_direction::LoadDirection;

use super::Machine;

/// Steps of the last digit by which a gauge must have moved before a missing motion can be reported.
const STILL_DIGITS: f64 = 5.0;

/// A gauge that moves by less than this share of what the one that moves most does may stand still (1).
const SMALL_SHARE: f64 = 0.1;

/// A gauge along the load, by this share of it, moves with the load; at an angle the end may move any way (1).
pub(super) const ALONG_SHARE: f64 = 0.99;

/// And the share of its value: less is creep, or friction in the joints.
const STILL_SHARE: f64 = 0.02;

/// Share of the displacement by which an end may creep on while the force stays.
const CREEP_SHARE: f64 = 0.1;

/// A display that flickers by so many steps of its last digit stands still.
const STILL_FLICKER_DIGITS: f64 = 3.0;

/// Displays that show one text for a whole dwell are believed if that happens more often than this by chance.
const CHANCE_OF_STILLNESS: f64 = 1e-3;

/// Without any idea of the compliance, a display that stands still while the force moves by this many tolerances is asked about.
const STILL_TOLERANCES: f64 = 4.0;

/// The moving gauge may be behind the one that stands still by this part of the lag, beside its period.
const PART_OF_LAG: f64 = 0.5;

/// A change of displacement for a change of force may be this many times what the cell gave before, or this part of it. A tared gauge
/// doubles it, a unit key makes it 4.4, 9.8 or 25.4 times as much; play that closes may reach it once.
const PROPORTION: f64 = 1.75;

/// The same where only the push by hand gives the compliance.
const PROPORTION_OF_PUSH: f64 = 3.0;

/// Settling spreads beyond which a displacement under no load is against the force.
const AGAINST_SPREADS: f64 = 10.0;

/// Why a reading is not taken without a question.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CaptureCheck {
    /// The rule, and the id of the prompt.
    pub(super) rule: &'static str,
    /// The gauge that it is about.
    pub(super) channel: Channel,
    pub(super) text: String,
    /// Whether it may go by itself: a gauge that is late catches up.
    pub(super) may_pass: bool,
    /// A gauge that stands still, and since when, s.
    pub(super) still: Option<(Channel, f64)>,
}

/// How much of a load is along the axis of a gauge, with its sense; all of it where the gauge stands along the load.
pub(super) fn share_along(load: &LoadDirection, channel: Channel) -> f64 {
    channel.axis().map_or(1.0, |axis| load.along(axis))
}

impl Machine {
    /// Checks that a reading fails.
    pub(super) fn failed_checks(&self, taken: &TakenReading) -> Vec<CaptureCheck> {
        let each = || self.displacements();
        let mut found = Vec::new();
        if self.settings.lag_s.is_finite() {
            found.extend(each().map(|of| self.displacement_stands_still(taken, of)));
            found.push(self.force_stands_still(taken));
            found.extend(each().map(|of| self.out_of_proportion(taken, of)));
            found.push(self.flicker_has_ended(taken));
        }
        found.push(self.beyond_a_hard_limit(taken));
        found.push(self.against_the_force(taken));
        found.extend(each().map(|of| self.far_from_repeats(taken, of)));
        found.extend(self.channels.iter().map(|of| self.coarse_steps(*of)));
        found.into_iter().flatten().collect()
    }

    /// About how far the end of a cell gives way where a gauge stands, from its readings or the push by hand, m/N; and how well that is
    /// known.
    pub(super) fn compliance_m_per_n(&self, cell: usize, channel: Channel) -> Option<(f64, f64)> {
        let measured = self.slope_m_per_n(cell, channel);
        let measured = measured.map(|slope| (slope.abs(), PROPORTION));
        let leads = self.plan.leading(cell) == channel;
        let pushed = self.pushed.filter(|(pushed, _)| *pushed == cell && leads);
        measured.or(pushed.map(|(_, compliance)| (compliance, PROPORTION_OF_PUSH)))
    }

    /// The same from the last good reading under load, with its sign.
    pub(super) fn slope_m_per_n(&self, cell: usize, channel: Channel) -> Option<f64> {
        let zero = self.state.zero.as_ref();
        let preload_n = zero.and_then(|zero| zero.set.preload_n);
        let preload_n = preload_n.unwrap_or(self.plan.procedure.preload_n);
        let tolerance_n = self.plan.procedure.settle.force_tolerance_n;
        let good = self
            .state
            .accepted()
            .rev()
            .filter(|kept| is_unflagged(kept));
        let mut slopes = good.filter_map(|kept| {
            let loaded_n = kept.taken.force_n - preload_n;
            let is_here =
                kept.taken.cell == cell && loaded_n.abs() > STILL_TOLERANCES * tolerance_n;
            let moved_m = kept.taken.displacement_of(channel).filter(|_| is_here)?;
            Some(moved_m / loaded_n)
        });
        slopes.next()
    }

    /// The same of the gauge that moves most.
    fn largest_m_per_n(&self, cell: usize) -> f64 {
        self.displacements()
            .filter_map(|channel| self.compliance_m_per_n(cell, channel))
            .fold(0.0, |largest, (compliance, _)| largest.max(compliance))
    }

    /// Since when a gauge has stood still, s, and by how much the other has moved since then at least. `visible` is what the gauge that
    /// stands still would have to show, N or m; its flicker comes on top and is the last of what comes back.
    fn moved_behind(
        &self,
        still: Channel,
        moving: Channel,
        visible: f64,
    ) -> Option<(f64, f64, f64)> {
        let (still, moving) = (self.stream(still), self.stream(moving));
        let digit = still.last.as_ref()?.resolution_si;
        let from_s = still.window_from_s(self.plan.procedure.settle.dwell_s, self.now_s);
        // Over a longer time it flickers further than in the dwell.
        let flicker = (2.0 * still.range(from_s, self.now_s)).min(visible / 2.0);
        let band = flicker.max(STILL_FLICKER_DIGITS * digit);
        let since_s = still.still_since_s(band)?;
        let now = moving.last.as_ref()?.value_si;
        let lag_s = PART_OF_LAG * self.settings.lag_s + moving.period_s().unwrap_or(0.0);
        let at = moving.value_at(since_s)?;
        // With the first value behind that: of a gap in between nothing is known.
        let behind_s = moving.between(since_s + lag_s, f64::INFINITY).next();
        let until_s = behind_s.map_or(since_s + lag_s, |(at_s, _)| at_s);
        let near = moving.between(since_s, until_s);
        let moved = near.map(|(_, value)| now - value);
        let least = |least: f64, moved: f64| {
            if moved.abs() < least.abs() {
                moved
            } else {
                least
            }
        };
        let jumped = moved.fold(now - at, least);
        let crept = self.crept_since(moving, since_s);
        let most = if crept.abs() > jumped.abs() {
            crept
        } else {
            jumped
        };
        Some((since_s, most, band))
    }

    /// How far a gauge has moved bit by bit since a time, its lag taken off; 0 if half of it came at once: what was moved and put back.
    fn crept_since(&self, moving: &GaugeStream, since_s: f64) -> f64 {
        let values = moving.between(since_s + self.settings.lag_s, f64::INFINITY);
        let values: Vec<f64> = values.map(|(_, value)| value).collect();
        let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let largest = steps.fold(0.0, f64::max);
        let crept = values.last().zip(values.first());
        let crept = crept.map_or(0.0, |(last, first)| last - first);
        if 2.0 * largest <= crept.abs() {
            crept
        } else {
            0.0
        }
    }

    fn displacement_stands_still(
        &self,
        taken: &TakenReading,
        channel: Channel,
    ) -> Option<CaptureCheck> {
        let settle = &self.plan.procedure.settle;
        let digit_m = self.stream(channel).last.as_ref()?.resolution_si;
        let displacement_m = taken.displacement_of(channel)?;
        let visible_m = (STILL_DIGITS * digit_m)
            .max(settle.spread_m)
            .max(STILL_SHARE * displacement_m.abs());
        let (since_s, moved_n, band_m) = self.moved_behind(channel, Channel::Force, visible_m)?;
        let moved_n = moved_n.abs();
        let still = if let Some((compliance, _)) = self.compliance_m_per_n(taken.cell, channel) {
            let shows = compliance >= SMALL_SHARE * self.largest_m_per_n(taken.cell);
            shows && compliance * moved_n > visible_m + band_m
        } else {
            // Across the load an end need not move.
            let share = share_along(&taken.direction, channel);
            share.abs() > ALONG_SHARE && moved_n > STILL_TOLERANCES * settle.force_tolerance_n
        };
        still.then(|| CaptureCheck {
            rule: "frozen",
            channel,
            text: format!(
                "The {channel} gauge has shown {} for {:.1} s while the force moved by {moved_n:.1} N: hold, end of travel, or not touching?",
                taken.raw_of(channel).trim(),
                self.now_s - since_s
            ),
            may_pass: true,
            still: Some((channel, since_s)),
        })
    }

    fn force_stands_still(&self, taken: &TakenReading) -> Option<CaptureCheck> {
        let settle = &self.plan.procedure.settle;
        let leading = self.plan.leading(taken.cell);
        let (compliance, _) = self.compliance_m_per_n(taken.cell, leading)?;
        let digit_n = self.stream(Channel::Force).last.as_ref()?.resolution_si;
        let mut visible_n = (STILL_DIGITS * digit_n)
            .max(settle.force_tolerance_n / STILL_TOLERANCES)
            .max(STILL_SHARE * taken.force_n.abs());
        let (since_s, moved_si, band_n) = self.moved_behind(Channel::Force, leading, visible_n)?;
        let moved_m = moved_si.abs();
        let (sign, _) = self.state.axis(leading);
        if sign * moved_si * taken.displacement_m > 0.0 {
            // Onward under a load that stays: joints and supports creep.
            visible_n = visible_n.max(CREEP_SHARE * taken.force_n.abs());
        }
        let still = moved_m > settle.spread_m && moved_m > compliance * (visible_n + band_n);
        still.then(|| CaptureCheck {
            rule: "frozen",
            channel: Channel::Force,
            text: format!(
                "The force gauge has shown {} for {:.1} s while the displacement moved by {:.1} um: hold, peak mode, or overload?",
                taken.force_raw.trim(),
                self.now_s - since_s,
                moved_m * 1e6
            ),
            may_pass: true,
            still: Some((Channel::Force, since_s)),
        })
    }

    /// Displays that used to flicker stand still since the dwell began: held, at a peak, or handed on by an adapter that repeats itself.
    fn flicker_has_ended(&self, taken: &TakenReading) -> Option<CaptureCheck> {
        let dwell_s = self.load.as_ref()?.dwell_s(self.now_s);
        let from_s = self.now_s - dwell_s;
        let chances = self.feeds.iter();
        let chances = chances.map(|stream| stream.chance_of_stillness(from_s));
        (combined_chance(chances) < CHANCE_OF_STILLNESS).then(|| CaptureCheck {
            rule: "frozen",
            channel: Channel::Force,
            text: format!(
                "The displays flickered until now; for {dwell_s:.1} s they show {} nearly without change: hold, peak mode, or an adapter that repeats itself?",
                self.channels
                    .iter()
                    .map(|of| taken.raw_of(*of).trim())
                    .collect::<Vec<_>>()
                    .join(" and "),
            ),
            may_pass: true,
            still: None,
        })
    }

    fn against_the_force(&self, taken: &TakenReading) -> Option<CaptureCheck> {
        let settle = &self.plan.procedure.settle;
        // The displacement counts from the preload: without load the end has moved back.
        let moved_n = taken.force_n - self.plan.procedure.preload_n;
        let displacement_m = taken.along_load_m()?;
        let clear = moved_n.abs() > settle.force_tolerance_n
            && displacement_m.abs() > AGAINST_SPREADS * settle.spread_m;
        let against = moved_n * displacement_m < 0.0;
        (clear && against).then(|| CaptureCheck {
            rule: "displacement-sign",
            channel: self.plan.leading(taken.cell),
            text: format!(
                "The end moves by {:.1} um against a force of {:.1} N.",
                displacement_m * 1e6,
                taken.force_n
            ),
            may_pass: false,
            still: None,
        })
    }

    /// From one certain moment to the next, force and displacement change in proportion.
    fn out_of_proportion(&self, taken: &TakenReading, channel: Channel) -> Option<CaptureCheck> {
        let settle = &self.plan.procedure.settle;
        let (shown_si, _) = self.before?;
        let before_n = self.along(Channel::Force, shown_si[Channel::Force.index()]);
        let before_m = self.along(channel, shown_si[channel.index()]);
        let changed_n = taken.force_n - before_n;
        let moved_m = taken.displacement_of(channel)? - before_m;
        let (compliance, mut factor) = self.compliance_m_per_n(taken.cell, channel)?;
        let mut expected_m = compliance * changed_n.abs();
        // The same step of an earlier repeat carries more information than the last reading.
        if let Some(slope) = self.same_step_before(taken, before_n, channel) {
            expected_m = slope * changed_n.abs();
            factor = PROPORTION;
        }
        let digit_m = self.stream(channel).last.as_ref()?.resolution_si;
        // Of several gauges one may show the small rest of large motions.
        let small_m = channel.axis().map_or(0.0, |_| {
            SMALL_SHARE * self.largest_m_per_n(taken.cell) * changed_n.abs()
        });
        let slack_m = (STILL_TOLERANCES * settle.spread_m)
            .max(2.0 * STILL_DIGITS * digit_m)
            .max(small_m);
        if changed_n.abs() <= STILL_TOLERANCES * settle.force_tolerance_n {
            return None;
        }
        let little = moved_m.abs() < expected_m / factor - slack_m;
        let much = moved_m.abs() > expected_m * factor + slack_m;
        // Which way a gauge across the load goes, an earlier reading of the cell shows; for one along it there is a rule of its own.
        let is_across = self.plan.leading(taken.cell) != channel;
        let slope = self.slope_m_per_n(taken.cell, channel);
        let slope = slope.filter(|_| is_across);
        let way = slope.map_or(1.0, f64::signum) * changed_n.signum();
        let back = slope.is_some() && moved_m * way < -slack_m;
        (little || much || back).then(|| CaptureCheck {
            rule: "implausible",
            channel,
            text: format!(
                "The force changed by {changed_n:.1} N and the {channel} by {:.1} um, where the cell so far predicts {:.0} um: unit key, zero key, sign, late display, or slip?",
                moved_m * 1e6,
                expected_m * way * 1e6
            ),
            may_pass: little && !back,
            still: None,
        })
    }

    /// What the same change of load gave in an earlier repeat, m/N.
    fn same_step_before(
        &self,
        taken: &TakenReading,
        before_n: f64,
        channel: Channel,
    ) -> Option<f64> {
        let near_n = STILL_TOLERANCES * self.plan.procedure.settle.force_tolerance_n;
        let good = || {
            let all = self
                .state
                .accepted()
                .rev()
                .filter(|kept| is_unflagged(kept));
            let all = all.map(|kept| &kept.taken);
            all.filter(|other| other.cell == taken.cell && other.repeat < taken.repeat)
        };
        let there = good().find(|other| {
            (other.step, other.branch, other.target_n) == (taken.step, taken.branch, taken.target_n)
        })?;
        let from = good().find(|other| {
            other.repeat == there.repeat
                && other.step < there.step
                && (other.force_n - before_n).abs() < near_n
        })?;
        let changed_n = there.force_n - from.force_n;
        let moved_m = there.displacement_of(channel)? - from.displacement_of(channel)?;
        let slope = (moved_m / changed_n).abs();
        (changed_n.abs() > near_n && slope.is_finite()).then_some(slope)
    }

    /// A displacement that is off what its repeats, or the other loads, let expect.
    fn far_from_repeats(&self, taken: &TakenReading, channel: Channel) -> Option<CaptureCheck> {
        let displacement_m = taken.displacement_of(channel)?;
        let reading = load_reading(taken, &self.state, &self.plan);
        let prediction = check_of(&self.state, &self.plan, self.settings.scatter_m).predict(
            (taken.cell, taken.repeat),
            &reading,
            gauge_number(&self.plan, channel),
        )?;
        let off_m = (displacement_m - prediction.expected_m).abs();
        (off_m > prediction.limit_m).then(|| CaptureCheck {
            rule: "implausible",
            channel,
            text: format!(
                "{}{:.1} um at {:.1} N is {:.0} um off the prediction from {}.",
                channel
                    .axis()
                    .map_or_else(String::new, |axis| format!("along {axis}, ")),
                displacement_m * 1e6,
                taken.force_n,
                off_m * 1e6,
                prediction.what
            ),
            may_pass: false,
            still: None,
        })
    }

    /// Whether a gauge uses few last digits, apart from those of the planned loads, which somebody sets.
    pub(super) fn few_digits(&self, channel: Channel) -> Option<FewDigits> {
        let stream = self.stream(channel);
        let half_digit = 0.5 * stream.last.as_ref()?.resolution_si;
        let procedure = &self.plan.procedure;
        stream.few_digits(|value_si| {
            let mut set_n = procedure.loads_n.iter().chain([&procedure.preload_n]);
            let force_n = self.along(channel, value_si);
            channel == Channel::Force && set_n.any(|set_n| (force_n - set_n).abs() < half_digit)
        })
    }

    /// A gauge that uses few last digits counts in coarser steps than it shows, or digits of it stand still.
    fn coarse_steps(&self, channel: Channel) -> Option<CaptureCheck> {
        let stream = self.stream(channel);
        let known = self.state.instruments[channel.index()].as_ref();
        if known.is_some_and(|known| known.step_si.is_some()) {
            return None;
        }
        let few = self.few_digits(channel)?;
        let digit = stream.last.as_ref()?.resolution_si;
        let (factor, unit) = match channel {
            Channel::Force => (1.0, "N"),
            _ => (1e6, "um"),
        };
        let rule = match channel {
            Channel::Force => "force-steps",
            _ => "displacement-steps",
        };
        Some(CaptureCheck {
            rule,
            channel,
            text: format!(
                "The last digit of the {channel} gauge was only {} in {} different values; they are {:.3} {unit} apart: resolution key, or frozen digits?",
                few.digits
                    .chars()
                    .map(String::from)
                    .collect::<Vec<_>>()
                    .join(" or "),
                few.values,
                few.step as f64 * digit * factor
            ),
            may_pass: false,
            still: None,
        })
    }
}

/// The chance that the product of independent chances is as small as theirs (Fisher); a chance of 1 shows nothing and does not count.
fn combined_chance(chances: impl Iterator<Item = f64>) -> f64 {
    let known = chances.filter(|chance| *chance < 1.0);
    let (product, count) = known.fold((1.0, 0), |(product, count), chance| {
        (product * chance, count + 1)
    });
    if product <= 0.0 {
        return product;
    }
    let size = -f64::ln(product);
    let mut term = product;
    let mut chance = 0.0;
    for k in 0..count.max(1) {
        chance += term;
        term *= size / f64::from(k + 1);
    }
    chance
}

#[cfg(test)]
mod tests {
    use super::combined_chance;

    #[test]
    fn chances_are_combined_as_fisher_does() {
        assert_eq!(combined_chance([1.0, 0.02].into_iter()), 0.02);
        assert_eq!(combined_chance([1.0, 1.0].into_iter()), 1.0);
        // The upper tail of chi-squared with four degrees of freedom is e^(-x/2) (1 + x/2), here at x = -2 ln 0.0025.
        let both = combined_chance([0.05, 0.05].into_iter());
        assert!(
            (both - 0.0025 * (1.0 + 400_f64.ln())).abs() < 1e-12,
            "{both}"
        );
        assert_eq!(combined_chance([0.0, 0.5].into_iter()), 0.0);
    }
}
