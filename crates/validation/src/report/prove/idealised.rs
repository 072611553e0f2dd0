//! Standard errors on real baselines beside the idealised ones.

use schemars::JsonSchema;
use serde::Serialize;

use crate::prove::{ErrorRow, PlaceErrors};
use stiffbench::mismatch::DesignReport;
use stiffbench::physics::Law;
use stiffbench::quantity::METRES_PER_MICROMETRE;
use stiffbench::report::Table;

fn um(length_m: f64) -> f64 {
    length_m / METRES_PER_MICROMETRE
}

/// The table: smallest, middle and largest over the places of a law.
#[must_use]
pub fn idealised_text(benches: &[String], plans: &[DesignReport], rows: &[ErrorRow]) -> String {
    let of_plan = |plan: &Option<PlaceErrors>| match plan {
        None => "not shown".to_owned(),
        Some(found) if found.places == 1 => format!("{:.2}", um(found.error_m[0])),
        Some(found) => {
            let [least, middle, most] = found.error_m.map(um);
            format!("{least:.2} to {most:.2}, middle {middle:.2}")
        }
    };
    let table = Table::of(rows)
        .words("law", |row| row.law.name)
        .numbers("idealised bench, um", |row| {
            format!("{:.2}", um(row.idealised_m))
        })
        .numbers_each(benches.iter().map(|bench| format!("{bench}, um")), |row| {
            row.plans.iter().map(of_plan).collect::<Vec<_>>()
        });
    let readings: Vec<String> = plans
        .iter()
        .map(|plan| format!("{} readings by {}", plan.readings, plan.procedure))
        .collect();
    format!(
        "Standard errors of the laws as the largest change of a reading, beside those of an idealised bench of the same plan ({}), with a\ndial gauge of 10 um read to 6 um. The idealised bench has three factors with random patterns and known noise and shapes.\n\n{}\n",
        readings.join("; "),
        table.text()
    )
}

/// A law's standard errors, for programs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct IdealisedErrors {
    /// The law.
    pub physics: Law,
    /// Standard error on the idealised bench, µm.
    pub idealised_um: f64,
    /// Under each plan.
    pub plans: Vec<ErrorsOfPlan>,
}

/// A law's standard errors under one plan.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ErrorsOfPlan {
    /// The mechanism.
    pub bench: String,
    /// Places that show the law.
    pub places: usize,
    /// Smallest, middle and largest over these places, µm; `null` without such a place.
    pub standard_error_um: Option<[f64; 3]>,
}

impl IdealisedErrors {
    /// Each law under the plans of these benches.
    #[must_use]
    pub fn all(benches: &[String], rows: &[ErrorRow]) -> Vec<Self> {
        let plan = |(plan, bench): (&Option<PlaceErrors>, &String)| ErrorsOfPlan {
            bench: bench.clone(),
            places: plan.map_or(0, |plan| plan.places),
            standard_error_um: plan.map(|plan| plan.error_m.map(um)),
        };
        rows.iter()
            .map(|row| Self {
                physics: row.law,
                idealised_um: um(row.idealised_m),
                plans: row.plans.iter().zip(benches).map(plan).collect(),
            })
            .collect()
    }
}
