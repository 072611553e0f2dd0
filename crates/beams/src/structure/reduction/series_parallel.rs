//! Elements and hinges in series and side by side, merged until nothing of either is left; what remains is eliminated node by node.

use std::collections::{BTreeMap, BTreeSet};

use super::graph::{Edge, GROUND, Segment};
use super::schedule::{Op, ReductionForm, Schedule, SchedulePiece, Slot, Update};
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
    links.iter().enumerate().find_map(|(place, link)| {
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
    /// `None` if a hinge is in series with nothing that bends.
    pub(super) fn build<'a>(segments: impl Iterator<Item = &'a Segment>) -> Option<Schedule> {
        let mut builder = Self {
            schedule: Schedule {
                slot_count: 1,
                ..Schedule::default()
            },
            begun: BTreeSet::new(),
        };
        for segment in segments {
            let links = merged(segment);
            let all_have = |form| links.iter().all(|link| link.assembly.has(form));
            if let [link] = &links[..] {
                if !all_have(ReductionForm::Compliance) {
                    return None;
                }
                builder.evaluate(&link.assembly, ReductionForm::Compliance, 0);
            } else {
                if !all_have(ReductionForm::Stiffness) {
                    return None;
                }
                builder.eliminate(&links, segment.terminals);
            }
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
    fn eliminate(&mut self, links: &[Link], [near, far]: [usize; 2]) {
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
        let order = minimum_degree_before(coupled, &present, &[far]);
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
        for link in links {
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
        self.sweep(&diagonals, &panels);
        self.invert(diagonals[diagonals.len() - 1], 0);
    }

    /// Block LDLᵀ of all diagonals but the last.
    fn sweep(&mut self, diagonals: &[Slot], panels: &BTreeMap<(usize, usize), Slot>) {
        for (row, &diagonal) in diagonals[..diagonals.len() - 1].iter().enumerate() {
            let own: Vec<(usize, Slot)> = panels
                .range((row, 0)..(row + 1, 0))
                .map(|(&(_, column), &slot)| (column, slot))
                .collect();
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
            self.schedule.widest = self.schedule.widest.max(own.len());
            self.schedule.ops.push(Op::Eliminate {
                diagonal,
                panels: own.iter().map(|&(_, slot)| slot).collect(),
                updates,
            });
        }
    }
}
