//! Where the structure of a mechanism yields besides its beams: joints, base and tool as hinges in series.

use stiffbench_units_and_text::test_point::Direction;

use super::kinematics::FixedDirection;
use super::model::Mechanism;
use super::spring_axis::{JointMotion, SpringAxis};
use crate::structure::Hinge;

use super::Robot;
use super::fitting_factors::FittingFactors;
use super::model_parameter::ModelParameter;
use super::springs::{SpringDefault, Yielding};

/// Stiffness that stands for a rigid joint, N·m/rad: far beyond any drive, so that a compliance of zero needs no other structure.
const RIGID_NM_PER_RAD: f64 = 1e30;

/// How joints pass on moments.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum JointModel {
    /// Every joint passes on everything (the paper).
    #[default]
    Rigid,
    /// Every joint turns freely unless a drive or a brake locks it.
    Pinned,
    /// The named joints, by index, turn against a stiffness in N·m/rad (zero is a pin); all others are rigid.
    Hinged(Vec<(usize, f64)>),
}

/// A hinge of the structure: what stands for one freedom of a joint, the base or the tool.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ModelHinge {
    /// Where it stands.
    pub(super) place: HingePlace,
    /// The parameter that is its compliance.
    pub(super) spring: ModelParameter,
    /// Compliance by the robot file, if values do not name it.
    default: f64,
    /// Stiffness in series with the spring, N·m/rad or N/m.
    own_stiffness: f64,
    /// Its axis.
    pub(super) direction: FixedDirection,
    /// The plane whose normal is the axis, of a hinge that turns about it.
    pub(super) plane: Option<usize>,
    pub(super) slides: bool,
}

/// Where a hinge stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum HingePlace {
    /// In a joint of the robot, about its own axis or along it.
    Joint(usize),
    /// In a joint, about another axis.
    JointAcross(usize),
    Base,
    Tool,
}

impl ModelHinge {
    /// Stiffness with given values, N·m/rad or N/m.
    pub(super) fn stiffness(&self, values: &FittingFactors) -> f64 {
        let spring = values.spring(&self.spring).unwrap_or(self.default);
        if spring == 0.0 {
            return self.own_stiffness.min(RIGID_NM_PER_RAD);
        }
        (1.0 / (1.0 / self.own_stiffness + spring)).min(RIGID_NM_PER_RAD)
    }

    /// The hinge, not yet placed.
    pub(super) fn hinge(&self, robot: &Robot, values: &FittingFactors) -> Hinge {
        let name = match self.place {
            HingePlace::Joint(joint) | HingePlace::JointAcross(joint) => {
                robot.joints[joint].name.as_str().into()
            }
            HingePlace::Base | HingePlace::Tool => self.spring.to_string().into(),
        };
        Hinge {
            name,
            axis: [1.0, 0.0, 0.0],
            slides: self.slides,
            stiffness_nm_per_rad: self.stiffness(values),
        }
    }
}

/// The hinges of a mechanism: of joints about their own axis first, then across, then of base and tool.
///
/// One stands where a joint model asks for it, where a spring gives way, and for every spring of `parameters`.
pub(super) fn hinges(
    robot: &Robot,
    mechanism: &Mechanism,
    joints: &JointModel,
    values: &FittingFactors,
    parameters: &[ModelParameter],
) -> Vec<ModelHinge> {
    let yields = |spring: &ModelParameter, own: &SpringDefault| {
        let compliance = values.spring(spring);
        parameters.contains(spring)
            || compliance.is_some_and(|c| c != 0.0)
            || (compliance.is_none() && own.yielding != Yielding::Rigid)
    };
    let existing = mechanism.joints(robot);
    let mut hinges: Vec<ModelHinge> = Vec::new();
    for (joint, own_stiffness) in of_joint_model(robot, mechanism, &existing, joints) {
        hinges.push(own_hinge(robot, joint, own_stiffness));
    }
    for &joint in &existing {
        let hinge = own_hinge(robot, joint, f64::INFINITY);
        let own = &robot.joints[joint].springs.own;
        let is_known = hinges.iter().any(|known| known.place == hinge.place);
        if !is_known && yields(&hinge.spring, own) {
            hinges.push(hinge);
        }
    }
    for &joint in &existing {
        let about = &robot.joints[joint].springs.about;
        for (axis, own) in Direction::ALL.into_iter().zip(about) {
            let hinge = across_hinge(robot, joint, axis, own);
            if yields(&hinge.spring, own) {
                hinges.push(hinge);
            }
        }
    }
    for (axis, own) in SpringAxis::ALL.into_iter().zip(&robot.base) {
        let direction = FixedDirection {
            body: None,
            local: unit(axis),
        };
        let hinge = end_hinge(
            HingePlace::Base,
            ModelParameter::Base(axis),
            axis,
            own,
            direction,
        );
        if yields(&hinge.spring, own) {
            hinges.push(hinge);
        }
    }
    for (axis, own) in SpringAxis::ALL.into_iter().zip(&robot.tool.springs) {
        let direction = FixedDirection {
            body: robot.tool.body,
            local: robot
                .tool
                .axes
                .map_or(unit(axis), |axes| axes[axis.index() % 3]),
        };
        let hinge = end_hinge(
            HingePlace::Tool,
            ModelParameter::Tool(axis),
            axis,
            own,
            direction,
        );
        if yields(&hinge.spring, own) {
            hinges.push(hinge);
        }
    }
    hinges
}

/// Joints that a joint model lets move, with their stiffness.
fn of_joint_model(
    robot: &Robot,
    mechanism: &Mechanism,
    existing: &[usize],
    joints: &JointModel,
) -> Vec<(usize, f64)> {
    // A joint with a spring of its own is held by that.
    let has_spring = |joint: &usize| {
        matches!(
            robot.joints[*joint].springs.own.yielding,
            Yielding::Compliance(_)
        )
    };
    match joints {
        JointModel::Rigid => Vec::new(),
        JointModel::Pinned => existing
            .iter()
            .copied()
            .filter(|joint| !mechanism.locked.contains(joint) && !has_spring(joint))
            .map(|joint| (joint, 0.0))
            .collect(),
        JointModel::Hinged(list) => list
            .iter()
            .copied()
            .filter(|(joint, _)| existing.contains(joint))
            .collect(),
    }
}

fn own_hinge(robot: &Robot, index: usize, stiffness: f64) -> ModelHinge {
    let joint = &robot.joints[index];
    let plane = &robot.planes[joint.plane];
    let own = &joint.springs.own.yielding;
    let slides = joint.motion == JointMotion::Slides;
    ModelHinge {
        place: HingePlace::Joint(index),
        spring: ModelParameter::of_joint(&joint.name, joint.motion),
        default: finite(own.compliance()),
        own_stiffness: with_pin(*own, stiffness),
        direction: FixedDirection {
            body: Some(plane.body),
            local: plane.normal,
        },
        plane: (!slides).then_some(joint.plane),
        slides,
    }
}

fn across_hinge(robot: &Robot, index: usize, axis: Direction, own: &SpringDefault) -> ModelHinge {
    let joint = &robot.joints[index];
    let plane = &robot.planes[joint.plane];
    ModelHinge {
        place: HingePlace::JointAcross(index),
        spring: ModelParameter::JointAbout(joint.name.as_str().into(), axis),
        default: finite(own.yielding.compliance()),
        own_stiffness: with_pin(own.yielding, f64::INFINITY),
        direction: FixedDirection {
            body: Some(plane.body),
            local: joint_axes(plane.normal)[axis.index()],
        },
        plane: None,
        slides: false,
    }
}

fn end_hinge(
    place: HingePlace,
    spring: ModelParameter,
    axis: SpringAxis,
    own: &SpringDefault,
    direction: FixedDirection,
) -> ModelHinge {
    ModelHinge {
        place,
        spring,
        default: finite(own.yielding.compliance()),
        own_stiffness: with_pin(own.yielding, f64::INFINITY),
        direction,
        plane: None,
        slides: !axis.turns(),
    }
}

/// Zero for a pin, which has no compliance to be a parameter.
fn finite(compliance: f64) -> f64 {
    if compliance.is_finite() {
        compliance
    } else {
        0.0
    }
}

fn with_pin(own: Yielding, stiffness: f64) -> f64 {
    match own {
        Yielding::Pinned => 0.0,
        Yielding::Rigid | Yielding::Compliance(_) => stiffness,
    }
}

fn unit(axis: SpringAxis) -> [f64; 3] {
    let mut unit = [0.0; 3];
    unit[axis.index() % 3] = 1.0;
    unit
}

/// The axes of a joint from its own axis, in the axes of the same body: see [`JointSprings`](super::springs::JointSprings).
pub(super) fn joint_axes(normal: [f64; 3]) -> [[f64; 3]; 3] {
    use stiffbench_numeric::vector::{cross, dot, norm, scale, subtract};
    let largest = (0..3).max_by(|a, b| normal[*a].abs().total_cmp(&normal[*b].abs()));
    let mut next = [0.0; 3];
    next[(largest.unwrap_or(0) + 1) % 3] = 1.0;
    let across = subtract(next, scale(normal, dot(next, normal)));
    let y = scale(across, 1.0 / norm(across));
    [normal, y, cross(normal, y)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiffbench_numeric::vector::{cross, dot};

    #[test]
    fn the_axes_of_a_joint_are_right_handed() {
        assert_eq!(
            joint_axes([0.0, 0.0, 1.0]),
            [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
        );
        for normal in [
            [1.0, 0.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.6, 0.0, 0.8],
            [0.48, -0.6, 0.64],
        ] {
            let [x, y, z] = joint_axes(normal);
            assert_eq!(x, normal);
            for (a, b) in [(x, y), (y, z), (z, x)] {
                assert!(dot(a, b).abs() < 1e-15);
            }
            for (a, b) in cross(x, y).into_iter().zip(z) {
                assert!((a - b).abs() < 1e-15);
            }
            assert!((dot(y, y) - 1.0).abs() < 1e-15);
        }
    }
}
