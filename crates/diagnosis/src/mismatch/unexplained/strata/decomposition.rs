//! The spaces of each stratum, of what it is tested against, and of what is taken out first.

use crate::mismatch::noise::{NoiseCovariance, force_within_steps};
use crate::mismatch::observed::Observations;
use crate::search::subtract;

use super::bases::{Fit, GlobalColumn, LocalBasis, WholeColumns};
use super::columns::{Setting, bases, sets};
use super::contrasts::{Basis, Common, ErrorTerm, Plan, Stage, plans};
use super::results::{Contrast, Untested};

/// Least mean square of an error term, in units of the noise (1): noise is at least six digits of the largest displacement, and what agrees to nine
/// of them differs by rounding alone.
pub(super) const LEAST_ERROR: f64 = 1e-6;

/// Squares of an error term with its degrees of freedom, not below [`LEAST_ERROR`].
fn at_least((squares, dof): (f64, f64)) -> (f64, f64) {
    (squares.max(LEAST_ERROR * dof), dof)
}

/// A contrast: what one fit explains beyond another.
pub(super) struct FitContrast {
    pub(super) plan: Plan,
    /// Global columns that are taken out in both.
    common: Vec<usize>,
    /// Global columns that are the contrast.
    added: Vec<usize>,
    without: Fit,
    with: Fit,
}

/// The decomposition of one model's residuals; it depends on the plan and the noise, not on the displacements.
pub(super) struct Decomposition<'a> {
    pub(super) observations: &'a Observations,
    pub(super) whitening: &'a NoiseCovariance,
    bases: [LocalBasis; 4],
    globals: Vec<GlobalColumn>,
    #[cfg(test)]
    model: Vec<usize>,
    pub(super) comparisons: Vec<FitContrast>,
    run_slope: [Fit; 2],
    run_zero: [Fit; 2],
    before_curves: Fit,
    curves: Fit,
    /// All that repeats itself.
    pure: Fit,
    /// Share of the variance of readings that [`Self::pure`] leaves: the errors of a force gauge that scatters are taken out of it, but not out of the
    /// means over repeats.
    pure_share: f64,
    pub(super) untested: Vec<Untested>,
}

impl<'a> Decomposition<'a> {
    pub(super) fn new(setting: &Setting<'a, '_>) -> Self {
        let observations = setting.observations;
        let whitening = setting.whitening;
        let cells = observations.cells.len();
        let mut runs = observations.runs.iter();
        let mixed = runs.any(|run| observations.is_loaded_both_ways(run.readings.clone()));
        let bases = bases(observations, whitening, mixed);
        let sets = sets(setting);
        let fit = |basis: Basis, stage: Stage, columns: &[&[usize]]| {
            let columns: Vec<&GlobalColumn> = columns
                .iter()
                .flat_map(|set| set.iter().map(|&place| &sets.globals[place]))
                .collect();
            let stages = std::iter::repeat_n(stage, cells);
            Fit::new(&bases[basis as usize], stages, &columns)
        };
        let model = &sets.model[..];
        let (clock, repeat) = (&sets.clock[..], &sets.repeat[..]);
        // Zeros and slopes of all runs hold what cells have of either; among columns of single runs they take no more memory than readings.
        let run_slope = [
            (Basis::Between, Stage::Sign),
            (Basis::Within, Stage::RunSlopes),
        ]
        .map(|(basis, stage)| fit(basis, stage, &[model, repeat]));
        let run_zero = [
            (Basis::Offsets, Stage::Offset),
            (Basis::Within, Stage::RunSlopes),
        ]
        .map(|(basis, stage)| fit(basis, stage, &[model]));
        let [pure, before_curves, curves] = [Stage::Branches, Stage::Sign, Stage::Curves]
            .map(|stage| fit(Basis::Within, stage, &[model, clock]));
        let mut comparisons = Vec::new();
        let mut untested = Vec::new();
        for plan in plans(mixed) {
            let common: &[&[usize]] = match plan.common {
                Common::Model => &[model],
                Common::Clock => &[model, clock],
                Common::Repeat => &[model, repeat],
            };
            let added: &[usize] = match plan.contrast {
                Contrast::Clock => clock,
                Contrast::Repeat => repeat,
                _ => &[],
            };
            let mut all = common.to_vec();
            all.push(added);
            let without = fit(plan.basis, plan.stages[0], common);
            let with = fit(plan.basis, plan.stages[1], &all);
            let dof = match plan.error {
                ErrorTerm::RunSlope => run_slope[1].rank.saturating_sub(run_slope[0].rank),
                ErrorTerm::RunZero => run_zero[1].rank.saturating_sub(run_zero[0].rank),
                ErrorTerm::Pure => observations.len().saturating_sub(pure.rank),
            };
            let why = if observations.free_zeros && plan.contrast == Contrast::CellOffset {
                Some("the zeros may be anything")
            } else if with.rank == without.rank {
                Some(plan.contrast.when_absent(observations))
            } else if dof == 0 {
                Some(plan.error.when_absent())
            } else {
                None
            };
            if let Some(why) = why {
                untested.push(Untested {
                    contrast: plan.contrast,
                    why: why.to_owned(),
                });
                continue;
            }
            comparisons.push(FitContrast {
                common: common.iter().flat_map(|set| set.iter().copied()).collect(),
                added: added.to_vec(),
                without,
                with,
                plan,
            });
        }
        Self {
            observations,
            whitening,
            bases,
            globals: sets.globals,
            #[cfg(test)]
            model: sets.model,
            comparisons,
            run_slope,
            run_zero,
            before_curves,
            curves,
            pure,
            pure_share: pure_share(observations, whitening),
            untested,
        }
    }

    /// Weighted squares and degrees of freedom of an error term.
    pub(super) fn error(&self, term: ErrorTerm, white: &[f64]) -> (f64, f64) {
        let [without, with] = match term {
            ErrorTerm::RunSlope => &self.run_slope,
            ErrorTerm::RunZero => &self.run_zero,
            ErrorTerm::Pure => {
                let dof = white.len().saturating_sub(self.pure.rank);
                return at_least((squares(&self.pure(white)) / self.pure_share, dof as f64));
            }
        };
        let [left, right] = [without, with].map(|fit| self.left_by(fit, white));
        let dof = with.rank - without.rank;
        at_least((squares(&left) - squares(&right), dof as f64))
    }

    /// What each comparison explains of a white vector over what it is compared with, with both degrees of freedom, and [`ErrorTerm::Pure`]:
    /// by products alone, for many vectors.
    pub(super) fn ratios(&self, white: &[f64]) -> (Vec<[f64; 3]>, (f64, f64)) {
        let local = self.bases.each_ref().map(|b| b.squares_along(white));
        let within = |fit: &Fit| fit.squares_within(&local[fit.basis as usize], white);
        let whole = squares(white);
        // Below this they are nothing but rounding.
        let least = f64::EPSILON * white.len() as f64 * whole;
        let runs = |[without, with]: &[Fit; 2]| {
            let squares = within(with) - within(without);
            at_least((squares.max(least), (with.rank - without.rank) as f64))
        };
        let pure = at_least((
            ((whole - within(&self.pure)) / self.pure_share).max(least),
            white.len().saturating_sub(self.pure.rank) as f64,
        ));
        let run_slope = runs(&self.run_slope);
        let run_zero = runs(&self.run_zero);
        let ratio = |one: &FitContrast| {
            let explained = within(&one.with) - within(&one.without);
            let d1 = (one.with.rank - one.without.rank) as f64;
            let (error, d2) = match one.plan.error {
                ErrorTerm::RunSlope => run_slope,
                ErrorTerm::RunZero => run_zero,
                ErrorTerm::Pure => pure,
            };
            [(explained / d1) / (error / d2), d1, d2]
        };
        (self.comparisons.iter().map(ratio).collect(), pure)
    }

    /// What a contrast explains of a white vector, and its degrees of freedom.
    pub(super) fn pattern(&self, comparison: &FitContrast, white: &[f64]) -> (Vec<f64>, f64) {
        self.between_fits(&comparison.without, &comparison.with, white)
    }

    /// The same for the part of the contrast that lies in some cells.
    pub(super) fn pattern_in(
        &self,
        comparison: &FitContrast,
        white: &[f64],
        inside: &dyn Fn(usize) -> bool,
    ) -> (Vec<f64>, f64) {
        let [from, to] = comparison.plan.stages;
        let cells = 0..self.observations.cells.len();
        let stages = cells.map(|cell| if inside(cell) { to } else { from });
        let added: Vec<GlobalColumn> = comparison
            .added
            .iter()
            .map(|&place| self.restricted(&self.globals[place], inside))
            .collect();
        let columns: Vec<&GlobalColumn> = comparison
            .common
            .iter()
            .map(|&place| &self.globals[place])
            .chain(&added)
            .collect();
        let basis = comparison.plan.basis as usize;
        let with = Fit::new(&self.bases[basis], stages, &columns);
        self.between_fits(&comparison.without, &with, white)
    }

    fn restricted(&self, column: &GlobalColumn, inside: &dyn Fn(usize) -> bool) -> GlobalColumn {
        let mut white = column.white.clone();
        for (index, cell) in self.observations.cells.iter().enumerate() {
            if !inside(index) {
                white[cell.readings.clone()].fill(0.0);
            }
        }
        GlobalColumn {
            white,
            ..column.clone()
        }
    }

    /// What a white vector has outside the space of a fit.
    fn left_by(&self, fit: &Fit, white: &[f64]) -> Vec<f64> {
        fit.left(&self.bases[fit.basis as usize], white)
    }

    fn between_fits(&self, without: &Fit, with: &Fit, white: &[f64]) -> (Vec<f64>, f64) {
        let mut pattern = self.left_by(without, white);
        let rest = self.left_by(with, white);
        subtract(&mut pattern, 1.0, &rest);
        (pattern, (with.rank - without.rank) as f64)
    }

    /// What a contrast would explain of columns of readings (m), in white, with all that is taken out before it taken out.
    pub(super) fn seen(&self, comparison: &FitContrast, column_m: &[f64]) -> Vec<f64> {
        self.pattern(comparison, &self.white(column_m)).0
    }

    /// A white vector with what the model can absorb taken out.
    #[cfg(test)]
    pub(super) fn without_model(&self, white: &[f64]) -> Vec<f64> {
        let columns: Vec<&GlobalColumn> = self.model.iter().map(|&p| &self.globals[p]).collect();
        self.left_by(
            &Fit::new(&self.bases[0], std::iter::empty(), &columns),
            white,
        )
    }

    /// Readings, m, made white.
    pub(super) fn white(&self, readings_m: &[f64]) -> Vec<f64> {
        let mut white = readings_m.to_vec();
        self.whitening.covariance.whiten(&mut white);
        white
    }

    /// Orthonormal columns that global columns add to smooth curves over the load, and to everything that repeats itself.
    pub(super) fn beyond_curves(&self, columns: &[GlobalColumn]) -> [WholeColumns; 2] {
        [&self.curves, &self.pure].map(|fit| fit.beyond(&self.bases[fit.basis as usize], columns))
    }

    /// The part of a white vector that curves, steps and loops over the load can be, zeros, slopes and the clock taken out.
    pub(super) fn shape(&self, white: &[f64]) -> (Vec<f64>, f64) {
        self.between_fits(&self.before_curves, &self.pure, white)
    }

    /// What is left of a white vector when all that repeats itself is taken out.
    pub(super) fn pure(&self, white: &[f64]) -> Vec<f64> {
        self.left_by(&self.pure, white)
    }

    /// For each reading, the share of its own error in what [`Self::pure`] leaves.
    pub(super) fn leverage_left(&self) -> Vec<f64> {
        let basis = &self.bases[self.pure.basis as usize];
        self.pure.leverage_left(basis, self.observations.len())
    }
}

/// Share of their own errors in the variance of readings, where errors of the force are told apart; else 1.
fn pure_share(observations: &Observations, whitening: &NoiseCovariance) -> f64 {
    if force_within_steps(observations, &whitening.noise).is_empty() {
        return 1.0;
    }
    let all = 0..observations.len();
    let shares = all.map(|reading| whitening.own_share(reading));
    shares.sum::<f64>() / observations.len() as f64
}

/// Sum of squares.
pub(super) fn squares(vector: &[f64]) -> f64 {
    vector.iter().map(|x| x * x).sum()
}
