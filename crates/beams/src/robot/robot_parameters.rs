//! The parameters that a mechanism of a robot has.

use std::sync::Arc;

use stiffbench_units_and_text::test_point::Direction;

use super::error::RobotError;
use super::model::{Mechanism, Robot};
use super::model_parameter::{ModelParameter, NotAParameter};
use super::spring_axis::{JointMotion, SpringAxis};
use crate::structure::Property;

impl ModelParameter {
    /// Every parameter that a mechanism has: factors of classes, of its sections and groups, springs in its joints, under the base and at
    /// the tool.
    #[must_use]
    pub fn all(robot: &Robot, mechanism: &Mechanism) -> Vec<Self> {
        let members = || {
            mechanism
                .members
                .iter()
                .map(|&member| &robot.members[member])
        };
        let sections = robot.sections.keys().enumerate();
        let sections = sections.filter(|(section, _)| members().any(|m| m.section == *section));
        let of_section = |(_, name): (usize, &String)| {
            let name: Arc<str> = name.as_str().into();
            Property::ALL.map(|property| Self::Section(name.clone(), property))
        };
        let groups = robot.groups();
        let groups = groups
            .into_iter()
            .filter(|group| members().any(|m| m.groups.contains(group)));
        let of_group = |group: Arc<str>| Property::ALL.map(|p| Self::Group(group.clone(), p));
        let joints = mechanism.joints(robot);
        let of_joint =
            |&joint: &usize| Self::of_joint(&robot.joints[joint].name, robot.joints[joint].motion);
        let across = |&joint: &usize| {
            let joint = &robot.joints[joint];
            let name: Arc<str> = joint.name.as_str().into();
            // About its own axis a joint that turns has the parameter above.
            let others = Direction::ALL.into_iter();
            let others = others.skip(usize::from(joint.motion == JointMotion::Turns));
            others.map(move |axis| Self::JointAbout(name.clone(), axis))
        };
        Self::CLASSES
            .into_iter()
            .chain(sections.flat_map(of_section))
            .chain(groups.flat_map(of_group))
            .chain(joints.iter().map(of_joint))
            .chain(joints.iter().flat_map(across))
            .chain(SpringAxis::ALL.map(Self::Base))
            .chain(SpringAxis::ALL.map(Self::Tool))
            .collect()
    }

    /// The parameter of a name such as `beam.Iy`, `section.rod.A`, `group.arm.J`, `joint.J2`, `joint.J2.y`, `base.rx`, `tool.z`.
    ///
    /// `joint.NAME` of a joint that slides is its compliance along the axis, `joint.NAME.x` of one that turns the same as `joint.NAME`.
    ///
    /// # Errors
    /// [`RobotError::NotAParameter`]; [`RobotError::UnknownName`] for a joint, section or group that the mechanism has not.
    pub fn find(robot: &Robot, mechanism: &Mechanism, name: &str) -> Result<Self, RobotError> {
        let parsed = Self::try_from(name.to_owned())?;
        let all = Self::all(robot, mechanism);
        // Names of joints may hold dots.
        if let Some(known) = all.iter().find(|known| known.to_string() == name) {
            return Ok(known.clone());
        }
        let parameter = match parsed {
            Self::Joint(joint) => Self::JointAlong(joint),
            Self::JointAbout(joint, Direction::X) => Self::Joint(joint),
            other => other,
        };
        if all.contains(&parameter) {
            return Ok(parameter);
        }
        Err(match &parameter {
            Self::Joint(joint) | Self::JointAlong(joint) | Self::JointAbout(joint, _) => {
                let known = mechanism.joints(robot).into_iter();
                robot.unknown(
                    "joint",
                    joint,
                    known.map(|joint| robot.joints[joint].name.as_str()),
                )
            }
            Self::Section(section, _) => robot.unknown(
                "section",
                section,
                robot.sections.keys().map(String::as_str),
            ),
            Self::Group(group, _) => {
                let known = robot.groups();
                robot.unknown("group", group, known.iter().map(|known| &**known))
            }
            Self::Class(..) | Self::Base(_) | Self::Tool(_) => NotAParameter {
                text: name.to_owned(),
            }
            .into(),
        })
    }
}
