//! `stiffbench simulate --load-cases` and `--positions`.

use std::fmt::Write as _;

use crate::bench::{
    LoadCasePlan, NoiseModel, PositionPlan, SimulatedPositions, simulate_load_cases,
    simulate_positions,
};
use crate::load_cases::{LoadCaseTable, write_load_cases};
use crate::report::{SimulationReport, TrackerReport};
use crate::robot::FittingFactors;

use super::args::SimulateArgs;
use super::failure::{Failure, refuse_given};
use super::model::physics_text;
use super::outcome::Outcome;
use super::procedure::{SingleLoads, single_loads};
use super::simulate::{
    create_new, effects_line, noise, origin, outcome, report, rigid_springs, truth_text,
    usual_header, write_session,
};
use crate::analysis::{ResolvedModel, refuse_unseen_laws};

/// Size of the largest force of load cases unless --loads-n says, N: that of the procedures.
const LARGEST_FORCE_N: f64 = 70.0;

/// What is made in place of series of loads.
#[derive(Debug, Clone, Copy)]
pub(super) enum CaseKind {
    /// This many load cases.
    LoadCases(usize),
    /// This many absolute positions.
    Positions(usize),
}

impl CaseKind {
    /// What is asked for; `None`: series of loads.
    pub(super) fn of(args: &SimulateArgs) -> Option<Self> {
        let load_cases = args.load_cases.map(Self::LoadCases);
        load_cases.or(args.positions.map(Self::Positions))
    }

    fn option(self) -> &'static str {
        match self {
            Self::LoadCases(_) => "--load-cases",
            Self::Positions(_) => "--positions",
        }
    }
}

/// A session folder with load cases or positions.
pub(super) fn run(
    args: &SimulateArgs,
    kind: CaseKind,
    mut resolved: ResolvedModel,
    truth: FittingFactors,
) -> Result<Outcome, Failure> {
    let help = |_: &str| format!("leave it out, or leave out {}", kind.option());
    let history = [("--keep-history", args.keep_history)];
    refuse_given(&history, "a load case has no history", help)?;
    let axes = [("--displacement-axes", args.axes.is_given())];
    refuse_given(&axes, "it belongs to series of loads", help)?;
    resolved.factors = truth;
    refuse_unseen_laws(&resolved, matches!(kind, CaseKind::Positions(_)))?;
    let truth = resolved.robot.with_own_springs(&resolved.factors);
    let rigid_springs = rigid_springs(&resolved, &truth);
    let noise = noise(args);
    let (mut table, tracker, words) = made(args, kind, &resolved, &truth, &noise)?;
    table.origin = Some(origin(args, &resolved));
    create_new(&args.out)?;
    let header = usual_header(args, &resolved).to_load_case_toml();
    let record = record(args, &resolved, &truth, &noise, tracker.as_ref());
    let readings = write_load_cases(&table);
    write_session(args, &resolved, readings.as_bytes(), [&header, &record])?;
    let folder = args.out.display();
    let poses = table.poses().len();
    let text = format!(
        "{folder}: {} {words} of mechanism {} in {poses} poses, seed {}\n{}\
         session.toml, readings.csv, robot.toml and simulation.toml (true factors{} and noise) written.\nNext: stiffbench fit {folder}\n",
        table.cases.len(),
        resolved.mechanism,
        args.seed,
        physics_text(&resolved.physics),
        if tracker.is_some() { ", tracker" } else { "" },
    );
    let report = SimulationReport {
        readings: table.component_count(),
        procedure: match kind {
            CaseKind::LoadCases(_) => "load cases".to_owned(),
            CaseKind::Positions(_) => "positions".to_owned(),
        },
        tracker,
        ..report(args, &resolved, truth, noise)
    };
    let warnings = [resolved.warnings.clone(), rigid_springs].concat();
    Ok(outcome(text, report, &resolved, warnings))
}

/// The table, the tracker that saw it, and what it holds in words.
fn made(
    args: &SimulateArgs,
    kind: CaseKind,
    resolved: &ResolvedModel,
    truth: &FittingFactors,
    noise: &NoiseModel,
) -> Result<(LoadCaseTable, Option<TrackerReport>, String), Failure> {
    let robot = &resolved.robot;
    let SingleLoads {
        poses,
        largest_n: force_n,
        repeats,
    } = single_loads(&args.procedure, kind.option())?;
    match kind {
        CaseKind::LoadCases(count) => {
            let largest_force_n = force_n.unwrap_or(LARGEST_FORCE_N);
            let plan = LoadCasePlan {
                count,
                largest_force_n,
                repeats,
                poses,
            };
            let physics = &resolved.physics;
            let table = simulate_load_cases(robot, physics, truth, &plan, noise, args.seed)?;
            let words = format!("load cases up to {largest_force_n} N");
            Ok((table, None, words))
        }
        CaseKind::Positions(count) => {
            let plan = PositionPlan {
                count,
                largest_force_n: force_n,
                repeats,
                poses,
            };
            let physics = &resolved.physics;
            let SimulatedPositions { table, frames } =
                simulate_positions(robot, physics, truth, &plan, noise, args.seed)?;
            let forces = force_n.map_or_else(String::new, |force_n| {
                format!(" and forces up to {force_n} N")
            });
            let words = format!("positions under own weight{forces}");
            Ok((table, Some(TrackerReport::from(&frames)), words))
        }
    }
}

/// What an analysis must not see: the truth.
fn record(
    args: &SimulateArgs,
    resolved: &ResolvedModel,
    truth: &FittingFactors,
    noise: &NoiseModel,
    tracker: Option<&TrackerReport>,
) -> String {
    let effects = effects_line(resolved);
    let mut text = truth_text(args.seed, truth, noise, [&effects, ""]);
    if let Some(tracker) = tracker {
        let _ = write!(
            text,
            "[tracker]\nbase_mm = {:?}\nrotation_vector_deg = {:?}\ntool_point_mm = {:?}\n",
            tracker.base_mm, tracker.rotation_vector_deg, tracker.tool_point_mm
        );
    }
    text
}
