//! Factorising and solving one structure after another of the same topology.

use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, LltRegularization};
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::cholesky::LltRef;
use faer::{Conj, MatMut, Par, Side, Spec};

use stiffbench_numeric::vector::subtract;

use super::closed_loops::ConstrainedFactor;
use super::clusters::VertexColumn;
use super::compliance::Compliance6;
use super::digits::{SIX_DIGITS, too_stiff};
use super::element::{NaturalStiffness, STRAINS, global_matrix, natural_strains};
use super::parts::{Hinge, Structure, StructureError};
use super::rotation::LocalAxes;
use super::self_weight::LoadAt;
use super::topology::{HELD, Topology};

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
    /// Of each vertex, what moves it.
    pub(super) columns: Vec<Vec<VertexColumn>>,
    /// Upper triangle of the stiffness matrix.
    values: Vec<f64>,
    factor: Vec<f64>,
    /// In place of `factor` where rigid members close loops.
    constrained: ConstrainedFactor,
    /// Right sides, then solutions: one column of equations per load.
    pub(super) solution: Vec<f64>,
    /// Forces on the ends of the element at its turn per unit of each of its freedoms.
    products: Vec<[f64; 12]>,
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
            columns: vec![Vec::new(); topology.clusters.vertices.len()],
            values: vec![0.0; topology.pattern.row_idx().len()],
            factor: vec![0.0; topology.symbolic.len_val()],
            constrained: ConstrainedFactor::default(),
            solution: vec![0.0; 6 * topology.equation_count],
            products: Vec::new(),
            memory: MemBuffer::new(scratch),
            topology,
        }
    }

    /// Takes positions, axes, sections and hinge stiffnesses of `structure` and factorises.
    ///
    /// # Errors
    /// [`StructureError::Mechanism`] naming the freedom that moves; [`StructureError::DegenerateElement`];
    /// [`StructureError::ImpossibleConstant`]; [`StructureError::ImpossibleAxis`]; [`StructureError::SingularLoop`].
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
        let clusters = &self.topology.clusters;
        assert!(same, "a solver serves structures of one topology");
        structure.hinges.iter().try_for_each(Hinge::check_axis)?;
        for (vertex, columns) in self.columns.iter_mut().enumerate() {
            // Those of a node that moves by itself never change.
            if columns.is_empty() || !clusters.is_free_node(vertex) {
                columns.clear();
                columns.extend(clusters.columns(structure, vertex));
            }
        }
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
            if map.columns.is_empty() {
                for slot in &map.slots {
                    self.values[slot.value as usize] +=
                        matrix[slot.row as usize][slot.column as usize];
                }
                continue;
            }
            let of_freedom =
                |&(end, column): &(usize, usize)| (end, &self.columns[map.vertices[end]][column]);
            self.products.clear();
            let freedoms = map.columns.iter().map(of_freedom);
            self.products
                .extend(freedoms.map(|(end, column)| times(&matrix, end, column)));
            for slot in &map.slots {
                let (end, column) = of_freedom(&map.columns[usize::from(slot.row)]);
                let product = &self.products[usize::from(slot.column)];
                self.values[slot.value as usize] += along(column, product, end);
            }
        }
        for (strut, map) in structure.struts.iter().zip(&self.topology.struts) {
            let count = map.columns.len();
            let own = strut.stiffness(structure, &self.topology.clusters, &map.columns);
            for slot in &map.slots {
                self.values[slot.value as usize] +=
                    own[usize::from(slot.row) * count + usize::from(slot.column)];
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
        if self.topology.equation_count == 0 {
            return Ok(());
        }
        if !self.topology.clusters.closures.is_empty() {
            return self.factorise_loops(structure);
        }
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

    /// The same where rigid members close loops.
    fn factorise_loops(&mut self, structure: &Structure) -> Result<(), StructureError> {
        let n = self.topology.equation_count;
        let mut dense = vec![0.0; n * n];
        let starts = self.topology.pattern.col_ptr();
        for column in 0..n {
            for slot in starts[column]..starts[column + 1] {
                let row = self.topology.pattern.row_idx()[slot];
                dense[row * n + column] = self.values[slot];
                dense[column * n + row] = self.values[slot];
            }
        }
        let (factor, least) = ConstrainedFactor::of(&self.topology, structure, &dense)?;
        self.constrained = factor;
        let lost = (least < SIX_DIGITS).then(|| too_stiff(&self.natural, structure));
        lost.flatten().map_or(Ok(()), Err)
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
        if n == 0 {
            return;
        }
        if !self.topology.clusters.closures.is_empty() {
            for right_side in self.solution[..n * count].chunks_exact_mut(n) {
                self.constrained.solve(right_side);
            }
            return;
        }
        let right_sides =
            MatMut::from_column_major_slice_mut(&mut self.solution[..n * count], n, count);
        LltRef::new(&self.topology.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            right_sides,
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
    }

    /// Each column of an attachment with its equation, [`HELD`] left out; none where nothing of the structure hangs.
    fn moving(&self, vertex: usize) -> impl Iterator<Item = (usize, &VertexColumn)> {
        let equations = self.topology.vertex_equations[vertex].iter().copied();
        let columns = equations.zip(&self.columns[vertex]);
        columns.filter(|(equation, _)| *equation != HELD)
    }

    /// Adds a force and moment at a vertex to right side `column`.
    fn add_load(&mut self, vertex: usize, load: [f64; 6], column: usize) {
        let offset = column * self.topology.equation_count;
        let equations = &self.topology.vertex_equations[vertex];
        for (&equation, moved) in equations.iter().zip(&self.columns[vertex]) {
            if equation != HELD {
                self.solution[offset + equation] += product(moved, &load);
            }
        }
    }

    /// Displacement or rotation `component` of a vertex in solution `column`.
    pub(super) fn read(&self, vertex: usize, component: usize, column: usize) -> f64 {
        let offset = column * self.topology.equation_count;
        self.moving(vertex).fold(0.0, |sum, (equation, moved)| {
            sum + moved[component] * self.solution[offset + equation]
        })
    }

    /// Solves unit loads along the first `count` of Fx, Fy, Fz, Mx, My, Mz at the end; the solutions stay for
    /// [`Solver::compliance_gradient`].
    fn respond_to_unit_loads(&mut self, count: usize) {
        let n = self.topology.equation_count;
        self.solution[..n * count].fill(0.0);
        for column in 0..count {
            let mut load = [0.0; 6];
            load[column] = 1.0;
            self.add_load(self.topology.end, load, column);
        }
        self.solve_in_place(count);
    }

    /// Compliance of the end, all six freedoms.
    ///
    /// Call [`Solver::update`] first.
    #[must_use]
    pub fn end_compliance(&mut self) -> Compliance6 {
        self.respond_to_unit_loads(6);
        let end = self.topology.end;
        Compliance6(std::array::from_fn(|i| {
            std::array::from_fn(|j| self.read(end, i, j))
        }))
    }

    /// Displacement per force at the end, 3 × 3, m/N: half the work of [`Solver::end_compliance`].
    #[must_use]
    pub fn end_translation_compliance(&mut self) -> [[f64; 3]; 3] {
        self.respond_to_unit_loads(3);
        let end = self.topology.end;
        std::array::from_fn(|i| std::array::from_fn(|j| self.read(end, i, j)))
    }

    /// Natural strains of an element in solution `column` of the last response.
    pub(crate) fn strains(&self, element: usize, column: usize) -> [f64; STRAINS] {
        let solution = &self.solution[column * self.topology.equation_count..];
        let ends = self.end_motions(element, solution);
        natural_strains(&self.axes[element], self.lengths_m[element], &ends)
    }

    /// Motions of the two ends of an element, but for what both have in common as one rigid body.
    pub(super) fn end_motions(&self, element: usize, solution: &[f64]) -> [f64; 12] {
        let map = &self.topology.elements[element];
        let mut ends = [0.0; 12];
        if map.columns.is_empty() {
            for (value, &equation) in ends.iter_mut().zip(&map.equations) {
                if equation != HELD {
                    *value = solution[equation];
                }
            }
        }
        for (&(end, column), &equation) in map.columns.iter().zip(&map.equations) {
            let moved = &self.columns[map.vertices[end]][column];
            for (value, share) in ends[6 * end..].iter_mut().zip(moved) {
                *value += share * solution[equation];
            }
        }
        ends
    }

    /// Displacement and rotation of the end under any loads (force and moment where they act).
    ///
    /// Call [`Solver::update`] first; `structure` is the one given there.
    #[must_use]
    pub fn end_displacement(&mut self, loads: &[LoadAt]) -> [f64; 6] {
        self.solve_loads(loads);
        std::array::from_fn(|component| self.read(self.topology.end, component, 0))
    }

    /// Solves loads; those that hang on nothing of the structure do nothing.
    pub(super) fn solve_loads(&mut self, loads: &[LoadAt]) {
        self.solution[..self.topology.equation_count].fill(0.0);
        for (at, load) in loads {
            if let Some(vertex) = self.topology.clusters.vertex(at) {
                self.add_load(vertex, *load, 0);
            }
        }
        self.solve_in_place(1);
    }
}

/// Product of a matrix over twelve end freedoms with a motion of one end.
fn times(matrix: &[[f64; 12]; 12], end: usize, column: &VertexColumn) -> [f64; 12] {
    let mut product = [0.0; 12];
    for (freedom, &share) in column.iter().enumerate() {
        if share != 0.0 {
            // Symmetric: the row is the column.
            for (sum, entry) in product.iter_mut().zip(&matrix[6 * end + freedom]) {
                *sum += share * entry;
            }
        }
    }
    product
}

/// Work of forces on the twelve end freedoms in a motion of one end.
fn along(column: &VertexColumn, forces: &[f64; 12], end: usize) -> f64 {
    let forces = &forces[6 * end..6 * end + 6];
    column
        .iter()
        .zip(forces)
        .map(|(share, force)| share * force)
        .sum()
}

/// Work of a force and moment in a motion.
fn product(column: &VertexColumn, load: &[f64; 6]) -> f64 {
    column
        .iter()
        .zip(load)
        .map(|(share, force)| share * force)
        .sum()
}
