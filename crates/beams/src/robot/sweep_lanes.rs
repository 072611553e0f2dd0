//! The bundles of a sweep: poses side by side, placed and solved.

#![expect(
    clippy::inline_always,
    reason = "what is not inlined into a kernel is compiled for another instruction set, and calls its instructions one by one"
)]

use pulp::Simd;

use crate::structure::{Compliance6, Placed, Reducer, Reduction};
use stiffbench_numeric::lanes::{Kernel, Lane, run};

use super::kinematics::Placement;
use super::members::MechanismModel;
use super::model::Pose;
use super::sweep::SweptPose;

/// Bundles whose number of lanes is not named.
pub(super) trait SweepLanes: std::fmt::Debug + Send {
    fn lane_count(&self) -> usize;
    /// Places as many poses as a lane holds, or fewer.
    fn place(&mut self, bundle: usize, poses: &[Pose]);
    fn solve(&mut self, bundle: usize);
    /// The result of a pose of the bundle solved last.
    fn pose(&self, lane: usize) -> Option<SweptPose>;
    fn compliance(&self, lane: usize) -> Compliance6;
    fn reused_parts(&self) -> u64;
}

#[derive(Debug)]
pub(super) struct Bundles<'a, S: Simd> {
    simd: S,
    model: &'a MechanismModel<'a>,
    reduction: &'a Reduction,
    /// Planes whose normals elements and hinges need.
    planes: Vec<usize>,
    /// Angle of each variable in the bundle at its turn, degrees.
    angles_deg: Vec<Lane<S>>,
    placement: Placement<Lane<S>>,
    placed: Vec<Placed<S>>,
    /// The bundle solved last.
    solved: usize,
    reducer: Reducer<S>,
}

impl<'a, S: Simd> Bundles<'a, S> {
    pub(super) fn new(
        simd: S,
        model: &'a MechanismModel<'a>,
        reduction: &'a Reduction,
        pose_count: usize,
    ) -> Self {
        let robot = model.robot();
        let of_members = model.members().map(|member| member.plane);
        let mut planes: Vec<usize> = of_members.chain(model.hinge_planes()).collect();
        planes.sort_unstable();
        planes.dedup();
        let placed = Placed::new(simd, model.nodes().len(), robot.planes.len());
        Self {
            simd,
            model,
            reduction,
            planes,
            angles_deg: vec![Lane::zero(simd); robot.variables.len()],
            placement: Placement::new(robot, Lane::zero(simd)),
            placed: vec![placed; pose_count.div_ceil(Lane::<S>::COUNT)],
            solved: 0,
            reducer: Reducer::new(simd, reduction),
        }
    }
}

impl<S: Simd> SweepLanes for Bundles<'_, S> {
    fn lane_count(&self) -> usize {
        Lane::<S>::COUNT
    }

    fn place(&mut self, bundle: usize, poses: &[Pose]) {
        for lane in 0..Lane::<S>::COUNT {
            // Lanes without a pose repeat the last one.
            let pose = &poses[lane.min(poses.len() - 1)];
            for (angle, &value) in self.angles_deg.iter_mut().zip(&pose.angles_deg) {
                angle.set(lane, value);
            }
        }
        run(
            self.simd,
            PlaceAll {
                model: self.model,
                planes: &self.planes,
                angles_deg: &self.angles_deg,
                placement: &mut self.placement,
                placed: &mut self.placed[bundle],
            },
        );
    }

    fn solve(&mut self, bundle: usize) {
        self.reducer.solve(self.reduction, &self.placed[bundle]);
        self.solved = bundle;
    }

    fn pose(&self, lane: usize) -> Option<SweptPose> {
        let results = &self.reducer.results;
        if results.faults.get(lane) != 0.0 {
            return None;
        }
        let end = &self.placed[self.solved].nodes_m[self.model.structure().end.node].0;
        Some(SweptPose {
            end_m: [0, 1, 2].map(|i| end[i].get(lane)),
            direct_m_per_n: [0, 1, 2].map(|i| results.compliance[i][i].get(lane)),
        })
    }

    fn compliance(&self, lane: usize) -> Compliance6 {
        let compliance = &self.reducer.results.compliance;
        Compliance6(compliance.map(|row| row.map(|entry| entry.get(lane))))
    }

    fn reused_parts(&self) -> u64 {
        self.reducer.reused
    }
}

/// Kinematics of a bundle.
struct PlaceAll<'a, S: Simd> {
    model: &'a MechanismModel<'a>,
    /// Planes whose normals are wanted.
    planes: &'a [usize],
    angles_deg: &'a [Lane<S>],
    placement: &'a mut Placement<Lane<S>>,
    /// Nodes as in the model's structure, normals by plane.
    placed: &'a mut Placed<S>,
}

impl<S: Simd> Kernel for PlaceAll<'_, S> {
    #[inline(always)]
    fn run(self) {
        let Self {
            model,
            placement,
            placed,
            ..
        } = self;
        let robot = model.robot();
        let order = model.order();
        placed.faults = order.place_all(robot, self.angles_deg, placed.faults, placement);
        for (target, &node) in placed.nodes_m.iter_mut().zip(model.nodes()) {
            target.0 = placement.node_m(node);
        }
        for &plane in self.planes {
            placed.normals[plane].0 = placement.plane_normal(robot, plane);
        }
    }
}
