//! The bundles of a sweep: poses side by side, placed and solved.

use pulp::Simd;

use crate::structure::{Compliance6, Placed, Reducer, Reduction};
use stiffbench_numeric::lanes::{Lane, run};

use super::members::MechanismModel;
use super::model::Pose;
use super::place_many::{PlaceMany, Placer};
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
    placer: Placer<S>,
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
            placer: Placer::new(simd, robot),
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
            for (angle, &value) in self.placer.angles_deg.iter_mut().zip(&pose.angles_deg) {
                angle.set(lane, value);
            }
        }
        run(
            self.simd,
            PlaceMany {
                robot: self.model.robot(),
                order: self.model.order(),
                wanted: self.model.nodes(),
                planes: &self.planes,
                placer: &mut self.placer,
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
