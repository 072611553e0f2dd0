//! What a change of the robot does to the distribution of its stiffness: derivatives of the least and of the mean stiffness to sections and
//! joints.
//!
//! All derivatives are exact ([`gradients`]): section constants are multiplied by factors, and rigid joints are springs without compliance.

use rayon::prelude::*;

use crate::distribution::map::{MapModel, StiffnessMap, gradients};
use crate::distribution::pose_set::PoseSample;
use stiffbench_beams::robot::{Joint, JointModel, ModelParameter, RobotError};
use stiffbench_beams::structure::Property;

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
    let stiffness = |row: &usize| map.stiffness_n_per_m(*row, column);
    let of_mean: f64 = rows.iter().map(stiffness).sum();
    rows.push(least);
    let (robot, mechanism) = (model.robot(), model.mechanism());
    let is_used = |section: usize| {
        let mut members = mechanism.members.iter();
        members.any(|&member| robot.members[member].section == section)
    };
    let sections = robot.sections.keys().enumerate();
    let sections = sections.filter(|(place, _)| is_used(*place));
    let sections: Vec<&String> = sections.map(|(_, name)| name).collect();
    let constants = sections.iter().flat_map(|section| {
        Property::ALL.map(|one| ModelParameter::Section(section.as_str().into(), one))
    });
    let joints = match joints {
        JointModel::Rigid => mechanism.joints(robot),
        JointModel::Pinned | JointModel::Hinged(_) => Vec::new(),
    };
    let joints = joints.iter().map(|&joint| &robot.joints[joint]);
    let spring = |joint: &Joint| ModelParameter::of_joint(&joint.name, joint.motion);
    let springs = joints.clone().map(spring);
    let parameters: Vec<ModelParameter> = constants.chain(springs).collect();
    let along = [map.columns[column].clone()];
    let of_chunk = |rows: &[usize]| gradients(model, map, poses, &along, &parameters, rows);
    let chunks: Result<Vec<_>, RobotError> = rows.par_chunks(CHUNK).map(of_chunk).collect();
    let found = chunks?.into_iter().flatten();
    let mut found: Vec<Vec<f64>> = found.flatten().collect();
    // Of logarithms.
    let smallest_n_per_m = stiffness(&least);
    let mut smallest = found.pop().unwrap_or_default();
    let mut mean = vec![0.0; parameters.len()];
    for (place, (smallest, mean)) in smallest.iter_mut().zip(&mut mean).enumerate() {
        *smallest /= smallest_n_per_m;
        // Nothing has no sign.
        *mean = found.iter().map(|slopes| slopes[place]).sum::<f64>() / of_mean + 0.0;
    }
    let by_section = smallest.as_chunks().0.iter().zip(mean.as_chunks().0);
    let by_joint = smallest.iter().zip(&mean).skip(4 * sections.len());
    Ok(Some(DesignSensitivity {
        axis,
        smallest_n_per_m,
        mean_n_per_m: map.column(column).sum::<f64>() / map.len() as f64,
        poses_of_mean: found.len(),
        sections: sections
            .iter()
            .zip(by_section)
            .map(|(section, (smallest, &mean))| SectionSensitivity {
                section: (*section).clone(),
                smallest: smallest.map(|slope| slope + 0.0),
                mean,
            })
            .collect(),
        joints: joints
            .zip(by_joint)
            .map(|(joint, (&smallest, &mean))| JointSensitivity {
                joint: joint.name.clone(),
                smallest,
                mean,
            })
            .collect(),
    }))
}
