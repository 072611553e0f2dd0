//! Joint values in columns: rows with the same values are one pose.

use super::draft::ImportDraft;
use super::joint_unit::joint_unit;
use super::values::{bad_value, no_value};
use crate::readings::{JointColumn, PoseJoints, TableError};
use stiffbench_units_and_text::test_point::PoseId;

/// Values of a joint within this of each other are the same: encoders of robots show less, rad or m.
const SAME: f64 = 2e-4;

/// Poses by joint values, in the order in which they appear.
#[derive(Debug, Default)]
pub(super) struct JointPoses {
    pub(super) poses: Vec<PoseJoints>,
    pub(super) are_guessed_degrees: bool,
}

impl JointPoses {
    /// The pose of each row; `None` without columns of joint values. Without names they become Q1, Q2, …: robot files call theirs P1, P2, ….
    ///
    /// # Errors
    /// For a cell that is no number, a row without one, and a pose with two sets of values.
    pub(super) fn of_rows(
        draft: &ImportDraft,
        rows: &[usize],
        names: Option<&[String]>,
    ) -> Result<Option<(Self, Vec<PoseId>)>, TableError> {
        let mut columns = Vec::new();
        let mut poses = Self::default();
        for (variable, index) in draft.found.joints() {
            let Some(unit) = joint_unit((&draft.table, &draft.mapping, &draft.found), index) else {
                continue;
            };
            poses.are_guessed_degrees |= unit.is_guessed;
            let column = JointColumn {
                variable: variable.to_owned(),
                unit: unit.unit,
            };
            columns.push((column, index, unit.conversion));
        }
        if columns.is_empty() {
            return Ok(None);
        }
        let mut of_rows = Vec::new();
        for (place, row) in rows.iter().enumerate() {
            let mut values = Vec::new();
            for (column, index, conversion) in &columns {
                let value = draft.table.number(*row, *index, *conversion)?;
                let Some(value) = value else {
                    return Err(no_value(draft, *row, *index));
                };
                values.push((column.clone(), value));
            }
            let name = names.map(|names| names[place].as_str());
            of_rows.push(poses.pose(draft, *row, columns[0].1, values, name)?);
        }
        Ok(Some((poses, of_rows)))
    }

    fn pose(
        &mut self,
        draft: &ImportDraft,
        row: usize,
        column: usize,
        values: Vec<(JointColumn, f64)>,
        name: Option<&str>,
    ) -> Result<PoseId, TableError> {
        let same = |known: &PoseJoints| {
            let pairs = known.values.iter().zip(&values);
            pairs
                .into_iter()
                .all(|((_, a), (_, b))| (a - b).abs() < SAME)
        };
        let named = name.map(PoseId::new);
        let is_it = |known: &&PoseJoints| match &named {
            Some(pose) => known.pose == *pose,
            None => same(known),
        };
        if let Some(known) = self.poses.iter().find(is_it) {
            if !same(known) {
                let cell = draft.table.cell(row, column);
                let expected = "the joint values of the other rows of this pose";
                return Err(bad_value(&cell, expected));
            }
            return Ok(known.pose.clone());
        }
        let next = self.poses.len() + 1;
        let pose = named.unwrap_or_else(|| PoseId::new(&format!("Q{next}")));
        self.poses.push(PoseJoints {
            pose: pose.clone(),
            values,
        });
        Ok(pose)
    }
}
