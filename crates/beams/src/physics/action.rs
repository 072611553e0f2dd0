//! What laws do to a run, at the place in the composition where each acts.

use std::fmt;

use super::joint_path::JointPath;
use super::run_loads::LoadPoint;

/// Most parameters of a law.
pub const MOST_PARAMETERS: usize = 4;

/// Values of a law's parameters; zero beyond those that it has.
pub type Values = [f64; MOST_PARAMETERS];

/// Values of an effect as an array, zero beyond those given.
#[must_use]
pub fn values_of(given: &[f64]) -> Values {
    let mut values = [0.0; MOST_PARAMETERS];
    for (value, given) in values.iter_mut().zip(given) {
        *value = *given;
    }
    values
}

/// A function of the values of a law and of a load.
pub type OfLoad = fn(&Values, &LoadPoint) -> f64;

/// A function of the values of a law, of a load and of the repeat.
pub type OfRepeat = fn(&Values, &LoadPoint, u32) -> f64;

/// What a law does. Displacement = mechanics × (1 + growth) + added, then the error of the gauge at that sum.
#[derive(Debug, Clone, Copy)]
pub enum LawAction {
    /// A joint turns.
    Joint(&'static dyn RotationLaw),
    /// All supports rock about an axis by the first value times their moment, rad/(N·m).
    Base,
    /// An element is missing.
    Missing,
    /// Another mechanism of the robot file is there.
    Mechanism,
    /// The structure is another than the robot file says, by the first value.
    Structure,
    /// Another force acts than the one measured: what is to be added to it, N.
    Force(OfLoad),
    /// The force acts turned by the first value, rad.
    Turn,
    /// The displacement is read along a direction turned by the first value, rad.
    Lean,
    /// The displacement of the mechanics grows by a share.
    Growth(OfRepeat),
    /// The reading is moved, m.
    Added(OfLoad),
    /// The gauge errs where it stands.
    Gauge(&'static dyn GaugeError),
    /// A part answers to all that it went through.
    History(&'static dyn HistoryLaw),
}

/// What drives the twist φ of a joint in a structure.
///
/// In a closed loop the twist unloads the joint: τ = T - k φ. A law solves that with its own equation in closed form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Driven {
    /// T, the moment of the joint at zero twist (twists of other joints included), N·m.
    pub moment_nm: f64,
    /// k, the stiffness that the structure sets against the twist, not below zero, N·m/rad.
    pub stiffness_nm_per_rad: f64,
    /// The twist at the load before, zero in a virgin run, rad.
    pub before_rad: f64,
}

/// The law of a joint: its twist from the moment that would act if the joint were rigid.
pub trait RotationLaw: fmt::Debug + Sync {
    /// The twist, rad.
    fn rotation_rad(&self, values: &Values, driven: Driven) -> f64;

    /// How fast the twist grows with the driving moment, rad/(N·m).
    fn slope_rad_per_nm(&self, values: &Values, driven: Driven) -> f64;

    /// Moment per twist under the smallest moment, N·m/rad; infinite where the joint does not turn, zero where it turns freely.
    fn stiffness_at_rest_nm_per_rad(&self, values: &Values) -> f64;

    /// What the joint adds to the displacements along a path of loads, m, one each, overwritten.
    ///
    /// An implementation hands its equation to `JointPath::side_by_side` if it has no memory, else to `JointPath::in_sequence`.
    fn added_m(&self, values: &Values, path: &JointPath, out: &mut [f64]);

    /// Whether the twist is proportional to the moment.
    fn is_linear(&self) -> bool;

    /// Spring, friction and play that do the same in a simulator of rigid bodies, or nearly.
    fn in_simulators(&self, values: &Values) -> SimulatedRotation;
}

/// A hinge as simulators of rigid bodies know it: a spring with dry friction, or play with dry friction.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SimulatedRotation {
    /// Compliance of the spring, rad/(N·m); zero without one.
    pub compliance_rad_per_nm: f64,
    /// Largest turn either way without a spring, rad; zero without play.
    pub play_rad: f64,
    /// Moment that friction holds, N·m.
    pub friction_nm: f64,
    /// What of the law this does not hold.
    pub left_out: Option<&'static str>,
}

/// What a part without a robot file went through, reading after reading; it begins virgin.
#[derive(Debug, Clone, Copy)]
pub struct DrivenPath<'a> {
    /// The quantity that was set at each reading.
    pub driver: &'a [f64],
    /// The clock at each reading, s; the number of the reading where none was recorded.
    pub time_s: &'a [f64],
}

/// The law of a part in a testing machine.
pub trait HistoryLaw: fmt::Debug + Sync {
    /// What it adds to the answers along a path, one each, overwritten.
    fn answers(&self, values: &Values, path: DrivenPath<'_>, out: &mut [f64]);
}

/// An error of the displacement gauge that depends on where it stands.
pub trait GaugeError: fmt::Debug + Sync {
    /// The error where the gauge reads `at_m`, m.
    fn error_m(&self, values: &Values, at_m: f64) -> f64;

    /// The errors at many readings, and the same a quarter of a turn of phase further, m, overwritten.
    fn both_phases_m(&self, values: &Values, at_m: &[f64], out: [&mut [f64]; 2]);
}
