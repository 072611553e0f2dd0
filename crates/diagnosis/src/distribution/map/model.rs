//! A mechanism with its physics, solved in any pose.
//!
//! Joints that are rigid or yield in proportion go through the lanes of [`PoseSweep`], a rocking base beside them, and what those do not
//! serve through the general solver; laws that are not linear have the secant stiffness of a stated load along each axis, from the
//! unloaded state. What is used is said ([`MapModel::method`]).

mod batch;

use rayon::prelude::*;

use stiffbench_beams::physics::{
    ActingPhysics, EffectError, JointRotations, LoadPoint, Mechanics, RunLoads,
};
use stiffbench_beams::robot::{
    FittingFactors, JointModel, Keep, Mechanism, MechanismModel, Pose, PoseBundles, PoseSweep,
    Predictor, Robot, RobotError, Theory,
};
use stiffbench_beams::structure::{Compliance6, SolutionPath};
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::column::{MapColumn, fill_row, row_width};
use super::matrix::MatrixKind;
use crate::distribution::end_load::EndShift;

pub use batch::SolvedBatch;

/// Poses that a thread takes at a time where each is solved alone.
const CHUNK: usize = 256;

/// Why there is no map.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum NoMap {
    /// The robot cannot be built or solved.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Robot(#[from] RobotError),
    /// The physics does not fit the mechanism.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Effect(#[from] EffectError),
    /// A law that is not linear, and no load to take it at.
    #[error("{effect} is not linear: its stiffness depends on the load, and none is stated")]
    #[diagnostic(
        code(stiffbench::distribution::no_load),
        help("state the load for the secant stiffness, for example --at-load 50")
    )]
    NoLoad {
        /// The law and its place.
        effect: String,
    },
    /// A law that is not linear, and a question that only linear structures have an answer to.
    #[error(
        "{effect} is not linear: the displacement of the end is not its compliance times the load"
    )]
    #[diagnostic(
        code(stiffbench::distribution::linear_only),
        help("leave out the law; `stiffbench simulate` shows what it does under a load")
    )]
    LinearOnly {
        /// The law and its place.
        effect: String,
    },
    /// A law that is not linear, and a stiffness that only a linear structure has.
    #[error(
        "{effect} is not linear: there is no stiffness along {column}, only along x, y and z at the stated load"
    )]
    #[diagnostic(
        code(stiffbench::distribution::axes_only),
        help("leave out the other directions, or the law")
    )]
    AxesOnly {
        /// The law and its place.
        effect: String,
        /// What was asked for.
        column: String,
    },
}

/// A mechanism with its factors and physics.
#[derive(Debug)]
pub struct MapModel<'a> {
    robot: &'a Robot,
    physics: &'a ActingPhysics,
    factors: FittingFactors,
    means: SolutionMethod<'a>,
    /// Where the base rocks, m; `None` where it stands firm.
    rocks_at_m: Option<[f64; 3]>,
}

/// How the poses are solved.
#[derive(Debug)]
enum SolutionMethod<'a> {
    /// Linear.
    Sweep {
        sweep: Box<PoseSweep<'a>>,
        joints: JointModel,
    },
    /// By the law's own equations, under a load of this size along each axis.
    Secant { load_n: f64, effect: String },
}

impl<'a> MapModel<'a> {
    /// Prepares a mechanism; effects of the bench must not be among the physics.
    ///
    /// # Arguments
    /// - `factors`: without springs, which are effects of the physics here.
    /// - `load_n`: load at which laws that are not linear are taken, N; no others need it.
    ///
    /// # Errors
    /// [`NoMap`].
    pub fn new(
        robot: &'a Robot,
        physics: &'a ActingPhysics,
        factors: &FittingFactors,
        load_n: Option<f64>,
    ) -> Result<Self, NoMap> {
        let mechanism = &physics.mechanism;
        let factors = &physics.with_springs(factors);
        let crooked = physics
            .effects
            .iter()
            .find(|effect| effect.law.is_nonlinear_joint());
        let means = match (crooked, load_n) {
            (Some(effect), None) => {
                return Err(NoMap::NoLoad {
                    effect: effect.title(),
                });
            }
            (Some(effect), Some(load_n)) => SolutionMethod::Secant {
                load_n,
                effect: effect.title(),
            },
            (None, _) => {
                let joints = yielding_joints(robot, physics);
                let (theory, path) = (Theory::EulerBernoulli, SolutionPath::Fastest);
                let all = joints.clone();
                let sweep = PoseSweep::with(robot, mechanism, all, theory, factors, path)?;
                SolutionMethod::Sweep {
                    sweep: Box::new(sweep),
                    joints,
                }
            }
        };
        let rocks = physics.laws.base_rad_per_nm() != [0.0; 3];
        Ok(Self {
            robot,
            physics,
            factors: factors.clone(),
            means,
            rocks_at_m: if rocks {
                Some(support_m(robot, mechanism)?)
            } else {
                None
            },
        })
    }

    /// The robot.
    #[must_use]
    pub fn robot(&self) -> &'a Robot {
        self.robot
    }

    /// The mechanism, without loose members.
    #[must_use]
    pub fn mechanism(&self) -> &'a Mechanism {
        &self.physics.mechanism
    }

    /// The factors.
    #[must_use]
    pub fn factors(&self) -> &FittingFactors {
        &self.factors
    }

    /// The joints, if all laws in them are linear.
    pub(in crate::distribution) fn joints(&self) -> Option<&JointModel> {
        match &self.means {
            SolutionMethod::Sweep { joints, .. } => Some(joints),
            SolutionMethod::Secant { .. } => None,
        }
    }

    /// How the poses are solved, part by part, for those who want to know.
    #[must_use]
    pub fn method(&self) -> Vec<String> {
        let mut words: Vec<String> = match &self.means {
            SolutionMethod::Sweep { sweep, .. } if !sweep.methods().is_empty() => {
                let (name, lanes) = sweep.instructions();
                let parts = sweep.methods().iter().map(ToString::to_string);
                let set = format!("{lanes} poses at once, instruction set {name}");
                parts.chain([set]).collect()
            }
            SolutionMethod::Sweep { .. } => vec!["general solver, pose by pose".to_owned()],
            SolutionMethod::Secant { load_n, effect } => vec![format!(
                "secant stiffness from no load to {load_n} N, pose by pose: {effect} is not linear"
            )],
        };
        if self.rocks_at_m.is_some() {
            words.push("the rocking of the base added".to_owned());
        }
        words
    }

    /// Fills one row a pose; returns the poses that have none, in order, with the reason.
    pub(super) fn rows(
        &self,
        poses: &[Pose],
        columns: &[MapColumn],
        matrix: Option<MatrixKind>,
        rows: &mut [f64],
    ) -> Result<Vec<(usize, String)>, NoMap> {
        self.check(columns)?;
        if matrix.is_none() && !self.is_linear() {
            return Ok(self.rows_alone(poses, columns, rows));
        }
        Ok(self.swept_rows(self.sweep()?, poses, (columns, matrix), rows))
    }

    /// Fills rows from a sweep.
    fn swept_rows(
        &self,
        sweep: &PoseSweep<'_>,
        poses: &[Pose],
        (columns, matrix): (&[MapColumn], Option<MatrixKind>),
        rows: &mut [f64],
    ) -> Vec<(usize, String)> {
        let swept = sweep.run(poses, Keep::Full);
        let solved = swept.poses.par_iter().zip(&swept.compliances);
        let rows = rows.par_chunks_mut(row_width(columns, matrix));
        solved.zip(rows).for_each(|((pose, compliance), row)| {
            if let (Some(pose), Some(compliance)) = (pose, compliance) {
                let compliance = self.on_its_base(compliance, pose.end_m);
                row[..3].copy_from_slice(&pose.end_m);
                fill_row(columns, matrix, &compliance, row);
            }
        });
        let failed = swept.failed.into_iter();
        failed
            .map(|(place, error)| (place, error.to_string()))
            .collect()
    }

    /// Fills rows one pose at a time, on all cores.
    fn rows_alone(
        &self,
        poses: &[Pose],
        columns: &[MapColumn],
        rows: &mut [f64],
    ) -> Vec<(usize, String)> {
        let width = row_width(columns, None);
        let chunks = poses
            .par_chunks(CHUNK)
            .zip(rows.par_chunks_mut(CHUNK * width));
        let failed: Vec<Vec<(usize, String)>> = chunks
            .enumerate()
            .map(|(chunk, (poses, rows))| {
                let mut alone = SinglePoseSolver::new(self);
                let solved = poses.iter().zip(rows.chunks_exact_mut(width)).enumerate();
                let failed = solved.filter_map(|(place, (pose, row))| {
                    let error = alone.row(pose, columns, row).err()?;
                    Some((chunk * CHUNK + place, error.to_string()))
                });
                failed.collect()
            })
            .collect();
        failed.into_iter().flatten().collect()
    }

    /// The compliance with what the rocking of the base adds.
    pub(in crate::distribution) fn on_its_base(
        &self,
        compliance: &Compliance6,
        end_m: [f64; 3],
    ) -> Compliance6 {
        self.rocks_at_m.map_or(*compliance, |support_m| {
            self.physics.with_base_at(compliance, support_m, end_m)
        })
    }

    /// How the end moves because the base rocks under moments, N·m, which `about` gives about a point; `None` where it stands firm.
    pub(in crate::distribution) fn rocking_under(
        &self,
        about: impl Fn([f64; 3]) -> [f64; 3],
        end_m: [f64; 3],
    ) -> Option<EndShift> {
        let support_m = self.rocks_at_m?;
        let (compliance, moment) = (self.physics.laws.base_rad_per_nm(), about(support_m));
        let rotation_rad = [0, 1, 2].map(|axis| compliance[axis] * moment[axis]);
        Some(EndShift::turned(rotation_rad, support_m, end_m))
    }

    /// The sweep over poses; laws that are not linear are refused.
    pub(in crate::distribution) fn sweep(&self) -> Result<&PoseSweep<'_>, NoMap> {
        match &self.means {
            SolutionMethod::Sweep { sweep, .. } => Ok(sweep),
            SolutionMethod::Secant { effect, .. } => Err(NoMap::LinearOnly {
                effect: effect.clone(),
            }),
        }
    }

    /// Refuses columns that the model has no answer to.
    ///
    /// # Errors
    /// [`NoMap::AxesOnly`].
    pub fn check(&self, columns: &[MapColumn]) -> Result<(), NoMap> {
        let SolutionMethod::Secant { effect, .. } = &self.means else {
            return Ok(());
        };
        match columns.iter().find(|column| column.axis().is_none()) {
            None => Ok(()),
            Some(column) => Err(NoMap::AxesOnly {
                effect: effect.clone(),
                column: column.name().to_owned(),
            }),
        }
    }

    /// Whether directions other than the axes, and principal stiffnesses, exist.
    #[must_use]
    pub fn is_linear(&self) -> bool {
        matches!(self.means, SolutionMethod::Sweep { .. })
    }
}

/// Solves one pose after another.
pub(super) struct SinglePoseSolver<'m, 'a> {
    model: &'m MapModel<'a>,
    lanes: Option<PoseBundles<'m>>,
    general: Option<Predictor<'a>>,
    secant: Option<(Mechanics<'a>, JointRotations)>,
}

impl<'m, 'a> SinglePoseSolver<'m, 'a> {
    pub(super) fn new(model: &'m MapModel<'a>) -> Self {
        let lanes = match &model.means {
            SolutionMethod::Sweep { sweep, .. } => sweep.bundles(1),
            SolutionMethod::Secant { .. } => None,
        };
        Self {
            model,
            lanes,
            general: None,
            secant: None,
        }
    }

    /// Fills the row of a pose.
    ///
    /// # Errors
    /// [`RobotError`] if it has none.
    pub(super) fn row(
        &mut self,
        pose: &Pose,
        columns: &[MapColumn],
        row: &mut [f64],
    ) -> Result<(), RobotError> {
        let model = self.model;
        let joints = match &model.means {
            SolutionMethod::Secant { load_n, .. } => {
                return self.secant_row(pose, *load_n, columns, row);
            }
            SolutionMethod::Sweep { joints, .. } => joints,
        };
        let solved = self.lanes.as_mut().and_then(|lanes| lanes.one(pose));
        let (end_m, compliance) = if let Some((swept, compliance)) = solved {
            (swept.end_m, compliance)
        } else {
            let predictor = match &mut self.general {
                Some(predictor) => predictor,
                empty => empty.insert(Predictor::with(
                    model.robot,
                    model.mechanism(),
                    joints,
                    Theory::EulerBernoulli,
                    &model.factors,
                )?),
            };
            predictor.place(pose)?;
            let compliance = predictor.compliance();
            let structure = predictor.model().structure();
            (structure.nodes[structure.end.node].position_m, compliance)
        };
        let compliance = model.on_its_base(&compliance, end_m);
        row[..3].copy_from_slice(&end_m);
        fill_row(columns, None, &compliance, row);
        Ok(())
    }

    fn secant_row(
        &mut self,
        pose: &Pose,
        load_n: f64,
        columns: &[MapColumn],
        row: &mut [f64],
    ) -> Result<(), RobotError> {
        let model = self.model;
        let (mechanics, joint_rotations) = match &mut self.secant {
            Some(known) => {
                known.0.move_to(0, pose)?;
                known.0.solve_joints(|_| true)?;
                known
            }
            empty => {
                let poses = std::slice::from_ref(pose);
                let mechanics =
                    Mechanics::new(model.robot, model.mechanism(), &model.factors, poses)?;
                empty.insert((mechanics, JointRotations::default()))
            }
        };
        row[..3].copy_from_slice(&mechanics.end_m(0));
        let id = PoseId::new("map");
        let load = LoadPoint {
            force_n: load_n,
            ..LoadPoint::default()
        };
        for (value, column) in row[3..].iter_mut().zip(columns) {
            let axis = column.axis().unwrap_or_default();
            let run = RunLoads {
                pose: &id,
                load: LoadDirection::of_axis(Direction::ALL[axis]),
                read: Direction::ALL[axis].into(),
                repeat: 1,
                release_n: None,
                loads: std::slice::from_ref(&load),
            };
            let mut displacement_m = [0.0];
            let laws = &model.physics.laws;
            laws.displacements_m(
                mechanics.pose(0),
                &run,
                joint_rotations,
                &mut displacement_m,
            );
            *value = load_n / displacement_m[0];
        }
        Ok(())
    }
}

/// Joints that yield in proportion to their moment.
fn yielding_joints(robot: &Robot, physics: &ActingPhysics) -> JointModel {
    let mut compliances: Vec<(usize, f64)> = Vec::new();
    for effect in &physics.effects {
        let Some(name) = effect.place.joint() else {
            continue;
        };
        if effect.law.is_nonlinear_joint() {
            continue;
        }
        let (Some(joint), Some(&c)) = (
            robot.joints.iter().position(|joint| joint.name == name),
            effect.values.first(),
        ) else {
            continue;
        };
        // Compliances of one joint act in series.
        match compliances.iter_mut().find(|(known, _)| *known == joint) {
            Some((_, sum)) => *sum += c,
            None => compliances.push((joint, c)),
        }
    }
    compliances.retain(|(_, c)| *c > 0.0);
    if compliances.is_empty() {
        return JointModel::Rigid;
    }
    JointModel::Hinged(
        compliances
            .into_iter()
            .map(|(joint, c)| (joint, 1.0 / c))
            .collect(),
    )
}

/// Where the first support of a mechanism is; supports do not move.
fn support_m(robot: &Robot, mechanism: &Mechanism) -> Result<[f64; 3], RobotError> {
    let unit = FittingFactors::UNIT;
    let (joints, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
    let mut model = MechanismModel::new(robot, mechanism, &joints, theory, &unit)?;
    model.place(&robot.nominal_pose())?;
    let structure = model.structure();
    Ok(structure
        .supports
        .first()
        .map_or([0.0; 3], |support| structure.nodes[support.node].position_m))
}
