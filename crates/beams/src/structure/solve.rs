//! Factorising and solving one structure after another of the same topology.

use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, LltRegularization};
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::cholesky::LltRef;
use faer::{Conj, MatMut, Par, Side, Spec};

use stiffbench_numeric::vector::{dot, subtract};

use super::compliance::Compliance6;
use super::digits::{SIX_DIGITS, too_stiff};
use super::element::{NaturalStiffness, STRAINS, global_matrix, natural_strains};
use super::parts::{Attachment, Hinge, Structure, StructureError, Support};
use super::rotation::LocalAxes;
use super::self_weight::LoadAt;
use super::topology::{ElementMap, HELD, Topology};

/// A pivot that has lost all but this share of its diagonal entry is rounding: the structure moves there.
///
/// In the stiffest and softest shipped robots, paper factors included, pivots keep more than 1e-9 of the diagonal; exact zeros come
/// out below 1e-15.
pub(super) const LOST_PIVOT: f64 = 1e-13;

/// Solver of all structures with one topology; moves and re-rates in place and allocates nothing after it was made.
pub struct Solver {
    pub(super) topology: Arc<Topology>,
    pub(super) axes: Vec<LocalAxes>,
    pub(super) lengths_m: Vec<f64>,
    pub(super) natural: Vec<NaturalStiffness>,
    /// Upper triangle of the stiffness matrix.
    values: Vec<f64>,
    factor: Vec<f64>,
    /// Right sides, then solutions: one column of equations per load.
    pub(super) solution: Vec<f64>,
    memory: MemBuffer,
}

impl std::fmt::Debug for Solver {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Solver")
            .field("equations", &self.topology.equation_count)
            .field("elements", &self.topology.elements.len())
            .finish_non_exhaustive()
    }
}

/// What a load case does to a structure.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// Displacement of each node: ux, uy, uz (m), rx, ry, rz (rad), global.
    pub nodes: Vec<[f64; 6]>,
    /// Twist of each hinge, rad.
    pub hinges_rad: Vec<f64>,
    /// Forces on the two ends of each element.
    pub elements: Vec<EndForces>,
    /// Force and moment of each support on the structure: Fx, Fy, Fz (N), Mx, My, Mz (N·m), global; zero in freedoms that are not
    /// held.
    pub reactions: Vec<[f64; 6]>,
}

/// Forces that the nodes exert on the two ends of an element, in its local axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndForces {
    /// Fx, Fy, Fz (N), Mx, My, Mz (N·m) at the first end.
    pub first: [f64; 6],
    /// The same at the second end.
    pub second: [f64; 6],
}

impl Solver {
    /// Prepares for structures connected like this one.
    ///
    /// # Errors
    /// [`StructureError::UnknownIndex`] for a reference that points nowhere.
    pub fn new(structure: &Structure) -> Result<Self, StructureError> {
        Ok(Self::of(Arc::new(Topology::new(structure)?)))
    }

    /// Another solver of structures connected like those of this one; it holds no structure yet.
    #[must_use]
    pub fn another(&self) -> Self {
        Self::of(Arc::clone(&self.topology))
    }

    fn of(topology: Arc<Topology>) -> Self {
        let scratch = topology
            .symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default())
            .or(topology.symbolic.solve_in_place_scratch::<f64>(6, Par::Seq));
        let element_count = topology.elements.len();
        let unset = LocalAxes {
            x: [0.0; 3],
            y: [0.0; 3],
            z: [0.0; 3],
        };
        Self {
            axes: vec![unset; element_count],
            lengths_m: vec![0.0; element_count],
            natural: Vec::with_capacity(element_count),
            values: vec![0.0; topology.pattern.row_idx().len()],
            factor: vec![0.0; topology.symbolic.len_val()],
            solution: vec![0.0; 6 * topology.equation_count],
            memory: MemBuffer::new(scratch),
            topology,
        }
    }

    /// Takes positions, axes, sections and hinge stiffnesses of `structure` and factorises.
    ///
    /// # Errors
    /// [`StructureError::Mechanism`] naming the freedom that moves; [`StructureError::DegenerateElement`];
    /// [`StructureError::ImpossibleConstant`]; [`StructureError::ImpossibleAxis`].
    ///
    /// # Panics
    /// If the structure is connected otherwise than the one this solver was made for.
    pub fn update(&mut self, structure: &Structure) -> Result<(), StructureError> {
        self.move_to(structure)?;
        self.update_sections(structure)
    }

    /// Takes sections and hinge stiffnesses of `structure`, which must stand where it stood, and factorises.
    ///
    /// # Errors
    /// As [`Solver::update`].
    pub fn update_sections(&mut self, structure: &Structure) -> Result<(), StructureError> {
        self.natural.clear();
        for (index, (element, &length_m)) in
            structure.elements.iter().zip(&self.lengths_m).enumerate()
        {
            let natural =
                NaturalStiffness::of(&element.section, &element.material, element.shear, length_m);
            // Possible constants may still give a stiffness that is none, by overflow.
            let overflow = natural.stiffness.into_iter().find(|d| !d.is_finite());
            let impossible = element.impossible_constant();
            if let Some((what, value)) = impossible.or(overflow.map(|d| ("a stiffness", d))) {
                return Err(StructureError::ImpossibleConstant {
                    what,
                    of: format!("element {index}"),
                    value,
                });
            }
            self.natural.push(natural);
        }
        self.assemble(structure)?;
        self.factorise(structure)
    }

    /// Local axes and lengths at new node positions.
    fn move_to(&mut self, structure: &Structure) -> Result<(), StructureError> {
        let same = structure.nodes.len() == self.topology.node_count
            && structure.elements.len() == self.topology.elements.len()
            && structure.hinges.len() == self.topology.hinge_equations.len();
        assert!(same, "a solver serves structures of one topology");
        structure.hinges.iter().try_for_each(Hinge::check_axis)?;
        for (index, element) in structure.elements.iter().enumerate() {
            let [first, second] = [0, 1].map(|end| &structure.nodes[element.ends[end].node]);
            let span = subtract(second.position_m, first.position_m);
            let Some((axes, length_m)) = LocalAxes::along(span, element.toward_y) else {
                return Err(StructureError::DegenerateElement {
                    element: index,
                    first: first.name.clone(),
                    second: second.name.clone(),
                });
            };
            self.axes[index] = axes;
            self.lengths_m[index] = length_m;
        }
        Ok(())
    }

    /// Sums the elements into the stiffness matrix (the paper's eq. (29) and what leads to (31)).
    fn assemble(&mut self, structure: &Structure) -> Result<(), StructureError> {
        self.values.fill(0.0);
        for (index, map) in self.topology.elements.iter().enumerate() {
            let matrix = global_matrix(
                &self.axes[index],
                self.lengths_m[index],
                &self.natural[index],
            );
            for slot in &map.slots {
                self.values[slot.value as usize] += if map.hinges.is_empty() {
                    matrix[slot.row as usize][slot.column as usize]
                } else {
                    extended_entry(&matrix, map, structure, slot.row.into(), slot.column.into())
                };
            }
        }
        for (hinge, &equation) in structure.hinges.iter().zip(&self.topology.hinge_equations) {
            let stiffness = hinge.stiffness_nm_per_rad;
            if !(stiffness.is_finite() && stiffness >= 0.0) {
                return Err(StructureError::ImpossibleConstant {
                    what: "the stiffness",
                    of: format!("joint {}", hinge.name),
                    value: stiffness,
                });
            }
            self.values[self.topology.diagonal_slots[equation]] += stiffness;
        }
        Ok(())
    }

    /// Numeric factorisation, with a look at every pivot.
    fn factorise(&mut self, structure: &Structure) -> Result<(), StructureError> {
        let matrix = SparseColMatRef::new(self.topology.pattern.as_ref(), &self.values[..]);
        let outcome = self.topology.symbolic.factorize_numeric_llt(
            &mut self.factor,
            matrix,
            Side::Upper,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut self.memory),
            Spec::default(),
        );
        let least = match outcome {
            Err(LltError::NonPositivePivot { .. }) => 0.0,
            Ok(_) => self.pivot_shares().fold(1.0, |least: f64, share| {
                if share.is_nan() {
                    0.0
                } else {
                    least.min(share)
                }
            }),
        };
        if least >= SIX_DIGITS {
            return Ok(());
        }
        if let Some(too_stiff) = too_stiff(&self.natural, structure) {
            return Err(too_stiff);
        }
        if least < LOST_PIVOT {
            let equation = self.topology.loosest_equation(&self.values);
            return Err(StructureError::Mechanism {
                freedom: self.topology.freedom(equation, structure),
            });
        }
        Ok(())
    }

    /// What each pivot keeps of its diagonal entry.
    fn pivot_shares(&self) -> impl Iterator<Item = f64> {
        use faer::sparse::linalg::cholesky::SymbolicCholeskyRaw;
        let SymbolicCholeskyRaw::Simplicial(symbolic) = self.topology.symbolic.raw() else {
            unreachable!("the topology requires a simplicial factorisation");
        };
        let starts = &symbolic.col_ptr()[..self.topology.equation_count];
        starts
            .iter()
            .zip(&self.topology.diagonal_slots)
            .map(|(&start, &slot)| self.factor[start].powi(2) / self.values[slot])
    }

    /// Solves for `count` right sides already in `self.solution`; at most six.
    pub(super) fn solve_in_place(&mut self, count: usize) {
        let n = self.topology.equation_count;
        let right_sides =
            MatMut::from_column_major_slice_mut(&mut self.solution[..n * count], n, count);
        LltRef::new(&self.topology.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            right_sides,
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
    }

    /// Adds a force and moment at an attachment to right side `column`.
    fn add_load(&mut self, structure: &Structure, at: &Attachment, load: [f64; 6], column: usize) {
        let offset = column * self.topology.equation_count;
        for (component, value) in load.into_iter().enumerate() {
            if let Some(equation) = self.topology.equation(at.node, component) {
                self.solution[offset + equation] += value;
            }
        }
        for &hinge in &at.hinges {
            let moment = dot(structure.hinges[hinge].axis, [load[3], load[4], load[5]]);
            self.solution[offset + self.topology.hinge_equations[hinge]] += moment;
        }
    }

    /// Displacement or rotation `component` of an attachment in solution `column`.
    pub(super) fn read(
        &self,
        structure: &Structure,
        at: &Attachment,
        component: usize,
        column: usize,
    ) -> f64 {
        let offset = column * self.topology.equation_count;
        let node_part = self
            .topology
            .equation(at.node, component)
            .map_or(0.0, |e| self.solution[offset + e]);
        if component < 3 {
            return node_part;
        }
        at.hinges.iter().fold(node_part, |sum, &hinge| {
            let twist = self.solution[offset + self.topology.hinge_equations[hinge]];
            sum + structure.hinges[hinge].axis[component - 3] * twist
        })
    }

    /// Solves unit loads along the first `count` of Fx, Fy, Fz, Mx, My, Mz at the end; the solutions stay for
    /// [`Solver::compliance_gradient`].
    fn respond_to_unit_loads(&mut self, structure: &Structure, count: usize) {
        let n = self.topology.equation_count;
        self.solution[..n * count].fill(0.0);
        let end = self.topology.end.clone();
        for column in 0..count {
            let mut load = [0.0; 6];
            load[column] = 1.0;
            self.add_load(structure, &end, load, column);
        }
        self.solve_in_place(count);
    }

    /// Compliance of the end, all six freedoms.
    ///
    /// Call [`Solver::update`] first; `structure` is the one given there.
    #[must_use]
    pub fn end_compliance(&mut self, structure: &Structure) -> Compliance6 {
        self.respond_to_unit_loads(structure, 6);
        let end = &self.topology.end;
        Compliance6(std::array::from_fn(|i| {
            std::array::from_fn(|j| self.read(structure, end, i, j))
        }))
    }

    /// Displacement per force at the end, 3 × 3, m/N: half the work of [`Solver::end_compliance`].
    #[must_use]
    pub fn end_translation_compliance(&mut self, structure: &Structure) -> [[f64; 3]; 3] {
        self.respond_to_unit_loads(structure, 3);
        let end = &self.topology.end;
        std::array::from_fn(|i| std::array::from_fn(|j| self.read(structure, end, i, j)))
    }

    /// Natural strains of an element in solution `column` of the last response.
    pub(super) fn strains(
        &self,
        structure: &Structure,
        element: usize,
        column: usize,
    ) -> [f64; STRAINS] {
        let map = &self.topology.elements[element];
        let solution = &self.solution[column * self.topology.equation_count..];
        let value = |equation: usize| {
            if equation == HELD {
                0.0
            } else {
                solution[equation]
            }
        };
        let mut ends: [f64; 12] = std::array::from_fn(|freedom| value(map.equations[freedom]));
        for (&(end, hinge), &equation) in map.hinges.iter().zip(&map.equations[12..]) {
            for (component, share) in structure.hinges[hinge].axis.into_iter().enumerate() {
                ends[6 * end + 3 + component] += share * value(equation);
            }
        }
        natural_strains(&self.axes[element], self.lengths_m[element], &ends)
    }

    /// Displacement and rotation of the end under any loads (force and moment where they act).
    ///
    /// Call [`Solver::update`] first; `structure` is the one given there.
    #[must_use]
    pub fn end_displacement(&mut self, structure: &Structure, loads: &[LoadAt]) -> [f64; 6] {
        self.solve_loads(structure, loads);
        let end = &self.topology.end;
        std::array::from_fn(|component| self.read(structure, end, component, 0))
    }

    fn solve_loads(&mut self, structure: &Structure, loads: &[LoadAt]) {
        self.solution[..self.topology.equation_count].fill(0.0);
        for (at, load) in loads {
            self.add_load(structure, at, *load, 0);
        }
        self.solve_in_place(1);
    }

    /// Displacements, element forces and reactions under any loads (force and moment where they act).
    ///
    /// Call [`Solver::update`] first; `structure` is the one given there.
    #[must_use]
    pub fn respond(&mut self, structure: &Structure, loads: &[LoadAt]) -> Response {
        self.solve_loads(structure, loads);
        let value = |node, component| {
            self.topology
                .equation(node, component)
                .map_or(0.0, |e| self.solution[e])
        };
        let elements: Vec<EndForces> = (0..self.topology.elements.len())
            .map(|element| {
                let strains = self.strains(structure, element, 0);
                let stiffness = &self.natural[element].stiffness;
                end_forces(
                    std::array::from_fn(|m| stiffness[m] * strains[m]),
                    self.lengths_m[element],
                )
            })
            .collect();
        Response {
            nodes: (0..self.topology.node_count)
                .map(|node| std::array::from_fn(|component| value(node, component)))
                .collect(),
            hinges_rad: self
                .topology
                .hinge_equations
                .iter()
                .map(|&e| self.solution[e])
                .collect(),
            reactions: self.reactions(structure, loads, &elements),
            elements,
        }
    }

    /// What the supports must add to balance element ends and loads at their nodes.
    fn reactions(
        &self,
        structure: &Structure,
        loads: &[LoadAt],
        forces: &[EndForces],
    ) -> Vec<[f64; 6]> {
        let reaction = |support: &Support| {
            let mut sum = [0.0; 6];
            for (place, element) in structure.elements.iter().enumerate() {
                for (end, local) in [forces[place].first, forces[place].second]
                    .into_iter()
                    .enumerate()
                {
                    if element.ends[end].node == support.node {
                        add_global(&mut sum, &self.axes[place], local);
                    }
                }
            }
            for (_, load) in loads.iter().filter(|(at, _)| at.node == support.node) {
                for (component, value) in sum.iter_mut().zip(load) {
                    *component -= value;
                }
            }
            std::array::from_fn(|i| if support.held[i] { sum[i] } else { 0.0 })
        };
        structure.supports.iter().map(reaction).collect()
    }
}

/// End forces from the natural forces: the transpose of the strain definitions.
fn end_forces([n, t, my, qy, mz, qz]: [f64; STRAINS], length_m: f64) -> EndForces {
    let chord = 2.0 / length_m;
    EndForces {
        first: [-n, chord * qz, -chord * qy, -t, my + qy, mz + qz],
        second: [n, -chord * qz, chord * qy, t, qy - my, qz - mz],
    }
}

/// Adds local forces and moments, turned to global axes.
fn add_global(sum: &mut [f64; 6], axes: &LocalAxes, local: [f64; 6]) {
    for i in 0..3 {
        sum[i] += axes.x[i] * local[0] + axes.y[i] * local[1] + axes.z[i] * local[2];
        sum[3 + i] += axes.x[i] * local[3] + axes.y[i] * local[4] + axes.z[i] * local[5];
    }
}

/// Entry of an element's matrix over its twelve end freedoms and its hinges: a hinge turns its end about its axis.
fn extended_entry(
    matrix: &[[f64; 12]; 12],
    map: &ElementMap,
    structure: &Structure,
    row: usize,
    column: usize,
) -> f64 {
    let parts = |freedom: usize| -> ([usize; 3], [f64; 3]) {
        if freedom < 12 {
            return ([freedom; 3], [1.0, 0.0, 0.0]);
        }
        let (end, hinge) = map.hinges[freedom - 12];
        let first = 6 * end + 3;
        ([first, first + 1, first + 2], structure.hinges[hinge].axis)
    };
    let (rows, row_shares) = parts(row);
    let (columns, column_shares) = parts(column);
    let mut sum = 0.0;
    for (i, a) in rows.into_iter().zip(row_shares) {
        for (j, b) in columns.into_iter().zip(column_shares) {
            sum += a * b * matrix[i][j];
        }
    }
    sum
}
