//! What the model of a part predicts for a table.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_document::{Document, Table};

use crate::export::tidy::csv_of;
use crate::mismatch::PartModel;
use crate::specimen::SpecimenTable;

use super::text::{significant, unit_behind, with_unit};
use crate::count::counted;

/// Most rows that are shown where nothing was measured; a file has all.
const SHOWN: usize = 20;

/// Share of the range of the fit by which a value may lie outside it by rounding (1).
const BEYOND: f64 = 1e-6;

/// Predictions of the answers of a table, in the units of the model.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct PredictionReport {
    /// Unit of what was set.
    pub driver_unit: String,
    /// Unit of the answers.
    pub answer_unit: String,
    /// Half the width of the band: 95 % of the readings that were left out of the fit were not further off.
    pub band: f64,
    /// How many readings that were.
    pub band_readings: usize,
    /// Smallest and largest value that was set in the readings of the fit.
    pub range: [f64; 2],
    /// How many rows are set beyond that.
    pub beyond_range: usize,
    /// Each run, where the table holds the answers.
    pub runs: Vec<PredictedRun>,
    /// Each row.
    pub rows: Vec<PredictedRow>,
}

/// A run of a table beside its prediction.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct PredictedRun {
    /// Its name.
    pub run: String,
    /// Its configuration.
    pub configuration: String,
    /// Number of readings.
    pub readings: usize,
    /// Mean of measured less predicted: the zero of a run is not predicted.
    pub zero: f64,
    /// Root mean square of measured less predicted about that zero.
    pub rms: f64,
    /// Share of the readings within the band about that zero.
    pub within_band: f64,
}

/// A row of a table with its prediction.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct PredictedRow {
    /// Line of the file.
    pub line: u32,
    /// Its run.
    pub run: String,
    /// What was set.
    pub driver: f64,
    /// The predicted answer.
    pub predicted: f64,
    /// Lower end of the band.
    pub low: f64,
    /// Upper end of the band.
    pub high: f64,
    /// The measured answer, where the table has it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured: Option<f64>,
}

impl PredictionReport {
    /// Predictions beside the readings of a table.
    ///
    /// # Arguments
    /// - `predicted`: what the model predicts for each reading of the table, in SI units.
    #[must_use]
    pub fn new(model: &PartModel, table: &SpecimenTable, predicted: &[f64]) -> Self {
        let units = &model.units;
        let (load, answer) = (units.of_load(), units.of_answer());
        let band = answer.in_table(model.band.half_width);
        let range = model.range.map(|end| load.in_table(end));
        let row = |(reading, value): (&crate::specimen::SpecimenReading, &f64)| {
            let predicted = answer.in_table(*value);
            PredictedRow {
                line: reading.line,
                run: table.runs[reading.run as usize].label.clone(),
                driver: table.driver(reading) / load.si_per_unit,
                predicted,
                low: predicted - band,
                high: predicted + band,
                measured: table
                    .has_response
                    .then(|| table.answer(reading) / answer.si_per_unit),
            }
        };
        let rows: Vec<PredictedRow> = table.readings.iter().zip(predicted).map(row).collect();
        let mut report = Self {
            driver_unit: load.name,
            answer_unit: answer.name,
            band,
            band_readings: model.band.readings,
            range,
            beyond_range: 0,
            runs: runs(table, &rows, band),
            rows,
        };
        let beyond = |row: &&PredictedRow| report.is_beyond(row.driver);
        report.beyond_range = report.rows.iter().filter(beyond).count();
        report
    }

    /// In words.
    #[must_use]
    pub fn document(&self) -> Document {
        let number = |value: f64| significant(value, 5);
        let mut document = Document::of(format!(
            "{} predicted, ± {} (95 %, from {} left out of the fit; the zero of a run is not included).",
            counted(self.rows.len(), "reading"),
            number(self.band) + &unit_behind(&self.answer_unit),
            counted(self.band_readings, "reading")
        ));
        if self.beyond_range > 0 {
            let [low, high] = self.range.map(number);
            document.paragraph(format!(
                "Outside the range of the fit, {low} to {high}{}: {}; the band is not known there.",
                unit_behind(&self.driver_unit),
                counted(self.beyond_range, "row")
            ));
        }
        if self.runs.is_empty() {
            document.table(self.first_rows());
            let further = self.rows.len().saturating_sub(SHOWN);
            if further > 0 {
                document.paragraph(format!(
                    "And {}; --out FILE writes all.",
                    counted(further, "row")
                ));
            }
            return document;
        }
        let head = |what: &str| with_unit(what, &self.answer_unit);
        let (zero, rms) = (head("zero"), head("rms about it"));
        document.table(
            Table::of(&self.runs)
                .words("run", |run| &run.run)
                .words("configuration", |run| &run.configuration)
                .numbers("readings", |run| run.readings)
                .numbers(zero, |run| number(run.zero))
                .numbers(rms, |run| number(run.rms))
                .numbers("within the band", |run| {
                    format!("{:.0} %", 100.0 * run.within_band)
                }),
        );
        document
    }

    /// The first rows, with the ends of the band where it is known.
    fn first_rows(&self) -> Table {
        let number = |value: f64| significant(value, 5);
        let end = |row: &PredictedRow, value: f64| {
            if self.is_beyond(row.driver) {
                "-".to_owned()
            } else {
                number(value)
            }
        };
        let answer = |name: &str| with_unit(name, &self.answer_unit);
        Table::of(self.rows.iter().take(SHOWN))
            .numbers("line", |row| row.line)
            .words("run", |row| &row.run)
            .numbers(with_unit("set", &self.driver_unit), |row| {
                number(row.driver)
            })
            .numbers(answer("predicted"), |row| number(row.predicted))
            .numbers(answer("low"), |row| end(row, row.low))
            .numbers(answer("high"), |row| end(row, row.high))
            .into()
    }

    /// Whether a value was not set in the readings of the fit.
    fn is_beyond(&self, driver: f64) -> bool {
        let [low, high] = self.range;
        let slack = BEYOND * (high - low);
        driver < low - slack || driver > high + slack
    }

    /// As a table: comma, point, one row a reading, units in the names of the columns.
    #[must_use]
    pub fn csv(&self) -> String {
        let header = |name: &str, unit: &str| match unit {
            "1" => name.to_owned(),
            unit => format!("{name} ({unit})"),
        };
        let answer = |name: &str| header(name, &self.answer_unit);
        let heads = [
            "line".to_owned(),
            "run".to_owned(),
            header("driver", &self.driver_unit),
            answer("predicted"),
            answer("low"),
            answer("high"),
            answer("measured"),
        ];
        let rows = self.rows.iter().map(|row| {
            let numbers = [row.driver, row.predicted, row.low, row.high].map(Some);
            let numbers = numbers.into_iter().chain([row.measured]);
            let numbers = numbers.map(|one| one.map_or_else(String::new, |n| n.to_string()));
            let named = [row.line.to_string(), row.run.clone()];
            named.into_iter().chain(numbers).collect()
        });
        let rows: Vec<Vec<String>> = rows.collect();
        csv_of(heads.iter().map(String::as_str), &rows)
    }
}

fn runs(table: &SpecimenTable, rows: &[PredictedRow], band: f64) -> Vec<PredictedRun> {
    let of_run = |index: usize| {
        let own = table.readings.iter().zip(rows);
        let own = own.filter(|(reading, _)| reading.run as usize == index);
        let off: Vec<f64> = own
            .filter_map(|(_, row)| Some(row.measured? - row.predicted))
            .collect();
        if off.is_empty() {
            return None;
        }
        let count = off.len() as f64;
        let zero = off.iter().sum::<f64>() / count;
        let squares: f64 = off.iter().map(|off| (off - zero).powi(2)).sum();
        let within = off.iter().filter(|off| (*off - zero).abs() <= band).count();
        let run = &table.runs[index];
        Some(PredictedRun {
            run: run.label.clone(),
            configuration: table.configurations[run.configuration as usize].clone(),
            readings: off.len(),
            zero,
            rms: (squares / count).sqrt(),
            within_band: within as f64 / count,
        })
    };
    (0..table.runs.len()).filter_map(of_run).collect()
}
