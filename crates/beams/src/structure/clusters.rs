//! What rigid members hold together, and how everything moves with independent freedoms: exact, without any stiffness in place of rigid.
//!
//! An attachment (a node, or what lies behind hinges at it) is a vertex. Rigid members join vertices to clusters, each of which moves as
//! one body; hinges stand between clusters. A cluster that hangs on another by hinges has no freedoms of its own: it moves with the
//! other and turns by the hinges between them, as the links of an arm do. So each vertex moves with the six freedoms of one node, its
//! root, and with the hinges on the way from there.
//!
//! Where hinges join two clusters that already have their ways, they close a loop: what lies behind them moves in two ways that must agree,
//! see [`closed_loops`](super::closed_loops).
//!
//! # Source
//! Master-slave elimination: Cook, Malkus, Plesha and Witt, Concepts and Applications of Finite Element Analysis (2002), section 13.2.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use stiffbench_numeric::vector::{cross, subtract};

use super::element::Attachment;
use super::parts::{Structure, StructureError, Support};

/// How the vertices of a structure move.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Clusters {
    /// The bare nodes in their order, then what lies behind hinges.
    pub(super) vertices: Vec<Attachment>,
    ways: Vec<Way>,
    /// Vertices behind hinges that close a loop of rigid members: they move with their cluster, and by those hinges too.
    pub(super) closures: Vec<usize>,
}

/// What a vertex moves with.
#[derive(Debug, Clone, PartialEq)]
struct Way {
    /// Node whose six freedoms it follows.
    root: usize,
    /// Hinges from there, each with its sense.
    hinges: Vec<(usize, f64)>,
}

/// An independent freedom.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum IndependentFreedom {
    /// Component 0 to 5 of a node.
    OfNode(usize, usize),
    /// Of a hinge.
    OfHinge(usize),
}

/// Displacement and rotation of a vertex per unit of a freedom.
pub(super) type VertexColumn = [f64; 6];

impl Clusters {
    /// # Errors
    /// [`StructureError::HeldRigidBody`].
    pub(super) fn new(structure: &Structure) -> Result<Self, StructureError> {
        let mut vertices: Vec<Attachment> = (0..structure.nodes.len()).map(Into::into).collect();
        let members = structure.rigid_members.iter();
        let ends = structure.elements.iter().map(|element| &element.ends);
        let ends = ends.chain(members.map(|member| &member.ends)).flatten();
        for end in ends.chain([&structure.end]) {
            if !end.hinges.is_empty() && !vertices[structure.nodes.len()..].contains(end) {
                vertices.push(end.clone());
            }
        }
        let classes = classes(structure, &vertices);
        let (ways, closures) = ClusterSearch::new(structure, &vertices, &classes)?.ways();
        Ok(Self {
            vertices,
            ways,
            closures,
        })
    }

    /// Number of an attachment; `None` if nothing of the structure hangs there.
    pub(super) fn vertex(&self, at: &Attachment) -> Option<usize> {
        if at.hinges.is_empty() {
            return Some(at.node);
        }
        self.vertices.iter().position(|known| known == at)
    }

    /// Whether a vertex moves with the freedoms of its own node and nothing else.
    pub(super) fn is_free_node(&self, vertex: usize) -> bool {
        let way = &self.ways[vertex];
        way.hinges.is_empty() && way.root == self.vertices[vertex].node
    }

    /// Whether every hinge on the way to a vertex is passed from its node to what lies behind it.
    pub(super) fn is_outward(&self, vertex: usize) -> bool {
        self.ways[vertex]
            .hinges
            .iter()
            .all(|(_, sense)| *sense > 0.0)
    }

    /// Node whose freedoms a vertex follows.
    pub(super) fn root(&self, vertex: usize) -> usize {
        self.ways[vertex].root
    }

    /// What a vertex moves with, in the order of its columns.
    pub(super) fn freedoms(&self, vertex: usize) -> impl Iterator<Item = IndependentFreedom> + '_ {
        let way = &self.ways[vertex];
        let of_node = (0..6).map(|component| IndependentFreedom::OfNode(way.root, component));
        let hinges = way.hinges.iter();
        of_node.chain(hinges.map(|&(hinge, _)| IndependentFreedom::OfHinge(hinge)))
    }

    /// How many columns of two vertices are the same motion of both: an element between them does not see it.
    pub(super) fn shared(&self, [first, second]: [usize; 2]) -> usize {
        let (first, second) = (&self.ways[first], &self.ways[second]);
        if first.root != second.root {
            return 0;
        }
        let pairs = first.hinges.iter().zip(&second.hinges);
        6 + pairs.take_while(|(a, b)| a == b).count()
    }

    /// Columns of a vertex where the structure stands.
    pub(super) fn columns(
        &self,
        structure: &Structure,
        vertex: usize,
    ) -> impl Iterator<Item = VertexColumn> {
        let way = &self.ways[vertex];
        let position = |node: usize| structure.nodes[node].position_m;
        let at_m = position(self.vertices[vertex].node);
        let about = move |axis: [f64; 3], node: usize, sense: f64| {
            let moved = cross(axis, subtract(at_m, position(node)));
            [moved[0], moved[1], moved[2], axis[0], axis[1], axis[2]].map(|entry| sense * entry)
        };
        let of_node = move |component: usize| {
            let mut unit = [0.0; 6];
            unit[component] = 1.0;
            if component < 3 {
                return unit;
            }
            about([unit[3], unit[4], unit[5]], way.root, 1.0)
        };
        let of_hinge = move |&(hinge, sense): &(usize, f64)| {
            let own = &structure.hinges[hinge];
            if own.slides {
                let [x, y, z] = own.axis.map(|entry| sense * entry);
                return [x, y, z, 0.0, 0.0, 0.0];
            }
            // A hinge on the way has something behind it.
            let node = structure.node_of_hinge(hinge).unwrap_or(way.root);
            about(own.axis, node, sense)
        };
        (0..6).map(of_node).chain(way.hinges.iter().map(of_hinge))
    }
}

impl Clusters {
    /// The six conditions of a loop: what a unit of each freedom moves the two sides of its closing hinges against each other.
    ///
    /// # Arguments
    /// - `vertex`: one of [`Clusters::closures`].
    pub(super) fn conditions(
        &self,
        structure: &Structure,
        vertex: usize,
    ) -> Vec<(IndependentFreedom, VertexColumn)> {
        let at = &self.vertices[vertex];
        let near = self.freedoms(at.node).zip(self.columns(structure, at.node));
        let closing = at.hinges.iter().map(|&hinge| {
            let own = &structure.hinges[hinge];
            let [x, y, z] = own.axis;
            let motion = if own.slides {
                [x, y, z, 0.0, 0.0, 0.0]
            } else {
                [0.0, 0.0, 0.0, x, y, z]
            };
            (IndependentFreedom::OfHinge(hinge), motion)
        });
        let far = self.freedoms(vertex).zip(self.columns(structure, vertex));
        let back = far.map(|(freedom, column)| (freedom, column.map(|entry| -entry)));
        near.chain(closing).chain(back).collect()
    }
}

/// The cluster of each vertex, by the smallest of its vertices.
fn classes(structure: &Structure, vertices: &[Attachment]) -> Vec<usize> {
    let mut classes: Vec<usize> = (0..vertices.len()).collect();
    let place = |at: &Attachment| vertices.iter().position(|known| known == at);
    for member in &structure.rigid_members {
        let [first, second] = [0, 1].map(|end: usize| place(&member.ends[end]).unwrap_or(0));
        let (first, second) = (classes[first], classes[second]);
        let (keeps, goes) = (first.min(second), first.max(second));
        for class in classes.iter_mut().filter(|class| **class == goes) {
            *class = keeps;
        }
    }
    classes
}

/// Search for the way of each cluster, from what is held.
struct ClusterSearch<'a> {
    structure: &'a Structure,
    vertices: &'a [Attachment],
    classes: &'a [usize],
    /// Vertices behind hinges that lead from or to a cluster.
    behind: BTreeMap<usize, Vec<usize>>,
    /// Held node of a cluster that has one.
    held: BTreeMap<usize, usize>,
    found: BTreeMap<usize, Way>,
    closures: Vec<usize>,
}

impl<'a> ClusterSearch<'a> {
    fn new(
        structure: &'a Structure,
        vertices: &'a [Attachment],
        classes: &'a [usize],
    ) -> Result<Self, StructureError> {
        let mut behind: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (vertex, at) in vertices.iter().enumerate().skip(structure.nodes.len()) {
            for class in [classes[at.node], classes[vertex]] {
                behind.entry(class).or_default().push(vertex);
            }
        }
        // A node held in full first: what is held in part beside it does not matter.
        let whole = |support: &&Support| support.held == [true; 6];
        let supports = structure.supports.iter();
        let partly = supports.clone().filter(|support| !whole(support));
        let mut held: BTreeMap<usize, usize> = BTreeMap::new();
        for support in supports.filter(whole) {
            held.entry(classes[support.node]).or_insert(support.node);
        }
        let fully = held.clone();
        for support in partly {
            let class = classes[support.node];
            let other = held.insert(class, support.node);
            if let Some(&held_node) = fully.get(&class) {
                held.insert(class, held_node);
            } else if other.is_some_and(|other| other != support.node) {
                return Err(StructureError::HeldRigidBody {
                    node: structure.nodes[support.node].name.clone(),
                });
            }
        }
        Ok(Self {
            structure,
            vertices,
            classes,
            behind,
            held,
            found: BTreeMap::new(),
            closures: Vec::new(),
        })
    }

    /// The way of each vertex, and the vertices that close loops.
    fn ways(mut self) -> (Vec<Way>, Vec<usize>) {
        let root = |root: usize| Way {
            root,
            hinges: Vec::new(),
        };
        let held: Vec<usize> = self.held.keys().copied().collect();
        for (&class, &node) in &self.held {
            self.found.insert(class, root(node));
        }
        self.follow(held);
        for node in 0..self.structure.nodes.len() {
            let class = self.classes[node];
            if let Entry::Vacant(unknown) = self.found.entry(class) {
                unknown.insert(root(node));
                self.follow(vec![class]);
            }
        }
        let ways = self.classes.iter().map(|class| self.found[class].clone());
        (ways.collect(), self.closures)
    }

    /// Finds what hangs on clusters by hinges.
    fn follow(&mut self, mut waiting: Vec<usize>) {
        while let Some(class) = waiting.pop() {
            for vertex in self.behind.remove(&class).unwrap_or_default() {
                let at = &self.vertices[vertex];
                let (near, far) = (self.classes[at.node], self.classes[vertex]);
                let (other, sense) = if near == class {
                    (far, 1.0)
                } else {
                    (near, -1.0)
                };
                // Each hinge is met from both sides.
                if let Some(seen) = self.behind.get_mut(&other) {
                    seen.retain(|known| *known != vertex);
                }
                if other == class || self.found.contains_key(&other) {
                    if !self.closures.contains(&vertex) {
                        self.closures.push(vertex);
                    }
                    continue;
                }
                let mut way = self.found[&class].clone();
                let hinges = at.hinges.iter().map(|&hinge| (hinge, sense));
                if sense > 0.0 {
                    way.hinges.extend(hinges);
                } else {
                    way.hinges.extend(hinges.rev());
                }
                self.found.insert(other, way);
                waiting.push(other);
            }
        }
    }
}
