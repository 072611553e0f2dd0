//! The parts of a structure, each with its schedule.

use std::collections::BTreeSet;
use std::fmt;

use super::braced::Braced;
use super::graph::{Graph, Segment};
use super::member::Constants;
use super::schedule::{Op, Schedule, SchedulePiece};
use super::series_parallel::Builder;
use crate::structure::parts::Structure;

/// Which ways of solving a part are open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SolutionPath {
    /// In its plane and across it where that is exact, in space elsewhere.
    #[default]
    Fastest,
    /// In space always.
    Spatial,
}

/// How a part of a structure is solved, for those who want to know what was done.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct PartMethod {
    /// Node towards the ground; `None` where it begins at the supports.
    pub from: Option<String>,
    /// Node towards the end.
    pub to: String,
    /// Elements that carry load on the end.
    pub elements: usize,
    /// Joints that yield on the way of that load.
    pub yielding_joints: usize,
    /// Nodes that series and parallels did not make superfluous.
    pub eliminated_nodes: usize,
    /// Whether motion in its plane and across it are solved apart, in poses that leave it in its plane.
    pub planar: bool,
    /// Floating-point operations of one pose that is not computed before, a fused product counted as two.
    pub operations: u64,
}

impl fmt::Display for PartMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let from = self.from.as_deref().unwrap_or("supports");
        let way = if self.planar {
            "in its plane and across it apart"
        } else {
            "in space"
        };
        let yielding = match self.yielding_joints {
            0 => String::new(),
            1 => ", a joint that yields".to_owned(),
            several => format!(", {several} joints that yield"),
        };
        write!(
            f,
            "{from} to {}: {} elements{yielding}, {} nodes eliminated, {way}",
            self.to, self.elements, self.eliminated_nodes
        )
    }
}

/// Operations of a part, counted in the functions that do them: those of an element, of a hinge, and of a node seen from the end of the
/// part.
fn operations(part: &Substructure) -> u64 {
    let nodes = part.nodes.len() as u64;
    if part.plane.is_some() {
        part.schedule.operations(3, 2, [59, 15]) + 24 * nodes
    } else {
        part.schedule.operations(6, 1, [204, 57]) + 3 * nodes
    }
}

/// What the connections of a structure fix for all poses.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reduction {
    pub(super) parts: Vec<Substructure>,
    /// Nodes of each element.
    pub(super) ends: Vec<[usize; 2]>,
    /// Plane of each element.
    pub(super) planes: Vec<usize>,
    pub(super) node_count: usize,
    pub(super) end: usize,
    /// Elements that carry nothing, but must have a length.
    pub(super) idle: Vec<usize>,
    /// Whether something may not yield at all.
    pub(super) has_rigid_members: bool,
    pub(super) constants: Vec<Constants>,
    pub(super) hinges: Vec<YieldingHinge>,
    pub(super) braced: Braced,
    methods: Vec<PartMethod>,
}

/// A hinge that turns in proportion to its moment, or slides in proportion to its force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct YieldingHinge {
    pub(super) node: usize,
    /// The plane whose normal is its axis.
    pub(super) plane: usize,
    pub(super) slides: bool,
    pub(super) rad_per_nm: f64,
}

/// A part that hangs on the rest by its two terminals.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Substructure {
    /// The plane that all its pieces share, if they are to be solved in it.
    pub(super) plane: Option<usize>,
    /// Node to which its matrices are referred.
    ///
    /// Where a joint between several elements yields it is there: a turn about an axis that does not pass the origin displaces it, and
    /// the small stiffness against that turn would be a difference of large numbers.
    pub(super) origin: usize,
    /// Its nodes, held ones included.
    pub(super) nodes: Vec<usize>,
    /// Planes of its pieces.
    pub(super) planes: Vec<usize>,
    pub(super) schedule: Schedule,
    /// Whether struts stand over its hinges: they may move where its nodes stand.
    pub(super) is_braced: bool,
}

impl Reduction {
    /// Reduces a structure.
    ///
    /// # Arguments
    /// - `planes`: for each element the plane whose normal is its local y.
    /// - `hinge_planes`: for each hinge the plane whose normal is its axis; of one that slides no plane of elements.
    ///
    /// # Returns
    /// `None` for a structure with a strut over anything but hinges on the way to the end, a pin, a hinge that closes a loop of rigid members
    /// alone, a node held in part, a held end, or something that hangs on no support.
    pub(crate) fn of(
        structure: &Structure,
        planes: &[usize],
        hinge_planes: &[usize],
        path: SolutionPath,
    ) -> Option<Self> {
        let braced = Braced::of(structure)?;
        let graph = Graph::of(structure)?;
        let segments = graph.segments();
        let hinges = yielding_hinges(structure, hinge_planes)?;
        let plane_of_piece = |piece: SchedulePiece| match piece {
            SchedulePiece::Element(element) => planes[element],
            SchedulePiece::Hinge(hinge) => hinge_planes[hinge],
        };
        if segments.iter().filter(|s| braced.holds(s)).count() < braced.hinges.len() {
            return None;
        }
        let plane_of = |segment: &Segment| {
            if braced.holds(segment) {
                return None;
            }
            let mut planes = segment.edges.iter().map(|edge| plane_of_piece(edge.piece));
            let first = planes.next()?;
            planes.all(|plane| plane == first).then_some(first)
        };
        // Neighbours in one plane are one part: adding them up is cheaper than carrying them one by one.
        let runs = segments.chunk_by(|a, b| plane_of(a).is_some() && plane_of(a) == plane_of(b));
        let has_elements = |run: &[Segment]| run.iter().any(Segment::has_elements);
        // Where nothing but joints yields, all are one part, referred to the end at once.
        let (bending, yielding): (Vec<&[Segment]>, Vec<&[Segment]>) =
            runs.partition(|run| has_elements(run));
        let yielding = yielding.concat();
        let runs = bending
            .into_iter()
            .chain((!yielding.is_empty()).then_some(&yielding[..]));
        let ends: Vec<[usize; 2]> = structure
            .elements
            .iter()
            .map(|element| [0, 1].map(|end| element.ends[end].node))
            .collect();
        let mut parts = Vec::new();
        let mut methods = Vec::new();
        let mut idle: BTreeSet<usize> = (0..ends.len()).collect();
        for run in runs {
            let (near, far) = (run[0].terminals[0], run[run.len() - 1].terminals[1]);
            let bends = has_elements(run);
            let far = if bends {
                node_at(run, far, &ends, &graph)?
            } else {
                structure.end.node
            };
            let edges = run.iter().flat_map(|segment| &segment.edges);
            let pieces: Vec<SchedulePiece> = edges.map(|edge| edge.piece).collect();
            let mut elements = 0;
            for piece in &pieces {
                if let SchedulePiece::Element(element) = piece {
                    elements += 1;
                    idle.remove(element);
                }
            }
            let nodes_of = |piece: SchedulePiece| match piece {
                SchedulePiece::Element(element) => ends[element],
                SchedulePiece::Hinge(hinge) => [hinges[hinge].node; 2],
            };
            let schedule = Builder::build(run.iter(), &braced)?;
            let nodes: Vec<usize> = pieces.iter().flat_map(|&piece| nodes_of(piece)).collect();
            let eased = schedule.eased_hinges().map(|hinge| hinges[hinge].node);
            let meeting = |node: &usize| nodes.iter().filter(|known| *known == node).count();
            let origin = eased.max_by_key(meeting).unwrap_or(far);
            let part = Substructure {
                plane: plane_of(&run[0]).filter(|_| path == SolutionPath::Fastest && bends),
                origin,
                nodes: distinct(nodes.into_iter().chain([far])),
                planes: distinct(pieces.iter().map(|&piece| plane_of_piece(piece))),
                is_braced: run.iter().any(|segment| braced.holds(segment)),
                schedule,
            };
            let name = |node: usize| structure.nodes[node].name.to_string();
            let eliminated = |op: &&Op| matches!(op, Op::Eliminate { .. });
            methods.push(PartMethod {
                from: graph.node(near).map(name),
                to: name(far),
                elements,
                yielding_joints: pieces.len() - elements,
                eliminated_nodes: part.schedule.ops.iter().filter(eliminated).count(),
                planar: part.plane.is_some(),
                operations: operations(&part),
            });
            parts.push(part);
        }
        Some(Self {
            parts,
            constants: Vec::with_capacity(ends.len()),
            ends,
            planes: planes.to_vec(),
            node_count: structure.nodes.len(),
            hinges,
            braced,
            end: structure.end.node,
            idle: idle.into_iter().collect(),
            has_rigid_members: !structure.rigid_members.is_empty(),
            methods,
        })
    }

    /// Takes sections, materials and hinge stiffnesses of a structure; returns whether all can be used.
    ///
    /// A constant of zero cannot: what carries nothing has no compliance to add.
    pub(crate) fn rate(&mut self, structure: &Structure) -> bool {
        self.constants.clear();
        let elements = structure.elements.iter();
        self.constants.extend(elements.map_while(Constants::of));
        for (own, hinge) in self.hinges.iter_mut().zip(&structure.hinges) {
            own.rad_per_nm = 1.0 / hinge.stiffness_nm_per_rad;
        }
        let mut springs = self.hinges.iter();
        let springs = springs.all(|hinge| is_usable(hinge.rad_per_nm));
        springs && self.constants.len() == self.ends.len()
    }

    /// How each part is solved, from the ground to the end.
    pub(crate) fn methods(&self) -> &[PartMethod] {
        &self.methods
    }
}

fn distinct(all: impl Iterator<Item = usize>) -> Vec<usize> {
    all.collect::<BTreeSet<usize>>().into_iter().collect()
}

/// A node of the pieces of a run at its far vertex: a rigid cluster may have others, out of the plane of the run.
fn node_at(run: &[Segment], far: usize, ends: &[[usize; 2]], graph: &Graph) -> Option<usize> {
    let edges = run.iter().flat_map(|segment| &segment.edges);
    let mut elements = edges.filter_map(|edge| match edge.piece {
        SchedulePiece::Element(element) => Some((edge.ends, ends[element])),
        SchedulePiece::Hinge(_) => None,
    });
    let at_far = |(vertices, nodes): ([usize; 2], [usize; 2])| {
        let side = vertices.iter().position(|vertex| *vertex == far)?;
        Some(nodes[side])
    };
    elements.find_map(at_far).or_else(|| graph.node(far))
}

/// Whether a hinge of this compliance can be put in series with what bends.
fn is_usable(rad_per_nm: f64) -> bool {
    rad_per_nm.is_normal() && rad_per_nm > 0.0
}

/// The hinges of a structure; `None` if one is a pin, or has nothing behind it.
fn yielding_hinges(structure: &Structure, planes: &[usize]) -> Option<Vec<YieldingHinge>> {
    let hinges = structure.hinges.iter().zip(planes).enumerate();
    hinges
        .map(|(index, (hinge, &plane))| {
            let rad_per_nm = 1.0 / hinge.stiffness_nm_per_rad;
            Some(YieldingHinge {
                node: structure.node_of_hinge(index)?,
                plane,
                slides: hinge.slides,
                rad_per_nm: is_usable(rad_per_nm).then_some(rad_per_nm)?,
            })
        })
        .collect()
}
