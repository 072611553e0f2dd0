//! How the compliance of the end changes with the section constants, from the strain energy of every element.
//!
//! A force of one along a direction moves the end by c along it. What an element then carries follows from the solution, and
//! ∂c/∂ln p = -2 U with U the strain energy that depends on the constant p: exact, as in [`Solver`](crate::structure::Solver).

use pulp::Simd;

use super::block::Block;
use super::execute::{Carriers, SolverBuffers};
use super::member::{components, energies_in_plane, energies_in_space};
use super::schedule::{ReductionForm, SchedulePiece};
use super::solve::{Placed, Reducer, see_in_plane, see_in_space};
use super::substructure::{Reduction, Substructure};
use stiffbench_numeric::simd::{Aligned, Kernel, Lane, Number, cross, run, subtract};

/// Derivatives of the displacement along three directions per force along each, to ln A, ln Iy, ln Iz, ln J of all elements of a group,
/// m/N.
pub(crate) type GroupGradient<S> = [[Lane<S>; 4]; 3];

impl<S: Simd> Reducer<S> {
    /// Derivatives of the compliance solved last, by group of elements, by a reducer made for them.
    ///
    /// # Arguments
    /// - `groups`: of each element.
    /// - `units`: the directions, unit vectors.
    pub(crate) fn differentiate(
        &mut self,
        reduction: &Reduction,
        placed: &Placed<S>,
        groups: &[usize],
        units: &[[Lane<S>; 3]; 3],
        gradient: &mut [GroupGradient<S>],
    ) {
        gradient.fill([[Lane::zero(self.simd); 4]; 3]);
        for (part, state) in reduction.parts.iter().zip(&mut self.parts) {
            // Without a plane a part is out of it in every pose.
            let bent = match part.plane {
                Some(_) => state.solution.bent,
                None => Lane::one(self.simd),
            };
            let mut sums = EnergySums {
                reduction,
                groups,
                bent,
                gradient,
            };
            if let Some(plane) = part.plane {
                let (flat, memory) = (&mut self.flat, &mut state.planar);
                run(
                    self.simd,
                    PlaneLoads {
                        part,
                        plane,
                        placed,
                        units,
                        flat,
                        memory,
                        sums: &mut sums,
                    },
                );
            }
            if (0..Lane::<S>::COUNT).any(|lane| bent.get(lane) != 0.0) {
                let (deep, memory) = (&mut self.deep, &mut state.spatial);
                run(
                    self.simd,
                    SpaceLoads {
                        part,
                        placed,
                        units,
                        deep,
                        memory,
                        sums: &mut sums,
                    },
                );
            }
        }
    }
}

/// Where energies are added up.
struct EnergySums<'a, S: Simd> {
    reduction: &'a Reduction,
    groups: &'a [usize],
    /// Above zero in poses in which the part was solved in space.
    bent: Lane<S>,
    gradient: &'a mut [GroupGradient<S>],
}

impl<S: Simd> EnergySums<'_, S> {
    /// Subtracts the energies of an element in the poses that were solved in this way.
    #[inline(always)]
    fn subtract(&mut self, element: usize, energies: &GroupGradient<S>, planar: bool) {
        let (half, zero) = (self.bent.of(0.5), self.bent.of(0.0));
        let gradient = &mut self.gradient[self.groups[element]];
        for load in 0..3 {
            for property in 0..4 {
                let energy = energies[load][property];
                gradient[load][property] -= if planar {
                    self.bent.choose(half, energy, zero)
                } else {
                    self.bent.choose(half, zero, energy)
                };
            }
        }
    }
}

/// Follows the loads through a part in its plane.
struct PlaneLoads<'a, 's, S: Simd> {
    part: &'a Substructure,
    plane: usize,
    placed: &'a Placed<S>,
    units: &'a [[Lane<S>; 3]; 3],
    flat: &'a mut [Aligned<[Lane<S>; 2]>],
    memory: &'a mut SolverBuffers<S, 3, 2>,
    sums: &'a mut EnergySums<'s, S>,
}

impl<S: Simd> Kernel for PlaneLoads<'_, '_, S> {
    #[inline(always)]
    fn run(self) {
        let Self { part, placed, .. } = self;
        let (frame, _) = see_in_plane(part, self.plane, placed, self.flat);
        let mut forces = [[self.units[0]; 3]; 2];
        for load in 0..3 {
            let [force, moment] = carried_by(part, placed, self.sums.reduction, &self.units[load]);
            let [f, m] = [components(&frame, &force), components(&frame, &moment)];
            forces[0][load] = [f[1], f[2], m[0]];
            forces[1][load] = [m[1], m[2], f[0]];
        }
        let mut carriers = FlatCarriers {
            nodes: self.flat,
            sums: self.sums,
        };
        self.memory.follow(&part.schedule, &forces, &mut carriers);
    }
}

struct FlatCarriers<'a, 's, S: Simd> {
    nodes: &'a [Aligned<[Lane<S>; 2]>],
    sums: &'a mut EnergySums<'s, S>,
}

impl<S: Simd> Carriers<S, 3, 2> for FlatCarriers<'_, '_, S> {
    #[inline(always)]
    fn carry(&mut self, piece: SchedulePiece, form: ReductionForm, states: &[Block<S, 3>; 2]) {
        if let SchedulePiece::Element(element) = piece {
            let reduction = self.sums.reduction;
            let [first, second] = reduction.ends[element];
            let ends = [self.nodes[first].0, self.nodes[second].0];
            let energies = energies_in_plane(&reduction.constants[element], form, ends, states);
            self.sums.subtract(element, &energies, true);
        }
    }
}

/// Follows the loads through a part in space.
struct SpaceLoads<'a, 's, S: Simd> {
    part: &'a Substructure,
    placed: &'a Placed<S>,
    units: &'a [[Lane<S>; 3]; 3],
    deep: &'a mut [Aligned<[Lane<S>; 3]>],
    memory: &'a mut SolverBuffers<S, 6, 1>,
    sums: &'a mut EnergySums<'s, S>,
}

impl<S: Simd> Kernel for SpaceLoads<'_, '_, S> {
    #[inline(always)]
    fn run(self) {
        let Self { part, placed, .. } = self;
        see_in_space(part, placed, self.deep);
        let mut forces = [[[self.units[0][0]; 6]; 3]];
        for load in 0..3 {
            let [[fx, fy, fz], [mx, my, mz]] =
                carried_by(part, placed, self.sums.reduction, &self.units[load]);
            forces[0][load] = [fx, fy, fz, mx, my, mz];
        }
        let mut carriers = DeepCarriers {
            nodes: self.deep,
            normals: &placed.normals,
            sums: self.sums,
        };
        self.memory.follow(&part.schedule, &forces, &mut carriers);
    }
}

struct DeepCarriers<'a, 's, S: Simd> {
    nodes: &'a [Aligned<[Lane<S>; 3]>],
    normals: &'a [Aligned<[Lane<S>; 3]>],
    sums: &'a mut EnergySums<'s, S>,
}

impl<S: Simd> Carriers<S, 6, 1> for DeepCarriers<'_, '_, S> {
    #[inline(always)]
    fn carry(
        &mut self,
        piece: SchedulePiece,
        form: ReductionForm,
        [states]: &[[[Lane<S>; 6]; 3]; 1],
    ) {
        if let SchedulePiece::Element(element) = piece {
            let reduction = self.sums.reduction;
            let [first, second] = reduction.ends[element];
            let ends = [&self.nodes[first].0, &self.nodes[second].0];
            let toward_y = &self.normals[reduction.planes[element]].0;
            let constants = &reduction.constants[element];
            let energies = energies_in_space(constants, form, ends, toward_y, states);
            self.sums.subtract(element, &energies, false);
        }
    }
}

/// Force and moment at the far node of a part under a force on the end.
#[inline(always)]
fn carried_by<S: Simd>(
    part: &Substructure,
    placed: &Placed<S>,
    reduction: &Reduction,
    force: &[Lane<S>; 3],
) -> [[Lane<S>; 3]; 2] {
    let end = &placed.nodes_m[reduction.end].0;
    let arm = subtract(end, &placed.nodes_m[part.far].0);
    [*force, cross(&arm, force)]
}
