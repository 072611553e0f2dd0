//! Load cases: files, the robot that they were measured on, and the fit.

use std::path::{Path, PathBuf};

use crate::fit::{FactorStatus, FitOptions, FitOutcome};
use crate::fit::{
    LoadCaseModel, PosedLoadCases, TableMistake, TrackedPoses, bad_load_case_values,
    fit_load_cases, plan_load_cases, table_mistake, usual_choice,
};
use crate::load_cases::{LoadCaseTable, is_load_case_table, read_load_cases};
use crate::mismatch::{BadReading, GaugeSteps};
use crate::parameters::{FitRole, ParameterChoice};
use crate::physics::{ActingPhysics, Effect, Needs};
use crate::readings::{ReadOptions, is_vector_table};
use crate::robot::FittingFactors;
use crate::stiffness::read_off_words;
use crate::test_point::PoseId;

use super::data::{OpenSettings, check_calibration, readings_file, session_header};
use super::diagnose::{DiagnoseSettings, DiagnosisReport, diagnose_together};
use super::error::{AnalysisError, ArgumentError};
use super::files::{folder_of, is_there, read_bytes, shown};
use super::fit::{FitSettings, PLANNED, PlannedFit, training_poses};
use super::hash::sha256;
use super::inputs::Inputs;
use super::model::{ModelChoice, ResolvedModel, resolve_beside};
use super::procedure::{add_missing_poses, put_pose};
use super::session_table::{SessionTable, origin_of};
use super::together::marked;

/// Load cases with the session they belong to.
pub type LoadedLoadCases = SessionTable<LoadCaseTable>;

impl LoadedLoadCases {
    /// Whether a session folder or file holds load cases.
    #[must_use]
    pub fn is_at(path: &Path) -> bool {
        let file = readings_file(path).ok();
        let bytes = file.and_then(|file| read_bytes(&file).ok());
        bytes.is_some_and(|bytes| is_load_case_table(&bytes) && !is_vector_table(&bytes))
    }

    /// Opens a session folder or a file of load cases.
    ///
    /// # Errors
    /// For data that are not there or cannot be read, and an overdue calibration, as the options have it.
    pub fn open(path: &Path, options: &OpenSettings) -> Result<Self, AnalysisError> {
        let file = readings_file(path)?;
        let folder = folder_of(&file);
        let bytes = read_bytes(&file)?;
        let name = shown(&file);
        options.gauges.refuse(&name)?;
        let table = read_load_cases(&name, bytes.as_slice(), &ReadOptions::default())?;
        let mut warnings: Vec<String> = table.notes.iter().map(ToString::to_string).collect();
        let header = session_header(&folder, &mut warnings)?;
        let overdue = check_calibration(header.as_ref(), None, options.calibration, &mut warnings)?;
        Ok(Self {
            name: shown(path),
            sha256: sha256(&bytes),
            origin: origin_of(table.origin.as_ref(), header.as_ref()),
            table,
            header,
            folder,
            warnings,
            calibration: Vec::new(),
            overdue,
            differs_from_journal: false,
        })
    }

    /// The error of what needs series of loads.
    pub(super) fn needs_runs(&self, needs: &'static str) -> AnalysisError {
        AnalysisError::NeedsRuns {
            data: self.name.clone(),
            needs,
        }
    }
}

/// Load cases in the poses and axes of a robot.
#[derive(Debug)]
pub struct LoadCaseData {
    /// Robot, mechanism, values to begin at.
    pub model: ResolvedModel,
    /// The load cases.
    pub posed: PosedLoadCases,
    /// What a user should know of data and model.
    pub warnings: Vec<String>,
    /// Data, robot, mechanism and factors.
    pub inputs: Inputs,
    /// Values of the parameters with the springs that the user's effects name.
    start: FittingFactors,
    /// The user's other effects, if there are any.
    physics: Option<ActingPhysics>,
    /// Steps of the gauges of the first table.
    steps: GaugeSteps,
}

impl LoadCaseData {
    /// Resolves the model of load cases and puts them into its poses.
    ///
    /// # Errors
    /// For a model that cannot be resolved, and variables, poses and axes that the robot does not have.
    pub fn new(loaded: &LoadedLoadCases, choice: &ModelChoice) -> Result<Self, AnalysisError> {
        let beside = (loaded.header.as_ref(), loaded.folder.as_path());
        let model = resolve_beside(choice, Some(beside))?;
        let posed = PosedLoadCases::new(&model.robot, model.mechanism()?, &loaded.table)?;
        let mut warnings = [&loaded.warnings[..], &model.warnings, &posed.warnings].concat();
        refuse_unseen_laws(&model, posed.has_positions())?;
        let (start, others) = springs_apart(&model);
        let acting = ActingPhysics::new(&model.robot, model.mechanism()?, others)?;
        let physics = Some(acting).filter(|acting| !acting.effects.is_empty());
        let mut steps = GaugeSteps::of(loaded.header.as_ref());
        if steps.force_n.is_none()
            && let Some(step_n) = posed.force_step_n()
        {
            warnings.push(read_off_words("force", step_n, "N"));
            steps.force_n = Some(step_n);
        }
        Ok(Self {
            inputs: Inputs::default().with_table(loaded).with_model(&model),
            start,
            physics,
            steps,
            model,
            posed,
            warnings,
        })
    }

    /// Opens further load cases of the same robot and takes them in.
    ///
    /// # Errors
    /// For data that are no load cases or of another robot, and variables, poses and axes that the robot does not have.
    pub fn join_at(
        &mut self,
        paths: &[PathBuf],
        options: &OpenSettings,
    ) -> Result<(), AnalysisError> {
        for path in paths {
            if is_there(path) && !LoadedLoadCases::is_at(path) {
                return ArgumentError::refuse(
                    path.display().to_string(),
                    "no load cases are there: loads and displacements as vectors, which the first data are",
                    "name a table of load cases; sessions are fitted with sessions",
                );
            }
            self.join(&LoadedLoadCases::open(path, options)?)?;
        }
        Ok(())
    }

    /// Takes in further load cases of the same robot.
    ///
    /// # Errors
    /// For a session of another robot, and variables, poses and axes that the robot does not have.
    pub fn join(&mut self, further: &LoadedLoadCases) -> Result<(), AnalysisError> {
        let header = further.header.as_ref();
        let own = sha256(&self.model.source.text);
        if let Some(hash) = header.and_then(|header| header.robot_sha256.as_ref())
            && *hash != own
        {
            return ArgumentError::refuse(
                further.name.clone(),
                format!(
                    "it was measured on another robot file than {} (its SHA-256 differs)",
                    self.model.source.name
                ),
                "fit sessions of one robot together",
            );
        }
        if let Some(procedure) = header.and_then(|header| header.procedure.as_ref()) {
            add_missing_poses(&mut self.model.robot, &procedure.joint_values);
        }
        let mechanism = self.model.mechanism()?;
        let posed = PosedLoadCases::new(&self.model.robot, mechanism, &further.table)?;
        self.warnings.extend(further.warnings.iter().cloned());
        self.warnings.extend(posed.warnings.iter().cloned());
        self.posed.join(posed);
        self.inputs = std::mem::take(&mut self.inputs).with_table(further);
        Ok(())
    }

    /// The load cases with what they were measured on.
    ///
    /// # Errors
    /// If the robot was changed and lacks the mechanism.
    pub fn problem(&self) -> Result<LoadCaseModel<'_>, AnalysisError> {
        Ok(LoadCaseModel {
            robot: &self.model.robot,
            mechanism: &self.model.physics.mechanism,
            start: &self.start,
            posed: &self.posed,
            steps: self.steps,
            physics: self.physics.as_ref(),
        })
    }

    /// The parameters that are free unless the user says: joint springs where the links are rigid, else the factors of beams.
    ///
    /// # Errors
    /// For a pose that cannot be reached, or a structure that carries nothing.
    pub fn usual_choice(&self) -> Result<ParameterChoice, AnalysisError> {
        let model = self.problem()?;
        Ok(usual_choice(
            model.robot,
            model.mechanism,
            model.start,
            model.posed,
        )?)
    }

    /// Fits parameters to the load cases.
    ///
    /// # Errors
    /// For training poses that the data do not have, and a fit that is impossible.
    pub fn fit(&self, settings: &FitSettings) -> Result<FitOutcome, AnalysisError> {
        Ok(fit_load_cases(&self.problem()?, &self.options(settings)?)?)
    }

    /// Values that contradict their repeats, or the fit to all others.
    ///
    /// # Errors
    /// As [`LoadCaseData::fit`].
    pub fn bad_values(
        &self,
        settings: &FitSettings,
        fit: &FitOutcome,
    ) -> Result<Vec<BadReading>, AnalysisError> {
        let options = self.options(settings)?;
        Ok(bad_load_case_values(&self.problem()?, &options, fit)?)
    }

    /// Readings of a pose or a component that would agree with all others if they were multiplied by a usual factor.
    ///
    /// # Errors
    /// As [`LoadCaseData::fit`].
    pub fn table_mistake(
        &self,
        settings: &FitSettings,
        fit: &FitOutcome,
    ) -> Result<Option<TableMistake>, AnalysisError> {
        let options = self.options(settings)?;
        Ok(table_mistake(&self.problem()?, &options, fit)?)
    }

    /// Finds what the free parameters leave out.
    ///
    /// # Arguments
    /// - `loaded`: the first of the data.
    /// - `step`: as of [`diagnose_together`].
    ///
    /// # Errors
    /// As [`LoadCaseData::fit`] and [`diagnose_together`].
    pub fn diagnose(
        &mut self,
        loaded: &LoadedLoadCases,
        options: DiagnoseSettings,
        step: &dyn Fn(),
    ) -> Result<DiagnosisReport, AnalysisError> {
        let settings = &FitSettings {
            choice: options.parameters.clone(),
            ..FitSettings::default()
        };
        let fit = self.fit(settings)?;
        let tracker = self.tracked(&fit)?;
        let table_mistake = self.table_mistake(settings, &fit)?;
        // Beside a mistake of the whole table good values look bad.
        let bad = if table_mistake.is_some() {
            Vec::new()
        } else {
            self.bad_values(settings, &fit)?
        };
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
            put_pose(&mut self.model.robot, &name, pose);
        }
        let series = posed.as_series(self.steps, tracker.as_ref());
        let session = loaded.with_table(series);
        let mut options = options;
        if let (Some(choice), Some(_)) = (&mut options.parameters, &tracker) {
            // Own weight does not load every spring.
            let open = fit.estimates.iter();
            let open = open.filter(|one| matches!(one.status, FactorStatus::NotIdentified { .. }));
            for one in open {
                choice.set(&one.parameter, FitRole::Fixed);
            }
        }
        let report = diagnose_together(&[session], &self.model, options, step)?;
        Ok(DiagnosisReport {
            table_mistake,
            bad_readings: bad,
            marked_readings,
            ..report
        })
    }

    /// The tools as the tracker of a fit sees them; none of displacements.
    fn tracked(&self, fit: &FitOutcome) -> Result<Option<TrackedPoses>, AnalysisError> {
        let frames = fit.frames.as_ref().map(|fitted| fitted.frames);
        let (robot, mechanism) = (&self.model.robot, self.model.mechanism()?);
        let tracked = frames.map(|frames| self.posed.tracked(robot, mechanism, frames));
        Ok(tracked.transpose()?)
    }

    /// As [`FitData::plan`](super::FitData::plan).
    ///
    /// # Errors
    /// For a structure that carries nothing.
    pub fn plan(&self, fit: &FitOutcome) -> Result<PlannedFit, AnalysisError> {
        let model = self.problem()?;
        let planned = plan_load_cases(&model, fit, PLANNED)?;
        Ok(PlannedFit::new(model.robot, None, planned))
    }

    fn options(&self, settings: &FitSettings) -> Result<FitOptions, AnalysisError> {
        let known: Vec<&str> = self.posed.labels.iter().map(PoseId::as_str).collect();
        let train = settings.train.as_deref();
        Ok(FitOptions {
            train: train
                .map(|names| training_poses(names, &known))
                .transpose()?,
            choice: match &settings.choice {
                Some(choice) => choice.clone(),
                None => self.usual_choice()?,
            },
            sigma: settings.sigma,
        })
    }
}

/// The factors of a model with the springs that its effects name.
///
/// # Errors
/// For an effect that is no spring.
pub(super) fn start_of(model: &ResolvedModel) -> Result<FittingFactors, AnalysisError> {
    let (start, others) = springs_apart(model);
    match others.first() {
        None => Ok(start),
        Some(effect) => ArgumentError::refuse(
            format!("--effect {}", effect.compact()),
            "plans of poses know only springs: joint-compliance, joint-tilt-compliance, tool-compliance and base-compliance",
            "leave it out",
        ),
    }
}

/// The same with the other effects apart.
fn springs_apart(model: &ResolvedModel) -> (FittingFactors, Vec<Effect>) {
    let mut start = model.robot.with_own_springs(&model.factors);
    let mut others = Vec::new();
    for effect in &model.physics.effects {
        match effect.as_spring() {
            Some((spring, own)) => start.set(&spring, start.get(&spring) + own),
            None => others.push(effect.clone()),
        }
    }
    (start, others)
}

/// Refuses effects that single loads cannot show: those of the clock, and beside positions of a tracker those of gauges and runs.
///
/// # Errors
/// For the first of them.
pub fn refuse_unseen_laws(model: &ResolvedModel, positions: bool) -> Result<(), AnalysisError> {
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
