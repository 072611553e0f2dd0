//! What a structure's connections fix once and for all: numbering, sparsity, symbolic factorisation.

use faer::Side;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SymbolicSparseColMat, SymbolicSparseColMatRef};

use super::structure::{Attachment, Freedom, Structure, StructureError};

/// Equation of a freedom that is held.
const HELD: usize = usize::MAX;

/// One contribution to a strain column: freedom `component` of end `end` (0, 1), or a hinge at that end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    Component { end: usize, component: usize },
    Hinge { end: usize, hinge: usize },
}

/// How one element meets the equations.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct ElementMap {
    /// Equations the element touches, ascending.
    pub(super) equations: Vec<usize>,
    /// Contributions: place in `equations`, and what is added to that strain column.
    pub(super) contributions: Vec<(usize, Source)>,
    /// Place in the matrix values of each pair (i, j) with i ≤ j, column by column.
    pub(super) slots: Vec<usize>,
    /// First strain column of this element among all.
    pub(super) first_column: usize,
}

/// Everything about a structure that does not change with its pose or its sections.
#[derive(Debug)]
pub(super) struct Topology {
    pub(super) node_count: usize,
    pub(super) hinge_count: usize,
    /// Equation of each freedom of each node, [`HELD`] if held.
    node_equations: Vec<[usize; 6]>,
    /// Equation of each hinge.
    pub(super) hinge_equations: Vec<usize>,
    pub(super) equation_count: usize,
    pub(super) elements: Vec<ElementMap>,
    pub(super) column_count: usize,
    /// Upper triangle, compressed by columns.
    pub(super) pattern: SymbolicSparseColMat<usize>,
    /// Place of each diagonal entry in the matrix values.
    pub(super) diagonal_slots: Vec<usize>,
    pub(super) symbolic: SymbolicCholesky<usize>,
    pub(super) end: Attachment,
}

impl Topology {
    /// Numbers the freedoms and factorises symbolically.
    ///
    /// Blocks (nodes and hinges) are ordered by minimum degree, the end's block last: what the loads touch is then eliminated
    /// last and the fill of these chain-like structures stays within a few blocks a column.
    pub(super) fn new(structure: &Structure) -> Result<Self, StructureError> {
        check_indices(structure)?;
        let node_count = structure.nodes.len();
        let mut held = vec![[false; 6]; node_count];
        for support in &structure.supports {
            for (flag, support_holds) in held[support.node].iter_mut().zip(support.held) {
                *flag |= support_holds;
            }
        }
        // A node that no element or load touches has nothing to say: its freedoms are left out, not reported as loose.
        let mut used = vec![false; node_count];
        for attachment in structure.elements.iter().flat_map(|e| &e.ends) {
            used[attachment.node] = true;
        }
        used[structure.end.node] = true;
        for (node, flags) in held.iter_mut().enumerate() {
            if !used[node] {
                *flags = [true; 6];
            }
        }

        let order = block_order(structure, node_count);
        let mut node_equations = vec![[HELD; 6]; node_count];
        let mut hinge_equations = vec![HELD; structure.hinges.len()];
        let mut equation_count = 0;
        for block in order {
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

        let mut elements: Vec<ElementMap> = structure
            .elements
            .iter()
            .map(|element| element_map(&element.ends, &node_equations, &hinge_equations))
            .collect();
        let mut column_count = 0;
        for map in &mut elements {
            map.first_column = column_count;
            column_count += map.equations.len();
        }

        let (pattern, diagonal_slots) = upper_pattern(equation_count, &mut elements);
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
            hinge_count: structure.hinges.len(),
            node_equations,
            hinge_equations,
            equation_count,
            elements,
            column_count,
            pattern,
            diagonal_slots,
            symbolic,
            end: structure.end.clone(),
        })
    }

    /// Equation of a freedom of a node, or `None` if it is held.
    pub(super) fn equation(&self, node: usize, component: usize) -> Option<usize> {
        let equation = self.node_equations[node][component];
        (equation != HELD).then_some(equation)
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
}

/// Refuses indices that point outside the structure.
fn check_indices(structure: &Structure) -> Result<(), StructureError> {
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
    for support in &structure.supports {
        check("a support", "node", support.node, nodes)?;
    }
    check_attachment("the end", &structure.end)
}

/// Blocks of a structure, nodes first and then hinges, in the order of elimination.
fn block_order(structure: &Structure, node_count: usize) -> Vec<usize> {
    let block_count = node_count + structure.hinges.len();
    let mut neighbours: Vec<Vec<usize>> = vec![Vec::new(); block_count];
    for element in &structure.elements {
        let blocks: Vec<usize> = element
            .ends
            .iter()
            .flat_map(|end| {
                std::iter::once(end.node).chain(end.hinges.iter().map(|hinge| node_count + hinge))
            })
            .collect();
        for &a in &blocks {
            neighbours[a].extend(blocks.iter().filter(|&&b| b != a));
        }
    }
    let mut column_starts = vec![0];
    let mut rows = Vec::new();
    for list in &mut neighbours {
        list.sort_unstable();
        list.dedup();
        rows.extend_from_slice(list);
        column_starts.push(rows.len());
    }
    let graph =
        SymbolicSparseColMatRef::new_checked(block_count, block_count, &column_starts, None, &rows);
    let mut order = vec![0; block_count];
    let mut inverse = vec![0; block_count];
    let mut memory = MemBuffer::new(StackReq::or(
        amd::order_scratch::<usize>(block_count, rows.len()),
        amd::order_maybe_unsorted_scratch::<usize>(block_count, rows.len()),
    ));
    amd::order_maybe_unsorted(
        &mut order,
        &mut inverse,
        graph,
        amd::Control::default(),
        MemStack::new(&mut memory),
    )
    .expect("a graph of a few dozen blocks can be ordered");
    let end = structure.end.node;
    order.retain(|&block| block != end);
    order.push(end);
    order
}

/// The equations an element touches and what each takes from its ends.
fn element_map(
    ends: &[Attachment; 2],
    node_equations: &[[usize; 6]],
    hinge_equations: &[usize],
) -> ElementMap {
    let mut touched: Vec<(usize, Source)> = Vec::new();
    for (end, attachment) in ends.iter().enumerate() {
        for (component, &equation) in node_equations[attachment.node].iter().enumerate() {
            if equation != HELD {
                touched.push((equation, Source::Component { end, component }));
            }
        }
        for &hinge in &attachment.hinges {
            touched.push((hinge_equations[hinge], Source::Hinge { end, hinge }));
        }
    }
    let mut equations: Vec<usize> = touched.iter().map(|(equation, _)| *equation).collect();
    equations.sort_unstable();
    equations.dedup();
    let contributions = touched
        .into_iter()
        .map(|(equation, source)| {
            let place = equations
                .binary_search(&equation)
                .expect("it was just put there");
            (place, source)
        })
        .collect();
    ElementMap {
        equations,
        contributions,
        ..ElementMap::default()
    }
}

/// Sparsity of the upper triangle; fills in the slots of every element and returns the place of each diagonal entry.
fn upper_pattern(
    equation_count: usize,
    elements: &mut [ElementMap],
) -> (SymbolicSparseColMat<usize>, Vec<usize>) {
    let mut columns: Vec<Vec<usize>> = (0..equation_count).map(|equation| vec![equation]).collect();
    for map in elements.iter() {
        for (j, &column) in map.equations.iter().enumerate() {
            columns[column].extend_from_slice(&map.equations[..j]);
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
        map.slots = (0..map.equations.len())
            .flat_map(|j| (0..=j).map(move |i| (i, j)))
            .map(|(i, j)| slot(map.equations[i], map.equations[j]))
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
