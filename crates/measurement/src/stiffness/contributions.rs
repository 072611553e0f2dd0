//! The rows of an uncertainty budget, one function per source.
//!
//! How a certificate reaches a stiffness. U in newtons, common to all readings, can be an offset, a wrong scale or a curvature of
//! the gauge; the certificate cannot state which. Counted is the worst of them.
//! - The slope: an offset goes into the free intercept, so what is left is the scale, all of U reached at the largest load used:
//!   u(ln K) = (U/k) / F_max.
//! - The mean of F/δ: an error of one size and sign at every load, which is an offset: u(K) = u Σ |∂K/∂F_l|. No other error
//!   within ± U moves the mean further. It is taken as even within ± U, u = U/√3 (GUM 4.3.7), or U/k where that is more.
//!
//! The displacement gauge is treated likewise.
//!
//! How a display step reaches a slope. Rounding errors are within half a step, rectangular, q/√12. Where the repeats of a load
//! differ by more than the step they round differently, are averaged, and show in the scatter: counted once, there. Where all
//! repeats fall on one step they are wrong together, nothing shows, and the step is counted without averaging over repeats.

use super::budget_row::{
    BudgetInputs, BudgetRow, Distribution, EvaluationType, Return, RowUse, UncertaintySource,
};
use super::curve::{LoadCurve, LoadMean};
use super::estimate::{BareStiffness, Method, ScatterBasis};
use super::gauges::GaugeTerms;

/// Observed standard deviation in steps above which rounding errors differ from repeat to repeat: a normal spread of half a
/// step leaves them practically uniform, and together with q²/12 is seen as √(0.25 + 1/12) = 0.58 steps.
const ROUNDING_IS_AVERAGED_FROM_STEPS: f64 = 0.58;

fn row(source: UncertaintySource, unit: &'static str, sensitivity: f64) -> BudgetRow {
    BudgetRow {
        source,
        evaluation: EvaluationType::B,
        distribution: Distribution::Rectangular,
        standing: RowUse::NotStated,
        standard_uncertainty: None,
        unit,
        sensitivity: sensitivity.abs(),
        contribution_n_per_m: 0.0,
        dof: f64::INFINITY,
        share_percent: 0.0,
        note: "",
    }
}

impl BudgetRow {
    fn counted(mut self, standard_uncertainty: f64) -> Self {
        self.standing = RowUse::Counted;
        self.standard_uncertainty = Some(standard_uncertainty);
        self.contribution_n_per_m = self.sensitivity * standard_uncertainty;
        self
    }

    fn aside(mut self, standing: RowUse, note: &'static str) -> Self {
        self.standing = standing;
        self.noted(note)
    }

    fn noted(mut self, note: &'static str) -> Self {
        self.note = note;
        self
    }
}

pub(super) fn repeatability(bare: &BareStiffness) -> BudgetRow {
    let (unit, sensitivity) = match bare.method {
        Method::PaperMean => ("N/m", 1.0),
        Method::Regression => ("m/N", bare.value_n_per_m * bare.value_n_per_m),
    };
    let empty = BudgetRow {
        evaluation: EvaluationType::A,
        distribution: Distribution::Normal,
        ..row(UncertaintySource::Repeatability, unit, sensitivity)
    };
    match bare.type_a {
        Some(type_a) => BudgetRow {
            dof: type_a.dof,
            ..empty.counted(type_a.standard_uncertainty / sensitivity)
        },
        None => empty.noted("too few readings to estimate the scatter"),
    }
}

pub(super) fn resolution_rows(bare: &BareStiffness, inputs: &BudgetInputs<'_>) -> [BudgetRow; 2] {
    let curve = inputs.curve;
    // Without load the force is zero, not a rounded force.
    let force: f64 = curve
        .loaded()
        .map(|load| bare.per_force[load].powi(2))
        .sum();
    let displacement: f64 = bare.per_displacement.iter().map(|s| s * s).sum();
    let force_sd = repeat_sd(curve, |load| load.force_n.sd);
    let displacement_sd = repeat_sd(curve, |load| load.displacement_m.sd);
    let about_line = inputs.line.and_then(|line| line.residual_sd_m);
    let compliance = 1.0 / bare.value_n_per_m.abs();
    [
        resolution_row(
            row(UncertaintySource::ForceResolution, "N", force.sqrt()),
            &inputs.gauges.force,
            force_sd,
            about_line.map(|sd| sd / compliance),
        ),
        resolution_row(
            row(
                UncertaintySource::DisplacementResolution,
                "m",
                displacement.sqrt(),
            ),
            &inputs.gauges.displacement,
            displacement_sd,
            about_line,
        ),
    ]
}

/// `between_repeats` and `about_line`: standard deviations in the gauge's unit, `None` if there is none.
fn resolution_row(
    empty: BudgetRow,
    gauge: &GaugeTerms,
    between_repeats: Option<f64>,
    about_line: Option<f64>,
) -> BudgetRow {
    let Some(step) = gauge.resolution() else {
        return empty.noted("resolution not stated");
    };
    let standard_uncertainty = step / 12_f64.sqrt();
    let shows = match (between_repeats, about_line) {
        (Some(sd), _) => sd >= ROUNDING_IS_AVERAGED_FROM_STEPS * step,
        // Single readings round differently at each load, and the scatter about the line shows it.
        (None, Some(sd)) => sd >= standard_uncertainty,
        (None, None) => false,
    };
    let is_read_off = gauge.resolution_is_read_off();
    if shows {
        let note = if is_read_off {
            "not stated, step estimated from the readings; they differ by more than a step: included in the scatter"
        } else {
            "readings differ by more than a step: averaged, and included in the scatter"
        };
        return BudgetRow {
            standard_uncertainty: Some(standard_uncertainty),
            ..empty.aside(RowUse::InRepeatability, note)
        };
    }
    empty.counted(standard_uncertainty).noted(if is_read_off {
        "not stated, step estimated from the readings; repeats show the same step"
    } else {
        "repeats show the same step: common to the repeats of a load"
    })
}

/// Pooled standard deviation of the readings of a load, over the loads that have repeats.
fn repeat_sd(curve: &LoadCurve, sd: impl Fn(&LoadMean) -> Option<f64>) -> Option<f64> {
    let parts = curve.loaded().filter_map(|load| {
        let load = &curve.loads[load];
        Some((sd(load)?.powi(2), (load.n - 1) as f64))
    });
    let (sum, dof) = parts.fold((0.0, 0.0), |(sum, dof), (variance, n)| {
        (sum + variance * n, dof + n)
    });
    (dof > 0.0).then(|| (sum / dof).sqrt())
}

pub(super) fn calibration_rows(bare: &BareStiffness, inputs: &BudgetInputs<'_>) -> [BudgetRow; 2] {
    let [per_force, per_displacement] = match bare.method {
        Method::PaperMean => {
            [&bare.per_force, &bare.per_displacement].map(|per| per.iter().map(|s| s.abs()).sum())
        }
        Method::Regression => [
            inputs.curve.largest_force_n(),
            largest_displacement_m(bare, inputs.curve),
        ]
        .map(|largest| {
            if largest > 0.0 {
                bare.value_n_per_m / largest
            } else {
                0.0
            }
        }),
    };
    [
        calibration_row(
            row(UncertaintySource::ForceCalibration, "N", per_force),
            &inputs.gauges.force,
            bare.method,
        ),
        calibration_row(
            row(
                UncertaintySource::DisplacementCalibration,
                "m",
                per_displacement,
            ),
            &inputs.gauges.displacement,
            bare.method,
        ),
    ]
}

/// The ratio counts displacement from the gauge zero, the slope from its own intercept.
fn largest_displacement_m(bare: &BareStiffness, curve: &LoadCurve) -> f64 {
    match bare.method {
        Method::PaperMean => curve.largest_displacement_m(),
        Method::Regression => (curve.largest_force_n() / bare.value_n_per_m).abs(),
    }
}

fn calibration_row(empty: BudgetRow, gauge: &GaugeTerms, method: Method) -> BudgetRow {
    let empty = BudgetRow {
        distribution: match method {
            Method::Regression if !gauge.states_limits() => Distribution::Normal,
            Method::Regression | Method::PaperMean => Distribution::Rectangular,
        },
        ..empty
    };
    let Some(u) = gauge.calibration_standard_uncertainty() else {
        return empty.noted("calibration not stated");
    };
    let u = match method {
        Method::Regression => u,
        Method::PaperMean => gauge
            .expanded_uncertainty()
            .map_or(u, |expanded| u.max(expanded / 3_f64.sqrt())),
    };
    let note = match (method, gauge.coverage_factor_is_assumed()) {
        (Method::Regression, false) => "scale error at the largest value used, common to all cells",
        (Method::Regression, true) => {
            "scale error at the largest value used, common to all cells; k not stated, 2 assumed"
        }
        (Method::PaperMean, false) => "the same error at every load, common to all cells",
        (Method::PaperMean, true) => {
            "the same error at every load, common to all cells; k not stated, 2 assumed"
        }
    };
    empty.counted(u).noted(note)
}

pub(super) fn zero_setting(bare: &BareStiffness, inputs: &BudgetInputs<'_>) -> BudgetRow {
    let empty = BudgetRow {
        distribution: Distribution::Normal,
        ..row(
            UncertaintySource::ZeroSetting,
            "m",
            bare.per_common_displacement(),
        )
    };
    if bare.method == Method::Regression {
        return empty.aside(RowUse::NoEffect, "absorbed by the free intercept");
    }
    let (n_zeros, n_runs) = (inputs.curve.n_zeros, inputs.curve.runs.len());
    let between_runs = matches!(
        bare.basis,
        ScatterBasis::RunToRun { .. } | ScatterBasis::PooledRuns { .. }
    );
    if n_zeros >= n_runs && between_runs {
        let note = "each run has its own zero: included in the scatter between runs";
        return empty.aside(RowUse::InRepeatability, note);
    }
    let about_line = inputs.line.and_then(|line| {
        let dof = line.slope_by_residuals?.dof;
        Some((line.residual_sd_m?, dof))
    });
    let of_reading = inputs
        .pooled
        .map(|pooled| (pooled.displacement_sd_m, pooled.dof))
        .or(about_line);
    let Some((sd, dof)) = of_reading else {
        return empty.noted("zero shared, and no scatter of readings to estimate it from");
    };
    let step = inputs.gauges.displacement.resolution().unwrap_or(0.0);
    let of_zero = ((sd * sd + step * step / 12.0) / n_zeros as f64).sqrt();
    BudgetRow {
        dof,
        ..empty
            .counted(of_zero)
            .noted("error of a zero common to its runs, taken as that of one reading")
    }
}

/// Zeros that moved, each as a limit at the largest load; the drift of the force as the displacement that belongs to it.
pub(super) fn zero_drift(bare: &BareStiffness, inputs: &BudgetInputs<'_>) -> BudgetRow {
    let largest = largest_displacement_m(bare, inputs.curve);
    let sensitivity = if largest > 0.0 {
        bare.value_n_per_m / largest
    } else {
        0.0
    };
    let empty = row(UncertaintySource::ZeroDrift, "m", sensitivity);
    let beyond_step = |drift: f64, gauge: &GaugeTerms| {
        let is_seen = drift > gauge.resolution().unwrap_or(0.0);
        if is_seen { drift } else { 0.0 }
    };
    let (drift_m, note) = match inputs.back_to_zero {
        Return::NotMeasured => (None, "no unloaded reading after the loads"),
        Return::WithinNoise => (Some(0.0), "the gauge returned to zero within its noise"),
        Return::Checked(drift_m) => {
            let drift_m = beyond_step(drift_m, &inputs.gauges.displacement);
            let note = if drift_m > 0.0 {
                "largest change found by the zero checks, as a limit at the largest load"
            } else {
                "the checks of the zero found no change beyond a step of the gauge"
            };
            (Some(drift_m), note)
        }
        Return::Away(mean_m) => (
            Some(mean_m.abs()),
            "mean difference of the unloaded readings after and before, as a limit at the largest load",
        ),
    };
    let force_n = beyond_step(inputs.force_drift_n, &inputs.gauges.force);
    let of_force_m = force_n / bare.value_n_per_m.abs();
    let both_m = drift_m.unwrap_or_default().hypot(of_force_m);
    if both_m > 0.0 && both_m.is_finite() {
        let note = match (drift_m.is_some_and(|drift_m| drift_m > 0.0), force_n > 0.0) {
            (true, false) => note,
            (true, true) => {
                "changes of both zeros, as limits at the largest load; that of the force divided by K"
            }
            _ => {
                "largest change of the force zero found by its checks, divided by K, as a limit at the largest load"
            }
        };
        return empty.counted(both_m / 3_f64.sqrt()).noted(note);
    }
    match drift_m {
        None => empty.noted(note),
        Some(_) => empty.aside(RowUse::InRepeatability, note),
    }
}
