//! What to measure: before a session by `stiffbench diagnose --design`, after one by the pairs that it left open.

use std::fmt::Write;
use std::path::Path;

use serde_json::{Value, json};

use crate::mismatch::{
    DesignBench, DesignReport, Diagnosis, GaugeSteps, NextMeasurement, Observations,
    ProposedMeasurement, RobotBaseline, USUAL_NOISE, Verdict, design_of_plan, next_measurements,
    poses_at_hand,
};
use crate::parameters::ParameterChoice;
use crate::physics::title;
use crate::procedure::{Pace, Procedure};
use crate::readings::SessionHeader;
use crate::robot::{Mechanism, Pose, Robot};
use crate::test_point::PoseId;

use super::diagnose_args::DiagnoseArgs;
use super::failure::{CliError, Failure};
use super::inputs::Inputs;
use super::outcome::Outcome;
use super::parameter_args::ParameterArgs;
use super::procedure::named_procedure;
use super::resolve::{ResolvedModel, resolve};

/// Steps of the gauges of a bench of which nothing is known yet: a dial gauge of 10 µm, a force gauge of a tenth of a newton.
const USUAL_STEPS: GaugeSteps = GaugeSteps {
    force_n: Some(0.1),
    displacement_m: Some(1e-5),
};

/// Rows of the printed tables.
const ROWS: usize = 40;

/// Says what a procedure can and cannot tell apart.
pub(super) fn run(args: &DiagnoseArgs, name: &str) -> Result<Outcome, Failure> {
    let (procedure, mut warnings) = named_procedure(name)?;
    let chosen = resolve(&args.model, None)?;
    let mechanism = chosen.robot.mechanism(Some(&chosen.mechanism))?;
    let measured = procedure.poses.clone().unwrap_or_default();
    let poses = poses_at_hand(&chosen.robot, mechanism, &chosen.factors, &measured);
    let baseline = baseline(&chosen, mechanism, &poses, &args.parameters)?;
    let procedure = Procedure {
        poses: Some(procedure.poses.unwrap_or_else(|| poses.clone())),
        ..procedure
    };
    let bench = DesignBench {
        baseline: &baseline,
        poses: &poses,
        parameters: None,
        noise: USUAL_NOISE,
        steps: USUAL_STEPS,
        pace: Pace::default(),
    };
    let report = design_of_plan(&bench, &procedure, None, args.seed)?;
    warnings.extend(chosen.robot.warnings.iter().cloned());
    Ok(Outcome::new("design", text(&report), json(&report))
        .with_inputs(Inputs::default().with_model(&chosen))
        .with_warnings(warnings))
}

/// What a shipped procedure can show on a mechanism in its named poses, on a bench of which nothing is known yet.
///
/// # Errors
/// For a mechanism or procedure that is not there, or a plan that shows nothing.
pub fn usual_plan(
    robot: &Robot,
    mechanism: &str,
    procedure: &str,
    seed: u64,
) -> Result<DesignReport, Failure> {
    let (procedure, _) = named_procedure(procedure)?;
    let poses: Vec<PoseId> = robot.poses.iter().map(|named| named.id.clone()).collect();
    let placed: Vec<Pose> = robot.poses.iter().map(|named| named.pose.clone()).collect();
    let (_, factors) = robot.default_factors();
    let mechanism = robot.mechanism(Some(mechanism))?;
    let baseline = RobotBaseline::new(
        robot,
        mechanism,
        factors,
        placed,
        &ParameterChoice::default(),
    )?;
    let bench = DesignBench {
        baseline: &baseline,
        poses: &poses,
        parameters: None,
        noise: USUAL_NOISE,
        steps: USUAL_STEPS,
        pace: Pace::default(),
    };
    let procedure = Procedure {
        poses: Some(poses.clone()),
        ..procedure
    };
    Ok(design_of_plan(&bench, &procedure, None, seed)?)
}

/// Measurements proposed, and the procedures to be written beside them: file name and text.
type Proposals = (Vec<NextMeasurement>, Vec<(String, String)>);

/// Plans that separate what a diagnosis left open, with the procedures to be written beside it.
pub(super) fn proposals(
    chosen: &ResolvedModel,
    header: Option<&SessionHeader>,
    done: &Observations,
    diagnosis: &Diagnosis,
    parameters: &ParameterArgs,
) -> Result<Proposals, Failure> {
    let open = diagnosis
        .findings
        .iter()
        .any(|f| f.alternative_group.is_some());
    if !open && diagnosis.verdict != Verdict::Unknown {
        return Ok((Vec::new(), Vec::new()));
    }
    let mechanism = chosen.robot.mechanism(Some(&chosen.mechanism))?;
    let poses = poses_at_hand(&chosen.robot, mechanism, &chosen.factors, &done.poses);
    let baseline = baseline(chosen, mechanism, &poses, parameters)?;
    let bench = DesignBench {
        baseline: &baseline,
        poses: &poses,
        parameters: Some(&diagnosis.parameters),
        noise: diagnosis.noise,
        steps: done.steps,
        pace: Pace::default(),
    };
    let record = header.and_then(|header| header.procedure.as_ref());
    let base = record
        .and_then(|record| Procedure::from_record(record).ok())
        .unwrap_or_default();
    let all = next_measurements(&bench, done, diagnosis, &base)?;
    let mut files = Vec::new();
    let next = all
        .iter()
        .map(|proposal| told(proposal, &mut files))
        .collect();
    Ok((next, files))
}

/// A proposal as it is told, its procedure among the files; the same procedure is written once.
fn told(proposal: &ProposedMeasurement, files: &mut Vec<(String, String)>) -> NextMeasurement {
    let file = proposal.procedure.as_ref().map(|procedure| {
        let text = procedure.to_toml();
        if let Some((name, _)) = files.iter().find(|(_, written)| *written == text) {
            return name.clone();
        }
        let name = format!("next-{}.toml", files.len() + 1);
        files.push((name.clone(), text));
        name
    });
    NextMeasurement {
        plan: proposal.plan.clone(),
        separates: proposal.separates.clone(),
        expected_log_lr: proposal.expected_log_lr,
        minutes: proposal.minutes,
        file,
    }
}

/// The beam model of what was chosen, in these poses.
pub(super) fn baseline<'a>(
    chosen: &'a ResolvedModel,
    mechanism: &Mechanism,
    poses: &[PoseId],
    parameters: &ParameterArgs,
) -> Result<RobotBaseline<'a>, Failure> {
    let placed = poses
        .iter()
        .map(|pose| chosen.robot.pose(pose).cloned())
        .collect::<Result<Vec<Pose>, _>>()?;
    let choice = parameters.choice(chosen)?;
    let factors = chosen.factors.clone();
    Ok(RobotBaseline::new(
        &chosen.robot,
        mechanism,
        factors,
        placed,
        &choice,
    )?)
}

fn text(report: &DesignReport) -> String {
    let mut text = format!(
        "Procedure {}: {} readings, about {:.0} minutes. What it would show, with a dial gauge of 10 um read to 6 um:\n\n",
        report.procedure, report.readings, report.minutes
    );
    let mut table = crate::report::TextTable::new(&[
        "law and place",
        "found in 80 % from, um at the end",
        "hardest to tell apart from",
        "told apart from, um at the end",
    ]);
    for law in report.laws.iter().take(ROWS) {
        let nearest = law.nearest.first();
        let name = nearest.map_or_else(|| "-".to_owned(), |n| title(n.rival.law, &n.rival.place));
        let from = match nearest {
            None => "-".to_owned(),
            Some(rival) if rival.never => "never".to_owned(),
            Some(rival) => rival
                .end_effect_5_m
                .map_or_else(|| "-".to_owned(), |m| format!("{:.1}", m * 1e6)),
        };
        table.row([
            title(law.suspect.law, &law.suspect.place),
            format!("{:.1}", law.end_effect_80_m * 1e6),
            name,
            from,
        ]);
    }
    text.push_str(&table.text());
    if report.laws.len() > ROWS {
        let _ = writeln!(
            text,
            "… and {} more: --json has all.",
            report.laws.len() - ROWS
        );
    }
    if !report.inseparable.is_empty() {
        text.push_str("\nCannot be told apart at any plausible size:\n");
        for group in &report.inseparable {
            let names: Vec<String> = group.iter().map(ToString::to_string).collect();
            let _ = writeln!(text, "- {}", names.join(" = "));
        }
    }
    if !report.unseen.is_empty() {
        let names: Vec<String> = report
            .unseen
            .iter()
            .map(|u| u.suspect.to_string())
            .collect();
        let _ = writeln!(
            text,
            "\nNot shown at any plausible size: {}.",
            names.join(", ")
        );
    }
    text
}

fn json(report: &DesignReport) -> Value {
    let suspect = |suspect: &crate::mismatch::Suspect| json!({ "physics": suspect.law.name, "place": suspect.place.to_json() });
    json!({
        "procedure": report.procedure,
        "readings": report.readings,
        "minutes": report.minutes,
        "laws": report.laws.iter().map(|law| json!({
            "physics": law.suspect.law.name,
            "place": law.suspect.place.to_json(),
            "size_80": law.size_80,
            "unit": law.suspect.law.parameters.first().map(crate::physics::ParameterSpec::unit),
            "end_effect_80_um": law.end_effect_80_m * 1e6,
            "nearest": law.nearest.iter().map(|near| json!({
                "physics": near.rival.law.name,
                "place": near.rival.place.to_json(),
                "cosine": near.cosine,
                "size_3": near.size_3,
                "size_5": near.size_5,
                "never": near.never,
            })).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "inseparable": report.inseparable.iter().map(|group| group.iter().map(suspect).collect::<Vec<_>>()).collect::<Vec<_>>(),
        "unseen": report.unseen.iter().map(|unseen| {
            let mut value = suspect(&unseen.suspect);
            value["size_needed"] = json!(unseen.size_needed);
            value
        }).collect::<Vec<_>>(),
    })
}

/// The data of a diagnosis; clap asks for it unless a procedure is judged.
pub(super) fn data(args: &DiagnoseArgs) -> Result<&Path, CliError> {
    args.data.as_deref().ok_or_else(|| CliError::Argument {
        argument: "DATA".to_owned(),
        problem: "there is nothing to diagnose".to_owned(),
        help: Some("name a session folder or a readings file".to_owned()),
    })
}
