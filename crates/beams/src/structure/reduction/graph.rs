//! Which elements and hinges lie between the ground and the end, and at which nodes that way hangs on a single node.

use std::collections::BTreeMap;

use super::schedule::SchedulePiece;
use crate::structure::parts::{Attachment, Structure};
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
    /// The graph of a structure; `None` if something lies behind several hinges, or it has a node held in part, a held end, an element
    /// from a node to itself, or something that hangs on no support: those are for [`Solver`](crate::structure::Solver).
    pub(super) fn of(structure: &Structure) -> Option<Self> {
        let held = held_freedoms(structure);
        let whole = held.iter().all(|h| *h == [true; 6] || *h == [false; 6]);
        if !whole {
            return None;
        }
        let mut nodes: Vec<usize> = (0..held.len()).filter(|&n| !held[n][0]).collect();
        let free: BTreeMap<usize, usize> = nodes.iter().copied().zip(1..).collect();
        let on_node = |node: usize| free.get(&node).copied().unwrap_or(GROUND);
        let first_behind = nodes.len() + 1;
        let vertex = |at: &Attachment| match at.hinges[..] {
            [] => Some(on_node(at.node)),
            [hinge] => Some(first_behind + hinge),
            _ => None,
        };
        let mut edges = Vec::new();
        for (element, parts) in structure.elements.iter().enumerate() {
            if parts.ends[0].node == parts.ends[1].node {
                return None;
            }
            edges.push(Edge {
                piece: SchedulePiece::Element(element),
                ends: [vertex(&parts.ends[0])?, vertex(&parts.ends[1])?],
            });
        }
        for hinge in 0..structure.hinges.len() {
            let node = structure.node_of_hinge(hinge)?;
            edges.push(Edge {
                piece: SchedulePiece::Hinge(hinge),
                ends: [on_node(node), first_behind + hinge],
            });
            nodes.push(node);
        }
        let graph = Self {
            vertex_count: nodes.len() + 1,
            edges,
            end: vertex(&structure.end)?,
            nodes,
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
