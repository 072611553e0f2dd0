//! A fit for people.

use std::fmt::Write;

use crate::analysis::{DerivedQuantity, ReadingMark, ResidualOrder, RunsTest};
use crate::fit::{FitMethod, WeightBasis};
use crate::least_squares::SigmaMode;
use crate::test_point::PoseId;

use super::correlation::correlation_text;
use super::fit_report::{FitReport, FittedCellReport, ParameterReport};
use super::load_case_page::planned_text;
use super::text::{
    TextColumn, digits, interval, or_dash, p_text, significant, table_of, with_unit,
};
use crate::count::{counted, degrees_of_freedom};
use crate::physics::Effect;

/// Probabilities below this are a finding.
const UNLIKELY: f64 = 0.01;

/// Numbers of marked readings that are printed; JSON has all.
const NUMBERS_PRINTED: usize = 8;

impl FitReport {
    /// The steps of the paper's method, if it was used; parameters, cells, and what to think of them.
    ///
    /// # Arguments
    /// - `warnings`: printed at the end.
    #[must_use]
    pub fn text(&self, warnings: &[String]) -> String {
        let mut text = self
            .steps
            .as_ref()
            .map_or_else(String::new, |steps| steps.text(&self.mechanism));
        text.push_str(&result(self, warnings));
        text
    }
}

fn result(fit: &FitReport, warnings: &[String]) -> String {
    let mut text = format!(
        "Mechanism {}, {}, {}.\n\n",
        fit.mechanism,
        method_words(fit.method),
        fit.termination
    );
    for session in &fit.sessions {
        let slope = session.run_slope_sd.map_or_else(
            || "too few repeats to show how the slopes of its runs scatter".to_owned(),
            |sd| {
                format!(
                    "slopes of its runs scatter by {} %",
                    significant(100.0 * sd, 2)
                )
            },
        );
        let _ = writeln!(
            text,
            "Session {}: {}, {slope}.",
            session.name,
            counted(session.cells, "cell")
        );
    }
    for mark in &fit.marked {
        text.push_str(&mark_text(mark));
    }
    if !(fit.sessions.is_empty() && fit.marked.is_empty()) {
        text.push('\n');
    }
    text.push_str(&held_fixed(&fit.physics));
    let bootstrap = fit
        .parameters
        .iter()
        .any(|parameter| parameter.ci95_bootstrap.is_some());
    let mut columns: Vec<TextColumn<'_, &ParameterReport>> = vec![
        ("parameter", &|one| with_unit(&one.name, one.unit)),
        ("start", &|one| significant(one.start, 4)),
        ("value", &|one| digits(one.value, 4)),
        ("standard error", &|one| digits(one.se, 2)),
        ("95 % interval", &|one| islands(one)),
        ("status", &|one| status_words(one.status, one.moved)),
    ];
    if bootstrap {
        columns.insert(
            5,
            ("95 %, bootstrap", &|one| interval(one.ci95_bootstrap, 4)),
        );
    }
    text.push_str(&table_of(&fit.parameters, &columns));
    if let Some(drawn) = &fit.bootstrap {
        let _ = writeln!(
            text,
            "Bootstrap: {}, {} drawn anew (seed {}), {} of the refits failed.",
            counted(drawn.replicates, "replicate"),
            drawn.over,
            drawn.seed,
            drawn.failed
        );
    }
    text.push_str(&derived_text(&fit.derived));
    text.push_str(&words(fit));
    text.push_str(&agreement_text(fit));
    text.push_str(&runs_text(&fit.runs_tests));
    text.push_str(&correlation_text(fit.correlation.as_ref()));
    text.push('\n');
    text.push_str(&cells_text(fit));
    if let Some(comparison) = &fit.comparison {
        text.push_str(&comparison.text());
    }
    for warning in warnings {
        let _ = writeln!(text, "\nnote: {warning}");
    }
    text
}

/// What acts beside the linear structure; empty without effects.
pub(super) fn held_fixed(physics: &[Effect]) -> String {
    if physics.is_empty() {
        return String::new();
    }
    let lines: Vec<String> = physics.iter().map(|one| format!("  {one}")).collect();
    let lines = lines.join("\n");
    format!("Physics beside the beams, held fixed:\n{lines}\n\n")
}

/// Which readings are left out or flagged, and why.
fn mark_text(mark: &ReadingMark) -> String {
    let used = if mark.status == "accepted" {
        "Used though flagged".to_owned()
    } else {
        format!("Left out, {}", mark.status)
    };
    let reason = if mark.flag.is_empty() {
        "no reason stated"
    } else {
        &mark.flag
    };
    let session = mark.session.as_ref();
    let session = session.map_or_else(String::new, |name| format!(" of session {name}"));
    let count = mark.readings.len();
    let numbers = mark.readings.iter().take(NUMBERS_PRINTED);
    let numbers: Vec<String> = numbers.map(ToString::to_string).collect();
    let more = if count > NUMBERS_PRINTED { ", ..." } else { "" };
    format!(
        "{used} ({reason}): {}{session}, number {}{more}.\n",
        counted(count, "reading"),
        numbers.join(", ")
    )
}

/// The status of a parameter, and whether the fit left it where it began.
pub(super) fn status_words(status: &str, moved: Option<bool>) -> String {
    let still = if moved == Some(false) {
        ", did not move"
    } else {
        ""
    };
    format!("{}{still}", status.replace('_', " "))
}

/// How much of the parameters the data determine.
pub(super) fn rank_text(data: &str, [rank, free]: [usize; 2], condition: Option<f64>) -> String {
    let condition = condition.map_or_else(|| "infinite".to_owned(), |value| significant(value, 3));
    format!(
        "The {data} determine {rank} of {} (rank of the Jacobian); condition number {condition}.\n",
        counted(free, "parameter")
    )
}

/// The 95 % interval, or the islands that it consists of.
fn islands(parameter: &ParameterReport) -> String {
    if parameter.islands.is_empty() {
        return interval(parameter.ci95, 4);
    }
    let parts = parameter
        .islands
        .iter()
        .map(|part| interval(Some(*part), 4));
    parts.collect::<Vec<_>>().join(" or ")
}

/// Sentences about factors that the data do not determine, and what would.
fn words(fit: &FitReport) -> String {
    let mut text = String::new();
    for parameter in &fit.parameters {
        if let Some(words) = &parameter.words {
            let _ = writeln!(text, "{}: {words}.", parameter.name);
        }
    }
    for combination in &fit.not_determined {
        let _ = writeln!(text, "Not determined by these cells: {combination}.");
    }
    if !text.is_empty() {
        text.insert(0, '\n');
    }
    if !fit.next.is_empty() {
        text.push_str(&planned_text(&fit.next, &fit.parameters));
    }
    text
}

fn agreement_text(fit: &FitReport) -> String {
    let (Some(sigma), Some(basis)) = (fit.sigma, fit.weights) else {
        return String::new();
    };
    let sigma = match sigma {
        SigmaMode::Known if matches!(basis, WeightBasis::FromResiduals { .. }) => {
            "scatter from run to run taken from the residuals"
        }
        SigmaMode::Known => "uncertainties of the stiffnesses taken as known",
        SigmaMode::Estimated => "scatter about the fit taken as the uncertainty of the stiffnesses",
    };
    let weights = match basis {
        WeightBasis::Pooled { run_slope_sd, dof } => {
            format!(
                "weights from scatter pooled over the cells (slope from run to run {:.2} %, {})",
                100.0 * run_slope_sd,
                degrees_of_freedom(dof)
            )
        }
        WeightBasis::FromResiduals { run_slope_sd, dof } => {
            format!(
                "weights from reading noise and {:.2} % from run to run ({})",
                100.0 * run_slope_sd,
                degrees_of_freedom(dof)
            )
        }
        WeightBasis::EachCell => "weights from each cell's own scatter".to_owned(),
        WeightBasis::Stated => "weights from the stated uncertainties".to_owned(),
        WeightBasis::Equal => "equal weights".to_owned(),
    };
    let dof = counted(fit.dof.unwrap_or_default(), "degree of freedom");
    let chi = fit
        .reduced_chi2
        .map_or_else(String::new, |chi| match fit.p {
            Some(p) => format!(
                "; lack of fit: reduced chi-squared {chi:.3} with {dof} (p = {})",
                p_text(p)
            ),
            // Of weights that the residuals gave it is 1 by construction, or less.
            None if matches!(basis, WeightBasis::FromResiduals { .. }) => String::new(),
            None if matches!(basis, WeightBasis::Equal) => format!(
                "; the stiffnesses scatter about the fit by {:.2} % with {dof}",
                100.0 * chi.sqrt()
            ),
            None => format!(
                "; the stiffnesses scatter about the fit by {} times what their weights say, with {dof}",
                significant(chi.sqrt(), 3)
            ),
        });
    let rank = [fit.rank, fit.free].map(Option::unwrap_or_default);
    format!(
        "\nIntervals: likelihood ratio, {sigma}; {weights}{chi}.\n{}",
        rank_text("cells", rank, fit.condition)
    )
}

/// Quantities that were derived from the parameters; empty without any.
#[must_use]
pub fn derived_text(derived: &[DerivedQuantity]) -> String {
    if derived.is_empty() {
        return String::new();
    }
    let table = table_of(
        derived,
        &[
            ("derived", &|one| one.name.clone()),
            ("from", &|one| one.expression.clone()),
            ("value", &|one| significant(one.value, 4)),
            ("standard error", &|one| digits(one.se, 2)),
            ("95 % interval", &|one| interval(one.ci95, 4)),
        ],
    );
    let mut words = String::new();
    for one in derived {
        if let Some(known) = &one.words {
            let _ = writeln!(words, "{}: {known}.", one.name);
        }
    }
    format!("\n{table}{words}")
}

/// What the runs tests of the residuals show.
fn runs_text(tests: &[RunsTest]) -> String {
    let line = |test: &RunsTest| {
        let order = match test.against {
            ResidualOrder::Load => "Residuals by load within runs",
            ResidualOrder::Order => "Slopes of runs in order of time",
        };
        let verdict = if test.p < UNLIKELY {
            "a structure is left: stiffbench diagnose looks for its cause"
        } else {
            "as of independent errors"
        };
        format!(
            "{order}: {} stretches of one sign, {:.0} expected (p = {}): {verdict}.\n",
            test.runs,
            test.expected,
            p_text(test.p)
        )
    };
    tests.iter().map(line).collect()
}

fn cells_text(fit: &FitReport) -> String {
    let left_out = fit
        .cells
        .iter()
        .any(|cell| cell.predicted_without_its_pose.is_some());
    let without_its_pose = |cell: &&FittedCellReport| {
        let without = cell.predicted_without_its_pose.as_ref();
        let without = without.and_then(|k| Some(k.value? / cell.measured.value?));
        or_dash(without, |ratio| format!("{:.2}", 100.0 * ratio))
    };
    let held_out = |cell: &&FittedCellReport| if cell.held_out { "yes" } else { "" }.to_owned();
    let mut text = String::new();
    if !fit.cells.is_empty() {
        text = table_of(
            &fit.cells,
            &[
                ("pose", &|cell| {
                    of_session(cell.session.as_ref(), &cell.pose)
                }),
                ("direction", &|cell| cell.direction.to_string()),
                ("measured, N/um", &|cell| digits(cell.measured.value, 4)),
                ("predicted, N/um", &|cell| digits(cell.predicted.value, 4)),
                ("predicted/measured, %", &|cell| {
                    format!("{:.2}", cell.ratio_percent)
                }),
                if left_out {
                    ("without its pose, %", &without_its_pose)
                } else {
                    ("held out", &held_out)
                },
            ],
        );
    }
    text.push_str(&across_text(fit));
    if let Some(worst) = fit.max_error_percent {
        let unseen = left_out || fit.cells.iter().any(|cell| cell.held_out);
        let which = if unseen {
            "cells the fit did not see"
        } else {
            "cells of the fit itself"
        };
        let _ = writeln!(text, "\nLargest error over the {which}: {worst:.2} %.");
    }
    text
}

/// A pose, of one of several sessions with its name.
fn of_session(session: Option<&String>, pose: &PoseId) -> String {
    match session {
        Some(session) => format!("{session}/{pose}"),
        None => pose.to_string(),
    }
}

/// Compliances along other axes than that of the load; empty of one gauge.
fn across_text(fit: &FitReport) -> String {
    if fit.across.is_empty() {
        return String::new();
    }
    let table = table_of(
        &fit.across,
        &[
            ("pose", &|one| of_session(one.session.as_ref(), &one.pose)),
            ("load", &|one| one.load.clone()),
            ("axis", &|one| one.axis.to_string()),
            ("measured, um/N", &|one| digits(one.measured.value, 4)),
            ("u, um/N", &|one| {
                digits(one.measured.standard_uncertainty, 2)
            }),
            ("predicted, um/N", &|one| digits(one.predicted.value, 4)),
        ],
    );
    format!("\n{table}")
}

fn method_words(method: FitMethod) -> &'static str {
    match method {
        FitMethod::LeastSquares => "least squares on ln K of all training cells",
        FitMethod::Paper => "the paper's procedure",
    }
}
