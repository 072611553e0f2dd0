//! What is fitted again with every candidate: the free parameters of a robot, or the slopes of specimens.

use stiffbench_beams::physics::{Effect, Law, Place, PoseMechanics};
use stiffbench_units_and_text::test_point::Direction;

use crate::mismatch::error::MismatchError;

/// A parameter of the baseline, on the scale on which it is fitted: factors by their logarithm, all else by its value.
#[derive(Debug, Clone, PartialEq)]
pub struct BaselineParameter {
    /// Name, for example `beam.Iy` or `joint.J2`.
    pub name: String,
    /// Compliance of a spring at a fitted value of one, rad/(N·m); `None` for what is no spring.
    pub spring_rad_per_nm: Option<f64>,
    /// A large change of it: 1 of a logarithm, the mean slope of a slope.
    pub unit: f64,
    /// Where it starts.
    pub start: f64,
    /// Smallest value.
    pub lower: f64,
    /// Largest value.
    pub upper: f64,
    /// Standard deviation of what is known of it before any reading.
    pub prior_sd: f64,
}

impl BaselineParameter {
    /// Whether a factor stands at one of its bounds: it takes nothing more that the readings ask for.
    pub(crate) fn is_at_bound(&self, value: f64) -> bool {
        self.spring_rad_per_nm.is_none() && self.is_near_bound(value)
    }

    /// Whether a fitted value stands at one of its bounds.
    #[must_use]
    pub fn is_near_bound(&self, value: f64) -> bool {
        (value - self.lower).min(self.upper - value) < AT_BOUND * self.unit
    }
}

/// Distance of a fitted value from its bound at which it stands there, in units of the parameter.
const AT_BOUND: f64 = 1e-6;

/// The linear model that the effects are added to.
pub trait Baseline: Sync {
    /// Its parameters.
    fn parameters(&self) -> &[BaselineParameter];

    /// Those that describe it; behind them come those of how it is seen.
    fn described(&self) -> &[BaselineParameter] {
        self.parameters()
    }

    /// A solver; each thread has its own.
    ///
    /// # Errors
    /// [`MismatchError::Robot`] if a pose cannot be solved; for a variant, if it carries no load.
    fn solver(&self, variant: usize) -> Result<Box<dyn PoseSolver + '_>, MismatchError>;

    /// Number of variants of the structure: 1, and one for each element that may be loose.
    fn variants(&self) -> usize {
        1
    }

    /// The variant without the elements that these effects call loose.
    fn variant(&self, _effects: &[Effect]) -> Option<usize> {
        Some(0)
    }

    /// Loose members that the structure survives, and mechanisms that the session may have taken for another.
    fn other_structures(&self) -> Vec<Effect> {
        Vec::new()
    }

    /// Whether a law at a place is itself a free parameter of the model that stands within its bounds: nothing is left to find there.
    fn contains(&self, _law: Law, _place: &Place, _fitted: &[f64]) -> bool {
        false
    }

    /// The joints, in the order of the levers.
    fn joints(&self) -> &[Place];

    /// Axes about which its base may rock; none of a part on a bench.
    fn rocking_axes(&self) -> Vec<Direction> {
        Vec::new()
    }

    /// What springs that are not free would change, about fitted values.
    ///
    /// # Errors
    /// [`MismatchError::Robot`] if a pose cannot be solved.
    fn spring_columns(&self, _parameters: &[f64]) -> Result<Vec<StructureColumn>, MismatchError> {
        Ok(Vec::new())
    }

    /// What entries of the robot file that may be wrong would change, about fitted values.
    ///
    /// # Errors
    /// [`MismatchError::Robot`] if a pose cannot be solved.
    fn file_columns(&self, _parameters: &[f64]) -> Result<Vec<StructureColumn>, MismatchError> {
        Ok(Vec::new())
    }

    /// What each element adds to the compliance of the full structure.
    ///
    /// # Errors
    /// [`MismatchError::Robot`] if a pose cannot be solved.
    fn elements(&self, _parameters: &[f64]) -> Result<Vec<ElementCompliance>, MismatchError> {
        Ok(Vec::new())
    }
}

/// What an element adds to the compliance at the end.
#[derive(Debug, Clone, PartialEq)]
pub struct ElementCompliance {
    /// The element.
    pub element: String,
    /// For each pose and each of [`Property::ALL`](stiffbench_beams::structure::Property::ALL): derivative of the compliance along x, y, z to the logarithm of the property, m/N.
    pub gradient_m_per_n: Vec<[[f64; 3]; 4]>,
}

/// What an entry of the robot file would change if it were wrong, to the first order, or what a spring changes that it lacks.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureColumn {
    /// The law.
    pub law: Law,
    /// The entry.
    pub place: Place,
    /// For each pose the change of the compliance for each unit of the law's value, SI.
    pub compliance: Vec<[[f64; 6]; 6]>,
    /// Of a spring for each pose the stiffness that a closed loop sets against it, N·m/rad or N/m: a compliance c counts as c/(1 + c k).
    /// Empty of other entries.
    pub loop_stiffness: Vec<f64>,
    /// For each pose the change of where the end stands without a load; empty where that is not read.
    pub unloaded: Vec<[f64; 6]>,
}

/// Solves all poses for values of the baseline's parameters.
pub trait PoseSolver: Send {
    /// From now on solves the structure that effects ask for; those that act on the readings of a structure are passed over.
    ///
    /// # Errors
    /// [`MismatchError::Effect`] for a place that is not there.
    fn set_structure(&mut self, _effects: &[Effect]) -> Result<(), MismatchError> {
        Ok(())
    }

    /// From now on differentiates the whole compliance: displacements across the load too.
    ///
    /// # Errors
    /// [`MismatchError::Robot`] if a pose cannot be solved.
    fn differentiate_whole(&mut self) -> Result<(), MismatchError> {
        Ok(())
    }

    /// Solves all poses.
    ///
    /// # Errors
    /// [`MismatchError::Robot`] if the structure carries nothing.
    fn solve(&mut self, parameters: &[f64]) -> Result<(), MismatchError>;

    /// Solves all poses; of the influence of twists only that of some joints is needed, by their places among the levers.
    ///
    /// # Errors
    /// As [`PoseSolver::solve`].
    fn solve_for(&mut self, parameters: &[f64], _joints: &[usize]) -> Result<(), MismatchError> {
        self.solve(parameters)
    }

    /// What is known of a pose.
    fn pose(&self, pose: usize) -> &PoseMechanics;

    /// The joints of this structure, in the order of its levers; one may have gone with a member.
    fn joints(&self) -> Vec<Place>;
}

/// Standard deviations of the parameters as known beforehand, in their units.
pub(crate) fn prior_sd(baseline: &dyn Baseline) -> Vec<f64> {
    let parameters = baseline.parameters().iter();
    parameters.map(|parameter| parameter.prior_sd).collect()
}

/// Values of the parameters at the start.
pub(crate) fn start(baseline: &dyn Baseline) -> Vec<f64> {
    let parameters = baseline.parameters().iter();
    parameters.map(|parameter| parameter.start).collect()
}
