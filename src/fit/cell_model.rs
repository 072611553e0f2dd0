//! Stiffness of many cells of the experiment as a function of the fitting factors, with exact derivatives.

use crate::robot::{ElementClass, FittingFactors, Mechanism, Pose, Predictor, Robot, RobotError};
use crate::structure::ComplianceGradient;
use crate::test_point::{Cell, Direction, PoseId};

/// Number of fitting factors: four of beams, four of links.
pub const FACTORS: usize = 8;

/// Names of the factors in the order of [`factor_vector`].
pub const FACTOR_NAMES: [&str; FACTORS] = [
    "beam.A", "beam.Iy", "beam.Iz", "beam.J", "link.A", "link.Iy", "link.Iz", "link.J",
];

/// The factors as one vector: beams A, Iy, Iz, J, then links.
#[must_use]
pub fn factor_vector(factors: &FittingFactors) -> [f64; FACTORS] {
    std::array::from_fn(|i| {
        if i < 4 {
            factors.beam[i]
        } else {
            factors.link[i - 4]
        }
    })
}

/// Factors from a vector in the order of [`factor_vector`].
#[must_use]
pub fn factors_from_vector(vector: &[f64; FACTORS]) -> FittingFactors {
    FittingFactors {
        beam: std::array::from_fn(|i| vector[i]),
        link: std::array::from_fn(|i| vector[4 + i]),
    }
}

/// Shares of one cell's compliance that the factors own: u ᵀ a_i K_i u / C, order of [`factor_vector`]; they add up to one.
///
/// The share of a factor is also ∂ ln K / ∂ ln a: K is the stiffness at the end, a homogeneous function of the factors.
pub type Shares = [f64; FACTORS];

/// Predicts the stiffness of cells (pose and direction) of one mechanism.
///
/// One structure stays placed in each pose, so that a change of factors costs an assembly and a factorisation, not a move.
#[derive(Debug)]
pub struct CellModel<'a> {
    cells: Vec<Cell>,
    /// For each pose its structure, and the cells it serves by direction.
    poses: Vec<PlacedPose<'a>>,
}

#[derive(Debug)]
struct PlacedPose<'a> {
    predictor: Predictor<'a>,
    /// Class of each element.
    classes: Vec<ElementClass>,
    /// (place among the cells, direction).
    cells: Vec<(usize, Direction)>,
    gradient: Vec<ComplianceGradient>,
}

impl<'a> CellModel<'a> {
    /// Places the mechanism in the poses of `cells`, whose names must be the robot's.
    ///
    /// # Errors
    /// [`RobotError::UnknownName`] for a pose, [`RobotError::Unreachable`], [`RobotError::Structure`].
    pub fn new(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        cells: &[Cell],
    ) -> Result<Self, RobotError> {
        let mut names: Vec<&PoseId> = Vec::new();
        for cell in cells {
            if !names.contains(&&cell.pose) {
                names.push(&cell.pose);
            }
        }
        let poses = names
            .into_iter()
            .map(|name| {
                let cells = cells
                    .iter()
                    .enumerate()
                    .filter(|(_, cell)| cell.pose == *name);
                let cells = cells.map(|(place, cell)| (place, cell.direction)).collect();
                PlacedPose::new(robot, mechanism, robot.pose(name)?, cells)
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            cells: cells.to_vec(),
            poses,
        })
    }

    /// The cells, in the order of every result.
    #[must_use]
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// Stiffness of every cell, N/m, into `stiffness_n_per_m`, and if asked for the shares of the factors.
    ///
    /// # Errors
    /// [`RobotError::Structure`] if the structure cannot carry a load with these factors.
    pub fn evaluate(
        &mut self,
        factors: &FittingFactors,
        stiffness_n_per_m: &mut [f64],
        mut shares: Option<&mut [Shares]>,
    ) -> Result<(), RobotError> {
        for pose in &mut self.poses {
            pose.predictor.set_factors(factors)?;
            let compliance = pose.predictor.translation_compliance();
            for &(place, direction) in &pose.cells {
                let i = direction.index();
                stiffness_n_per_m[place] = 1.0 / compliance[i][i];
                if let Some(shares) = shares.as_deref_mut() {
                    pose.predictor.compliance_gradient(i, &mut pose.gradient);
                    shares[place] = by_factor(&pose.gradient, &pose.classes, compliance[i][i]);
                }
            }
        }
        Ok(())
    }

    /// Stiffness of every cell, N/m.
    ///
    /// # Errors
    /// As [`CellModel::evaluate`].
    pub fn stiffness(&mut self, factors: &FittingFactors) -> Result<Vec<f64>, RobotError> {
        let mut stiffness = vec![0.0; self.cells.len()];
        self.evaluate(factors, &mut stiffness, None)?;
        Ok(stiffness)
    }
}

impl<'a> PlacedPose<'a> {
    fn new(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        pose: &Pose,
        cells: Vec<(usize, Direction)>,
    ) -> Result<Self, RobotError> {
        let mut predictor = Predictor::new(robot, mechanism, &FittingFactors::UNIT)?;
        predictor.place(pose)?;
        let classes: Vec<ElementClass> = predictor
            .model()
            .members()
            .map(|member| member.class)
            .collect();
        Ok(Self {
            predictor,
            gradient: vec![[0.0; 4]; classes.len()],
            classes,
            cells,
        })
    }
}

/// Sums the elements' derivatives of a compliance by class and divides by minus the compliance.
fn by_factor(
    gradient: &[ComplianceGradient],
    classes: &[ElementClass],
    compliance_m_per_n: f64,
) -> Shares {
    let mut shares = [0.0; FACTORS];
    for (element, class) in gradient.iter().zip(classes) {
        let first = if *class == ElementClass::Beam { 0 } else { 4 };
        for (share, derivative) in shares[first..first + 4].iter_mut().zip(element) {
            *share -= derivative / compliance_m_per_n;
        }
    }
    shares
}
