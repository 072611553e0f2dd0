//! The steps from elements to the compliance of the end, fixed once for all poses.

/// A matrix in memory.
pub(super) type Slot = usize;

/// In which way a two-ended part is written down: what adds up in series, or what adds up side by side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ReductionForm {
    /// Motion of one end against the other per force.
    Compliance,
    /// Its inverse.
    Stiffness,
}

/// What a structure is put together of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SchedulePiece {
    /// An element, by its index.
    Element(usize),
    /// A hinge, by its index. It has a compliance only: nothing but a turn about its axis moves its sides against each other.
    Hinge(usize),
}

/// A step. Where it is `fresh`, what it adds to holds nothing yet and is set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Op {
    /// Adds an element or a hinge; of the matrix only the upper triangle is kept.
    Piece {
        piece: SchedulePiece,
        form: ReductionForm,
        into: Slot,
        fresh: bool,
    },
    /// Adds the hinges that struts stand over.
    Brace { into: Slot, fresh: bool },
    /// Adds the inverse of a matrix, which is destroyed.
    Invert { from: Slot, into: Slot, fresh: bool },
    /// Adds the upper triangle of a matrix.
    Add { from: Slot, into: Slot, fresh: bool },
    /// Fills the lower triangle.
    Mirror { slot: Slot },
    /// Lets hinges turn between a node and the one it is to be joined to: their twists are eliminated.
    Ease {
        hinges: Vec<usize>,
        diagonal: Slot,
        panels: Vec<Slot>,
        updates: Vec<Update>,
        /// Diagonals of the neighbours, in the order of the panels.
        neighbours: Vec<Slot>,
    },
    /// Joins a node, whose hinges were eased, to the one on their other side; without one it is held.
    Join {
        diagonal: Slot,
        into: Option<Joined>,
        moves: Vec<PanelMove>,
    },
    /// Eliminates a node.
    Eliminate {
        diagonal: Slot,
        panels: Vec<Slot>,
        updates: Vec<Update>,
    },
}

/// What the elimination of a node does to the coupling of two of its neighbours, counted among its panels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Update {
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) target: Slot,
    /// A diagonal loses what a panel gains: panels hold minus the block of the matrix.
    pub(super) on_diagonal: bool,
    pub(super) fresh: bool,
}

/// The node that another is joined to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Joined {
    pub(super) diagonal: Slot,
    pub(super) fresh: bool,
    /// Panel between the two, if something joins them besides the hinges.
    pub(super) between: Option<Slot>,
}

/// A panel that goes over to the node that its own is joined to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PanelMove {
    pub(super) from: Slot,
    pub(super) into: Slot,
    /// Whether the other node comes first there.
    pub(super) transposed: bool,
    pub(super) fresh: bool,
}

/// Steps, with the memory that they need; the result is slot 0.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Schedule {
    pub(super) ops: Vec<Op>,
    pub(super) slot_count: usize,
    /// Most panels at one elimination.
    pub(super) widest: usize,
}

impl Schedule {
    /// Hinges between several elements on either side.
    pub(super) fn eased_hinges(&self) -> impl Iterator<Item = usize> {
        let eased = self.ops.iter().filter_map(|op| match op {
            Op::Ease { hinges, .. } => Some(hinges),
            _ => None,
        });
        eased.flatten().copied()
    }

    /// Floating-point operations of one pose, a fused product counted as two: `halves` problems of `n` freedoms a node, `of_element`
    /// operations for what an element gives to all of them, `of_hinge` for what a hinge adds to them.
    pub(super) fn operations(&self, n: u64, halves: u64, [of_element, of_hinge]: [u64; 2]) -> u64 {
        let triangle = n * (n + 1) / 2;
        // Inverses and ratios of n pivots; factor and update of what is right of and below each.
        let factorise = 2 * n + (0..n).map(|left| left + left * (left + 1)).sum::<u64>();
        let unit_inverse: u64 = (0..n).map(|width| width * width.saturating_sub(1)).sum();
        let product: u64 = (0..n)
            .map(|column| (column + 1) * (1 + 3 * (n - 1 - column)))
            .sum();
        let invert = factorise + unit_inverse + product;
        let reduce = n * n + n * n * (n - 1);
        let sum = |fresh: bool, entries: u64| if fresh { 0 } else { entries };
        let of_update = |update: &Update| {
            if update.on_diagonal {
                2 * n * triangle
            } else {
                2 * n * n * n - n * n + sum(update.fresh, n * n)
            }
        };
        let of_op = |op: &Op| match op {
            Op::Piece { piece, fresh, .. } => match piece {
                SchedulePiece::Element(_) => of_element + halves * sum(*fresh, triangle),
                SchedulePiece::Hinge(_) => of_hinge,
            },
            Op::Invert { fresh, .. } => halves * (invert + sum(*fresh, triangle)),
            Op::Add { fresh, .. } => halves * sum(*fresh, triangle),
            Op::Brace { .. } | Op::Mirror { .. } => 0,
            Op::Ease {
                hinges,
                panels,
                updates,
                ..
            } => {
                let products = (panels.len() as u64 + 1) * 2 * n * n;
                let updates: u64 = updates.iter().map(|_| 2 * n * n).sum();
                halves * hinges.len() as u64 * (products + updates + 2 * triangle)
            }
            Op::Join { moves, .. } => halves * (triangle + moves.len() as u64 * n * n),
            Op::Eliminate {
                panels, updates, ..
            } => {
                let updates: u64 = updates.iter().map(of_update).sum();
                halves * (factorise + panels.len() as u64 * reduce + updates)
            }
        };
        self.ops.iter().map(of_op).sum()
    }
}
