//! The robot file, format `planar-linkage-robot/1`: its keys and their meaning.
//!
//! These types mirror the TOML text and carry the JSON Schema that is published from it (`stiffbench robot show --schema`). What the
//! file means as a whole (names that must exist, dependencies that must not be circular) is checked by
//! [`crate::robot::Robot::parse`].

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use stiffbench_units_and_text::toml_text::remove_null;

use super::exact_array::{exactly, exactly_if_given};
use super::expression::Expression;
use super::fitting_factors::FittingFactors;
use super::model_parameter::{ElementClass, ModelParameter, NotAParameter};
use super::spring_axis::SpringAxis;

/// The only format known to this version.
pub const FORMAT: &str = "planar-linkage-robot/1";

/// The JSON Schema of the format (draft 2020-12), for editors that complete and check TOML.
///
/// It knows shapes and words, not whether names exist; that is checked by [`crate::robot::Robot::parse`].
#[must_use]
pub fn json_schema() -> serde_json::Value {
    let mut schema = schemars::schema_for!(RobotFile).to_value();
    if let Some(object) = schema.as_object_mut() {
        object.insert("title".to_owned(), format!("robot file, {FORMAT}").into());
    }
    schema["properties"]["format"]["const"] = FORMAT.into();
    remove_null(&mut schema);
    schema
}

/// A table that keeps the order of the file: poses, mechanisms and nodes are listed as the author lists them.
pub type OrderedTable<T> = indexmap::IndexMap<String, T>;

/// A robot: rigid bodies, joints between them, nodes, and two-node beam elements between nodes.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub struct RobotFile {
    /// `planar-linkage-robot/1`.
    pub format: String,
    /// What the robot is called in tables and figures.
    pub name: String,
    /// Joints between bodies; in a rigid-jointed structure they transmit everything.
    #[serde(default)]
    pub joints: Vec<JointEntry>,
    /// Two-node beams.
    pub elements: Vec<ElementEntry>,
    /// Units of the file; only `m`, `deg`, `m2`, `m4`, `Pa`, `kg` are known.
    pub units: Option<UnitsEntry>,
    /// Words for the axes; only the vertical is used in computation, for weight.
    pub frame: Option<FrameEntry>,
    /// Angles that make a pose.
    #[serde(default)]
    pub variables: OrderedTable<VariableEntry>,
    /// Coupled limits of the variables.
    #[serde(default)]
    pub limits: Vec<LimitEntry>,
    /// Names for numbers that expressions may use.
    #[serde(default)]
    pub parameters: OrderedTable<Expression>,
    /// Planes in which linkages move.
    #[serde(default)]
    pub planes: OrderedTable<PlaneEntry>,
    /// Rigid bodies.
    pub bodies: Vec<BodyEntry>,
    /// Points.
    pub nodes: OrderedTable<NodeEntry>,
    /// Nodes held by the frame.
    pub support: SupportEntry,
    /// The end of the robot.
    pub end: EndEntry,
    /// Elastic constants by name.
    pub materials: OrderedTable<MaterialEntry>,
    /// Nominal section constants by name, before any fitting factor.
    pub sections: OrderedTable<SectionEntry>,
    /// Which chains make which mechanism.
    pub mechanisms: OrderedTable<MechanismEntry>,
    /// Masses that hang at nodes, kg: motors, gearboxes, a tool.
    #[serde(default)]
    pub masses: OrderedTable<f64>,
    /// Sets of fitting factors by name.
    #[serde(default)]
    pub factors: OrderedTable<FactorsEntry>,
    /// Named poses.
    #[serde(default)]
    pub poses: OrderedTable<PoseEntry>,
}

/// A revolute joint.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub struct JointEntry {
    /// Name, unique among joints.
    pub id: String,
    /// Node it sits at.
    pub node: String,
    /// The two bodies it joins; the second is the one that turns on the first.
    #[serde(deserialize_with = "exactly")]
    pub bodies: [String; 2],
    /// Chain it is counted in.
    pub chain: Option<String>,
    /// Name of a plane: the joint turns about its normal.
    pub axis: String,
}

/// A two-node beam.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub struct ElementEntry {
    /// Name, unique among elements.
    pub id: String,
    /// Its two nodes; local x runs from the first to the second.
    #[serde(deserialize_with = "exactly")]
    pub nodes: [String; 2],
    /// Chain it belongs to.
    pub chain: String,
    /// Which fitting factors it takes.
    pub class: ElementClass,
    /// Name of its section.
    pub section: String,
    /// Body it is part of.
    pub body: String,
    /// Plane whose normal is local y.
    pub plane: String,
}

/// Units of the file.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub struct UnitsEntry {
    /// `m`.
    pub length: Option<String>,
    /// `deg`.
    pub angle: Option<String>,
    /// `m2`.
    pub area: Option<String>,
    /// `m4`.
    pub second_moment: Option<String>,
    /// `Pa`.
    pub modulus: Option<String>,
    /// `kg`.
    pub mass: Option<String>,
}

/// Words for the axes.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub struct FrameEntry {
    /// Meaning of x.
    pub x: Option<String>,
    /// Meaning of y.
    pub y: Option<String>,
    /// Meaning of z.
    pub z: Option<String>,
    /// Unit vector of the lateral direction.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub lateral: Option<[f64; 3]>,
    /// Unit vector of the vertical direction; weight acts against it. y if absent.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub vertical: Option<[f64; 3]>,
    /// Unit vector of the radial direction.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub radial: Option<[f64; 3]>,
}

/// An angle of the pose, degrees.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub struct VariableEntry {
    /// Smallest value.
    pub min: Expression,
    /// Largest value.
    pub max: Expression,
    /// Value in poses that do not name it.
    pub nominal: Expression,
}

/// A coupled limit: the sum of coefficient times variable is at least a value, degrees.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub struct LimitEntry {
    /// Coefficient by variable.
    pub terms: BTreeMap<String, f64>,
    /// Smallest value of the sum.
    pub at_least: Expression,
}

/// A plane in which a linkage moves.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub struct PlaneEntry {
    /// Body the normal is fixed to.
    pub body: String,
    /// Unit normal in that body's axes.
    #[serde(deserialize_with = "exactly")]
    pub normal: [f64; 3],
}

/// A rigid body and its axes.
///
/// The reference body has neither `parent` nor `along`. A body with `parent` turns about `axis` through `origin`; one with
/// `along` has local z from the first node to the second and local x along the plane's normal.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub struct BodyEntry {
    /// Name, unique among bodies.
    pub id: String,
    /// Chain it is counted in; absent for helpers.
    pub chain: Option<String>,
    /// Body it turns on.
    pub parent: Option<String>,
    /// Node at its origin.
    pub origin: Option<String>,
    /// Axis of its rotation, in the parent's axes.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub axis: Option<[f64; 3]>,
    /// Angle: coefficient by variable, and `offset_deg`.
    pub angle: Option<BTreeMap<String, Expression>>,
    /// Two nodes it is aligned with.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub along: Option<[String; 2]>,
    /// Plane of an aligned body.
    pub plane: Option<String>,
    /// Turn of an aligned body from local z towards local y, degrees.
    pub turn_deg: Option<Expression>,
}

impl BodyEntry {
    /// Whether it has a key of a body that turns on a parent.
    pub(super) fn has_turn(&self) -> bool {
        self.origin.is_some() || self.axis.is_some() || self.angle.is_some()
    }
}

/// A point: fixed on a body, or where two circles meet.
#[derive(Debug, Clone, JsonSchema)]
#[schemars(untagged)]
pub enum NodeEntry {
    /// Fixed on a body.
    Fixed {
        /// The body.
        on: String,
        /// Local coordinates, m.
        at: [Expression; 3],
    },
    /// Intersection of two circles in a plane.
    Loop {
        /// Centre and radius of both circles.
        #[schemars(rename = "loop")]
        circles: [(String, Radius); 2],
        /// The plane.
        plane: String,
        /// +1 or -1: which of the two intersections.
        branch: i64,
    },
}

/// Radius of a circle of a loop, m.
#[derive(Debug, Clone, JsonSchema)]
#[schemars(untagged)]
pub enum Radius {
    /// Distance between two other nodes.
    Distance {
        /// The two nodes.
        dist: [String; 2],
    },
    /// A length.
    Length(Expression),
}

/// Held nodes.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub struct SupportEntry {
    /// Nodes held in all six freedoms; one absent from a mechanism is ignored.
    pub fixed: Vec<String>,
    /// Height below which no joint and no tool may be in a pose that is proposed for a measurement, m.
    pub floor_m: Option<Expression>,
    /// Least distance of the tool from the vertical through the base in such a pose, m.
    pub radius_m: Option<Expression>,
}

/// The end of the robot.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub struct EndEntry {
    /// Its node.
    pub node: String,
}

/// Elastic constants of an isotropic material.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub struct MaterialEntry {
    /// Young's modulus, Pa.
    #[serde(rename = "E")]
    pub youngs_modulus: f64,
    /// Shear modulus, Pa.
    #[serde(rename = "G")]
    pub shear_modulus: f64,
    /// Density, kg/m³: with the area of a section the mass of its members, where the section has no `mass_per_m`.
    pub density: Option<f64>,
}

/// Nominal section constants.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub struct SectionEntry {
    /// Name of the material.
    pub material: String,
    /// Area, m².
    #[serde(rename = "A")]
    pub area: f64,
    /// Second moment for bending within the plane, m⁴.
    #[serde(rename = "Iy")]
    pub iy: f64,
    /// Second moment for bending out of the plane, m⁴.
    #[serde(rename = "Iz")]
    pub iz: f64,
    /// Torsion constant, m⁴.
    #[serde(rename = "J")]
    pub j: f64,
    /// Shear coefficients along local y and z (shear area over area), used by Timoshenko beams; 5/6 if absent.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub shear: Option<[f64; 2]>,
    /// Mass of a member per length, kg/m, with all that is fixed along it.
    pub mass_per_m: Option<f64>,
}

/// Which parts make a mechanism.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub struct MechanismEntry {
    /// Chains whose elements belong to it.
    pub chains: Vec<String>,
    /// Further single elements.
    #[serde(default)]
    pub elements: Vec<String>,
    /// Joint that each motor locks when a pose is held (pinned structure only).
    #[serde(default)]
    pub drives: BTreeMap<String, String>,
    /// Further joints held by a brake (pinned structure only).
    #[serde(default)]
    pub locked: Vec<String>,
}

/// Fitting factors by element class.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub struct FactorsEntry {
    /// Of beams; 1 if absent.
    #[serde(default)]
    pub beam: FactorEntry,
    /// Of links; 1 if absent.
    #[serde(default)]
    pub link: FactorEntry,
    /// Of single sections, by name, beside those of the class.
    #[serde(default)]
    pub sections: OrderedTable<FactorEntry>,
    /// Compliance of joints about their axis, by name, rad/(N·m).
    #[serde(default, rename = "joints_rad_per_Nm")]
    pub joints_rad_per_nm: OrderedTable<f64>,
    /// Compliance of the base about x, y, z through the first support, rad/(N·m).
    #[serde(default, rename = "base_rad_per_Nm")]
    pub base_rad_per_nm: BaseEntry,
    /// Of groups of members, by name, beside those of class and section.
    #[serde(default)]
    pub groups: OrderedTable<FactorEntry>,
    /// Compliance of all other springs, by the name of the parameter, for example `joint.J2.y` or `tool.z`, rad/(N·m) or m/N.
    #[serde(default)]
    pub springs: OrderedTable<f64>,
}

impl FactorsEntry {
    /// The values, not checked.
    ///
    /// # Errors
    /// [`NotAParameter`] for a spring whose name is none.
    pub fn values(&self) -> Result<FittingFactors, NotAParameter> {
        let four = |entry: &FactorEntry| [entry.area, entry.iy, entry.iz, entry.j];
        let of_each = |entries: &OrderedTable<FactorEntry>| {
            let entries = entries.iter();
            entries
                .map(|(name, entry)| (name.clone(), four(entry)))
                .collect()
        };
        let others = self
            .springs
            .iter()
            .map(|(name, c)| Ok((ModelParameter::spring_named(name)?, *c)));
        let others = others.collect::<Result<Vec<_>, NotAParameter>>()?;
        let joints = self.joints_rad_per_nm.iter();
        let BaseEntry { x, y, z } = self.base_rad_per_nm;
        let joints = joints.map(|(name, c)| (ModelParameter::Joint(name.as_str().into()), *c));
        let base = [
            (SpringAxis::Rx, x),
            (SpringAxis::Ry, y),
            (SpringAxis::Rz, z),
        ];
        let base = base.map(|(axis, c)| (ModelParameter::Base(axis), c));
        Ok(FittingFactors {
            sections: of_each(&self.sections),
            groups: of_each(&self.groups),
            springs: joints
                .chain(base.into_iter().filter(|(_, c)| *c != 0.0))
                .chain(others)
                .collect(),
            ..FittingFactors::of_classes(four(&self.beam), four(&self.link))
        })
    }
}

/// Compliance of the base about each axis, rad/(N·m).
#[derive(Debug, Clone, Copy, Default, Deserialize, JsonSchema)]
#[serde(default)]
pub struct BaseEntry {
    /// About x.
    pub x: f64,
    /// About y.
    pub y: f64,
    /// About z.
    pub z: f64,
}

/// Multipliers of the section constants.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
pub struct FactorEntry {
    /// Of the area.
    #[serde(rename = "A")]
    pub area: f64,
    /// Of Iy.
    #[serde(rename = "Iy")]
    pub iy: f64,
    /// Of Iz.
    #[serde(rename = "Iz")]
    pub iz: f64,
    /// Of J.
    #[serde(rename = "J")]
    pub j: f64,
}

impl Default for FactorEntry {
    fn default() -> Self {
        let [area, iy, iz, j] = [1.0; 4];
        Self { area, iy, iz, j }
    }
}

/// A named pose: values of variables, degrees; those not named take their nominal value. `paper_z_y` may give the point (z, y), m,
/// that a publication states for it.
pub type PoseEntry = OrderedTable<PoseValue>;

/// What a key of a pose holds.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected an angle in degrees, an expression, or a point [z, y]"
)]
pub enum PoseValue {
    /// Value of a variable, degrees.
    Angle(Expression),
    /// A point, m.
    Point(#[serde(deserialize_with = "exactly")] [f64; 2]),
}
