//! What these readings could not have shown, why, and what would make it visible.

use crate::mismatch::DetectionLimit;
use crate::physics::{Law, Needs, Place};

use crate::analysis::DiagnosisReport;

/// A law that these readings cannot show, at a place or at all.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Untestable<'a> {
    /// The law.
    pub(super) law: Law,
    /// The place; `None` for all places of the law.
    pub(super) place: Option<Place>,
    /// What the search knows of it nevertheless.
    pub(super) limit: Option<&'a DetectionLimit>,
    /// Why it cannot be seen, as a clause.
    pub(super) reason: &'static str,
    /// What would make it visible, as a clause; `None` where nothing would.
    pub(super) remedy: Option<&'static str>,
}

/// Everything that could not be tested: single places first, then laws as a whole.
pub(super) fn untestable(report: &DiagnosisReport) -> Vec<Untestable<'_>> {
    let critical = &report.diagnosis.detection_limits;
    let places = critical
        .iter()
        .filter(|limit| limit.size_80.is_none())
        .map(|limit| {
            let (reason, remedy) = limit.law.search.unseen_at_place;
            Untestable {
                law: limit.law,
                place: Some(limit.place.clone()),
                limit: Some(limit),
                reason,
                remedy: Some(remedy),
            }
        });
    let whole = Law::ALL
        .iter()
        .copied()
        .filter(|law| {
            critical.iter().all(|limit| limit.law != *law)
                && report
                    .critical
                    .laws
                    .values
                    .keys()
                    .all(|(tested, _)| tested != law)
        })
        .map(|law| {
            let (reason, remedy) = if report.without.contains(&law) {
                (
                    "it was left out of the search",
                    Some("do not name it after --without"),
                )
            } else {
                altogether(report, law)
            };
            Untestable {
                law,
                place: law.place_kind.only(),
                limit: None,
                reason,
                remedy,
            }
        });
    places.chain(whole).collect()
}

/// Why a law cannot be seen at all in these readings.
fn altogether(report: &DiagnosisReport, law: Law) -> (&'static str, Option<&'static str>) {
    let recorded = report.observations.recorded;
    match law.search.needs {
        Needs::Hold if !recorded.hold => (
            "the readings do not record how long each load had been on (column hold_s)",
            Some("record hold_s and hold the largest load for a minute or two"),
        ),
        Needs::Clock if !recorded.time => (
            "the readings carry no clock (column t_s)",
            Some("record the time of each reading"),
        ),
        Needs::Temperature if !recorded.temperature => (
            "the readings carry no temperature (column temp_degC)",
            Some("record the temperature beside the gauge"),
        ),
        Needs::Nothing | Needs::Hold | Needs::Clock | Needs::Temperature => law.search.unseen,
    }
}
