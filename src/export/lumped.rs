//! A structure of beams in a pose as rigid bodies with springs between them, as simulators of rigid bodies need it.
//!
//! Each node is a body. A beam is two rigid halves with six springs between them at its middle. For loads at the nodes this is exact: in
//! the middle of a beam of constant section, elongation, twist, the two bendings and the two shears do not couple. Its weight is as exact: the
//! halves carry it where it loads the nodes as that of the whole beam does, q L/2 with q L²/12 about each. The bodies hang on each
//! other as a tree from the base. A beam that closes a loop is cut beside its far node, and the cut ends are to be welded.
//!
//! # Source
//! The natural modes of Argyris (Recent Advances in Matrix Methods of Structural Analysis, 1964), as in [`NaturalStiffness`]: a
//! displacement δ of one rigid half against the other is a shear mode of 2 δ/L.

use std::collections::VecDeque;

use crate::physics::SimulatedRotation;
use crate::structure::{Attachment, LocalAxes, NaturalStiffness, Structure};
use crate::test_point::Direction;
use crate::vector::subtract;

use super::inertia::{Inertia, Rod};

/// A stiffness from which on a spring is as good as rigid, N·m/rad or N/m: what stands for rigid joints in a structure is far above it.
const RIGID: f64 = 1e18;

/// Rigid bodies and springs that move as a structure does.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LumpedModel {
    /// The bodies, each after the one it hangs on; the first is the base.
    pub bodies: Vec<LumpedBody>,
    /// Pairs of bodies that are to be welded to each other: the cut ends of loops.
    pub welds: Vec<Weld>,
    /// Body that the end of the robot is on.
    pub end: usize,
    /// Position of the end, m.
    pub end_m: [f64; 3],
}

/// A rigid body with its axes along those of the world.
#[derive(Debug, Clone, PartialEq)]
pub struct LumpedBody {
    /// Its name.
    pub name: String,
    /// The body that it hangs on; `None` is the world.
    pub parent: Option<usize>,
    /// Its origin, m.
    pub position_m: [f64; 3],
    /// How it moves on its parent, in series.
    pub joints: Vec<LumpedJoint>,
    /// What it weighs.
    pub inertia: Inertia,
    /// Rigid halves of beams, and rigid links, on it.
    pub rods: Vec<Rod>,
}

/// A motion about or along one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct LumpedJoint {
    /// Its name, for example `joint.J2` or `member.rod.rz`.
    pub name: String,
    /// A point of its axis, m.
    pub position_m: [f64; 3],
    /// Unit vector of the axis.
    pub axis: [f64; 3],
    /// Whether it slides along the axis instead of turning about it.
    pub slides: bool,
    /// Stiffness of its spring, N·m/rad or N/m; `None` without one.
    pub stiffness: Option<f64>,
    /// Moment or force that its friction holds, N·m or N.
    pub friction: f64,
    /// Largest motion either way, rad or m; `None` without a stop.
    pub play: Option<f64>,
}

/// Two bodies that move as one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Weld {
    /// The member that is cut there.
    pub member: String,
    /// The bodies.
    pub bodies: [usize; 2],
}

/// What a structure does not say of itself.
#[derive(Debug, Clone, Default)]
pub struct LumpedParts {
    /// Names of the elements of the structure.
    pub members: Vec<String>,
    /// Mass per length of the elements, kg/m; zero where it is not known.
    pub kg_per_m: Vec<f64>,
    /// Names of the hinges of the structure.
    pub hinges: Vec<String>,
    /// Laws of hinges, by their place.
    pub laws: Vec<(usize, SimulatedRotation)>,
    /// Compliance of the base about x, y, z through the first support, that the structure does not have, rad/(N·m).
    pub base_rad_per_nm: [f64; 3],
    /// Masses that are not those of elements: where they hang, kg, position, m.
    pub masses: Vec<(Attachment, f64, [f64; 3])>,
}

/// What lies between two vertices.
#[derive(Debug, Clone, Copy)]
enum LumpedLink {
    /// Nothing that yields.
    Rigid,
    /// A hinge, by its place.
    Hinge(usize),
    /// A beam, by its place.
    Beam(usize),
}

/// An edge of the graph of bodies.
#[derive(Debug, Clone, Copy)]
struct LumpedEdge {
    vertices: [usize; 2],
    link: LumpedLink,
}

impl LumpedModel {
    /// The rigid bodies of a structure, where it stands.
    #[must_use]
    pub fn new(structure: &Structure, parts: &LumpedParts) -> Self {
        let mut builder = LumpedBuilder {
            structure,
            parts,
            vertices: (0..structure.nodes.len()).map(Into::into).collect(),
            bodies: Vec::new(),
            found: Self::default(),
        };
        builder.build();
        for (at, mass_kg, position_m) in &parts.masses {
            let body = builder.body(builder.vertex(at));
            if let Some(body) = builder.found.bodies.get_mut(body) {
                body.inertia = body.inertia.with(Inertia::point(*mass_kg, *position_m));
            }
        }
        builder.found
    }
}

struct LumpedBuilder<'a> {
    structure: &'a Structure,
    parts: &'a LumpedParts,
    /// The bare nodes in their order, then what lies behind hinges.
    vertices: Vec<Attachment>,
    /// The body of each vertex.
    bodies: Vec<Option<usize>>,
    found: LumpedModel,
}

impl LumpedBuilder<'_> {
    fn build(&mut self) {
        let edges = self.edges();
        self.bodies = vec![None; self.vertices.len()];
        let supports = self.structure.supports.iter();
        let held: Vec<usize> = supports.map(|support| support.node).collect();
        let Some(&first) = held.first() else {
            return;
        };
        let base = self.base(first);
        for &vertex in &held {
            self.bodies[vertex] = Some(base);
        }
        let mut next = VecDeque::new();
        for vertex in held {
            leave(vertex, &edges, &mut next);
        }
        let mut used = vec![false; edges.len()];
        while let Some((from, number)) = next.pop_front() {
            let edge = edges[number];
            if std::mem::replace(&mut used[number], true) {
                continue;
            }
            let to = edge.vertices[usize::from(edge.vertices[0] == from)];
            if self.bodies[to].is_none() {
                let body = self.hang(self.name(to), (from, to), edge.link);
                self.bodies[to] = Some(body);
                leave(to, &edges, &mut next);
            } else {
                self.cut(from, to, edge.link);
            }
        }
        let end = self.vertex(&self.structure.end);
        self.found.end = self.body(end);
        self.found.end_m = self.position_m(end);
    }

    /// What joins the vertices; those behind hinges are found on the way.
    fn edges(&mut self) -> Vec<LumpedEdge> {
        let structure = self.structure;
        let mut edges = Vec::new();
        let ends = structure.elements.iter().map(|element| &element.ends);
        let ends: Vec<[usize; 2]> = ends
            .map(|[a, b]| [self.behind(a, &mut edges), self.behind(b, &mut edges)])
            .collect();
        for member in &structure.rigid_members {
            let [a, b] = &member.ends;
            let vertices = [self.behind(a, &mut edges), self.behind(b, &mut edges)];
            let link = LumpedLink::Rigid;
            edges.push(LumpedEdge { vertices, link });
        }
        self.behind(&structure.end, &mut edges);
        for (at, ..) in &self.parts.masses {
            self.behind(at, &mut edges);
        }
        let beams = ends.into_iter().enumerate();
        edges.extend(beams.map(|(element, vertices)| LumpedEdge {
            vertices,
            link: LumpedLink::Beam(element),
        }));
        edges
    }

    /// The vertex behind hinges, with an edge for each hinge that is met first.
    fn behind(&mut self, at: &Attachment, edges: &mut Vec<LumpedEdge>) -> usize {
        if let Some(known) = self.vertices.iter().position(|known| known == at) {
            return known;
        }
        let mut before = at.clone();
        let hinge = before.hinges.pop().expect("every bare node is a vertex");
        let before = self.behind(&before, edges);
        self.vertices.push(at.clone());
        let vertices = [before, self.vertices.len() - 1];
        let link = LumpedLink::Hinge(hinge);
        edges.push(LumpedEdge { vertices, link });
        vertices[1]
    }

    fn vertex(&self, at: &Attachment) -> usize {
        let place = self.vertices.iter().position(|known| known == at);
        place.expect("every attachment of the structure is a vertex")
    }

    fn body(&self, vertex: usize) -> usize {
        self.bodies[vertex].unwrap_or(0)
    }

    fn position_m(&self, vertex: usize) -> [f64; 3] {
        self.structure.nodes[self.vertices[vertex].node].position_m
    }

    /// The body of the supports, with the springs under it.
    fn base(&mut self, first: usize) -> usize {
        let position_m = self.position_m(first);
        let springs = Direction::ALL.into_iter().zip(self.parts.base_rad_per_nm);
        let joints = springs
            .filter(|(_, c)| *c > 0.0)
            .map(|(axis, c)| LumpedJoint {
                stiffness: Some(1.0 / c),
                ..free(format!("base.r{axis}.law"), position_m, axis.unit_vector())
            });
        let joints = joints.collect();
        self.add("base".to_owned(), None, position_m, joints)
    }

    fn add(
        &mut self,
        name: String,
        parent: Option<usize>,
        position_m: [f64; 3],
        joints: Vec<LumpedJoint>,
    ) -> usize {
        self.found.bodies.push(LumpedBody {
            name,
            parent,
            position_m,
            joints,
            inertia: Inertia::default(),
            rods: Vec::new(),
        });
        self.found.bodies.len() - 1
    }

    /// A body at a vertex that hangs on another.
    fn hang(&mut self, name: String, (from, to): (usize, usize), link: LumpedLink) -> usize {
        let joints = self.joints(link);
        let (parent, position_m) = (self.body(from), self.position_m(to));
        let body = self.add(name, Some(parent), position_m, joints);
        match link {
            LumpedLink::Beam(element) => self.add_halves(element, [(from, parent), (to, body)]),
            LumpedLink::Rigid => {
                let rod = Rod::rigid([self.position_m(from), position_m]);
                self.found.bodies[parent].rods.extend(rod);
            }
            LumpedLink::Hinge(_) => {}
        }
        body
    }

    /// Closes a loop: what lies between two bodies hangs on the first and is welded to the second.
    fn cut(&mut self, from: usize, to: usize, link: LumpedLink) {
        let member = match link {
            LumpedLink::Beam(element) => self.parts.members[element].clone(),
            LumpedLink::Rigid | LumpedLink::Hinge(_) => self.name(to),
        };
        let body = self.hang(format!("cut.{member}"), (from, to), link);
        let bodies = [body, self.body(to)];
        self.found.welds.push(Weld { member, bodies });
    }

    /// Name of the body of a vertex: that of its node, and of the joints before it.
    fn name(&self, vertex: usize) -> String {
        let at = &self.vertices[vertex];
        let mut name = format!("node.{}", self.structure.nodes[at.node].name);
        for &hinge in &at.hinges {
            name.push('.');
            name.push_str(&self.parts.hinges[hinge]);
        }
        name
    }

    fn joints(&self, link: LumpedLink) -> Vec<LumpedJoint> {
        match link {
            LumpedLink::Rigid => Vec::new(),
            LumpedLink::Hinge(hinge) => self.hinge(hinge),
            LumpedLink::Beam(element) => self.middle(element),
        }
    }

    /// A hinge: its spring, then the laws that act in it.
    fn hinge(&self, number: usize) -> Vec<LumpedJoint> {
        let hinge = &self.structure.hinges[number];
        let name = &self.parts.hinges[number];
        let behind = |at: &&Attachment| at.hinges.last() == Some(&number);
        let at = self.vertices.iter().find(behind);
        let position_m = at.map_or([0.0; 3], |at| self.structure.nodes[at.node].position_m);
        let plain = |name: String| LumpedJoint {
            slides: hinge.slides,
            ..free(name, position_m, hinge.axis)
        };
        let mut joints = Vec::new();
        if hinge.stiffness_nm_per_rad < RIGID {
            joints.push(LumpedJoint {
                stiffness: (hinge.stiffness_nm_per_rad > 0.0).then_some(hinge.stiffness_nm_per_rad),
                ..plain(name.clone())
            });
        }
        let laws = self.parts.laws.iter().filter(|(of, _)| *of == number);
        for (count, (_, law)) in laws.enumerate() {
            let mut turns = plain(format!("{name}.law{}", count + 1));
            turns.friction = law.friction_nm;
            if law.compliance_rad_per_nm > 0.0 {
                turns.stiffness = Some(1.0 / law.compliance_rad_per_nm);
                joints.push(turns);
            } else if law.play_rad > 0.0 {
                turns.play = Some(law.play_rad);
                joints.push(turns);
            }
        }
        joints
    }

    /// The six springs in the middle of a beam.
    fn middle(&self, number: usize) -> Vec<LumpedJoint> {
        let element = &self.structure.elements[number];
        let [first, second] = self.ends_m(number);
        let span_m = subtract(second, first);
        let Some((axes, length_m)) = LocalAxes::along(span_m, element.toward_y) else {
            return Vec::new();
        };
        let natural =
            NaturalStiffness::of(&element.section, &element.material, element.shear, length_m);
        let [stretch, twist, curve_y, shear_y, curve_z, shear_z] = natural.stiffness;
        let across = 4.0 / (length_m * length_m);
        let middle_m = middle_of([first, second]);
        let name = &self.parts.members[number];
        let springs = [
            ("x", axes.x, true, stretch),
            ("y", axes.y, true, across * shear_z),
            ("z", axes.z, true, across * shear_y),
            ("rx", axes.x, false, twist),
            ("ry", axes.y, false, curve_y),
            ("rz", axes.z, false, curve_z),
        ];
        let spring = |(motion, axis, slides, stiffness)| LumpedJoint {
            slides,
            stiffness: Some(stiffness),
            ..free(format!("member.{name}.{motion}"), middle_m, axis)
        };
        springs.map(spring).into()
    }

    fn ends_m(&self, element: usize) -> [[f64; 3]; 2] {
        let ends = &self.structure.elements[element].ends;
        [0, 1].map(|end: usize| self.structure.nodes[ends[end].node].position_m)
    }

    /// Gives two bodies the halves of a beam between them.
    fn add_halves(&mut self, element: usize, ends: [(usize, usize); 2]) {
        let middle_m = middle_of(self.ends_m(element));
        let area_m2 = self.structure.elements[element].section.area_m2;
        for (vertex, body) in ends {
            let node_m = self.position_m(vertex);
            // Half the mass with its centre a sixth of the length from the node pulls and turns the node as the weight of the beam does.
            let third_m = [0, 1, 2].map(|i| node_m[i] + (middle_m[i] - node_m[i]) / 1.5);
            let kg_per_m = 1.5 * self.parts.kg_per_m[element];
            let rod = Inertia::rod(kg_per_m, Rod::beam([node_m, third_m], area_m2));
            let body = &mut self.found.bodies[body];
            body.inertia = body.inertia.with(rod);
            body.rods.push(Rod::beam([node_m, middle_m], area_m2));
        }
    }
}

/// Puts the ways that lead on from a vertex in order: what is not to be cut, hinges and rigid links, before any beam.
fn leave(vertex: usize, edges: &[LumpedEdge], next: &mut VecDeque<(usize, usize)>) {
    for (number, edge) in edges.iter().enumerate() {
        match (edge.vertices.contains(&vertex), edge.link) {
            (false, _) => {}
            (true, LumpedLink::Beam(_)) => next.push_back((vertex, number)),
            (true, LumpedLink::Rigid | LumpedLink::Hinge(_)) => next.push_front((vertex, number)),
        }
    }
}

fn middle_of([a, b]: [[f64; 3]; 2]) -> [f64; 3] {
    [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]))
}

/// A joint that turns freely.
fn free(name: String, position_m: [f64; 3], axis: [f64; 3]) -> LumpedJoint {
    LumpedJoint {
        name,
        position_m,
        axis,
        slides: false,
        stiffness: None,
        friction: 0.0,
        play: None,
    }
}
