//! What is fitted again with every candidate: the free parameters of a robot, or the slopes of specimens.

use stiffbench_beams::physics::{
    Effect, Law, Mechanics, Place, PlaceScale, PoseMechanics, without_elements,
};
use stiffbench_beams::robot::{
    FittingFactors, Mechanism, ModelParameter, MultiPosePredictor, Pose, Predictor, Robot,
    RobotError,
};
use stiffbench_units_and_text::test_point::Direction;

use crate::parameters::{
    ChosenParameter, FIRST_SPRING, FitRole, ParameterChoice, ScaleCell, SpringScales,
};

use super::error::MismatchError;

/// A parameter of the baseline, on the scale on which it is fitted: factors by their logarithm, all else by its value.
#[derive(Debug, Clone, PartialEq)]
pub struct BaselineParameter {
    /// Name, for example `beam.Iy` or `joint.J2`.
    pub name: String,
    /// Compliance of a spring at a fitted value of one, rad/(N·m); `None` for what is no spring.
    pub spring_rad_per_nm: Option<f64>,
    /// Where it starts.
    pub start: f64,
    /// Smallest value.
    pub lower: f64,
    /// Largest value.
    pub upper: f64,
    /// Standard deviation of what is known of it before any reading.
    pub prior_sd: f64,
}

/// The linear model that the effects are added to.
pub trait Baseline: Sync {
    /// Its parameters.
    fn parameters(&self) -> &[BaselineParameter];

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

    /// The loose members that the structure survives.
    fn missing_member_effects(&self) -> Vec<Effect> {
        Vec::new()
    }

    /// Whether a law at a place is itself a free parameter of the model: nothing is left to find there.
    fn contains(&self, _law: Law, _place: &Place) -> bool {
        false
    }

    /// Names of the joints, in the order of the levers.
    fn joints(&self) -> &[String];

    /// What each element adds to the compliance of the full structure.
    ///
    /// # Errors
    /// [`MismatchError::Robot`] if a pose cannot be solved.
    fn elements(&self, _parameters: &[f64]) -> Result<Vec<ElementCompliance>, MismatchError> {
        Ok(Vec::new())
    }
}

/// Names of the section properties, in the order of derivatives to them.
pub const PROPERTIES: [&str; 4] = ["A", "Iy", "Iz", "J"];

/// What an element adds to the compliance at the end.
#[derive(Debug, Clone, PartialEq)]
pub struct ElementCompliance {
    /// The element.
    pub element: String,
    /// For each pose and each of [`PROPERTIES`]: derivative of the compliance along x, y, z to the logarithm of the property, m/N.
    pub gradient_m_per_n: Vec<[[f64; 3]; 4]>,
}

/// Solves all poses for values of the baseline's parameters.
pub trait PoseSolver: Send {
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

    /// Index of the joint of the full structure among the levers of this one; `None` if it has gone with a member.
    fn joint_names(&self) -> Vec<String>;
}

/// Standard deviations of the parameters as known beforehand, in their units.
pub(super) fn prior_sd(baseline: &dyn Baseline) -> Vec<f64> {
    let parameters = baseline.parameters().iter();
    parameters.map(|parameter| parameter.prior_sd).collect()
}

/// Half the width, in standard deviations, of the range that bounds leave to a factor: uniform over ± ln 10.
const PRIOR_WIDTHS: f64 = 1.732_050_807_568_877_2;

/// The model of a robot with some of its parameters free.
#[derive(Debug)]
pub struct RobotBaseline<'a> {
    robot: &'a Robot,
    /// The whole mechanism, then those without one or two elements.
    mechanisms: Vec<(Vec<String>, Mechanism)>,
    values: BaselineValues,
    poses: Vec<Pose>,
    parameters: Vec<BaselineParameter>,
    /// The free springs as effects, of any size.
    springs: Vec<Effect>,
    joints: Vec<String>,
}

/// BaselineValues of all parameters, some of which are free.
#[derive(Debug, Clone)]
struct BaselineValues {
    at: FittingFactors,
    free: Vec<ModelParameter>,
    /// As [`BaselineParameter::spring_rad_per_nm`].
    springs_rad_per_nm: Vec<Option<f64>>,
}

impl BaselineValues {
    /// Takes fitted values.
    fn set(&mut self, fitted: &[f64]) {
        let free = self.free.iter().zip(&self.springs_rad_per_nm);
        for ((parameter, spring), fitted) in free.zip(fitted) {
            let value = spring.map_or_else(|| fitted.exp(), |scale| scale * fitted);
            self.at.set(parameter, value);
        }
    }
}

impl<'a> RobotBaseline<'a> {
    /// The baseline of a mechanism in the poses of a session.
    ///
    /// # Arguments
    /// - `factors`: where the free parameters start, and what the others are kept at.
    /// - `choice`: which parameters are free, and their bounds.
    ///
    /// # Errors
    /// [`MismatchError::Robot`] for a structure that carries nothing, [`MismatchError::Parameter`] for one that is tied or has no room.
    pub fn new(
        robot: &'a Robot,
        mechanism: &Mechanism,
        factors: FittingFactors,
        poses: Vec<Pose>,
        choice: &ParameterChoice,
    ) -> Result<Self, MismatchError> {
        let free = choice.members.iter().filter(|m| m.role != FitRole::Fixed);
        let free: Vec<&ChosenParameter> = free.collect();
        let scales = if free.iter().all(|chosen| chosen.parameter.is_factor()) {
            None
        } else {
            let of_pose = |pose| {
                Direction::ALL.map(|direction| ScaleCell {
                    pose,
                    direction,
                    measured_m_per_n: 0.0,
                })
            };
            let cells: Vec<ScaleCell> = (0..poses.len()).flat_map(of_pose).collect();
            let wanted: Vec<ModelParameter> =
                free.iter().map(|chosen| chosen.parameter.clone()).collect();
            Some(SpringScales::new(
                robot, mechanism, &factors, &wanted, &poses, &cells,
            )?)
        };
        let mut parameters = Vec::with_capacity(free.len());
        for chosen in &free {
            let scale = scales.as_ref().map(|scales| scales.of(&chosen.parameter));
            parameters.push(parameter(chosen, &factors, choice.range, scale)?);
        }
        let values = BaselineValues {
            at: factors,
            free: free.iter().map(|chosen| chosen.parameter.clone()).collect(),
            springs_rad_per_nm: parameters.iter().map(|p| p.spring_rad_per_nm).collect(),
        };
        let joints = mechanism
            .joints(robot)
            .into_iter()
            .map(|joint| robot.joints[joint].name.clone())
            .collect();
        let mut mechanisms = vec![(Vec::new(), mechanism.clone())];
        for &member in &mechanism.members {
            let mut rest = mechanism.clone();
            rest.members.retain(|other| *other != member);
            let name = robot.members[member].name.clone();
            if carries_loads(robot, &rest, &values.at, &poses) {
                mechanisms.push((vec![name], rest));
            }
        }
        let mut springs = FittingFactors::UNIT;
        for chosen in free.iter().filter(|chosen| !chosen.parameter.is_factor()) {
            springs.set(&chosen.parameter, 1.0);
        }
        Ok(Self {
            robot,
            springs: Effect::of_springs(&springs),
            mechanisms,
            values,
            poses,
            parameters,
            joints,
        })
    }

    /// Elements without which the mechanism still carries a load.
    pub fn missing_elements(&self) -> impl Iterator<Item = &str> {
        self.mechanisms
            .iter()
            .filter_map(|(loose, _)| loose.first().map(String::as_str))
    }

    /// BaselineValues of all parameters of the model where the free ones have these fitted values.
    #[must_use]
    pub fn factors(&self, fitted: &[f64]) -> FittingFactors {
        let mut values = self.values.clone();
        values.set(fitted);
        values.at
    }

    /// The fitted values at which the free parameters have these: springs of baselines in other poses have other units.
    #[must_use]
    pub fn fitted_values(&self, values: &FittingFactors) -> Vec<f64> {
        let free = self.values.free.iter().zip(&self.values.springs_rad_per_nm);
        free.map(|(parameter, spring)| {
            let value = values.get(parameter);
            spring.map_or_else(|| value.ln(), |scale| value / scale)
        })
        .collect()
    }

    /// Adds the variant that lacks the loose members of a model found before.
    ///
    /// # Errors
    /// [`MismatchError::Effect`] for an element that is not there.
    pub fn add_variant(&mut self, effects: &[Effect]) -> Result<(), MismatchError> {
        let loose = missing_member_names(effects);
        if self.mechanisms.iter().all(|(names, _)| *names != loose) {
            let rest = without_elements(self.robot, &self.mechanisms[0].1, effects)?;
            self.mechanisms.push((loose, rest));
        }
        Ok(())
    }
}

/// A free parameter, on the scale on which it is fitted.
fn parameter(
    chosen: &ChosenParameter,
    start: &FittingFactors,
    range: [f64; 2],
    scale: Option<PlaceScale>,
) -> Result<BaselineParameter, MismatchError> {
    let name = chosen.parameter.to_string();
    let value = start.get(&chosen.parameter);
    let wrong = |problem: &'static str| MismatchError::Parameter {
        name: name.clone(),
        problem,
    };
    if chosen.role != FitRole::Free {
        return Err(wrong("a search keeps or frees a parameter, and ties none"));
    }
    if chosen.parameter.is_factor() {
        let [lower, upper] = chosen.bounds.unwrap_or(range.map(|times| times * value));
        return Ok(BaselineParameter {
            spring_rad_per_nm: None,
            start: value.ln(),
            lower: lower.ln(),
            upper: upper.ln(),
            prior_sd: 0.5 * (upper / lower).ln() / PRIOR_WIDTHS,
            name,
        });
    }
    let scale = scale.unwrap_or_default();
    if scale.compliance == 0.0 {
        return Err(wrong("no load of these readings acts on it"));
    }
    let bounds = chosen.bounds.unwrap_or(scale.plausible_compliance());
    let [lower, upper] = bounds.map(|bound| bound / scale.compliance);
    if lower >= upper {
        return Err(wrong("its bounds leave no room"));
    }
    let begin = value / scale.compliance;
    let begin = if begin == 0.0 { FIRST_SPRING } else { begin };
    Ok(BaselineParameter {
        spring_rad_per_nm: Some(scale.compliance),
        start: begin.clamp(lower, upper),
        lower,
        upper,
        prior_sd: 0.5 * (upper - lower) / PRIOR_WIDTHS,
        name,
    })
}

/// Whether a mechanism carries a load in every pose.
fn carries_loads(
    robot: &Robot,
    mechanism: &Mechanism,
    factors: &FittingFactors,
    poses: &[Pose],
) -> bool {
    let solved = || {
        let springs: Vec<ModelParameter> = factors.springs().collect();
        let mut predictor = MultiPosePredictor::new(robot, mechanism, &springs, poses.len())?;
        for (index, pose) in poses.iter().enumerate() {
            predictor.place(index, pose)?;
        }
        predictor.solve(factors, false)
    };
    solved().is_ok()
}

fn missing_member_names(effects: &[Effect]) -> Vec<String> {
    let mut names: Vec<String> = effects
        .iter()
        .filter_map(|effect| match &effect.place {
            Place::Element(name) => Some(name.clone()),
            _ => None,
        })
        .collect();
    names.sort();
    names
}

impl Baseline for RobotBaseline<'_> {
    fn parameters(&self) -> &[BaselineParameter] {
        &self.parameters
    }

    fn solver(&self, variant: usize) -> Result<Box<dyn PoseSolver + '_>, MismatchError> {
        let mechanism = &self.mechanisms[variant].1;
        let (values, poses) = (self.values.clone(), &self.poses);
        let mut mechanics =
            Mechanics::rigid_with(self.robot, mechanism, &values.free, &values.at, poses)?;
        let units = values.springs_rad_per_nm.iter();
        mechanics.differentiate_in(units.map(|unit| unit.unwrap_or(1.0)).collect());
        Ok(Box::new(RobotSolver {
            mechanics,
            values,
            solved: Vec::new(),
            joints: JointsSolved::None,
        }))
    }

    fn variants(&self) -> usize {
        self.mechanisms.len()
    }

    fn variant(&self, effects: &[Effect]) -> Option<usize> {
        let loose = missing_member_names(effects);
        self.mechanisms
            .iter()
            .position(|(names, _)| *names == loose)
    }

    fn missing_member_effects(&self) -> Vec<Effect> {
        let laws = Law::ALL.iter().filter(|law| law.is_missing_element());
        let of_law = |law: &Law| {
            let law = *law;
            self.missing_elements().map(move |name| Effect {
                law,
                place: Place::Element(name.to_owned()),
                values: Vec::new(),
            })
        };
        laws.flat_map(of_law).collect()
    }

    fn contains(&self, law: Law, place: &Place) -> bool {
        let mut springs = self.springs.iter();
        springs.any(|spring| spring.law == law && spring.place == *place)
    }

    fn joints(&self) -> &[String] {
        &self.joints
    }

    fn elements(&self, parameters: &[f64]) -> Result<Vec<ElementCompliance>, MismatchError> {
        let mechanism = &self.mechanisms[0].1;
        let mut predictor = Predictor::new(self.robot, mechanism, &self.factors(parameters))?;
        let mut elements: Vec<ElementCompliance> = mechanism
            .members
            .iter()
            .map(|&member| ElementCompliance {
                element: self.robot.members[member].name.clone(),
                gradient_m_per_n: Vec::new(),
            })
            .collect();
        let mut gradient = vec![[0.0; 4]; elements.len()];
        for pose in &self.poses {
            predictor.place(pose)?;
            // The derivatives are those of the compliance solved last.
            let _ = predictor.translation_compliance();
            for element in &mut elements {
                element.gradient_m_per_n.push([[0.0; 3]; 4]);
            }
            for axis in 0..3 {
                predictor.compliance_gradient(axis, &mut gradient);
                for (element, gradient) in elements.iter_mut().zip(&gradient) {
                    if let Some(pose) = element.gradient_m_per_n.last_mut() {
                        for (property, value) in pose.iter_mut().zip(gradient) {
                            property[axis] = *value;
                        }
                    }
                }
            }
        }
        Ok(elements)
    }
}

/// One thread's solver of a robot.
struct RobotSolver<'a> {
    mechanics: Mechanics<'a>,
    values: BaselineValues,
    solved: Vec<f64>,
    joints: JointsSolved,
}

/// Joints whose twists were computed for the parameters solved last.
#[derive(Debug, PartialEq)]
enum JointsSolved {
    None,
    Some(Vec<usize>),
    All,
}

impl RobotSolver<'_> {
    fn solve_rigid(&mut self, parameters: &[f64]) -> Result<(), MismatchError> {
        if self.solved == parameters {
            return Ok(());
        }
        self.solved.clear();
        self.joints = JointsSolved::None;
        self.values.set(parameters);
        self.mechanics
            .set_factors_rigid(&self.values.at)
            .map_err(|error: RobotError| MismatchError::Robot(error))?;
        self.solved.extend_from_slice(parameters);
        Ok(())
    }
}

impl PoseSolver for RobotSolver<'_> {
    fn solve(&mut self, parameters: &[f64]) -> Result<(), MismatchError> {
        self.solve_rigid(parameters)?;
        if self.joints != JointsSolved::All {
            self.mechanics.solve_joints(|_| true)?;
            self.joints = JointsSolved::All;
        }
        Ok(())
    }

    fn solve_for(&mut self, parameters: &[f64], joints: &[usize]) -> Result<(), MismatchError> {
        self.solve_rigid(parameters)?;
        let known = match &self.joints {
            JointsSolved::None => joints.is_empty(),
            JointsSolved::Some(known) => joints.iter().all(|joint| known.contains(joint)),
            JointsSolved::All => true,
        };
        if !known {
            self.mechanics
                .solve_joints(|joint| joints.contains(&joint))?;
            self.joints = JointsSolved::Some(joints.to_vec());
        }
        Ok(())
    }

    fn pose(&self, pose: usize) -> &PoseMechanics {
        self.mechanics.pose(pose)
    }

    fn joint_names(&self) -> Vec<String> {
        self.mechanics.joint_names().map(str::to_owned).collect()
    }
}
