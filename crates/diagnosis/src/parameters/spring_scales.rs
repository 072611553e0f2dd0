//! How large the compliance of a spring may plausibly be: by what it adds to measured displacements.

use stiffbench_beams::physics::{Mechanics, PlaceScale};
use stiffbench_beams::robot::{FittingFactors, Mechanism, ModelParameter, Pose, Robot, RobotError};
use stiffbench_units_and_text::test_point::Direction;

use crate::search::constants::OPEN_LOOP;

/// A spring begins at this share of the compliance that would add as much as the structure gives, if the start has none: at zero its
/// bound would hold it.
pub(crate) const FIRST_SPRING: f64 = 0.1;

/// Scale of each spring of a mechanism in cells.
#[derive(Debug, Clone)]
pub(crate) struct SpringScales {
    scales: Vec<(ModelParameter, PlaceScale)>,
}

impl SpringScales {
    /// # Arguments
    /// - `factors`: of the structure without springs, which are left out.
    /// - `cells`: number of the pose, and direction.
    ///
    /// # Errors
    /// [`RobotError`] for a pose or structure.
    pub(crate) fn new(
        robot: &Robot,
        mechanism: &Mechanism,
        factors: &FittingFactors,
        poses: &[Pose],
        cells: &[(usize, Direction)],
    ) -> Result<Self, RobotError> {
        let mechanics = Mechanics::new(robot, mechanism, &factors.without_springs(), poses)?;
        let joints = mechanics.joint_names().enumerate();
        let joints = joints.map(|(place, name)| (ModelParameter::Joint(name.into()), Some(place)));
        let base = Direction::ALL.map(|axis| (ModelParameter::Base(axis), None));
        let scale = |(spring, joint): (ModelParameter, Option<usize>)| {
            let scale = scale_in(&mechanics, cells, &spring, joint);
            (spring, scale)
        };
        Ok(Self {
            scales: joints.chain(base).map(scale).collect(),
        })
    }

    /// The scale of a spring; zero of one on which no load acts, and of factors.
    pub(crate) fn of(&self, spring: &ModelParameter) -> PlaceScale {
        let mut scales = self.scales.iter();
        let own = scales.find(|(known, _)| known == spring);
        own.map_or_else(PlaceScale::default, |(_, scale)| *scale)
    }
}

/// The scale in the cell that shows a spring best.
fn scale_in(
    mechanics: &Mechanics<'_>,
    cells: &[(usize, Direction)],
    spring: &ModelParameter,
    joint: Option<usize>,
) -> PlaceScale {
    let (mut most, mut scale) = (0.0, PlaceScale::default());
    for &(pose, direction) in cells {
        let (pose, axis) = (mechanics.pose(pose), direction.index());
        let influence = &pose.influence;
        let lever = match (spring, joint) {
            (ModelParameter::Base(about), _) => pose.base_levers_m[about.index()][axis],
            (_, Some(joint)) => influence.levers_m[joint][axis],
            _ => 0.0,
        };
        let structure = influence.compliance_m_per_n[axis][axis];
        let share = lever * lever / structure;
        if share > most {
            let stiffness = joint.map_or(0.0, |joint| influence.stiffness(joint, joint).abs());
            let is_open = lever * lever > OPEN_LOOP * structure * stiffness;
            most = share;
            scale.compliance = 1.0 / share;
            scale.loop_nm_per_rad = if is_open { 0.0 } else { stiffness };
        }
    }
    scale
}
