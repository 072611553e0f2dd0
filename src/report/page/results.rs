//! The results of a session as printed: stiffness of every pose and direction, and its uncertainty budget.

use schemars::JsonSchema;
use serde::Serialize;

use crate::quantity::NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE as N_PER_UM;
use crate::report::text::value_and_u;
use crate::report::{VectorStiffnessCell, significant};
use crate::reported::Reported;
use crate::stiffness::{BudgetRow, CellStiffness, Method, RowUse, StiffnessTable};

use super::session::PageEntry;

/// The stiffness of a cell as printed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PageCell {
    /// The pose.
    pub pose: String,
    /// The direction.
    pub direction: String,
    /// Number of runs.
    pub runs: usize,
    /// Stiffness, N/µm; a dash where there is none.
    pub stiffness: String,
    /// Expanded uncertainty, N/µm; a dash where there is none.
    pub expanded: String,
    /// Coverage factor for 95 %.
    pub k: String,
    /// Effective degrees of freedom.
    pub dof: String,
    /// Expanded uncertainty in percent of the stiffness.
    pub percent: String,
    /// Why there is no stiffness or no uncertainty, or why it is in doubt.
    pub reason: Option<String>,
}

/// The uncertainty budget of a session as printed, standard uncertainties of K by regression.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub struct PageBudget {
    /// The sources that count in any cell.
    pub sources: Vec<PageBudgetSource>,
    /// The cells.
    pub rows: Vec<PageBudgetRow>,
    /// The other sources, and why they do not count.
    pub others: Vec<PageEntry>,
}

/// A source of uncertainty.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PageBudgetSource {
    /// What it is.
    pub name: String,
    /// Type A or B.
    pub evaluation: String,
    /// Assumed distribution.
    pub distribution: String,
}

/// The budget of a pose and direction.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PageBudgetRow {
    /// Pose and direction.
    pub cell: String,
    /// For each source the contribution, N/µm, with its share of the variance, or why there is none.
    pub contributions: Vec<String>,
    /// Combined standard uncertainty, N/µm.
    pub combined: String,
    /// Effective degrees of freedom.
    pub dof: String,
}

/// What stands where there is nothing.
const NONE: &str = "–";

/// The stiffness of a cell, N/µm.
fn reported(cell: &CellStiffness) -> Reported {
    match cell.by(Method::Regression) {
        Ok(found) => Reported::from_estimate(&found.estimate, N_PER_UM, "N/um"),
        Err(reason) => Reported::missing("N/um", reason.to_string()),
    }
}

impl From<&CellStiffness> for PageCell {
    fn from(cell: &CellStiffness) -> Self {
        let found = cell.by(Method::Regression);
        let stiffness = reported(cell);
        let is_known = stiffness.expanded_uncertainty.is_some();
        let known = found.as_ref().ok().filter(|_| is_known);
        let mut flags = cell.flags.iter();
        let reason = match &found {
            Err(reason) => Some(reason.to_string()),
            Ok(found) if !is_known => Some(format!("no uncertainty: {}", found.basis)),
            Ok(_) => {
                let spoils = flags.find(|flag| flag.spoils_stiffness());
                spoils.map(|flag| format!("in doubt: {flag}"))
            }
        };
        Self {
            pose: cell.cell.pose.to_string(),
            direction: cell.cell.direction.to_string(),
            runs: cell.n_runs,
            dof: known.map_or_else(|| NONE.to_owned(), |one| dof_words(one.estimate.dof)),
            reason,
            ..Self::of(&stiffness)
        }
    }
}

/// Degrees of freedom, rounded down to whole ones (GUM, G.4.1).
fn dof_words(dof: f64) -> String {
    // Student's k for 95 % is then within 0.0003 of that of the normal distribution.
    const INFINITE: f64 = 1e4;
    // Sums leave a whole number off by their rounding.
    let whole = (dof * (1.0 + 1e-9)).floor();
    if whole < INFINITE {
        format!("{whole:.0}")
    } else {
        "∞".to_owned()
    }
}

impl From<&VectorStiffnessCell> for PageCell {
    fn from(cell: &VectorStiffnessCell) -> Self {
        Self {
            pose: cell.pose.to_string(),
            direction: cell.direction.clone(),
            runs: cell.runs,
            ..Self::of(&cell.stiffness)
        }
    }
}

impl PageCell {
    /// The stiffness with its uncertainty and unit.
    pub(super) fn words(&self) -> String {
        let Self {
            stiffness,
            expanded,
            ..
        } = self;
        // No line ends between a number and its unit.
        match (stiffness.as_str(), expanded.as_str()) {
            (NONE, _) => "no stiffness".to_owned(),
            (_, NONE) => format!("{stiffness}\u{a0}N/µm without an uncertainty"),
            _ => format!("({stiffness} ± {expanded})\u{a0}N/µm"),
        }
    }

    /// A stiffness as printed, without the names of its cell.
    fn of(found: &Reported) -> Self {
        let none = || NONE.to_owned();
        let both = found.value.zip(found.expanded_uncertainty);
        let percent = both.map(|(value, expanded)| significant(100.0 * expanded / value.abs(), 2));
        let [stiffness, expanded] = value_and_u([found.value, found.expanded_uncertainty], 5, NONE);
        Self {
            pose: String::new(),
            direction: String::new(),
            runs: 0,
            stiffness,
            expanded,
            k: found.k.map_or_else(none, |k| format!("{k:.2}")),
            dof: found.dof.map_or_else(none, dof_words),
            percent: percent.unwrap_or_else(none),
            reason: found.reason.clone(),
        }
    }
}

impl From<&StiffnessTable> for PageBudget {
    fn from(table: &StiffnessTable) -> Self {
        let cells = table.cells.iter();
        let found: Vec<_> = cells
            .filter_map(|row| Some((row, row.by(Method::Regression).ok()?)))
            .collect();
        let Some((_, first)) = found.first() else {
            return Self::default();
        };
        let places = 0..first.budget.rows.len();
        let counts = |place: &usize| {
            let mut rows = found
                .iter()
                .filter_map(|(_, one)| one.budget.rows.get(*place));
            rows.any(|row| row.standing == RowUse::Counted)
        };
        let (counted, others): (Vec<usize>, Vec<usize>) = places.partition(counts);
        let sources = counted.iter().map(|place| &first.budget.rows[*place]);
        let rows = found.iter().map(|(row, one)| {
            let of_row = counted
                .iter()
                .filter_map(|place| one.budget.rows.get(*place));
            PageBudgetRow {
                cell: row.cell.to_string(),
                contributions: of_row.map(contribution).collect(),
                combined: significant(one.estimate.standard_uncertainty / N_PER_UM, 3),
                dof: dof_words(one.estimate.dof),
            }
        });
        let others = others.iter().map(|place| &first.budget.rows[*place]);
        Self {
            sources: sources
                .map(|row| PageBudgetSource {
                    name: row.source.to_string(),
                    evaluation: format!("{:?}", row.evaluation),
                    distribution: format!("{:?}", row.distribution).to_lowercase(),
                })
                .collect(),
            rows: rows.collect(),
            others: others
                .map(|row| PageEntry::new(row.source.to_string(), use_words(row.standing)))
                .collect(),
        }
    }
}

/// A contribution with its share, or why it does not count.
fn contribution(row: &BudgetRow) -> String {
    match row.standing {
        RowUse::Counted => format!(
            "{} ({:.1} %)",
            significant(row.contribution_n_per_m / N_PER_UM, 3),
            row.share_percent
        ),
        other => use_words(other).to_owned(),
    }
}

fn use_words(standing: RowUse) -> &'static str {
    match standing {
        RowUse::Counted => "counted",
        RowUse::InRepeatability => "shows in the repeatability, counted there",
        RowUse::NotStated => "not stated, not in U",
        RowUse::NoEffect => "no effect on K by regression",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_of_freedom_are_whole_or_infinite() {
        for (dof, words) in [
            (4.0 - 1e-12, "4"),
            (2.174, "2"),
            (11.9, "11"),
            (741_710.9, "∞"),
            (f64::INFINITY, "∞"),
        ] {
            assert_eq!(dof_words(dof), words);
        }
    }
}
