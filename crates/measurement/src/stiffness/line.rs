//! Straight lines of displacement against force: one per run, and the common slope with one intercept per gauge zero.

use thiserror::Error;

use super::curve::{CurvePoint, LoadCurve, Run};
use crate::readings::are_one_load;
use stiffbench_numeric::statistics::{Estimate, LeastSquaresLine, mean, standard_deviation};

/// Fewest runs whose scatter is used; with two the coverage factor would be 12.7 and the estimate of the scatter nearly useless.
pub(super) const FEWEST_RUNS: usize = 3;

/// Forces closer together than this share of their size are one force: no slope can be drawn through them.
const SMALLEST_RELATIVE_SPREAD: f64 = 1e-12;

/// Least-squares line through the points of one run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StraightLine {
    pub(super) slope_m_per_n: f64,
    pub(super) intercept_m: f64,
    pub(super) mean_force_n: f64,
    /// Sum of squared distances of the forces from their mean, N².
    pub(super) sxx_n2: f64,
    pub(super) n: usize,
}

impl StraightLine {
    /// `None` if there is only one force.
    pub(super) fn through<'a>(
        points: impl Iterator<Item = &'a CurvePoint> + Clone,
    ) -> Option<Self> {
        let size: f64 = points.clone().map(|p| p.force_n * p.force_n).sum();
        let pairs = points.clone().map(|p| (p.force_n, p.displacement_m));
        let line = LeastSquaresLine::through(pairs)?;
        (line.sxx > SMALLEST_RELATIVE_SPREAD * size).then(|| Self {
            slope_m_per_n: line.slope,
            intercept_m: line.at(0.0),
            mean_force_n: line.mean.0,
            sxx_n2: line.sxx,
            n: points.count(),
        })
    }

    pub(super) fn residual_m(&self, point: &CurvePoint) -> f64 {
        point.displacement_m - self.intercept_m - self.slope_m_per_n * point.force_n
    }

    /// Share of its own displacement that a point pulls the line with.
    pub(super) fn leverage(&self, point: &CurvePoint) -> f64 {
        let force = point.force_n - self.mean_force_n;
        1.0 / self.n as f64 + force * force / self.sxx_n2
    }
}

/// Standard uncertainty from observed scatter (GUM 4.2), in the unit of the field that holds it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TypeA {
    /// Standard uncertainty.
    pub standard_uncertainty: f64,
    /// Degrees of freedom.
    pub dof: f64,
}

/// Why a cell has no stiffness by a method.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum NoStiffness {
    /// Only unloaded readings.
    #[error("no reading under load")]
    NoLoad,
    /// The mean displacement at a load is exactly zero, so F/δ is infinite there.
    #[error("the mean displacement at {target_n} N is zero, F/δ has no value there")]
    NoDisplacement {
        /// The load, N.
        target_n: f64,
    },
    /// The mean force at a load that should not be zero is exactly zero.
    #[error("the mean force measured at {target_n} N is zero")]
    NoForce {
        /// The load, N.
        target_n: f64,
    },
    /// Force and displacement have opposite signs at a load, so F/δ is negative there.
    #[error("force and displacement have opposite signs at {target_n} N, F/δ is negative there")]
    OppositeSigns {
        /// The load, N.
        target_n: f64,
    },
    /// No gauge zero has readings at two loads.
    #[error("all readings of each gauge zero are at one load")]
    OneForce,
    /// The slope is exactly zero.
    #[error("the displacement does not change with the force")]
    NoSlope,
}

/// Common slope of displacement on force in a cell, with a free intercept per gauge zero.
#[derive(Debug, Clone, PartialEq)]
pub struct LineFit {
    /// Slope, m/N: the compliance.
    pub slope_m_per_n: f64,
    /// Uncertainty of the slope, m/N, from the scatter of the runs; from three runs on.
    pub slope_by_runs: Option<TypeA>,
    /// The same from two runs on: too few for an estimate of their own, but they add one degree of freedom to the estimate from all cells.
    pub(super) slope_by_any_runs: Option<TypeA>,
    /// Uncertainty of the slope, m/N, from the scatter of single readings about the line.
    pub slope_by_residuals: Option<TypeA>,
    /// Standard deviation of a reading about the line, m; `None` if the line goes through every reading by construction.
    pub residual_sd_m: Option<f64>,
    /// Intercept of each gauge zero, m.
    pub intercepts_m: Vec<f64>,
    /// Mean intercept, m: what the gauge would have shown without load.
    pub zero_offset_m: Estimate,
    /// What each run contributes to the slope, in the order of the curve's runs.
    pub runs: Vec<RunSums>,
    /// Change of the slope per change of displacement at each load, 1/N.
    pub(super) load_weights_per_n: Vec<f64>,
}

/// Sums of one run about the means of its gauge zero; the slope of a cell is Σ `sxy_n_m` over Σ `sxx_n2`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunSums {
    /// Σ (F - F̄)², N².
    pub sxx_n2: f64,
    /// Σ (F - F̄)(δ - δ̄), N·m.
    pub sxy_n_m: f64,
}

impl LineFit {
    /// Fits the cell, unloaded readings included: they are readings like others, and a third of what is known of the slope.
    /// A dead zone then leaves a trace in the slope (0.8 % for 20 µm at 50 N/mm over 0 to 70 N), none without them.
    ///
    /// With c the slope, F̄ and δ̄ the means over the readings of one zero, c = Σ(F - F̄)(δ - δ̄) / Σ(F - F̄)². Its variance is
    /// computed twice. From residuals e: s²/Σ(F - F̄)², with N - (zeros) - 1 degrees of freedom; this takes all readings for
    /// independent. From runs: G/(G-1) Σ_runs (Σ (F - F̄) e)² / (Σ(F - F̄)²)² with G - 1; runs with zeros of their own and equal
    /// loads turn this into the variance of the mean of the run slopes.
    ///
    /// # Errors
    /// `NoStiffness::OneForce` if no gauge zero has readings at two loads.
    ///
    /// # Source
    /// Liang and Zeger, Biometrika 73 (1986) 13, for the variance from runs; the factor G/(G-1) makes it unbiased for equal runs.
    pub fn new(curve: &LoadCurve) -> Result<Self, NoStiffness> {
        let centres = zero_centres(curve);
        let runs: Vec<RunSums> = curve
            .runs
            .iter()
            .map(|run| RunSums::of(run, &centres))
            .collect();
        let sxx: f64 = runs.iter().map(|run| run.sxx_n2).sum();
        let sxy: f64 = runs.iter().map(|run| run.sxy_n_m).sum();
        let size: f64 = curve.points().map(|p| p.force_n * p.force_n).sum();
        let is_flat = sxx <= SMALLEST_RELATIVE_SPREAD * size || size == 0.0;
        if is_flat || is_at_one_load(curve) {
            return Err(NoStiffness::OneForce);
        }
        let slope = sxy / sxx;
        let intercepts_m: Vec<f64> = centres.iter().map(|(f, d)| d - slope * f).collect();
        let mut load_weights_per_n = vec![0.0; curve.loads.len()];
        for p in curve.points() {
            load_weights_per_n[p.load] += (p.force_n - centres[p.zero].0) / sxx;
        }
        let residual = |p: &CurvePoint| p.displacement_m - intercepts_m[p.zero] - slope * p.force_n;
        let rss: f64 = curve.points().map(|p| residual(p) * residual(p)).sum();
        let residual_dof = curve.n_points().saturating_sub(curve.n_zeros + 1) as f64;
        let residual_sd_m = (residual_dof > 0.0).then(|| (rss / residual_dof).sqrt());
        let slope_by_residuals = residual_sd_m.map(|sd| TypeA {
            standard_uncertainty: sd / sxx.sqrt(),
            dof: residual_dof,
        });
        let score = |p: &CurvePoint| (p.force_n - centres[p.zero].0) * residual(p);
        let by_runs = slope_by_runs(curve, &centres, score).filter(|_| residual_dof > 0.0);
        let slope_by_any_runs = by_runs.map(|(root_n2, dof)| TypeA {
            standard_uncertainty: root_n2 / sxx,
            dof: dof.min(residual_dof),
        });
        let enough = by_runs.is_some_and(|(_, dof)| dof + 1.0 >= FEWEST_RUNS as f64);
        let slope_by_runs = slope_by_any_runs.filter(|_| enough);
        let zero_offset_m = zero_offset(curve, &centres, &intercepts_m, residual_sd_m, sxx);
        Ok(Self {
            slope_m_per_n: slope,
            slope_by_runs,
            slope_by_any_runs,
            slope_by_residuals,
            residual_sd_m,
            intercepts_m,
            zero_offset_m,
            runs,
            load_weights_per_n,
        })
    }

    /// The uncertainty that is used: from runs if there are enough of them, else from residuals.
    #[must_use]
    pub fn type_a(&self) -> Option<TypeA> {
        self.slope_by_runs.or(self.slope_by_residuals)
    }
}

impl RunSums {
    fn of(run: &Run, centres: &[(f64, f64)]) -> Self {
        let mut sums = Self {
            sxx_n2: 0.0,
            sxy_n_m: 0.0,
        };
        for p in &run.points {
            let force = p.force_n - centres[p.zero].0;
            sums.sxx_n2 += force * force;
            sums.sxy_n_m += force * (p.displacement_m - centres[p.zero].1);
        }
        sums
    }
}

/// Root of G/(G-1) Σ (Σ of the scores of a run)² over the G runs that pull the slope, and G - 1; `None` for fewer than two.
fn slope_by_runs(
    curve: &LoadCurve,
    centres: &[(f64, f64)],
    score: impl Fn(&CurvePoint) -> f64,
) -> Option<(f64, f64)> {
    let pulls = |p: &CurvePoint| p.force_n != centres[p.zero].0;
    let squares: Vec<f64> = curve
        .runs
        .iter()
        .filter(|run| run.points.iter().any(pulls))
        .map(|run| run.points.iter().map(&score).sum::<f64>().powi(2))
        .collect();
    let g = squares.len() as f64;
    let root = (g / (g - 1.0) * squares.iter().sum::<f64>()).sqrt();
    (squares.len() >= 2).then_some((root, g - 1.0))
}

/// Whether all readings of each gauge zero have one target and forces that are one load: a line through them is drawn by noise.
fn is_at_one_load(curve: &LoadCurve) -> bool {
    curve.points_by_zero().into_iter().all(|here| {
        let mut targets = here.iter().map(|point| curve.loads[point.load].target_n);
        let first = targets.next();
        targets.all(|target_n| Some(target_n) == first)
            && are_one_load(here.iter().map(|point| point.force_n))
    })
}

/// Mean force (N) and displacement (m) of each gauge zero.
fn zero_centres(curve: &LoadCurve) -> Vec<(f64, f64)> {
    let mut sums = vec![(0.0, 0.0, 0_usize); curve.n_zeros];
    for p in curve.points() {
        let sum = &mut sums[p.zero];
        *sum = (sum.0 + p.force_n, sum.1 + p.displacement_m, sum.2 + 1);
    }
    sums.iter()
        .map(|&(force, displacement, n)| (force / n as f64, displacement / n as f64))
        .collect()
}

/// Mean intercept; its uncertainty from the scatter of the intercepts of the runs' own lines, else from the residuals.
fn zero_offset(
    curve: &LoadCurve,
    centres: &[(f64, f64)],
    intercepts_m: &[f64],
    residual_sd_m: Option<f64>,
    sxx_n2: f64,
) -> Estimate {
    let value = mean(intercepts_m).unwrap_or_default();
    let own: Vec<f64> = curve
        .runs
        .iter()
        .filter_map(|run| StraightLine::through(run.points.iter()))
        .map(|line| line.intercept_m)
        .collect();
    if let Some(sd) = standard_deviation(&own).filter(|_| own.len() >= FEWEST_RUNS) {
        return Estimate {
            value,
            standard_uncertainty: sd / (own.len() as f64).sqrt(),
            dof: (own.len() - 1) as f64,
        };
    }
    let Some(sd) = residual_sd_m else {
        return Estimate::without_uncertainty(value);
    };
    let mut counts = vec![0.0; curve.n_zeros];
    for p in curve.points() {
        counts[p.zero] += 1.0;
    }
    let n_zeros = curve.n_zeros as f64;
    let mean_force = centres.iter().map(|(force, _)| force).sum::<f64>() / n_zeros;
    let of_means: f64 = counts.iter().map(|n| 1.0 / n).sum::<f64>() / (n_zeros * n_zeros);
    Estimate {
        value,
        standard_uncertainty: sd * (of_means + mean_force * mean_force / sxx_n2).sqrt(),
        dof: (curve.n_points() - curve.n_zeros - 1) as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::readings::Reading;
    use crate::stiffness::curve::Branches;
    use crate::stiffness::sample::{cell, reading};

    fn curve(readings: &[Reading]) -> LoadCurve {
        let refs: Vec<&Reading> = readings.iter().collect();
        LoadCurve::new(cell(), &refs, Branches::LoadingOnly)
    }

    #[test]
    fn a_line_through_four_points_worked_by_hand() {
        // δ in µm at F = 0, 1, 2, 3 N: 1, 3, 4, 8. Mean F 1.5, mean δ 4, Sxx 5, Sxy 11: slope 2.2, intercept 0.7.
        // Residuals 0.3, 0.1, -1.1, 0.7: RSS 1.8, s² 0.9, u(slope) = √(0.9/5); intercept s √(1/4 + 2.25/5).
        let readings: Vec<Reading> = [1e-6, 3e-6, 4e-6, 8e-6]
            .iter()
            .enumerate()
            .map(|(i, &d)| reading(1, i as u32, i as f64, i as f64, d))
            .collect();
        let fit = LineFit::new(&curve(&readings)).unwrap();
        assert!((fit.slope_m_per_n - 2.2e-6).abs() < 1e-18);
        assert!((fit.intercepts_m[0] - 0.7e-6).abs() < 1e-18);
        assert_eq!(fit.slope_by_runs, None);
        let by_residuals = fit.slope_by_residuals.unwrap();
        assert!((by_residuals.standard_uncertainty / 1e-6 - 0.18_f64.sqrt()).abs() < 1e-12);
        assert_eq!(by_residuals.dof, 2.0);
        let offset = fit.zero_offset_m;
        assert!((offset.standard_uncertainty / 1e-6 - (0.9_f64 * 0.7).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn runs_with_zeros_of_their_own_give_the_scatter_of_their_slopes() {
        // Three exact lines of slope 1, 2, 3 µm/N and any zero: mean 2, standard error of the mean 1/√3, 2 dof.
        let readings: Vec<Reading> = (1..=3)
            .flat_map(|run| {
                (0..4).map(move |i| {
                    let force = f64::from(i);
                    let displacement = (f64::from(run * run) * 7.0 + f64::from(run) * force) * 1e-6;
                    reading(run, i, force, force, displacement)
                })
            })
            .collect();
        let fit = LineFit::new(&curve(&readings)).unwrap();
        assert!((fit.slope_m_per_n - 2e-6).abs() < 1e-18);
        let by_runs = fit.slope_by_runs.unwrap();
        assert!((by_runs.standard_uncertainty / 1e-6 - 1.0 / 3_f64.sqrt()).abs() < 1e-12);
        assert_eq!(by_runs.dof, 2.0);
        // Intercepts 7, 28, 63 µm: mean 98/3, variance (4802 - 9604/3)/2 = 2401/3.
        assert!((fit.zero_offset_m.value / 1e-6 - 98.0 / 3.0).abs() < 1e-9);
        let sd = (2401.0_f64 / 3.0).sqrt();
        assert!((fit.zero_offset_m.standard_uncertainty / 1e-6 - sd / 3_f64.sqrt()).abs() < 1e-9,);
    }

    #[test]
    fn one_force_has_no_slope() {
        let readings = [
            reading(1, 0, -10.0, -10.0, -2e-4),
            reading(2, 0, -10.0, -10.0, -2e-4),
        ];
        assert_eq!(LineFit::new(&curve(&readings)), Err(NoStiffness::OneForce));
        // Two forces, but each on a zero of its own: the step between them is lost.
        let readings = [
            reading(1, 0, -10.0, -10.0, -2e-4),
            reading(2, 0, -20.0, -20.0, -4e-4),
        ];
        assert_eq!(LineFit::new(&curve(&readings)), Err(NoStiffness::OneForce));
    }

    #[test]
    fn noise_about_one_load_gives_no_slope_in_any_order() {
        let forces = [50.01, 50.05, 50.11];
        for order in [[0, 1, 2], [2, 1, 0], [1, 0, 2]] {
            let steps = (0..).zip(order);
            let readings: Vec<Reading> = steps
                .map(|(step, place)| reading(1, step, 50.0, forces[place], 62.4e-6))
                .collect();
            assert_eq!(LineFit::new(&curve(&readings)), Err(NoStiffness::OneForce));
        }
        // The same forces, each aimed at, are loads of their own.
        let steps = (0..).zip(forces);
        let readings: Vec<Reading> = steps
            .map(|(step, force)| reading(1, step, force, force, 1e-6 * force))
            .collect();
        assert!(LineFit::new(&curve(&readings)).is_ok());
        // An unloaded reading on the same zero makes two loads.
        let readings = [
            reading(1, 0, 0.0, 0.02, 0.0),
            reading(1, 1, 50.0, 50.0, 6e-5),
        ];
        assert!(LineFit::new(&curve(&readings)).is_ok());
        // A target that is stated for all readings hides no loads.
        let readings = [
            reading(1, 0, 50.0, 10.0, 1e-5),
            reading(1, 1, 50.0, 50.0, 6e-5),
        ];
        assert!(LineFit::new(&curve(&readings)).is_ok());
    }

    #[test]
    fn two_readings_give_a_slope_without_uncertainty() {
        let readings = [
            reading(1, 0, 0.0, 0.0, 0.0),
            reading(1, 1, -10.0, -10.0, -2e-4),
        ];
        let fit = LineFit::new(&curve(&readings)).unwrap();
        assert!((fit.slope_m_per_n - 2e-5).abs() < 1e-18);
        assert_eq!(fit.type_a(), None);
        assert_eq!(fit.zero_offset_m.dof, 0.0);
    }
}
