//! What the connections of a structure fix for all poses: order of elimination, places of the blocks, and who updates whom.

use std::collections::{BTreeMap, BTreeSet};

use crate::structure::ordering::minimum_degree_before;
use crate::structure::parts::Structure;
use crate::structure::topology::held_freedoms;

/// Motion in the plane of the frame: up, uq, rn.
pub(super) const IN_PLANE: usize = 0;

/// Motion across that plane: un, rp, rq.
pub(super) const ACROSS: usize = 1;

/// Block LDLᵀ of a structure whose nodes are wholly free or wholly held, two blocks of three freedoms a free node.
///
/// Blocks on the diagonal ("columns") are numbered by order of elimination: last comes the end's motion in the plane, before it
/// that across. The other blocks ("panels") are numbered by the column whose elimination uses them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Plan {
    pub(super) columns: Vec<Column>,
    pub(super) panel_count: usize,
    /// Where the blocks of each element go.
    pub(super) elements: Vec<ElementPlaces>,
}

/// Half the motion of a free node, at its turn.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Column {
    /// Number of its first panel; the others follow.
    pub(super) first_panel: usize,
    /// For each panel the column it couples to, ascending.
    pub(super) neighbours: Vec<usize>,
    /// What its elimination changes.
    pub(super) updates: Vec<Update>,
}

/// Block `target` loses the product of two panels of the column being eliminated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Update {
    /// Panels, counted from the column's first: rows and columns of the target.
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) target: Target,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Target {
    Diagonal(usize),
    Panel(usize),
}

/// A panel, and whether its rows belong to the second of the two blocks it was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PanelPlace {
    pub(super) panel: usize,
    pub(super) transposed: bool,
}

/// Where an element's blocks go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ElementPlaces {
    /// Its nodes in the structure.
    pub(super) nodes: [usize; 2],
    /// Whether it lies in the plane of the frame, so that it does not couple the two halves of the motion.
    pub(super) in_plane: bool,
    /// Columns of each end, [`IN_PLANE`] and [`ACROSS`]; `None` for a held one.
    pub(super) ends: [Option<[usize; 2]>; 2],
    /// Between the halves of each end, for elements out of the plane.
    pub(super) within: [Option<PanelPlace>; 2],
    /// Between a half of the first end and a half of the second.
    pub(super) between: Option<[[Option<PanelPlace>; 2]; 2]>,
}

/// Whether a structure is one that block elimination serves: elements but no hinge, no node held in part, a free end, no element
/// from a node to itself.
pub(super) fn serves(structure: &Structure) -> bool {
    let held = held_freedoms(structure);
    !structure.elements.is_empty()
        && structure.hinges.is_empty()
        && held
            .iter()
            .all(|flags| *flags == [true; 6] || *flags == [false; 6])
        && held[structure.end.node] == [false; 6]
        && structure
            .elements
            .iter()
            .all(|element| element.ends[0].node != element.ends[1].node)
}

impl Plan {
    /// Orders a structure that [`serves`]; `in_plane` tells which elements lie in the plane of the frame.
    pub(super) fn of(structure: &Structure, in_plane: &[bool]) -> Self {
        let held = held_freedoms(structure);
        let half = |node: usize, half: usize| 2 * node + half;
        let mut coupled = vec![BTreeSet::new(); 2 * held.len()];
        for (element, &in_plane) in structure.elements.iter().zip(in_plane) {
            let nodes = [element.ends[0].node, element.ends[1].node];
            for (a, b) in pairs(nodes.map(|node| [half(node, 0), half(node, 1)]), in_plane) {
                coupled[a].insert(b);
                coupled[b].insert(a);
            }
        }
        let present: Vec<bool> = (0..2 * held.len())
            .map(|block| held[block / 2] == [false; 6])
            .collect();
        let end = structure.end.node;
        let order =
            minimum_degree_before(coupled, &present, &[half(end, ACROSS), half(end, IN_PLANE)]);

        let mut column_of = vec![None; present.len()];
        for (column, eliminated) in order.iter().enumerate() {
            column_of[eliminated.block] = Some(column);
        }
        let mut panels = Panels::default();
        let mut columns: Vec<Column> = Vec::with_capacity(order.len());
        for (column, eliminated) in order.iter().enumerate() {
            let later = eliminated.neighbours.iter();
            let mut neighbours: Vec<usize> = later.filter_map(|&block| column_of[block]).collect();
            neighbours.sort_unstable();
            let first_panel = panels.0.len();
            for &neighbour in &neighbours {
                let number = panels.0.len();
                panels.0.insert((column, neighbour), number);
            }
            columns.push(Column {
                first_panel,
                neighbours,
                updates: Vec::new(),
            });
        }
        for column in &mut columns {
            column.updates = panels.updates(&column.neighbours);
        }
        let elements = structure.elements.iter().zip(in_plane);
        let elements = elements.map(|(element, &in_plane)| {
            let nodes = [element.ends[0].node, element.ends[1].node];
            let ends =
                nodes.map(|node| Some([column_of[half(node, 0)]?, column_of[half(node, 1)]?]));
            panels.places(nodes, ends, in_plane)
        });
        Self {
            elements: elements.collect(),
            panel_count: panels.0.len(),
            columns,
        }
    }

    /// Most panels in a column.
    pub(super) fn widest(&self) -> usize {
        let widths = self.columns.iter().map(|column| column.neighbours.len());
        widths.max().unwrap_or(0)
    }
}

/// Pairs of blocks that an element couples, from the halves of its two ends.
fn pairs(ends: [[usize; 2]; 2], in_plane: bool) -> Vec<(usize, usize)> {
    let [[a, b], [c, d]] = ends;
    if in_plane {
        vec![(a, c), (b, d)]
    } else {
        vec![(a, b), (c, d), (a, c), (a, d), (b, c), (b, d)]
    }
}

/// Number of each panel by its two columns, the earlier first.
#[derive(Debug, Default)]
struct Panels(BTreeMap<(usize, usize), usize>);

impl Panels {
    fn place(&self, rows: usize, columns: usize) -> Option<PanelPlace> {
        let pair = (rows.min(columns), rows.max(columns));
        Some(PanelPlace {
            panel: *self.0.get(&pair)?,
            transposed: columns < rows,
        })
    }

    /// What the elimination of a column with these neighbours changes: every pair of them.
    fn updates(&self, neighbours: &[usize]) -> Vec<Update> {
        let mut updates = Vec::new();
        for (rows, &first) in neighbours.iter().enumerate() {
            for (columns, &second) in neighbours.iter().enumerate().skip(rows) {
                let target = if rows == columns {
                    Target::Diagonal(first)
                } else {
                    Target::Panel(self.0[&(first, second)])
                };
                updates.push(Update {
                    rows,
                    columns,
                    target,
                });
            }
        }
        updates
    }

    fn places(
        &self,
        nodes: [usize; 2],
        ends: [Option<[usize; 2]>; 2],
        in_plane: bool,
    ) -> ElementPlaces {
        let within = ends.map(|end| {
            let [a, b] = end.filter(|_| !in_plane)?;
            self.place(a, b)
        });
        let between = match ends {
            [Some(first), Some(second)] => Some([0, 1].map(|i| {
                [0, 1].map(|j| {
                    if in_plane && i != j {
                        None
                    } else {
                        self.place(first[i], second[j])
                    }
                })
            })),
            _ => None,
        };
        ElementPlaces {
            nodes,
            in_plane,
            ends,
            within,
            between,
        }
    }
}
