//! Standard errors on real baselines beside the idealised ones.

use crate::prove::{ErrorsOfPlan, IdealisedErrors};
use stiffbench::mismatch::DesignReport;
use stiffbench::report::Table;

/// The table: smallest, middle and largest over the places of a law.
#[must_use]
pub fn idealised_text(plans: &[(String, DesignReport)], rows: &[IdealisedErrors]) -> String {
    let of_plan = |plan: &ErrorsOfPlan| match plan.standard_error_um {
        None => "not shown".to_owned(),
        Some([only, ..]) if plan.places == 1 => format!("{only:.2}"),
        Some([least, middle, most]) => format!("{least:.2} to {most:.2}, middle {middle:.2}"),
    };
    let benches = plans.iter().map(|(bench, _)| format!("{bench}, um"));
    let table = Table::of(rows)
        .words("law", |row| row.physics.name)
        .numbers("idealised bench, um", |row| {
            format!("{:.2}", row.idealised_um)
        })
        .numbers_each(benches, |row| {
            row.plans.iter().map(of_plan).collect::<Vec<_>>()
        });
    let readings: Vec<String> = plans
        .iter()
        .map(|(_, plan)| format!("{} readings by {}", plan.readings, plan.procedure))
        .collect();
    format!(
        "Standard errors of the laws as the largest change of a reading, beside those of an idealised bench of the same plan ({}), with a\ndial gauge of 10 um read to 6 um. The idealised bench has three factors with random patterns and known noise and shapes.\n\n{}\n",
        readings.join("; "),
        table.text()
    )
}
