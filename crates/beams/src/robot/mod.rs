//! Pose to structure: bodies, joints, nodes and members of a robot, read from its file.
//!
//! A [`Robot`] is a checked robot file: every name resolved, every dependency in order. A [`Mechanism`] chooses which of its
//! chains are there; a [`Pose`] fixes its angles; [`MechanismModel`] joins the three into a structure that can be solved, and
//! moves it from pose to pose without allocating.

mod body_axes;
mod carried_masses;
mod compile;
mod crossed;
mod error;
mod exact_array;
mod expression;
pub mod file;
mod fitting_factors;
pub mod format2;
mod hinges;
mod kinematics;
mod lengths;
mod loads;
mod mechanism;
mod members;
mod mobility;
mod model;
mod model_parameter;
mod multi_pose;
mod parameters;
mod placed;
mod plausible;
mod predict;
mod robot_parameters;
mod sensitivity;
mod shapes;
mod simd_poses;
mod spring_axis;
mod springs;
mod structure_parts;
mod sweep;
mod tool_pose;
mod tracked_poses;
mod tracker_frames;
mod weight;

use std::sync::Arc;

use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

pub use error::{RobotError, RobotProblem};
pub use expression::{Expression, ExpressionError};
pub use fitting_factors::{FittingFactors, StoredSprings};
pub use hinges::JointModel;
pub use lengths::FileLength;
pub use loads::{Balancer, BalancerForce, BodyPoint, MassPlace, PointMass};
pub(crate) use members::base_levers_between;
pub use members::{MechanismModel, Theory};
pub use mobility::{ChainMobility, Mobility, chain_mobility, mobility};
pub use model::{
    Angle, Body, BodyPlace, Joint, Limit, LimitViolation, Mechanism, Member, NamedPose, NodePlace,
    Plane, Pose, RadiusOf, RatedSection, RigidLink, Robot, RobotNode, Variable,
};
pub use model_parameter::{ElementClass, ModelParameter, NotAParameter};
pub use multi_pose::MultiPosePredictor;
pub use placed::PlacedRobot;
pub use predict::Predictor;
pub use spring_axis::{JointMotion, NotASpringAxis, SpringAxis};
pub use springs::{JointSprings, Payload, RoleInFit, SpringDefault, Tool, Yielding};
pub use sweep::{Keep, PoseBundles, PoseSweep, Swept, SweptPose};
pub use tool_pose::ToolPose;
pub use tracked_poses::TrackedPoses;
pub use tracker_frames::{TRACKER_PARAMETERS, TrackerFrames};
pub use weight::{GRAVITY_M_PER_S2, Masses};

/// The JSON Schema of the format that a robot file is in.
#[must_use]
pub fn schema_of(source: &SourceText) -> serde_json::Value {
    if format2::is_of_this_format(source) {
        format2::json_schema()
    } else {
        file::json_schema()
    }
}

impl Robot {
    /// Reads a robot file.
    ///
    /// # Errors
    /// [`RobotError::File`] pointing at the line that is wrong.
    pub fn parse(source: &SourceText) -> Result<Self, RobotError> {
        if format2::is_of_this_format(source) {
            format2::compile(source)
        } else {
            compile::compile(source)
        }
    }

    /// Mechanism by name; the last one of the file if `name` is `None` (the complete robot stands last).
    ///
    /// # Errors
    /// [`RobotError::UnknownName`] with the names that exist.
    pub fn mechanism(&self, name: Option<&str>) -> Result<&Mechanism, RobotError> {
        match name {
            None => Ok(self
                .mechanisms
                .last()
                .expect("a robot has at least one mechanism")
                .1),
            Some(name) => self.mechanisms.get(name).ok_or_else(|| {
                self.unknown(
                    "mechanism",
                    name,
                    self.mechanisms.keys().map(String::as_str),
                )
            }),
        }
    }

    /// Factor set by name.
    ///
    /// # Errors
    /// [`RobotError::UnknownName`] with the names that exist.
    pub fn factor_set(&self, name: &str) -> Result<FittingFactors, RobotError> {
        if let Some(factors) = self.factors.get(name) {
            return Ok(factors.clone());
        }
        // Every robot has the factors of a model that was never fitted, whether its file lists them or not.
        if name == "unit" {
            return Ok(FittingFactors::UNIT);
        }
        Err(self.unknown("factor set", name, self.factors.keys().map(String::as_str)))
    }

    /// Factors a model starts from when none are named: `m_fsd` if the file has them, else unit factors.
    #[must_use]
    pub fn default_factors(&self) -> (&'static str, FittingFactors) {
        match self.factors.get("m_fsd") {
            Some(factors) => ("m_fsd", factors.clone()),
            None => ("unit", FittingFactors::UNIT),
        }
    }

    /// Named pose.
    ///
    /// # Errors
    /// [`RobotError::UnknownName`] with the names that exist.
    pub fn pose(&self, id: &PoseId) -> Result<&Pose, RobotError> {
        self.poses
            .iter()
            .find(|named| named.id == *id)
            .map(|named| &named.pose)
            .ok_or_else(|| {
                self.unknown(
                    "pose",
                    id.as_str(),
                    self.poses.iter().map(|named| named.id.as_str()),
                )
            })
    }

    /// Names of the groups of parameters, in the order of the members.
    #[must_use]
    pub fn groups(&self) -> Vec<Arc<str>> {
        let mut groups: Vec<Arc<str>> = Vec::new();
        for group in self.members.iter().flat_map(|member| &member.groups) {
            if !groups.contains(group) {
                groups.push(group.clone());
            }
        }
        groups
    }

    /// Every spring of the file that gives way or takes part in fits, with what a fit does with it.
    pub fn own_springs(&self) -> impl Iterator<Item = (ModelParameter, &SpringDefault)> {
        let joints = self.joints.iter().flat_map(|joint| {
            let own = ModelParameter::of_joint(&joint.name, joint.motion);
            let about = Direction::ALL.into_iter().zip(&joint.springs.about);
            let about = about.map(|(axis, spring)| {
                let name = joint.name.as_str().into();
                (ModelParameter::JointAbout(name, axis), spring)
            });
            std::iter::once((own, &joint.springs.own)).chain(about)
        });
        let base = SpringAxis::ALL.into_iter().zip(&self.base);
        let tool = SpringAxis::ALL.into_iter().zip(&self.tool.springs);
        joints
            .chain(base.map(|(axis, spring)| (ModelParameter::Base(axis), spring)))
            .chain(tool.map(|(axis, spring)| (ModelParameter::Tool(axis), spring)))
            .filter(|(_, spring)| **spring != SpringDefault::default())
    }

    /// The springs of a mechanism that have no value yet: the file leaves them to a fit, and these values do not list them.
    #[must_use]
    pub fn unknown_springs(
        &self,
        mechanism: &Mechanism,
        values: &FittingFactors,
    ) -> Vec<ModelParameter> {
        let all = ModelParameter::all(self, mechanism);
        self.own_springs()
            .filter(|(spring, own)| own.is_unknown() && values.spring(spring).is_none())
            .map(|(spring, _)| spring)
            .filter(|spring| all.contains(spring))
            .collect()
    }

    /// The values with the springs of the file that they do not list; pins are no springs, and those without a value stay unlisted.
    #[must_use]
    pub fn with_own_springs(&self, values: &FittingFactors) -> FittingFactors {
        let mut all = values.clone();
        self.add_own_springs(&mut all);
        all
    }

    /// The same in place.
    pub(crate) fn add_own_springs(&self, values: &mut FittingFactors) {
        for (spring, default) in self.own_springs() {
            if let Yielding::Compliance(compliance) = default.yielding
                && !default.is_unknown()
            {
                values.springs.entry(spring).or_insert(compliance);
            }
        }
    }

    /// What the robot file calls x, y or z (0, 1, 2), without its explanation: of `lateral (out of the plane)` the first word; the
    /// vertical needs no word.
    #[must_use]
    pub fn axis_word(&self, axis: usize) -> Option<&str> {
        let words = self.axis_words[axis].as_deref();
        let word = words.and_then(|words| words.split([',', '(']).next());
        let up = (self.vertical[axis] == 1.0).then_some("vertical");
        word.map(str::trim).filter(|word| !word.is_empty()).or(up)
    }

    /// Axes of the base about which a search tries whether it rocks: all but y where y is vertical.
    ///
    /// The critical values that are published for linkages with y up hold for x and z: the joint of their waist turns about y. Where another
    /// axis is vertical it is tried too, and a joint that moves the end alike is named beside it.
    pub fn rocking_axes(&self) -> impl Iterator<Item = Direction> + use<> {
        let y_is_vertical = self.vertical[Direction::Y.index()].abs() == 1.0;
        let axes = Direction::ALL.into_iter();
        axes.filter(move |axis| *axis != Direction::Y || !y_is_vertical)
    }

    /// The pose with every variable at its nominal value.
    #[must_use]
    pub fn nominal_pose(&self) -> Pose {
        Pose {
            angles_deg: self
                .variables
                .iter()
                .map(|variable| variable.nominal_deg)
                .collect(),
        }
    }

    /// The named poses with their names; without any the nominal one, as `nominal`.
    #[must_use]
    pub fn poses_or_nominal(&self) -> Vec<(String, Pose)> {
        if self.poses.is_empty() {
            return vec![("nominal".to_owned(), self.nominal_pose())];
        }
        let named = self.poses.iter();
        named
            .map(|named| (named.id.to_string(), named.pose.clone()))
            .collect()
    }

    /// Index of a variable.
    ///
    /// # Errors
    /// [`RobotError::UnknownName`] with the names that exist.
    pub fn variable(&self, name: &str) -> Result<usize, RobotError> {
        self.variables
            .iter()
            .position(|variable| variable.name == name)
            .ok_or_else(|| {
                self.unknown(
                    "variable",
                    name,
                    self.variables.iter().map(|v| v.name.as_str()),
                )
            })
    }

    /// Limits that a pose breaks by more than 1e-9 degree.
    #[must_use]
    pub fn violated_limits(&self, pose: &Pose) -> Vec<LimitViolation> {
        model::violated_limits(self, pose)
    }

    /// Whether a pose breaks no limit by more than 1e-9 degree; as [`Robot::violated_limits`], without words for each.
    #[must_use]
    pub fn is_within_limits(&self, pose: &Pose) -> bool {
        model::is_within_limits(self, pose)
    }

    /// The error for a name this robot lacks.
    /// Checks that sections and joints that values of parameters name are there, and that all values are possible.
    ///
    /// # Errors
    /// [`RobotError::UnknownName`], [`RobotError::ImpossibleParameter`].
    pub fn check_parameters(&self, values: &FittingFactors) -> Result<(), RobotError> {
        let sections = || self.sections.keys().map(String::as_str);
        let joints = || self.joints.iter().map(|joint| joint.name.as_str());
        let missing = values
            .sections
            .keys()
            .find(|name| !self.sections.contains_key(*name));
        if let Some(name) = missing {
            return Err(self.unknown("section", name, sections()));
        }
        let groups = self.groups();
        let missing = values.groups.keys();
        if let Some(name) = missing
            .into_iter()
            .find(|name| groups.iter().all(|g| **g != ***name))
        {
            return Err(self.unknown("group", name, groups.iter().map(|group| &**group)));
        }
        for spring in values.springs.keys() {
            if let Some(name) = spring.joint()
                && joints().all(|known| known != name)
            {
                return Err(self.unknown("joint", name, joints()));
            }
        }
        let all = ModelParameter::CLASSES.into_iter().chain(values.named());
        for parameter in all {
            let value = values.get(&parameter);
            let least = if parameter.is_factor() {
                f64::MIN_POSITIVE
            } else {
                0.0
            };
            if !(value.is_finite() && value >= least) {
                let parameter = parameter.to_string();
                return Err(RobotError::ImpossibleParameter { parameter, value });
            }
        }
        Ok(())
    }

    /// Name of the section of a member.
    pub(crate) fn section_name(&self, member: &Member) -> &str {
        let section = self.sections.get_index(member.section);
        section.map_or("", |(name, _)| name)
    }

    fn unknown<'a>(
        &self,
        kind: &'static str,
        name: &str,
        known: impl Iterator<Item = &'a str>,
    ) -> RobotError {
        let known: Vec<&str> = known.collect();
        let help = stiffbench_units_and_text::nearest::nearest(name, known.iter().copied())
            .map(|near| format!("did you mean `{near}`?"));
        RobotError::UnknownName {
            robot: self.name.clone(),
            kind,
            name: name.to_owned(),
            known: if known.is_empty() {
                "none".to_owned()
            } else {
                known.join(", ")
            },
            help,
        }
    }
}
