//! The model of a robot with some of its parameters free.

use std::sync::OnceLock;

use stiffbench_beams::physics::laws::{LOOSE_MEMBER, WRONG_MECHANISM};
use stiffbench_beams::physics::{
    Effect, FileSuspects, Law, Mechanics, Place, PlaceScale, without_elements,
};
use stiffbench_beams::robot::{
    FittingFactors, Mechanism, ModelParameter, MultiPosePredictor, Pose, Predictor, Robot,
    RobotError, TRACKER_PARAMETERS, TrackedPoses, TrackerFrames,
};
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use crate::parameters::{
    ChosenParameter, FIRST_SPRING, FitRole, ParameterChoice, ScaleCell, SpringScales,
};

use super::baseline::{
    Baseline, BaselineParameter, ElementCompliance, PoseSolver, StructureColumn,
};
use super::robot_solver::{RobotSolver, file_columns, spring_columns};
use crate::mismatch::error::MismatchError;

/// Half the width, in standard deviations, of the range that bounds leave to a factor: uniform over ± ln 10.
const PRIOR_WIDTHS: f64 = 1.732_050_807_568_877_2;

/// How far a tracker may stand, or be turned, from where a fit has it, m and rad: a fit to the rigid robot comes within millimetres.
const TRACKER_RANGE: f64 = 1.0;

/// The model of a robot with some of its parameters free.
#[derive(Debug)]
pub struct RobotBaseline<'a> {
    pub(crate) robot: &'a Robot,
    /// The whole mechanism, then those without one or two elements, then other mechanisms of the file.
    mechanisms: Vec<(VariantKey, Mechanism)>,
    pub(crate) values: BaselineValues,
    pub(crate) poses: Vec<Pose>,
    /// Entries of the robot file, made when they are asked for.
    suspects: OnceLock<FileSuspects>,
    /// Whether they are candidates of a search.
    suspects_file: bool,
    parameters: Vec<BaselineParameter>,
    /// The free springs as effects, of any size.
    springs: Vec<Effect>,
    joints: Vec<Place>,
    unloaded: Vec<ModelParameter>,
    /// A tracker: where it stands, and which point of the tool it measures, is free, and own weight moves the tool.
    tracked: Option<TrackedPoses>,
}

/// What distinguishes a structure from the one of the session.
#[derive(Debug, Clone, PartialEq, Default)]
struct VariantKey {
    /// The mechanism of the file, if it is another.
    mechanism: Option<String>,
    /// Elements that are missing, in the order of their names.
    loose: Vec<String>,
}

impl VariantKey {
    fn of(effects: &[Effect]) -> Self {
        let mut key = Self::default();
        for effect in effects {
            match &effect.place {
                Place::Element(name) if effect.law.is_missing_element() => {
                    key.loose.push(name.clone());
                }
                Place::Mechanism(name) => key.mechanism = Some(name.clone()),
                _ => {}
            }
        }
        key.loose.sort();
        key
    }
}

/// Values of all parameters, some of which are free.
#[derive(Debug, Clone)]
pub(crate) struct BaselineValues {
    pub(crate) at: FittingFactors,
    pub(crate) free: Vec<ModelParameter>,
    /// As [`BaselineParameter::spring_rad_per_nm`].
    pub(crate) springs_rad_per_nm: Vec<Option<f64>>,
}

impl BaselineValues {
    /// What derivatives to each free parameter are multiplied by.
    pub(crate) fn units(&self) -> Vec<f64> {
        let units = self.springs_rad_per_nm.iter();
        units.map(|unit| unit.unwrap_or(1.0)).collect()
    }

    /// Takes fitted values.
    pub(crate) fn set(&mut self, fitted: &[f64]) {
        let free = self.free.iter().zip(&self.springs_rad_per_nm);
        for ((parameter, spring), fitted) in free.zip(fitted) {
            let value = spring.map_or_else(|| fitted.exp(), |scale| scale * fitted);
            self.at.set(parameter, value);
        }
    }
}

/// Most poses in each of which the angle of a joint may be wrong by itself: candidates and the effort of each grow with the poses.
const MOST_SUSPECTED_POSES: usize = 50;

impl<'a> RobotBaseline<'a> {
    /// The baseline of a mechanism in the poses of a session.
    ///
    /// # Arguments
    /// - `factors`: where the free parameters start, and what the others are kept at.
    /// - `choice`: which parameters are free, and their bounds. A tied spring is free by itself; one that no load acts on is kept
    ///   ([`RobotBaseline::unloaded`]).
    /// - `measured_m_per_n`: largest displacement per force that was measured, m/N, which bounds the springs of a robot that is softer than its
    ///   file says ([`Observations::largest_m_per_n`](crate::mismatch::Observations::largest_m_per_n)); zero before a measurement.
    ///
    /// # Errors
    /// [`MismatchError::Robot`] for a structure that carries nothing, [`MismatchError::Parameter`] for a factor that is tied, and a parameter
    /// that has no room.
    pub fn new(
        robot: &'a Robot,
        mechanism: &Mechanism,
        factors: FittingFactors,
        poses: Vec<Pose>,
        choice: &ParameterChoice,
        measured_m_per_n: f64,
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
                    measured_m_per_n,
                })
            };
            let cells: Vec<ScaleCell> = (0..poses.len()).flat_map(of_pose).collect();
            let wanted: Vec<ModelParameter> =
                free.iter().map(|chosen| chosen.parameter.clone()).collect();
            Some(SpringScales::new(
                robot, mechanism, &factors, &wanted, &poses, &cells,
            )?)
        };
        let scale = |parameter: &ModelParameter| scales.as_ref().map(|scales| scales.of(parameter));
        let is_unloaded = |chosen: &&ChosenParameter| {
            let scale = scale(&chosen.parameter).unwrap_or_default();
            !chosen.parameter.is_factor() && scale.compliance == 0.0
        };
        let (unloaded, free): (Vec<_>, Vec<_>) = free.into_iter().partition(is_unloaded);
        let parameters = free
            .iter()
            .map(|chosen| parameter(chosen, &factors, choice.range, scale(&chosen.parameter)));
        let parameters: Vec<BaselineParameter> = parameters.collect::<Result<_, _>>()?;
        let values = BaselineValues {
            at: factors,
            free: free.iter().map(|chosen| chosen.parameter.clone()).collect(),
            springs_rad_per_nm: parameters.iter().map(|p| p.spring_rad_per_nm).collect(),
        };
        let joints = mechanism
            .joints(robot)
            .into_iter()
            .map(|joint| Place::of_joint(&robot.joints[joint].name, robot.joints[joint].motion))
            .collect();
        let mut mechanisms = vec![(VariantKey::default(), mechanism.clone())];
        for &member in &mechanism.members {
            let mut rest = mechanism.clone();
            rest.members.retain(|other| *other != member);
            let name = robot.members[member].name.clone();
            if carries_loads(robot, &rest, &values.at, &poses) {
                let loose = vec![name];
                let mechanism = None;
                mechanisms.push((VariantKey { mechanism, loose }, rest));
            }
        }
        Ok(Self {
            robot,
            springs: (free.iter())
                .filter_map(|chosen| Effect::of_spring(&chosen.parameter, 1.0))
                .collect(),
            mechanisms,
            values,
            poses,
            parameters,
            joints,
            unloaded: (unloaded.iter().map(|chosen| chosen.parameter.clone())).collect(),
            suspects: OnceLock::new(),
            suspects_file: false,
            tracked: None,
        })
    }

    /// Frees where a tracker stands and which point of the tool it sees; own weight counts from now on.
    ///
    /// # Arguments
    /// - `frames`: about which they are free.
    ///
    /// # Errors
    /// [`MismatchError::Robot`] for a pose that cannot be reached.
    pub fn track(&mut self, frames: &TrackerFrames) -> Result<(), MismatchError> {
        let mechanism = &self.mechanisms[0].1;
        let tracked = TrackedPoses::new(self.robot, mechanism, &self.poses, *frames)?;
        self.parameters
            .extend(TRACKER_PARAMETERS.map(|name| BaselineParameter {
                name: name.to_owned(),
                spring_rad_per_nm: None,
                unit: 1.0,
                start: 0.0,
                lower: -TRACKER_RANGE,
                upper: TRACKER_RANGE,
                prior_sd: TRACKER_RANGE / PRIOR_WIDTHS,
            }));
        self.tracked = Some(tracked);
        Ok(())
    }

    /// What a tracker sees of it.
    pub(crate) fn tracked(&self) -> Option<&TrackedPoses> {
        self.tracked.as_ref()
    }

    /// Springs that are kept though they were to be free: no load along the base axes acts on them in these poses.
    #[must_use]
    pub fn unloaded(&self) -> &[ModelParameter] {
        &self.unloaded
    }

    /// Searches for mistakes of the robot file too: lengths, angles, sections, factors, the mechanism.
    pub fn suspect_file(&mut self) {
        self.suspects_file = true;
        for (name, other) in &self.robot.mechanisms {
            let is_another = other.members != self.mechanisms[0].1.members;
            if is_another && carries_loads(self.robot, other, &self.values.at, &self.poses) {
                let key = VariantKey {
                    mechanism: Some(name.clone()),
                    loose: Vec::new(),
                };
                self.mechanisms.push((key, other.clone()));
            }
        }
    }

    /// A mechanism in poses, differentiated to the free parameters in their units, under own weight where a tracker sees it.
    ///
    /// # Errors
    /// [`RobotError`] for a pose that cannot be reached, or in which the structure carries nothing.
    pub(crate) fn mechanics<'m>(
        &self,
        (robot, mechanism): (&'m Robot, &'m Mechanism),
        factors: &FittingFactors,
        poses: &[Pose],
    ) -> Result<Mechanics<'m>, RobotError> {
        let free = &self.values.free;
        let mut mechanics = Mechanics::rigid_with(robot, mechanism, free, factors, poses)?;
        mechanics.differentiate_in(self.values.units());
        if self.tracked.is_some() {
            mechanics.weigh(free)?;
        }
        Ok(mechanics)
    }

    /// The mechanism of the session.
    pub(crate) fn mechanism(&self) -> &Mechanism {
        &self.mechanisms[0].1
    }

    /// Entries of the robot file that may be wrong.
    pub fn suspects(&self) -> &FileSuspects {
        self.suspects.get_or_init(|| {
            let named = self.robot.poses.iter();
            let named = named.filter(|named| self.poses.contains(&named.pose));
            let mut poses: Vec<PoseId> = named.map(|named| named.id.clone()).collect();
            if poses.len() > MOST_SUSPECTED_POSES {
                poses.clear();
            }
            FileSuspects::new(self.robot, &self.mechanisms[0].1, &poses, &self.values.free)
        })
    }

    /// The name of a pose in the robot file.
    pub(crate) fn pose_id(&self, pose: &Pose) -> Option<&PoseId> {
        let mut named = self.robot.poses.iter();
        named
            .find(|named| named.pose == *pose)
            .map(|named| &named.id)
    }

    /// Values of all parameters of the model where the free ones have these fitted values.
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
        let key = VariantKey::of(effects);
        if self.mechanisms.iter().all(|(known, _)| *known != key) {
            let whole = match &key.mechanism {
                Some(name) => self.robot.mechanism(Some(name))?,
                None => &self.mechanisms[0].1,
            };
            let rest = without_elements(self.robot, whole, effects)?;
            self.mechanisms.push((key, rest));
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
    if chosen.role != FitRole::Free && chosen.parameter.is_factor() {
        return Err(wrong("a search keeps or frees a parameter, and ties none"));
    }
    if chosen.parameter.is_factor() {
        let [lower, upper] = chosen.bounds.unwrap_or(range.map(|times| times * value));
        return Ok(BaselineParameter {
            spring_rad_per_nm: None,
            unit: 1.0,
            start: value.ln(),
            lower: lower.ln(),
            upper: upper.ln(),
            prior_sd: 0.5 * (upper / lower).ln() / PRIOR_WIDTHS,
            name,
        });
    }
    let scale = scale.unwrap_or_default();
    let bounds = chosen.bounds.unwrap_or(scale.plausible_compliance());
    let [lower, upper] = bounds.map(|bound| bound / scale.compliance);
    if lower >= upper {
        return Err(wrong("its bounds leave no room"));
    }
    let begin = value / scale.compliance;
    let begin = if begin == 0.0 { FIRST_SPRING } else { begin };
    Ok(BaselineParameter {
        spring_rad_per_nm: Some(scale.compliance),
        unit: 1.0,
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

impl Baseline for RobotBaseline<'_> {
    fn parameters(&self) -> &[BaselineParameter] {
        &self.parameters
    }

    fn described(&self) -> &[BaselineParameter] {
        &self.parameters[..self.values.free.len()]
    }

    fn solver(&self, variant: usize) -> Result<Box<dyn PoseSolver + '_>, MismatchError> {
        let mechanism = &self.mechanisms[variant].1;
        let mechanics = self.mechanics((self.robot, mechanism), &self.values.at, &self.poses)?;
        Ok(Box::new(RobotSolver::new(self, mechanism, mechanics)))
    }

    fn variants(&self) -> usize {
        self.mechanisms.len()
    }

    fn variant(&self, effects: &[Effect]) -> Option<usize> {
        let key = VariantKey::of(effects);
        self.mechanisms.iter().position(|(known, _)| *known == key)
    }

    fn rocking_axes(&self) -> Vec<Direction> {
        self.robot.rocking_axes().collect()
    }

    fn other_structures(&self) -> Vec<Effect> {
        let effect = |law: Law, place| Effect {
            law,
            place,
            values: Vec::new(),
        };
        let variants = self.mechanisms[1..].iter().filter_map(|(key, _)| {
            Some(match (&key.mechanism, &key.loose[..]) {
                (None, [name]) => effect(LOOSE_MEMBER, Place::Element(name.clone())),
                (Some(name), []) => effect(WRONG_MECHANISM, Place::Mechanism(name.clone())),
                _ => return None,
            })
        });
        variants.collect()
    }

    fn contains(&self, law: Law, place: &Place, fitted: &[f64]) -> bool {
        let mut springs = self.springs.iter();
        if springs.any(|spring| spring.law == law && spring.place == *place) {
            return true;
        }
        let Place::Group { group, property } = place else {
            return false;
        };
        let all = self.parameters.iter().zip(fitted);
        let mut of_group = all.filter(|(parameter, _)| {
            let of = parameter.name.rsplit_once('.');
            of.is_some_and(|(of, constant)| {
                of == group && property.is_none_or(|property| property.name() == constant)
            })
        });
        of_group.any(|(parameter, value)| property.is_none() || !parameter.is_at_bound(*value))
    }

    fn joints(&self) -> &[Place] {
        &self.joints
    }

    fn spring_columns(&self, parameters: &[f64]) -> Result<Vec<StructureColumn>, MismatchError> {
        spring_columns(self, parameters)
    }

    fn file_columns(&self, parameters: &[f64]) -> Result<Vec<StructureColumn>, MismatchError> {
        if !self.suspects_file {
            return Ok(Vec::new());
        }
        file_columns(self, parameters)
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
