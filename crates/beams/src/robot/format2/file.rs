//! The keys of `stiffbench/robot/2` and their meaning.
//!
//! Every key of a measured value may end in a unit. What the file means as a whole is checked by [`crate::robot::Robot::parse`].

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use crate::robot::exact_array::{exactly, exactly_if_given};
use crate::robot::file::{FactorsEntry, OrderedTable};

use super::measure::{AngleOf, ComplianceOf, InUnit, LengthOf, StiffnessOf, TravelOf};
use super::parts::{BalancerRow, BaseRow, MassRow, MaterialRow, SectionRow, ToolRow};

/// A robot: joints, points, what connects them, and what loads it.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotFile2 {
    /// `stiffbench/robot/2`.
    pub schema: String,
    /// What the robot is called in tables and figures.
    pub name: String,
    /// Where the numbers are from, under which licence.
    pub source: Option<String>,
    /// Axis of the world that points upwards.
    pub up: UpAxis,
    /// Which Denavit-Hartenberg convention the joints with `alpha`, `a`, `theta`, `d` follow.
    pub dh: Option<DhConvention>,
    /// Names for lengths and angles that expressions may use.
    #[serde(default)]
    pub parameters: OrderedTable<InUnit<TravelOf>>,
    /// Joints, by name, from the base to the tool.
    pub joints: OrderedTable<JointRow>,
    /// Coordinates of a pose that no single joint has, or limits of those that joints have.
    #[serde(default)]
    pub variables: OrderedTable<VariableRow>,
    /// Coupled limits of the variables.
    #[serde(default)]
    pub limits: Vec<LimitRow>,
    /// Directions that loops and links refer to.
    #[serde(default)]
    pub planes: OrderedTable<PlaneRow>,
    /// Bodies whose place follows from two points.
    #[serde(default)]
    pub bodies: OrderedTable<BodyRow>,
    /// Points besides those of the joints.
    #[serde(default)]
    pub points: OrderedTable<PointRow>,
    /// Beams between points; what no beam connects is rigid.
    #[serde(default)]
    pub links: OrderedTable<LinkRow>,
    /// Cross-sections with constants or a profile.
    #[serde(default)]
    pub sections: OrderedTable<SectionRow>,
    /// Materials beside the known ones.
    #[serde(default)]
    pub materials: OrderedTable<MaterialRow>,
    /// How the robot stands.
    pub base: Option<BaseRow>,
    /// What is mounted at the end.
    pub tool: Option<ToolRow>,
    /// Masses with their centres.
    #[serde(default)]
    pub masses: OrderedTable<MassRow>,
    /// Springs and gas cylinders that carry part of the weight.
    #[serde(default)]
    pub balancers: OrderedTable<BalancerRow>,
    /// Sets of fitting factors.
    #[serde(default)]
    pub factors: OrderedTable<FactorsEntry>,
    /// Named poses.
    #[serde(default)]
    pub poses: OrderedTable<PoseAngles>,
}

/// An axis that points upwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// y is vertical.
    Y,
    /// z is vertical.
    Z,
}

/// A Denavit-Hartenberg convention.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum DhConvention {
    /// Rot z(theta) Trans z(d) Trans x(a) Rot x(alpha): Denavit and Hartenberg 1955.
    Standard,
    /// Rot x(alpha) Trans x(a) Rot z(theta) Trans z(d): Craig.
    Modified,
}

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum JointKind {
    /// It turns about its axis.
    #[default]
    Revolute,
    /// It slides along its axis.
    Sliding,
}

/// With which body the bearing of a sliding joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Bearing {
    /// It stays on the body that carries the joint: a ram in a guide.
    #[default]
    Fixed,
    /// It moves with the sliding body: a carriage on a rail.
    Moving,
}

/// How a spring takes part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum SpringWord {
    /// It has the given stiffness; a fit keeps it.
    Fixed,
    /// A fit determines it, from the given stiffness or from the data alone.
    Free,
    /// It has the value of another parameter, `tied_to`.
    Tied,
    /// It does not give way.
    Rigid,
    /// It gives way freely.
    Pinned,
}

/// A joint, and the body that moves on it.
///
/// Where it is: `at`, `turn`, `axis`; or a row of a Denavit-Hartenberg table; or `point`, where two bodies meet that other joints and
/// loops move.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointRow {
    /// `revolute` if absent.
    #[serde(default)]
    pub kind: JointKind,
    /// Of a sliding joint: with which body its bearing, where forces pass, moves. `fixed` if absent.
    pub bearing: Option<Bearing>,
    /// Body that carries it; that of the joint before it if absent, `base` for the first.
    pub on: Option<String>,
    /// Body that moves on it; named like the joint if absent.
    pub body: Option<String>,
    /// Its place in the axes of the body that carries it; zero if absent.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub at: Option<[InUnit<LengthOf>; 3]>,
    /// Roll, pitch and yaw of its axes against those of the body that carries it: turns about x, then y, then z of that body.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub turn: Option<[InUnit<AngleOf>; 3]>,
    /// Its axis: `x`, `-x` and so on, or a vector, in the turned axes. z if absent.
    pub axis: Option<AxisValue>,
    /// Twist of the row of a Denavit-Hartenberg table.
    pub alpha: Option<InUnit<AngleOf>>,
    /// Length of the row.
    pub a: Option<InUnit<LengthOf>>,
    /// Angle of the row where the joint's angle is zero.
    pub theta: Option<InUnit<AngleOf>>,
    /// Offset of the row.
    pub d: Option<InUnit<LengthOf>>,
    /// A point where `on` and `body` meet; then neither is placed by this joint.
    pub point: Option<String>,
    /// Plane about whose normal a joint with `point` turns.
    pub plane: Option<String>,
    /// Its angle or travel as `offset` + sum of coefficient times variable; the variable with its own name if absent.
    pub angle: Option<OrderedTable<InUnit<TravelOf>>>,
    /// Smallest value of its variable.
    pub min: Option<InUnit<TravelOf>>,
    /// Largest value of its variable.
    pub max: Option<InUnit<TravelOf>>,
    /// Value in poses that do not name it; zero if absent.
    pub nominal: Option<InUnit<TravelOf>>,
    /// How its spring takes part; `fixed` if a stiffness is given, else `rigid`, of a joint with `point` `pinned`.
    pub spring: Option<SpringWord>,
    /// Stiffness about its axis, N·m/rad; of a sliding joint along it, N/m.
    pub stiffness: Option<InUnit<StiffnessOf>>,
    /// Compliance instead of the stiffness.
    pub compliance: Option<InUnit<ComplianceOf>>,
    /// Parameter that a tied spring follows, for example `joint.J2`.
    pub tied_to: Option<String>,
    /// Springs about the two axes across its own; of a sliding joint also `x`, about its own.
    pub across: Option<AcrossRow>,
    /// Section of the beam from this joint to the next points of its body: a name from `[sections]`, or a profile with its material, for
    /// example `tube 120x6 aluminium`. Rigid if absent.
    pub link: Option<String>,
    /// Groups of parameters that this beam takes part in.
    #[serde(default)]
    pub groups: Vec<String>,
}

/// `x`, `-z` and so on, or a vector.
#[derive(Debug, Clone, PartialEq, JsonSchema)]
#[schemars(untagged)]
pub enum AxisValue {
    /// A word.
    Word(String),
    /// A vector of any length.
    Vector([f64; 3]),
}

/// Springs of a joint about axes across its own.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AcrossRow {
    /// About its own axis, of a sliding joint.
    pub x: Option<SpringShape>,
    /// About the first axis across.
    pub y: Option<SpringShape>,
    /// About the second axis across.
    pub z: Option<SpringShape>,
}

/// A spring as the schema knows it.
#[derive(Debug, Clone, JsonSchema)]
#[schemars(untagged)]
pub enum SpringShape {
    /// How it takes part.
    Word(SpringWord),
    /// With its stiffness.
    Table(SpringRow),
}

/// A spring.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringRow {
    /// How it takes part; `fixed` if a stiffness is given.
    pub spring: Option<SpringWord>,
    /// N·m/rad, or N/m along an axis.
    pub stiffness: Option<InUnit<StiffnessOf>>,
    /// Compliance instead of the stiffness.
    pub compliance: Option<InUnit<ComplianceOf>>,
    /// Parameter that a tied spring follows.
    pub tied_to: Option<String>,
}

/// Springs along and about three axes.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringRows {
    /// Along x.
    pub x: Option<SpringShape>,
    /// Along y.
    pub y: Option<SpringShape>,
    /// Along z.
    pub z: Option<SpringShape>,
    /// About x.
    pub rx: Option<SpringShape>,
    /// About y.
    pub ry: Option<SpringShape>,
    /// About z.
    pub rz: Option<SpringShape>,
}

/// A coordinate of a pose.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VariableRow {
    /// Smallest value.
    pub min: Option<InUnit<TravelOf>>,
    /// Largest value.
    pub max: Option<InUnit<TravelOf>>,
    /// Value in poses that do not name it; zero if absent.
    pub nominal: Option<InUnit<TravelOf>>,
}

/// A coupled limit: the sum of coefficient times variable lies between two values.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitRow {
    /// Coefficient by variable.
    pub terms: BTreeMap<String, f64>,
    /// Smallest value of the sum.
    pub at_least: Option<InUnit<TravelOf>>,
    /// Largest value of the sum.
    pub at_most: Option<InUnit<TravelOf>>,
}

/// A direction that is fixed to a body.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneRow {
    /// The body; `base` if absent.
    pub on: Option<String>,
    /// Its normal.
    pub normal: AxisValue,
}

/// A body that lies along two points: local z from the first to the second, local x the plane's normal.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyRow {
    /// The two points.
    #[serde(deserialize_with = "exactly")]
    pub along: [String; 2],
    /// The plane.
    pub plane: String,
}

/// A point: fixed on a body, or where two circles meet.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointRow {
    /// The body that it is fixed on.
    pub on: Option<String>,
    /// Its place in the axes of that body; zero if absent.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub at: Option<[InUnit<LengthOf>; 3]>,
    /// Centres of two circles that meet in it.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub centres: Option<[String; 2]>,
    /// Their radii.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub radii: Option<[InUnit<LengthOf>; 2]>,
    /// Plane of the circles.
    pub plane: Option<String>,
    /// 1 or -1: on which side of the line from the first to the second centre it lies; with n the normal, 1 is the side of n × that line.
    pub side: Option<i64>,
}

/// A beam between two points.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LinkRow {
    /// The two points.
    #[serde(deserialize_with = "exactly")]
    pub between: [String; 2],
    /// Body that it is part of; the one that both points lie on if absent.
    pub on: Option<String>,
    /// Section: a name from `[sections]`, or a profile with its material. Rigid if absent.
    pub section: Option<String>,
    /// Direction of local y, the width of the section, in the axes of its body.
    pub width: Option<AxisValue>,
    /// Plane whose normal is local y, instead of `width`.
    pub plane: Option<String>,
    /// Groups of parameters that it takes part in.
    #[serde(default)]
    pub groups: Vec<String>,
}

/// A pose: values by variable, or all values in the order of the variables.
#[derive(Debug, Clone, PartialEq, JsonSchema)]
#[schemars(untagged)]
pub enum PoseAngles {
    /// By variable; the others take their nominal value.
    Named(OrderedTable<InUnit<TravelOf>>),
    /// In the order of the variables.
    Listed(Vec<InUnit<TravelOf>>),
}
