//! The compliance of the end in as many poses as a lane holds.

use pulp::Simd;

use super::block::Block;
use super::combine::Combine;
use super::execute::{Members, SolverBuffers};
use super::member::{
    add_hinge_in_plane, add_hinge_in_space, components, hinge_motion, hinge_motion_in_plane,
    in_plane, in_space,
};
use super::placed::{Placed, Results};
use super::schedule::ReductionForm;
use super::substructure::{Reduction, Substructure};
use stiffbench_numeric::simd::{
    Aligned, Kernel, Lane, Number, frame_on, multiply_add, run, subtract,
};

/// A node lies in the plane of the end of its part if it leaves it by no more than this share of its distance: far above rounding,
/// and what it leaves out is of this size and far below what any solver keeps.
const OUT_OF_PLANE: f64 = 1e-12;

/// The memory to solve with; one a thread.
#[derive(Debug)]
pub(crate) struct Reducer<S: Simd> {
    pub(super) simd: S,
    pub(super) parts: Vec<SubstructureState<S>>,
    /// Nodes of the part at its turn, seen from its origin: in its plane, and in space.
    pub(super) flat: Vec<Aligned<[Lane<S>; 2]>>,
    pub(super) deep: Vec<Aligned<[Lane<S>; 3]>>,
    pub(crate) results: Results<S>,
    /// How often a part stood as it stood before, in bundles of poses.
    pub(crate) reused: u64,
}

/// A part, and what it gave the last time.
#[derive(Debug)]
pub(super) struct SubstructureState<S: Simd> {
    pub(super) planar: SolverBuffers<S, 3, 2>,
    pub(super) spatial: SolverBuffers<S, 6, 1>,
    /// Nodes and normals of the last time; none before the first.
    stood: Vec<[Lane<S>; 3]>,
    pub(super) solution: Solution<S>,
}

/// Compliance of a part at its origin, global axes.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub(super) struct Solution<S: Simd> {
    pub(super) compliance: Block<S, 6>,
    /// Largest ratio of a diagonal entry to its pivot.
    pub(super) worst: Lane<S>,
    /// Above zero where the part is not in its plane.
    pub(super) bent: Lane<S>,
}

impl<S: Simd> Reducer<S> {
    /// # Arguments
    /// - `derivatives`: whether [`Reducer::differentiate`] will be called.
    pub(crate) fn new(simd: S, reduction: &Reduction, derivatives: bool) -> Self {
        let zero = Lane::zero(simd);
        let state = |part: &Substructure| SubstructureState {
            planar: SolverBuffers::new(simd, &part.schedule, derivatives),
            spatial: SolverBuffers::new(simd, &part.schedule, derivatives),
            stood: Vec::with_capacity(part.nodes.len() + part.planes.len()),
            solution: Solution {
                compliance: [[zero; 6]; 6],
                worst: zero,
                bent: zero,
            },
        };
        Self {
            simd,
            parts: reduction.parts.iter().map(state).collect(),
            flat: vec![Aligned([zero; 2]); reduction.node_count],
            deep: vec![Aligned([zero; 3]); reduction.node_count],
            results: Results {
                compliance: [[zero; 6]; 6],
                faults: Lane::one(simd),
            },
            reused: 0,
        }
    }

    /// Works every part out again at the next solution: the elements have other constants.
    pub(crate) fn forget(&mut self) {
        for part in &mut self.parts {
            part.stood.clear();
        }
    }

    /// Solves; the outcome is in [`Reducer::results`].
    pub(crate) fn solve(&mut self, reduction: &Reduction, placed: &Placed<S>) {
        for (index, part) in reduction.parts.iter().enumerate() {
            if self.parts[index].stands(part, placed) {
                self.reused += 1;
                continue;
            }
            self.solve_part(reduction, index, placed);
        }
        let solutions = &self.parts;
        let results = &mut self.results;
        run(
            self.simd,
            Combine {
                reduction,
                placed,
                solutions,
                results,
            },
        );
    }

    /// Solves a part in its plane where it lies in it, and in space elsewhere: each pose as it would be alone.
    fn solve_part(&mut self, reduction: &Reduction, index: usize, placed: &Placed<S>) {
        let part = &reduction.parts[index];
        let state = &mut self.parts[index];
        let lanes = 0..Lane::<S>::COUNT;
        let mut planar = None;
        if let Some(plane) = part.plane {
            let (flat, memory) = (&mut self.flat, &mut state.planar);
            let solution = &mut state.solution;
            run(
                self.simd,
                PlaneSolve {
                    reduction,
                    part,
                    plane,
                    placed,
                    flat,
                    memory,
                    solution,
                },
            );
            let bent = &solution.bent;
            if lanes.clone().all(|lane| bent.get(lane) == 0.0) {
                return;
            }
            planar = Some(solution.clone());
        }
        let (deep, memory) = (&mut self.deep, &mut state.spatial);
        let solution = &mut state.solution;
        run(
            self.simd,
            SpaceSolve {
                reduction,
                part,
                placed,
                deep,
                memory,
                solution,
            },
        );
        if let Some(planar) = planar {
            for lane in lanes.filter(|&lane| planar.bent.get(lane) == 0.0) {
                solution.take(&planar, lane);
            }
        }
    }
}

impl<S: Simd> Solution<S> {
    /// Takes one pose from another solution.
    fn take(&mut self, other: &Self, lane: usize) {
        let entries = self.compliance.iter_mut().flatten();
        for (entry, other) in entries.zip(other.compliance.iter().flatten()) {
            entry.set(lane, other.get(lane));
        }
        self.worst.set(lane, other.worst.get(lane));
    }
}

impl<S: Simd> SubstructureState<S> {
    /// Whether a part stands where it stood the last time; remembers where it stands.
    fn stands(&mut self, part: &Substructure, placed: &Placed<S>) -> bool {
        let nodes = part.nodes.iter().map(|&node| placed.nodes_m[node].0);
        let normals = part.planes.iter().map(|&plane| placed.normals[plane].0);
        let same = |a: &[Lane<S>; 3], b: &[Lane<S>; 3]| a.iter().zip(b).all(|(a, b)| a.is_same(b));
        let count = part.nodes.len() + part.planes.len();
        let all = normals.chain(nodes);
        let stands = !part.is_braced
            && self.stood.len() == count
            && self.stood.iter().zip(all.clone()).all(|(a, b)| same(a, &b));
        if !stands {
            self.stood.clear();
            self.stood.extend(all);
        }
        stands
    }
}

/// Solves a part in its plane and across it.
struct PlaneSolve<'a, S: Simd> {
    reduction: &'a Reduction,
    part: &'a Substructure,
    plane: usize,
    placed: &'a Placed<S>,
    flat: &'a mut [Aligned<[Lane<S>; 2]>],
    memory: &'a mut SolverBuffers<S, 3, 2>,
    solution: &'a mut Solution<S>,
}

impl<S: Simd> Kernel for PlaneSolve<'_, S> {
    #[inline(always)]
    fn run(self) {
        let Self { part, placed, .. } = self;
        let (frame, bent) = see_in_plane(part, self.plane, placed, self.flat);
        let mut worst = bent.of(0.0);
        let mut members = FlatMembers {
            reduction: self.reduction,
            nodes: self.flat,
        };
        let halves = self
            .memory
            .execute(&part.schedule, &mut members, &mut worst);
        self.solution.compliance = in_global_axes(&frame, halves);
        self.solution.worst = worst;
        self.solution.bent = bent;
    }
}

/// Sees the nodes of a part from its origin, in its plane; gives the frame n, p, q, and what is above zero where they leave the plane.
#[inline(always)]
pub(super) fn see_in_plane<S: Simd>(
    part: &Substructure,
    plane: usize,
    placed: &Placed<S>,
    flat: &mut [Aligned<[Lane<S>; 2]>],
) -> ([[Lane<S>; 3]; 3], Lane<S>) {
    let frame = frame_on(&placed.normals[plane].0);
    let origin = &placed.nodes_m[part.origin].0;
    let mut bent = frame[0][0].of(0.0);
    let (tolerance, least) = (
        bent.of(OUT_OF_PLANE * OUT_OF_PLANE),
        bent.of(f64::MIN_POSITIVE),
    );
    for &node in &part.nodes {
        let [n, p, q] = components(&frame, &subtract(&placed.nodes_m[node].0, origin));
        let limit = multiply_add(tolerance, multiply_add(p, p, q * q), least);
        bent += (n * n).fault_unless_below(limit);
        flat[node].0 = [p, q];
    }
    (frame, bent)
}

/// Sees the nodes of a part from its origin.
#[inline(always)]
pub(super) fn see_in_space<S: Simd>(
    part: &Substructure,
    placed: &Placed<S>,
    deep: &mut [Aligned<[Lane<S>; 3]>],
) {
    let origin = &placed.nodes_m[part.origin].0;
    for &node in &part.nodes {
        deep[node].0 = subtract(&placed.nodes_m[node].0, origin);
    }
}

struct FlatMembers<'a, S: Simd> {
    reduction: &'a Reduction,
    nodes: &'a [Aligned<[Lane<S>; 2]>],
}

impl<S: Simd> Members<S, 3, 2> for FlatMembers<'_, S> {
    #[inline(always)]
    fn element(&mut self, element: usize, form: ReductionForm) -> [Block<S, 3>; 2] {
        let [first, second] = self.reduction.ends[element];
        let constants = &self.reduction.constants[element];
        in_plane(constants, form, [self.nodes[first].0, self.nodes[second].0])
    }

    #[inline(always)]
    fn add_hinge(&mut self, hinge: usize, fresh: bool, sum: &mut [Block<S, 3>; 2]) {
        let hinge = &self.reduction.hinges[hinge];
        add_hinge_in_plane(hinge.rad_per_nm, self.nodes[hinge.node].0, fresh, sum);
    }

    fn add_braced(&mut self, _: bool, _: &mut [Block<S, 3>; 2]) {
        unreachable!("hinges that struts stand over have no plane");
    }

    #[inline(always)]
    fn hinge(&mut self, hinge: usize) -> ([[Lane<S>; 3]; 2], f64) {
        let hinge = &self.reduction.hinges[hinge];
        let motion = hinge_motion_in_plane(self.nodes[hinge.node].0);
        (motion, 1.0 / hinge.rad_per_nm)
    }
}

/// Solves a part in space.
struct SpaceSolve<'a, S: Simd> {
    reduction: &'a Reduction,
    part: &'a Substructure,
    placed: &'a Placed<S>,
    deep: &'a mut [Aligned<[Lane<S>; 3]>],
    memory: &'a mut SolverBuffers<S, 6, 1>,
    solution: &'a mut Solution<S>,
}

impl<S: Simd> Kernel for SpaceSolve<'_, S> {
    #[inline(always)]
    fn run(self) {
        let Self { part, placed, .. } = self;
        see_in_space(part, placed, self.deep);
        let mut worst = placed.faults.of(0.0);
        let mut members = DeepMembers {
            reduction: self.reduction,
            nodes: self.deep,
            placed,
            origin: part.origin,
            faults: worst,
        };
        let whole = self
            .memory
            .execute(&part.schedule, &mut members, &mut worst);
        self.solution.compliance = whole[0];
        for i in 0..6 {
            for j in 0..i {
                self.solution.compliance[i][j] = whole[0][j][i];
            }
        }
        // An element without a plane is worse than any pivot.
        self.solution.worst = multiply_add(members.faults, worst.of(1e300), worst);
    }
}

struct DeepMembers<'a, S: Simd> {
    reduction: &'a Reduction,
    nodes: &'a [Aligned<[Lane<S>; 3]>],
    placed: &'a Placed<S>,
    /// Node from which the others are seen.
    origin: usize,
    faults: Lane<S>,
}

impl<S: Simd> Members<S, 6, 1> for DeepMembers<'_, S> {
    #[inline(always)]
    fn element(&mut self, element: usize, form: ReductionForm) -> [Block<S, 6>; 1] {
        let [first, second] = self.reduction.ends[element];
        in_space(
            &self.reduction.constants[element],
            form,
            [&self.nodes[first].0, &self.nodes[second].0],
            &self.placed.normals[self.reduction.planes[element]].0,
            &mut self.faults,
        )
    }

    #[inline(always)]
    fn add_hinge(&mut self, hinge: usize, fresh: bool, sum: &mut [Block<S, 6>; 1]) {
        let hinge = &self.reduction.hinges[hinge];
        let (node, axis) = (
            &self.nodes[hinge.node].0,
            &self.placed.normals[hinge.plane].0,
        );
        let of_hinge = (hinge.rad_per_nm, hinge.slides);
        add_hinge_in_space(of_hinge, node, axis, fresh, sum);
    }

    #[inline(always)]
    fn add_braced(&mut self, fresh: bool, [sum]: &mut [Block<S, 6>; 1]) {
        if fresh {
            *sum = [[self.faults.of(0.0); 6]; 6];
        }
        let origin_m = &self.placed.nodes_m[self.origin].0;
        let (reduction, faults) = (self.reduction, &mut self.faults);
        let braced = &reduction.braced;
        braced.add(reduction, self.placed, self.nodes, origin_m, faults, sum);
    }

    #[inline(always)]
    fn hinge(&mut self, hinge: usize) -> ([[Lane<S>; 6]; 1], f64) {
        let hinge = &self.reduction.hinges[hinge];
        let (node, axis) = (
            &self.nodes[hinge.node].0,
            &self.placed.normals[hinge.plane].0,
        );
        let motion = hinge_motion(node, axis, hinge.slides);
        ([motion], 1.0 / hinge.rad_per_nm)
    }
}

/// The compliance over ux uy uz rx ry rz from that over up, uq, rn and that over rp, rq, un.
#[inline(always)]
fn in_global_axes<S: Simd>(
    [n, p, q]: &[[Lane<S>; 3]; 3],
    [within, across]: &[Block<S, 3>; 2],
) -> Block<S, 6> {
    let mut global = [[n[0]; 6]; 6];
    let (nn, turn) = (across[2][2], within[2][2]);
    for i in 0..3 {
        // Rows of displacements times the in-plane block, of turns times the block across.
        let up = multiply_add(p[i], within[0][0], q[i] * within[0][1]);
        let uq = multiply_add(p[i], within[0][1], q[i] * within[1][1]);
        let un = n[i] * nn;
        let rp = multiply_add(p[i], across[0][0], q[i] * across[0][1]);
        let rq = multiply_add(p[i], across[0][1], q[i] * across[1][1]);
        let rn = n[i] * turn;
        let by_n = multiply_add(p[i], within[0][2], q[i] * within[1][2]);
        let (un_rp, un_rq) = (n[i] * across[0][2], n[i] * across[1][2]);
        for j in 0..3 {
            global[i][j] = multiply_add(up, p[j], multiply_add(uq, q[j], un * n[j]));
            global[3 + i][3 + j] = multiply_add(rp, p[j], multiply_add(rq, q[j], rn * n[j]));
            let mixed = multiply_add(un_rp, p[j], multiply_add(un_rq, q[j], by_n * n[j]));
            global[i][3 + j] = mixed;
            global[3 + j][i] = mixed;
        }
    }
    global
}
