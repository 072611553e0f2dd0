//! The two stiffnesses of a cell with their type A uncertainty, before the budget adds what the gauges are known for.

use std::fmt;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::curve::LoadCurve;
use super::line::{FEWEST_RUNS, LineFit, NoStiffness, TypeA};
use super::run_slope::PooledRunSlope;
use super::scatter::PooledScatter;
use stiffbench_units_and_text::count::counted;

/// How a stiffness was computed of the readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The paper's: mean of F/δ over the loads that are not zero.
    PaperMean,
    /// 1/slope of displacement on force, free intercept per gauge zero.
    Regression,
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::PaperMean => "mean of F/δ",
            Self::Regression => "regression",
        })
    }
}

/// Which scatter the type A uncertainty rests on.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema, Error,
)]
#[serde(rename_all = "kebab-case", tag = "from")]
pub enum ScatterBasis {
    /// Scatter between runs; it holds whatever the readings of a run share.
    #[error("scatter between {n_runs} runs")]
    RunToRun {
        /// Number of runs.
        n_runs: usize,
    },
    /// Scatter between runs, pooled over all cells, because this one has fewer than three runs.
    #[error(
        "scatter between runs pooled over all cells ({} here, three are needed to see how runs differ)",
        counted(.n_runs, "run")
    )]
    PooledRuns {
        /// Number of runs.
        n_runs: usize,
    },
    /// How runs differ cannot be seen: fewer than three runs here, and in no cell two.
    #[error("repeatability unknown: {} here, and no cell with two runs", counted(.n_runs, "run"))]
    Unavailable {
        /// Number of runs.
        n_runs: usize,
    },
}

/// A stiffness with the derivatives that its budget needs.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BareStiffness {
    pub(super) method: Method,
    pub(super) value_n_per_m: f64,
    pub(super) type_a: Option<TypeA>,
    pub(super) basis: ScatterBasis,
    /// Change of stiffness per change of displacement at each load, N/m².
    pub(super) per_displacement: Vec<f64>,
    /// Change of stiffness per change of force at each load, 1/m.
    pub(super) per_force: Vec<f64>,
}

impl BareStiffness {
    /// Change of stiffness when all displacements change together, N/m²; zero where a free intercept takes it up.
    pub(super) fn per_common_displacement(&self) -> f64 {
        match self.method {
            Method::PaperMean => self.per_displacement.iter().sum(),
            Method::Regression => 0.0,
        }
    }
}

/// The paper's stiffness: K = (1/L) Σ F̄/δ̄ over the L loads that are not zero (paper IV-C, steps 4 to 6).
///
/// The readings of a load are averaged first, force and displacement each for itself, then the ratio is taken, as the paper
/// averages its five measurements of a load before it works out seven stiffnesses. δ counts from the gauge zero.
///
/// A load at which no positive ratio exists takes the value away from the whole cell: a mean without it would be another
/// quantity, and one with it is ruled by the noise of a single reading.
///
/// Type A from runs: every run r pulls the mean by z_r = Σ_l (F - F̄ - k(δ - δ̄)) / (L n δ̄), k = F̄/δ̄, to first order, and
/// u² = Σ z_r², each term enlarged by n/(n-1). With complete runs this is the jackknife over runs to first order. With fewer
/// than three runs: the estimate from all cells.
pub(super) fn paper_stiffness(
    curve: &LoadCurve,
    elsewhere: Option<&Elsewhere<'_>>,
) -> Result<BareStiffness, NoStiffness> {
    let loaded: Vec<usize> = curve.loaded().collect();
    if loaded.is_empty() {
        return Err(NoStiffness::NoLoad);
    }
    let n_loads = loaded.len() as f64;
    let mut ratios = vec![0.0; curve.loads.len()];
    let mut per_displacement = ratios.clone();
    let mut per_force = ratios.clone();
    for &load in &loaded {
        let displacement_m = curve.loads[load].displacement_m.mean;
        ratios[load] = positive_ratio(curve, load)?;
        per_displacement[load] = -ratios[load] / (n_loads * displacement_m);
        per_force[load] = 1.0 / (n_loads * displacement_m);
    }
    let value_n_per_m = ratios.iter().sum::<f64>() / n_loads;
    let n_runs = curve.runs.len();
    let type_a = paper_type_a(curve, &per_displacement, &per_force);
    let (type_a, basis) = own_or_borrowed(n_runs, type_a, || {
        let Elsewhere { run_slope, scatter } = elsewhere?;
        Some(run_slope.type_a_of_mean(curve, scatter, value_n_per_m, &per_displacement))
    });
    Ok(BareStiffness {
        method: Method::PaperMean,
        value_n_per_m,
        type_a,
        basis,
        per_displacement,
        per_force,
    })
}

fn positive_ratio(curve: &LoadCurve, load: usize) -> Result<f64, NoStiffness> {
    let mean = &curve.loads[load];
    let target_n = mean.target_n;
    let ratio = mean.force_n.mean / mean.displacement_m.mean;
    if mean.force_n.mean == 0.0 {
        Err(NoStiffness::NoForce { target_n })
    } else if !ratio.is_finite() {
        Err(NoStiffness::NoDisplacement { target_n })
    } else if ratio <= 0.0 {
        Err(NoStiffness::OppositeSigns { target_n })
    } else {
        Ok(ratio)
    }
}

/// The estimate from all cells of how runs differ, for a cell that has too few.
#[derive(Debug, Clone, Copy)]
pub(super) struct Elsewhere<'a> {
    pub(super) run_slope: &'a PooledRunSlope,
    pub(super) scatter: &'a PooledScatter,
}

/// The uncertainty that a cell has of its own runs; one of too few runs borrows it from the others, if they have it.
fn own_or_borrowed(
    n_runs: usize,
    own: Option<TypeA>,
    pooled: impl FnOnce() -> Option<TypeA>,
) -> (Option<TypeA>, ScatterBasis) {
    if own.is_some() {
        return (own, ScatterBasis::RunToRun { n_runs });
    }
    match pooled() {
        None => (None, ScatterBasis::Unavailable { n_runs }),
        borrowed => (borrowed, ScatterBasis::PooledRuns { n_runs }),
    }
}

fn paper_type_a(curve: &LoadCurve, per_displacement: &[f64], per_force: &[f64]) -> Option<TypeA> {
    let loads = &curve.loads;
    let spare: usize = curve.loaded().map(|load| loads[load].n - 1).sum();
    let loaded_runs = curve.runs.iter().filter(|run| {
        let mut points = run.points.iter();
        points.any(|p| !loads[p.load].is_unloaded())
    });
    let loaded_runs: Vec<_> = loaded_runs.collect();
    if loaded_runs.len() < FEWEST_RUNS || curve.loaded().any(|load| loads[load].n < 2) {
        return None;
    }
    let pull = |p: &super::curve::CurvePoint| {
        let load = &loads[p.load];
        let n = load.n as f64;
        let change = per_force[p.load] * (p.force_n - load.force_n.mean)
            + per_displacement[p.load] * (p.displacement_m - load.displacement_m.mean);
        change / n * (n / (n - 1.0)).sqrt()
    };
    let variance: f64 = loaded_runs
        .iter()
        .map(|run| {
            let points = run.points.iter();
            let of_run: f64 = points
                .filter(|p| !loads[p.load].is_unloaded())
                .map(pull)
                .sum();
            of_run * of_run
        })
        .sum();
    Some(TypeA {
        standard_uncertainty: variance.sqrt(),
        // Runs of a single reading each leave one degree less per load, not one less in all.
        dof: (loaded_runs.len() - 1).min(spare) as f64,
    })
}

/// The stiffness of a curve by a method, N/m, without its uncertainty.
///
/// # Errors
/// [`NoStiffness`].
pub fn stiffness_value(curve: &LoadCurve, method: Method) -> Result<f64, NoStiffness> {
    let bare = match method {
        Method::PaperMean => paper_stiffness(curve, None)?,
        Method::Regression => regression_stiffness(curve, &LineFit::new(curve)?, None)?,
    };
    Ok(bare.value_n_per_m)
}

/// 1/slope of displacement on force, with u(K) = K² u(slope).
pub(super) fn regression_stiffness(
    curve: &LoadCurve,
    line: &LineFit,
    elsewhere: Option<&Elsewhere<'_>>,
) -> Result<BareStiffness, NoStiffness> {
    let value_n_per_m = 1.0 / line.slope_m_per_n;
    if !value_n_per_m.is_finite() {
        return Err(NoStiffness::NoSlope);
    }
    let squared = value_n_per_m * value_n_per_m;
    let n_runs = curve.runs.len();
    let type_a = line.slope_by_runs.map(|slope| TypeA {
        standard_uncertainty: squared * slope.standard_uncertainty,
        dof: slope.dof,
    });
    let (type_a, basis) = own_or_borrowed(n_runs, type_a, || {
        let Elsewhere { run_slope, scatter } = elsewhere?;
        run_slope.type_a(line, scatter, value_n_per_m)
    });
    let weights = &line.load_weights_per_n;
    Ok(BareStiffness {
        method: Method::Regression,
        value_n_per_m,
        type_a,
        basis,
        per_displacement: weights.iter().map(|w| -squared * w).collect(),
        // An error f of the force shifts the displacement expected there by slope · f.
        per_force: weights.iter().map(|w| value_n_per_m * w).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::readings::Reading;
    use crate::stiffness::curve::Branches;
    use crate::stiffness::sample::{SimulatedBench, cell, reading};

    fn curve(readings: &[Reading]) -> LoadCurve {
        let refs: Vec<&Reading> = readings.iter().collect();
        LoadCurve::new(cell(), &refs, Branches::LoadingOnly)
    }

    fn paper_of(readings: &[Reading]) -> Result<BareStiffness, NoStiffness> {
        let curve = curve(readings);
        paper_stiffness(&curve, None)
    }

    /// Loading 0..-70 N of a cell of 50 N/mm with `extra` metres at each force.
    fn sweep(extra: impl Fn(f64) -> f64) -> Vec<Reading> {
        (0..=7)
            .map(|i| {
                let force = -10.0 * f64::from(i);
                reading(1, i, force, force, force / 50e3 + extra(force))
            })
            .collect()
    }

    /// Stiffness by the paper's mean and by regression relative to 50 N/mm.
    fn both(readings: &[Reading]) -> (f64, f64) {
        let curve = curve(readings);
        let line = LineFit::new(&curve).unwrap();
        let paper = paper_stiffness(&curve, None).unwrap();
        let regression = regression_stiffness(&curve, &line, None).unwrap();
        (paper.value_n_per_m / 50e3, regression.value_n_per_m / 50e3)
    }

    #[test]
    fn a_dead_zone_lowers_the_mean_of_ratios_and_not_the_free_slope() {
        // A dead zone b lowers mean(F/δ) by mean[K b/(F + K b)]: 3.5 % for 20 µm at 50 N/mm; the free slope sees none of it
        // when the unloaded reading is not part of the fit.
        let loaded: Vec<Reading> = sweep(|force| if force < 0.0 { -20e-6 } else { 0.0 })
            .into_iter()
            .filter(|r| r.target_n != 0.0)
            .collect();
        let (paper, regression) = both(&loaded);
        let expected: f64 = (1..=7)
            .map(|i| 1.0 / (f64::from(i) * 10.0 + 1.0))
            .sum::<f64>()
            / 7.0;
        assert!((1.0 - paper - expected).abs() < 1e-12);
        assert!((expected - 0.035).abs() < 5e-4);
        assert!((regression - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_quadratic_lowers_the_free_slope_twice_as_much_as_the_mean_of_ratios() {
        // δ = F/K + β F²: 40 K β and 80 K β to first order over 10 to 70 N, β as stated in 1/(N·N/m).
        let beta = 1e-12;
        let loaded: Vec<Reading> = sweep(|force| -beta * force * force)
            .into_iter()
            .filter(|r| r.target_n != 0.0)
            .collect();
        let (paper, regression) = both(&loaded);
        let k_beta = 50e3 * beta;
        assert!(((1.0 - paper) / k_beta - 40.0).abs() < 0.01);
        assert!(((1.0 - regression) / k_beta - 80.0).abs() < 0.01);
    }

    #[test]
    fn with_the_unloaded_reading_the_slope_sees_a_little_of_a_dead_zone_and_less_of_a_quadratic() {
        // Forces 0 to 70 N: mean 35, Σ(F - 35)² = 4200. A dead zone b adds b · 35/4200 to the slope, K b = 1 N here; the slope
        // of F² is 70.
        let (_, regression) = both(&sweep(|force| if force < 0.0 { -20e-6 } else { 0.0 }));
        assert!((1.0 / regression - 1.0 - 35.0 / 4200.0).abs() < 1e-12);
        let beta = 1e-12;
        let (_, regression) = both(&sweep(|force| -beta * force * force));
        assert!(((1.0 - regression) / (50e3 * beta) - 70.0).abs() < 0.01);
    }

    #[test]
    fn the_paper_averages_readings_before_it_takes_the_ratio() {
        // One load, forces -9 and -11, displacements -10 and -30 µm: 10/20, not the mean of 0.9 and 0.367.
        let readings = [
            reading(1, 0, -10.0, -9.0, -10e-6),
            reading(2, 0, -10.0, -11.0, -30e-6),
        ];
        let paper = paper_of(&readings).unwrap();
        assert!((paper.value_n_per_m - 0.5e6).abs() < 1e-6);
        assert_eq!(paper.basis, ScatterBasis::Unavailable { n_runs: 2 });
        assert_eq!(paper.type_a, None);
    }

    #[test]
    fn the_uncertainty_from_runs_is_that_of_the_jackknife() {
        let bench = SimulatedBench {
            compliances_m_per_n: vec![20e-6],
            ..SimulatedBench::paper(1, 7)
        };
        let readings = bench.readings();
        let all = paper_of(&readings).unwrap();
        let without: Vec<f64> = (0..5)
            .map(|run| {
                let rest: Vec<Reading> =
                    readings.iter().filter(|r| r.run != run).cloned().collect();
                paper_of(&rest).unwrap().value_n_per_m
            })
            .collect();
        let mean = without.iter().sum::<f64>() / 5.0;
        let squares: f64 = without.iter().map(|k| (k - mean).powi(2)).sum();
        let jackknife = (0.8 * squares).sqrt();
        let type_a = all.type_a.unwrap();
        assert!((type_a.standard_uncertainty / jackknife - 1.0).abs() < 0.03);
        assert_eq!(
            (type_a.dof, all.basis),
            (4.0, ScatterBasis::RunToRun { n_runs: 5 })
        );
    }

    #[test]
    fn runs_of_one_reading_each_count_their_degrees_of_freedom_by_load() {
        // Five applications of two loads, every application a run of its own: 2 · (5 - 1).
        let readings: Vec<Reading> = (1..=10)
            .map(|run| Reading {
                zero: 0,
                ..reading(
                    run,
                    0,
                    if run <= 5 { -10.0 } else { -20.0 },
                    if run <= 5 { -10.0 } else { -20.0 },
                    if run <= 5 { -2e-4 } else { -4e-4 } - 1e-6 * f64::from(run % 5),
                )
            })
            .collect();
        assert_eq!(paper_of(&readings).unwrap().type_a.unwrap().dof, 8.0);
    }

    #[test]
    fn a_load_without_a_positive_ratio_takes_the_value_away_and_is_named() {
        let cases = [
            (0.0, -10.0, NoStiffness::NoDisplacement { target_n: -10.0 }),
            (3e-6, -10.0, NoStiffness::OppositeSigns { target_n: -10.0 }),
            (-2e-4, 0.0, NoStiffness::NoForce { target_n: -10.0 }),
        ];
        for (displacement, force, reason) in cases {
            let mut readings = sweep(|_| 0.0);
            readings[1].displacement_m = displacement;
            readings[1].force_n = force;
            assert_eq!(paper_of(&readings).unwrap_err(), reason);
        }
        let unloaded = [reading(1, 0, 0.0, 0.0, 1e-6)];
        assert_eq!(paper_of(&unloaded).unwrap_err(), NoStiffness::NoLoad);
    }

    #[test]
    fn a_flat_line_has_no_stiffness() {
        let readings = [
            reading(1, 0, 0.0, 0.0, 0.0),
            reading(1, 1, -10.0, -10.0, 0.0),
        ];
        let curve = curve(&readings);
        let line = LineFit::new(&curve).unwrap();
        assert_eq!(
            regression_stiffness(&curve, &line, None).unwrap_err(),
            NoStiffness::NoSlope
        );
    }
}
