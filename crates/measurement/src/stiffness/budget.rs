//! The uncertainty budget of a stiffness (GUM clauses 4, 5 and annex G).

use super::budget_row::{BudgetInputs, BudgetRow, EvaluationType, RowUse, UncertaintySource};
use super::contributions::{
    calibration_rows, repeatability, resolution_rows, zero_drift, zero_setting,
};
use super::covariance::LnParts;
use super::estimate::{BareStiffness, Method, ScatterBasis};
use super::line::TypeA;
use stiffbench_numeric::statistics::{Estimate, welch_satterthwaite};

/// All rows of a stiffness; what is not stated has its row too.
#[derive(Debug, Clone, PartialEq)]
pub struct Budget {
    /// The rows, scatter first.
    pub rows: Vec<BudgetRow>,
}

/// Stiffness of one cell by one method.
#[derive(Debug, Clone, PartialEq)]
pub struct StiffnessEstimate {
    /// How it was computed.
    pub method: Method,
    /// Value, combined standard uncertainty and effective degrees of freedom, N/m. Without a type A part there is no combined
    /// uncertainty, since the rest alone would be too small.
    pub estimate: Estimate,
    /// Part from observed scatter, N/m.
    pub type_a: Option<TypeA>,
    /// Part from other knowledge, standard uncertainty in N/m; what is not stated is not in it (see `budget`).
    pub type_b_n_per_m: f64,
    /// What `type_a` rests on.
    pub basis: ScatterBasis,
    /// Where the uncertainty comes from.
    pub budget: Budget,
    /// The uncertainty of ln K, split into what cells share and what they do not.
    pub ln_parts: LnParts,
}

impl Budget {
    /// The row of `source`.
    #[must_use]
    pub fn row(&self, source: UncertaintySource) -> Option<&BudgetRow> {
        self.rows.iter().find(|row| row.source == source)
    }
}

/// Relative size of what the rounding of sums leaves; no scatter of readings is as small.
const SUMS_ROUNDING: f64 = 1e-12;

/// Beyond so many degrees of freedom Student's t is the normal distribution, and their number means nothing.
const MANY_DOF: f64 = 1e6;

/// Adds the rows of the gauges to a stiffness and combines them (GUM eqs. (10) and (G.2b)).
pub(super) fn combine(bare: &BareStiffness, inputs: &BudgetInputs<'_>) -> StiffnessEstimate {
    let mut rows = vec![repeatability(bare)];
    rows.extend(resolution_rows(bare, inputs));
    rows.extend(calibration_rows(bare, inputs));
    rows.push(zero_setting(bare, inputs));
    rows.push(zero_drift(bare, inputs));

    let variance: f64 = rows.iter().map(|r| r.contribution_n_per_m.powi(2)).sum();
    for row in &mut rows {
        if variance > 0.0 {
            row.share_percent = 100.0 * row.contribution_n_per_m.powi(2) / variance;
        }
    }
    // Runs that are equal digit for digit differ by the rounding of sums, which is no scatter.
    let standard = Some(variance.sqrt()).filter(|u| *u > SUMS_ROUNDING * bare.value_n_per_m.abs());
    let estimate = match bare.type_a {
        Some(_) => Estimate {
            value: bare.value_n_per_m,
            standard_uncertainty: standard.unwrap_or(0.0),
            dof: effective_dof(&rows, |_| true),
        },
        None => Estimate::without_uncertainty(bare.value_n_per_m),
    };
    let of = |wanted: fn(&BudgetRow) -> bool| {
        let rows = rows.iter().filter(|row| wanted(row));
        let sum: f64 = rows.map(|row| row.contribution_n_per_m.powi(2)).sum();
        sum.sqrt()
    };
    let size = bare.value_n_per_m.abs();
    StiffnessEstimate {
        method: bare.method,
        estimate,
        type_a: bare.type_a,
        type_b_n_per_m: of(|row| row.evaluation == EvaluationType::B),
        basis: bare.basis,
        ln_parts: LnParts {
            independent: bare.type_a.map(|_| of(is_of_the_cell) / size),
            independent_dof: effective_dof(&rows, is_of_the_cell),
            force_calibration: of(|row| row.source == UncertaintySource::ForceCalibration) / size,
            displacement_calibration: of(|row| {
                row.source == UncertaintySource::DisplacementCalibration
            }) / size,
        },
        budget: Budget { rows },
    }
}

fn is_of_the_cell(row: &BudgetRow) -> bool {
    !matches!(
        row.source,
        UncertaintySource::ForceCalibration | UncertaintySource::DisplacementCalibration
    )
}

fn effective_dof(rows: &[BudgetRow], counts: fn(&BudgetRow) -> bool) -> f64 {
    let parts: Vec<(f64, f64)> = rows
        .iter()
        .filter(|row| counts(row) && row.standing == RowUse::Counted)
        .map(|row| (row.contribution_n_per_m, row.dof))
        .collect();
    // Readings without any scatter: their degrees of freedom still limit what is known.
    let without_scatter = parts.iter().all(|(u, _)| *u == 0.0);
    let dof = if without_scatter {
        parts
            .iter()
            .map(|(_, dof)| *dof)
            .fold(f64::INFINITY, f64::min)
    } else {
        welch_satterthwaite(&parts)
    };
    if dof > MANY_DOF { f64::INFINITY } else { dof }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::readings::Reading;
    use crate::stiffness::budget_row::Return;
    use crate::stiffness::curve::{Branches, LoadCurve};
    use crate::stiffness::estimate::{paper_stiffness, regression_stiffness};
    use crate::stiffness::gauges::{GaugePair, GaugeTerms};
    use crate::stiffness::line::LineFit;
    use crate::stiffness::sample::{cell, reading};

    /// Force gauge 0.1 N, U 0.15 N; displacement gauge 10 µm, U 4 µm; both k = 2.
    fn gauges() -> GaugePair {
        GaugePair {
            force: GaugeTerms::new(Some(0.1), Some(0.15), Some(2.0)).unwrap(),
            displacement: GaugeTerms::new(Some(10e-6), Some(4e-6), Some(2.0)).unwrap(),
        }
    }

    /// Three runs of 10, 20, 30 N on slopes of 18, 20 and 22 µm/N: mean 20 µm/N, 0.05 N/µm.
    fn three_slopes() -> Vec<Reading> {
        (1..=3_u32)
            .flat_map(|run| {
                (1..=3_u32).map(move |step| {
                    let force = 10.0 * f64::from(step);
                    let slope = (16.0 + 2.0 * f64::from(run)) * 1e-6;
                    reading(run, step, force, force, slope * force)
                })
            })
            .collect()
    }

    fn estimates(readings: &[Reading], gauges: &GaugePair) -> [StiffnessEstimate; 2] {
        let refs: Vec<&Reading> = readings.iter().collect();
        let curve = LoadCurve::new(cell(), &refs, Branches::LoadingOnly);
        let line = LineFit::new(&curve).unwrap();
        let inputs = BudgetInputs {
            curve: &curve,
            line: Some(&line),
            gauges,
            pooled: None,
            back_to_zero: Return::NotMeasured,
            force_drift_n: 0.0,
        };
        [
            combine(&paper_stiffness(&curve, None).unwrap(), &inputs),
            combine(&regression_stiffness(&curve, &line, None).unwrap(), &inputs),
        ]
    }

    fn close(found: f64, expected: f64) {
        assert!(
            (found / expected - 1.0).abs() < 1e-9,
            "{found} is not {expected}"
        );
    }

    #[test]
    fn the_rows_of_a_regression_are_those_worked_by_hand() {
        let [_, regression] = estimates(&three_slopes(), &gauges());
        let k = 0.05e6;
        let row = |source| regression.budget.row(source).unwrap();
        // Slopes 18, 20, 22: standard deviation 2, of the mean 2/√3, two degrees of freedom.
        let repeatability = row(UncertaintySource::Repeatability);
        close(
            repeatability.standard_uncertainty.unwrap(),
            2e-6 / 3_f64.sqrt(),
        );
        close(repeatability.sensitivity, k * k);
        assert_eq!((repeatability.dof, repeatability.unit), (2.0, "m/N"));
        // All forces of a load are equal: the step is common to the repeats. Load weights (F - 20)/200, K · √(2 · 0.05²).
        let force_step = row(UncertaintySource::ForceResolution);
        close(
            force_step.standard_uncertainty.unwrap(),
            0.1 / 12_f64.sqrt(),
        );
        close(force_step.sensitivity, k * (2.0 * 0.05_f64.powi(2)).sqrt());
        assert_eq!(force_step.standing, RowUse::Counted);
        // Displacements of a load differ by 20 to 60 µm, more than a step: in the scatter.
        let step = row(UncertaintySource::DisplacementResolution);
        assert_eq!(step.standing, RowUse::InRepeatability);
        assert_eq!(step.contribution_n_per_m, 0.0);
        // Scale at the largest load: 30 N and 600 µm.
        close(
            row(UncertaintySource::ForceCalibration).contribution_n_per_m,
            k * 0.075 / 30.0,
        );
        let of_displacement = row(UncertaintySource::DisplacementCalibration).contribution_n_per_m;
        close(of_displacement, k * 2e-6 / 600e-6);
        assert_eq!(
            row(UncertaintySource::ZeroSetting).standing,
            RowUse::NoEffect
        );
        assert_eq!(
            row(UncertaintySource::ZeroDrift).standing,
            RowUse::NotStated
        );

        let parts = [
            k * k * 2e-6 / 3_f64.sqrt(),
            k * 0.1 / 12_f64.sqrt() * 0.005_f64.sqrt(),
            k * 0.0025,
            k / 300.0,
        ];
        let variance: f64 = parts.iter().map(|u| u * u).sum();
        close(regression.estimate.standard_uncertainty, variance.sqrt());
        close(
            regression.estimate.dof,
            variance * variance / (parts[0].powi(4) / 2.0),
        );
        let shares: f64 = regression.budget.rows.iter().map(|r| r.share_percent).sum();
        close(shares, 100.0);
        let type_b: f64 = parts[1..].iter().map(|u| u * u).sum();
        close(regression.type_b_n_per_m, type_b.sqrt());
        close(regression.ln_parts.force_calibration, 0.0025);
        close(regression.ln_parts.displacement_calibration, 1.0 / 300.0);
        let independent = (parts[0].powi(2) + parts[1].powi(2)).sqrt() / k;
        close(regression.ln_parts.independent.unwrap(), independent);
    }

    #[test]
    fn what_is_not_stated_has_its_row_and_does_not_count() {
        let [paper, regression] = estimates(&three_slopes(), &GaugePair::default());
        for estimate in [paper, regression] {
            assert_eq!(estimate.budget.rows.len(), 7);
            let not_stated = [
                UncertaintySource::ForceResolution,
                UncertaintySource::DisplacementResolution,
                UncertaintySource::ForceCalibration,
                UncertaintySource::DisplacementCalibration,
            ];
            for source in not_stated {
                let row = estimate.budget.row(source).unwrap();
                assert_eq!(
                    (row.standing, row.standard_uncertainty),
                    (RowUse::NotStated, None)
                );
                assert!(row.note.contains("not stated"));
            }
            assert_eq!(estimate.type_b_n_per_m, 0.0);
        }
    }

    #[test]
    fn a_zero_shared_by_the_runs_counts_for_the_ratio_and_not_for_the_slope() {
        let mut readings = three_slopes();
        let [apart, _] = estimates(&readings, &gauges());
        let setting = apart.budget.row(UncertaintySource::ZeroSetting).unwrap();
        assert_eq!(setting.standing, RowUse::InRepeatability);
        for reading in &mut readings {
            reading.zero = 0;
        }
        let [paper, regression] = estimates(&readings, &gauges());
        let setting = paper.budget.row(UncertaintySource::ZeroSetting).unwrap();
        assert_eq!(setting.standing, RowUse::Counted);
        // dK/d(zero) = mean of K/δ over 200, 400, 600 µm.
        close(
            setting.sensitivity,
            50e3 * (1.0 / 200e-6 + 1.0 / 400e-6 + 1.0 / 600e-6) / 3.0,
        );
        let setting = regression
            .budget
            .row(UncertaintySource::ZeroSetting)
            .unwrap();
        assert_eq!(setting.contribution_n_per_m, 0.0);
    }

    #[test]
    fn a_drift_of_the_zero_is_a_limit_at_the_largest_load() {
        let readings = three_slopes();
        let refs: Vec<&Reading> = readings.iter().collect();
        let curve = LoadCurve::new(cell(), &refs, Branches::LoadingOnly);
        let line = LineFit::new(&curve).unwrap();
        let gauges = GaugePair::default();
        let inputs = BudgetInputs {
            curve: &curve,
            line: Some(&line),
            gauges: &gauges,
            pooled: None,
            back_to_zero: Return::Away(-12e-6),
            force_drift_n: 0.0,
        };
        let estimate = combine(&regression_stiffness(&curve, &line, None).unwrap(), &inputs);
        let drift = estimate.budget.row(UncertaintySource::ZeroDrift).unwrap();
        close(
            drift.contribution_n_per_m,
            0.05e6 * 12.0 / 600.0 / 3_f64.sqrt(),
        );
    }

    #[test]
    fn a_checked_zero_counts_by_its_drift_once_it_exceeds_a_step_of_the_gauge() {
        let readings: Vec<Reading> = (0..8)
            .map(|step| {
                let load_n = -10.0 * f64::from(step);
                reading(1, step, load_n, load_n, load_n / 0.05e6)
            })
            .collect();
        let refs: Vec<&Reading> = readings.iter().collect();
        let curve = LoadCurve::new(cell(), &refs, Branches::LoadingOnly);
        let line = LineFit::new(&curve).unwrap();
        let gauges = gauges();
        let step_m = gauges.displacement.resolution().unwrap();
        let of = |drift_m: f64, force_drift_n: f64| {
            let inputs = BudgetInputs {
                curve: &curve,
                line: Some(&line),
                gauges: &gauges,
                pooled: None,
                back_to_zero: Return::Checked(drift_m),
                force_drift_n,
            };
            let estimate = combine(&regression_stiffness(&curve, &line, None).unwrap(), &inputs);
            *estimate.budget.row(UncertaintySource::ZeroDrift).unwrap()
        };
        let step_n = gauges.force.resolution().unwrap();
        assert_eq!(of(step_m, step_n).standing, RowUse::InRepeatability);
        // A limit at the largest load, where the end gives way by 1.4 mm.
        let one_percent = 0.05e6 * 0.01 / 3_f64.sqrt();
        close(of(14e-6, 0.0).contribution_n_per_m, one_percent);
        // 0.7 N of 70 N are as much, whatever the displacement gauge did; both are independent.
        close(of(step_m, 0.7).contribution_n_per_m, one_percent);
        close(
            of(14e-6, 0.7).contribution_n_per_m,
            2_f64.sqrt() * one_percent,
        );
    }

    #[test]
    fn without_any_scatter_to_see_there_is_no_combined_uncertainty() {
        let readings = [
            reading(1, 0, 0.0, 0.0, 0.0),
            reading(1, 1, -10.0, -10.0, -2e-4),
        ];
        for estimate in estimates(&readings, &gauges()) {
            assert!(estimate.estimate.standard_uncertainty.is_nan());
            assert_eq!(estimate.estimate.expanded_95(), None);
            assert!(estimate.type_b_n_per_m > 0.0);
            assert_eq!(estimate.ln_parts.independent, None);
        }
    }

    #[test]
    fn equal_runs_have_no_scatter_and_their_figures_no_endless_digits() {
        let readings: Vec<Reading> = (1..=3_u32)
            .flat_map(|run| {
                let of = [
                    (0.0, 0.0),
                    (10.0, 20.1e-6),
                    (20.0, 40.7e-6),
                    (30.0, 60.2e-6),
                ];
                (0..4_u32)
                    .zip(of)
                    .map(move |(step, (force, d))| reading(run, step, force, force, d))
            })
            .collect();
        for estimate in estimates(&readings, &GaugePair::default()) {
            assert_eq!(estimate.estimate.standard_uncertainty, 0.0);
        }
        // What the display leaves open is all that is left, and it is taken as known.
        let [_, regression] = estimates(&readings, &gauges());
        assert!(regression.estimate.standard_uncertainty > 0.0);
        assert!(regression.estimate.dof.is_infinite());
    }
}
