//! `stiffbench fit`.

use crate::fit::{
    FactorStatus, FitOptions, FitOutcome, FitProblem, FixedPhysics, MeasuredStiffness,
    MonteCarloSettings, PaperOptions, PaperSource, bootstrap_cells, find_lower_minimum, fit_cells,
    follow_paper,
};
use crate::least_squares::{BootstrapSettings, SearchSettings, SigmaMode};
use crate::nearest::nearest;
use crate::report::{fit_figures, fit_json, fit_text, paper_steps_json, paper_steps_text};
use crate::stiffness::{Branches, Method as StiffnessMethod, StiffnessTable};
use crate::test_point::PoseId;

use super::args::{FitArgs, Global, Method, ModelArgs, Sigma};
use super::data::{Data, Session, is_shipped_list, load, load_measured};
use super::failure::{CliError, Failure};
use super::figure_files::{write, write_figure};
use super::inputs::Inputs;
use super::outcome::Outcome;
use super::plausible;
use super::progress::progress;
use super::resolve::{ResolvedModel, no_robot, resolve};

/// Data ready to be fitted.
pub(super) struct Prepared {
    /// Robot, mechanism, factors.
    pub(super) chosen: ResolvedModel,
    /// Stiffness of the cells.
    pub(super) measured: MeasuredStiffness,
    /// What acts beside the beams.
    pub(super) physics: Option<FixedPhysics>,
    /// The readings behind it, if there are any.
    pub(super) session: Option<(Box<Session>, StiffnessTable)>,
    /// Notes.
    pub(super) warnings: Vec<String>,
    /// Data, robot, mechanism and factors.
    pub(super) inputs: Inputs,
}

impl Prepared {
    /// The training poses, each of which the data must have.
    pub(super) fn training(
        &self,
        names: Option<&[String]>,
    ) -> Result<Option<Vec<PoseId>>, CliError> {
        let Some(names) = names else { return Ok(None) };
        let measured = self.measured.cells.iter().map(|cell| &cell.cell);
        let unusable = self.measured.unusable.iter().map(|(cell, _)| cell);
        let mut known: Vec<&str> = Vec::new();
        for cell in measured.chain(unusable) {
            if !known.contains(&cell.pose.as_str()) {
                known.push(cell.pose.as_str());
            }
        }
        let wrong = |name: &str, problem: String, help| CliError::Argument {
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

    /// The problem of a fit to all cells.
    pub(super) fn problem(&self) -> Result<FitProblem<'_>, Failure> {
        Ok(FitProblem {
            robot: &self.chosen.robot,
            mechanism: self.chosen.robot.mechanism(Some(&self.chosen.mechanism))?,
            measured: &self.measured,
            start: &self.chosen.factors,
            physics: self.physics.as_ref(),
        })
    }
}

/// Fits and reports.
pub(super) fn run(args: &FitArgs, global: &Global) -> Result<Outcome, Failure> {
    let method = match args.method {
        Method::LeastSquares => StiffnessMethod::Regression,
        Method::Paper => StiffnessMethod::PaperMean,
    };
    refuse_what_the_method_ignores(args)?;
    let prepared = prepare(load(&args.data, global)?, &args.model, method)?;
    let fitted = match args.method {
        Method::LeastSquares => least_squares(args, &prepared, global).map(|outcome| {
            let (text, data) = (fit_text(&outcome), fit_json(&outcome));
            (outcome, text, data)
        }),
        Method::Paper => paper(args, &prepared, global),
    };
    let (outcome, text, data) =
        fitted.map_err(|failure| failure.with_warnings(&prepared.warnings))?;
    let mut warnings = prepared.warnings;
    warnings.extend(plausible::of_fit(&outcome));
    // The text has them already.
    if global.json {
        warnings.extend(outcome.warnings.iter().cloned());
    }
    let mut written = Vec::new();
    if let Some(file) = &args.save_factors {
        write(file, outcome.factors.to_toml().as_bytes())?;
        written.push(file.clone());
    }
    if let Some(folder) = &args.figures {
        let table = prepared.session.as_ref().map(|(_, table)| table);
        let figures = fit_figures(
            &outcome,
            table,
            args.parameters.choice(&prepared.chosen)?.range,
        );
        written.extend(write_figure(
            &folder.join("stiffness"),
            &figures.comparison,
            &prepared.inputs,
        )?);
        written.extend(write_figure(
            &folder.join("factors"),
            &figures.factors,
            &prepared.inputs,
        )?);
        if let Some(correlation) = &figures.correlation {
            written.extend(write_figure(
                &folder.join("correlation"),
                correlation,
                &prepared.inputs,
            )?);
        }
    }
    warnings.extend(
        written
            .iter()
            .map(|path| format!("wrote {}", path.display())),
    );
    let open = outcome.estimates.iter().any(|e| {
        matches!(
            e.status,
            FactorStatus::AtBound { .. } | FactorStatus::NotIdentified { .. }
        )
    });
    Ok(Outcome::new("fit", text, data)
        .with_inputs(prepared.inputs)
        .with_warnings(warnings)
        .with_strict_exit(if open { 41 } else { 0 }))
}

/// Robot and stiffness from data.
pub(super) fn prepare(
    data: Data,
    model: &ModelArgs,
    method: StiffnessMethod,
) -> Result<Prepared, Failure> {
    match data {
        Data::Stiffness {
            measured,
            name,
            sha256,
        } => {
            if model.robot.is_none() && model.model.is_none() && !is_shipped_list(&name) {
                return Err(no_robot().into());
            }
            let chosen = resolve(model, None)?;
            for cell in &measured.cells {
                chosen.robot.pose(&cell.cell.pose)?;
            }
            let mut warnings = vec![format!(
                "{name} holds stiffness values without readings: what only readings show cannot be tested"
            )];
            let physics = fixed_physics(&chosen, method);
            if physics.is_some() {
                warnings.push("without readings the loads behind the stiffness values are not known: laws that are not linear act as under the paper's, 10 to 70 N".to_owned());
            }
            Ok(Prepared {
                inputs: Inputs::default()
                    .with_list(&name, &sha256)
                    .with_model(&chosen),
                chosen,
                measured,
                physics,
                session: None,
                warnings,
            })
        }
        Data::Readings(mut session) => {
            let chosen = resolve(model, Some(&mut session))?;
            let table = session.stiffness(Branches::LoadingOnly)?;
            let measured = MeasuredStiffness::from_table(&table, method);
            let mut warnings = session.warnings.clone();
            warnings.extend(
                measured
                    .unusable
                    .iter()
                    .map(|(cell, reason)| format!("{cell} takes no part in the fit: {reason}")),
            );
            warnings.extend(plausible::of_stiffness(&table));
            let flags: usize = table.cells.iter().map(|cell| cell.flags.len()).sum();
            if flags > 0 {
                warnings.push(format!("{flags} flag(s) on the readings; `stiffbench stiffness` prints them. Nothing was removed."));
            }
            let physics = fixed_physics(&chosen, method)
                .map(|physics| physics.under(&session.table, session.header.as_ref()));
            Ok(Prepared {
                inputs: Inputs::default().with_session(&session).with_model(&chosen),
                chosen,
                measured,
                physics,
                session: Some((session, table)),
                warnings,
            })
        }
    }
}

/// The physics beside the beams for a fit, if there is any.
pub(super) fn fixed_physics(
    chosen: &ResolvedModel,
    method: StiffnessMethod,
) -> Option<FixedPhysics> {
    let acting = Some(&chosen.physics).filter(|acting| !acting.effects.is_empty())?;
    Some(FixedPhysics::new(acting.clone(), method))
}

/// Options without effect are a misunderstanding, and worth an error.
fn refuse_what_the_method_ignores(args: &FitArgs) -> Result<(), CliError> {
    let of_paper = [
        ("--weights", args.weights.is_some()),
        ("--reference", args.reference.is_some()),
    ];
    let of_least_squares = [
        ("--free", !args.parameters.free.is_empty()),
        ("--fix", !args.parameters.fix.is_empty()),
        ("--tie", !args.parameters.tie.is_empty()),
        ("--bounds", !args.parameters.bounds.is_empty()),
        ("--sigma", args.sigma.is_some()),
        ("--bootstrap", args.bootstrap > 0),
        ("--global-search", args.global_search),
    ];
    let (ignored, method): (&[(&str, bool)], _) = match args.method {
        Method::LeastSquares => (&of_paper, "paper"),
        Method::Paper => (&of_least_squares, "least-squares"),
    };
    match ignored.iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((option, _)) => Err(CliError::Argument {
            argument: (*option).to_owned(),
            problem: format!("it belongs to --method {method}"),
            help: Some(format!("add --method {method}, or leave {option} out")),
        }),
    }
}

fn least_squares(
    args: &FitArgs,
    prepared: &Prepared,
    global: &Global,
) -> Result<FitOutcome, Failure> {
    let problem = prepared.problem()?;
    let options = FitOptions {
        train: prepared.training(args.train.as_deref())?,
        choice: args.parameters.choice(&prepared.chosen)?,
        sigma: args.sigma.map(|sigma| match sigma {
            Sigma::Known => SigmaMode::Known,
            Sigma::Estimated => SigmaMode::Estimated,
        }),
    };
    if args.sigma == Some(Sigma::Known) && !problem.measured.has_uncertainties() {
        return Err(CliError::Argument {
            argument: "--sigma known".to_owned(),
            problem: "the data state no uncertainty of the stiffnesses".to_owned(),
            help: Some(
                "give readings with repeats or a column u_N_per_um, or use --sigma estimated"
                    .to_owned(),
            ),
        }
        .into());
    }
    let mut outcome = fit_cells(&problem, &options)?;
    let in_training = |pose: &PoseId| {
        options
            .train
            .as_ref()
            .is_none_or(|train| train.contains(pose))
    };
    let training = problem.measured.select(|cell| in_training(&cell.pose));
    let trained = FitProblem {
        measured: &training,
        ..problem
    };
    if args.bootstrap > 0 {
        let Some((_, table)) = &prepared.session else {
            return Err(CliError::NeedsReadings {
                data: args.data.display().to_string(),
                needs: "--bootstrap",
            }
            .into());
        };
        let settings = BootstrapSettings {
            replicates: args.bootstrap,
            seed: args.seed,
        };
        let bar = progress(global, "refits", args.bootstrap as u64);
        let done = || bar.inc(1);
        let fitted = &outcome.factors;
        let found = bootstrap_cells(&trained, fitted, table, &options.choice, &settings, &done)?;
        bar.finish_and_clear();
        for (estimate, interval) in outcome.estimates.iter_mut().zip(found.intervals_95) {
            let holds = |[lower, upper]: &[f64; 2]| (*lower..=*upper).contains(&estimate.value);
            estimate.bootstrap_interval_95 = interval.filter(holds);
            if let Some([lower, upper]) = interval.filter(|interval| !holds(interval)) {
                outcome.warnings.push(format!(
                    "{}: refits to runs drawn again lie from {lower:.4} to {upper:.4}, which does not hold the estimate {:.4}: no bootstrap interval is given",
                    estimate.name, estimate.value
                ));
            }
        }
        if found.failed > 0 {
            outcome.warnings.push(format!(
                "{} of {} refits of the bootstrap failed; its intervals are optimistic",
                found.failed, args.bootstrap
            ));
        }
    }
    if args.global_search {
        let settings = SearchSettings {
            seed: args.seed,
            ..SearchSettings::default()
        };
        let lower = find_lower_minimum(&trained, &options.choice, &settings)?;
        outcome.warnings.push(match lower {
            Some(factors) => format!(
                "a better fit exists: {}",
                factors.to_toml().replace('\n', " ")
            ),
            None => "swarm and simplex found no better fit within the bounds".to_owned(),
        });
    }
    Ok(outcome)
}

fn paper(
    args: &FitArgs,
    prepared: &Prepared,
    global: &Global,
) -> Result<(FitOutcome, String, serde_json::Value), Failure> {
    let Prepared {
        chosen, measured, ..
    } = prepared;
    let mechanism = chosen.robot.mechanism(Some(&chosen.mechanism))?;
    let poses = prepared
        .training(args.train.as_deref())?
        .unwrap_or_else(|| {
            let mut poses: Vec<PoseId> = Vec::new();
            for cell in &measured.cells {
                if !poses.contains(&cell.cell.pose) {
                    poses.push(cell.cell.pose.clone());
                }
            }
            poses
        });
    let weights = args
        .weights
        .clone()
        .unwrap_or_else(|| vec![1.0; poses.len()]);
    if weights.len() != poses.len() {
        return Err(CliError::Argument {
            argument: "--weights".to_owned(),
            problem: format!(
                "{} weights for {} training poses",
                weights.len(),
                poses.len()
            ),
            help: Some("give one weight a pose, in the order of --train".to_owned()),
        }
        .into());
    }
    let source = match &args.reference {
        Some(path) => PaperSource::Reference(load_measured(path, global)?),
        None => match chosen.robot.factors.get("s_fsd") {
            Some(factors) => PaperSource::Given("s_fsd".to_owned(), factors.clone()),
            None => PaperSource::Given("unit".to_owned(), crate::robot::FittingFactors::UNIT),
        },
    };
    let options = PaperOptions {
        poses: poses.into_iter().zip(weights).collect(),
        source,
        trials: MonteCarloSettings {
            seed: args.seed,
            ..MonteCarloSettings::default()
        },
    };
    let fit = follow_paper(
        &chosen.robot,
        mechanism,
        measured,
        prepared.physics.as_ref(),
        &options,
    )?;
    let text = paper_steps_text(&fit) + &fit_text(&fit.outcome);
    let mut data = fit_json(&fit.outcome);
    data["steps"] = paper_steps_json(&fit);
    Ok((fit.outcome, text, data))
}
