//! What a structure's connections fix once and for all: numbering, sparsity, symbolic factorisation.

use std::collections::BTreeSet;

use faer::Side;
use faer::sparse::SymbolicSparseColMat;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};

use super::clusters::{Clusters, IndependentFreedom};
use super::element::Attachment;
use super::ordering::{Eliminated, minimum_degree_before};
use super::parts::{Freedom, Structure, StructureError, Strut};
use super::struts::strut_columns;

/// Equation of a freedom that is held.
pub(super) const HELD: usize = usize::MAX;

/// How one element meets the equations.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct ElementMap {
    /// Equation of each freedom, [`HELD`] if held.
    pub(super) equations: Vec<usize>,
    /// The end (0 or 1) that each freedom moves and its column there; none if the freedoms are the twelve of the two nodes.
    pub(super) columns: Vec<(usize, usize)>,
    /// Vertices of the two ends.
    pub(super) vertices: [usize; 2],
    /// Free pairs of freedoms and their place in the matrix values.
    pub(super) slots: Vec<MatrixSlot>,
}

/// Where entry (row, column) of an element's matrix goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct MatrixSlot {
    pub(super) row: u8,
    pub(super) column: u8,
    pub(super) value: u32,
}

/// Everything about a structure that does not change with its pose or its sections.
#[derive(Debug)]
pub(super) struct Topology {
    pub(super) node_count: usize,
    /// Equation of each freedom of each node, [`HELD`] if held.
    node_equations: Vec<[usize; 6]>,
    /// Equation of each hinge.
    pub(super) hinge_equations: Vec<usize>,
    pub(super) equation_count: usize,
    pub(super) elements: Vec<ElementMap>,
    pub(super) struts: Vec<ElementMap>,
    /// Upper triangle, compressed by columns.
    pub(super) pattern: SymbolicSparseColMat<usize>,
    /// Place of each diagonal entry in the matrix values.
    pub(super) diagonal_slots: Vec<usize>,
    pub(super) symbolic: SymbolicCholesky<usize>,
    pub(super) clusters: Clusters,
    /// Equation of each column of each vertex, [`HELD`] if held.
    pub(super) vertex_equations: Vec<Vec<usize>>,
    /// Vertex of the end.
    pub(super) end: usize,
}

impl Topology {
    /// Numbers the freedoms and factorises symbolically.
    ///
    /// Blocks (nodes and hinges) are ordered by minimum degree, the end's block last.
    pub(super) fn new(structure: &Structure) -> Result<Self, StructureError> {
        check_indices(structure)?;
        let node_count = structure.nodes.len();
        let held = held_freedoms(structure);
        let clusters = Clusters::new(structure)?;
        let vertex = |at: &Attachment| {
            let known = clusters.vertex(at);
            known.expect("the clusters hold every attachment of the structure")
        };
        let order = block_order(structure, &clusters, &held);
        let mut node_equations = vec![[HELD; 6]; node_count];
        let mut hinge_equations = vec![HELD; structure.hinges.len()];
        let mut equation_count = 0;
        for Eliminated { block, .. } in order {
            if block < node_count {
                for (component, equation) in node_equations[block].iter_mut().enumerate() {
                    if !held[block][component] {
                        *equation = equation_count;
                        equation_count += 1;
                    }
                }
            } else {
                hinge_equations[block - node_count] = equation_count;
                equation_count += 1;
            }
        }

        let equation =
            |freedom: IndependentFreedom| equation_of(freedom, &node_equations, &hinge_equations);
        let vertices = 0..clusters.vertices.len();
        let vertex_equations: Vec<Vec<usize>> = vertices
            .map(|vertex| clusters.freedoms(vertex).map(equation).collect())
            .collect();
        let mut elements: Vec<ElementMap> = structure
            .elements
            .iter()
            .map(|element| {
                let ends = [vertex(&element.ends[0]), vertex(&element.ends[1])];
                element_map(ends, &clusters, &vertex_equations)
            })
            .collect();
        let mut struts: Vec<ElementMap> = structure
            .struts
            .iter()
            .map(|strut| strut_map(strut, &clusters, equation))
            .collect();
        let mut maps: Vec<&mut ElementMap> = elements.iter_mut().chain(&mut struts).collect();
        let (pattern, diagonal_slots) = upper_pattern(equation_count, &mut maps);
        let symbolic = factorize_symbolic_cholesky(
            pattern.as_ref(),
            Side::Upper,
            SymmetricOrdering::Identity,
            CholeskySymbolicParams {
                supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SIMPLICIAL,
                ..CholeskySymbolicParams::default()
            },
        )
        .expect("a structure of a few hundred equations fits in memory");
        Ok(Self {
            node_count,
            node_equations,
            hinge_equations,
            equation_count,
            elements,
            struts,
            pattern,
            diagonal_slots,
            symbolic,
            end: vertex(&structure.end),
            vertex_equations,
            clusters,
        })
    }

    /// The equation of a freedom, [`HELD`] if held.
    pub(super) fn equation(&self, freedom: IndependentFreedom) -> usize {
        equation_of(freedom, &self.node_equations, &self.hinge_equations)
    }

    /// The freedom behind an equation.
    pub(super) fn freedom(&self, equation: usize, structure: &Structure) -> Freedom {
        for (node, equations) in self.node_equations.iter().enumerate() {
            if let Some(component) = equations.iter().position(|e| *e == equation) {
                return Freedom::OfNode {
                    node: structure.nodes[node].name.clone(),
                    component,
                };
            }
        }
        let hinge = self
            .hinge_equations
            .iter()
            .position(|e| *e == equation)
            .expect("every equation belongs to a node or a hinge");
        Freedom::OfHinge {
            hinge: structure.hinges[hinge].name.clone(),
        }
    }

    /// The equation that moves most in the softest motion of the matrix scaled to a unit diagonal.
    ///
    /// Only called when a factorisation failed, so a dense eigenvalue problem is fast enough.
    pub(super) fn loosest_equation(&self, values: &[f64]) -> usize {
        let n = self.equation_count;
        let diagonal: Vec<f64> = self
            .diagonal_slots
            .iter()
            .map(|&slot| values[slot])
            .collect();
        if let Some(free) = diagonal.iter().position(|d| *d <= 0.0 || !d.is_finite()) {
            return free;
        }
        let mut dense = faer::Mat::<f64>::zeros(n, n);
        let starts = self.pattern.col_ptr();
        for column in 0..n {
            for slot in starts[column]..starts[column + 1] {
                let row = self.pattern.row_idx()[slot];
                let scaled = values[slot] / (diagonal[row] * diagonal[column]).sqrt();
                dense[(row, column)] = scaled;
                dense[(column, row)] = scaled;
            }
        }
        let largest = |column: &dyn Fn(usize) -> f64| {
            (0..n)
                .max_by(|a, b| column(*a).abs().total_cmp(&column(*b).abs()))
                .unwrap_or(0)
        };
        match dense.self_adjoint_eigen(Side::Lower) {
            // Eigenvalues ascend: the first vector is the softest motion.
            Ok(eigen) => largest(&|i| eigen.U()[(i, 0)]),
            Err(_) => largest(&|i| -diagonal[i]),
        }
    }
}

fn equation_of(freedom: IndependentFreedom, of_nodes: &[[usize; 6]], of_hinges: &[usize]) -> usize {
    match freedom {
        IndependentFreedom::OfNode(node, component) => of_nodes[node][component],
        IndependentFreedom::OfHinge(hinge) => of_hinges[hinge],
    }
}

/// Refuses indices that point outside the structure.
pub(super) fn check_indices(structure: &Structure) -> Result<(), StructureError> {
    let check = |what, kind, index, count| {
        if index < count {
            Ok(())
        } else {
            Err(StructureError::UnknownIndex {
                what,
                kind,
                index,
                count,
            })
        }
    };
    let nodes = structure.nodes.len();
    let check_attachment = |what, attachment: &Attachment| {
        check(what, "node", attachment.node, nodes)?;
        attachment
            .hinges
            .iter()
            .try_for_each(|&hinge| check(what, "hinge", hinge, structure.hinges.len()))
    };
    for element in &structure.elements {
        for end in &element.ends {
            check_attachment("an element", end)?;
        }
    }
    for end in structure
        .rigid_members
        .iter()
        .flat_map(|member| &member.ends)
    {
        check_attachment("a rigid member", end)?;
    }
    for support in &structure.supports {
        check("a support", "node", support.node, nodes)?;
    }
    check_attachment("the end", &structure.end)
}

/// Blocks of a structure, nodes first and then hinges, in the order of elimination.
///
/// Nodes without a free freedom, and those that move with another node, take no part.
fn block_order(structure: &Structure, clusters: &Clusters, held: &[[bool; 6]]) -> Vec<Eliminated> {
    let node_count = held.len();
    let block_count = node_count + structure.hinges.len();
    let mut neighbours = vec![BTreeSet::new(); block_count];
    let elements = structure.elements.iter().map(|element| &element.ends);
    let elements = elements.map(|ends| ends.iter().collect::<Vec<_>>());
    let struts = structure.struts.iter();
    let struts = struts.map(|strut| strut.ends.iter().flatten().collect());
    for ends in elements.chain(struts) {
        let blocks: Vec<usize> = ends
            .into_iter()
            .filter_map(|end| clusters.vertex(end))
            .flat_map(|vertex| {
                let freedoms = clusters.freedoms(vertex);
                freedoms.filter_map(|freedom| match freedom {
                    IndependentFreedom::OfNode(node, 0) => Some(node),
                    IndependentFreedom::OfNode(..) => None,
                    IndependentFreedom::OfHinge(hinge) => Some(node_count + hinge),
                })
            })
            .collect();
        for &a in &blocks {
            neighbours[a].extend(&blocks);
        }
    }
    let mut present = vec![true; block_count];
    for (node, (present, held)) in present.iter_mut().zip(held).enumerate() {
        *present = *held != [true; 6] && clusters.root(node) == node;
    }
    let end = clusters.vertex(&structure.end);
    let last = end.map(|vertex| clusters.root(vertex));
    minimum_degree_before(neighbours, &present, last.as_slice())
}

/// Which freedoms of each node are held, by a support or because nothing is there to move them.
pub(super) fn held_freedoms(structure: &Structure) -> Vec<[bool; 6]> {
    let mut held = vec![[false; 6]; structure.nodes.len()];
    for support in &structure.supports {
        for (flag, support_holds) in held[support.node].iter_mut().zip(support.held) {
            *flag |= support_holds;
        }
    }
    // A node without element and load does not matter: its freedoms are left out, not reported as loose.
    let mut used = vec![false; structure.nodes.len()];
    let rigid = structure
        .rigid_members
        .iter()
        .flat_map(|member| &member.ends);
    for attachment in structure.elements.iter().flat_map(|e| &e.ends).chain(rigid) {
        used[attachment.node] = true;
    }
    used[structure.end.node] = true;
    for (flags, used) in held.iter_mut().zip(used) {
        if !used {
            *flags = [true; 6];
        }
    }
    held
}

/// Equations of the freedoms of an element.
fn element_map(
    vertices: [usize; 2],
    clusters: &Clusters,
    vertex_equations: &[Vec<usize>],
) -> ElementMap {
    let plain = vertices.iter().all(|&vertex| clusters.is_free_node(vertex));
    let shared = clusters.shared(vertices);
    let mut map = ElementMap {
        vertices,
        ..ElementMap::default()
    };
    for (end, vertex) in vertices.into_iter().enumerate() {
        let all = vertex_equations[vertex].iter().enumerate();
        for (column, &equation) in all {
            if plain {
                map.equations.push(equation);
            } else if column >= shared && equation != HELD {
                map.equations.push(equation);
                map.columns.push((end, column));
            }
        }
    }
    map
}

/// Equations of the freedoms of a strut.
fn strut_map(
    strut: &Strut,
    clusters: &Clusters,
    equation: impl Fn(IndependentFreedom) -> usize,
) -> ElementMap {
    let mut map = ElementMap::default();
    let columns = strut_columns(clusters, &strut.ends);
    let freedoms = strut.freedoms(clusters, &columns);
    for (column, equation) in columns.into_iter().zip(freedoms.into_iter().map(equation)) {
        if equation != HELD {
            map.equations.push(equation);
            map.columns.push(column);
        }
    }
    map
}

/// Sparsity of the upper triangle; fills in the slots of every element and returns the place of each diagonal entry.
fn upper_pattern(
    equation_count: usize,
    elements: &mut [&mut ElementMap],
) -> (SymbolicSparseColMat<usize>, Vec<usize>) {
    let mut columns: Vec<Vec<usize>> = (0..equation_count).map(|equation| vec![equation]).collect();
    let free = |map: &ElementMap| -> Vec<(u8, usize)> {
        (0..)
            .zip(map.equations.iter().copied())
            .filter(|(_, equation)| *equation != HELD)
            .collect()
    };
    for map in elements.iter() {
        let free = free(map);
        for &(_, column) in &free {
            columns[column].extend(free.iter().map(|(_, row)| *row).filter(|row| *row < column));
        }
    }
    let mut column_starts = vec![0];
    let mut rows = Vec::new();
    for column in &mut columns {
        column.sort_unstable();
        column.dedup();
        rows.extend_from_slice(column);
        column_starts.push(rows.len());
    }
    let slot = |row: usize, column: usize| {
        column_starts[column]
            + columns[column]
                .binary_search(&row)
                .expect("the pattern holds every pair")
    };
    for map in elements {
        let free = free(map);
        // Every ordered pair whose equations lie in the upper triangle; two freedoms with one equation both count.
        map.slots = free
            .iter()
            .flat_map(|&column| free.iter().map(move |&row| (row, column)))
            .filter(|((_, row), (_, column))| row <= column)
            .map(|((i, row), (j, column))| MatrixSlot {
                row: i,
                column: j,
                value: slot(row, column) as u32,
            })
            .collect();
    }
    let diagonal_slots = (0..equation_count)
        .map(|equation| slot(equation, equation))
        .collect();
    let pattern = SymbolicSparseColMat::new_checked(
        equation_count,
        equation_count,
        column_starts,
        None,
        rows,
    );
    (pattern, diagonal_slots)
}
