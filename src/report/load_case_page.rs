//! A fit to load cases for people.

use std::fmt::Write;

use crate::elastostatics::{
    FittedFrames, LoadCaseAgreement, LoadCaseFit, PlannedLoadCase, ScatterSource,
};
use crate::fit::{FactorEstimate, FactorStatus};

use super::correlation::correlation_text;
use super::fit::{rank_text, status_words};
use super::fit_report::{ParameterReport, stiffness_unit};
use super::load_case_fit::LoadCaseFitReport;
use super::text::{AlignedTable, interval, micro, significant};
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
    let springs = table_if_any(
        [
            "spring",
            "compliance, 1e-6",
            "standard error",
            "95 % interval",
            "stiffness",
            "95 % interval",
            "unit",
            "status",
        ],
        springs.into_iter().map(spring),
    );
    let factors = table_if_any(
        [
            "factor",
            "start",
            "value",
            "standard error",
            "95 % interval",
            "status",
        ],
        moved.map(factor),
    );
    springs + &factors
}

/// A table with an empty line after it; nothing without rows.
fn table_if_any<const N: usize>(
    heads: [&str; N],
    rows: impl Iterator<Item = [String; N]>,
) -> String {
    let mut rows = rows.peekable();
    if rows.peek().is_none() {
        return String::new();
    }
    let mut table = AlignedTable::new(&heads);
    rows.for_each(|row| table.row(row));
    table.text() + "\n"
}

fn factor(estimate: &FactorEstimate) -> [String; 6] {
    [
        estimate.name.clone(),
        significant(estimate.start, 4),
        significant(estimate.value, 4),
        optional(estimate.standard_uncertainty, 2),
        interval(estimate.interval_95, 4),
        status_words(estimate.status.word(), estimate.moved()),
    ]
}

fn spring(estimate: &FactorEstimate) -> [String; 8] {
    let inverse = |compliance: f64| {
        if compliance > 0.0 {
            significant(1.0 / compliance, 4)
        } else {
            "infinite".to_owned()
        }
    };
    let unit = estimate.parameter.unit();
    let stiffness = estimate.interval_95.map_or_else(
        || "-".to_owned(),
        |[low, high]| format!("{} to {}", inverse(high), inverse(low)),
    );
    [
        estimate.name.clone(),
        optional(estimate.known_value().map(micro), 4),
        optional(estimate.standard_uncertainty.map(micro), 2),
        interval(estimate.interval_95.map(|ends| ends.map(micro)), 4),
        (estimate.known_value()).map_or_else(|| "-".to_owned(), inverse),
        stiffness,
        stiffness_unit(unit),
        status_words(estimate.status.word(), estimate.moved()),
    ]
}

fn optional(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| significant(value, digits))
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
            optional(agreement.reduced_chi2, 3),
            if p < 0.01 {
                format!("{p:.1e}")
            } else {
                format!("{p:.2}")
            }
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
    let mut rows = AlignedTable::new(&["frame", "value", "unit", "standard error", "unit"]);
    for (one, value) in fitted.parameters.iter().zip(values.as_flattened()) {
        let unit = match one.unit {
            "urad" => "deg",
            _ => "mm",
        };
        rows.row([
            one.name.to_owned(),
            format!("{value:.4}"),
            unit.to_owned(),
            optional(one.standard_error.map(micro), 2),
            one.unit.to_owned(),
        ]);
    }
    format!(
        "Base frame in the axes of the tracker (rotation vector), and the measured point from the tool centre in those of the tool:\n\n{}\n",
        rows.text()
    )
}

fn errors(fit: &LoadCaseFit) -> String {
    let um = |value: Option<f64>| optional(value.map(micro), 4);
    let mut rows = AlignedTable::new(&["pose", "rigid, um", "fitted, um", "without its pose, um"]);
    for pose in &fit.poses {
        rows.row([
            pose.pose.to_string(),
            um(Some(pose.rigid_m)),
            um((!fit.is_held_out(&pose.pose)).then_some(pose.fitted_m)),
            um(pose.without_its_pose_m),
        ]);
    }
    let [_, fitted, unseen] = fit.rms_m();
    let held_out = fit.held_out_poses();
    let trained = fit.poses.len() - held_out;
    if held_out > 0 {
        rows.row([
            format!("the {trained} of the fit"),
            um(fit.rigid_of(false)),
            um(fitted),
            "-".to_owned(),
        ]);
        rows.row([
            format!("the {held_out} left out"),
            um(fit.rigid_of(true)),
            "-".to_owned(),
            um(unseen),
        ]);
    } else {
        rows.row([
            "all".to_owned(),
            um(fit.rigid_rms_m()),
            um(fitted),
            um(unseen),
        ]);
    }
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
        "\nRoot mean square error of the {what}:\n\n{}Rigid: the robot without what is fitted{own} ({without}).\n{gain}",
        rows.text()
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
