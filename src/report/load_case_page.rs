//! A fit to load cases for people.

use std::fmt::Write;

use crate::elastostatics::{
    FittedFrames, LoadCaseAgreement, LoadCaseFit, PlannedLoadCase, ScatterSource,
};
use crate::fit::{FactorEstimate, FactorStatus};

use super::correlation::correlation_text;
use super::fit::{held_fixed, rank_text, status_words};
use super::fit_report::{ParameterReport, stiffness_unit};
use super::load_case_fit::LoadCaseFitReport;
use super::text::{TextColumn, digits, interval, micro, or_dash, p_text, significant, table_of};
use crate::count::{counted, degrees_of_freedom};

/// A standard error that a planned load case leaves above this share of itself is not printed.
const WORTH_PRINTING: f64 = 0.99;

/// Parameters, errors by pose, and what to think of them.
#[must_use]
pub fn load_case_fit_text(fit: &LoadCaseFit) -> String {
    let cases: Vec<(u32, u32)> = fit
        .components
        .iter()
        .map(|one| (one.line, one.repeat))
        .collect();
    let mut distinct = cases.clone();
    distinct.dedup();
    let mut text = format!(
        "Mechanism {}, least squares on {} of {} in {}, {}.\n\n",
        fit.mechanism,
        counted(fit.components.len(), "component"),
        counted(distinct.len(), "load case"),
        counted(fit.poses.len(), "pose"),
        fit.termination
    );
    text.push_str(&held_fixed(&fit.physics));
    text.push_str(&parameters(fit));
    text.push_str(&open(fit));
    if let Some(frames) = &fit.frames {
        text.push_str(&frames_table(frames));
    }
    if let Some(agreement) = &fit.agreement {
        text.push_str(&scatter(agreement));
        text.push_str(&determined(fit, agreement));
    }
    text.push_str(&correlation_text(fit.correlation.as_ref()));
    text.push_str(&errors(fit));
    for warning in &fit.warnings {
        let _ = writeln!(text, "\nnote: {warning}");
    }
    text
}

fn parameters(fit: &LoadCaseFit) -> String {
    let estimates = fit.estimates.iter();
    let (factors, springs): (Vec<_>, Vec<_>) = estimates.partition(|one| one.parameter.is_factor());
    let moved = factors
        .into_iter()
        .filter(|one| one.status != FactorStatus::Fixed);
    let inverse = |compliance: f64| {
        if compliance > 0.0 {
            significant(1.0 / compliance, 4)
        } else {
            "infinite".to_owned()
        }
    };
    let status = |one: &&FactorEstimate| status_words(one.status.word(), one.moved());
    let springs = table_if_any(
        springs,
        &[
            ("spring", &|one| one.name.clone()),
            ("compliance, 1e-6", &|one| {
                digits(one.known_value().map(micro), 4)
            }),
            ("standard error", &|one| {
                digits(one.standard_uncertainty.map(micro), 2)
            }),
            ("95 % interval", &|one| {
                interval(one.interval_95.map(|ends| ends.map(micro)), 4)
            }),
            ("stiffness", &|one| or_dash(one.known_value(), inverse)),
            ("95 % interval", &|one| {
                or_dash(one.interval_95, |[low, high]| {
                    format!("{} to {}", inverse(high), inverse(low))
                })
            }),
            ("unit", &|one| stiffness_unit(one.parameter.unit())),
            ("status", &status),
        ],
    );
    let factors = table_if_any(
        moved.collect(),
        &[
            ("factor", &|one| one.name.clone()),
            ("start", &|one| significant(one.start, 4)),
            ("value", &|one| significant(one.value, 4)),
            ("standard error", &|one| digits(one.standard_uncertainty, 2)),
            ("95 % interval", &|one| interval(one.interval_95, 4)),
            ("status", &status),
        ],
    );
    springs + &factors
}

/// A table with an empty line after it; nothing without rows.
fn table_if_any<T>(rows: Vec<T>, columns: &[TextColumn<'_, T>]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    table_of(rows, columns) + "\n"
}

/// Sentences about parameters that the poses do not determine.
fn open(fit: &LoadCaseFit) -> String {
    let mut text = String::new();
    for estimate in &fit.estimates {
        if let Some(words) = estimate.status.why_open() {
            let _ = writeln!(text, "{}: {words}.", estimate.name);
        }
    }
    for combination in &fit.not_determined {
        let _ = writeln!(text, "Not determined by these poses: {combination}.");
    }
    text
}

fn scatter(agreement: &LoadCaseAgreement) -> String {
    let words = |value: f64| significant(micro(value), 3);
    let displacement = agreement
        .displacement_sd_m
        .map(|sd| format!("{} um of a displacement", words(sd)));
    let rotation = agreement
        .rotation_sd_rad
        .map(|sd| format!("{} urad of a rotation", words(sd)));
    let load = (agreement.load_sd > 0.0).then(|| {
        format!(
            "{} % of what a load moves",
            significant(100.0 * agreement.load_sd, 2)
        )
    });
    let parts: Vec<String> = [displacement, rotation, load]
        .into_iter()
        .flatten()
        .collect();
    let source = match agreement.source {
        ScatterSource::Repeats => "from the repeats",
        ScatterSource::Residuals => "from what the fit leaves over the poses",
    };
    let lack = agreement.p.map_or_else(String::new, |p| {
        format!(
            "; lack of fit: reduced chi-squared {}, p = {}",
            digits(agreement.reduced_chi2, 3),
            p_text(p)
        )
    });
    format!(
        "Scatter {source}: {}, {}{lack}.\n",
        parts.join(", "),
        degrees_of_freedom(agreement.scatter_dof)
    )
}

/// How many of the parameters have a value: of those that the Jacobian determines some may fit with any value within their bounds.
fn determined(fit: &LoadCaseFit, agreement: &LoadCaseAgreement) -> String {
    let condition = Some(agreement.condition).filter(|condition| condition.is_finite());
    let is_open = |one: &&FactorEstimate| {
        matches!(one.status, FactorStatus::NotIdentified { .. }) && one.bounds.is_some()
    };
    let open = fit.estimates.iter().filter(is_open);
    let open: Vec<&str> = open.map(|one| one.name.as_str()).collect();
    let (rank, free) = (agreement.rank, agreement.free);
    if open.is_empty() || rank < free {
        return rank_text("poses", [rank, free], condition);
    }
    format!(
        "The poses determine {} of {free} parameters: all but {} (the Jacobian has rank {rank}, but the interval does not end within the bounds); condition number {}.\n",
        free.saturating_sub(open.len()),
        open.join(", "),
        condition.map_or_else(|| "infinite".to_owned(), |value| significant(value, 3))
    )
}

/// Base frame and tool point.
fn frames_table(fitted: &FittedFrames) -> String {
    let frames = &fitted.frames;
    let turn = frames.rotation_vector_rad().map(f64::to_degrees);
    let millimetres = |metres: [f64; 3]| metres.map(|metres| 1e3 * metres);
    let values = [
        millimetres(frames.base_m),
        turn,
        millimetres(frames.tool_point_m),
    ];
    let unit = |unit: &str| if unit == "urad" { "deg" } else { "mm" }.to_owned();
    let table = table_of(
        fitted.parameters.iter().zip(values.as_flattened()),
        &[
            ("frame", &|(one, _)| one.name.to_owned()),
            ("value", &|(_, value)| format!("{value:.4}")),
            ("unit", &|(one, _)| unit(one.unit)),
            ("standard error", &|(one, _)| {
                digits(one.standard_error.map(micro), 2)
            }),
            ("unit", &|(one, _)| one.unit.to_owned()),
        ],
    );
    format!(
        "Base frame in the axes of the tracker (rotation vector), and the measured point from the tool centre in those of the tool:\n\n{table}\n"
    )
}

fn errors(fit: &LoadCaseFit) -> String {
    let um = |value: Option<f64>| digits(value.map(micro), 4);
    let each = fit.poses.iter().map(|pose| {
        let fitted_m = (!fit.is_held_out(&pose.pose)).then_some(pose.fitted_m);
        let errors = [Some(pose.rigid_m), fitted_m, pose.without_its_pose_m];
        (pose.pose.to_string(), errors)
    });
    let mut rows: Vec<(String, [Option<f64>; 3])> = each.collect();
    let [_, fitted, unseen] = fit.rms_m();
    let held_out = fit.held_out_poses();
    let trained = fit.poses.len() - held_out;
    if held_out > 0 {
        let of_fit = [fit.rigid_of(false), fitted, None];
        rows.push((format!("the {trained} of the fit"), of_fit));
        let left_out = [fit.rigid_of(true), None, unseen];
        rows.push((format!("the {held_out} left out"), left_out));
    } else {
        rows.push(("all".to_owned(), [fit.rigid_rms_m(), fitted, unseen]));
    }
    let table = table_of(
        rows,
        &[
            ("pose", &|(name, _)| name.clone()),
            ("rigid, um", &|(_, errors)| um(errors[0])),
            ("fitted, um", &|(_, errors)| um(errors[1])),
            ("without its pose, um", &|(_, errors)| um(errors[2])),
        ],
    );
    let (what, own) = if fit.frames.is_some() {
        ("positions", ", with base frame and tool point of its own")
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
    let gain = match (fit.rigid_unseen_m(), unseen) {
        (Some(rigid), Some(unseen)) => format!(
            "In {}: {} um of the rigid robot -> {} um of the fit.\n",
            if held_out > 0 {
                format!("the {} left out", counted(held_out, "pose"))
            } else {
                "poses left out".to_owned()
            },
            um(Some(rigid)),
            um(Some(unseen))
        ),
        _ => String::new(),
    };
    format!(
        "\nRoot mean square error of the {what}:\n\n{table}Rigid: the robot without what is fitted{own} ({without}).\n{gain}"
    )
}

/// Further load cases that would determine what is open, as a table; empty without any.
#[must_use]
pub fn next_load_cases_text(report: &LoadCaseFitReport) -> String {
    // Of positions the reason of each spring names what would determine it.
    if report.frames.is_some() {
        return String::new();
    }
    if report.next.is_empty() {
        let unloaded = report
            .parameters
            .iter()
            .filter(|one| one.status == "not_identified");
        let unloaded: Vec<&str> = unloaded.map(|one| one.name.as_str()).collect();
        if unloaded.is_empty() {
            return String::new();
        }
        return format!(
            "\nNo force at the tool centre would determine {}: apply a moment, or load a point off the axis and state it as `at_mm` of [tool].\n",
            unloaded.join(", ")
        );
    }
    planned_text(&report.next, &report.parameters)
}

/// Planned load cases with what they do for the parameters.
pub(super) fn planned_text(planned: &[PlannedLoadCase], parameters: &[ParameterReport]) -> String {
    let mut text =
        "\nLoad cases that would determine best what is open, one after the other (standard errors now and then):\n"
            .to_owned();
    for (place, next) in planned.iter().enumerate() {
        let errors = next
            .errors
            .iter()
            .filter(|one| one.then < WORTH_PRINTING * one.now);
        let errors = errors.map(|one| {
            let own = parameters.iter().find(|own| own.name == one.name);
            // Of a factor the error of its logarithm is planned; the table has that of its value.
            let (scale, unit) = match own {
                Some(own) if own.unit == "1" => (own.value.unwrap_or(1.0), String::new()),
                Some(own) => (1.0, format!(" {}", own.unit)),
                None => (1.0, String::new()),
            };
            let [now, then] = [one.now, one.then].map(|error| significant(scale * error, 2));
            format!("{} {now} to {then}{unit}", one.name)
        });
        let _ = writeln!(
            text,
            "\n{}. {} N along {} in pose {}: {}\n   {}",
            place + 1,
            significant(next.force_n, 3),
            next.direction,
            next.name,
            joint_words(next),
            errors.collect::<Vec<_>>().join(", ")
        );
    }
    text
}

/// The pose of a planned load case by its joints.
pub(super) fn joint_words(next: &PlannedLoadCase) -> String {
    let joints = next.joints_deg.iter();
    let joints: Vec<String> = joints
        .map(|(name, value)| format!("{name} {value}"))
        .collect();
    joints.join(", ")
}
