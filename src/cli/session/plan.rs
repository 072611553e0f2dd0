//! `session plan`: what a session will ask for, without touching a port.

use stiffbench_document::Document;

use crate::analysis::{Inputs, ResolvedModel, UnknownSprings, add_poses, choose_poses, design};
use crate::cli::failure::refuse_given;
use crate::cli::figure_files::write;
use crate::cli::procedure::resolve_procedure;
use crate::cli::{Failure, Global, Outcome};
use crate::clock::Clock;
use crate::count::{counted, hours_and_minutes};
use crate::fit::BestPoses;
use crate::procedure::{Pace, PlannedReading, Procedure};
use crate::readings::Instruments;
use crate::report::{PlanReport, best_poses_document, design_document};
use crate::session::{QUESTIONS, Question, SessionCell, SessionPlan, SessionState};
use crate::test_point::PoseId;

use super::args::{PlanArgs, RunArgs};
use super::drive::checked;
use super::emulation::emulate;
use super::gauges::{check_descriptions, resolve_gauges};

/// Files that a session makes.
const FILES: [(&str, &str); 7] = [
    ("session.toml", "robot, procedure and gauges, written once"),
    ("robot.toml", "the robot file"),
    ("journal.jsonl", "every event, on the disk before it counts"),
    ("readings.csv", "the readings, live"),
    ("session.log", "what the program did, as JSON lines"),
    ("session.lock", "which process has the session"),
    ("raw/*.trace", "every byte of the gauges"),
];

pub(super) fn run(args: &PlanArgs) -> Result<Outcome, Failure> {
    let mut resolved = args.model.resolve()?;
    let (procedure, mut warnings) = resolve_procedure(&args.procedure)?;
    warnings.extend(add_poses(&mut resolved.robot, &procedure)?);
    let mut procedure = args.axes.applied(procedure)?;
    for pose in procedure.poses.iter().flatten() {
        resolved.robot.pose(pose)?;
    }
    let needs_design = args.best.best_poses.is_none() && !args.design;
    refuse_given(
        &[("--parameter", needs_design && !args.parameters.is_default())],
        "the steps of a procedure do not depend on it",
        |_| "add --best-poses N or --design, or leave it out".to_owned(),
    )?;
    let best = best_poses(args, &resolved, &mut procedure)?;
    if let Some(file) = &args.best.save_procedure {
        write(file, procedure.to_toml().as_bytes())?;
    }
    if args.design {
        return designed(args, &resolved, procedure, warnings);
    }
    let poses: Vec<PoseId> = resolved
        .robot
        .poses
        .iter()
        .map(|named| named.id.clone())
        .collect();
    let plan = SessionPlan::new(&procedure, &poses)
        .with_axis_words([0, 1, 2].map(|axis| resolved.robot.axis_word(axis)));
    let outcome = planned(&plan, &procedure, best.as_ref());
    let unknown = UnknownSprings::of(&resolved).words();
    warnings.extend(best.and(unknown).map(|words| {
        format!(
            "{words}; the standard errors count them as rigid: what scatters from run to run, in proportion to what a spring gives, comes on top"
        )
    }));
    warnings.extend(resolved.warnings.iter().cloned());
    Ok(outcome
        .with_inputs(Inputs::default().with_model(&resolved))
        .with_warnings(warnings)
        .with_written(&args.best.save_procedure))
}

/// What the procedure can and cannot distinguish.
fn designed(
    args: &PlanArgs,
    model: &ResolvedModel,
    procedure: Procedure,
    mut warnings: Vec<String>,
) -> Result<Outcome, Failure> {
    let choice = args.parameters.choice(model)?;
    let report = design(model, procedure, &choice, 0)?;
    warnings.extend(model.robot.warnings.iter().cloned());
    Ok(Outcome::new("design", design_document(&report), report)
        .with_inputs(Inputs::default().with_model(model))
        .with_warnings(warnings)
        .with_written(&args.best.save_procedure))
}

/// What `session run` with these arguments would ask for and write; it refuses what that would refuse.
pub(super) fn dry_run(args: &RunArgs, global: &Global) -> Result<Outcome, Failure> {
    let session = checked(args, global)?;
    let (plan, mut warnings) = (&session.plan, session.warnings);
    let mut bench = args.bench.clone();
    let (clock, records) = (Clock::default(), Instruments::default());
    let hand = emulate(
        &mut bench,
        &session.robot,
        &session.procedure,
        &records,
        clock,
    )?;
    let channels = plan.channels();
    warnings.extend(if hand.is_some() {
        let state = SessionState::default();
        resolve_gauges(&bench, &channels, &records, &state)?.1
    } else {
        check_descriptions(&bench, &channels)?
    });
    Ok(planned(plan, &session.procedure, None)
        .with_inputs(Inputs::default().with_model(&session.robot))
        .with_warnings(warnings))
}

/// The plan in words and for programs.
fn planned(plan: &SessionPlan, procedure: &Procedure, best: Option<&BestPoses>) -> Outcome {
    let seconds = plan.seconds_left(&SessionState::default(), &Pace::default());
    let mut document = Document::of(format!(
        "Procedure {}: {} in {}, about {}",
        procedure.name,
        counted(plan.len(), "reading"),
        counted(plan.cells.len(), "cell"),
        hours_and_minutes(seconds / 60.0)
    ));
    let axes = &procedure.displacement_axes;
    if axes.is_empty() {
        document.paragraph("ready, temperature and sign-check are asked once");
    } else {
        let axes: Vec<String> = axes.iter().map(ToString::to_string).collect();
        document.paragraph(format!("displacement gauges along {}", axes.join(", ")));
        document.paragraph(
            "ready and temperature are asked once, sign-check once for each push that shows signs",
        );
    }
    document.append(best.map(best_poses_document).unwrap_or_default());
    for (place, cell) in plan.cells.iter().enumerate() {
        describe(&mut document, place, cell, plan);
    }
    document
        .paragraph("Questions, each answered by --answer ID=VALUE or a line of an answers file:");
    for Question { id, answer, .. } in QUESTIONS {
        document.pair(id, answer);
    }
    document.paragraph("Files:");
    for (name, what) in FILES {
        document.pair(name, what);
    }
    let files = FILES.iter().map(|(name, _)| *name).collect();
    let report = PlanReport::new(plan, seconds, files).with_best_poses(best);
    Outcome::new("session-plan", document, report)
}

/// The poses that determine the parameters best, if they are to be chosen; the procedure then measures them.
fn best_poses(
    args: &PlanArgs,
    resolved: &ResolvedModel,
    procedure: &mut Procedure,
) -> Result<Option<BestPoses>, Failure> {
    let Some(count) = args.best.best_poses else {
        return Ok(None);
    };
    let choice = args.parameters.choice(resolved)?;
    let wanted = (&args.best.rules.rules(), count);
    Ok(Some(choose_poses(resolved, procedure, &choice, wanted)?))
}

/// The steps of a cell: a line for each gauge zero and each run or load.
fn describe(document: &mut Document, place: usize, cell: &SessionCell, plan: &SessionPlan) {
    document.paragraph(format!(
        "Cell {} of {}: setup.{}.{} asks for pose {}{} and direction {}",
        place + 1,
        plan.cells.len(),
        cell.pose,
        cell.direction,
        cell.pose,
        plan.joints_text(&cell.pose),
        plan.direction_text(&cell.direction)
    ));
    let zero_check = ("zero check", "under the preload, then gauge free");
    let at_load = plan.procedure.release_n().is_some();
    let goes_on = |before: &PlannedReading, next: &PlannedReading| {
        let is_same = if at_load {
            before.step == next.step
        } else {
            before.repeat == next.repeat
        };
        is_same && !next.zero_before
    };
    for (index, readings) in cell.readings.chunk_by(goes_on).enumerate() {
        let first = &readings[0];
        if first.zero_before {
            if index > 0 {
                document.pair(zero_check.0, zero_check.1);
            }
            let preload_n = plan.procedure.preload_n;
            document.pair("zero", format!("gauge free, then {preload_n} N"));
        }
        let steps = readings.iter().map(|reading| match reading.extra_hold_s {
            Some(hold_s) => format!("hold to {hold_s} s"),
            None if at_load => reading.repeat.to_string(),
            None => reading.target_n.to_string(),
        });
        let steps = steps.collect::<Vec<_>>().join(" ");
        if at_load {
            let released = format!("released in between: {steps}");
            document.pair(format!("{} N", first.target_n), released);
        } else {
            document.pair(format!("run {}", first.repeat), steps);
        }
    }
    document.pair(zero_check.0, zero_check.1);
}
