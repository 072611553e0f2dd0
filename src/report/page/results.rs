//! The stiffness of poses and directions as a report states it.

use stiffbench_document::{Document, Table};

use crate::report::stiffness::{printed, reported};
use crate::report::{VectorStiffnessCell, significant};
use crate::reported::Reported;
use crate::stiffness::{CellStiffness, Flag, Method};

/// The stiffness of a pose and direction.
#[derive(Debug, Clone, PartialEq)]
pub struct PageCell {
    /// The pose.
    pub pose: String,
    /// The direction.
    pub direction: String,
    /// Number of runs.
    pub runs: usize,
    /// Its stiffness, N/µm.
    pub stiffness: Reported,
    /// Why there is no stiffness or no uncertainty, or why it is in doubt.
    pub reason: Option<String>,
}

impl From<&CellStiffness> for PageCell {
    fn from(cell: &CellStiffness) -> Self {
        let stiffness = reported(cell, Method::Regression);
        let reason = match cell.by(Method::Regression) {
            Err(reason) => Some(reason.to_string()),
            Ok(found) if stiffness.expanded_uncertainty.is_none() => {
                Some(format!("no uncertainty: {}", found.basis))
            }
            Ok(_) => {
                let spoils = cell.flags.iter().find(|flag| Flag::spoils_stiffness(flag));
                spoils.map(|flag| format!("in doubt: {flag}"))
            }
        };
        Self {
            pose: cell.cell.pose.to_string(),
            direction: cell.cell.direction.to_string(),
            runs: cell.n_runs,
            stiffness,
            reason,
        }
    }
}

impl From<&VectorStiffnessCell> for PageCell {
    fn from(cell: &VectorStiffnessCell) -> Self {
        Self {
            pose: cell.pose.to_string(),
            direction: cell.direction.clone(),
            runs: cell.runs,
            stiffness: cell.stiffness.clone(),
            reason: cell.stiffness.reason.clone(),
        }
    }
}

impl PageCell {
    /// The stiffness with its uncertainty and unit.
    pub(super) fn words(&self) -> String {
        let [value, u, ..] = printed(&self.stiffness);
        // No line ends between a number and its unit.
        match (value.as_str(), u.as_str()) {
            ("-", _) => "no stiffness".to_owned(),
            (_, "-") => format!("{value}\u{a0}N/µm without an uncertainty"),
            _ => format!("({value} ± {u})\u{a0}N/µm"),
        }
    }

    /// The same with k and the name of the cell.
    pub(super) fn named_words(&self) -> String {
        let (words, [_, _, k, _]) = (self.words(), printed(&self.stiffness));
        let Self {
            pose, direction, ..
        } = self;
        if k == "-" {
            return format!("{words} ({pose} {direction})");
        }
        format!("{words}, k\u{a0}=\u{a0}{k} ({pose} {direction})")
    }
}

/// The table of cells, and what is to be known of some.
pub(super) fn cells_document(cells: &[PageCell]) -> Document {
    let percent = |cell: &&PageCell| {
        let Reported {
            value,
            expanded_uncertainty,
            ..
        } = cell.stiffness;
        let both = value.zip(expanded_uncertainty.filter(|u| *u > 0.0));
        let percent = both.map(|(value, u)| significant(100.0 * u / value.abs(), 2));
        percent.unwrap_or_else(|| "-".to_owned())
    };
    let mut document = Document::new();
    document.table(
        Table::of(cells)
            .words("pose", |cell| &cell.pose)
            .words("direction", |cell| &cell.direction)
            .numbers("runs", |cell| cell.runs)
            .numbers_each(["K, N/µm", "U, N/µm", "k", "dof"], |cell| {
                printed(&cell.stiffness)
            })
            .numbers("U/K, %", percent),
    );
    for cell in cells {
        if let Some(reason) = &cell.reason {
            document.item(format!("{} {}: {reason}", cell.pose, cell.direction));
        }
    }
    document
}
