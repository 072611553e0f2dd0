//! How large the compliance of a spring may plausibly be: by what it adds to measured displacements.

use stiffbench_beams::physics::{Effect, Mechanics, PlaceScale};
use stiffbench_beams::robot::{
    FittingFactors, Mechanism, ModelParameter, MultiPosePredictor, Pose, Robot, RobotError,
};
use stiffbench_units_and_text::test_point::Direction;

use crate::search::constants::OPEN_LOOP;

/// A spring begins at this share of the compliance that would add as much as the robot gives, if the start has none: at zero its
/// bound would hold it.
pub(crate) const FIRST_SPRING: f64 = 0.1;

/// Displacement per force, m/N, that stands for the structure's where that is rigid: a light industrial arm, softer than most.
const RIGID_ARM_M_PER_N: f64 = 1e-5;

/// A structure that gives less is rigid, and what it seems to give is rounding, m/N.
const RIGID_BELOW_M_PER_N: f64 = 1e-12;

/// A spring that moves the end by less than this share of what one of its kind does bears no load: the rest is rounding of angles.
pub(crate) const UNLOADED: f64 = 1e-7;

/// Whether a spring bears no load, by the compliance at which it adds as much as the robot has, and the least of those of its kind or that of
/// a lever of 1 m: these go with the square of the lever.
pub(crate) fn bears_no_load(compliance: f64, least: f64) -> bool {
    compliance * UNLOADED * UNLOADED > least.min(RIGID_ARM_M_PER_N)
}

/// Scale of each spring of a mechanism in cells.
#[derive(Debug, Clone)]
pub(crate) struct SpringScales {
    scales: Vec<(ModelParameter, PlaceScale)>,
}

/// A pose and a direction, and what is known there of the whole robot.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ScaleCell {
    /// Number of the pose.
    pub(crate) pose: usize,
    /// The direction.
    pub(crate) direction: Direction,
    /// Displacement per force that was measured, m/N; 0 if none was.
    pub(crate) measured_m_per_n: f64,
}

impl SpringScales {
    /// # Arguments
    /// - `factors`: where a fit begins.
    /// - `parameters`: the springs among them get a scale.
    /// - `cells`: where they are looked at.
    ///
    /// # Errors
    /// [`RobotError`] for a pose or structure.
    pub(crate) fn new(
        robot: &Robot,
        mechanism: &Mechanism,
        factors: &FittingFactors,
        parameters: &[ModelParameter],
        poses: &[Pose],
        cells: &[ScaleCell],
    ) -> Result<Self, RobotError> {
        let springs = parameters.iter().filter(|parameter| !parameter.is_factor());
        let springs: Vec<ModelParameter> = springs.cloned().collect();
        let start = robot.with_own_springs(factors);
        let mut rigid = start.clone();
        for spring in rigid.springs.values_mut() {
            *spring = 0.0;
        }
        let mechanics = Mechanics::new(robot, mechanism, &rigid, poses)?;
        let with_springs = if start == rigid {
            None
        } else {
            Some(Mechanics::new(robot, mechanism, &start, poses)?)
        };
        let mut predictor = MultiPosePredictor::new(robot, mechanism, &springs, poses.len())?;
        for (index, pose) in poses.iter().enumerate() {
            predictor.place(index, pose)?;
        }
        predictor.solve(&rigid, true)?;
        let scale = |(place, spring): (usize, &ModelParameter)| {
            let own = Effect::of_spring(spring, 0.0).map(|effect| effect.place);
            let joint = mechanics.joints().position(|place| Some(place) == own);
            // That in the cell that shows the spring best.
            let (mut most, mut scale) = (0.0, PlaceScale::default());
            for cell in cells {
                let (pose, axis) = (cell.pose, cell.direction.index());
                let of_axis = |mechanics: &Mechanics<'_>| {
                    mechanics.pose(pose).influence.compliance[axis][axis]
                };
                // Displacement per force and compliance of the spring: its load per force, squared.
                let gradient = predictor.gradient(pose, axis);
                let squared_lever = gradient.map_or(0.0, |gradient| gradient[place]);
                // Without springs, with those of the start, and as measured: on stiff links nearly all is springs.
                let structure = of_axis(&mechanics);
                let of_start = with_springs.as_ref().map_or(0.0, of_axis);
                let robot = structure.max(of_start).max(cell.measured_m_per_n);
                let share = squared_lever / known(robot);
                if share > most {
                    // Moment of the structure against a twist of the joint, N·m/rad; zero of all other springs.
                    let influence = &mechanics.pose(pose).influence;
                    let stiffness =
                        joint.map_or(0.0, |joint| influence.stiffness(joint, joint).abs());
                    let is_open = squared_lever > OPEN_LOOP * known(structure) * stiffness;
                    most = share;
                    scale.compliance = 1.0 / share;
                    scale.loop_nm_per_rad = if is_open { 0.0 } else { stiffness };
                }
            }
            (spring.clone(), scale)
        };
        let mut scales: Vec<_> = springs.iter().enumerate().map(scale).collect();
        let least_of = |unit: &str| {
            let alike = scales.iter().filter(|(spring, _)| spring.unit() == unit);
            let loaded = alike.map(|(_, scale)| scale.compliance);
            loaded
                .filter(|compliance| *compliance > 0.0)
                .fold(f64::INFINITY, f64::min)
        };
        let least: Vec<f64> = springs
            .iter()
            .map(|spring| least_of(spring.unit()))
            .collect();
        for ((_, scale), least) in scales.iter_mut().zip(least) {
            if bears_no_load(scale.compliance, least) {
                *scale = PlaceScale::default();
            }
        }
        Ok(Self { scales })
    }

    /// The scale of a spring; zero of one on which no load acts, and of factors.
    pub(crate) fn of(&self, spring: &ModelParameter) -> PlaceScale {
        let mut scales = self.scales.iter();
        let own = scales.find(|(known, _)| known == spring);
        own.map_or_else(PlaceScale::default, |(_, scale)| *scale)
    }
}

/// Displacement per force of a structure, m/N; of a rigid one that of a usual arm.
fn known(m_per_n: f64) -> f64 {
    if m_per_n > RIGID_BELOW_M_PER_N {
        m_per_n
    } else {
        RIGID_ARM_M_PER_N
    }
}
