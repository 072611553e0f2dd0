//! False alarms and coverage.

use std::fmt::Write;

use schemars::JsonSchema;
use serde::Serialize;

use crate::prove::{CalibrationRow, FalseAlarm, Share, Variant};
use stiffbench::report::Table;
use stiffbench::search::{LAW_LEVEL, UNEXPLAINED_LEVEL};

use super::share_words;

/// False alarms in all, and the upper 95 % bound, that are promised.
const MOST: [f64; 2] = [0.05, 0.065];

/// Shares of all rows, or of one variant.
fn sums<'a>(rows: impl Iterator<Item = &'a CalibrationRow>) -> [Share; 2] {
    rows.fold([Share::default(); 2], |[alarms, factors], row| {
        [alarms.with(row.alarms), factors.with(row.factors)]
    })
}

/// Tables and every false alarm with its seed.
#[must_use]
pub fn calibration_text(rows: &[CalibrationRow]) -> String {
    let [all, _] = sums(rows.iter());
    let mut text = format!(
        "False alarms on {} benches with nothing missing; designed level {:.1} % (laws {:.1} %, structure left {:.1} %).\nAny verdict but nothing-missing or insufficient-data is an alarm.\n\n",
        all.trials,
        100.0 * (LAW_LEVEL + UNEXPLAINED_LEVEL),
        100.0 * LAW_LEVEL,
        100.0 * UNEXPLAINED_LEVEL
    );
    let mut counted: Vec<(String, &str, [Share; 2])> = Vec::new();
    for row in rows {
        let shares = [row.alarms, row.factors];
        counted.push((row.variant.to_string(), &row.bench, shares));
    }
    for variant in Variant::ALL {
        let of_variant = || rows.iter().filter(|row| row.variant == variant);
        if of_variant().count() > 1 {
            counted.push((variant.to_string(), "all", sums(of_variant())));
        }
    }
    counted.push(("all".to_owned(), "all", sums(rows.iter())));
    let upper = |alarms: &Share| {
        let upper = alarms.upper_95();
        upper.map_or_else(|| "-".to_owned(), |upper| format!("{:.1}", 100.0 * upper))
    };
    let table = Table::of(counted)
        .words("variant", |(variant, ..)| variant.clone())
        .words("bench", |(_, bench, _)| *bench)
        .numbers_each(["alarms", "%"], |(.., [alarms, _])| {
            let [hits, percent, _] = share_words(alarms);
            [hits, percent]
        })
        .numbers("upper 95 %", |(.., [alarms, _])| upper(alarms))
        .numbers_each(
            ["factors in intervals", "%", "95 % interval"],
            |(.., [_, factors])| share_words(factors),
        );
    text.push_str(&table.text());
    let [share, upper] = MOST.map(|most| 100.0 * most);
    let kept = all.value().is_some_and(|value| value <= MOST[0])
        && all.upper_95().is_some_and(|upper| upper <= MOST[1]);
    let _ = writeln!(
        text,
        "\nPromised: at most {share:.0} %, upper 95 % bound at most {upper:.1} %: {}. Coverage of factors: 93 to 97 %.\n",
        if kept { "kept" } else { "NOT KEPT" }
    );
    for row in rows {
        for FalseAlarm { seed, said } in &row.false_alarms {
            let _ = writeln!(
                text,
                "- {}, {}, seed {seed}: {said}",
                row.variant, row.bench
            );
        }
    }
    text.push('\n');
    text
}

/// False alarms and coverage, for programs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct CalibrationReport {
    /// Chance of a false alarm by design.
    pub designed_level: f64,
    /// Trials in which something was found.
    pub alarms: Share,
    /// Identified factors inside their 95 % intervals.
    pub factors_in_intervals: Share,
    /// Each plan.
    pub rows: Vec<CalibrationRow>,
}

impl CalibrationReport {
    /// The sums of all plans, with each of them.
    #[must_use]
    pub fn new(rows: Vec<CalibrationRow>) -> Self {
        let [alarms, factors_in_intervals] = sums(rows.iter());
        Self {
            designed_level: LAW_LEVEL + UNEXPLAINED_LEVEL,
            alarms,
            factors_in_intervals,
            rows,
        }
    }
}
