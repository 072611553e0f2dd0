//! Fits of the model's factors to data.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fit::{
    BootstrapDraws, FactorStatus, FitError, FitOptions, FitOutcome, FitProblem, FixedPhysics,
    MeasuredStiffness, MonteCarloSettings, PaperFit, PaperOptions, PaperSource, PlannedLoadCases,
    PoseRules, ResampledUnit, TableMistake, WeightBasis, bootstrap_cells, find_lower_minimum,
    fit_cells, fit_load_cases, follow_paper, plan_beside_cells, plan_load_cases,
};
use crate::least_squares::{BootstrapSettings, LeastSquaresError, SearchSettings, SigmaMode};
use crate::load_cases::LoadCaseTable;
use crate::mismatch::{BadReading, CellSlopes, Observations};
use crate::nearest::nearest;
use crate::parameters::{FitRole, ParameterChoice};
use crate::procedure::Procedure;
use crate::robot::{FittingFactors, RobotError};
use crate::stiffness::{Branches, Method, StiffnessTable};
use crate::test_point::PoseId;

use super::data::{Data, LoadedLoadCases, LoadedSession, is_shipped_list};
use super::error::{AnalysisError, ArgumentError, Failure};
use super::inputs::Inputs;
use super::marked::ReadingMark;
use super::model::{ModelChoice, ResolvedModel, no_robot, resolve};
use super::plausible::doubts_about_stiffness;
use super::pose_plan::{procedure_of, table_of};
use super::posed::PosedData;
use super::together::{names, resolve_together};
use super::unknown_springs::UnknownSprings;
use crate::count::counted;

/// Data ready to be fitted.
#[derive(Debug)]
pub struct FitData {
    /// Robot, mechanism, factors.
    pub model: ResolvedModel,
    /// Stiffness of the cells (a cell is a pose and a direction); none of load cases.
    pub measured: MeasuredStiffness,
    /// The load cases, if the data are some.
    pub posed: Option<PosedData>,
    /// What acts beside the beams.
    pub physics: Option<FixedPhysics>,
    /// The readings behind it with their stiffness, if there are any.
    pub session: Option<(Box<LoadedSession>, StiffnessTable)>,
    /// The sessions, where they are several, in the order of the cells.
    pub sessions: Vec<FittedSession>,
    /// Readings that the fit leaves out, and those that it uses though they are flagged.
    pub marked: Vec<ReadingMark>,
    /// What a user should know of the data and the model.
    pub warnings: Vec<String>,
    /// Data, robot, mechanism and factors.
    pub inputs: Inputs,
}

/// Further load cases that are planned for what is open.
const PLANNED: usize = 3;

/// What is to be measured next.
#[derive(Debug, Clone)]
pub struct PlannedFit {
    /// The load cases, one after the other; none if nothing is open, or nothing would narrow it.
    pub planned: PlannedLoadCases,
    /// The same as a table to be filled in.
    pub table: LoadCaseTable,
    /// A procedure that measures them.
    pub procedure: Procedure,
}

/// One of several sessions that were fitted together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "FittedSessionReport")]
pub struct FittedSession {
    /// What the cells call it.
    pub name: String,
    /// The data as they were named.
    pub data: String,
    /// Its cells that have a stiffness.
    pub cells: usize,
    /// Its compliances along other axes than that of the load.
    pub across: usize,
    /// Relative standard deviation of the slope from run to run; `null` where it has too few repeats.
    pub run_slope_sd: Option<f64>,
}

/// What the bootstrap resamples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum BootstrapOver {
    /// Applications of the load sequence within their cell: scatter from run to run
    #[default]
    Runs,
    /// Whole cells (pose and direction): also the misfit of the model from cell to cell
    Cells,
}

/// How factors are fitted by least squares.
#[derive(Debug, Clone, Default)]
pub struct FitSettings {
    /// Names of the poses to fit; the others are held out. `None`: all, assessed by leaving each out in turn.
    pub train: Option<Vec<String>>,
    /// Which parameters may move, and how far. `None`: those of [`FitData::usual_choice`].
    pub choice: Option<ParameterChoice>,
    /// Where the standard deviation of the residuals comes from; `None`: from the data's uncertainties if they have any.
    pub sigma: Option<SigmaMode>,
    /// Number of bootstrap replicates; 0: none.
    pub bootstrap: usize,
    /// What the bootstrap resamples.
    pub bootstrap_over: BootstrapOver,
    /// Search for a lower minimum with a particle swarm and a simplex.
    pub global_search: bool,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// How factors are fitted by the nine steps of the paper.
#[derive(Debug, Clone, Default)]
pub struct PaperFitSettings {
    /// Names of the poses to fit; `None`: all.
    pub train: Option<Vec<String>>,
    /// Weights of the training poses in their order; `None`: equal ones.
    pub weights: Option<Vec<f64>>,
    /// Reference stiffness of the single-source steps; `None`: the robot's factors `s_fsd`, else `unit`, are given.
    pub reference: Option<MeasuredStiffness>,
    /// Seed of the Monte Carlo trials.
    pub seed: u64,
}

impl FitData {
    /// Resolves the model of data. Readings are reduced to stiffness, session by session, so that each cell has the uncertainty that its own
    /// session shows: by generalised least squares in their noise, for the paper's method or without repeats by `method` from the loading
    /// branches. Load cases are put into the poses of the robot.
    ///
    /// # Errors
    /// For a model that [`resolve`] refuses, values without a named robot, poses, variables and axes that the robot does not have, and
    /// sessions that do not go together.
    pub fn new(data: Data, choice: &ModelChoice, method: Method) -> Result<Self, Failure> {
        let inputs = Inputs::default().with_data(&data);
        let prepared = match data {
            Data::Stiffness { measured, name, .. } => {
                Self::of_values(measured, &name, choice, method)
            }
            Data::Readings(sessions) => match <[LoadedSession; 1]>::try_from(sessions) {
                Ok([session]) => Self::of_readings(session, choice, method),
                Err(sessions) => Self::together(&sessions, choice, method),
            },
            Data::LoadCases(loaded) => Self::of_load_cases(&loaded, choice),
        }?;
        Ok(Self {
            inputs: inputs.with_model(&prepared.model),
            ..prepared
        })
    }

    /// A model beside stiffness, without what only some data have.
    fn bare(model: ResolvedModel, measured: MeasuredStiffness, warnings: Vec<String>) -> Self {
        Self {
            model,
            measured,
            posed: None,
            physics: None,
            session: None,
            sessions: Vec::new(),
            marked: Vec::new(),
            warnings,
            inputs: Inputs::default(),
        }
    }

    fn of_load_cases(loaded: &[LoadedLoadCases], choice: &ModelChoice) -> Result<Self, Failure> {
        let (model, posed, warnings) = PosedData::new(loaded, choice)?;
        Ok(Self {
            posed: Some(posed),
            ..Self::bare(model, MeasuredStiffness::default(), warnings)
        })
    }

    fn of_values(
        measured: MeasuredStiffness,
        name: &str,
        choice: &ModelChoice,
        method: Method,
    ) -> Result<Self, Failure> {
        if choice.robot.is_none() && choice.model.is_none() && !is_shipped_list(name) {
            return Err(no_robot());
        }
        let model = resolve(choice, None)?;
        for cell in &measured.cells {
            model.robot.pose(&cell.cell.pose)?;
        }
        let mut warnings = vec![format!(
            "{name} holds stiffness values without readings: what only readings show cannot be tested"
        )];
        let physics = fixed_physics(&model, method);
        if physics.is_some() {
            warnings.push("without readings the loads behind the stiffness values are not known: laws that are not linear act as under the paper's, 10 to 70 N".to_owned());
        }
        Ok(Self {
            physics,
            ..Self::bare(model, measured, warnings)
        })
    }

    fn together(
        sessions: &[LoadedSession],
        choice: &ModelChoice,
        method: Method,
    ) -> Result<Self, Failure> {
        let model = resolve_together(sessions, choice)?;
        let (mut all, mut warnings) = (Vec::new(), model.warnings.clone());
        let mut physics = fixed_physics(&model, method);
        let mut first_run = 0;
        let (mut shares, mut marked) = (Vec::new(), Vec::new());
        for (session, name) in sessions.iter().zip(names(sessions)) {
            let own = reduced(session, method)?;
            let measured = own.measured;
            let named = own.warnings.iter();
            warnings.extend(named.map(|warning| format!("{}: {warning}", session.name)));
            marked.extend(ReadingMark::of(&session.table, Some(&name)));
            shares.push(FittedSession {
                name,
                data: session.name.clone(),
                cells: measured.cells.len(),
                across: measured.across.len(),
                run_slope_sd: match measured.basis {
                    WeightBasis::Pooled { run_slope_sd, .. } => Some(run_slope_sd),
                    _ => None,
                },
            });
            all.push(measured);
            physics = physics.map(|physics| {
                // No run of one session is one of another.
                let mut table = session.table.clone();
                for reading in &mut table.readings {
                    reading.run += first_run;
                }
                let runs = table.readings.iter().map(|reading| reading.run + 1);
                first_run = runs.fold(first_run, u32::max);
                physics
                    .under(&table, session.header.as_ref())
                    .by(own.slopes.as_ref())
            });
        }
        Ok(Self {
            physics,
            sessions: shares,
            marked,
            ..Self::bare(model, MeasuredStiffness::joined(&all), warnings)
        })
    }

    fn of_readings(
        session: LoadedSession,
        choice: &ModelChoice,
        method: Method,
    ) -> Result<Self, Failure> {
        let model = resolve(choice, Some(&session))?;
        let own = reduced(&session, method)?;
        let warnings = [&own.warnings[..], &model.warnings].concat();
        let physics = fixed_physics(&model, method)
            .map(|physics| physics.under(&session.table, session.header.as_ref()))
            .map(|physics| physics.by(own.slopes.as_ref()));
        Ok(Self {
            physics,
            marked: ReadingMark::of(&session.table, None),
            session: Some((Box::new(session), own.table)),
            ..Self::bare(model, own.measured, warnings)
        })
    }

    /// The problem of a fit to all cells.
    ///
    /// # Errors
    /// If the robot was changed and lacks the mechanism.
    pub fn problem(&self) -> Result<FitProblem<'_>, RobotError> {
        Ok(FitProblem {
            robot: &self.model.robot,
            mechanism: self.model.mechanism()?,
            measured: &self.measured,
            start: &self.model.factors,
            physics: self.physics.as_ref(),
        })
    }

    /// The parameters that are free unless the user says. Of load cases joint springs where the links are rigid, else the factors of beams;
    /// of stiffness those of [`ResolvedModel::usual_parameters`].
    ///
    /// # Errors
    /// For a pose that cannot be reached, a structure that carries nothing, and as [`problem`](Self::problem).
    pub fn usual_choice(&self) -> Result<ParameterChoice, Failure> {
        match &self.posed {
            Some(posed) => posed.usual_choice(&self.model),
            None => Ok(self.model.usual_parameters()?),
        }
    }

    fn options(&self, settings: &FitSettings) -> Result<FitOptions, Failure> {
        Ok(FitOptions {
            train: self.training(settings.train.as_deref())?,
            choice: match &settings.choice {
                Some(choice) => choice.clone(),
                None => self.usual_choice()?,
            },
            sigma: settings.sigma,
            scatter: self.posed.as_ref().and_then(|posed| posed.scatter),
        })
    }

    /// Of load cases a mistake of the whole table, else values that contradict their repeats, or the fit to all others.
    ///
    /// # Errors
    /// As [`fit`](Self::fit).
    pub fn mistakes(
        &self,
        settings: &FitSettings,
        fit: &FitOutcome,
    ) -> Result<(Option<TableMistake>, Vec<BadReading>), Failure> {
        match &self.posed {
            Some(posed) => posed.mistakes(&self.model, &self.options(settings)?, fit),
            None => Ok((None, Vec::new())),
        }
    }

    /// Fits the factors to all training data at once by least squares.
    ///
    /// # Arguments
    /// - `refitted`: called after each replicate of the bootstrap.
    ///
    /// # Errors
    /// For training poses that the data do not have, data without what the settings need, and a fit that is impossible.
    pub fn fit(
        &self,
        settings: &FitSettings,
        refitted: &(dyn Fn() + Sync),
    ) -> Result<FitOutcome, Failure> {
        let options = self.options(settings)?;
        if let Some(posed) = &self.posed {
            let members = &options.choice.members;
            let moves = members.iter().any(|one| one.role == FitRole::Free);
            if !moves && !posed.posed.has_positions() {
                let count = members.len();
                return Err(FitError::from(LeastSquaresError::NoFreeParameter { count }).into());
            }
            let outcome = fit_load_cases(&posed.problem(&self.model), &options)?;
            return Ok(self.without_unknown(outcome, &options.choice));
        }
        let start = self.model.start_of_fit(&options.choice);
        let problem = FitProblem {
            start: &start,
            ..self.problem()?
        };
        if settings.sigma == Some(SigmaMode::Known) && !self.measured.has_uncertainties() {
            return ArgumentError::refuse(
                "--sigma known",
                "the data state no uncertainty of the stiffnesses",
                "give readings with repeats or a column u_N_per_um, or use --sigma estimated",
            );
        }
        let mut outcome = fit_cells(&problem, &options)?;
        let in_training = |pose: &PoseId| {
            let train = options.train.as_ref();
            train.is_none_or(|train| train.contains(pose))
        };
        let training = self.measured.select(|cell| in_training(&cell.pose));
        let trained = FitProblem {
            measured: &training,
            ..problem
        };
        if settings.bootstrap > 0 {
            if !self.measured.across.is_empty() {
                return ArgumentError::refuse(
                    "--bootstrap",
                    "it resamples stiffnesses along the load, and the data have displacements along other axes",
                    "leave it out: the intervals allow for what the gauges have in common",
                );
            }
            self.bootstrap(&trained, settings, &options.choice, &mut outcome, refitted)?;
        }
        if settings.global_search {
            let search = SearchSettings {
                seed: settings.seed,
                ..SearchSettings::default()
            };
            let lower = find_lower_minimum(&trained, &options.choice, &search)?;
            outcome.warnings.push(match lower {
                Some(factors) => format!(
                    "a better fit exists: {}",
                    factors.to_toml().replace('\n', " ")
                ),
                None => "swarm and simplex found no better fit within the bounds".to_owned(),
            });
        }
        Ok(self.without_unknown(outcome, &options.choice))
    }

    /// The same without numbers for springs that were kept though they have no value yet.
    fn without_unknown(&self, mut outcome: FitOutcome, choice: &ParameterChoice) -> FitOutcome {
        for (spring, words) in UnknownSprings::of(&self.model).kept(choice) {
            let mut estimates = outcome.estimates.iter_mut();
            if let Some(own) = estimates.find(|own| own.parameter == *spring) {
                own.status = FactorStatus::NotIdentified { words };
            }
        }
        outcome
    }

    /// The further load cases that determine best what a fit leaves open, a table to be filled in with them, and a procedure that measures
    /// them.
    ///
    /// # Errors
    /// For a structure that carries nothing, or if no pose keeps the rules.
    pub fn plan(&self, outcome: &FitOutcome, rules: &PoseRules) -> Result<PlannedFit, Failure> {
        let wanted = (rules, PLANNED);
        let session = self.session.as_ref().map(|(session, _)| session);
        let planned = if let Some(posed) = &self.posed {
            plan_load_cases(&posed.problem(&self.model), outcome, wanted)?
        } else {
            let readings = session.iter().flat_map(|session| &session.table.readings);
            let largest_n = readings.map(|reading| reading.force_n.abs());
            let largest_n = largest_n.fold(0.0, f64::max);
            plan_beside_cells(&self.problem()?, outcome, largest_n, wanted)?
        };
        let header = session.and_then(|session| session.header.as_ref());
        let followed = header
            .and_then(|header| header.procedure.as_ref())
            .and_then(|record| Procedure::from_record(record).ok());
        let robot = &self.model.robot;
        Ok(PlannedFit {
            table: table_of(robot, &planned.planned),
            procedure: procedure_of(robot, followed, &planned.planned),
            planned,
        })
    }

    /// Adds the bootstrap intervals to a fit.
    fn bootstrap(
        &self,
        trained: &FitProblem<'_>,
        settings: &FitSettings,
        choice: &ParameterChoice,
        outcome: &mut FitOutcome,
        refitted: &(dyn Fn() + Sync),
    ) -> Result<(), Failure> {
        let unit = match (settings.bootstrap_over, &self.session) {
            (BootstrapOver::Cells, _) => ResampledUnit::Cells,
            (BootstrapOver::Runs, Some((_, table))) => ResampledUnit::Runs(table),
            (BootstrapOver::Runs, None) => {
                return Err(AnalysisError::NeedsReadings {
                    data: self.inputs.data_name().to_owned(),
                    needs: "--bootstrap (--bootstrap-over cells does not)",
                }
                .into());
            }
        };
        let bootstrap = BootstrapSettings {
            replicates: settings.bootstrap,
            seed: settings.seed,
        };
        let fitted = &outcome.factors;
        let found = bootstrap_cells(trained, fitted, unit, choice, &bootstrap, refitted)?;
        let found_of_each = found.intervals_95.into_iter().zip(found.at_bound);
        for (estimate, (interval, at_bound)) in outcome.estimates.iter_mut().zip(found_of_each) {
            if at_bound > 0 {
                outcome.warnings.push(format!(
                    "{}: {at_bound} of {} refits of the bootstrap ended on its bound: they do not determine it, and its bootstrap interval depends on the bound",
                    estimate.name, found.succeeded
                ));
            }
            // Refits that never move it say nothing of it.
            let interval = interval.filter(|[lower, upper]| lower < upper);
            let holds = |[lower, upper]: &[f64; 2]| (*lower..=*upper).contains(&estimate.value);
            estimate.bootstrap_interval_95 = interval.filter(holds);
            if let Some([lower, upper]) = interval.filter(|interval| !holds(interval)) {
                outcome.warnings.push(format!(
                    "{}: refits of the bootstrap lie from {lower:.4} to {upper:.4}, which does not hold the estimate {:.4}: no bootstrap interval is given",
                    estimate.name, estimate.value
                ));
            }
        }
        outcome.bootstrap = Some(BootstrapDraws {
            over: match settings.bootstrap_over {
                BootstrapOver::Runs => "runs".into(),
                BootstrapOver::Cells => "cells".into(),
            },
            replicates: settings.bootstrap,
            failed: found.failed,
            seed: found.seed,
        });
        if found.failed > 0 {
            outcome.warnings.push(format!(
                "{} of {} refits of the bootstrap failed; its intervals are optimistic",
                found.failed, settings.bootstrap
            ));
        }
        Ok(())
    }

    /// Fits the factors by the nine steps of the paper.
    ///
    /// # Errors
    /// For training poses that the data do not have, weights that do not match them, and a fit that is impossible.
    pub fn fit_as_paper(&self, settings: &PaperFitSettings) -> Result<PaperFit, Failure> {
        let poses = self.training(settings.train.as_deref())?;
        let poses = poses.unwrap_or_else(|| {
            let mut poses: Vec<PoseId> = Vec::new();
            for cell in &self.measured.cells {
                if !poses.contains(&cell.cell.pose) {
                    poses.push(cell.cell.pose.clone());
                }
            }
            poses
        });
        let weights = settings.weights.clone();
        let weights = weights.unwrap_or_else(|| vec![1.0; poses.len()]);
        if weights.len() != poses.len() {
            return ArgumentError::refuse(
                "--weights",
                format!(
                    "{} weights for {} training poses",
                    weights.len(),
                    poses.len()
                ),
                "give one weight per pose, in the order of --train",
            );
        }
        let source = match (&settings.reference, self.model.robot.factors.get("s_fsd")) {
            (Some(reference), _) => PaperSource::Reference(reference.clone()),
            (None, Some(factors)) => PaperSource::Given("s_fsd".to_owned(), factors.clone()),
            (None, None) => PaperSource::Given("unit".to_owned(), FittingFactors::UNIT),
        };
        let options = PaperOptions {
            poses: poses.into_iter().zip(weights).collect(),
            source,
            trials: MonteCarloSettings {
                seed: settings.seed,
                ..MonteCarloSettings::default()
            },
        };
        Ok(follow_paper(
            &self.model.robot,
            self.model.mechanism()?,
            &self.measured,
            self.physics.as_ref(),
            &options,
        )?)
    }

    /// The training poses by name, each of which the data must have, and which is named once.
    fn training(&self, names: Option<&[String]>) -> Result<Option<Vec<PoseId>>, ArgumentError> {
        let Some(names) = names else { return Ok(None) };
        let of_cases = self.posed.iter().flat_map(|data| &data.posed.labels);
        let of_cells = self.measured.cells.iter().map(|cell| &cell.cell.pose);
        let unusable = self.measured.unusable.iter().map(|(cell, _)| &cell.pose);
        let mut known: Vec<&str> = Vec::new();
        for pose in of_cases.chain(of_cells).chain(unusable) {
            if !known.contains(&pose.as_str()) {
                known.push(pose.as_str());
            }
        }
        let wrong = |name: &str, problem: String, help| ArgumentError {
            argument: format!("--train {name}"),
            problem,
            help,
        };
        for (place, name) in names.iter().enumerate() {
            if !known.contains(&name.as_str()) {
                let problem = format!("the data have no such pose; they have {}", known.join(", "));
                let help = nearest(name, known.iter().copied());
                let help = help.map(|near| format!("did you mean {near}?"));
                return Err(wrong(name, problem, help));
            }
            if names[..place].contains(name) {
                return Err(wrong(name, "it is named twice".to_owned(), None));
            }
        }
        Ok(Some(names.iter().map(|name| PoseId::new(name)).collect()))
    }
}

/// The readings of a session reduced to stiffness.
struct ReducedSession {
    measured: MeasuredStiffness,
    table: StiffnessTable,
    /// The slopes that the stiffness is from, if it is not from the table.
    slopes: Option<Arc<CellSlopes>>,
    /// What a user should know of it.
    warnings: Vec<String>,
}

fn reduced(session: &LoadedSession, method: Method) -> Result<ReducedSession, Failure> {
    let table = session.stiffness(Branches::LoadingOnly)?;
    // Without repeats the noise of the readings of one gauge is not known.
    let has_slopes = table.run_slope.is_some() || !session.table.is_of_one_gauge();
    let by_readings = has_slopes && method == Method::Regression;
    let observations = || Observations::new(&session.table, session.header.as_ref());
    let slopes = by_readings.then(|| CellSlopes::new(observations()));
    let slopes = slopes.flatten().map(Arc::new);
    let measured = match &slopes {
        Some(slopes) => MeasuredStiffness::from_slopes(&table, slopes),
        None => MeasuredStiffness::from_table(&table, method),
    };
    let mut warnings = session.warnings.clone();
    let unusable = measured.unusable.iter();
    warnings.extend(
        unusable.map(|(cell, reason)| format!("{cell} takes no part in the fit: {reason}")),
    );
    warnings.extend(doubts_about_stiffness(&table));
    let flags: usize = table.cells.iter().map(|cell| cell.flags.len()).sum();
    if flags > 0 {
        warnings.push(format!(
            "{} on the readings; `stiffbench stiffness` prints them. Nothing was removed.",
            counted(flags, "flag")
        ));
    }
    Ok(ReducedSession {
        measured,
        table,
        slopes,
        warnings,
    })
}

/// The physics beside the beams for a fit or prediction by `method`, if there is any.
#[must_use]
pub fn fixed_physics(model: &ResolvedModel, method: Method) -> Option<FixedPhysics> {
    let acting = Some(&model.physics).filter(|acting| !acting.effects.is_empty())?;
    Some(FixedPhysics::new(acting.clone(), method))
}
