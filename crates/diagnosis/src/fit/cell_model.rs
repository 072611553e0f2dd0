//! Stiffness of many cells of the experiment as a function of the fitting factors: of beams with exact derivatives, with physics beside them from
//! predicted readings.

use std::sync::Arc;

use stiffbench_beams::physics::{JointRotations, Mechanics, PoseMechanics, RunLoads};
use stiffbench_beams::robot::{FittingFactors, Mechanism, ModelParameter, Robot, RobotError};
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::Cell;

use super::error::FitError;
use super::fixed_physics::{CellReadings, FixedPhysics};
use super::measured::MeasuredCompliance;
use super::problem::poses_of_cells;
use super::shares::Shares;
use crate::mismatch::CellSlopes;

/// Step of the logarithm of a factor in the derivatives beside physics: central differences keep nine digits of the ten that a solution has,
/// less four.
const LN_STEP: f64 = 1e-4;

/// Predicts the stiffness of cells (pose and direction) of one mechanism, with physics beside the beams as the estimator of the data makes it of
/// predicted readings.
///
/// The structure stays placed in all poses, so that a change of factors costs the solution of all of them at once, not a move.
#[derive(Debug)]
pub struct CellModel<'a> {
    mechanics: Mechanics<'a>,
    parameters: Vec<ModelParameter>,
    cells: Vec<PlacedCell>,
    physics: Option<&'a FixedPhysics>,
    joint_rotations: JointRotations,
    displacement_m: Vec<f64>,
}

/// What a cell reads.
#[derive(Debug)]
struct PlacedCell {
    /// Number of its pose.
    pose: usize,
    /// None without physics.
    readings: CellReadings,
    /// Its load, of one that is read along another axis.
    across: Option<LoadDirection>,
    /// The slopes that give it its compliance, with its series and its place there.
    slope: Option<(Arc<CellSlopes>, [usize; 2])>,
}

impl<'a> CellModel<'a> {
    /// Places the mechanism in the poses of `cells`, whose names must be the robot's; shares are those of `parameters`.
    ///
    /// # Errors
    /// [`RobotError::UnknownName`] for a pose, [`RobotError::Unreachable`], [`RobotError::Structure`].
    pub fn new(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        parameters: &[ModelParameter],
        cells: &[Cell],
    ) -> Result<Self, RobotError> {
        Self::with_across((robot, mechanism, None), parameters, cells, &[])
    }

    /// The same with what acts beside the beams of a robot, and with compliances along other axes than that of the load behind the cells.
    ///
    /// # Errors
    /// Those of [`CellModel::new`].
    pub(super) fn with_across(
        (robot, mechanism, physics): (&'a Robot, &'a Mechanism, Option<&'a FixedPhysics>),
        parameters: &[ModelParameter],
        cells: &[Cell],
        across: &[MeasuredCompliance],
    ) -> Result<Self, RobotError> {
        let along = cells.iter().map(|cell| (cell, None));
        let across = across.iter().map(|one| (&one.cell, Some(one.load.clone())));
        let is_whole = across.len() > 0;
        let all = along.chain(across);
        let (poses, places) = poses_of_cells(robot, all.clone().map(|(cell, _)| cell))?;
        let placed = all.zip(places).map(|((cell, across), pose)| PlacedCell {
            pose,
            readings: physics.map_or_else(
                || CellReadings::empty(cell.clone()),
                |physics| physics.readings(cell),
            ),
            across,
            slope: physics.and_then(|physics| physics.slope(cell)),
        });
        let acting = physics.map(|physics| &physics.acting);
        let mechanism = acting.map_or(mechanism, |acting| &acting.mechanism);
        let unit = FittingFactors::UNIT;
        let unit = acting.map_or_else(|| unit.clone(), |acting| acting.with_springs(&unit));
        // A structure that moves even with nominal sections is reported before any fit begins.
        let mut mechanics = Mechanics::rigid_with(robot, mechanism, parameters, &unit, &poses)?;
        if physics.is_some() {
            mechanics.solve_joints(|_| true)?;
        } else if is_whole {
            mechanics.differentiate_whole()?;
        }
        Ok(Self {
            mechanics,
            parameters: parameters.to_vec(),
            cells: placed.collect(),
            physics,
            joint_rotations: JointRotations::default(),
            displacement_m: Vec::new(),
        })
    }

    /// A cell, by its place in every result.
    pub(super) fn cell(&self, place: usize) -> Option<&Cell> {
        self.cells.get(place).map(|one| &one.readings.cell)
    }

    /// Stiffness of every cell, N/m, into `values`, and if asked for the shares of the parameters. What those of the factors leave of one is the
    /// share of springs and of the physics beside the beams. Behind the cells stand compliances along other axes than that of the load, m/N,
    /// with their derivatives.
    ///
    /// # Errors
    /// [`FitError::Robot`] if the structure cannot carry a load with these factors; with physics also [`FitError::NoPrediction`],
    /// [`FitError::NotFinite`] and [`FitError::NegativePrediction`].
    pub fn evaluate(
        &mut self,
        factors: &FittingFactors,
        values: &mut [f64],
        shares: Option<&mut [Shares]>,
    ) -> Result<(), FitError> {
        match self.physics {
            None => Ok(self.evaluate_beams(factors, values, shares)?),
            Some(physics) => self.evaluate_readings(physics, factors, values, shares),
        }
    }

    /// The same of beams alone.
    fn evaluate_beams(
        &mut self,
        factors: &FittingFactors,
        values: &mut [f64],
        mut shares: Option<&mut [Shares]>,
    ) -> Result<(), RobotError> {
        self.mechanics.set_factors_rigid(factors)?;
        for (place, cell) in self.cells.iter().enumerate() {
            let axis = cell.readings.cell.direction;
            let (read, along) = (axis.into(), LoadDirection::of_axis(axis));
            let load = cell.across.as_ref().unwrap_or(along);
            let pose = self.mechanics.pose(cell.pose);
            let compliance = pose.compliance(&read, load);
            let (value, unit) = match cell.across {
                None => (1.0 / compliance, -compliance),
                Some(_) => (compliance, 1.0),
            };
            values[place] = value;
            if let Some(shares) = shares.as_deref_mut() {
                let slopes = 0..self.parameters.len();
                let slopes = slopes.map(|one| pose.gradient(one, &read, load) / unit);
                shares[place].clear();
                shares[place].extend(slopes);
            }
        }
        Ok(())
    }

    /// The same of predicted readings, with differences for derivatives.
    fn evaluate_readings(
        &mut self,
        physics: &'a FixedPhysics,
        factors: &FittingFactors,
        stiffness_n_per_m: &mut [f64],
        shares: Option<&mut [Shares]>,
    ) -> Result<(), FitError> {
        if let Some(shares) = shares {
            for shares in shares.iter_mut() {
                shares.clear();
            }
            for index in 0..self.parameters.len() {
                let parameter = self.parameters[index].clone();
                let value = factors.get(&parameter);
                // Beyond zero a spring has no meaning: from there the difference is one-sided.
                let (steps, wide) = if parameter.is_factor() {
                    (
                        [value * LN_STEP.exp(), value * (-LN_STEP).exp()],
                        2.0 * LN_STEP,
                    )
                } else {
                    let step = LN_STEP * value.max(self.visible_spring(&parameter));
                    let low = (value - step).max(0.0);
                    ([value + step, low], value + step - low)
                };
                let mut sides = [stiffness_n_per_m.to_vec(), stiffness_n_per_m.to_vec()];
                for (side, step) in sides.iter_mut().zip(steps) {
                    let mut moved = factors.clone();
                    moved.set(&parameter, step);
                    self.stiffness_of_readings(physics, &moved, side)?;
                }
                let [up, down] = &sides;
                for (cell, shares) in shares.iter_mut().enumerate() {
                    let change = if self.cells[cell].across.is_some() {
                        up[cell] - down[cell]
                    } else {
                        (up[cell] / down[cell]).ln()
                    };
                    shares.push(change / wide);
                }
            }
        }
        self.stiffness_of_readings(physics, factors, stiffness_n_per_m)
    }

    /// The compliance of a spring that would add as much as the structure gives in the cell that shows it best, rad/(N·m); zero if none does.
    fn visible_spring(&self, spring: &ModelParameter) -> f64 {
        let place = self.parameters.iter().position(|known| known == spring);
        let share = |cell: &PlacedCell| {
            let axis = cell.readings.cell.direction.index();
            let pose = self.mechanics.pose(cell.pose);
            let gradient = place.map_or(0.0, |place| pose.gradient[place][axis][axis]);
            gradient / pose.influence.compliance[axis][axis]
        };
        let most = self.cells.iter().map(share).fold(0.0, f64::max);
        if most > 0.0 { 1.0 / most } else { 0.0 }
    }

    fn stiffness_of_readings(
        &mut self,
        physics: &'a FixedPhysics,
        factors: &FittingFactors,
        out: &mut [f64],
    ) -> Result<(), FitError> {
        self.mechanics
            .set_factors(&physics.acting.with_springs(factors))?;
        for (place, stiffness) in out.iter_mut().enumerate() {
            let by_slope = self.predicted_slope(physics, place)?;
            if self.cells[place].across.is_some() {
                *stiffness = by_slope.unwrap_or_default();
                continue;
            }
            if by_slope.is_none() {
                self.predict(physics, place)?;
            }
            let readings = &mut self.cells[place].readings;
            let value = match by_slope {
                Some(compliance) => Ok(compliance.recip()),
                None => physics.stiffness_n_per_m(readings, &self.displacement_m),
            };
            *stiffness = match value {
                Ok(value) if value > 0.0 => value,
                Ok(value) => {
                    return Err(FitError::NegativePrediction {
                        cell: readings.cell.clone(),
                        stiffness_n_per_m: value,
                    });
                }
                Err(reason) => {
                    return Err(FitError::NoPrediction {
                        cell: readings.cell.clone(),
                        reason,
                    });
                }
            };
        }
        Ok(())
    }

    /// Sequence number and displacement of every reading that the physics beside the beams was given, m; none for beams alone, of which
    /// the stiffness says all.
    ///
    /// # Errors
    /// As [`CellModel::evaluate`].
    pub fn displacements_m(
        &mut self,
        factors: &FittingFactors,
    ) -> Result<Vec<(u32, f64)>, FitError> {
        let mut displacements = Vec::new();
        let Some(physics) = self.physics else {
            return Ok(displacements);
        };
        self.mechanics
            .set_factors(&physics.acting.with_springs(factors))?;
        for place in 0..self.cells.len() {
            self.predict(physics, place)?;
            let readings = &self.cells[place].readings.readings;
            let numbers = readings.iter().map(|reading| reading.seq);
            displacements.extend(numbers.zip(self.displacement_m.iter().copied()));
        }
        Ok(displacements)
    }

    /// Stiffness of every cell, N/m.
    ///
    /// # Errors
    /// As [`CellModel::evaluate`].
    pub fn stiffness(&mut self, factors: &FittingFactors) -> Result<Vec<f64>, FitError> {
        let mut stiffness = vec![0.0; self.cells.len()];
        self.evaluate(factors, &mut stiffness, None)?;
        Ok(stiffness)
    }

    /// Compliance that slopes make of the predicted readings of a cell, m/N; `None` if it has it from elsewhere.
    ///
    /// # Errors
    /// [`FitError::NotFinite`].
    fn predicted_slope(
        &mut self,
        physics: &FixedPhysics,
        place: usize,
    ) -> Result<Option<f64>, FitError> {
        let PlacedCell { pose, slope, .. } = &self.cells[place];
        let Some((slopes, [series, own])) = slope else {
            return Ok(None);
        };
        let (series, observations) = (&slopes.series[*series], &slopes.observations);
        let first = series.readings().start;
        self.displacement_m.clear();
        self.displacement_m.resize(series.readings().len(), 0.0);
        for run in series.runs.clone() {
            let loads = observations.run_loads(run);
            let own = observations.runs[run].readings.clone();
            let out = &mut self.displacement_m[own.start - first..own.end - first];
            let pose = self.mechanics.pose(*pose);
            predict_run(physics, pose, &loads, &mut self.joint_rotations, out)?;
        }
        Ok(Some(series.estimate(*own, &self.displacement_m)))
    }

    /// Predicts the readings of a cell.
    ///
    /// # Errors
    /// [`FitError::NotFinite`].
    fn predict(&mut self, physics: &FixedPhysics, place: usize) -> Result<(), FitError> {
        let PlacedCell { pose, readings, .. } = &self.cells[place];
        let pose = self.mechanics.pose(*pose);
        let CellReadings {
            cell,
            readings,
            loads,
        } = readings;
        self.displacement_m.clear();
        self.displacement_m.resize(loads.len(), 0.0);
        let mut begin = 0;
        for run in readings.chunk_by(|a, b| a.run == b.run) {
            let places = begin..begin + run.len();
            begin = places.end;
            let loads = RunLoads {
                pose: &cell.pose,
                load: LoadDirection::of_axis(cell.direction),
                read: cell.direction.into(),
                repeat: run[0].repeat,
                release_n: physics.release_n(),
                loads: &loads[places.clone()],
            };
            let out = &mut self.displacement_m[places];
            predict_run(physics, pose, &loads, &mut self.joint_rotations, out)?;
        }
        Ok(())
    }
}

/// Predicts the readings of a run, m.
///
/// # Errors
/// [`FitError::NotFinite`].
fn predict_run(
    physics: &FixedPhysics,
    pose: &PoseMechanics,
    loads: &RunLoads<'_>,
    joint_rotations: &mut JointRotations,
    out: &mut [f64],
) -> Result<(), FitError> {
    let laws = &physics.acting.laws;
    laws.displacements_m(pose, loads, joint_rotations, out);
    match out.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(place) => Err(FitError::NotFinite {
            pose: loads.pose.clone(),
            direction: loads.read.axis(),
            force_n: loads.loads[place].force_n,
            repeat: loads.repeat,
            value: out[place],
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::hp_robot;
    use stiffbench_beams::physics::{ActingPhysics, Effect};
    use stiffbench_measurement::stiffness::Method;
    use stiffbench_units_and_text::test_point::{Direction, PoseId};

    const CLASSES: [ModelParameter; 8] = ModelParameter::CLASSES;

    fn physics(robot: &Robot, effects: &[&str], method: Method) -> FixedPhysics {
        let effects: Vec<Effect> = effects.iter().map(|text| text.parse().unwrap()).collect();
        let mechanism = robot.mechanism(Some("F")).unwrap();
        FixedPhysics::new(
            ActingPhysics::new(robot, mechanism, effects).unwrap(),
            method,
        )
    }

    fn with_physics<'a>(
        robot: &'a Robot,
        physics: &'a FixedPhysics,
        cells: &[Cell],
    ) -> Result<CellModel<'a>, RobotError> {
        let mechanism = robot.mechanism(Some("F"))?;
        let acting = (robot, mechanism, Some(physics));
        CellModel::with_across(acting, &CLASSES, cells, &[])
    }

    /// The same mechanism without effects.
    fn beams<'a>(robot: &'a Robot, cells: &[Cell]) -> CellModel<'a> {
        let mechanism = robot.mechanism(Some("F")).unwrap();
        CellModel::new(robot, mechanism, &CLASSES, cells).unwrap()
    }

    fn cells() -> Vec<Cell> {
        let of_pose = |pose: &str| {
            let pose = PoseId::new(pose);
            Direction::ALL.map(|direction| Cell::new(pose.clone(), direction))
        };
        ["P1", "P3"].into_iter().flat_map(of_pose).collect()
    }

    #[test]
    fn without_effects_stiffness_and_shares_are_those_of_the_beams() {
        let robot = hp_robot();
        let factors = robot.factor_set("m_fsd").unwrap();
        let cells = cells();
        let mut beams = beams(&robot, &cells);
        let evaluated = |model: &mut CellModel<'_>| {
            let mut stiffness = vec![0.0; cells.len()];
            let mut shares = vec![Vec::new(); cells.len()];
            model
                .evaluate(&factors, &mut stiffness, Some(&mut shares))
                .unwrap();
            (stiffness, shares)
        };
        let (expected, expected_shares) = evaluated(&mut beams);
        for method in [Method::Regression, Method::PaperMean] {
            let physics = physics(&robot, &[], method);
            let mut model = with_physics(&robot, &physics, &cells).unwrap();
            let (stiffness, shares) = evaluated(&mut model);
            for (cell, (k, expected)) in stiffness.iter().zip(&expected).enumerate() {
                assert!((k / expected - 1.0).abs() < 1e-8, "{k} {expected}");
                for (share, expected) in shares[cell].iter().zip(&expected_shares[cell]) {
                    assert!((share - expected).abs() < 1e-5, "{share} {expected}");
                }
            }
        }
    }

    #[test]
    fn stand_and_force_gauge_change_the_stiffness_by_their_formulas() {
        // The stand is linear: 1/K grows by its compliance.
        let robot = hp_robot();
        let factors = robot.factor_set("m_fsd").unwrap();
        let cells = cells();
        let stand = physics(
            &robot,
            &["gauge-stand-compliance@y:c=1um/N"],
            Method::PaperMean,
        );
        let mut beams = beams(&robot, &cells);
        let plain = beams.stiffness(&factors).unwrap();
        let mut model = with_physics(&robot, &stand, &cells).unwrap();
        let with_stand = model.stiffness(&factors).unwrap();
        for ((cell, k), with) in cells.iter().zip(&plain).zip(&with_stand) {
            let added = if cell.direction == Direction::Y {
                1e-6
            } else {
                0.0
            };
            assert!((with * (1.0 / k + added) - 1.0).abs() < 1e-8, "{cell}");
        }
        // F (1 + q |F|) at -10, -20, ... -70 N: K_paper = K mean(1/(1 + q F)), and the free slope over 0 to 70 N gives K/(1 + q 70 N).
        let (q, loads) = (1e-3, (1..=7).map(|i| 10.0 * f64::from(i)));
        let paper: f64 = loads.map(|force| 1.0 / (1.0 + q * force)).sum::<f64>() / 7.0;
        for (method, expected) in [(Method::PaperMean, paper), (Method::Regression, 1.0 / 1.07)] {
            let gauge = physics(&robot, &["force-gauge-nonlinearity:q=0.1%/N"], method);
            let mut model = with_physics(&robot, &gauge, &cells).unwrap();
            for (with, k) in model.stiffness(&factors).unwrap().iter().zip(&plain) {
                assert!(
                    (with / k / expected - 1.0).abs() < 1e-8,
                    "{method}: {}",
                    with / k
                );
            }
        }
    }

    #[test]
    fn a_load_turned_too_far_has_no_stiffness_to_compare() {
        let robot = hp_robot();
        let cells = cells();
        let physics = physics(
            &robot,
            &["load-misalignment@y>z:angle=3rad"],
            Method::Regression,
        );
        let mut model = with_physics(&robot, &physics, &cells).unwrap();
        let error = model.stiffness(&robot.factor_set("m_fsd").unwrap());
        assert!(
            matches!(error, Err(FitError::NegativePrediction { .. })),
            "{error:?}"
        );
    }

    #[test]
    fn a_reading_without_a_value_is_named() {
        let robot = hp_robot();
        let cells = cells();
        let physics = physics(
            &robot,
            &["creep@structure:k=1%/decade,t0=1s"],
            Method::Regression,
        );
        let mut model = with_physics(&robot, &physics, &cells).unwrap();
        // The fifth of the eight loads of the second run.
        model.cells[5].readings.loads[8 + 4].hold_s = f64::NAN;
        let factors = robot.factor_set("m_fsd").unwrap();
        let error = model.stiffness(&factors).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the model returned NaN at pose P3, F = -40 N along z, repeat 2"
        );
    }
}
