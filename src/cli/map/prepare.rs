//! From the arguments to a study.

use crate::analysis::{ArgumentError, ResolvedModel, UnknownSprings};
use crate::cli::args::ModelArgs;
use crate::cli::failure::Failure;
use crate::distribution::{MapColumn, MapPlane, PlaneAxis, variables_beside_the_plane};
use crate::physics::{ActingPhysics, Effect, EffectError};
use crate::robot::{Pose, Robot};

use super::args::StudyArgs;
use super::fit_file::{FitFile, read_fit};
use super::job::{MapJob, MechanismJob, SCHEMA, plane_of};

/// The study that the arguments ask for, and what a user should know of it.
pub(super) fn prepare(args: &StudyArgs) -> Result<(MapJob, Vec<String>), Failure> {
    let fit = args.fit.as_deref().map(read_fit).transpose()?;
    // The effects are put into each mechanism below: the choice is to find robot, factors and the model's mechanism only.
    let bare = ModelArgs {
        robot: args.robot.clone(),
        factors: args.factors.clone(),
        model: args.model.clone(),
        ..ModelArgs::default()
    };
    let resolved = bare.resolve()?;
    let mut effects = resolved.physics.effects.clone();
    for text in &args.effects {
        effects.push(text.parse()?);
    }
    let mut warnings = resolved.warnings.clone();
    let robot = &resolved.robot;
    let names = mechanisms(args, robot, &resolved)?;
    let fit = fit.unwrap_or_else(|| FitFile {
        factors_name: resolved.factors_name.clone(),
        factors: resolved.factors.clone(),
        ..FitFile::default()
    });
    warnings.extend(fit.warnings);
    warnings.extend(fit.notes);
    robot.check_parameters(&fit.factors)?;
    // A sweep takes springs as it takes every other physics beside the beams.
    effects.extend(Effect::of_springs(&fit.factors));
    for name in &names {
        let mechanism = robot.mechanism(Some(name))?;
        let unknown = UnknownSprings::new(robot, mechanism, &fit.factors, &effects);
        for pose in poses_of(robot) {
            unknown.refuse(&pose)?;
        }
        warnings.extend(unknown.words());
    }
    let factors = fit.factors.without_springs();
    let mechanisms = with_effects(robot, &names, &effects, &mut warnings)?;
    let linear = !effects.iter().any(|effect| effect.law.is_nonlinear_joint());
    let plane = plane(args, robot);
    let mut held = held_variables(args, robot, plane)?;
    held.sort();
    let job = MapJob {
        schema: SCHEMA.to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        robot_file: resolved.source.name.clone(),
        robot_text: resolved.source.text.clone(),
        factors_name: fit.factors_name,
        factors,
        covariance: fit.covariance,
        at_load_n: args.at_load,
        mechanisms,
        sampling: args.sampling,
        poses: args.poses,
        seed: args.seed,
        held,
        columns: columns(args, linear),
        plane,
        matrix: args.matrix,
    };
    warnings.extend(notes_on_laws(args, &job, linear));
    Ok((job, warnings))
}

/// The named poses and the nominal one.
fn poses_of(robot: &Robot) -> impl Iterator<Item = Pose> + '_ {
    let named = robot.poses.iter().map(|named| named.pose.clone());
    named.chain([robot.nominal_pose()])
}

/// What the laws in the joints make of the options.
fn notes_on_laws(args: &StudyArgs, job: &MapJob, linear: bool) -> Vec<String> {
    let notes = [
        (
            !linear && !args.no_principal,
            "laws that are not linear have no principal stiffnesses: left out",
        ),
        (
            linear && args.at_load.is_some(),
            "--at-load: every law is linear, and the load changes nothing",
        ),
        (
            !linear && job.covariance.is_some(),
            "the uncertainty of the fit is carried through linear laws only: left out",
        ),
        (
            job.covariance.is_some() && job.columns.iter().any(MapColumn::is_rotational),
            "the uncertainty of the fit is carried to stiffness along directions only, not to rotational stiffness",
        ),
    ];
    let notes = notes.into_iter().filter(|(applies, _)| *applies);
    notes.map(|(_, note)| note.to_owned()).collect()
}

/// The mechanisms to study, each once.
fn mechanisms(
    args: &StudyArgs,
    robot: &Robot,
    resolved: &ResolvedModel,
) -> Result<Vec<String>, Failure> {
    if args.mechanism.is_empty() && args.model.is_some() {
        return Ok(vec![resolved.mechanism.clone()]);
    }
    if args.mechanism.is_empty() || args.mechanism == ["all"] {
        return Ok(robot.mechanisms.keys().cloned().collect());
    }
    let mut names: Vec<String> = Vec::new();
    for name in &args.mechanism {
        robot.mechanism(Some(name))?;
        if names.contains(name) {
            return ArgumentError::refuse(
                format!("--mechanisms {name}"),
                "it is named twice".to_owned(),
                "name each mechanism once, for example --mechanisms A,F",
            );
        }
        names.push(name.clone());
    }
    Ok(names)
}

/// The effects of each mechanism: those of the bench in none, and those whose joint or element it lacks not in it.
fn with_effects(
    robot: &Robot,
    names: &[String],
    effects: &[Effect],
    warnings: &mut Vec<String>,
) -> Result<Vec<MechanismJob>, Failure> {
    let mut jobs: Vec<MechanismJob> = names
        .iter()
        .map(|name| MechanismJob {
            name: name.clone(),
            effects: Vec::new(),
        })
        .collect();
    for effect in effects {
        if !effect.law.place_kind.is_of_robot() {
            warnings.push(format!(
                "{effect}: of the bench, not of the robot, and not in its map"
            ));
            continue;
        }
        let mut absent = None;
        let mut lacking = Vec::new();
        for job in &mut jobs {
            let mechanism = robot.mechanism(Some(&job.name))?;
            match ActingPhysics::new(robot, mechanism, vec![effect.clone()]) {
                Ok(_) => job.effects.push(effect.compact()),
                Err(error @ EffectError::Unknown { .. }) => {
                    lacking.push(job.name.clone());
                    absent = Some(error);
                }
                Err(other) => return Err(other.into()),
            }
        }
        match absent {
            Some(error) if lacking.len() == jobs.len() => return Err(error.into()),
            Some(_) => warnings.push(format!(
                "{}: not in mechanism {}, which has no such place",
                effect.title(),
                lacking.join(", ")
            )),
            None => {}
        }
    }
    Ok(jobs)
}

/// The coordinates of the plane; `None` for reach and height, however they were named.
fn plane(args: &StudyArgs, robot: &Robot) -> Option<[PlaneAxis; 2]> {
    let plane = MapPlane::new(args.plane?.0, robot.vertical);
    (!plane.is_upright()).then(|| plane.axes())
}

/// Variables that stay at their nominal value.
fn held_variables(
    args: &StudyArgs,
    robot: &Robot,
    plane: Option<[PlaneAxis; 2]>,
) -> Result<Vec<String>, Failure> {
    let Some(vary) = &args.vary else {
        let (mechanism, plane) = (robot.mechanism(None)?, plane_of(plane, robot));
        return Ok(variables_beside_the_plane(robot, mechanism, &plane)?);
    };
    for name in vary {
        robot.variable(name)?;
    }
    let names = robot.variables.iter().map(|variable| variable.name.clone());
    Ok(names.filter(|name| !vary.contains(name)).collect())
}

/// The columns, each once.
fn columns(args: &StudyArgs, linear: bool) -> Vec<MapColumn> {
    let mut columns: Vec<MapColumn> = Vec::new();
    let asked = args.directions.iter().flat_map(|directions| &directions.0);
    for column in asked {
        let is_same = |known: &MapColumn| {
            known.unit() == column.unit() && known.is_rotational() == column.is_rotational()
        };
        if !columns.iter().any(is_same) {
            columns.push(column.clone());
        }
    }
    if columns.is_empty() {
        columns = MapColumn::axes();
    }
    if linear && !args.no_principal {
        let turns = columns.iter().any(MapColumn::is_rotational);
        columns.extend(MapColumn::principal());
        if turns {
            columns.extend(MapColumn::principal_of_rotation());
        }
    }
    columns
}
