//! What a change of the robot does to the distribution of its stiffness: derivatives of the least and of the mean stiffness to sections and
//! joints.
//!
//! All derivatives are exact: of a compliance to the section constants of an element, -uᵀ ∂K/∂ln p u, added up by section; to the
//! compliance of a joint, the square of the moment that a unit force at the end sends through it.

use rayon::prelude::*;

use crate::distribution::map::{MapModel, StiffnessMap};
use crate::distribution::pose_set::PoseSample;
use stiffbench_beams::robot::{
    JointModel, Mechanism, MechanismModel, Pose, Predictor, Robot, RobotError, Theory,
};
use stiffbench_beams::structure::{RotationInfluence, Solver};

/// Poses that a thread takes at a time.
const CHUNK: usize = 128;
/// Derivatives of a mean are taken from this many poses at most, evenly chosen among all: their scatter is then below a few percent of
/// themselves.
const POSES_OF_A_MEAN: usize = 4_000;

/// What moves the stiffness along an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignSensitivity {
    /// The axis: 0 is x.
    pub axis: usize,
    /// Least stiffness over the poses, N/m.
    pub smallest_n_per_m: f64,
    /// Mean stiffness, N/m.
    pub mean_n_per_m: f64,
    /// Poses behind the derivatives of the mean.
    pub poses_of_mean: usize,
    /// The sections of the mechanism.
    pub sections: Vec<SectionSensitivity>,
    /// Its joints; empty where joints yield already.
    pub joints: Vec<JointSensitivity>,
}

/// Relative change of a stiffness per relative change of the constants of a section, order A, Iy, Iz, J.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionSensitivity {
    /// Its name.
    pub section: String,
    /// Of the least stiffness.
    pub smallest: [f64; 4],
    /// Of the mean.
    pub mean: [f64; 4],
}

/// Relative loss of a stiffness per compliance of a joint that was rigid, N·m/rad.
#[derive(Debug, Clone, PartialEq)]
pub struct JointSensitivity {
    /// Its name.
    pub joint: String,
    /// Of the least stiffness.
    pub smallest: f64,
    /// Of the mean.
    pub mean: f64,
}

/// Indices of the sections that the members of a mechanism have, in the order of the file.
fn sections_of(robot: &Robot, mechanism: &Mechanism) -> Vec<usize> {
    let is_used = |section: &usize| {
        let mut members = mechanism.members.iter();
        members.any(|&member| robot.members[member].section == *section)
    };
    (0..robot.sections.len()).filter(is_used).collect()
}

/// Derivatives of ln K along an axis in poses to ln A, ln Iy, ln Iz, ln J of each section, in the order of [`sections_of`]; joints must be
/// linear.
fn log_gradients(
    model: &MapModel<'_>,
    joints: &JointModel,
    poses: &[Pose],
    axis: usize,
) -> Result<Vec<Vec<f64>>, RobotError> {
    let (robot, mechanism) = (model.robot(), model.mechanism());
    let sections = sections_of(robot, mechanism);
    let places: Vec<usize> = mechanism
        .members
        .iter()
        .filter_map(|&member| {
            let of_member = robot.members[member].section;
            sections.iter().position(|section| *section == of_member)
        })
        .collect();
    let of_chunk = |poses: &[Pose]| -> Result<Vec<Vec<f64>>, RobotError> {
        let theory = Theory::EulerBernoulli;
        let mut predictor = Predictor::with(robot, mechanism, joints, theory, model.factors())?;
        let mut by_element = vec![[0.0; 4]; places.len()];
        let mut found = Vec::with_capacity(poses.len());
        for pose in poses {
            predictor.place(pose)?;
            let compliance = predictor.translation_compliance()[axis][axis];
            predictor.compliance_gradient(axis, &mut by_element);
            let structure = predictor.model().structure();
            let end_m = structure.nodes[structure.end.node].position_m;
            let whole = compliance + model.rocking_m_per_n(end_m, axis);
            let mut gradient = vec![0.0; 4 * sections.len()];
            for (slopes, &place) in by_element.iter().zip(&places) {
                for (sum, slope) in gradient[4 * place..].iter_mut().zip(slopes) {
                    *sum -= slope / whole;
                }
            }
            found.push(gradient);
        }
        Ok(found)
    };
    let chunks: Result<Vec<_>, RobotError> = poses.par_chunks(CHUNK).map(of_chunk).collect();
    Ok(chunks?.into_iter().flatten().collect())
}

/// Derivative of ln K along an axis to the compliance of each rigid joint of the mechanism in a pose, N·m/rad: minus K times the square
/// of the moment per unit force.
fn joint_gradients(
    model: &MapModel<'_>,
    poses: &[Pose],
    axis: usize,
) -> Result<Vec<Vec<f64>>, RobotError> {
    let (robot, mechanism) = (model.robot(), model.mechanism());
    let joints = mechanism.joints(robot);
    let all = JointModel::Hinged(joints.iter().map(|&joint| (joint, 0.0)).collect());
    let theory = Theory::EulerBernoulli;
    let of_chunk = |poses: &[Pose]| -> Result<Vec<Vec<f64>>, RobotError> {
        let of = |joints: &JointModel| {
            MechanismModel::new(robot, mechanism, joints, theory, model.factors())
        };
        let (mut rigid, mut hinged) = (of(&JointModel::Rigid)?, of(&all)?);
        let wrap = |source| RobotError::Structure {
            mechanism: mechanism.name.clone(),
            source,
        };
        let mut solver = Solver::new(rigid.structure()).map_err(wrap)?;
        let mut influence = RotationInfluence::default();
        let mut found = Vec::with_capacity(poses.len());
        for pose in poses {
            rigid.place(pose)?;
            hinged.place(pose)?;
            solver.update(rigid.structure()).map_err(wrap)?;
            let compliance = solver.end_translation_compliance()[axis][axis];
            let solved = solver.rotation_influence(hinged.structure(), &mut influence);
            solved.map_err(wrap)?;
            let structure = rigid.structure();
            let end_m = structure.nodes[structure.end.node].position_m;
            let whole = compliance + model.rocking_m_per_n(end_m, axis);
            let levers = influence.levers.iter();
            found.push(
                levers
                    .map(|lever| -lever[axis] * lever[axis] / whole)
                    .collect(),
            );
        }
        Ok(found)
    };
    let chunks: Result<Vec<_>, RobotError> = poses.par_chunks(CHUNK).map(of_chunk).collect();
    Ok(chunks?.into_iter().flatten().collect())
}

/// Gradient of the logarithm of a mean from those of its terms: their mean, weighted with the terms. Gradients beyond the values are left
/// out.
fn of_mean(gradients: &[Vec<f64>], values: &[f64]) -> Vec<f64> {
    let sum: f64 = values.iter().sum();
    let mut mean = vec![0.0; gradients.first().map_or(0, Vec::len)];
    for (gradient, value) in gradients.iter().zip(values) {
        for (mean, slope) in mean.iter_mut().zip(gradient) {
            *mean += slope * value / sum;
        }
    }
    mean
}

/// What moves the least and the mean stiffness along an axis; `None` for a map without rows or without this axis.
///
/// # Errors
/// [`RobotError`] if the model cannot be built.
pub fn design_sensitivity(
    model: &MapModel<'_>,
    map: &StiffnessMap,
    poses: &PoseSample,
    axis: usize,
) -> Result<Option<DesignSensitivity>, RobotError> {
    let column = map
        .columns
        .iter()
        .position(|column| column.axis() == Some(axis));
    let (Some(column), Some(joints)) = (column, model.joints()) else {
        return Ok(None);
    };
    let all = map.column(column).enumerate();
    let Some((least, _)) = all.min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Ok(None);
    };
    let step = map.len().div_ceil(POSES_OF_A_MEAN).max(1);
    let mut rows: Vec<usize> = (0..map.len()).step_by(step).collect();
    let values: Vec<f64> = rows
        .iter()
        .map(|&row| map.stiffness_n_per_m(row, column))
        .collect();
    rows.push(least);
    let taken = rows.iter();
    let taken = taken.map(|&row| poses.pose(map.places[row] as usize));
    let taken: Vec<Pose> = taken.collect();
    let least_and_mean = |gradients: Vec<Vec<f64>>| {
        let mean = of_mean(&gradients, &values);
        (gradients.last().cloned().unwrap_or_default(), mean)
    };
    let (robot, mechanism) = (model.robot(), model.mechanism());
    let names: Vec<&String> = robot.sections.keys().collect();
    let (smallest, mean) = least_and_mean(log_gradients(model, joints, &taken, axis)?);
    let (smallest, mean) = (smallest.as_chunks().0, mean.as_chunks().0);
    let sections = sections_of(robot, mechanism).into_iter();
    let sections = sections.zip(smallest.iter().zip(mean));
    let sections = sections.map(|(section, (&smallest, &mean))| SectionSensitivity {
        section: names[section].clone(),
        smallest,
        mean,
    });
    let joints = match joints {
        JointModel::Rigid => {
            let (smallest, mean) = least_and_mean(joint_gradients(model, &taken, axis)?);
            let joints = mechanism.joints(robot).into_iter();
            let joints = joints.zip(smallest.into_iter().zip(mean));
            let named = joints.map(|(joint, (smallest, mean))| JointSensitivity {
                joint: robot.joints[joint].name.clone(),
                smallest,
                mean,
            });
            named.collect()
        }
        JointModel::Pinned | JointModel::Hinged(_) => Vec::new(),
    };
    Ok(Some(DesignSensitivity {
        axis,
        smallest_n_per_m: map.stiffness_n_per_m(least, column),
        mean_n_per_m: map.column(column).sum::<f64>() / map.len() as f64,
        poses_of_mean: values.len(),
        sections: sections.collect(),
        joints,
    }))
}
