//! Whether readings agree with their repeats: the slope and the offset of a run, and each of its loads, against their predictive distribution.
//!
//! The distribution comes from the other runs of the cell, the scatter of all runs of the session, and a stated prior, which counts as six
//! degrees of freedom; a zero is a reading too, and scatters as they do. All checks of a session together ask in one clean session of twenty.
//! A session asks while the robot still stands there, an analysis says what a session would have asked.

use std::collections::HashMap;

use stiffbench_numeric::statistics::{LeastSquaresLine, student_t_quantile};
use stiffbench_units_and_text::test_point::{Branch, Direction};

use crate::procedure::Settle;

/// Share of clean sessions in which something is asked about.
const CLEAN_SESSIONS_ASKED: f64 = 0.05;

/// Scatter of the slope of a run before it is known, relative.
const PRIOR_SLOPE: f64 = 0.005;

/// A gauge that moves less than this share of the one that moves most has the slope scatter of this share of it (1).
const LEAST_SHARE: f64 = 0.2;

/// Scatter of readings before it is known, where nobody states it: this share of the settling spread, within which a display stays.
const PRIOR_OF_SPREAD: f64 = 0.5;

/// What the prior counts as, degrees of freedom.
const PRIOR_FREEDOM: f64 = 6.0;

/// Slopes and offsets of real runs have heavier tails than normal ones: their distribution never gets more degrees of freedom.
const MOST_FREEDOM: f64 = 10.0;

/// A load that its own line follows so closely shows nothing (1).
const LEAST_FREE: f64 = 0.01;

/// Slope, offset, loads.
const KINDS: usize = 3;
const SLOPE: usize = 0;
const OFFSET: usize = 1;
const LOADS: usize = 2;

/// Without repeats a displacement is far from what the other loads of its run let expect beyond this many settling spreads and this share.
const FAR_FROM_LINE: (f64, f64) = (20.0, 0.5);

/// Fewest loads whose line lets expect anything.
const FEWEST_LOADS: usize = 3;

/// Readings of a run that its repeats contradict.
#[derive(Debug, Clone, PartialEq)]
pub struct Contradiction {
    /// Numbers of the readings, all of one run.
    pub numbers: Vec<u32>,
    /// Which they are, what was read and what would have been expected: one sentence for the operator.
    pub text: String,
}

/// The readings of all gauges under one load.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadReading {
    /// Its number in the session.
    pub number: u32,
    /// Place in the load sequence.
    pub step: u32,
    /// Loading or unloading.
    pub branch: Branch,
    /// What was aimed at, N.
    pub target_n: f64,
    /// Which reading under this load it is: the same number in each run.
    pub hold: u64,
    /// Force from that under which its zero was set, N.
    pub force_n: f64,
    /// Displacement from the zero, m, a gauge each.
    pub displacement_m: Vec<Option<f64>>,
    /// Whether something is known against it: then it is no measure for others.
    pub is_flagged: bool,
}

/// The readings of one application of the loads, in the order in which they were taken.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedRun {
    /// Number of its pose and direction.
    pub cell: usize,
    /// n-th application.
    pub repeat: u32,
    /// Whether it counts; one that was taken again stays in the scatter.
    pub counts: bool,
    /// Whether all its readings are there.
    pub is_whole: bool,
    /// What they are.
    pub readings: Vec<LoadReading>,
}

/// What is known of a session besides its readings.
#[derive(Debug, Clone, PartialEq)]
pub struct RunTerms {
    /// When a reading counts as settled.
    pub settle: Settle,
    /// Whether each run has a zero of its own; runs that share one do not scatter by it.
    pub zero_each_run: bool,
    /// Scatter of readings, m, where somebody states it.
    pub scatter_m: Option<f64>,
    /// Step of the force gauge, N.
    pub force_step_n: f64,
    /// The displacement gauges: the axis along which each stands if that is not the load's, and its step, m.
    pub gauges: Vec<(Option<Direction>, f64)>,
    /// Names of pose and direction of each cell.
    pub cells: Vec<String>,
    /// Runs that are planned in a cell.
    pub repeats: u32,
}

/// What repeats have in common: step, branch, target, and which reading under the load it is.
type LoadKey = (u32, Branch, u64, u64);

impl LoadReading {
    fn key(&self) -> LoadKey {
        (self.step, self.branch, self.target_n.to_bits(), self.hold)
    }
}

/// How much a run differs in one respect, in units of the prior scatter.
#[derive(Clone, Copy)]
struct RunDifference {
    cell: usize,
    repeat: u32,
    gauge: usize,
    kind: usize,
    /// Signed; of loads the root of the sum of their squares.
    size: f64,
    freedom: f64,
    /// What the earlier runs yield, m/N.
    slope: f64,
}

/// A run compared with the earlier runs of its cell, at one gauge.
struct RunComparison {
    /// Difference of slope, m/N, and of offset, m, each with its prior scatter.
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

/// What is expected of a reading.
pub struct LoadPrediction {
    /// Displacement, m.
    pub expected_m: f64,
    /// How far from that it is asked about, m.
    pub limit_m: f64,
    /// From what it follows.
    pub what: &'static str,
}

/// The runs of a session as far as they were taken.
pub struct RunCheck {
    terms: RunTerms,
    runs: Vec<LoadedRun>,
    /// Where in each run a load stands.
    places: Vec<HashMap<LoadKey, usize>>,
    /// Of each whole run from those before it.
    differences: Vec<RunDifference>,
}

/// The least-squares line through some points (N, m); `None` where their forces are all alike.
fn line_through(points: impl Iterator<Item = (f64, f64)> + Clone) -> Option<LeastSquaresLine> {
    LeastSquaresLine::through(points).filter(|line| line.sxx > 1.0)
}

/// Force and displacement of the loading branch at a gauge.
fn loading_points<'a>(
    readings: impl Iterator<Item = &'a LoadReading>,
    gauge: usize,
) -> Vec<(f64, f64)> {
    let loading = readings.filter(|one| one.branch == Branch::Loading);
    loading
        .filter_map(|one| Some((one.force_n, one.displacement_m[gauge]?)))
        .collect()
}

impl LoadedRun {
    /// Whether more than half of it has a flag: then no others are measured by it.
    fn is_mostly_flagged(&self) -> bool {
        let flagged = self.readings.iter().filter(|one| one.is_flagged);
        2 * flagged.count() > self.readings.len()
    }
}

impl RunCheck {
    /// Compares runs.
    ///
    /// # Arguments
    /// - `runs`: in the order in which they were finished.
    #[must_use]
    pub fn new(terms: RunTerms, runs: Vec<LoadedRun>) -> Self {
        let places = runs.iter().map(|run| {
            let readings = run.readings.iter().enumerate();
            let readings = readings.filter(|(_, one)| !one.is_flagged);
            readings.map(|(place, one)| (one.key(), place)).collect()
        });
        let mut check = Self {
            terms,
            places: places.collect(),
            runs,
            differences: Vec::new(),
        };
        let whole = (0..check.runs.len()).filter(|at| check.runs[*at].is_whole);
        check.differences = check.differences_of(&whole.collect::<Vec<_>>(), Vec::new());
        check
    }

    /// Runs of a cell that the others contradict, the worst first, and what all cells have alike, in words.
    #[must_use]
    pub fn contradictions(&self, cell: usize) -> (Vec<Contradiction>, Vec<String>) {
        let mut alike = Vec::new();
        let all = self.before(self.runs.len(), cell, None);
        // Of two runs that contradict each other the later is asked about.
        let from = usize::from(all.len() == 2);
        let found = all[from..].iter();
        let found = found.filter_map(|at| self.judged(*at, &mut alike));
        let mut found: Vec<(f64, Contradiction)> = found.collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        (found.into_iter().map(|(_, found)| found).collect(), alike)
    }

    /// From what size the next run of a cell is asked about, for the operator; `None` before its first run.
    ///
    /// # Arguments
    /// - `gauge`: the one that moves most with the load.
    #[must_use]
    pub fn asked_from(&self, cell: usize, gauge: usize) -> Option<String> {
        let runs = self.before(self.runs.len(), cell, None);
        let like = &self.runs[*runs.last()?];
        let comparison = self.compare(like, &runs, gauge, &self.differences)?;
        let scatter = |kind: usize, tested: usize| {
            let of = (gauge, kind, cell, comparison.slope);
            self.limit_of(&self.differences, of, tested)
        };
        let [slope, offset] = comparison.line;
        let loads = comparison.loads.iter().map(|of| of.2);
        let loads = loads.filter(|prior_m| prior_m.is_normal());
        let load_m = loads.fold(0.0, f64::max);
        Some(format!(
            "the next run is asked about from {:.1} % of its slope, {:.1} um in all its loads, or {:.1} um in one",
            (scatter(SLOPE, 1) * slope.1 / comparison.slope).abs() * 100.0,
            scatter(OFFSET, 1) * offset.1 * 1e6,
            scatter(LOADS, comparison.loads.len()) * load_m * 1e6
        ))
    }

    /// What is expected of a reading that is to be taken.
    ///
    /// # Arguments
    /// - `run`: cell and repeat of the reading.
    #[must_use]
    pub fn predict(
        &self,
        run: (usize, u32),
        reading: &LoadReading,
        gauge: usize,
    ) -> Option<LoadPrediction> {
        let (cell, repeat) = run;
        let all = (0..self.runs.len()).filter(|of| self.runs[*of].counts);
        let all: Vec<usize> = all.filter(|of| self.runs[*of].cell == cell).collect();
        let is_other = |of: &usize| self.runs[*of].repeat != repeat;
        let others: Vec<usize> = all.iter().copied().filter(is_other).collect();
        let repeats = self.of_repeats((cell, &others), reading, gauge, &self.differences);
        // Its run is judged when it is complete: slope, offset and scatter may each be all that is not asked about then.
        let repeats = repeats.map(|(expected_m, limits_m)| LoadPrediction {
            expected_m,
            limit_m: limits_m.iter().sum(),
            what: "its repeats",
        });
        repeats.or_else(|| {
            let points = loading_points(self.readings(&all), gauge);
            let is_known = points.len() >= FEWEST_LOADS;
            let line = line_through(points.into_iter()).filter(|_| is_known)?;
            Some(self.on_line(line.at(reading.force_n)))
        })
    }

    /// The displacement that the repeats of a reading let expect, and how far the slope, the offset and the scatter of its run may take it from there
    /// without a question, m.
    fn of_repeats(
        &self,
        (cell, others): (usize, &[usize]),
        reading: &LoadReading,
        gauge: usize,
        scatter: &[RunDifference],
    ) -> Option<(f64, [f64; KINDS])> {
        let shown = self.slope(others, gauge);
        let (expected_m, n) = self.expected(reading, others, gauge, shown.unwrap_or(0.0))?;
        // Where nothing shows the slope, the displacement counts from the zero.
        let slope = shown.unwrap_or(expected_m / reading.force_n);
        let slope = if slope.is_finite() { slope } else { 0.0 };
        let limit_m = |kind: usize, tested: usize, prior_m: f64| {
            let limit = self.limit_of(scatter, (gauge, kind, cell, slope), tested);
            (1.0 + 1.0 / n).sqrt() * limit * prior_m
        };
        let reading_m = self.reading_variance(gauge, slope).sqrt();
        let zero_m = reading_m * pooled(scatter, (gauge, LOADS, cell, slope)).0;
        let slope_m = self.slope_prior(others, gauge, slope) * reading.force_n.abs();
        let tested = others.iter().map(|of| self.runs[*of].readings.len()).max();
        // Forces that nothing corrects differ by what they were set to.
        let tolerance_n = self.terms.settle.force_tolerance_n;
        let set_m = shown.map_or(2.0 * tolerance_n * slope.abs(), |_| 0.0);
        let limits_m = [
            limit_m(SLOPE, 1, slope_m) + set_m,
            limit_m(OFFSET, 1, zero_m),
            limit_m(LOADS, tested.unwrap_or(1), reading_m),
        ];
        Some((expected_m, limits_m))
    }

    /// What the other loads of the loading branch let expect.
    fn on_line(&self, expected_m: f64) -> LoadPrediction {
        let (spreads, share) = FAR_FROM_LINE;
        LoadPrediction {
            expected_m,
            limit_m: (spreads * self.terms.settle.spread_m).max(share * expected_m.abs()),
            what: "the other loads",
        }
    }

    /// The readings of some runs that nothing is known against.
    fn readings(&self, runs: &[usize]) -> impl Iterator<Item = &LoadReading> + Clone {
        let all = runs.iter().flat_map(|of| &self.runs[*of].readings);
        all.filter(|one| !one.is_flagged)
    }

    /// The whole runs of a cell that count, up to one, without other tries of a repeat.
    fn before(&self, end: usize, cell: usize, repeat: Option<u32>) -> Vec<usize> {
        let runs = self.runs[..end].iter().enumerate();
        let runs = runs.filter(|(_, of)| of.cell == cell && of.counts && of.is_whole);
        let runs = runs.filter(|(_, of)| Some(of.repeat) != repeat);
        runs.map(|(at, _)| at).collect()
    }

    /// How many limits a run is off the others of its cell, and how; the scatter is that without it.
    fn judged(&self, at: usize, alike: &mut Vec<String>) -> Option<(f64, Contradiction)> {
        let run = &self.runs[at];
        let others = self.before(self.runs.len(), run.cell, Some(run.repeat));
        let is_here = |of: &usize| self.runs[*of].cell == run.cell && self.runs[*of].is_whole;
        let here = (0..self.runs.len()).filter(is_here);
        let here = here.filter(|of| self.runs[*of].repeat != run.repeat);
        let there = self.differences.iter().filter(|of| of.cell != run.cell);
        let scatter = self.differences_of(&here.collect::<Vec<_>>(), there.copied().collect());
        let gauges = 0..self.terms.gauges.len();
        let findings = gauges.flat_map(|gauge| {
            if run.readings.len() < FEWEST_LOADS {
                return self.single_loads(run, &others, gauge, &scatter);
            }
            let comparison = self.compare(run, &others, gauge, &scatter);
            comparison.map_or_else(Vec::new, |of| {
                self.findings(run, gauge, &of, &scatter, alike)
            })
        });
        let findings = findings.collect();
        contradiction(run, findings)
    }

    /// Loads of a run of which too few are left for a line, each by itself against the others of its cell.
    fn single_loads(
        &self,
        run: &LoadedRun,
        others: &[usize],
        gauge: usize,
        scatter: &[RunDifference],
    ) -> Vec<RunFinding> {
        let found = run.readings.iter().filter_map(|one| {
            let (expected_m, limits_m) =
                self.of_repeats((run.cell, others), one, gauge, scatter)?;
            let off_m = one.displacement_m[gauge]? - expected_m;
            // They do not depend on each other.
            let limit_m = limits_m.iter().map(|of| of.powi(2)).sum::<f64>().sqrt();
            (off_m.abs() > limit_m).then(|| RunFinding {
                times: off_m.abs() / limit_m,
                number: Some(one.number),
                text: self.load_text(run, gauge, one.number, [off_m, limit_m]),
            })
        });
        found.collect()
    }

    fn load_text(&self, run: &LoadedRun, gauge: usize, number: u32, m: [f64; 2]) -> String {
        format!(
            "{}: reading {number} is {:.1} um off the other loads and its repeats, where up to {:.1} um are usual.",
            self.place(run, gauge),
            m[0] * 1e6,
            m[1] * 1e6
        )
    }

    /// How much runs differ from those before them, beside what is known.
    fn differences_of(&self, runs: &[usize], mut known: Vec<RunDifference>) -> Vec<RunDifference> {
        for (place, at) in runs.iter().enumerate() {
            let run = &self.runs[*at];
            let before = runs[..place].iter().copied();
            let before = before.filter(|of| {
                let of = &self.runs[*of];
                (of.cell, of.counts) == (run.cell, true) && of.repeat != run.repeat
            });
            let before: Vec<usize> = before.collect();
            if run.is_mostly_flagged() {
                continue;
            }
            for gauge in 0..self.terms.gauges.len() {
                if let Some(comparison) = self.compare(run, &before, gauge, &known) {
                    known.extend(comparison.differences(run, gauge));
                }
            }
        }
        known
    }

    /// What a gauge yields over some runs, m/N.
    fn slope(&self, runs: &[usize], gauge: usize) -> Option<f64> {
        let readings = self.readings(runs);
        let points = readings.filter_map(|one| Some((one.force_n, one.displacement_m[gauge]?)));
        line_through(points).map(|line| line.slope)
    }

    /// Prior scatter of the slope of a gauge that yields so much, m/N.
    fn slope_prior(&self, runs: &[usize], gauge: usize, slope: f64) -> f64 {
        let others = (0..self.terms.gauges.len()).filter(|other| *other != gauge);
        let slopes = others.filter_map(|of| self.slope(runs, of));
        let largest = slopes.fold(slope.abs(), |most: f64, slope| most.max(slope.abs()));
        PRIOR_SLOPE * slope.abs().max(LEAST_SHARE * largest)
    }

    /// Prior variance of a reading, m².
    fn reading_variance(&self, gauge: usize, slope: f64) -> f64 {
        let steps_m = [self.terms.gauges[gauge].1, slope * self.terms.force_step_n];
        let of_steps = steps_m.map(|step_m| step_m.powi(2) / 12.0);
        let stated_m = self.terms.scatter_m;
        let prior_m = stated_m.unwrap_or(PRIOR_OF_SPREAD * self.terms.settle.spread_m);
        prior_m.powi(2) + of_steps[0] + of_steps[1]
    }

    /// Mean displacement of the repeats of a reading at its force, m, and how many there are.
    fn expected(
        &self,
        reading: &LoadReading,
        runs: &[usize],
        gauge: usize,
        slope: f64,
    ) -> Option<(f64, f64)> {
        let alike = runs.iter().filter_map(|of| {
            let place = self.places[*of].get(&reading.key())?;
            Some(&self.runs[*of].readings[*place])
        });
        let expected = alike.filter_map(|other| {
            Some(other.displacement_m[gauge]? + slope * (reading.force_n - other.force_n))
        });
        let expected: Vec<f64> = expected.collect();
        let n = expected.len() as f64;
        (n > 0.0).then(|| (expected.iter().sum::<f64>() / n, n))
    }

    fn compare(
        &self,
        run: &LoadedRun,
        before: &[usize],
        gauge: usize,
        scatter: &[RunDifference],
    ) -> Option<RunComparison> {
        let slope = self.slope(before, gauge)?;
        let reading_variance = self.reading_variance(gauge, slope);
        // Where few readings of a run are left without a flag, all of them judge it.
        let all = run.is_mostly_flagged();
        let readings = run.readings.iter().filter(|one| all || !one.is_flagged);
        let points = readings.filter_map(|one| {
            let (expected_m, _) = self.expected(one, before, gauge, slope)?;
            Some((
                one.number,
                one.force_n,
                one.displacement_m[gauge]? - expected_m,
            ))
        });
        let points: Vec<(u32, f64, f64)> = points.collect();
        let n = points.len() as f64;
        let line = line_through(points.iter().map(|of| (of.1, of.2)))?;
        let more = 1.0 + 1.0 / before.len() as f64;
        let leverage = |force_n: f64| 1.0 / n + (force_n - line.mean.0).powi(2) / line.sxx;
        let freedom = n - 2.0;
        // Of a gauge that is noisier than assumed, the run itself shows it.
        let (scale, known) = pooled(scatter, (gauge, LOADS, run.cell, slope));
        let of_run = line.residual_squares / (more * reading_variance);
        let noise = reading_variance * (known * scale.powi(2) + of_run) / (known + freedom);
        let slope_prior = self.slope_prior(before, gauge, slope);
        let slope_variance = more * (slope_prior.powi(2) + noise / line.sxx);
        let of_zero = f64::from(u8::from(self.terms.zero_each_run));
        let offset_variance = more * noise * (of_zero + leverage(0.0));
        let loads = points.iter().map(|of| {
            let free = Some(1.0 - leverage(of.1)).filter(|free| *free > LEAST_FREE);
            let free = free.unwrap_or(0.0);
            let variance = more * reading_variance / free;
            (of.0, (of.2 - line.at(of.1)) / free, variance.sqrt())
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

    /// How many scatters off a run is asked about, where so many values of it are tested alike.
    fn limit(&self, freedom: f64, tested: usize) -> f64 {
        let RunTerms {
            repeats,
            gauges,
            cells,
            ..
        } = &self.terms;
        let repeats = f64::from(*repeats);
        // The second run of a cell is judged by the first, and after each later one all of them by the others.
        let looks = (0.5 * repeats * (repeats + 1.0) - 2.0).max(1.0);
        let checks = looks * (cells.len() * gauges.len() * KINDS * tested.max(1)) as f64;
        let chance = CLEAN_SESSIONS_ASKED / checks;
        student_t_quantile(1.0 - 0.5 * chance, freedom).unwrap_or(f64::INFINITY)
    }

    /// The same in units of the prior, where the scatter is known so far.
    fn limit_of(
        &self,
        scatter: &[RunDifference],
        of: (usize, usize, usize, f64),
        tested: usize,
    ) -> f64 {
        let (scale, freedom) = pooled(scatter, of);
        let most = if of.1 == LOADS { freedom } else { MOST_FREEDOM };
        scale * self.limit(freedom.min(most), tested)
    }

    /// For the operator.
    fn place(&self, run: &LoadedRun, gauge: usize) -> String {
        let along = self.terms.gauges[gauge].0;
        let along = along.map_or_else(String::new, |axis| format!(" along {axis}"));
        let cell = self.terms.cells.get(run.cell).map_or("", String::as_str);
        format!("Repeat {} of {cell}{along}", run.repeat)
    }

    fn findings(
        &self,
        run: &LoadedRun,
        gauge: usize,
        comparison: &RunComparison,
        scatter: &[RunDifference],
        alike: &mut Vec<String>,
    ) -> Vec<RunFinding> {
        let place = self.place(run, gauge);
        let of = |kind: usize| (gauge, kind, run.cell, comparison.slope);
        let mut found = Vec::new();
        for (kind, (off, prior)) in comparison.line.into_iter().enumerate() {
            let limit = self.limit_of(scatter, of(kind), 1);
            let size = off / prior;
            let differs = if kind == SLOPE {
                format!(
                    "yields by {:.2} um/N, where the others predict {:.2} ± {:.2} um/N",
                    (comparison.slope + off) * 1e6,
                    comparison.slope * 1e6,
                    limit * prior * 1e6
                )
            } else {
                let (off_um, limit_um) = (off * 1e6, limit * prior * 1e6);
                format!("is {off_um:.1} um off the others, where up to {limit_um:.1} um are usual")
            };
            if size.abs() <= limit {
                continue;
            }
            if self.is_of_all_cells(run, gauge, kind, (size, limit)) {
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
        let (scale, known) = pooled(scatter, of(LOADS));
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
                    text: self.load_text(run, gauge, *number, [*off_m, limit * prior_m]),
                });
            }
        }
        found
    }

    /// Whether the same run of the other cells differed alike: joints and clamps that set in.
    fn is_of_all_cells(
        &self,
        run: &LoadedRun,
        gauge: usize,
        kind: usize,
        (size, limit): (f64, f64),
    ) -> bool {
        let others = self.differences.iter().filter(|of| {
            (of.gauge, of.kind, of.repeat) == (gauge, kind, run.repeat) && of.cell != run.cell
        });
        let others: Vec<f64> = others.map(|of| of.size).collect();
        let n = others.len() as f64;
        let mean = others.iter().sum::<f64>() / n;
        n > 0.0 && mean / size > 0.5 && (size - mean).abs() <= limit * (1.0 + 1.0 / n).sqrt()
    }
}

/// Scatter of a kind in units of the prior, and its degrees of freedom.
///
/// # Arguments
/// - `slope`: what the gauge yields in this cell, m/N.
fn pooled(
    scatter: &[RunDifference],
    (gauge, kind, cell, slope): (usize, usize, usize, f64),
) -> (f64, f64) {
    let known = scatter.iter();
    let known = known.filter(|of| (of.gauge, of.kind) == (gauge, kind));
    let prior = (PRIOR_FREEDOM, PRIOR_FREEDOM);
    let sum =
        |sums: (f64, f64), of: &RunDifference| (sums.0 + of.size.powi(2), sums.1 + of.freedom);
    let sums = if kind == LOADS {
        let (here, there): (Vec<_>, Vec<_>) = known.partition(|of| of.cell == cell);
        // Where this cell is softer than another, all the scatter of that may have come from the force.
        let of_others = there.into_iter().fold(prior, |sums, of: &RunDifference| {
            let softer = Some((slope / of.slope).abs()).filter(|times| times.is_finite());
            let size = of.size * softer.unwrap_or(1.0).max(1.0);
            sum(sums, &RunDifference { size, ..*of })
        });
        let square = of_others.0 / of_others.1;
        // It is a prior for this one.
        here.into_iter()
            .fold((square * PRIOR_FREEDOM, PRIOR_FREEDOM), sum)
    } else {
        known.fold(prior, sum)
    };
    ((sums.0 / sums.1).sqrt(), sums.1)
}

/// All that stands out in a run is one question; how many times the limit the worst is.
fn contradiction(run: &LoadedRun, findings: Vec<RunFinding>) -> Option<(f64, Contradiction)> {
    let whole = findings.iter().any(|of| of.number.is_none());
    let single = findings.iter().filter_map(|of| of.number);
    let numbers = if whole {
        run.readings.iter().map(|one| one.number).collect()
    } else {
        single.collect()
    };
    let worst = findings
        .into_iter()
        .max_by(|a, b| a.times.total_cmp(&b.times))?;
    let text = worst.text;
    Some((worst.times, Contradiction { numbers, text }))
}

impl RunComparison {
    /// What a comparison adds to the scatter.
    fn differences(&self, run: &LoadedRun, gauge: usize) -> [RunDifference; 3] {
        let of = |kind: usize, size: f64, freedom: f64| RunDifference {
            cell: run.cell,
            repeat: run.repeat,
            gauge,
            kind,
            size,
            freedom,
            slope: self.slope,
        };
        let [slope, offset] = self.line.map(|(off, prior)| off / prior);
        [
            of(SLOPE, slope, 1.0),
            of(OFFSET, offset, 1.0),
            of(LOADS, self.squares.sqrt(), self.freedom),
        ]
    }
}
