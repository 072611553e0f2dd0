//! How the compliance of the end changes with section constants and springs, from the strain energy of every element.
//!
//! A unit load moves the end by a column of the compliance C. What an element then carries follows from the solution, and
//! ∂C_ij/∂ln p = -2 U_ij with U_ij the bilinear strain energy of loads i and j that depends on the constant p; of a spring with
//! compliance c, ∂C_ij/∂c is the product of what both loads put on it. Exact, as in [`Solver`](crate::structure::Solver).

use pulp::Simd;

use super::block::Block;
use super::execute::{Carriers, LOADS, SolverBuffers, States};
use super::member::{components, hinge_motion, hinge_motion_in_plane};
use super::placed::Placed;
use super::schedule::{ReductionForm, SchedulePiece};
use super::solve::{Reducer, see_in_plane, see_in_space};
use super::strained::StrainedElement;
use super::substructure::{Reduction, Substructure};
use crate::structure::gradient::ParameterPlaces;
use stiffbench_numeric::simd::{Aligned, Kernel, Lane, Number, cross, multiply_add, run, subtract};

/// Derivatives of the displacement along three directions per force along each, to ln A, ln Iy, ln Iz, ln J of all elements of a group,
/// m/N.
pub(crate) type GroupGradient<S> = [[Lane<S>; 4]; 3];

/// Derivatives of the whole compliance to a parameter; only the upper triangle is set.
pub(crate) type WholeGradient<S> = Block<S, 6>;

/// A force and a moment on the end.
type Load<S> = [[Lane<S>; 3]; 2];

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
        let zero = Lane::zero(self.simd);
        gradient.fill([[zero; 4]; 3]);
        let mut sums = GroupSums { groups, gradient };
        let loads = units.map(|unit| [unit, [zero; 3]]);
        self.follow(reduction, placed, &loads, &mut sums);
    }

    /// Derivatives of the whole compliance solved last to parameters, by a reducer made for derivatives.
    ///
    /// # Arguments
    /// - `gradient`: one a parameter, overwritten.
    pub(crate) fn differentiate_whole(
        &mut self,
        reduction: &Reduction,
        placed: &Placed<S>,
        places: &ParameterPlaces,
        gradient: &mut [WholeGradient<S>],
    ) {
        let (zero, one) = (Lane::zero(self.simd), Lane::one(self.simd));
        gradient.fill([[zero; 6]; 6]);
        let mut sums = WholeSums { places, gradient };
        let mut loads = [[[zero; 3]; 2]; LOADS];
        for load in 0..LOADS {
            loads[load][load / 3][load % 3] = one;
        }
        self.follow(reduction, placed, &loads, &mut sums);
    }

    /// Follows loads on the end to every piece.
    fn follow<const L: usize, E: EnergySums<S, L>>(
        &mut self,
        reduction: &Reduction,
        placed: &Placed<S>,
        loads: &[Load<S>; L],
        energies: &mut E,
    ) {
        for (part, state) in reduction.parts.iter().zip(&mut self.parts) {
            // Without a plane a part is out of it in every pose.
            let bent = match part.plane {
                Some(_) => state.solution.bent,
                None => Lane::one(self.simd),
            };
            let mut sums = PartSums {
                reduction,
                bent,
                energies: &mut *energies,
            };
            if let Some(plane) = part.plane {
                let (flat, memory) = (&mut self.flat, &mut state.planar);
                run(
                    self.simd,
                    PlaneLoads {
                        part,
                        plane,
                        placed,
                        loads,
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
                        loads,
                        deep,
                        memory,
                        sums: &mut sums,
                    },
                );
            }
        }
    }
}

/// What takes the energies of pieces under `L` loads. A share of zero leaves a pose out.
trait EnergySums<S: Simd, const L: usize> {
    /// Whether an element counts.
    fn wants(&self, element: usize) -> bool;
    fn element(
        &mut self,
        reduction: &Reduction,
        element: usize,
        strained: &StrainedElement<S, L>,
        kept: &SolvedLanes<S>,
    );
    /// Of a hinge under moments, or forces of one that slides.
    fn hinge(&mut self, hinge: usize, loads: &[Lane<S>; L], kept: &SolvedLanes<S>);
}

/// In which poses a part was solved in this way.
struct SolvedLanes<S: Simd> {
    bent: Lane<S>,
    planar: bool,
}

impl<S: Simd> SolvedLanes<S> {
    /// A value, or zero in the other poses.
    #[inline(always)]
    fn of(&self, value: Lane<S>) -> Lane<S> {
        let (half, zero) = (self.bent.of(0.5), self.bent.of(0.0));
        if self.planar {
            self.bent.choose(half, value, zero)
        } else {
            self.bent.choose(half, zero, value)
        }
    }
}

/// Energies of elements by group, of each load alone.
struct GroupSums<'a, S: Simd> {
    groups: &'a [usize],
    gradient: &'a mut [GroupGradient<S>],
}

impl<S: Simd> EnergySums<S, 3> for GroupSums<'_, S> {
    #[inline(always)]
    fn wants(&self, _: usize) -> bool {
        true
    }

    #[inline(always)]
    fn element(
        &mut self,
        reduction: &Reduction,
        element: usize,
        strained: &StrainedElement<S, 3>,
        kept: &SolvedLanes<S>,
    ) {
        let gradient = &mut self.gradient[self.groups[element]];
        for load in 0..3 {
            let energies = strained.energies(&reduction.constants[element], load, load);
            for property in 0..4 {
                gradient[load][property] -= kept.of(energies[property]);
            }
        }
    }

    #[inline(always)]
    fn hinge(&mut self, _: usize, _: &[Lane<S>; 3], _: &SolvedLanes<S>) {}
}

/// Energies by parameter, of all pairs of loads.
struct WholeSums<'a, S: Simd> {
    places: &'a ParameterPlaces,
    gradient: &'a mut [WholeGradient<S>],
}

impl<S: Simd> EnergySums<S, LOADS> for WholeSums<'_, S> {
    #[inline(always)]
    fn wants(&self, element: usize) -> bool {
        !self.places.of_elements[element].is_empty()
    }

    #[inline(always)]
    fn element(
        &mut self,
        reduction: &Reduction,
        element: usize,
        strained: &StrainedElement<S, LOADS>,
        kept: &SolvedLanes<S>,
    ) {
        for i in 0..LOADS {
            for j in i..LOADS {
                let energies = strained.energies(&reduction.constants[element], i, j);
                for (place, property) in &self.places.of_elements[element] {
                    self.gradient[*place][i][j] -= kept.of(energies[property.index()]);
                }
            }
        }
    }

    #[inline(always)]
    fn hinge(&mut self, hinge: usize, loads: &[Lane<S>; LOADS], kept: &SolvedLanes<S>) {
        if let Some(place) = self.places.of_hinges[hinge] {
            for i in 0..LOADS {
                for j in i..LOADS {
                    self.gradient[place][i][j] += kept.of(loads[i] * loads[j]);
                }
            }
        }
    }
}

/// Where the energies of a part go.
struct PartSums<'a, S: Simd, E> {
    reduction: &'a Reduction,
    /// Above zero in poses in which the part was solved in space.
    bent: Lane<S>,
    energies: &'a mut E,
}

impl<S: Simd, E> PartSums<'_, S, E> {
    /// Takes the moments in a hinge.
    #[inline(always)]
    fn twist<const L: usize>(&mut self, hinge: usize, moments: &[Lane<S>; LOADS], planar: bool)
    where
        E: EnergySums<S, L>,
    {
        let kept = SolvedLanes {
            bent: self.bent,
            planar,
        };
        let mut loads = [moments[0]; L];
        loads.copy_from_slice(&moments[..L]);
        self.energies.hinge(hinge, &loads, &kept);
    }
}

/// Follows the loads through a part in its plane.
struct PlaneLoads<'a, 's, S: Simd, E, const L: usize> {
    part: &'a Substructure,
    plane: usize,
    placed: &'a Placed<S>,
    loads: &'a [Load<S>; L],
    flat: &'a mut [Aligned<[Lane<S>; 2]>],
    memory: &'a mut SolverBuffers<S, 3, 2>,
    sums: &'a mut PartSums<'s, S, E>,
}

impl<S: Simd, E: EnergySums<S, L>, const L: usize> Kernel for PlaneLoads<'_, '_, S, E, L> {
    #[inline(always)]
    fn run(self) {
        let Self { part, placed, .. } = self;
        let (frame, bent) = see_in_plane(part, self.plane, placed, self.flat);
        let mut forces = [[[bent.of(0.0); 3]; LOADS]; 2];
        for load in 0..L {
            let [force, moment] = carried_by(part, placed, self.sums.reduction, &self.loads[load]);
            let [f, m] = [components(&frame, &force), components(&frame, &moment)];
            forces[0][load] = [f[1], f[2], m[0]];
            forces[1][load] = [m[1], m[2], f[0]];
        }
        let mut carriers = FlatCarriers::<S, E, L> {
            nodes: self.flat,
            sums: self.sums,
        };
        let memory = self.memory;
        memory.follow::<L, _>(&part.schedule, &forces, &mut carriers);
    }
}

struct FlatCarriers<'a, 's, S: Simd, E, const L: usize> {
    nodes: &'a [Aligned<[Lane<S>; 2]>],
    sums: &'a mut PartSums<'s, S, E>,
}

impl<S: Simd, E: EnergySums<S, L>, const L: usize> Carriers<S, 3, 2>
    for FlatCarriers<'_, '_, S, E, L>
{
    #[inline(always)]
    fn carry(&mut self, piece: SchedulePiece, form: ReductionForm, states: &States<S, 3, 2>) {
        let PartSums {
            reduction,
            bent,
            energies,
        } = self.sums;
        let kept = SolvedLanes {
            bent: *bent,
            planar: true,
        };
        match piece {
            SchedulePiece::Element(element) if energies.wants(element) => {
                let [first, second] = reduction.ends[element];
                let ends = [self.nodes[first].0, self.nodes[second].0];
                let constants = &reduction.constants[element];
                let strained = StrainedElement::<S, L>::in_plane(constants, form, ends, states);
                energies.element(reduction, element, &strained, &kept);
            }
            SchedulePiece::Element(_) => {}
            SchedulePiece::Hinge(hinge) => {
                let [p, q] = self.nodes[reduction.hinges[hinge].node].0;
                let mut loads = [p; L];
                for load in 0..L {
                    let [fp, fq, mn] = states[0][load];
                    loads[load] = multiply_add(q, fp, mn) - p * fq;
                }
                energies.hinge(hinge, &loads, &kept);
            }
        }
    }

    #[inline(always)]
    fn hinge(&mut self, hinge: usize) -> ([[Lane<S>; 3]; 2], f64) {
        let own = &self.sums.reduction.hinges[hinge];
        (
            hinge_motion_in_plane(self.nodes[own.node].0),
            own.rad_per_nm,
        )
    }

    #[inline(always)]
    fn twist(&mut self, hinge: usize, moments: &[Lane<S>; LOADS]) {
        self.sums.twist::<L>(hinge, moments, true);
    }
}

/// Follows the loads through a part in space.
struct SpaceLoads<'a, 's, S: Simd, E, const L: usize> {
    part: &'a Substructure,
    placed: &'a Placed<S>,
    loads: &'a [Load<S>; L],
    deep: &'a mut [Aligned<[Lane<S>; 3]>],
    memory: &'a mut SolverBuffers<S, 6, 1>,
    sums: &'a mut PartSums<'s, S, E>,
}

impl<S: Simd, E: EnergySums<S, L>, const L: usize> Kernel for SpaceLoads<'_, '_, S, E, L> {
    #[inline(always)]
    fn run(self) {
        let Self { part, placed, .. } = self;
        see_in_space(part, placed, self.deep);
        let zero = placed.faults.of(0.0);
        let mut forces = [[[zero; 6]; LOADS]];
        for load in 0..L {
            let [[fx, fy, fz], [mx, my, mz]] =
                carried_by(part, placed, self.sums.reduction, &self.loads[load]);
            forces[0][load] = [fx, fy, fz, mx, my, mz];
        }
        let mut carriers = DeepCarriers::<S, E, L> {
            nodes: self.deep,
            normals: &placed.normals,
            sums: self.sums,
        };
        let memory = self.memory;
        memory.follow::<L, _>(&part.schedule, &forces, &mut carriers);
    }
}

struct DeepCarriers<'a, 's, S: Simd, E, const L: usize> {
    nodes: &'a [Aligned<[Lane<S>; 3]>],
    normals: &'a [Aligned<[Lane<S>; 3]>],
    sums: &'a mut PartSums<'s, S, E>,
}

impl<S: Simd, E: EnergySums<S, L>, const L: usize> Carriers<S, 6, 1>
    for DeepCarriers<'_, '_, S, E, L>
{
    #[inline(always)]
    fn carry(&mut self, piece: SchedulePiece, form: ReductionForm, states: &States<S, 6, 1>) {
        let PartSums {
            reduction,
            bent,
            energies,
        } = self.sums;
        let kept = SolvedLanes {
            bent: *bent,
            planar: false,
        };
        match piece {
            SchedulePiece::Element(element) if energies.wants(element) => {
                let [first, second] = reduction.ends[element];
                let ends = [&self.nodes[first].0, &self.nodes[second].0];
                let toward_y = &self.normals[reduction.planes[element]].0;
                let constants = &reduction.constants[element];
                let strained =
                    StrainedElement::<S, L>::in_space(constants, form, ends, toward_y, states);
                energies.element(reduction, element, &strained, &kept);
            }
            SchedulePiece::Element(_) => {}
            SchedulePiece::Hinge(hinge) => {
                let own = &reduction.hinges[hinge];
                let (node, axis) = (&self.nodes[own.node].0, &self.normals[own.plane].0);
                let motion = hinge_motion(node, axis, own.slides);
                let mut loads = [motion[0]; L];
                for load in 0..L {
                    let mut work = motion[0] * states[0][load][0];
                    for i in 1..6 {
                        work = multiply_add(motion[i], states[0][load][i], work);
                    }
                    loads[load] = work;
                }
                energies.hinge(hinge, &loads, &kept);
            }
        }
    }

    #[inline(always)]
    fn hinge(&mut self, hinge: usize) -> ([[Lane<S>; 6]; 1], f64) {
        let own = &self.sums.reduction.hinges[hinge];
        let (node, axis) = (&self.nodes[own.node].0, &self.normals[own.plane].0);
        ([hinge_motion(node, axis, own.slides)], own.rad_per_nm)
    }

    #[inline(always)]
    fn twist(&mut self, hinge: usize, moments: &[Lane<S>; LOADS]) {
        self.sums.twist::<L>(hinge, moments, false);
    }
}

/// Force and moment at the origin of a part under those on the end.
#[inline(always)]
fn carried_by<S: Simd>(
    part: &Substructure,
    placed: &Placed<S>,
    reduction: &Reduction,
    [force, moment]: &Load<S>,
) -> Load<S> {
    let end = &placed.nodes_m[reduction.end].0;
    let arm = subtract(end, &placed.nodes_m[part.origin].0);
    let mut carried = cross(&arm, force);
    for i in 0..3 {
        carried[i] += moment[i];
    }
    [*force, carried]
}
