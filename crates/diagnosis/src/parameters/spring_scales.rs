//! How large the compliance of a spring may plausibly be: by what it adds to measured displacements.

use stiffbench_beams::physics::{Mechanics, PlaceScale};
use stiffbench_beams::robot::{
    FittingFactors, Mechanism, ModelParameter, MultiPosePredictor, Pose, Robot, RobotError,
};
use stiffbench_units_and_text::test_point::Direction;

use crate::search::constants::OPEN_LOOP;

/// A spring begins at this share of the compliance that would add as much as the structure gives, if the start has none: at zero its
/// bound would hold it.
pub(crate) const FIRST_SPRING: f64 = 0.1;

/// Displacement per force, m/N, that stands for the structure's where that is rigid: a light industrial arm, softer than most.
const RIGID_ARM_M_PER_N: f64 = 1e-5;

/// A structure that gives less is rigid, and what it seems to give is rounding, m/N.
const RIGID_BELOW_M_PER_N: f64 = 1e-12;

/// Scale of each spring of a mechanism in cells.
#[derive(Debug, Clone)]
pub(crate) struct SpringScales {
    scales: Vec<(ModelParameter, PlaceScale)>,
}

/// What a spring does in a cell.
struct SpringInCell {
    /// Displacement per force and compliance of the spring: its load per force, squared.
    squared_lever: f64,
    /// Moment of the structure against a twist of the joint, N·m/rad; zero of all other springs.
    stiffness_nm_per_rad: f64,
    /// Displacement per force of the structure without springs, m/N.
    structure_m_per_n: f64,
}

impl SpringScales {
    /// # Arguments
    /// - `factors`: of the structure without springs of joints and base, which are left out.
    /// - `parameters`: the springs among them get a scale.
    /// - `cells`: number of the pose, and direction.
    ///
    /// # Errors
    /// [`RobotError`] for a pose or structure.
    pub(crate) fn new(
        robot: &Robot,
        mechanism: &Mechanism,
        factors: &FittingFactors,
        parameters: &[ModelParameter],
        poses: &[Pose],
        cells: &[(usize, Direction)],
    ) -> Result<Self, RobotError> {
        let springs = parameters.iter().filter(|parameter| !parameter.is_factor());
        let springs: Vec<ModelParameter> = springs.cloned().collect();
        let mut rigid = robot.with_own_springs(factors);
        for spring in rigid.springs.values_mut() {
            *spring = 0.0;
        }
        let mechanics = Mechanics::new(robot, mechanism, &rigid, poses)?;
        let mut predictor = MultiPosePredictor::new(robot, mechanism, &springs, poses.len())?;
        for (index, pose) in poses.iter().enumerate() {
            predictor.place(index, pose)?;
        }
        predictor.solve(&rigid, true)?;
        let scale = |(place, spring): (usize, &ModelParameter)| {
            let joint = mechanics
                .joint_names()
                .position(|name| *spring == ModelParameter::Joint(name.into()));
            let in_cell = |&(pose, direction): &(usize, Direction)| {
                let axis = direction.index();
                let gradient = predictor.gradient(pose, axis);
                let influence = &mechanics.pose(pose).influence;
                SpringInCell {
                    squared_lever: gradient.map_or(0.0, |gradient| gradient[place]),
                    stiffness_nm_per_rad: joint
                        .map_or(0.0, |joint| influence.stiffness(joint, joint).abs()),
                    structure_m_per_n: influence.compliance_m_per_n[axis][axis],
                }
            };
            (spring.clone(), scale_in(cells.iter().map(in_cell)))
        };
        let scales = springs.iter().enumerate().map(scale).collect();
        Ok(Self { scales })
    }

    /// The scale of a spring; zero of one on which no load acts, and of factors.
    pub(crate) fn of(&self, spring: &ModelParameter) -> PlaceScale {
        let mut scales = self.scales.iter();
        let own = scales.find(|(known, _)| known == spring);
        own.map_or_else(PlaceScale::default, |(_, scale)| *scale)
    }
}

/// The scale in the cell that shows a spring best.
fn scale_in(cells: impl Iterator<Item = SpringInCell>) -> PlaceScale {
    let (mut most, mut scale) = (0.0, PlaceScale::default());
    for cell in cells {
        let lever = cell.squared_lever;
        let structure = if cell.structure_m_per_n > RIGID_BELOW_M_PER_N {
            cell.structure_m_per_n
        } else {
            RIGID_ARM_M_PER_N
        };
        let share = lever / structure;
        if share > most {
            let stiffness = cell.stiffness_nm_per_rad;
            let is_open = lever > OPEN_LOOP * structure * stiffness;
            most = share;
            scale.compliance = 1.0 / share;
            scale.loop_nm_per_rad = if is_open { 0.0 } else { stiffness };
        }
    }
    scale
}
