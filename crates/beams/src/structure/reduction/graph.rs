//! Which elements and hinges lie between the ground and the end, and at which nodes that way hangs on a single node.

use std::collections::BTreeMap;

use super::schedule::SchedulePiece;
use crate::structure::element::Attachment;
use crate::structure::parts::Structure;
use crate::structure::topology::held_freedoms;

/// The ground, to which all held nodes belong; free nodes follow from 1, then what lies behind each hinge.
pub(super) const GROUND: usize = 0;

/// A stretch of the way from the ground to the end: all its pieces hang on the rest by its two terminals alone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Segment {
    /// Vertex towards the ground, and vertex towards the end.
    pub(super) terminals: [usize; 2],
    /// Pieces that carry load, with their vertices.
    pub(super) edges: Vec<Edge>,
}

impl Segment {
    pub(super) fn has_elements(&self) -> bool {
        let mut edges = self.edges.iter();
        edges.any(|edge| matches!(edge.piece, SchedulePiece::Element(_)))
    }

    /// The hinge that it consists of, if it is one.
    pub(super) fn hinge(&self) -> Option<usize> {
        match self.edges[..] {
            [
                Edge {
                    piece: SchedulePiece::Hinge(hinge),
                    ..
                },
            ] => Some(hinge),
            _ => None,
        }
    }
}

/// A piece and its two vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Edge {
    pub(super) piece: SchedulePiece,
    pub(super) ends: [usize; 2],
}

/// Vertices of a structure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Graph {
    vertex_count: usize,
    edges: Vec<Edge>,
    end: usize,
    /// Node of each vertex but the ground.
    nodes: Vec<usize>,
}

impl Graph {
    /// The graph of a structure; `None` if a hinge stands behind different others in different places, or the structure has a node held
    /// in part, a held end, an element from a node to itself, or something that hangs on no support: those are for
    /// [`Solver`](crate::structure::Solver).
    ///
    /// What rigid members join is one vertex: all motions are referred to a common point, where they are the same.
    pub(super) fn of(structure: &Structure) -> Option<Self> {
        let held = held_freedoms(structure);
        let whole = held.iter().all(|h| *h == [true; 6] || *h == [false; 6]);
        if !whole {
            return None;
        }
        let mut vertices = Vertices::of(structure, &held)?;
        for member in &structure.rigid_members {
            vertices.join([0, 1].map(|end: usize| vertices.number(&member.ends[end])));
        }
        let numbers = vertices.compact();
        let vertex = |at: &Attachment| numbers[vertices.number(at)];
        let mut edges = Vec::new();
        for (element, parts) in structure.elements.iter().enumerate() {
            if parts.ends[0].node == parts.ends[1].node {
                return None;
            }
            let ends = [vertex(&parts.ends[0]), vertex(&parts.ends[1])];
            if ends[0] != ends[1] {
                let piece = SchedulePiece::Element(element);
                edges.push(Edge { piece, ends });
            }
        }
        for &(hinge, ends) in &vertices.hinges {
            let ends = ends.map(|end| numbers[end]);
            // A hinge between points of one rigid body does not move.
            if ends[0] != ends[1] {
                let piece = SchedulePiece::Hinge(hinge);
                edges.push(Edge { piece, ends });
            }
        }
        let vertex_count = numbers.iter().max().map_or(0, |most| most + 1);
        let node = |wanted: usize| {
            let place = numbers.iter().position(|number| *number == wanted);
            place.map_or(0, |place| vertices.nodes[place])
        };
        let graph = Self {
            vertex_count,
            edges,
            end: vertex(&structure.end),
            nodes: (1..vertex_count).map(node).collect(),
        };
        let all_hang_on_the_ground = !graph.reached(&[GROUND], None).contains(&false);
        (all_hang_on_the_ground && graph.end != GROUND).then_some(graph)
    }

    /// Node of a vertex; `None` for the ground.
    pub(super) fn node(&self, vertex: usize) -> Option<usize> {
        Some(self.nodes[vertex.checked_sub(1)?])
    }

    /// Vertices that can be reached from some without passing another.
    fn reached(&self, from: &[usize], without: Option<usize>) -> Vec<bool> {
        let mut reached = vec![false; self.vertex_count];
        let mut around = vec![Vec::new(); self.vertex_count];
        for Edge { ends: [a, b], .. } in &self.edges {
            around[*a].push(*b);
            around[*b].push(*a);
        }
        let mut waiting: Vec<usize> = from.to_vec();
        while let Some(vertex) = waiting.pop() {
            if Some(vertex) != without && !reached[vertex] {
                reached[vertex] = true;
                waiting.extend(&around[vertex]);
            }
        }
        reached
    }

    /// The way from the ground to the end in as many stretches as it has nodes that every path passes.
    ///
    /// Elements that hang on the way by one node carry nothing, whatever the load on the end: they are in no segment.
    pub(super) fn segments(&self) -> Vec<Segment> {
        // What the ground reaches without a node that every path passes, smallest first: that is their order on the way.
        let mut passed: Vec<(usize, Vec<bool>)> = (1..self.vertex_count)
            .map(|vertex| (vertex, self.reached(&[GROUND], Some(vertex))))
            .filter(|(_, reached)| !reached[self.end])
            .collect();
        passed.sort_by_key(|(_, reached)| reached.iter().filter(|r| **r).count());
        let mut near = GROUND;
        let mut before = vec![false; self.vertex_count];
        let mut segments = Vec::new();
        for (far, reached) in passed {
            let inside = |vertex: usize| {
                vertex == near || vertex == far || (reached[vertex] && !before[vertex])
            };
            let carries = self.between(near, far, &inside);
            let edges = self.edges.iter().copied();
            segments.push(Segment {
                terminals: [near, far],
                edges: edges
                    .filter(|edge| edge.ends.iter().all(|&v| inside(v) && carries[v]))
                    .filter(|edge| edge.ends != [GROUND; 2])
                    .collect(),
            });
            (near, before) = (far, reached);
        }
        segments
    }

    /// Vertices that lie on a path from one terminal to the other.
    fn between(&self, near: usize, far: usize, inside: &dyn Fn(usize) -> bool) -> Vec<bool> {
        let mut carries: Vec<bool> = (0..self.vertex_count).map(inside).collect();
        for vertex in (0..self.vertex_count).filter(|&vertex| inside(vertex)) {
            // What neither terminal reaches without it hangs on it.
            let from: Vec<usize> = [near, far].into_iter().filter(|&t| t != vertex).collect();
            let reached = self.reached(&from, Some(vertex));
            for other in 0..self.vertex_count {
                carries[other] &= reached[other] || other == vertex;
            }
        }
        carries
    }
}

/// The ground, free nodes and what lies behind hinges, before rigid members join them.
struct Vertices {
    /// Node of each.
    nodes: Vec<usize>,
    /// Vertex of each bare node.
    of_nodes: Vec<usize>,
    /// Vertex behind hinges passed at a node.
    behind: BTreeMap<(usize, Vec<usize>), usize>,
    /// Each hinge with the vertices on its two sides.
    hinges: Vec<(usize, [usize; 2])>,
    /// A vertex of the same cluster, the ground or the smallest.
    cluster: Vec<usize>,
}

impl Vertices {
    /// `None` if a hinge stands behind different others in different places.
    fn of(structure: &Structure, held: &[[bool; 6]]) -> Option<Self> {
        let mut vertices = Self {
            nodes: vec![0],
            of_nodes: Vec::with_capacity(held.len()),
            behind: BTreeMap::new(),
            hinges: Vec::new(),
            cluster: Vec::new(),
        };
        for (node, held) in held.iter().enumerate() {
            if held[0] {
                vertices.of_nodes.push(GROUND);
            } else {
                vertices.of_nodes.push(vertices.nodes.len());
                vertices.nodes.push(node);
            }
        }
        let elements = structure.elements.iter().flat_map(|element| &element.ends);
        let rigid = structure
            .rigid_members
            .iter()
            .flat_map(|member| &member.ends);
        for at in elements.chain(rigid).chain([&structure.end]) {
            for count in 1..=at.hinges.len() {
                let key = (at.node, at.hinges[..count].to_vec());
                if vertices.behind.contains_key(&key) {
                    continue;
                }
                let hinge = at.hinges[count - 1];
                if vertices.hinges.iter().any(|(known, _)| *known == hinge) {
                    return None;
                }
                let before = vertices.passed(at.node, &at.hinges[..count - 1]);
                let vertex = vertices.nodes.len();
                vertices.nodes.push(at.node);
                vertices.hinges.push((hinge, [before, vertex]));
                vertices.behind.insert(key, vertex);
            }
        }
        // A hinge with nothing behind it.
        if vertices.hinges.len() < structure.hinges.len() {
            return None;
        }
        vertices.cluster = (0..vertices.nodes.len()).collect();
        Some(vertices)
    }

    fn passed(&self, node: usize, hinges: &[usize]) -> usize {
        if hinges.is_empty() {
            return self.of_nodes[node];
        }
        self.behind[&(node, hinges.to_vec())]
    }

    fn number(&self, at: &Attachment) -> usize {
        self.passed(at.node, &at.hinges)
    }

    fn join(&mut self, ends: [usize; 2]) {
        let [a, b] = ends.map(|end| self.cluster[end]);
        let (keeps, goes) = (a.min(b), a.max(b));
        for cluster in self.cluster.iter_mut().filter(|cluster| **cluster == goes) {
            *cluster = keeps;
        }
    }

    /// Numbers without gaps, one a cluster; the ground stays zero.
    fn compact(&self) -> Vec<usize> {
        let mut numbers: BTreeMap<usize, usize> = BTreeMap::new();
        let clusters = self.cluster.iter();
        clusters
            .map(|cluster| {
                let next = numbers.len();
                *numbers.entry(*cluster).or_insert(next)
            })
            .collect()
    }
}
