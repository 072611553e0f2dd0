//! Compliance of the end of a robot in very many poses, on all cores.

use rayon::iter::repeat_n;
use rayon::prelude::*;

use super::hinges::JointModel;
use crate::structure::{Compliance6, PartMethod, Reduction, SolutionPath};
use stiffbench_numeric::simd::InstructionSet;

use super::Robot;
use super::error::RobotError;
use super::fitting_factors::FittingFactors;
use super::members::{MechanismModel, Theory};
use super::model::{Mechanism, Pose};
use super::predict::Predictor;
use super::simd_poses::{SimdPoses, simd_poses};

/// Poses that a thread takes at a time: enough that its memory is set up rarely, few enough that two threads share evenly.
const CHUNK: usize = 2048;

/// One mechanism with its factors, ready for any number of poses.
///
/// Each pose has the result that it would have alone, whatever the number of poses or threads. What the reduction does not serve (pins,
/// balancers over beams, loops of rigid links, elements that carry nothing) or do not solve goes to a [`Predictor`], pose by
/// pose, which also names what is wrong.
#[derive(Debug)]
pub struct PoseSweep<'a> {
    robot: &'a Robot,
    mechanism: &'a Mechanism,
    joints: JointModel,
    theory: Theory,
    factors: FittingFactors,
    model: MechanismModel<'a>,
    reduction: Option<Reduction>,
}

/// What is kept of each pose besides [`SweptPose`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Keep {
    /// Nothing.
    #[default]
    Diagonal,
    /// The whole compliance.
    Full,
}

/// The end in a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SweptPose {
    /// Position, m.
    pub end_m: [f64; 3],
    /// Displacement along x, y, z per force along it, m/N.
    pub direct_m_per_n: [f64; 3],
}

/// What a sweep found, in the order of the poses.
#[derive(Debug)]
pub struct Swept {
    /// One a pose; `None` for those in `failed`.
    pub poses: Vec<Option<SweptPose>>,
    /// The compliance of each pose, 6 × 6, SI, if it was to be kept; empty otherwise.
    pub compliances: Vec<Option<Compliance6>>,
    /// Poses that have no result, by index, and why.
    pub failed: Vec<(usize, RobotError)>,
    /// How many poses the general solver took.
    pub alone: usize,
}

impl<'a> PoseSweep<'a> {
    /// Sweep of the paper's structure: rigid joints, Euler-Bernoulli beams, by the fastest exact way.
    ///
    /// # Errors
    /// [`RobotError::IncompleteMechanism`].
    pub fn new(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        factors: &FittingFactors,
    ) -> Result<Self, RobotError> {
        let (joints, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
        Self::with(
            robot,
            mechanism,
            joints,
            theory,
            factors,
            SolutionPath::Fastest,
        )
    }

    /// Sweep of any structure of a mechanism.
    ///
    /// # Errors
    /// [`RobotError::IncompleteMechanism`].
    pub fn with(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        joints: JointModel,
        theory: Theory,
        factors: &FittingFactors,
        path: SolutionPath,
    ) -> Result<Self, RobotError> {
        let mut model = MechanismModel::new(robot, mechanism, &joints, theory, factors)?;
        let mut reduction = model.reduction(path);
        reduction.take_if(|reduction| !model.rate(reduction, factors));
        Ok(Self {
            robot,
            mechanism,
            joints,
            theory,
            factors: factors.clone(),
            model,
            reduction,
        })
    }

    /// How each part of the structure is solved, from the ground to the end; empty if every pose goes to the general solver.
    #[must_use]
    pub fn methods(&self) -> &[PartMethod] {
        self.reduction.as_ref().map_or(&[], Reduction::methods)
    }

    /// Name of the instruction set of this machine that is used, and how many poses it takes at once.
    #[must_use]
    pub fn instructions(&self) -> (&'static str, usize) {
        let set = InstructionSet::for_poses(usize::MAX);
        (set.name(), set.lanes())
    }

    /// Solves every pose; angles in degrees, in the order of the robot's variables.
    ///
    /// Memory grows with what is kept, no more: each thread has room for a few poses of its own.
    #[must_use]
    pub fn run(&self, poses: &[Pose], keep: Keep) -> Swept {
        // Cleared by all threads: the system maps memory where it is first touched, and one thread would take a while.
        let mut found: Vec<Option<SweptPose>> = repeat_n(None, poses.len()).collect();
        let mut compliances: Vec<Option<Compliance6>> = match keep {
            Keep::Diagonal => Vec::new(),
            Keep::Full => repeat_n(None, poses.len()).collect(),
        };
        // Memory is made for a run of chunks, not for each: setting it up takes as long as some hundred poses.
        let set = InstructionSet::for_poses(poses.len());
        let memory = || self.simd(set, set.lanes());
        let chunks = poses.par_chunks(CHUNK).zip(found.par_chunks_mut(CHUNK));
        let done: Vec<Chunk> = match keep {
            Keep::Diagonal => chunks
                .map_init(memory, |simd, (poses, found)| {
                    self.chunk(simd.as_deref_mut(), poses, found, &mut [])
                })
                .collect(),
            Keep::Full => chunks
                .zip(compliances.par_chunks_mut(CHUNK))
                .map_init(memory, |simd, ((poses, found), compliances)| {
                    self.chunk(simd.as_deref_mut(), poses, found, compliances)
                })
                .collect(),
        };
        let mut swept = Swept {
            poses: found,
            compliances,
            failed: Vec::new(),
            alone: 0,
        };
        for (place, chunk) in done.into_iter().enumerate() {
            let failed = chunk.failed.into_iter();
            swept
                .failed
                .extend(failed.map(|(index, error)| (place * CHUNK + index, error)));
            swept.alone += chunk.alone;
        }
        swept
    }

    /// Solves poses whose values stand in one slice, and writes a result of each; returns the poses that have none, whose place in
    /// `results` stays as it was, and why.
    ///
    /// # Arguments
    /// - `values`: the values of a pose in the order of the robot's variables, degrees or m, behind those of the pose before.
    /// - `result`: of the position of the end, m, and the compliance.
    ///
    /// # Panics
    /// Unless there are as many values as `results` and variables ask for.
    pub fn run_into<T: Send>(
        &self,
        values: &[f64],
        results: &mut [T],
        result: impl Fn([f64; 3], &Compliance6) -> T + Sync,
    ) -> Vec<(usize, RobotError)> {
        let width = self.robot.variables.len();
        assert_eq!(values.len(), width * results.len(), "{width} values a pose");
        let set = InstructionSet::for_poses(results.len());
        let room = CHUNK.min(results.len());
        let memory = || {
            (
                self.simd(set, set.lanes()),
                vec![self.robot.nominal_pose(); room],
                vec![None; room],
                vec![None; room],
            )
        };
        let chunks = results.par_chunks_mut(CHUNK).enumerate();
        let failed: Vec<_> = chunks
            .map_init(memory, |(simd, poses, found, whole), (place, results)| {
                let start = place * CHUNK;
                let count = results.len();
                for (index, pose) in poses[..count].iter_mut().enumerate() {
                    let begin = (start + index) * width;
                    pose.angles_deg.copy_from_slice(&values[begin..][..width]);
                }
                let (found, whole) = (&mut found[..count], &mut whole[..count]);
                found.fill(None);
                let chunk = self.chunk(simd.as_deref_mut(), &poses[..count], found, whole);
                for ((place, pose), compliance) in results.iter_mut().zip(found).zip(whole) {
                    if let (Some(pose), Some(compliance)) = (pose, compliance) {
                        *place = result(pose.end_m, compliance);
                    }
                }
                let failed = chunk.failed.into_iter();
                failed
                    .map(|(index, error)| (start + index, error))
                    .collect::<Vec<_>>()
            })
            .collect();
        failed.into_iter().flatten().collect()
    }

    /// Room for a number of poses, to place and solve them apart.
    ///
    /// `None` if every pose goes to the general solver.
    #[must_use]
    pub fn bundles(&self, pose_count: usize) -> Option<PoseBundles<'_>> {
        Some(PoseBundles {
            sweep: self,
            simd: self.simd(InstructionSet::for_poses(pose_count), pose_count)?,
            pose_count,
        })
    }

    fn simd(&self, set: InstructionSet, pose_count: usize) -> Option<Box<dyn SimdPoses>> {
        let reduction = self.reduction.as_ref()?;
        Some(simd_poses(set, &self.model, reduction, pose_count, None))
    }

    fn chunk(
        &self,
        simd: Option<&mut (dyn SimdPoses + 'static)>,
        poses: &[Pose],
        found: &mut [Option<SweptPose>],
        compliances: &mut [Option<Compliance6>],
    ) -> Chunk {
        if let (Some(simd), Some(reduction)) = (simd, &self.reduction) {
            let count = simd.lane_count();
            for (bundle, poses) in poses.chunks(count).enumerate() {
                simd.place(0, &self.model, poses);
                simd.solve(0, reduction);
                for lane in 0..poses.len() {
                    let index = bundle * count + lane;
                    found[index] = simd.pose(lane);
                    if let (Some(_), Some(kept)) = (found[index], compliances.get_mut(index)) {
                        *kept = Some(simd.compliance(lane));
                    }
                }
            }
        }
        self.solve_rest(poses, found, compliances)
    }

    /// Solves by the general solver what has no result yet.
    fn solve_rest(
        &self,
        poses: &[Pose],
        found: &mut [Option<SweptPose>],
        compliances: &mut [Option<Compliance6>],
    ) -> Chunk {
        let mut chunk = Chunk::default();
        let mut general = None;
        for (index, pose) in poses.iter().enumerate() {
            if found[index].is_some() {
                continue;
            }
            chunk.alone += 1;
            match self.solve_alone(pose, &mut general) {
                Ok((swept, compliance)) => {
                    found[index] = Some(swept);
                    if let Some(kept) = compliances.get_mut(index) {
                        *kept = Some(compliance);
                    }
                }
                Err(error) => chunk.failed.push((index, error)),
            }
        }
        chunk
    }

    fn solve_alone(
        &self,
        pose: &Pose,
        general: &mut Option<Predictor<'a>>,
    ) -> Result<(SweptPose, Compliance6), RobotError> {
        if general.is_none() {
            let Self {
                robot, mechanism, ..
            } = *self;
            let joints = &self.joints;
            *general = Some(Predictor::with(
                robot,
                mechanism,
                joints,
                self.theory,
                &self.factors,
            )?);
        }
        let Some(predictor) = general else {
            unreachable!("it was made above");
        };
        predictor.place(pose)?;
        let compliance = predictor.compliance();
        let structure = predictor.model().structure();
        let swept = SweptPose {
            end_m: structure.nodes[structure.end.node].position_m,
            direct_m_per_n: [0, 1, 2].map(|axis| compliance.direct(axis)),
        };
        Ok((swept, compliance))
    }
}

/// What the poses of a chunk leave besides their results.
#[derive(Debug, Default)]
struct Chunk {
    failed: Vec<(usize, RobotError)>,
    alone: usize,
}

/// Poses side by side in SIMD registers: placed once, solved as often as wanted. Allocates nothing after it was made.
///
/// [`PoseSweep::run`] does both at once; this is for one pose after another, and for measuring them apart.
#[derive(Debug)]
pub struct PoseBundles<'a> {
    sweep: &'a PoseSweep<'a>,
    simd: Box<dyn SimdPoses>,
    pose_count: usize,
}

impl PoseBundles<'_> {
    /// Places poses.
    ///
    /// # Panics
    /// If there are more than there is room for.
    pub fn place(&mut self, poses: &[Pose]) {
        assert!(
            poses.len() <= self.pose_count,
            "room for {}",
            self.pose_count
        );
        let lanes = self.simd.lane_count();
        for (bundle, poses) in poses.chunks(lanes).enumerate() {
            self.simd.place(bundle, &self.sweep.model, poses);
        }
    }

    /// Solves all placed poses; gives the results of each bundle to `each`, as index and result of a pose.
    pub fn solve(&mut self, mut each: impl FnMut(usize, Option<SweptPose>)) {
        let lanes = self.simd.lane_count();
        for bundle in 0..self.pose_count.div_ceil(lanes) {
            self.solve_bundle(bundle);
            for lane in 0..lanes.min(self.pose_count - bundle * lanes) {
                each(bundle * lanes + lane, self.simd.pose(lane));
            }
        }
    }

    /// Places and solves one pose, in the first place there is room for; `None` if the reduction has no result for it.
    ///
    /// The results are those of [`PoseSweep::run`], byte by byte.
    pub fn one(&mut self, pose: &Pose) -> Option<(SweptPose, Compliance6)> {
        let model = &self.sweep.model;
        self.simd.place(0, model, std::slice::from_ref(pose));
        self.solve_bundle(0);
        let swept = self.simd.pose(0)?;
        Some((swept, self.simd.compliance(0)))
    }

    fn solve_bundle(&mut self, bundle: usize) {
        if let Some(reduction) = &self.sweep.reduction {
            self.simd.solve(bundle, reduction);
        }
    }

    /// How often a part of the structure was found where it stood before, and not computed again.
    #[must_use]
    pub fn reused_parts(&self) -> u64 {
        self.simd.reused_parts()
    }
}
