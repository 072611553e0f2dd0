//! The keys of sections, masses, base and tool.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::robot::exact_array::{exactly, exactly_if_given};

use super::file::SpringRows;
use super::measure::{
    AngleOf, AreaOf, DensityOf, ForceOf, InUnit, LengthOf, MassOf, MassPerLengthOf, ModulusOf,
    SecondMomentOf, StiffnessOf,
};

/// A cross-section: a profile, or constants.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SectionRow {
    /// `tube 40x3`, `box 60x40x3`, `bar 60x10`, `round 12`, `IPE 200`, `HEA 160`, `HEB 100`, `UPN 80`; dimensions in mm.
    pub profile: Option<String>,
    /// Name of the material; steel if absent.
    pub material: Option<String>,
    /// Area.
    #[serde(default, rename = "A")]
    pub area: Option<InUnit<AreaOf>>,
    /// Second moment for bending along local z.
    #[serde(default, rename = "Iy")]
    pub iy: Option<InUnit<SecondMomentOf>>,
    /// Second moment for bending along local y.
    #[serde(default, rename = "Iz")]
    pub iz: Option<InUnit<SecondMomentOf>>,
    /// Torsion constant.
    #[serde(default, rename = "J")]
    pub j: Option<InUnit<SecondMomentOf>>,
    /// Shear coefficients along local y and z (shear area over area).
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub shear: Option<[f64; 2]>,
    /// Mass per length with all that is fixed along the beam; density times area if absent.
    pub mass: Option<InUnit<MassPerLengthOf>>,
}

/// A material.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialRow {
    /// Young's modulus.
    #[serde(rename = "E")]
    pub youngs_modulus: InUnit<ModulusOf>,
    /// Shear modulus.
    #[serde(rename = "G")]
    pub shear_modulus: InUnit<ModulusOf>,
    /// Density.
    pub density: Option<InUnit<DensityOf>>,
}

/// How the robot stands.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BaseRow {
    /// Points that are held; the origin of the world if absent.
    pub fixed: Option<Vec<String>>,
    /// Height below which no joint and no tool may be in a pose that is proposed for a measurement.
    pub floor: Option<InUnit<LengthOf>>,
    /// Least distance of the tool from the vertical through the base in such a pose.
    pub radius: Option<InUnit<LengthOf>>,
    /// Springs of the foundation along and about the axes of the world, through the first of these points.
    #[serde(default)]
    pub springs: SpringRows,
}

/// What is mounted at the end.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ToolRow {
    /// Body that it is mounted on; that of the last joint if absent.
    pub on: Option<String>,
    /// Tool centre, in the axes of that body (of the last frame of a Denavit-Hartenberg table).
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub at: Option<[InUnit<LengthOf>; 3]>,
    /// Roll, pitch and yaw of the tool's axes.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub turn: Option<[InUnit<AngleOf>; 3]>,
    /// Springs where it is mounted, along and about its axes.
    #[serde(default)]
    pub springs: SpringRows,
    /// What it carries.
    pub payload: Option<PayloadRow>,
}

/// A payload.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PayloadRow {
    /// Its mass.
    pub mass: InUnit<MassOf>,
    /// Its centre from the tool centre, in the axes of the tool; zero if absent.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub at: Option<[InUnit<LengthOf>; 3]>,
}

/// A mass.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MassRow {
    /// The mass.
    pub mass: InUnit<MassOf>,
    /// The body that carries it.
    pub on: String,
    /// Its centre in the axes of that body; zero if absent.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub at: Option<[InUnit<LengthOf>; 3]>,
}

/// A spring or a gas cylinder between two bodies.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BalancerRow {
    /// Its two pivots.
    #[serde(deserialize_with = "exactly")]
    pub pivots: [PivotRow; 2],
    /// Distance of the pivots at which it has its preload.
    pub length: InUnit<LengthOf>,
    /// Force at that length; above zero it pulls the pivots together, below zero it pushes.
    pub preload: InUnit<ForceOf>,
    /// Stiffness of a spring, N/m.
    pub stiffness: Option<InUnit<StiffnessOf>>,
    /// Instead, of a gas cylinder: gas volume at that length over the area of the piston.
    pub gas_column: Option<InUnit<LengthOf>>,
    /// Polytropic exponent of the gas; 1 if absent, for changes that are slow.
    pub exponent: Option<f64>,
}

/// A pivot of a balancer.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PivotRow {
    /// The body.
    pub on: String,
    /// Its place in the axes of that body; zero if absent.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub at: Option<[InUnit<LengthOf>; 3]>,
}
