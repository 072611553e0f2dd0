//! Elements and hinges in series and side by side, merged until nothing of either is left; what remains is eliminated node by node.

use std::collections::{BTreeMap, BTreeSet};

use super::braced::Braced;
use super::graph::{Edge, GROUND, Segment};
use super::schedule::{
    Joined, Op, PanelMove, ReductionForm, Schedule, SchedulePiece, Slot, Update,
};
use crate::structure::ordering::{Eliminated, minimum_degree_before};

/// An assembly that hangs on the rest by two nodes: motions of its parts add up in series, their forces side by side.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum SeriesParallel {
    Piece(SchedulePiece),
    Series(Vec<SeriesParallel>),
    Parallel(Vec<SeriesParallel>),
}

/// An assembly and its vertices.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Link {
    assembly: SeriesParallel,
    ends: [usize; 2],
}

impl SeriesParallel {
    /// Whether it can be written down in a form: a hinge, which is rigid but for its turn, has a stiffness only together with what it is
    /// in series with.
    fn has(&self, form: ReductionForm) -> bool {
        match self {
            Self::Piece(SchedulePiece::Element(_)) => true,
            Self::Piece(SchedulePiece::Hinge(_)) => form == ReductionForm::Compliance,
            Self::Series(parts) => {
                let sum = parts.iter().all(|part| part.has(ReductionForm::Compliance));
                sum && (form == ReductionForm::Compliance
                    || parts.iter().any(|p| p.has(ReductionForm::Stiffness)))
            }
            Self::Parallel(parts) => parts.iter().all(|part| part.has(ReductionForm::Stiffness)),
        }
    }

    /// The hinges of an assembly of nothing else: it is rigid but for their turns.
    fn hinges(&self) -> Option<Vec<usize>> {
        match self {
            Self::Piece(SchedulePiece::Hinge(hinge)) => Some(vec![*hinge]),
            Self::Series(parts) => {
                let hinges: Option<Vec<_>> = parts.iter().map(Self::hinges).collect();
                Some(hinges?.concat())
            }
            Self::Piece(SchedulePiece::Element(_)) | Self::Parallel(_) => None,
        }
    }

    fn joined(self, other: Self, wrap: fn(Vec<Self>) -> Self) -> Self {
        let mut parts = Vec::new();
        for part in [self, other] {
            match (part, wrap(Vec::new())) {
                (Self::Series(inner), Self::Series(_))
                | (Self::Parallel(inner), Self::Parallel(_)) => parts.extend(inner),
                (part, _) => parts.push(part),
            }
        }
        wrap(parts)
    }
}

/// Merges the pieces of a segment as far as series and parallels go.
fn merged(segment: &Segment) -> Vec<Link> {
    let link = |edge: &Edge| Link {
        assembly: SeriesParallel::Piece(edge.piece),
        ends: edge.ends,
    };
    let nothing = || SeriesParallel::Series(Vec::new());
    let mut links: Vec<Link> = segment.edges.iter().map(link).collect();
    loop {
        if let Some((first, second)) = side_by_side(&links) {
            let second = links.remove(second);
            let first = &mut links[first];
            let assembly = std::mem::replace(&mut first.assembly, nothing());
            first.assembly = assembly.joined(second.assembly, SeriesParallel::Parallel);
        } else if let Some((first, second, ends)) = in_series(&links, segment.terminals) {
            let second = links.remove(second);
            let first = &mut links[first];
            let assembly = std::mem::replace(&mut first.assembly, nothing());
            first.assembly = assembly.joined(second.assembly, SeriesParallel::Series);
            first.ends = ends;
        } else {
            return links;
        }
    }
}

/// Two links, the earlier first, with the same ends.
fn side_by_side(links: &[Link]) -> Option<(usize, usize)> {
    let mut seen = BTreeMap::new();
    // Hinges alone have no stiffness to be added.
    let all = links.iter().enumerate();
    let mut bending = all.filter(|(_, link)| link.assembly.hinges().is_none());
    bending.find_map(|(place, link)| {
        let [a, b] = link.ends;
        let earlier = seen.insert((a.min(b), a.max(b)), place)?;
        Some((earlier, place))
    })
}

/// Two links, the earlier first, that alone meet at a node which is no terminal; and the ends of both together.
fn in_series(links: &[Link], terminals: [usize; 2]) -> Option<(usize, usize, [usize; 2])> {
    let mut at: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (place, link) in links.iter().enumerate() {
        for vertex in link.ends {
            at.entry(vertex).or_default().push(place);
        }
    }
    let other = |place: usize, vertex: usize| {
        let [a, b] = links[place].ends;
        if a == vertex { b } else { a }
    };
    at.iter().find_map(|(&vertex, places)| match places[..] {
        [first, second] if vertex != GROUND && !terminals.contains(&vertex) => {
            Some((first, second, [other(first, vertex), other(second, vertex)]))
        }
        _ => None,
    })
}

/// Builds the schedule of consecutive segments: the sum of their compliances, in slot 0.
pub(super) struct Builder {
    schedule: Schedule,
    /// Slots that hold something already.
    begun: BTreeSet<Slot>,
}

impl Builder {
    /// `None` if hinges alone lead from one terminal of a segment to the other beside what bends, or close a loop.
    ///
    /// # Arguments
    /// - `braced`: hinges that struts stand over, each a segment by itself: they are added together.
    pub(super) fn build<'a>(
        segments: impl Iterator<Item = &'a Segment>,
        braced: &Braced,
    ) -> Option<Schedule> {
        let mut builder = Self {
            schedule: Schedule {
                slot_count: 1,
                ..Schedule::default()
            },
            begun: BTreeSet::new(),
        };
        let mut has_braced = false;
        for segment in segments {
            if braced.holds(segment) {
                has_braced = true;
                continue;
            }
            let links = merged(segment);
            let all_have = |form| links.iter().all(|link| link.assembly.has(form));
            if let [link] = &links[..] {
                if !all_have(ReductionForm::Compliance) {
                    return None;
                }
                builder.evaluate(&link.assembly, ReductionForm::Compliance, 0);
            } else {
                let served = |link: &Link| {
                    link.assembly.hinges().is_some() || link.assembly.has(ReductionForm::Stiffness)
                };
                if !links.iter().all(served) {
                    return None;
                }
                builder.eliminate(&links, segment.terminals)?;
            }
        }
        if has_braced {
            let fresh = builder.begins(0);
            builder.schedule.ops.push(Op::Brace { into: 0, fresh });
        }
        Some(builder.schedule)
    }

    fn slot(&mut self) -> Slot {
        self.schedule.slot_count += 1;
        self.schedule.slot_count - 1
    }

    /// Whether a slot is written for the first time.
    fn begins(&mut self, slot: Slot) -> bool {
        self.begun.insert(slot)
    }

    /// Adds an assembly to a slot as compliance or stiffness.
    fn evaluate(&mut self, assembly: &SeriesParallel, form: ReductionForm, into: Slot) {
        let (parts, own) = match assembly {
            SeriesParallel::Piece(piece) => {
                let (piece, fresh) = (*piece, self.begins(into));
                self.schedule.ops.push(Op::Piece {
                    piece,
                    form,
                    into,
                    fresh,
                });
                return;
            }
            SeriesParallel::Series(parts) => (parts, ReductionForm::Compliance),
            SeriesParallel::Parallel(parts) => (parts, ReductionForm::Stiffness),
        };
        if own == form {
            for part in parts {
                self.evaluate(part, form, into);
            }
            return;
        }
        let sum = self.slot();
        for part in parts {
            self.evaluate(part, own, sum);
        }
        self.invert(sum, into);
    }

    fn invert(&mut self, from: Slot, into: Slot) {
        let fresh = self.begins(into);
        self.schedule.ops.push(Op::Invert { from, into, fresh });
    }

    /// Assembles the links of a segment and eliminates all vertices but the far terminal; the near one is held.
    ///
    /// A vertex that hangs on another by hinges alone is joined to it once they are eased.
    fn eliminate(&mut self, links: &[Link], [near, far]: [usize; 2]) -> Option<()> {
        let vertices: BTreeSet<usize> = links.iter().flat_map(|link| link.ends).collect();
        let count = vertices.last().map_or(0, |last| last + 1);
        let mut coupled = vec![BTreeSet::new(); count];
        for Link { ends: [a, b], .. } in links {
            coupled[*a].insert(*b);
            coupled[*b].insert(*a);
        }
        let present: Vec<bool> = (0..count)
            .map(|vertex| vertex != near && vertices.contains(&vertex))
            .collect();
        let joins = joins(links, [near, far])?;
        let order = elimination_order(coupled, &present, far, &joins);
        let place: BTreeMap<usize, usize> = order.iter().map(|e| e.block).zip(0..).collect();
        let diagonals: Vec<Slot> = order.iter().map(|_| self.slot()).collect();
        let mut panels = BTreeMap::new();
        for (row, Eliminated { neighbours, .. }) in order.iter().enumerate() {
            let mut columns: Vec<usize> = neighbours.iter().map(|n| place[n]).collect();
            columns.sort_unstable();
            for column in columns {
                panels.insert((row, column), self.slot());
            }
        }
        for link in links.iter().filter(|link| link.assembly.hinges().is_none()) {
            let stands = link.ends.map(|vertex| place.get(&vertex).copied());
            match stands {
                [Some(a), Some(b)] => {
                    let panel = panels[&(a.min(b), a.max(b))];
                    self.evaluate(&link.assembly, ReductionForm::Stiffness, panel);
                    for end in [a, b] {
                        let (into, from) = (diagonals[end], panel);
                        let fresh = self.begins(into);
                        self.schedule.ops.push(Op::Add { from, into, fresh });
                    }
                    self.schedule.ops.push(Op::Mirror { slot: panel });
                }
                [Some(end), None] | [None, Some(end)] => {
                    self.evaluate(&link.assembly, ReductionForm::Stiffness, diagonals[end]);
                }
                [None, None] => {}
            }
        }
        let mut joined: BTreeMap<usize, (Option<usize>, Vec<usize>)> = BTreeMap::new();
        for (vertex, (other, hinges)) in joins {
            joined.insert(place[&vertex], (place.get(&other).copied(), hinges));
        }
        self.sweep(&diagonals, &panels, &joined);
        self.invert(diagonals[diagonals.len() - 1], 0);
        Some(())
    }

    /// Block LDLᵀ of all diagonals but the last.
    ///
    /// # Arguments
    /// - `joined`: rows that hang on another by hinges: that row, and the hinges; without a row it is held.
    fn sweep(
        &mut self,
        diagonals: &[Slot],
        panels: &BTreeMap<(usize, usize), Slot>,
        joined: &BTreeMap<usize, (Option<usize>, Vec<usize>)>,
    ) {
        for (row, &diagonal) in diagonals[..diagonals.len() - 1].iter().enumerate() {
            let own: Vec<(usize, Slot)> = panels
                .range((row, 0)..(row + 1, 0))
                .map(|(&(_, column), &slot)| (column, slot))
                .collect();
            if let Some((other, hinges)) = joined.get(&row) {
                self.join(row, *other, hinges, (diagonals, panels), &own);
                continue;
            }
            let updates = self.updates(&own, diagonals, panels);
            self.schedule.widest = self.schedule.widest.max(own.len());
            self.schedule.ops.push(Op::Eliminate {
                diagonal,
                panels: own.iter().map(|&(_, slot)| slot).collect(),
                updates,
            });
        }
    }

    /// What an elimination does to the couplings of all pairs of neighbours.
    fn updates(
        &mut self,
        own: &[(usize, Slot)],
        diagonals: &[Slot],
        panels: &BTreeMap<(usize, usize), Slot>,
    ) -> Vec<Update> {
        let mut updates = Vec::new();
        for (rows, &(first, _)) in own.iter().enumerate() {
            for (columns, &(second, _)) in own.iter().enumerate().skip(rows) {
                let on_diagonal = first == second;
                let target = if on_diagonal {
                    diagonals[first]
                } else {
                    panels[&(first, second)]
                };
                updates.push(Update {
                    rows,
                    columns,
                    target,
                    on_diagonal,
                    fresh: self.begins(target),
                });
            }
        }
        updates
    }

    /// Eases the hinges of a row and joins it to another.
    fn join(
        &mut self,
        row: usize,
        other: Option<usize>,
        hinges: &[usize],
        (diagonals, panels): (&[Slot], &BTreeMap<(usize, usize), Slot>),
        own: &[(usize, Slot)],
    ) {
        // A neighbour by the hinges alone has a panel with nothing in it.
        let own: Vec<(usize, Slot)> = own
            .iter()
            .copied()
            .filter(|(_, panel)| self.begun.contains(panel))
            .collect();
        let updates = self.updates(&own, diagonals, panels);
        self.schedule.widest = self.schedule.widest.max(own.len());
        self.schedule.ops.push(Op::Ease {
            hinges: hinges.to_vec(),
            diagonal: diagonals[row],
            panels: own.iter().map(|&(_, slot)| slot).collect(),
            updates,
            neighbours: own.iter().map(|&(column, _)| diagonals[column]).collect(),
        });
        let mut moves = Vec::new();
        if let Some(other) = other {
            for &(column, from) in own.iter().filter(|(column, _)| *column != other) {
                let into = panels[&(other.min(column), other.max(column))];
                moves.push(PanelMove {
                    from,
                    into,
                    transposed: column < other,
                    fresh: self.begins(into),
                });
            }
        }
        let between = own.iter().find(|(column, _)| Some(*column) == other);
        let into = other.map(|other| Joined {
            diagonal: diagonals[other],
            fresh: self.begins(diagonals[other]),
            between: between.map(|(_, slot)| *slot),
        });
        self.schedule.ops.push(Op::Join {
            diagonal: diagonals[row],
            into,
            moves,
        });
    }
}

/// A vertex, and the one that it hangs on by hinges with these.
type Join = (usize, (usize, Vec<usize>));

/// Which vertices hang on another by hinges: each with that vertex and the hinges, in the order in which they are joined.
///
/// `None` if hinges alone close a loop or lead from one terminal to the other.
fn joins(links: &[Link], [near, far]: [usize; 2]) -> Option<Vec<Join>> {
    let hinged = links.iter().filter_map(|link| {
        let hinges = link.assembly.hinges()?;
        Some((link.ends, hinges))
    });
    let mut open: Vec<([usize; 2], Vec<usize>)> = hinged.collect();
    let mut joins = Vec::new();
    while !open.is_empty() {
        // A vertex with one such link left.
        let count = |vertex: usize| {
            open.iter()
                .filter(|(ends, _)| ends.contains(&vertex))
                .count()
        };
        let is_leaf = |vertex: usize| vertex != near && vertex != far && count(vertex) == 1;
        let found = open.iter().enumerate().find_map(|(place, (ends, _))| {
            let side = ends.iter().position(|&vertex| is_leaf(vertex))?;
            Some((place, ends[side], ends[1 - side]))
        });
        let (place, vertex, other) = found?;
        let (_, hinges) = open.remove(place);
        joins.push((vertex, (other, hinges)));
    }
    Some(joins)
}

/// Vertices in order of least degree, the far terminal last, and each that is joined before the one it is joined to.
fn elimination_order(
    coupled: Vec<BTreeSet<usize>>,
    present: &[bool],
    far: usize,
    joins: &[Join],
) -> Vec<Eliminated> {
    if joins.is_empty() {
        return minimum_degree_before(coupled, present, &[far]);
    }
    // Those that are joined first, in their order; then the rest.
    let first: Vec<usize> = joins.iter().map(|(vertex, _)| *vertex).collect();
    let rest = minimum_degree_before(coupled.clone(), present, &[far]);
    let rest = rest.into_iter().map(|eliminated| eliminated.block);
    let rest = rest.filter(|block| !first.contains(block));
    let last: Vec<usize> = first.iter().copied().chain(rest).collect();
    minimum_degree_before(coupled, present, &last)
}
