//! What looks wrong in a cell. A flag is raised, nothing is taken away.

use thiserror::Error;

use super::significance::TestStatistic;
use super::straight_part::StraightPart;
use stiffbench_units_and_text::count::counted;
use stiffbench_units_and_text::digits::significant;

/// An outlier as many times as far off as its limit puts the stiffness in doubt: it moves the slope of five runs of eight readings by 1.2 standard
/// errors, where U is 2.8.
const FAR: f64 = 2.0;

/// A reading, by the numbers that find it again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReadingPlace {
    /// Sequence number in the session.
    pub seq: u32,
    /// Line of the file; 0 if none.
    pub line: u32,
    /// n-th application, from 1.
    pub repeat: u32,
}

/// What a drift of the zero was seen in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum ZeroEvidence {
    /// Unloaded readings on one gauge zero.
    #[error("unloaded readings")]
    UnloadedReadings,
    /// Intercepts of the runs on one gauge zero, without unloaded readings.
    #[error("intercepts of the runs")]
    Intercepts,
}

/// Something about the readings of a cell that its stiffness does not show.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum Flag {
    /// A reading far from its repeats.
    #[error(
        "reading {} (repeat {}, {target_n} N) is {} from what the other readings predict, pooled standard deviation {}: {}",
        .place.seq, .place.repeat, signed_um(*.deviation_m), um(*.sd_m), tested(.test, um)
    )]
    Outlier {
        /// The reading.
        place: ReadingPlace,
        /// Its target, N.
        target_n: f64,
        /// Distance from what the other readings predict for it, m: the deleted residual, which the reading itself does not pull.
        deviation_m: f64,
        /// Pooled standard deviation of a reading, m.
        sd_m: f64,
        /// The test; `detectable` in m.
        test: TestStatistic,
    },
    /// Stiffness of the runs moves with the repeat number.
    #[error("the stiffness of the runs changes by {} per repeat: {}", signed_percent(*.per_repeat), tested(.test, percent))]
    RepeatTrend {
        /// Relative change per repeat.
        per_repeat: f64,
        /// The test; `detectable` relative per repeat.
        test: TestStatistic,
    },
    /// The zero moves with time while the gauge is not zeroed again.
    #[error("the {evidence} on one gauge zero move by {} from first to last: {}", signed_um(*.change_m), tested(.test, um))]
    ZeroDrift {
        /// Change from the first to the last run on this zero, m.
        change_m: f64,
        /// What it was seen in.
        evidence: ZeroEvidence,
        /// The test; `detectable` in m.
        test: TestStatistic,
    },
    /// The gauge does not come back to where it was before the loads.
    #[error(
        "after unloading, the gauge shows {} from its start (mean of {}): {}",
        signed_um(*.mean_m), counted(.n_runs, "run"), tested(.test, um)
    )]
    ReturnToZero {
        /// Mean over the runs of unloaded reading after minus before, m.
        mean_m: f64,
        /// Runs with both readings.
        n_runs: usize,
        /// The test; `detectable` in m.
        test: TestStatistic,
    },
    /// Displacement falls back from one load to the next larger one.
    #[error("the displacement falls back by {} from {from_target_n} N to {to_target_n} N: {}", um(*.drop_m), tested(.test, um))]
    NotMonotonic {
        /// The smaller load, N.
        from_target_n: f64,
        /// The larger load, N.
        to_target_n: f64,
        /// By how much, m.
        drop_m: f64,
        /// The test; `detectable` in m.
        test: TestStatistic,
    },
    /// Forces measured against the direction of their target.
    #[error(
        "{n_opposite} of {n} forces at {target_n} N have the other sign: check the polarity of the force gauge"
    )]
    ForceSign {
        /// The target, N.
        target_n: f64,
        /// Readings with the other sign.
        n_opposite: usize,
        /// Readings of this load.
        n: usize,
    },
    /// The force measured at a load that should not be zero is zero in the mean.
    #[error("the mean force measured at {target_n} N is zero")]
    ZeroForce {
        /// The target, N.
        target_n: f64,
    },
    /// Displacement against the force.
    #[error(
        "at {target_n} N the mean force is {force_n:.2} N and the mean displacement {}: opposite signs, F/δ has no meaning there",
        um(*.displacement_m)
    )]
    DisplacementSign {
        /// The target, N.
        target_n: f64,
        /// Mean force, N.
        force_n: f64,
        /// Mean displacement, m.
        displacement_m: f64,
    },
    /// A mean displacement too small for a ratio with a meaning.
    #[error(
        "at {target_n} N the mean displacement {} is within {} of zero (95 % of its scatter, at least half a step): F/δ there is mostly noise",
        um(*.displacement_m), um(*.limit_m)
    )]
    DisplacementNotResolved {
        /// The target, N.
        target_n: f64,
        /// Mean displacement, m.
        displacement_m: f64,
        /// What it would have to exceed, m.
        limit_m: f64,
    },
    /// The slope of displacement on force is negative.
    #[error(
        "the slope gives {} N/µm: force and displacement move against each other, check the polarity of the gauges",
        significant(.stiffness_n_per_m / 1e6, 4)
    )]
    NegativeStiffness {
        /// 1/slope, N/m.
        stiffness_n_per_m: f64,
    },
    /// The slope does not stand clear of its uncertainty, so that 1/slope and its interval mean little.
    #[error(
        "the slope is only {ratio:.1} times its standard uncertainty (limit 5): do not trust the interval of its inverse"
    )]
    SlopeNotResolved {
        /// Slope over its standard uncertainty.
        ratio: f64,
    },
    /// The repeats refute the straight line whose slope the stiffness is.
    #[error(
        "the loads do not lie on a straight line: K is {} and {} (lack of fit against the {}, F({:.0}, {:.0}) = {f:.1}, p < 0.01; the largest departure is {:.1} µm, {:.1} % of the range). U applies to the line and does not include the curvature: state K with a range of loads (stiffbench stiffness --from-load N --to-load N){}",
        half(&.halves[0]), half(&.halves[1]), if *.by_repeats { "repeats" } else { "scatter of neighbours" }, .dof[0], .dof[1],
        1e6 * .departure_m, 100.0 * .departure_share, .part.map_or_else(String::new, |part| format!(". {part}"))
    )]
    NotStraight {
        /// Lack of fit: F of the step means about the line against step times run.
        f: f64,
        /// Degrees of freedom of both.
        dof: [f64; 2],
        /// Two halves of the loads: their ends, N, and the stiffness there, N/m.
        halves: [([f64; 2], f64); 2],
        /// Whether repeats tell the scatter; else neighbours in a run of many readings do.
        by_repeats: bool,
        /// The largest distance of a load's mean from the line, m.
        departure_m: f64,
        /// Its share of the range of displacements.
        departure_share: f64,
        /// The loads that do lie on a line.
        part: Option<StraightPart>,
    },
    /// Fewer than three loads: curvature, dead zone and offset cannot be distinguished from the slope.
    #[error("{} under force (limit 3): an offset or curvature cannot be distinguished from the slope", counted(.n, "load"))]
    TooFewLoads {
        /// Distinct loads under force.
        n: usize,
    },
}

impl Flag {
    /// Stable name of the rule.
    #[must_use]
    pub fn rule(&self) -> &'static str {
        match self {
            Self::Outlier { .. } => "outlier",
            Self::RepeatTrend { .. } => "repeat-trend",
            Self::ZeroDrift { .. } => "zero-drift",
            Self::ReturnToZero { .. } => "return-to-zero",
            Self::NotMonotonic { .. } => "not-monotonic",
            Self::ForceSign { .. } => "force-sign",
            Self::ZeroForce { .. } => "zero-force",
            Self::DisplacementSign { .. } => "displacement-sign",
            Self::DisplacementNotResolved { .. } => "displacement-not-resolved",
            Self::NegativeStiffness { .. } => "negative-stiffness",
            Self::SlopeNotResolved { .. } => "slope-not-resolved",
            Self::NotStraight { .. } => "not-straight",
            Self::TooFewLoads { .. } => "too-few-loads",
        }
    }

    /// Whether the stiffness itself is in doubt. An outlier at its limit moves the slope of a cell by less than its U.
    #[must_use]
    pub fn spoils_stiffness(&self) -> bool {
        match self {
            Self::Outlier { test, .. } => test.statistic > FAR * test.limit,
            Self::NegativeStiffness { .. }
            | Self::SlopeNotResolved { .. }
            | Self::NotStraight { .. } => true,
            _ => false,
        }
    }

    /// The loads that lie on a line, where a flag says that not all do.
    #[must_use]
    pub fn straight_part(&self) -> Option<&StraightPart> {
        match self {
            Self::NotStraight { part, .. } => part.as_ref(),
            _ => None,
        }
    }

    /// The test behind the flag, if it is a question of scatter.
    #[must_use]
    pub fn test(&self) -> Option<TestStatistic> {
        match self {
            Self::Outlier { test, .. }
            | Self::RepeatTrend { test, .. }
            | Self::ZeroDrift { test, .. }
            | Self::ReturnToZero { test, .. }
            | Self::NotMonotonic { test, .. } => Some(*test),
            _ => None,
        }
    }
}

/// A length in micrometres, to hundredths.
fn um(metres: f64) -> String {
    format!("{:.2} µm", metres * 1e6)
}

/// The same of a change, with its sign.
fn signed_um(metres: f64) -> String {
    format!("{:+.2} µm", metres * 1e6)
}

fn percent(share: f64) -> String {
    format!("{} % per repeat", significant(100.0 * share, 3))
}

/// A change in percent, with its sign.
fn signed_percent(share: f64) -> String {
    let sign = if share < 0.0 { "-" } else { "+" };
    format!("{sign}{} %", significant(100.0 * share.abs(), 3))
}

/// The stiffness of a half of the loads.
fn half(([from, to], stiffness_n_per_m): &([f64; 2], f64)) -> String {
    format!(
        "{} N/µm from {from} to {to} N",
        significant(stiffness_n_per_m / 1e6, 4)
    )
}

/// The words that close every tested flag: rule, threshold, power.
fn tested(test: &TestStatistic, detectable: fn(f64) -> String) -> String {
    format!(
        "{:.2} standard errors, limit {:.2} for 5 % over {}; 80 % of cases of {} would be found",
        test.statistic,
        test.limit,
        counted(test.n_tested, "comparison"),
        detectable(test.detectable)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tested_flag_states_rule_threshold_and_power() {
        let flag = Flag::Outlier {
            place: ReadingPlace {
                seq: 17,
                line: 18,
                repeat: 3,
            },
            target_n: -40.0,
            deviation_m: -31e-6,
            sd_m: 6e-6,
            test: TestStatistic::new(5.8, 4.02, 480, 6.7e-6),
        };
        assert_eq!(flag.rule(), "outlier");
        assert_eq!(
            flag.to_string(),
            "reading 17 (repeat 3, -40 N) is -31.00 µm from what the other readings predict, pooled standard deviation 6.00 µm: \
             5.80 standard errors, limit 4.02 for 5 % over 480 comparisons; 80 % of cases of 32.57 µm would be found"
        );
    }

    #[test]
    fn every_flag_has_words() {
        let test = TestStatistic::new(5.0, 3.0, 12, 1e-6);
        let flags = [
            Flag::RepeatTrend {
                per_repeat: 0.01,
                test,
            },
            Flag::ZeroDrift {
                change_m: 1e-5,
                evidence: ZeroEvidence::Intercepts,
                test,
            },
            Flag::ReturnToZero {
                mean_m: 1e-5,
                n_runs: 5,
                test,
            },
            Flag::NotMonotonic {
                from_target_n: -10.0,
                to_target_n: -20.0,
                drop_m: 1e-5,
                test,
            },
            Flag::ForceSign {
                target_n: -10.0,
                n_opposite: 2,
                n: 5,
            },
            Flag::ZeroForce { target_n: -10.0 },
            Flag::DisplacementSign {
                target_n: -10.0,
                force_n: -9.9,
                displacement_m: 3e-6,
            },
            Flag::DisplacementNotResolved {
                target_n: -10.0,
                displacement_m: -3e-6,
                limit_m: 5e-6,
            },
            Flag::NegativeStiffness {
                stiffness_n_per_m: -5e4,
            },
            Flag::SlopeNotResolved { ratio: 2.0 },
            Flag::NotStraight {
                f: 1e4,
                dof: [11.0, 44.0],
                halves: [([10.0, 40.0], 4e4), ([40.0, 70.0], 5e4)],
                by_repeats: true,
                departure_m: 2e-5,
                departure_share: 0.02,
                part: None,
            },
            Flag::TooFewLoads { n: 1 },
        ];
        for flag in flags {
            let text = flag.to_string();
            assert!(text.len() > 30 && !text.contains("NaN"), "{text}");
            let says_limit = text.contains("limit") == flag.test().is_some();
            let fixed = matches!(
                flag,
                Flag::SlopeNotResolved { .. } | Flag::TooFewLoads { .. }
            );
            assert!(says_limit || fixed, "{text}");
        }
    }
}
