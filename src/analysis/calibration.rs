//! Calibrations of gauges that are given beside a session.

use crate::calibration::CalibrationCurve;
use crate::quantity::METRES_PER_MICROMETRE;
use crate::readings::{InstrumentRecord, Instruments, ReadingTable, SessionHeader};

use super::error::ArgumentError;
use crate::count::counted;
use crate::mismatch::StatedScatter;

/// Coverage factor of expanded uncertainties that the command line states (GUM 6.3.3).
const K: f64 = 2.0;

/// What is stated of the errors of a gauge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StatedError {
    /// Expanded uncertainty for k = 2, N or m.
    Expanded(f64),
    /// LimitsOfError of error on both sides of zero, N or m, within which every value is as likely.
    LimitsOfError(f64),
}

impl StatedError {
    /// Standard uncertainty, N or m (GUM 4.3.7 of limits).
    fn standard_uncertainty(self) -> f64 {
        match self {
            Self::Expanded(u) => u / K,
            Self::LimitsOfError(limit) => limit / f64::sqrt(3.0),
        }
    }
}

/// What is given of one gauge; what is absent stays as the session states it.
#[derive(Debug, Clone, Default)]
pub struct GaugeCalibration {
    /// What is stated of its errors, with the option that states it.
    pub error: Option<(StatedError, String)>,
    /// Curve that corrects the readings, with the option that states it.
    pub curve: Option<(CalibrationCurve, String)>,
}

/// What is given of the gauges.
#[derive(Debug, Clone, Default)]
pub struct GivenCalibration {
    /// The force gauge.
    pub force: GaugeCalibration,
    /// The displacement gauge.
    pub displacement: GaugeCalibration,
    /// Instrument records that take the place of those of the session, with the file.
    pub records: Option<(Instruments, String)>,
}

/// A gauge, for words.
struct GaugeWords {
    name: &'static str,
    unit: &'static str,
    si_per_unit: f64,
}

const FORCE: GaugeWords = GaugeWords {
    name: "force gauge",
    unit: "N",
    si_per_unit: 1.0,
};

const DISPLACEMENT: GaugeWords = GaugeWords {
    name: "displacement gauge",
    unit: "um",
    si_per_unit: METRES_PER_MICROMETRE,
};

impl GivenCalibration {
    /// Whether nothing is given.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        let gauges = [&self.force, &self.displacement];
        let none = |gauge: &&GaugeCalibration| gauge.error.is_none() && gauge.curve.is_none();
        self.records.is_none() && gauges.iter().all(none)
    }

    /// What is stated of the errors of both gauges as the scatter of load cases: these have no cell whose budget it could enter.
    ///
    /// # Errors
    /// If it is stated of the force alone, or is zero, and if more than errors is given.
    pub(super) fn scatter(&self, data: &str) -> Result<Option<StatedScatter>, ArgumentError> {
        let mut rest = self.clone();
        let force = rest.force.error.take();
        let displacement = rest.displacement.error.take();
        rest.refuse(data)?;
        let sd = |(error, _): (StatedError, String)| error.standard_uncertainty();
        let force_sd_n = force.map(sd);
        match displacement.map(sd) {
            Some(0.0) => ArgumentError::refuse(
                "--displacement-u",
                "with a scatter of zero no reading could be off",
                "state how far the gauge repeats, at least its step",
            ),
            Some(displacement_sd_m) => Ok(Some(StatedScatter {
                displacement_sd_m,
                force_sd_n,
            })),
            None if force_sd_n.is_some() => ArgumentError::refuse(
                "--force-u",
                "of load cases the scatter of force and displacement is stated together",
                "state --displacement-u too",
            ),
            None => Ok(None),
        }
    }

    /// Refuses calibrations beside data that have no gauge along the load.
    ///
    /// # Errors
    /// If any is given.
    pub fn refuse(&self, data: &str) -> Result<(), ArgumentError> {
        if self.is_empty() {
            return Ok(());
        }
        Err(ArgumentError::new(
            "--force-u, --displacement-u, --force-calibration, --displacement-calibration, --instrument-records",
            format!("{data} has no single displacement gauge along the load"),
            "leave them out",
        ))
    }

    /// Corrects the readings and states the uncertainties; returns what was done, in words.
    pub(super) fn apply(
        &self,
        table: &mut ReadingTable,
        header: &mut Option<SessionHeader>,
        warnings: &mut Vec<String>,
    ) -> Vec<String> {
        let mut done = Vec::new();
        if self.is_empty() {
            return done;
        }
        let header = header.get_or_insert_with(SessionHeader::default);
        if let Some((records, file)) = &self.records {
            header.instruments = records.clone();
            done.push(format!("instrument records of {file}"));
        }
        let instruments = &mut header.instruments;
        let gauges = [
            (&self.force, &mut instruments.force, FORCE),
            (
                &self.displacement,
                &mut instruments.displacement,
                DISPLACEMENT,
            ),
        ];
        for (side, (given, record, words)) in gauges.into_iter().enumerate() {
            if let Some((curve, source)) = &given.curve {
                let beyond = values(table, side).filter(|value| curve.is_beyond(*value));
                let beyond = beyond.count();
                let largest = correct(table, side, curve);
                done.push(format!(
                    "{} corrected by {source}, at most by {} {}",
                    words.name,
                    rounded(largest / words.si_per_unit),
                    words.unit
                ));
                if beyond > 0 {
                    warnings.push(format!(
                        "beyond the points of {source}, corrected along its last line: {} of the {}",
                        counted(beyond, "reading"),
                        words.name
                    ));
                }
                let error = StatedError::Expanded(K * curve.standard_uncertainty());
                done.push(state(record, error, &words, source));
            }
            if let Some((error, source)) = &given.error {
                done.push(state(record, *error, &words, source));
            }
        }
        done
    }
}

fn values(table: &ReadingTable, side: usize) -> impl Iterator<Item = f64> {
    let readings = table.readings.iter();
    readings.map(move |reading| [reading.force_n, reading.displacement_m][side])
}

/// Corrects the readings of a gauge, and returns the largest correction. The gauge's own texts stay.
fn correct(table: &mut ReadingTable, side: usize, curve: &CalibrationCurve) -> f64 {
    let mut largest = 0.0_f64;
    let are_planned = side == 0 && table.readings.iter().all(|one| one.force_n == one.target_n);
    for reading in &mut table.readings {
        let value = if side == 0 {
            &mut reading.force_n
        } else {
            &mut reading.displacement_m
        };
        let corrected = curve.corrected(*value);
        largest = largest.max((corrected - *value).abs());
        *value = corrected;
        // Dead weights, or forces that were only planned, have no step of a display before and none after.
        if are_planned {
            reading.target_n = corrected;
        }
    }
    largest
}

/// Puts what is stated into the record of the gauge, and returns it in words.
fn state(
    record: &mut Option<InstrumentRecord>,
    error: StatedError,
    words: &GaugeWords,
    source: &str,
) -> String {
    let record = record.get_or_insert_with(InstrumentRecord::default);
    let GaugeWords {
        name,
        unit,
        si_per_unit,
    } = words;
    match error {
        StatedError::Expanded(expanded) => {
            record.expanded_uncertainty = Some(expanded);
            record.k = Some(K);
            let expanded = rounded(expanded / si_per_unit);
            format!("{name}: U = {expanded} {unit}, k = {K} ({source})")
        }
        StatedError::LimitsOfError(limit) => {
            let k = 3_f64.sqrt();
            record.expanded_uncertainty = Some(limit);
            record.k = Some(k);
            format!(
                "{name}: limits of error ±{} {unit}, rectangular, u = {} {unit} ({source})",
                rounded(limit / si_per_unit),
                rounded(limit / k / si_per_unit)
            )
        }
    }
}

/// Without the digits that only the conversion of units left.
fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}
