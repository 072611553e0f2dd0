//! `stiffbench plot`.

use std::path::PathBuf;

use crate::analysis::{
    AnalysisError, ArgumentError, Data, FitData, FitSettings, Inputs, LoadedSession,
    UnknownSprings, is_dash,
};
use crate::fit::FitOutcome;
use crate::physics::{Effect, PlaceKind};
use crate::plot::Figure;
use crate::report::{
    FigureReport, Fitted, load_displacement_figure, residuals_figure, robot_figure,
};
use crate::robot::{Predictor, Theory};
use crate::stiffness::{Branches, Method};
use crate::test_point::PoseId;

use super::args::{FigureName, Global, PlotArgs};
use super::failure::Failure;
use super::figure_files::write_figure;
use super::outcome::Outcome;
use super::robot::workspace_projection;

/// Draws one figure.
pub(super) fn run(args: &PlotArgs, global: &Global) -> Result<Outcome, Failure> {
    let mut warnings = Vec::new();
    let (name, figure, inputs) = match args.figure {
        FigureName::LoadDisplacement => overlay(args, global, &mut warnings)?,
        FigureName::Workspace => workspace(args)?,
        FigureName::Robot => robot(args, &mut warnings)?,
        FigureName::Stiffness
        | FigureName::Factors
        | FigureName::Correlation
        | FigureName::Residuals => of_fit(args, global, &mut warnings)?,
    };
    let path = args.out.clone().unwrap_or_else(|| PathBuf::from(name));
    let mut drawing = None;
    let mut written = Vec::new();
    if is_dash(&path) {
        drawing = Some(inputs.on(&figure).to_svg());
    } else {
        written = write_figure(&path, &figure, &inputs)?;
    }
    let names: Vec<String> = written
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    let text = names.join("\n") + "\n";
    Ok(Outcome::new(
        "plot",
        text,
        FigureReport {
            figure: name,
            files: written,
        },
    )
    .with_inputs(inputs)
    .with_warnings(warnings)
    .with_file(drawing))
}

/// A figure with its name and what it shows.
type NamedFigure = (&'static str, Figure, Inputs);

fn first_data(args: &PlotArgs) -> Result<&PathBuf, ArgumentError> {
    args.data.first().ok_or_else(|| {
        ArgumentError::new(
            "DATA",
            "this figure needs measured data",
            "stiffbench plot residuals my-session",
        )
    })
}

fn overlay(
    args: &PlotArgs,
    global: &Global,
    warnings: &mut Vec<String>,
) -> Result<NamedFigure, Failure> {
    first_data(args)?;
    let mut sessions = Vec::new();
    let mut inputs = Inputs::default();
    for path in &args.data {
        let session = LoadedSession::open(path, &global.open_settings())?;
        warnings.extend(session.warnings.iter().cloned());
        inputs = inputs.with_session(&session);
        let table = session.stiffness(Branches::Both)?;
        sessions.push((session.name, table));
    }
    let pairs: Vec<(&str, &crate::stiffness::StiffnessTable)> = sessions
        .iter()
        .map(|(name, table)| (name.as_str(), table))
        .collect();
    Ok((
        "load-displacement",
        load_displacement_figure(&pairs),
        inputs,
    ))
}

fn of_fit(
    args: &PlotArgs,
    global: &Global,
    warnings: &mut Vec<String>,
) -> Result<NamedFigure, Failure> {
    let path = first_data(args)?;
    let data = Data::open(path, &global.open_settings())?;
    if args.figure == FigureName::Residuals && matches!(data, Data::Stiffness { .. }) {
        return Err(AnalysisError::NeedsReadings {
            data: path.display().to_string(),
            needs: "a figure of residuals",
        }
        .into());
    }
    data.refuse_load_cases("a fit of stiffness values")?;
    let prepared = FitData::new(data, &args.model.choice()?, Method::Regression)?;
    warnings.extend(prepared.warnings.iter().cloned());
    let settings = FitSettings {
        train: args.train.clone(),
        ..FitSettings::default()
    };
    let outcome = prepared.fit(&settings, &|| ())?;
    if args.figure == FigureName::Residuals {
        return Ok((
            "residuals",
            residuals(&prepared, &outcome)?,
            prepared.inputs,
        ));
    }
    let figures = Fitted::new(&prepared, &settings, outcome)?.figures;
    let wanted = match args.figure {
        FigureName::Factors => "factors",
        FigureName::Correlation => "correlation",
        _ => "stiffness",
    };
    let found = figures.into_iter().find(|(name, _)| *name == wanted);
    let (name, figure) = found.ok_or_else(|| {
        ArgumentError::new(
            "correlation",
            "the data determine fewer than two factors, so there is no correlation",
            "train on more poses",
        )
    })?;
    Ok((name, figure, prepared.inputs))
}

/// Residuals of the readings behind a fit.
pub(super) fn residuals(prepared: &FitData, outcome: &FitOutcome) -> Result<Figure, Failure> {
    let Some((_, table)) = &prepared.session else {
        return Err(AnalysisError::NeedsReadings {
            data: "the data".to_owned(),
            needs: "a figure of residuals",
        }
        .into());
    };
    Ok(residuals_figure(prepared, outcome, table)?)
}

fn workspace(args: &PlotArgs) -> Result<NamedFigure, Failure> {
    let resolved = args.model.resolve()?;
    let figure = workspace_projection(&resolved.robot, args.samples, args.seed)?;
    let figure = figure.figure(&resolved.robot);
    let inputs = Inputs::default().with_robot(&resolved.robot, &resolved.source.text);
    Ok(("workspace", figure, inputs))
}

fn robot(args: &PlotArgs, warnings: &mut Vec<String>) -> Result<NamedFigure, Failure> {
    let resolved = args.model.resolve()?;
    let (name, pose) = match &args.pose {
        Some(name) => (
            name.clone(),
            resolved.robot.pose(&PoseId::new(name))?.clone(),
        ),
        None => resolved.robot.poses_or_nominal().swap_remove(0),
    };
    let (robot, physics) = (&resolved.robot, &resolved.physics);
    let factors = &physics.with_springs(&resolved.factors);
    let at_rest = |effect: &&Effect| {
        let kind = effect.law.place_kind;
        let is_drawn = matches!(kind, PlaceKind::Joint | PlaceKind::Element)
            || effect.spring_of_structure().is_some();
        !is_drawn
    };
    let not_drawn = physics.effects.iter().filter(at_rest);
    warnings.extend(not_drawn.map(|effect| format!("{effect}: not drawn")));
    if args.load.iter().any(|force| *force != 0.0) {
        UnknownSprings::of(&resolved).refuse(&pose)?;
    }
    let joints = physics.joints_under(robot, factors, &pose, args.load)?;
    let mut predictor = Predictor::with(
        robot,
        &physics.mechanism,
        &joints,
        Theory::EulerBernoulli,
        factors,
    )?;
    predictor.place(&pose)?;
    let figure = robot_figure(&mut predictor, &name, args.load);
    Ok(("robot", figure, Inputs::default().with_model(&resolved)))
}
