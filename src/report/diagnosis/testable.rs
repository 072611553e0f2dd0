//! What these readings could not have shown, why, and what would make it visible.

use crate::mismatch::DetectionLimit;
use crate::physics::{Law, Place};

use super::DiagnosisReport;

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
pub(super) fn untestable<'a>(report: &DiagnosisReport<'a>) -> Vec<Untestable<'a>> {
    let limits = &report.diagnosis.detection_limits;
    let places = limits
        .iter()
        .filter(|limit| limit.size_80.is_none())
        .map(|limit| {
            let (reason, remedy) = at_a_place(limit.law);
            Untestable {
                law: limit.law,
                place: Some(limit.place.clone()),
                limit: Some(limit),
                reason,
                remedy: Some(remedy),
            }
        });
    let whole = Law::ALL
        .into_iter()
        .filter(|law| {
            limits.iter().all(|limit| limit.law != *law)
                && report.limits.laws.keys().all(|(tested, _)| tested != law)
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
                place: only_place(law),
                limit: None,
                reason,
                remedy,
            }
        });
    places.chain(whole).collect()
}

/// The place of a law that has only one.
fn only_place(law: Law) -> Option<Place> {
    match law {
        Law::ForceGaugeNonlinearity => Some(Place::ForceGauge),
        Law::Creep | Law::SettingIn => Some(Place::Structure),
        Law::DriftPerSecond | Law::DriftPerKelvin => Some(Place::Clock),
        Law::GaugePeriodic => Some(Place::DisplacementGauge),
        _ => None,
    }
}

/// Why a law cannot be seen at one of its places.
fn at_a_place(law: Law) -> (&'static str, &'static str) {
    match law {
        Law::LoadMisalignment => (
            "a force turned that way moves this robot along the direction of reading only to second order",
            "read the displacement along all three axes at each load",
        ),
        Law::LooseMember => (
            "without it the readings would hardly change, or the factors take what changes",
            "measure further poses, or look at both of its ends",
        ),
        law if law.is_of_a_joint() => (
            "even if the joint turned freely the readings would hardly change, or the factors take what changes",
            "measure poses in which the load turns the joint more, or load and read the linkage next to it",
        ),
        _ => (
            "no possible size of it would have stood out from the noise and from what the factors take",
            "measure further poses, larger loads or more repeats",
        ),
    }
}

/// Why a law cannot be seen at all in these readings.
fn altogether(report: &DiagnosisReport<'_>, law: Law) -> (&'static str, Option<&'static str>) {
    let recorded = report.observations.recorded;
    match law {
        Law::Creep if !recorded.hold => (
            "the readings do not say how long each load had been on (column hold_s)",
            Some("record hold_s and hold the largest load for a minute or two"),
        ),
        Law::DriftPerSecond if !recorded.time => (
            "the readings carry no clock (column t_s)",
            Some("record the time of each reading"),
        ),
        Law::DriftPerKelvin if !recorded.temperature => (
            "the readings carry no temperature (column temp_degC)",
            Some("record the temperature beside the gauge"),
        ),
        Law::SettingIn => (
            "there is only one repeat",
            Some("repeat each load sequence three to five times"),
        ),
        Law::GaugePeriodic => (
            "the displacements do not span a period of any gauge",
            Some("shift the zero of the gauge by a few tenths of a millimetre between repeats"),
        ),
        Law::Slip => (
            "no run has enough load steps to tell a slip from an outlier",
            Some("take at least four load steps a run"),
        ),
        Law::LooseMember => (
            "no element can be missing without the mechanism falling apart",
            None,
        ),
        law if law.is_of_a_joint() => (
            "the mechanism has no joint that these loads act on",
            Some("choose the mechanism that the robot really has"),
        ),
        _ => (
            "no possible size of it would have shown in these readings",
            Some("measure further poses, larger loads or more repeats"),
        ),
    }
}
