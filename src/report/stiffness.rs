//! Measured stiffness for people.

use indexmap::IndexSet;

use stiffbench_document::Document;

use crate::quantity::NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE as N_PER_UM;
use crate::statistics::Estimate;
use crate::stiffness::{
    BudgetRow, CellStiffness, Flag, Method, NoStiffness, PooledScatter, RowUse, StiffnessEstimate,
    StiffnessTable,
};

use super::text::{or_dash, significant, value_and_u};
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
    let rows = table.cells.iter().map(|cell| {
        let methods = [Method::Regression, Method::PaperMean];
        (cell, methods.map(|method| columns(cell.by(method))))
    });
    document.rows(
        rows,
        &[
            ("pose", &|(row, _)| row.cell.pose.to_string()),
            ("direction", &|(row, _)| row.cell.direction.to_string()),
            ("runs", &|(row, _)| row.n_runs.to_string()),
            ("K regression, N/µm", &|(row, [own, _])| {
                own[0].clone() + if is_in_doubt(row) { IN_DOUBT } else { "" }
            }),
            ("U", &|(_, [own, _])| own[1].clone()),
            ("k", &|(_, [own, _])| own[2].clone()),
            ("dof", &|(_, [own, _])| own[3].clone()),
            ("K mean of F/d, N/µm", &|(_, [_, paper])| paper[0].clone()),
            ("U", &|(_, [_, paper])| paper[1].clone()),
            ("k", &|(_, [_, paper])| paper[2].clone()),
            ("zero offset, µm", &|(row, _)| {
                or_dash(row.zero_offset_m(), |offset| {
                    format!("{:.1}", (offset.value * 1e7).round() / 10.0 + 0.0)
                })
            }),
        ],
    );
    document.paragraph(ABOUT_UNCERTAINTY);
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
    for skipped in &table.skipped {
        document.item(format!(
            "not in the table: {}: {}",
            skipped.cell, skipped.reason
        ));
    }
    if with_budget {
        add_budgets(&mut document, table);
    }
    document
}

/// What the columns of the table are.
const ABOUT_UNCERTAINTY: &str = "U is the expanded uncertainty for 95 %: k from Student's t with the effective degrees of freedom (dof). It includes scatter from run to run, resolution, and calibration as far as the session states it. K regression: 1/slope with a free intercept for each zero; K mean of F/d: the paper's mean of force over displacement.";

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

/// The flags of a cell, those of one rule in one line with their number.
pub(super) fn flag_lines(cell: &CellStiffness) -> Vec<String> {
    let rules: IndexSet<&str> = cell.flags.iter().map(Flag::rule).collect();
    let line = |rule: &str| {
        let mut of_rule = cell.flags.iter().filter(|flag| flag.rule() == rule);
        let first = of_rule.next()?;
        let place = match first {
            Flag::Outlier { place, .. } if place.line > 0 => {
                format!(", first in line {}", place.line)
            }
            _ => ", first".to_owned(),
        };
        Some(match 1 + of_rule.count() {
            1 => first.to_string(),
            n => format!("{n} of {rule}{place}: {first}"),
        })
    };
    rules.into_iter().filter_map(line).collect()
}

/// Value, U, k and dof of an estimate.
fn columns(result: Result<&StiffnessEstimate, NoStiffness>) -> [String; 4] {
    let Ok(StiffnessEstimate { estimate, .. }) = result else {
        return ["-"; 4].map(str::to_owned);
    };
    let expanded = estimate.expanded_95().map(|u| u / N_PER_UM);
    let [value, u] = value_and_u([Some(estimate.value / N_PER_UM), expanded], 5, "-");
    if u == "-" {
        return [value, u.clone(), u.clone(), u];
    }
    let k = or_dash(estimate.coverage_factor_95(), |k| format!("{k:.2}"));
    let dof = dof_with_k(estimate.dof).unwrap_or_else(|| "∞".to_owned());
    [value, u, k, dof]
}

/// Degrees of freedom that a coverage factor with two decimals goes with: whole numbers as they are, others with so many decimals, at
/// least one, that k of what is printed is the printed k. `None` for infinite ones.
pub(super) fn dof_with_k(dof: f64) -> Option<String> {
    let k = |dof| {
        let estimate = Estimate {
            value: 0.0,
            standard_uncertainty: 1.0,
            dof,
        };
        estimate.coverage_factor_95().map(|k| format!("{k:.2}"))
    };
    if !dof.is_finite() {
        return None;
    }
    // Sums leave a whole number off by their rounding.
    if (dof - dof.round()).abs() < 1e-9 * dof {
        return Some(format!("{dof:.0}"));
    }
    let agrees = |text: &String| text.parse().is_ok_and(|printed: f64| k(printed) == k(dof));
    // Beyond six decimals Student's quantile does not change in the digits that are printed, even close to one degree of freedom.
    let mut texts = (1..=6).map(|decimals| format!("{dof:.decimals$}"));
    texts.find(agrees).or_else(|| Some(format!("{dof:.6}")))
}

/// Uncertainty budgets of the regression stiffness.
fn add_budgets(document: &mut Document, table: &StiffnessTable) {
    let contribution = |row: &&BudgetRow| match row.standing {
        RowUse::Counted => significant(row.contribution_n_per_m / N_PER_UM, 3),
        RowUse::InRepeatability => "in repeatability".to_owned(),
        RowUse::NotStated => "not stated".to_owned(),
        RowUse::NoEffect => "no effect".to_owned(),
    };
    for cell in &table.cells {
        let Ok(found) = cell.by(Method::Regression) else {
            continue;
        };
        document.paragraph(format!(
            "Budget of {} (K by regression, standard uncertainties):",
            cell.cell
        ));
        document.rows(
            &found.budget.rows,
            &[
                ("source", &|row| row.source.to_string()),
                ("type", &|row| format!("{:?}", row.evaluation)),
                ("distribution", &|row| {
                    format!("{:?}", row.distribution).to_lowercase()
                }),
                ("contribution, N/µm", &contribution),
                ("dof", &|row| match row.dof {
                    f64::INFINITY => "∞".to_owned(),
                    dof => significant(dof, 3),
                }),
                ("share, %", &|row| format!("{:.1}", row.share_percent)),
            ],
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::student_t_quantile;

    #[test]
    fn the_printed_degrees_of_freedom_have_the_printed_k() {
        let k = |dof: f64| format!("{:.2}", student_t_quantile(0.975, dof).unwrap());
        for step in 0..4000 {
            let dof = 1.0 + 0.0137 * f64::from(step);
            let printed = dof_with_k(dof).unwrap();
            assert_eq!(k(printed.parse().unwrap()), k(dof), "{dof}: {printed}");
        }
        assert_eq!(dof_with_k(4.0).unwrap(), "4");
        assert_eq!(dof_with_k(4.6).unwrap(), "4.6");
        assert_eq!(dof_with_k(f64::INFINITY), None);
    }
}
