//! A fit for people.

use stiffbench_document::{Document, Table, sign_of};

use crate::analysis::{DerivedQuantity, ReadingMark, ResidualOrder, RunsTest};
use crate::fit::{FactorStatus, FitMethod, FitOutcome, StatusWord, WeightBasis};
use crate::fit::{PlannedLoadCase, ProposedWithin};
use crate::least_squares::SigmaMode;
use crate::robot::JointMotion;
use crate::test_point::PoseId;

use super::correlation::correlations;
use super::fit_report::{FitReport, FittedCellReport, FramesReport, ParameterReport};
use super::robot::physics_document;
use super::text::{digits, interval, micro, or_dash, p_text, significant, unit_behind};
use crate::count::{counted, degrees_of_freedom};

/// Probabilities below this are a finding.
const UNLIKELY: f64 = 0.01;

/// Numbers of marked readings that are printed; JSON has all.
const NUMBERS_PRINTED: usize = 8;

/// A standard error that a planned load case leaves above this share of itself is not printed.
const WORTH_PRINTING: f64 = 0.99;

impl FitReport {
    /// The steps of the paper's method, if it was used; parameters, cells or errors by pose, and what to think of them.
    ///
    /// # Arguments
    /// - `outcome`: the fit that this reports.
    #[must_use]
    pub fn document(&self, outcome: &FitOutcome) -> Document {
        let mut document = self
            .steps
            .as_ref()
            .map_or_else(Document::new, |steps| steps.document(&self.mechanism));
        document.append(result(self, outcome));
        document
    }
}

fn result(fit: &FitReport, outcome: &FitOutcome) -> Document {
    let mut document = Document::of(format!(
        "Mechanism {}, {}, {}.",
        fit.mechanism,
        method_words(fit),
        fit.termination
    ));
    document.paragraphs(largest_error(fit));
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
        document.item(format!(
            "Session {}: {}, {slope}.",
            session.name,
            counted(session.cells, "cell")
        ));
    }
    document.items(fit.marked.iter().map(mark_words));
    document.append(physics_document(
        "Physics beside the beams, held fixed:",
        &fit.physics,
    ));
    document.append(parameter_tables(&fit.parameters));
    document.paragraphs(fit.bootstrap.as_ref().map(|drawn| {
        format!(
            "Bootstrap: {}, {} resampled (seed {}); {} of the refits failed.",
            counted(drawn.replicates, "replicate"),
            drawn.over,
            drawn.seed,
            drawn.failed
        )
    }));
    document.append(derived(&fit.derived));
    document.append(undetermined(fit));
    document.append(next(fit));
    if let Some(frames) = &fit.frames {
        document.append(frames_table(frames));
    }
    document.paragraphs(agreement_sentences(fit));
    document.items(fit.runs_tests.iter().map(runs_words));
    document.append(correlations(fit.correlation.as_ref()));
    document.append(cells(fit));
    if !fit.components.is_empty() {
        document.append(pose_errors(fit, outcome));
    }
    if let Some(comparison) = &fit.comparison {
        document.append(comparison.document());
    }
    for warning in &outcome.warnings {
        document.paragraph(format!("note: {warning}"));
    }
    document
}

/// Which readings are left out or flagged, and why.
fn mark_words(mark: &ReadingMark) -> String {
    let used = if mark.status == "accepted" {
        "Used despite a flag".to_owned()
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
        "{used} ({reason}): {}{session}, number {}{more}.",
        counted(count, "reading"),
        numbers.join(", ")
    )
}

/// The status of a parameter, and whether the fit left it where it began.
fn status_words(status: StatusWord, moved: Option<bool>) -> String {
    let still = if moved == Some(false) {
        ", did not move"
    } else {
        ""
    };
    format!("{status}{still}")
}

/// How many of the parameters have a value: of those that the Jacobian determines some may fit with any value within their bounds.
fn rank_words(fit: &FitReport) -> String {
    let [rank, free] = [fit.rank, fit.free].map(Option::unwrap_or_default);
    let condition = or_infinite(fit.condition.map(|value| significant(value, 3)));
    let open = fit.parameters.iter();
    let open = open.filter(|one| one.status == StatusWord::NotIdentified && one.bounds.is_some());
    let open: Vec<&str> = open.map(|one| one.name.as_str()).collect();
    let data = data_words(fit);
    if open.is_empty() || rank < free {
        return format!(
            "The {data} determine {rank} of {} (rank of the Jacobian); condition number {condition}.",
            counted(free, "parameter")
        );
    }
    format!(
        "The {data} determine {} of {free} parameters: all but {} (the Jacobian has rank {rank}, but the interval does not end within the bounds); condition number {condition}.",
        free.saturating_sub(open.len()),
        open.join(", ")
    )
}

/// What a fit has its numbers from.
fn data_words(fit: &FitReport) -> &'static str {
    if fit.components.is_empty() {
        "cells"
    } else {
        "poses"
    }
}

fn or_infinite(value: Option<String>) -> String {
    value.unwrap_or_else(|| "infinite".to_owned())
}

fn interval_in_micro(ends: Option<[f64; 2]>) -> String {
    interval(ends.map(|ends| ends.map(micro)), 4)
}

/// Factors and springs, each with start or stiffness, value, standard error and interval; of load cases on rigid links springs alone.
fn parameter_tables(parameters: &[ParameterReport]) -> Document {
    let bootstrap = parameters.iter().any(|one| one.ci95_bootstrap.is_some());
    let (springs, factors): (Vec<_>, Vec<_>) = parameters
        .iter()
        .partition(|one| one.stiffness_unit.is_some());
    let mut document = Document::new();
    if factors.iter().any(|one| one.status != StatusWord::Fixed) || springs.is_empty() {
        let table = Table::of(factors)
            .words("parameter", |one| &one.name)
            .numbers("start", |one| significant(one.start, 4))
            .numbers("value", |one| digits(one.value, 4))
            .numbers("standard error", |one| digits(one.se, 2))
            .numbers("95 % interval", |one| islands(one))
            .when(bootstrap, |table| {
                table.numbers("95 %, bootstrap", |one| interval(one.ci95_bootstrap, 4))
            });
        document.table(table.words("status", |one| status_words(one.status, one.moved)));
    }
    if springs.is_empty() {
        return document;
    }
    let stiffness = |one: &&ParameterReport| {
        or_dash(one.value, |_| {
            or_infinite(one.stiffness.map(|value| significant(value, 4)))
        })
    };
    let of_stiffness = |one: &&ParameterReport| {
        or_dash(one.stiffness_ci95, |ends| {
            let [low, high] = ends.map(|end| or_infinite(end.map(|end| significant(end, 4))));
            format!("{low} to {high}")
        })
    };
    let table = Table::of(springs)
        .words("spring", |one| &one.name)
        .numbers("compliance, 1e-6", |one| digits(one.value.map(micro), 4))
        .numbers("standard error", |one| digits(one.se.map(micro), 2))
        .numbers("95 % interval", |one| interval_in_micro(one.ci95))
        .when(bootstrap, |table| {
            table.numbers("95 %, bootstrap", |one| {
                interval_in_micro(one.ci95_bootstrap)
            })
        })
        .numbers("stiffness", stiffness)
        .numbers("95 % interval", of_stiffness)
        .words("unit", |one| one.stiffness_unit.clone().unwrap_or_default())
        .words("status", |one| status_words(one.status, one.moved));
    document.table(table);
    document
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

/// Parameters, and combinations of them, that the data do not determine.
fn undetermined(fit: &FitReport) -> Document {
    let mut document = Document::new();
    document.items(fit.parameters.iter().filter_map(|parameter| {
        let words = parameter.words.as_ref()?;
        Some(format!("{}: {words}.", parameter.name))
    }));
    let data = data_words(fit);
    let combinations = fit.not_determined.iter();
    document.items(combinations.map(|one| format!("Not determined by these {data}: {one}.")));
    document
}

/// How the components of load cases scatter.
fn component_scatter(fit: &FitReport, basis: WeightBasis) -> Option<String> {
    let displacement = fit.displacement_sd_um;
    let displacement =
        displacement.map(|sd| format!("{} µm of a displacement", significant(sd, 3)));
    let rotation = fit.rotation_sd_urad;
    let rotation = rotation.map(|sd| format!("{} µrad of a rotation", significant(sd, 3)));
    let (source, load_sd, dof) = match basis {
        WeightBasis::Pooled { run_slope_sd, dof } => ("from the repeats", run_slope_sd, dof),
        WeightBasis::FromResiduals { run_slope_sd, dof } => {
            ("from the residuals over the poses", run_slope_sd, dof)
        }
        // What is stated has no degrees of freedom that would count.
        WeightBasis::Stated => ("as stated", 0.0, f64::INFINITY),
        WeightBasis::EachCell | WeightBasis::Equal => return None,
    };
    let load = (load_sd > 0.0).then(|| {
        format!(
            "{} % of the displacement under load",
            significant(100.0 * load_sd, 2)
        )
    });
    let parts: Vec<String> = [displacement, rotation, load]
        .into_iter()
        .flatten()
        .collect();
    let lack = fit.p.map_or_else(String::new, |p| {
        format!(
            "; lack of fit: reduced chi-squared {}, p = {}",
            digits(fit.reduced_chi2, 3),
            p_text(p)
        )
    });
    let dof = (dof.is_finite()).then(|| format!(", {}", degrees_of_freedom(dof)));
    Some(format!(
        "Scatter {source}: {}{}{lack}.",
        parts.join(", "),
        dof.unwrap_or_default()
    ))
}

/// Further load cases that would determine what is open; of springs that no force loads, that there are none.
fn next(fit: &FitReport) -> Document {
    let mut document = Document::new();
    // Of positions the reason of each spring names what would determine it.
    if fit.frames.is_some() {
        return document;
    }
    if !fit.next.is_empty() {
        document = planned(&fit.next, &fit.parameters);
        if let Some(within) = &fit.next_within {
            document.paragraph(kept_words(within));
        }
        return document;
    }
    let springs = fit.parameters.iter();
    let springs = springs
        .filter(|one| one.stiffness_unit.is_some() && one.status == StatusWord::NotIdentified);
    let open: Vec<&str> = springs.map(|one| one.name.as_str()).collect();
    if !open.is_empty() {
        document.paragraph(format!(
            "No force at the tool centre would determine {}: apply a moment, or load a point off the axis and state it as `at_mm` of [tool].",
            open.join(", ")
        ));
    }
    document
}

/// Scatter and weights, and how many parameters the data determine.
fn agreement_sentences(fit: &FitReport) -> Vec<String> {
    let (Some(sigma), Some(basis)) = (fit.sigma, fit.weights) else {
        return Vec::new();
    };
    if !fit.components.is_empty() {
        let scatter = component_scatter(fit, basis).into_iter();
        return scatter.chain([rank_words(fit)]).collect();
    }
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
    let intervals = format!("Intervals: likelihood ratio, {sigma}; {weights}{chi}.");
    vec![intervals, rank_words(fit)]
}

/// Planned load cases with what they do for the parameters.
fn planned(planned: &[PlannedLoadCase], parameters: &[ParameterReport]) -> Document {
    let mut document = Document::of(
        "Next load cases that would best determine the open parameters (standard errors now and after each):",
    );
    for next in planned {
        let errors = next.errors.iter().filter(|one| {
            one.then
                .is_some_and(|then| one.now.is_none_or(|now| then < WORTH_PRINTING * now))
        });
        let errors = errors.map(|one| {
            let own = parameters.iter().find(|own| own.name == one.name);
            // Of a factor the error of its logarithm is planned; the table has that of its value.
            let (scale, unit) = match own {
                Some(own) if own.unit == "1" => (own.value.unwrap_or(1.0), String::new()),
                Some(own) => (1.0, unit_behind(&own.unit)),
                None => (1.0, String::new()),
            };
            let [now, then] = [one.now, one.then].map(|error| {
                error.map_or_else(
                    || "unknown".to_owned(),
                    |error| significant(scale * error, 2),
                )
            });
            format!("{} {now} to {then}{unit}", one.name)
        });
        document.item(format!(
            "{} N along {} in pose {}: {}; tool at {} mm. {}",
            significant(next.force_n, 3),
            next.direction,
            next.name,
            joint_words(next),
            tool_words(next.tool_m),
            errors.collect::<Vec<_>>().join(", ")
        ));
    }
    document
}

/// What the poses of a plan keep, and how to state other rules.
pub(super) fn kept_words(within: &ProposedWithin) -> String {
    format!(
        "New poses keep {}. Nothing else is known of obstacles: --floor-mm, --base-radius-mm and --limit-margin-percent state other distances, --forbid-poses NAME leaves out a pose.",
        within.words()
    )
}

/// A tool centre along x, y, z, whole mm.
pub(super) fn tool_words(tool_m: [f64; 3]) -> String {
    // No zero has a sign.
    let [x, y, z] = tool_m.map(|along_m| (1e3 * along_m).round() + 0.0);
    format!("{x}, {y}, {z}")
}

/// The pose of a planned load case by its joints.
pub(super) fn joint_words(next: &PlannedLoadCase) -> String {
    let joints = next.joints_deg.iter().zip(&next.motions);
    let joints: Vec<String> = joints
        .map(|((name, value), motion)| match motion {
            JointMotion::Turns => format!("{name} {value}°"),
            // Values are whole micrometres.
            JointMotion::Slides => format!("{name} {} mm", (1e6 * value).round() / 1e3),
        })
        .collect();
    joints.join(", ")
}

/// Quantities that were derived from the parameters; empty without any.
#[must_use]
fn derived(derived: &[DerivedQuantity]) -> Document {
    let mut document = Document::new();
    if derived.is_empty() {
        return document;
    }
    document.table(
        Table::of(derived)
            .words("derived", |one| &one.name)
            .words("from", |one| &one.expression)
            .numbers("value", |one| significant(one.value, 4))
            .numbers("standard error", |one| digits(one.se, 2))
            .numbers("95 % interval", |one| interval(one.ci95, 4)),
    );
    for one in derived {
        if let Some(known) = &one.words {
            document.item(format!("{}: {known}.", one.name));
        }
    }
    document
}

/// What a runs test of the residuals shows.
fn runs_words(test: &RunsTest) -> String {
    let order = match test.against {
        ResidualOrder::Load => "Residuals by load within runs",
        ResidualOrder::Order => "Slopes of runs in order of time",
    };
    let verdict = if test.p < UNLIKELY {
        "structure remains: stiffbench diagnose searches for its cause"
    } else {
        "as of independent errors"
    };
    format!(
        "{order}: {} stretches of one sign, {:.0} expected (p = {}): {verdict}.",
        test.runs,
        test.expected,
        p_text(test.p)
    )
}

fn cells(fit: &FitReport) -> Document {
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
    let mut document = Document::new();
    if !fit.cells.is_empty() {
        document.table(
            Table::of(&fit.cells)
                .words("pose", |cell| of_session(cell.session.as_ref(), &cell.pose))
                .words("direction", |cell| &cell.direction)
                .numbers("measured, N/µm", |cell| digits(cell.measured.value, 4))
                .numbers("predicted, N/µm", |cell| digits(cell.predicted.value, 4))
                .numbers("predicted/measured, %", |cell| {
                    format!("{:.2}", cell.ratio_percent)
                })
                .when(left_out, |table| {
                    table.numbers("without its pose, %", without_its_pose)
                })
                .when(!left_out, |table| table.words("held out", held_out)),
        );
    }
    if !fit.across.is_empty() {
        document.table(across(fit));
    }
    let of_readings = matches!(
        fit.weights,
        Some(
            WeightBasis::Pooled { .. } | WeightBasis::EachCell | WeightBasis::FromResiduals { .. }
        )
    );
    if of_readings && !fit.cells.is_empty() {
        document.paragraph("The measured stiffness is estimated from all readings with the scatter that they share (generalised least squares); `stiffness` prints the slope of each pose and direction by itself.");
    }
    document
}

/// How far the model is off, in a sentence.
fn largest_error(fit: &FitReport) -> Option<String> {
    let worst = fit.max_error_percent?;
    let mut cells = fit.cells.iter();
    let unseen = cells.any(|cell| cell.held_out || cell.predicted_without_its_pose.is_some());
    let which = if unseen {
        "cells the fit did not see"
    } else {
        "cells of the fit itself"
    };
    Some(format!("Largest error over the {which}: {worst:.2} %."))
}

/// A pose, of one of several sessions with its name.
fn of_session(session: Option<&String>, pose: &PoseId) -> String {
    match session {
        Some(session) => format!("{session}/{pose}"),
        None => pose.to_string(),
    }
}

/// Compliances along other axes than that of the load.
fn across(fit: &FitReport) -> Table {
    Table::of(&fit.across)
        .words("pose", |one| of_session(one.session.as_ref(), &one.pose))
        .words("load", |one| &one.load)
        .words("axis", |one| &one.axis)
        .numbers("measured, µm/N", |one| digits(one.measured.value, 4))
        .numbers("u, µm/N", |one| {
            digits(one.measured.standard_uncertainty, 2)
        })
        .numbers("predicted, µm/N", |one| digits(one.predicted.value, 4))
        .into()
}

/// Base frame and tool point.
fn frames_table(fitted: &FramesReport) -> Document {
    let frames = &fitted.frames;
    let values = [
        frames.base_mm,
        frames.rotation_vector_deg,
        frames.tool_point_mm,
    ];
    let unit = |unit: &str| if unit == "urad" { "deg" } else { "mm" }.to_owned();
    let mut document = Document::of(
        "Base frame in the axes of the tracker (rotation vector), and the measured point from the tool centre in those of the tool:",
    );
    document.table(
        Table::of(fitted.parameters.iter().zip(values.as_flattened()))
            .words("frame", |(one, _)| one.name.to_string())
            .numbers("value", |(_, value)| format!("{value:.4}"))
            .words("unit", |(one, _)| unit(&one.unit))
            .numbers("standard error", |(one, _)| {
                digits(one.standard_error.map(micro), 2)
            })
            .words("unit", |(one, _)| sign_of(&one.unit)),
    );
    document
}

/// Root mean square errors of displacements or positions, pose by pose.
fn pose_errors(report: &FitReport, fit: &FitOutcome) -> Document {
    let um = |value: Option<f64>| digits(value.map(micro), 4);
    let each = report.poses.iter().map(|pose| {
        let fitted_m = (!fit.is_held_out(&pose.pose)).then_some(pose.fitted_m);
        let errors = [Some(pose.rigid_m), fitted_m, pose.without_its_pose_m];
        (pose.pose.to_string(), errors)
    });
    let mut rows: Vec<(String, [Option<f64>; 3])> = each.collect();
    let [_, fitted, unseen] = fit.rms_m();
    let held_out = fit.held_out_poses();
    let trained = report.poses.len() - held_out;
    if held_out > 0 {
        let of_fit = [fit.rigid_of(false), fitted, None];
        rows.push((format!("the {trained} of the fit"), of_fit));
        let left_out = [fit.rigid_of(true), None, unseen];
        rows.push((format!("the {held_out} left out"), left_out));
    } else {
        rows.push(("all".to_owned(), [fit.rigid_rms_m(), fitted, unseen]));
    }
    let (what, own) = if fit.frames.is_some() {
        ("positions", ", with its own base frame and tool point")
    } else {
        ("displacements", "")
    };
    let moved = fit.estimates.iter();
    let moved = moved.filter(|one| one.status != FactorStatus::Fixed);
    let (factors, springs): (Vec<_>, Vec<_>) = moved.partition(|one| one.parameter.is_factor());
    let without = match (springs.is_empty(), factors.is_empty()) {
        (false, true) => "fitted springs without compliance",
        (true, _) => "fitted factors 1",
        (false, false) => "fitted springs without compliance, fitted factors 1",
    };
    let mut document = Document::of(format!("Root mean square error of the {what}:"));
    document.table(
        Table::of(rows)
            .words("pose", |(name, _)| name.clone())
            .numbers("rigid, µm", |(_, errors)| um(errors[0]))
            .numbers("fitted, µm", |(_, errors)| um(errors[1]))
            .numbers("without its pose, µm", |(_, errors)| um(errors[2])),
    );
    document.paragraph(format!(
        "Rigid: the robot without the fitted parameters{own} ({without})."
    ));
    if let (Some(rigid), Some(unseen)) = (fit.rigid_unseen_m(), unseen) {
        document.paragraph(format!(
            "In {}: {} µm of the rigid robot -> {} µm of the fit.",
            if held_out > 0 {
                format!("the {} left out", counted(held_out, "pose"))
            } else {
                "poses left out".to_owned()
            },
            um(Some(rigid)),
            um(Some(unseen))
        ));
    }
    document
}

fn method_words(fit: &FitReport) -> String {
    match fit.method {
        FitMethod::Paper => "the paper's procedure".to_owned(),
        FitMethod::LeastSquares if fit.components.is_empty() => {
            "least squares on ln K of all training cells".to_owned()
        }
        FitMethod::LeastSquares => {
            let cases = fit.components.iter().map(|one| (one.line, one.repeat));
            let mut cases: Vec<(u32, u32)> = cases.collect();
            cases.dedup();
            format!(
                "least squares on {} of {} in {}",
                counted(fit.components.len(), "component"),
                counted(cases.len(), "load case"),
                counted(fit.poses.len(), "pose")
            )
        }
    }
}
