//! Poses side by side in the lanes of a register: where their nodes are, what follows for each element, and the results.

use pulp::Simd;

use super::plan::Plan;
use crate::structure::parts::Structure;
use stiffbench_numeric::lanes::{
    Kernel, Lane, Number, across, cross, dot, frame_on, multiply_add, scale, subtract,
};

/// An element lies in the plane of the frame where its local y strays from the normal by no more than this, rad: far above
/// rounding, and what it leaves out is of this size and far below what any solver keeps.
const PLANE_TOLERANCE_RAD: f64 = 1e-12;

/// As many poses as a lane has, and their results.
#[derive(Debug, Clone)]
pub(super) struct Bundle<S: Simd> {
    /// Which lanes hold a pose.
    pub(super) placed: Vec<bool>,
    /// Position of each node, m.
    nodes_m: Vec<[Lane<S>; 3]>,
    /// Hint for local y of each element.
    toward_y: Vec<[Lane<S>; 3]>,
    /// Whether what follows belongs to the positions above.
    pub(super) prepared: bool,
    /// Unit vectors n, p, q: the normal of the main plane, and two axes in it; n × p = q.
    pub(super) frame: [[Lane<S>; 3]; 3],
    pub(super) elements: Vec<ElementGeometry<S>>,
    /// Global unit vectors along which derivatives are taken.
    pub(super) toward: [[Lane<S>; 3]; 3],
    /// Elements without length or plane, by pose.
    degenerate: Lane<S>,
    /// Elements that should lie in the main plane and do not, by pose.
    out_of_plane: Lane<S>,
    pub(super) results: Results<S>,
}

/// What a solution leaves.
#[derive(Debug, Clone)]
pub(super) struct Results<S: Simd> {
    /// Compliance of the end, 6 × 6.
    pub(super) compliance: [[Lane<S>; 6]; 6],
    /// How much is wrong, by pose: degenerate elements, pivots that are rounding.
    pub(super) faults: Lane<S>,
    /// For each group, axis and property.
    pub(super) derivatives: Vec<[[Lane<S>; 4]; 3]>,
}

/// Axes and length of an element.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct ElementGeometry<S: Simd> {
    /// Local x, y, z in the frame's components.
    pub(super) axes: [[Lane<S>; 3]; 3],
    /// 1/L, 1/m.
    pub(super) inverse_length: Lane<S>,
}

impl<S: Simd> Results<S> {
    pub(super) fn new(simd: S, groups: usize) -> Self {
        let zero = Lane::zero(simd);
        Self {
            compliance: [[zero; 6]; 6],
            faults: Lane::one(simd),
            derivatives: vec![[[zero; 4]; 3]; groups],
        }
    }

    /// Takes one pose from other results.
    pub(super) fn copy_lane(&mut self, other: &Self, lane: usize) {
        let entries = self.compliance.iter_mut().flatten();
        for (entry, other) in entries.zip(other.compliance.iter().flatten()) {
            entry.set(lane, other.get(lane));
        }
        self.faults.set(lane, other.faults.get(lane));
        let entries = self.derivatives.iter_mut().flatten().flatten();
        for (entry, other) in entries.zip(other.derivatives.iter().flatten().flatten()) {
            entry.set(lane, other.get(lane));
        }
    }
}

impl<S: Simd> Bundle<S> {
    pub(super) fn new(simd: S, structure: &Structure, groups: usize) -> Self {
        let zero = Lane::zero(simd);
        let unset = ElementGeometry {
            axes: [[zero; 3]; 3],
            inverse_length: zero,
        };
        Self {
            placed: vec![false; Lane::<S>::COUNT],
            nodes_m: vec![[zero; 3]; structure.nodes.len()],
            toward_y: vec![[zero; 3]; structure.elements.len()],
            prepared: false,
            frame: [[zero; 3]; 3],
            elements: vec![unset; structure.elements.len()],
            toward: [0, 1, 2]
                .map(|axis| [0, 1, 2].map(|i| if i == axis { Lane::one(simd) } else { zero })),
            degenerate: zero,
            out_of_plane: zero,
            results: Results::new(simd, groups),
        }
    }

    /// Copies positions and axes of `structure` into a lane.
    pub(super) fn place(&mut self, lane: usize, structure: &Structure) {
        assert!(
            structure.nodes.len() == self.nodes_m.len()
                && structure.elements.len() == self.toward_y.len(),
            "a solver serves structures of one topology"
        );
        for (position, node) in self.nodes_m.iter_mut().zip(&structure.nodes) {
            for i in 0..3 {
                position[i].set(lane, node.position_m[i]);
            }
        }
        for (toward_y, element) in self.toward_y.iter_mut().zip(&structure.elements) {
            for i in 0..3 {
                toward_y[i].set(lane, element.toward_y[i]);
            }
        }
        self.placed[lane] = true;
        self.prepared = false;
        // What was solved here was another pose.
        self.results.faults.set(lane, 1.0);
    }

    /// Whether all elements that should lie in the main plane do so, in the poses where they can be told.
    pub(super) fn is_in_plane(&self, lane: usize) -> bool {
        self.out_of_plane.get(lane) == 0.0
    }

    /// Begins a new solution.
    pub(super) fn clear(&mut self) {
        self.results.faults = self.degenerate;
        let zero = self.degenerate.of(0.0);
        self.results.derivatives.fill([[zero; 4]; 3]);
    }
}

/// Works out frame, axes and lengths of a bundle.
pub(super) struct Prepare<'a, S: Simd> {
    pub(super) plan: &'a Plan,
    /// An element whose local y is the normal of the main plane.
    pub(super) reference: usize,
    pub(super) bundle: &'a mut Bundle<S>,
}

impl<S: Simd> Kernel for Prepare<'_, S> {
    #[inline(always)]
    fn run(self) {
        let Self {
            plan,
            reference,
            bundle,
        } = self;
        let [first, second] = plan.elements[reference].nodes;
        let span = subtract(&bundle.nodes_m[second], &bundle.nodes_m[first]);
        let (axes, ..) = local_axes(&span, &bundle.toward_y[reference]);
        let frame = frame_on(&axes[1]);

        let mut degenerate = span[0].of(0.0);
        let mut out_of_plane = degenerate;
        let tolerance = degenerate.of(PLANE_TOLERANCE_RAD * PLANE_TOLERANCE_RAD);
        for (index, places) in plan.elements.iter().enumerate() {
            let [first, second] = places.nodes;
            let span = subtract(&bundle.nodes_m[second], &bundle.nodes_m[first]);
            let (axes, inverse_length, fault) = local_axes(
                &components(&frame, &span),
                &components(&frame, &bundle.toward_y[index]),
            );
            degenerate += fault;
            if places.in_plane {
                let (p, q) = (axes[1][1], axes[1][2]);
                out_of_plane += multiply_add(p, p, q * q).fault_unless_below(tolerance);
            }
            bundle.elements[index] = ElementGeometry {
                axes,
                inverse_length,
            };
        }
        bundle.frame = frame;
        bundle.degenerate = degenerate;
        bundle.out_of_plane = out_of_plane;
        bundle.prepared = true;
    }
}

/// As [`LocalAxes::along`](crate::structure::LocalAxes::along): axes, 1/length, and 1 in poses where there are none.
#[inline(always)]
fn local_axes<S: Simd>(
    span: &[Lane<S>; 3],
    toward_y: &[Lane<S>; 3],
) -> ([[Lane<S>; 3]; 3], Lane<S>, Lane<S>) {
    let inverse_length = dot(span, span).sqrt().inverse();
    let x = scale(span, inverse_length);
    let y = across(toward_y, &x);
    let y_squared = dot(&y, &y);
    let hint_squared = dot(toward_y, toward_y);
    let y = scale(&y, y_squared.sqrt().inverse());
    // Lengths of zero and beyond all numbers give 1/L of infinity and zero, what is not a number gives NaN: all are faults.
    let no_length = inverse_length.fault_unless_below(span[0].of(f64::INFINITY))
        + (-inverse_length).fault_unless_below(span[0].of(0.0));
    let no_plane = (hint_squared * span[0].of(1e-18)).fault_unless_below(y_squared);
    let z = cross(&x, &y);
    ([x, y, z], inverse_length, no_length + no_plane)
}

/// Components of a global vector in a frame.
#[inline(always)]
pub(super) fn components<S: Simd>(frame: &[[Lane<S>; 3]; 3], v: &[Lane<S>; 3]) -> [Lane<S>; 3] {
    [dot(&frame[0], v), dot(&frame[1], v), dot(&frame[2], v)]
}
