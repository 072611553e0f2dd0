//! Whether a run agrees with the earlier runs of its cell: its slope, its offset and each of its loads against their predictive distribution.
//!
//! The distribution comes from the earlier runs of the cell, the scatter of all runs of the session, and a stated prior, which counts as
//! [`PRIOR_FREEDOM`] degrees of freedom. All checks of a session together ask in [`CLEAN_SESSIONS_ASKED`] of clean sessions.

use stiffbench_gauges::Channel;
use stiffbench_numeric::statistics::{LeastSquaresLine, student_t_quantile};

use super::contradiction::Contradiction;
use super::event::TakenReading;
use super::plan::{SessionPlan, is_done};
use super::state::{KeptReading, SessionState};

/// Reason of the readings of a run that was taken again because it differed; what was found to be its cause stands behind it.
pub(super) const TAKEN_AGAIN: &str = "a reading of its run contradicted the repeats";

/// Share of clean sessions in which some run is asked about.
const CLEAN_SESSIONS_ASKED: f64 = 0.05;

/// Scatter of the slope of a run before it is known, relative.
const PRIOR_SLOPE: f64 = 0.005;

/// A gauge that moves less than this share of the one that moves most has the slope scatter of this share of it (1).
const LEAST_SHARE: f64 = 0.2;

/// Scatter of the offset of a run, and of a reading, before they are known: this share of the settling spread.
const PRIOR_OF_SPREAD: f64 = 0.5;

/// What the prior counts as, degrees of freedom.
const PRIOR_FREEDOM: f64 = 6.0;

/// Slopes and offsets of real runs have heavier tails than normal ones: their distribution never gets more degrees of freedom.
const MOST_FREEDOM: f64 = 10.0;

/// A load that its own line follows so closely shows nothing (1).
const LEAST_FREE: f64 = 0.01;

/// Slope, offset, loads.
const KINDS: usize = 3;
const LOADS: usize = 2;

/// The readings of one application of the loads.
struct CheckedRun<'a> {
    cell: usize,
    repeat: u32,
    /// Whether it counts; one that was taken again stays in the scatter.
    counts: bool,
    readings: Vec<&'a TakenReading>,
}

impl CheckedRun<'_> {
    fn place(&self) -> (usize, Option<u32>) {
        (self.cell, Some(self.repeat))
    }
}

/// How much a run differs in one respect, in units of the prior scatter.
#[derive(Clone, Copy)]
struct RunDifference {
    cell: usize,
    repeat: u32,
    channel: Channel,
    kind: usize,
    /// Signed; of loads the root of the sum of their squares.
    size: f64,
    freedom: f64,
}

/// A run compared with the earlier runs of its cell, at one gauge.
struct RunComparison {
    /// RunDifference of slope, m/N, and of offset, m, each with its prior scatter.
    line: [(f64, f64); 2],
    /// What the earlier runs yield, m/N.
    slope: f64,
    /// Number of each load, its difference from the line of the others and the prior scatter of that, m.
    loads: Vec<(u32, f64, f64)>,
    /// Sum of the squares about the line, in units of the prior scatter.
    squares: f64,
    /// Degrees of freedom of the loads.
    freedom: f64,
}

/// What stands out in a run.
struct RunFinding {
    /// How many times the limit.
    times: f64,
    /// None for all readings of the run.
    number: Option<u32>,
    text: String,
}

/// From what size a run is asked about.
pub(super) struct AskedFrom {
    /// Slope, relative.
    slope: f64,
    /// Offset, m.
    offset_m: f64,
    /// One load, m.
    load_m: f64,
}

/// The runs of a session as far as they were taken, each compared with those before it.
pub(super) struct RunScatter<'a> {
    state: &'a SessionState,
    plan: &'a SessionPlan,
    channels: Vec<Channel>,
    differences: Vec<RunDifference>,
}

impl<'a> RunScatter<'a> {
    pub(super) fn new(state: &'a SessionState, plan: &'a SessionPlan) -> Self {
        let channels = plan.channels().into_iter();
        Self {
            state,
            plan,
            channels: channels.filter(|of| of.is_displacement()).collect(),
            differences: Vec::new(),
        }
    }

    /// Runs of a cell that differ from those before them, and what all cells have alike, in words.
    pub(super) fn contradictions(&mut self, cell: usize) -> (Vec<Contradiction>, Vec<String>) {
        let runs = self.runs();
        let (mut found, mut alike) = (Vec::new(), Vec::new());
        for (at, run) in runs.iter().enumerate() {
            let before = runs[..at].iter();
            let before = before.filter(|other| other.cell == run.cell && other.counts);
            let before: Vec<&CheckedRun<'_>> =
                before.filter(|of| of.repeat != run.repeat).collect();
            let mut findings = Vec::new();
            let mut differences = Vec::new();
            for channel in self.channels.clone() {
                if let Some(comparison) = self.compare(run, &before, channel) {
                    if run.counts && run.cell == cell {
                        findings.extend(self.findings(run, channel, &comparison, &mut alike));
                    }
                    differences.extend(differences_of(run, channel, &comparison));
                }
            }
            self.differences.extend(differences);
            found.extend(contradiction(run, findings));
        }
        (found, alike)
    }

    /// From what size the next run of a cell is asked about; `None` before its first run.
    pub(super) fn asked_from(&self, cell: usize) -> Option<AskedFrom> {
        let runs = self.runs();
        let runs: Vec<&CheckedRun<'_>> = runs
            .iter()
            .filter(|run| run.cell == cell && run.counts)
            .collect();
        let channel = self.plan.leading(cell);
        let like = runs.last()?;
        let comparison = self.compare(like, &runs, channel)?;
        let limit = |kind: usize, tested: usize| {
            let (scale, freedom) = self.pooled(channel, kind, (cell, None));
            let most = if kind == LOADS { freedom } else { MOST_FREEDOM };
            scale * self.limit(freedom.min(most), tested)
        };
        let loads = comparison.loads.iter().map(|of| of.2);
        let loads = loads.filter(|prior_m| prior_m.is_normal());
        let load_m = loads.fold(0.0, f64::max);
        Some(AskedFrom {
            slope: (limit(0, 1) * comparison.line[0].1 / comparison.slope).abs(),
            offset_m: limit(1, 1) * comparison.line[1].1,
            load_m: limit(LOADS, comparison.loads.len()) * load_m,
        })
    }

    /// All whole runs, in the order in which they were finished.
    fn runs(&self) -> Vec<CheckedRun<'a>> {
        let mut runs: Vec<(u32, CheckedRun<'a>)> = Vec::new();
        let state = self.state;
        for kept in &state.readings {
            let (taken, counts) = (&kept.taken, kept.superseded.is_none());
            let stays = kept.superseded.as_deref() == Some(TAKEN_AGAIN);
            // What is flagged is no measure for others.
            if !(counts || stays) || !is_unflagged(kept) {
                continue;
            }
            let same = runs.iter_mut().find(|(attempt, run)| {
                (run.cell, run.repeat, run.counts) == (taken.cell, taken.repeat, counts)
                    && (counts || *attempt == taken.attempt)
            });
            if let Some((_, run)) = same {
                run.readings.push(taken);
            } else {
                let run = CheckedRun {
                    cell: taken.cell,
                    repeat: taken.repeat,
                    counts,
                    readings: vec![taken],
                };
                runs.push((taken.attempt, run));
            }
        }
        runs.retain(|(_, run)| !run.counts || !self.is_open(run.cell, run.repeat));
        runs.sort_by_key(|(_, run)| run.readings.last().map(|taken| taken.number));
        runs.into_iter().map(|(_, run)| run).collect()
    }

    /// Whether readings of a run are still to be taken.
    pub(super) fn is_open(&self, cell: usize, repeat: u32) -> bool {
        let planned = self.plan.cells.get(cell).map_or(&[][..], |of| &of.readings);
        let of_run = planned.iter().enumerate();
        of_run
            .filter(|(_, reading)| reading.repeat == repeat)
            .any(|(index, _)| !is_done(self.state, (cell, index)))
    }

    /// Force from that under which the zero of a reading was set, N.
    fn force_from_zero(&self, taken: &TakenReading) -> f64 {
        let zero = (taken.cell, taken.zero.clone());
        let zero_n = self.state.zero_forces.get(&zero).copied();
        taken.force_n - zero_n.unwrap_or(self.plan.procedure.preload_n)
    }

    /// What a gauge yields over some runs, m/N.
    fn slope(&self, runs: &[&CheckedRun<'_>], channel: Channel) -> Option<f64> {
        let readings = runs.iter().flat_map(|run| &run.readings);
        let points = readings
            .filter_map(|one| Some((self.force_from_zero(one), one.displacement_of(channel)?)));
        LeastSquaresLine::through(points)
            .filter(|line| line.sxx > 1.0)
            .map(|line| line.slope)
    }

    fn compare(
        &self,
        run: &CheckedRun<'_>,
        before: &[&CheckedRun<'_>],
        channel: Channel,
    ) -> Option<RunComparison> {
        let slope = self.slope(before, channel)?;
        let slopes = self
            .channels
            .iter()
            .filter_map(|of| self.slope(before, *of));
        let largest = slopes.fold(0.0, |most: f64, slope| most.max(slope.abs()));
        let step = |of: Channel| {
            let seen = self.state.instruments[of.index()].as_ref();
            seen.map_or(0.0, |seen| seen.step_si.unwrap_or(seen.resolution_si))
        };
        let (step_m, force_step_m) = (step(channel), slope * step(Channel::Force));
        let prior_m = PRIOR_OF_SPREAD * self.plan.procedure.settle.spread_m;
        let offset_variance = prior_m.powi(2) + step_m.powi(2) / 12.0;
        let reading_variance = offset_variance + force_step_m.powi(2) / 12.0;
        let points = run.readings.iter().filter_map(|one| {
            let force_n = self.force_from_zero(one);
            let earlier = before.iter().flat_map(|of| &of.readings);
            let alike = earlier.filter(|other| {
                (other.step, other.branch) == (one.step, one.branch)
                    && other.target_n.to_bits() == one.target_n.to_bits()
                    && self.hold(other) == self.hold(one)
            });
            let expected = alike.filter_map(|other| {
                let moved_n = force_n - self.force_from_zero(other);
                Some(other.displacement_of(channel)? + slope * moved_n)
            });
            let expected: Vec<f64> = expected.collect();
            let mean_m = expected.iter().sum::<f64>() / expected.len() as f64;
            let off_m = one.displacement_of(channel)? - mean_m;
            (!expected.is_empty()).then_some((one.number, force_n, off_m))
        });
        let points: Vec<(u32, f64, f64)> = points.collect();
        let n = points.len() as f64;
        let line = LeastSquaresLine::through(points.iter().map(|of| (of.1, of.2)))
            .filter(|line| line.sxx > 1.0)?;
        let more = 1.0 + 1.0 / before.len() as f64;
        let centre_n = points.iter().map(|of| of.1).sum::<f64>() / n;
        let leverage = |force_n: f64| 1.0 / n + (force_n - centre_n).powi(2) / line.sxx;
        let left = |of: &(u32, f64, f64)| of.2 - line.at(of.1);
        let squares: f64 = points.iter().map(|of| left(of).powi(2)).sum();
        let freedom = n - 2.0;
        // Of a gauge that is noisier than assumed, the run itself shows it.
        let (scale, known) = self.pooled(channel, LOADS, run.place());
        let of_run = squares / (more * reading_variance);
        let noise = reading_variance * (known * scale.powi(2) + of_run) / (known + freedom);
        let slope_prior = PRIOR_SLOPE * slope.abs().max(LEAST_SHARE * largest);
        let slope_variance = more * (slope_prior.powi(2) + noise / line.sxx);
        let offset_variance = more * (offset_variance + noise * leverage(0.0));
        let loads = points.iter().map(|of| {
            let free = Some(1.0 - leverage(of.1)).filter(|free| *free > LEAST_FREE);
            let free = free.unwrap_or(0.0);
            let variance = more * reading_variance / free;
            (of.0, left(of) / free, variance.sqrt())
        });
        Some(RunComparison {
            line: [
                (line.slope, slope_variance.sqrt()),
                (line.at(0.0), offset_variance.sqrt()),
            ],
            slope,
            squares: of_run,
            loads: loads.collect(),
            freedom: freedom.max(0.0),
        })
    }

    /// Seconds under the load after which a reading was due.
    fn hold(&self, taken: &TakenReading) -> Option<u64> {
        let planned = self.plan.cells.get(taken.cell)?.readings.get(taken.index)?;
        planned.extra_hold_s.map(f64::to_bits)
    }

    /// Scatter of a kind in units of the prior, and its degrees of freedom, without other tries of a run.
    fn pooled(&self, channel: Channel, kind: usize, run: (usize, Option<u32>)) -> (f64, f64) {
        let (cell, repeat) = run;
        let known = self.differences.iter().filter(|of| {
            let same = of.cell == cell && Some(of.repeat) == repeat;
            (of.channel, of.kind) == (channel, kind) && !same
        });
        let sum =
            |sums: (f64, f64), of: &RunDifference| (sums.0 + of.size.powi(2), sums.1 + of.freedom);
        let prior = (PRIOR_FREEDOM, PRIOR_FREEDOM);
        let sums = if kind == LOADS {
            // Soft cells scatter in other proportions than stiff ones: where another cell scatters less, that is no reason to expect it here.
            let (here, there): (Vec<_>, Vec<_>) = known.partition(|of| of.cell == cell);
            let of_others = there.into_iter().fold(prior, sum);
            let square = (of_others.0 / of_others.1).max(1.0);
            here.into_iter()
                .fold((square * PRIOR_FREEDOM, PRIOR_FREEDOM), sum)
        } else {
            known.fold(prior, sum)
        };
        ((sums.0 / sums.1).sqrt(), sums.1)
    }

    /// How many scatters off a run is asked about, where so many values of it are tested alike.
    fn limit(&self, freedom: f64, tested: usize) -> f64 {
        let cells = self.plan.cells.len() as f64;
        let compared = f64::from(self.plan.procedure.repeats.saturating_sub(1)).max(1.0);
        let checks = cells * compared * self.channels.len() as f64 * KINDS as f64;
        let chance = CLEAN_SESSIONS_ASKED / (checks * tested.max(1) as f64);
        student_t_quantile(1.0 - 0.5 * chance, freedom).unwrap_or(f64::INFINITY)
    }

    fn findings(
        &self,
        run: &CheckedRun<'_>,
        channel: Channel,
        comparison: &RunComparison,
        alike: &mut Vec<String>,
    ) -> Vec<RunFinding> {
        let along = channel
            .axis()
            .map_or_else(String::new, |axis| format!(" along {axis}"));
        let planned = &self.plan.cells[run.cell];
        let place = format!(
            "Repeat {} of {} {}{along}",
            run.repeat, planned.pose, planned.direction
        );
        let mut found = Vec::new();
        for (kind, (off, prior)) in comparison.line.into_iter().enumerate() {
            let (scale, freedom) = self.pooled(channel, kind, run.place());
            let limit = self.limit(freedom.min(MOST_FREEDOM), 1) * scale;
            let size = off / prior;
            let differs = if kind == 0 {
                format!(
                    "yields by {:.2} um/N, where its earlier runs predict {:.2} ± {:.2} um/N",
                    (comparison.slope + off) * 1e6,
                    comparison.slope * 1e6,
                    limit * prior * 1e6
                )
            } else {
                let (off_um, limit_um) = (off * 1e6, limit * prior * 1e6);
                format!(
                    "is {off_um:.1} um off its earlier runs, where up to {limit_um:.1} um are usual"
                )
            };
            if size.abs() <= limit {
                continue;
            }
            if self.is_of_all_cells(run, channel, kind, (size, limit)) {
                alike.push(format!(
                    "{place} {differs}: as in the other cells (setting in)"
                ));
                continue;
            }
            found.push(RunFinding {
                times: size.abs() / limit,
                number: None,
                text: format!("{place} {differs}."),
            });
        }
        let (scale, known) = self.pooled(channel, LOADS, run.place());
        for (number, off_m, prior_m) in &comparison.loads {
            let size = (off_m / prior_m).abs();
            // The others show how much a reading scatters.
            let freedom = (known + comparison.freedom - 1.0).max(known);
            let others = (comparison.squares - size.powi(2)).max(0.0);
            let scale = ((known * scale.powi(2) + others) / freedom).sqrt();
            let limit = self.limit(freedom, comparison.loads.len()) * scale;
            if prior_m.is_normal() && size > limit {
                found.push(RunFinding {
                    times: size / limit,
                    // Of three loads any one may be the wrong one.
                    number: Some(*number).filter(|_| comparison.freedom > 1.0),
                    text: format!(
                        "{place}: reading {number} is {:.1} um off the other loads and its repeats, where up to {:.1} um are usual.",
                        off_m * 1e6,
                        limit * prior_m * 1e6
                    ),
                });
            }
        }
        found
    }

    /// Whether the same run of the other cells differed alike: joints and clamps that set in.
    fn is_of_all_cells(
        &self,
        run: &CheckedRun<'_>,
        channel: Channel,
        kind: usize,
        (size, limit): (f64, f64),
    ) -> bool {
        let others = self.differences.iter().filter(|of| {
            (of.channel, of.kind, of.repeat) == (channel, kind, run.repeat) && of.cell != run.cell
        });
        let others: Vec<f64> = others.map(|of| of.size).collect();
        let n = others.len() as f64;
        let mean = others.iter().sum::<f64>() / n;
        n > 0.0 && mean / size > 0.5 && (size - mean).abs() <= limit * (1.0 + 1.0 / n).sqrt()
    }
}

impl AskedFrom {
    /// For the operator.
    pub(super) fn text(&self) -> String {
        format!(
            "the next run is asked about from {:.1} % of its slope, {:.1} um in all its loads, or {:.1} um in one",
            self.slope * 100.0,
            self.offset_m * 1e6,
            self.load_m * 1e6
        )
    }
}

/// All that stands out in a run is one question.
fn contradiction(run: &CheckedRun<'_>, findings: Vec<RunFinding>) -> Option<Contradiction> {
    let whole = findings.iter().any(|of| of.number.is_none());
    let single = findings.iter().filter_map(|of| of.number);
    let numbers = if whole {
        run.readings.iter().map(|taken| taken.number).collect()
    } else {
        single.collect()
    };
    let worst = findings
        .into_iter()
        .max_by(|a, b| a.times.total_cmp(&b.times))?;
    let text = worst.text;
    Some(Contradiction { numbers, text })
}

/// Whether nothing is known against a reading, nor was the operator asked about it.
pub(super) fn is_unflagged(kept: &KeptReading) -> bool {
    kept.taken.flag.is_empty() && kept.flags.is_empty()
}

fn differences_of(
    run: &CheckedRun<'_>,
    channel: Channel,
    comparison: &RunComparison,
) -> [RunDifference; KINDS] {
    let of = |kind: usize, size: f64, freedom: f64| RunDifference {
        cell: run.cell,
        repeat: run.repeat,
        channel,
        kind,
        size,
        freedom,
    };
    let [slope, offset] = comparison.line.map(|(off, prior)| off / prior);
    [
        of(0, slope, 1.0),
        of(1, offset, 1.0),
        of(LOADS, comparison.squares.sqrt(), comparison.freedom),
    ]
}
