//! Several sessions diagnosed together: what each brings.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiffbench_document::{Document, Table};

use crate::analysis::{DiagnosisReport, SessionShare};
use crate::mismatch::LawAtPlace;
use crate::report::{micro, significant};

use super::phrases::listed;

/// One of several sessions that were diagnosed together.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SessionReport {
    /// What it is called in the names of poses.
    pub name: String,
    /// The data as they were named.
    pub data: String,
    /// Readings that were searched.
    pub readings: usize,
    /// Its runs.
    pub runs: usize,
    /// Readings that its repeats contradict.
    pub bad_readings: usize,
    /// Standard deviation of its readings, µm.
    pub reading_sd_um: f64,
    /// Standard deviation of its gauge zeros, µm.
    pub zero_sd_um: f64,
    /// Relative standard deviation of the slopes of its runs.
    pub run_slope_sd: f64,
    /// Growth of the scatter with the displacement, as a share of it; 0 without.
    pub growth_sd: f64,
    /// Correlation of the scatter of a reading with that of the one before it in its run; 0 without.
    pub correlation: f64,
    /// Between what an earlier diagnosis stored beside this session, of fewer sessions, could not decide.
    pub open_before: Vec<String>,
}

impl From<&SessionShare> for SessionReport {
    fn from(share: &SessionShare) -> Self {
        Self {
            name: share.name.clone(),
            data: share.data.clone(),
            readings: share.readings,
            runs: share.runs,
            bad_readings: share.bad_readings,
            reading_sd_um: micro(share.noise.reading_sd_m),
            zero_sd_um: micro(share.noise.zero_sd_m),
            run_slope_sd: share.noise.run_slope_sd,
            growth_sd: share.noise.growth_sd,
            correlation: share.noise.correlation,
            open_before: share
                .open_before
                .iter()
                .flat_map(|before| before.open.iter().map(ToString::to_string))
                .collect(),
        }
    }
}

/// What was open between laws and places, and what of it the sessions together still name.
fn decided(report: &DiagnosisReport, share: &SessionShare) -> Option<String> {
    let before = share.open_before.as_ref()?;
    let findings = report.diagnosis.findings.iter();
    let now: Vec<LawAtPlace> = findings.map(|one| (&one.effect).into()).collect();
    let is_named = |one: &&LawAtPlace| {
        let mut named = now.iter();
        named.any(|named| (named.law.name, &named.place) == (one.law.name, &one.place))
    };
    let left: Vec<String> = before
        .open
        .iter()
        .filter(is_named)
        .map(ToString::to_string)
        .collect();
    let outcome = match &left[..] {
        [] => "Diagnosed together, the sessions name none of these.".to_owned(),
        [one] => format!("Diagnosed together, the sessions decide for {one}."),
        several if several.len() == before.open.len() => "All of these are still open.".to_owned(),
        several => format!("Still open: {}.", listed(several, "or")),
    };
    let own = match before.sessions {
        1 => format!("{} alone", share.name),
        _ => format!("{} with the sessions before it", share.name),
    };
    let open: Vec<String> = before.open.iter().map(ToString::to_string).collect();
    let sentence = format!("{own} left open: {}. {outcome}", listed(&open, "or"));
    Some(sentence)
}

/// The section of the page; empty of one session.
pub(super) fn sessions(report: &DiagnosisReport) -> Document {
    if report.sessions.is_empty() {
        return Document::new();
    }
    let digits = |value: f64| significant(value, 2);
    let decided = report
        .sessions
        .iter()
        .filter_map(|one| decided(report, one));
    let mut document = Document::under("Sessions, each with its own noise (standard deviations)");
    document.table(
        Table::of(&report.sessions)
            .words("session", |one| &one.name)
            .numbers("readings", |one| one.readings)
            .numbers("runs", |one| one.runs)
            .numbers("bad", |one| one.bad_readings)
            .numbers("reading, µm", |one| digits(micro(one.noise.reading_sd_m)))
            .numbers("gauge zero, µm", |one| digits(micro(one.noise.zero_sd_m)))
            .numbers("run slope, %", |one| digits(100.0 * one.noise.run_slope_sd)),
    );
    document.paragraphs(decided);
    document
}
