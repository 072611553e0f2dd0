//! Poses in SIMD registers: batched kinematics and batched solve, for any instruction set.

#![expect(
    clippy::inline_always,
    reason = "what is not inlined into a kernel is compiled for another instruction set, and calls its instructions one by one"
)]

use pulp::Simd;

use super::model_parameter::ElementClass;
use crate::structure::{
    Compliance6, ComplianceGradient, GroupGradient, ParameterPlaces, Placed, PlacedStrut, Reducer,
    Reduction, WholeGradient,
};
use stiffbench_numeric::simd::{InstructionSet, Kernel, Lane, Number, dot, run, subtract};

use super::kinematics::Placement;
use super::members::MechanismModel;
use super::model::Pose;
use super::sweep::SweptPose;

/// Derivatives of a compliance to ln A, ln Iy, ln Iz, ln J of all beams, and of all links, m/N.
pub(super) type ClassGradient = [ComplianceGradient; 2];

/// Room for poses, in bundles of as many as a register holds. Allocates nothing after it was made.
///
/// Each pose has the result that it would have alone. All calls take the model and the reduction that it was made for.
pub(super) trait SimdPoses: std::fmt::Debug + Send {
    /// Poses in a bundle.
    fn lane_count(&self) -> usize;
    /// Places as many poses as a bundle holds, or fewer; those that have no place show as not solved.
    fn place(&mut self, bundle: usize, model: &MechanismModel<'_>, poses: &[Pose]);
    /// Takes pose number `index` as the model stands.
    fn take(&mut self, index: usize, model: &MechanismModel<'_>);
    /// To be called after the constants of the reduction have changed.
    fn forget(&mut self);
    fn solve(&mut self, bundle: usize, reduction: &Reduction);
    /// Derivatives in the bundle solved last, along three unit vectors a pose.
    fn differentiate(&mut self, reduction: &Reduction, units: &[[[f64; 3]; 3]]);
    /// The result of a pose of the bundle solved last; `None` if it has none.
    fn pose(&self, lane: usize) -> Option<SweptPose>;
    fn compliance(&self, lane: usize) -> Compliance6;
    fn gradient(&self, lane: usize) -> [ClassGradient; 3];
    /// Derivatives of the whole compliance in the bundle solved last, to each of the parameters it was made for.
    fn differentiate_whole(&mut self, reduction: &Reduction, places: &ParameterPlaces);
    fn whole_gradient(&self, lane: usize, parameter: usize) -> Compliance6;
    fn reused_parts(&self) -> u64;
}

/// Room for a number of poses in registers of an instruction set.
///
/// # Arguments
/// - `parameters`: number of parameters to which derivatives will be asked for; `None` if for none.
pub(super) fn simd_poses(
    set: InstructionSet,
    model: &MechanismModel<'_>,
    reduction: &Reduction,
    pose_count: usize,
    parameters: Option<usize>,
) -> Box<dyn SimdPoses> {
    macro_rules! bundles {
        ($simd:expr) => {
            Box::new(Bundles::new(
                $simd, model, reduction, pose_count, parameters,
            ))
        };
    }
    match set {
        InstructionSet::Plain(simd) => bundles!(simd),
        #[cfg(target_arch = "aarch64")]
        InstructionSet::Neon(simd) => bundles!(simd),
        #[cfg(target_arch = "x86_64")]
        InstructionSet::Avx2(simd) => bundles!(simd),
        #[cfg(target_arch = "x86_64")]
        InstructionSet::Avx512(simd) => bundles!(simd),
    }
}

#[derive(Debug)]
struct Bundles<S: Simd> {
    simd: S,
    /// Planes whose normals elements and hinges need.
    planes: Vec<usize>,
    /// Class of each element.
    classes: Vec<usize>,
    /// Robot and structure node of the end.
    end: usize,
    /// Angle of each variable in the bundle at its turn, degrees.
    angles_deg: Vec<Lane<S>>,
    placement: Placement<Lane<S>>,
    placed: Vec<Placed<S>>,
    /// The bundle solved last.
    solved: usize,
    reducer: Reducer<S>,
    gradient: [GroupGradient<S>; 2],
    whole: Vec<WholeGradient<S>>,
}

impl<S: Simd> Bundles<S> {
    fn new(
        simd: S,
        model: &MechanismModel<'_>,
        reduction: &Reduction,
        pose_count: usize,
        parameters: Option<usize>,
    ) -> Self {
        let (robot, zero) = (model.robot(), Lane::zero(simd));
        let directions = robot.planes.len() + model.directions().count();
        let mut placed = Placed::new(simd, model.nodes().len(), directions);
        placed.struts = vec![PlacedStrut::new(zero); robot.balancers.len()];
        Self {
            simd,
            planes: model.planes(),
            classes: model.members().map(|member| class(member.class)).collect(),
            end: model.structure().end.node,
            angles_deg: vec![zero; robot.variables.len()],
            placement: Placement::new(robot, zero),
            placed: vec![placed; pose_count.div_ceil(Lane::<S>::COUNT)],
            solved: 0,
            reducer: Reducer::new(simd, reduction, parameters.is_some()),
            gradient: [[[zero; 4]; 3]; 2],
            whole: vec![[[zero; 6]; 6]; parameters.unwrap_or(0)],
        }
    }
}

/// Place of a class in a [`ClassGradient`].
pub(super) fn class(class: ElementClass) -> usize {
    match class {
        ElementClass::Beam => 0,
        ElementClass::Link => 1,
    }
}

impl<S: Simd> SimdPoses for Bundles<S> {
    fn lane_count(&self) -> usize {
        Lane::<S>::COUNT
    }

    fn place(&mut self, bundle: usize, model: &MechanismModel<'_>, poses: &[Pose]) {
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
                model,
                planes: &self.planes,
                angles_deg: &self.angles_deg,
                placement: &mut self.placement,
                placed: &mut self.placed[bundle],
            },
        );
    }

    fn take(&mut self, index: usize, model: &MechanismModel<'_>) {
        let (bundle, lane) = (index / Lane::<S>::COUNT, index % Lane::<S>::COUNT);
        let placed = &mut self.placed[bundle];
        let set = |target: &mut [Lane<S>; 3], from: [f64; 3]| {
            for i in 0..3 {
                target[i].set(lane, from[i]);
            }
        };
        for (target, node) in placed.nodes_m.iter_mut().zip(&model.structure().nodes) {
            set(&mut target.0, node.position_m);
        }
        for &plane in &self.planes {
            set(&mut placed.normals[plane].0, model.plane_normal(plane));
        }
        let others = placed.normals.iter_mut().skip(model.robot().planes.len());
        for (target, direction) in others.zip(model.directions()) {
            set(&mut target.0, model.placement().direction(direction));
        }
        placed.faults.set(lane, 0.0);
    }

    fn forget(&mut self) {
        self.reducer.forget();
    }

    fn solve(&mut self, bundle: usize, reduction: &Reduction) {
        self.reducer.solve(reduction, &self.placed[bundle]);
        self.solved = bundle;
    }

    fn differentiate(&mut self, reduction: &Reduction, units: &[[[f64; 3]; 3]]) {
        let mut by_lane = [[Lane::zero(self.simd); 3]; 3];
        for (lane, units) in units.iter().enumerate() {
            for (target, unit) in by_lane.iter_mut().zip(units) {
                for i in 0..3 {
                    target[i].set(lane, unit[i]);
                }
            }
        }
        let (placed, gradient) = (&self.placed[self.solved], &mut self.gradient);
        self.reducer
            .differentiate(reduction, placed, &self.classes, &by_lane, gradient);
    }

    fn pose(&self, lane: usize) -> Option<SweptPose> {
        let results = &self.reducer.results;
        if results.faults.get(lane) != 0.0 {
            return None;
        }
        let end = &self.placed[self.solved].nodes_m[self.end].0;
        Some(SweptPose {
            end_m: [0, 1, 2].map(|i| end[i].get(lane)),
            direct_m_per_n: [0, 1, 2].map(|i| results.compliance[i][i].get(lane)),
        })
    }

    fn compliance(&self, lane: usize) -> Compliance6 {
        let compliance = &self.reducer.results.compliance;
        Compliance6(compliance.map(|row| row.map(|entry| entry.get(lane))))
    }

    fn gradient(&self, lane: usize) -> [ClassGradient; 3] {
        let entries = |group: usize, unit: usize| self.gradient[group][unit].map(|g| g.get(lane));
        [0, 1, 2].map(|unit| [entries(0, unit), entries(1, unit)])
    }

    fn differentiate_whole(&mut self, reduction: &Reduction, places: &ParameterPlaces) {
        let (placed, whole) = (&self.placed[self.solved], &mut self.whole);
        self.reducer
            .differentiate_whole(reduction, placed, places, whole);
    }

    fn whole_gradient(&self, lane: usize, parameter: usize) -> Compliance6 {
        let upper = &self.whole[parameter];
        Compliance6(std::array::from_fn(|i| {
            std::array::from_fn(|j| upper[i.min(j)][i.max(j)].get(lane))
        }))
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
        let others = placed.normals.iter_mut().skip(robot.planes.len());
        for (target, direction) in others.zip(model.directions()) {
            target.0 = placement.direction(direction);
        }
        for (target, balancer) in placed.struts.iter_mut().zip(&robot.balancers) {
            for (point, pivot) in target.points_m.iter_mut().zip(&balancer.pivots) {
                *point = placement.point_m(pivot.body, &pivot.at_m);
            }
            let [first, second] = &target.points_m;
            let span = subtract(second, first);
            let distance = dot(&span, &span).sqrt();
            for lane in 0..Lane::<S>::COUNT {
                let (force_n, stiffness) = balancer.force.at(distance.get(lane));
                target.force_n.set(lane, force_n);
                target.stiffness_n_per_m.set(lane, stiffness);
            }
        }
    }
}
