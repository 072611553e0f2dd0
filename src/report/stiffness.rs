//! Measured stiffness for people.

use indexmap::IndexSet;

use stiffbench_document::{Document, Table};

use crate::quantity::NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE as N_PER_UM;
use crate::reported::Reported;
use crate::stiffness::{
    BudgetRow, CellStiffness, Flag, Method, PooledScatter, RowUse, StiffnessTable,
};

use super::hysteresis::hysteresis_document;
use super::text::{or_dash, significant, with_u};
use crate::count::{counted, degrees_of_freedom};

/// What stands behind a stiffness whose flags put it in doubt.
const IN_DOUBT: &str = " ?";

/// The table, its flags and what was left out.
#[must_use]
pub fn stiffness_document(table: &StiffnessTable, with_budget: bool) -> Document {
    let mut document = Document::new();
    let is_in_doubt = |cell: &CellStiffness| cell.flags.iter().any(Flag::spoils_stiffness);
    let in_doubt = table.cells.iter().filter(|cell| is_in_doubt(cell)).count();
    if in_doubt > 0 {
        let cells = counted(in_doubt, "cell");
        document.paragraph(format!(
            "K of {cells} is in doubt (?): the flags below give the reasons."
        ));
    }
    document.table(
        Table::of(&table.cells)
            .words("pose", |row| &row.cell.pose)
            .words("direction", |row| row.cell.direction)
            .numbers("runs", |row| row.n_runs)
            .numbers_each(["K regression, N/µm", "U", "k", "dof"], |row| {
                let [value, u, k, dof] = printed(&reported(row, Method::Regression));
                let doubt = if is_in_doubt(row) { IN_DOUBT } else { "" };
                [value + doubt, u, k, dof]
            })
            .numbers_each(["K mean of F/d, N/µm", "U", "k"], |row| {
                let [value, u, k, _] = printed(&reported(row, Method::PaperMean));
                [value, u, k]
            })
            .numbers("zero offset, µm", |row| {
                or_dash(row.zero_offset_m(), |offset| {
                    format!("{:.1}", (offset.value * 1e7).round() / 10.0 + 0.0)
                })
            }),
    );
    let has_scatter = |cell: &CellStiffness| cell.n_runs > 1;
    document.paragraph(if table.cells.iter().any(has_scatter) {
        ABOUT_UNCERTAINTY
    } else {
        WITHOUT_REPEATS
    });
    document.paragraph(scatter_words(table.pooled_scatter.as_ref()));
    for cell in &table.cells {
        for (name, result) in [
            ("regression", cell.by(Method::Regression)),
            ("mean of F/d", cell.by(Method::PaperMean)),
        ] {
            if let Err(reason) = result {
                document.item(format!("{}: no stiffness by {name}: {reason}", cell.cell));
            }
        }
        if is_without_scatter(cell) {
            document.item(format!(
                "{}: no uncertainty: the readings do not scatter ({}), and no step of the gauges is known",
                cell.cell,
                counted(cell.n_runs, "run")
            ));
        }
        for flag in flag_lines(cell) {
            document.item(format!("flag, {}: {flag}", cell.cell));
        }
    }
    for one in &table.skipped {
        document.item(format!("not in the table: {}: {}", one.cell, one.reason));
    }
    document.section("Hysteresis", loops_document(table));
    if with_budget {
        document.section("Uncertainty budget", budget_document(table));
    }
    document
}

/// The loops of the cells that were read in both branches.
pub(super) fn loops_document(table: &StiffnessTable) -> Document {
    let loops = table.cells.iter().filter_map(|row| {
        let [pose, direction] = [row.cell.pose.to_string(), row.cell.direction.to_string()];
        Some((pose, direction, row.hysteresis_report()?))
    });
    hysteresis_document(&loops.collect::<Vec<_>>())
}

/// What the columns of the table are.
const ABOUT_UNCERTAINTY: &str = "U is the expanded uncertainty for 95 %: k from Student's t with the effective degrees of freedom (dof), of which the table has whole numbers. It includes scatter from run to run, resolution, and calibration as far as the session states it. K regression: 1/slope with a free intercept for each zero; K mean of F/d: the paper's mean of force over displacement.";

/// What the columns of a table without repeats are.
const WITHOUT_REPEATS: &str = "No U: each pose and direction has one run, and nothing shows the scatter from run to run; two runs are the least, five are usual. K regression: 1/slope with a free intercept for each zero; K mean of F/d: the paper's mean of force over displacement.";

/// The scatter of single readings, and how far off one must be to be found.
fn scatter_words(pooled: Option<&PooledScatter>) -> String {
    let Some(pooled) = pooled else {
        return "The repeats are too few to find a single bad reading.".to_owned();
    };
    let found = match pooled.smallest_outliers_m {
        Some(ends) => {
            let [least, most] = ends.map(|m| significant(m * 1e6, 3));
            let beyond = if least == most {
                String::new()
            } else {
                format!(" in the best cell, from {most} µm in the worst")
            };
            format!(
                "is found in 80 % of cases from {least} µm off{beyond}, wherever it stands in its run"
            )
        }
        None => "may not be found, however far off: the repeats are too few, or show no scatter"
            .to_owned(),
    };
    format!(
        "Scatter of one reading within its run, pooled over all cells ({2}): {0:.2} µm, plus {1:.3} N × compliance, because soft cells scatter more. A single bad reading that has repeats {found}.",
        pooled.displacement_sd_m * 1e6,
        pooled.force_sd_n,
        degrees_of_freedom(pooled.dof)
    )
}

/// Whether nothing is known of the uncertainty of the slope because no reading differs from its repeats.
fn is_without_scatter(cell: &CellStiffness) -> bool {
    let found = cell.by(Method::Regression);
    found.is_ok_and(|found| found.estimate.standard_uncertainty == 0.0)
}

/// The stiffness of a cell, N/µm.
pub(super) fn reported(cell: &CellStiffness, method: Method) -> Reported {
    match cell.by(method) {
        Ok(found) => Reported::from_estimate(&found.estimate, N_PER_UM, "N/um"),
        Err(reason) => Reported::missing("N/um", reason.to_string()),
    }
}

/// The flags of a cell, those of one rule in one line with their number.
pub(super) fn flag_lines(cell: &CellStiffness) -> Vec<String> {
    let rules: IndexSet<&str> = cell.flags.iter().map(|flag| flag.rule).collect();
    let line = |rule: &str| {
        let mut of_rule = cell.flags.iter().filter(|flag| flag.rule == rule);
        let first = of_rule.next()?;
        let place = match first.reading {
            Some(reading) if reading.line > 0 => format!(", first in line {}", reading.line),
            _ => ", first".to_owned(),
        };
        Some(match 1 + of_rule.count() {
            1 => first.to_string(),
            n => format!("{n} of {rule}{place}: {first}"),
        })
    };
    rules.into_iter().filter_map(line).collect()
}

/// Value, U, k and dof of a stiffness in N/µm, as printed.
pub(super) fn printed(stiffness: &Reported) -> [String; 4] {
    let [value, u] = with_u(stiffness, 5);
    if u == "-" {
        return [value, u.clone(), u.clone(), u];
    }
    let k = or_dash(stiffness.k, |k| format!("{k:.2}"));
    [value, u, k, whole_dof(stiffness.dof)]
}

/// Degrees of freedom, rounded down to whole ones (GUM, G.4.1); `None` are infinite.
fn whole_dof(dof: Option<f64>) -> String {
    // Student's k for 95 % is then within 0.0003 of that of the normal distribution.
    const INFINITE: f64 = 1e4;
    // Sums leave a whole number off by their rounding.
    let whole = dof.map(|dof| (dof * (1.0 + 1e-9)).floor());
    match whole.filter(|whole| *whole < INFINITE) {
        Some(whole) => format!("{whole:.0}"),
        None => "∞".to_owned(),
    }
}

/// Uncertainty budget of the stiffness by regression: a row for each cell, a column for each source that counts in any; why the others do not.
pub(super) fn budget_document(table: &StiffnessTable) -> Document {
    let found = table.cells.iter();
    let found = found.filter_map(|row| Some((row, row.by(Method::Regression).ok()?)));
    let found: Vec<_> = found.collect();
    let Some((_, first)) = found.first() else {
        return Document::new();
    };
    let counts = |place: &usize| {
        let mut rows = found
            .iter()
            .filter_map(|(_, one)| one.budget.rows.get(*place));
        rows.any(|row| row.standing == RowUse::Counted)
    };
    let (counted, others): (Vec<usize>, Vec<usize>) =
        (0..first.budget.rows.len()).partition(counts);
    let sources = counted.iter().map(|place| {
        let row = &first.budget.rows[*place];
        let distribution = format!("{:?}", row.distribution).to_lowercase();
        format!("{} ({:?}, {distribution})", row.source, row.evaluation)
    });
    let mut document = Document::of(
        "Standard uncertainties of K by regression in N/µm, in parentheses the share of the variance. A: from the scatter of readings; B: from other knowledge.",
    );
    document.table(
        Table::of(&found)
            .words("pose, direction", |(row, _)| &row.cell)
            .numbers_each(sources, |(_, one)| {
                let own = counted
                    .iter()
                    .filter_map(|place| one.budget.rows.get(*place));
                own.map(contribution).collect::<Vec<_>>()
            })
            .numbers("combined", |(_, one)| {
                significant(one.estimate.standard_uncertainty / N_PER_UM, 3)
            })
            .numbers("dof", |(_, one)| whole_dof(Some(one.estimate.dof))),
    );
    for place in others {
        let row = &first.budget.rows[place];
        document.pair(row.source.to_string(), use_words(row.standing));
    }
    document
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
            assert_eq!(whole_dof(Some(dof)), words);
        }
    }
}
