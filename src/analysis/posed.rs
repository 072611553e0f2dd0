//! Load cases in the poses and axes of the robot that they were measured on.

use crate::fit::{
    FactorStatus, FitOptions, FitOutcome, LoadCaseModel, PosedLoadCases, TableMistake,
    bad_load_case_values, fit_load_cases, table_mistake, usual_choice,
};
use crate::mismatch::{BadReading, GaugeSteps, MismatchError, StatedScatter};
use crate::parameters::{FitRole, ParameterChoice};
use crate::physics::{ActingPhysics, Needs};
use crate::robot::{FittingFactors, TrackedPoses};
use crate::stiffness::read_off_words;

use super::data::LoadedLoadCases;
use super::diagnose::{DiagnoseSettings, DiagnosisReport, diagnose_together};
use super::error::{ArgumentError, Failure};
use super::hash::sha256;
use super::model::{ModelChoice, ResolvedModel, resolve_beside};
use super::procedure::{add_missing_poses, put_pose};
use super::session_table::SessionTable;
use super::together::marked;

/// Load cases in the poses and axes of a robot.
#[derive(Debug)]
pub struct PosedData {
    /// The load cases.
    pub posed: PosedLoadCases,
    /// Values of the parameters with the springs that the user's effects name.
    start: FittingFactors,
    /// The user's other effects, if there are any.
    physics: Option<ActingPhysics>,
    /// Steps of the gauges of the first table.
    steps: GaugeSteps,
    /// What is stated of the scatter.
    pub(super) scatter: Option<StatedScatter>,
}

impl PosedData {
    /// Resolves the model of load cases of one robot and puts them into its poses; and what a user should know of both.
    ///
    /// # Errors
    /// For a model that cannot be resolved, a session of another robot, and variables, poses and axes that the robot does not have.
    pub(super) fn new(
        loaded: &[LoadedLoadCases],
        choice: &ModelChoice,
    ) -> Result<(ResolvedModel, Self, Vec<String>), Failure> {
        let (first, further) = loaded.split_first().ok_or(MismatchError::Empty)?;
        let beside = (first.header.as_ref(), first.folder.as_path());
        let mut model = resolve_beside(choice, Some(beside))?;
        let posed = PosedLoadCases::new(&model.robot, model.mechanism()?, &first.table)?;
        let mut warnings = [&first.warnings[..], &model.warnings, &posed.warnings].concat();
        refuse_unseen_laws(&model, posed.has_positions())?;
        let (start, others) = model.springs_apart();
        let acting = ActingPhysics::new(&model.robot, model.mechanism()?, others)?;
        let mut steps = GaugeSteps::of(first.header.as_ref());
        if steps.force_n.is_none()
            && let Some(step_n) = posed.force_step_n()
        {
            warnings.push(read_off_words("force", step_n, "N"));
            steps.force_n = Some(step_n);
        }
        let mut data = Self {
            posed,
            start,
            physics: Some(acting).filter(|acting| !acting.effects.is_empty()),
            steps,
            scatter: first.scatter,
        };
        for one in further {
            warnings.extend(data.join(one, &mut model)?);
        }
        Ok((model, data, warnings))
    }

    /// Takes in further load cases of the same robot; gives what a user should know of them.
    fn join(
        &mut self,
        further: &LoadedLoadCases,
        model: &mut ResolvedModel,
    ) -> Result<Vec<String>, Failure> {
        let header = further.header.as_ref();
        let own = sha256(&model.source.text);
        if let Some(hash) = header.and_then(|header| header.robot_sha256.as_ref())
            && *hash != own
        {
            return ArgumentError::refuse(
                further.name.clone(),
                format!(
                    "it was measured on another robot file than {} (its SHA-256 differs)",
                    model.source.name
                ),
                "fit sessions of one robot together",
            );
        }
        if let Some(procedure) = header.and_then(|header| header.procedure.as_ref()) {
            add_missing_poses(&mut model.robot, &procedure.joint_values);
        }
        let posed = PosedLoadCases::new(&model.robot, model.mechanism()?, &further.table)?;
        let warnings = [&further.warnings[..], &posed.warnings].concat();
        self.posed.join(posed);
        Ok(warnings)
    }

    /// The load cases with what they were measured on.
    pub(super) fn problem<'a>(&'a self, model: &'a ResolvedModel) -> LoadCaseModel<'a> {
        LoadCaseModel {
            robot: &model.robot,
            mechanism: &model.physics.mechanism,
            start: &self.start,
            posed: &self.posed,
            steps: self.steps,
            physics: self.physics.as_ref(),
        }
    }

    /// The parameters that are free unless the user says: joint springs where the links are rigid, else the factors of beams.
    ///
    /// # Errors
    /// For a pose that cannot be reached, or a structure that carries nothing.
    pub(super) fn usual_choice(&self, model: &ResolvedModel) -> Result<ParameterChoice, Failure> {
        Ok(usual_choice(&self.problem(model))?)
    }

    /// Readings of a pose or a component that would agree with all others if they were multiplied by a usual factor, else values that
    /// contradict their repeats, or the fit to all others: beside a mistake of the whole table good values look bad.
    ///
    /// # Errors
    /// As of the fit.
    pub(super) fn mistakes(
        &self,
        model: &ResolvedModel,
        options: &FitOptions,
        fit: &FitOutcome,
    ) -> Result<(Option<TableMistake>, Vec<BadReading>), Failure> {
        let problem = self.problem(model);
        Ok(match table_mistake(&problem, options, fit)? {
            None => (None, bad_load_case_values(&problem, options, fit)?),
            mistake => (mistake, Vec::new()),
        })
    }

    /// Finds what the free parameters leave out.
    ///
    /// # Arguments
    /// - `first`: the first of the data.
    /// - `model`: takes the poses that the search names.
    ///
    /// # Errors
    /// For a fit that is impossible, and as of [`diagnose_together`].
    pub(super) fn diagnose(
        &self,
        first: &SessionTable<()>,
        model: &mut ResolvedModel,
        mut options: DiagnoseSettings,
        step: &dyn Fn(),
    ) -> Result<DiagnosisReport, Failure> {
        let mut choice = match options.parameters.take() {
            Some(choice) => choice,
            None => self.usual_choice(model)?,
        };
        let fitted = FitOptions {
            train: None,
            choice: choice.clone(),
            sigma: None,
            scatter: self.scatter,
        };
        let fit = fit_load_cases(&self.problem(model), &fitted)?;
        let tracker = self.tracked(model, &fit)?;
        let (table_mistake, bad) = self.mistakes(model, &fitted, &fit)?;
        let all = self.posed.as_series(self.steps, tracker.as_ref());
        let lines: Vec<u32> = bad.iter().map(|one| one.line).collect();
        let is_bad = |line| lines.contains(&line);
        let marked_readings = marked(&all, &is_bad).collect();
        let keep = options.keep_outliers;
        let rows: Vec<usize> = bad
            .iter()
            .map(|one| one.reading)
            .filter(|_| !keep)
            .collect();
        let posed = self.posed.without_rows(&rows);
        for (name, pose) in posed.named_poses() {
            put_pose(&mut model.robot, &name, pose);
        }
        let session = first.with_table(posed.as_series(self.steps, tracker.as_ref()));
        if tracker.is_some() {
            // Own weight does not load every spring.
            let open = fit.estimates.iter();
            let open = open.filter(|one| matches!(one.status, FactorStatus::NotIdentified { .. }));
            for one in open {
                choice.set(&one.parameter, FitRole::Fixed);
            }
        }
        options.parameters = Some(choice);
        let report = diagnose_together(&[session], model, options, step)?;
        Ok(DiagnosisReport {
            table_mistake,
            bad_readings: bad,
            marked_readings,
            ..report
        })
    }

    /// The tools as the tracker of a fit sees them; none of displacements.
    fn tracked(
        &self,
        model: &ResolvedModel,
        fit: &FitOutcome,
    ) -> Result<Option<TrackedPoses>, Failure> {
        let frames = fit.frames.as_ref().map(|fitted| fitted.frames);
        let (robot, mechanism) = (&model.robot, model.mechanism()?);
        let tracked =
            frames.map(|frames| TrackedPoses::new(robot, mechanism, &self.posed.poses, frames));
        Ok(tracked.transpose()?)
    }
}

/// Refuses effects that single loads cannot show: those of the clock, and beside positions of a tracker those of gauges and runs.
///
/// # Errors
/// For the first of them.
pub fn refuse_unseen_laws(model: &ResolvedModel, positions: bool) -> Result<(), Failure> {
    for effect in &model.physics.effects {
        let (problem, help) = if effect.law.search.needs != Needs::Nothing {
            (
                "it acts over time or by the temperature, and load cases have neither a clock nor a thermometer",
                "leave it out, or take series of loads in their place: stiffbench session, or simulate without --load-cases",
            )
        } else if positions && effect.law.is_hidden_from_trackers() {
            (
                "it is of a displacement gauge or its stand, of loads along an axis, or of one run, and a tracker has none of these",
                "leave it out",
            )
        } else {
            continue;
        };
        return ArgumentError::refuse(format!("--effect {}", effect.compact()), problem, help);
    }
    Ok(())
}
