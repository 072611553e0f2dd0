//! Readings sorted out: by cell, and those that do not count.

use std::collections::HashMap;

use crate::readings::{Reading, ReadingStatus};
use stiffbench_units_and_text::test_point::{Cell, PoseId};

/// Readings that no stiffness rests on, by reason.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LeftOut {
    /// Taken again later.
    pub superseded: usize,
    /// Refused by the operator or a rule.
    pub rejected: usize,
    /// Later readings of a step that has one already (holds).
    pub later_in_step: usize,
    /// Of a branch that was not asked for; the checks of the zero use them.
    pub other_branch: usize,
    /// Sequence numbers of accepted readings whose target, force or displacement is not a finite number.
    pub not_finite: Vec<u32>,
}

/// The readings of one cell.
pub(super) struct Group<'a> {
    pub(super) cell: Cell,
    /// Accepted, with finite numbers.
    pub(super) usable: Vec<&'a Reading>,
    /// All of them.
    pub(super) n_readings: usize,
}

/// Readings by cell, cells in the order of their first reading.
pub(super) fn group_by_cell(readings: &[Reading]) -> (Vec<Group<'_>>, LeftOut) {
    let mut groups: Vec<Group<'_>> = Vec::new();
    let mut left_out = LeftOut::default();
    let mut places: HashMap<&PoseId, [Option<usize>; 3]> = HashMap::new();
    // Readings of one cell mostly follow one another, so the last place is tried before the map.
    let mut last: Option<(&PoseId, [Option<usize>; 3])> = None;
    for reading in readings {
        let axis = reading.direction.index();
        let remembered = last
            .filter(|(pose, _)| **pose == reading.pose)
            .and_then(|(_, places)| places[axis]);
        let place = remembered.unwrap_or_else(|| {
            let of_pose = places.entry(&reading.pose).or_default();
            let place = *of_pose[axis].get_or_insert_with(|| {
                groups.push(Group {
                    cell: reading.cell(),
                    usable: Vec::new(),
                    n_readings: 0,
                });
                groups.len() - 1
            });
            last = Some((&reading.pose, *of_pose));
            place
        });
        let group = &mut groups[place];
        group.n_readings += 1;
        let numbers = [reading.target_n, reading.force_n, reading.displacement_m];
        match reading.status {
            ReadingStatus::Superseded => left_out.superseded += 1,
            ReadingStatus::Rejected => left_out.rejected += 1,
            ReadingStatus::Accepted if numbers.iter().all(|n| n.is_finite()) => {
                group.usable.push(reading);
            }
            ReadingStatus::Accepted => left_out.not_finite.push(reading.seq),
        }
    }
    (groups, left_out)
}
