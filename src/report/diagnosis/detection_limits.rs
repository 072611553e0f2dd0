//! Detection limits and critical values as a diagnosis reports them.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::analysis::{DiagnosisReport, Subject};
use crate::mismatch::{DetectionLimit, LawCriticalValues};
use crate::physics::{Law, Needs, ParameterSpec, Place, laws};
use crate::search::{LAW_LEVEL, NULL_SAMPLES, UNEXPLAINED_LEVEL};

/// Size of a law that readings would have shown at a place, or the reason why there is none.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct DetectionLimitReport {
    /// The law.
    pub physics: Law,
    /// The place; `null` for all places of the law.
    pub place: Option<Place>,
    /// Size found in 80 % of sessions, in `unit`; `null` if no possible size is.
    pub size_80: Option<f64>,
    /// Unit of the sizes; `null` for a law without size.
    pub unit: Option<String>,
    /// What else the search shows of the law.
    #[serde(flatten)]
    pub seen: Option<SeenLimit>,
    /// Why the law cannot be seen.
    #[serde(flatten)]
    pub unseen: Option<UnseenReason>,
}

/// What a search shows of a law at a place.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SeenLimit {
    /// Largest change of a reading by the size, µm; `null` of readings that are no lengths.
    // Without the key there is no limit at all.
    #[serde(deserialize_with = "Option::deserialize")]
    pub end_effect_um: Option<f64>,
    /// Upper 95 % limit of the size, given these readings, in `unit`; `null` where something was found.
    pub upper_95: Option<f64>,
}

/// Why a law cannot be seen.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct UnseenReason {
    /// Why, as a clause.
    pub reason: Cow<'static, str>,
    /// What would make it visible, as a clause; `null` where nothing would.
    pub remedy: Option<Cow<'static, str>>,
}

/// How the level of a search is split between the laws.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SearchLevels {
    /// Chance that noise alone passes for any law.
    pub laws_level: f64,
    /// Each law.
    pub laws: Vec<LawLevel>,
    /// Chance that noise alone passes for structure left over.
    #[serde(rename = "left_over_level")]
    pub unexplained_level: f64,
    /// Critical value of what is left over.
    #[serde(rename = "left_over_gain_limit")]
    pub unexplained_gain_limit: f64,
    /// Draws of noise behind the critical values.
    pub draws: usize,
}

/// Level and critical value of a law.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct LawLevel {
    /// The law.
    pub physics: Law,
    /// Unit of its size; `null` for a law without size.
    pub unit: Option<Cow<'static, str>>,
    /// Whether any period was searched.
    pub wide_search: bool,
    /// Its share of the level of all laws.
    pub share: Option<f64>,
    /// Its level.
    pub level: Option<f64>,
    /// The fall of the weighted squares that noise alone exceeds with that level.
    pub gain_limit: f64,
}

/// Unit of the size of a law.
fn unit(law: Law) -> Option<&'static str> {
    law.parameters.first().map(ParameterSpec::unit)
}

impl DetectionLimitReport {
    fn at_place(subject: &Subject, limit: &DetectionLimit) -> Self {
        let stored = limit
            .law
            .parameters_at(&limit.place)
            .next()
            .map(|size| subject.stored(&size));
        let (si, unit) = stored.unzip();
        let scaled = |size: f64| size / si.unwrap_or(1.0);
        let (reason, remedy) = limit.law.search.unseen_at_place;
        let unseen = UnseenReason {
            reason: reason.into(),
            remedy: Some(remedy.into()),
        };
        Self {
            physics: limit.law,
            place: Some(limit.place.clone()),
            size_80: limit.size_80.map(scaled),
            unit,
            seen: Some(SeenLimit {
                end_effect_um: limit.end_effect_m.and_then(|one| subject.micrometres(one)),
                upper_95: limit.upper_95.map(scaled),
            }),
            unseen: limit.size_80.is_none().then_some(unseen),
        }
    }
}

impl DiagnosisReport {
    /// Size of each law and place that these readings would have shown; then places at which a law cannot be seen, then laws that cannot
    /// be seen at all.
    pub(super) fn detection_limits(&self) -> Vec<DetectionLimitReport> {
        let limits = &self.diagnosis.detection_limits;
        let tested = &self.critical.laws.values;
        let at_place = |limit| DetectionLimitReport::at_place(&self.subject, limit);
        let mut all: Vec<DetectionLimitReport> = limits.iter().map(at_place).collect();
        all.sort_by_key(|limit| limit.unseen.is_some());
        let is_whole = |law: &Law| {
            limits.iter().all(|limit| limit.law != *law)
                && tested.keys().all(|(tested, _)| tested != law)
        };
        let whole = Law::searched_on(self.observations.object).filter(is_whole);
        all.extend(whole.map(|law| {
            DetectionLimitReport {
                physics: law,
                place: law.place_kind.only(),
                size_80: None,
                unit: law
                    .parameters
                    .first()
                    .map(|size| self.subject.stored(size).1),
                seen: None,
                unseen: Some(self.why_unseen(law)),
            }
        }));
        all
    }

    /// Why a law cannot be seen at all in these readings.
    fn why_unseen(&self, law: Law) -> UnseenReason {
        let recorded = self.observations.recorded;
        let is_one_sweep = self.observations.is_one_sweep();
        let (reason, remedy) = match law.search.needs {
            _ if self.without.contains(&law) => (
                "it was left out of the search",
                Some("do not exclude it with --without"),
            ),
            _ if self.observations.tracker.is_some() && law.is_hidden_from_trackers() => (
                "a tracker has no displacement gauge, stand or zero, and positions belong to no run",
                Some("read displacements under series of loads"),
            ),
            Needs::Hold if !recorded.hold => (
                "the readings do not record how long each load had been on (column hold_s)",
                Some("record hold_s and hold the largest load for a minute or two"),
            ),
            needs if is_one_sweep && needs.more_than_a_sweep() => (
                "time and load rose together: every run goes one way, at one rate",
                Some("unload, hold the load, or load at another rate"),
            ),
            Needs::Clock if !recorded.time => (
                "the readings have no times (column t_s)",
                Some("record the time of each reading"),
            ),
            Needs::Temperature if !recorded.temperature => (
                "the readings have no temperature (column temp_degC)",
                Some("record the temperature beside the gauge"),
            ),
            Needs::Nothing | Needs::Hold | Needs::Clock | Needs::Return | Needs::Temperature
                if self.is_in_the_model(law) =>
            {
                (
                    "every such parameter that these loads act on is already free",
                    None,
                )
            }
            _ => law.search.unseen,
        };
        UnseenReason {
            reason: reason.into(),
            remedy: remedy.map(Into::into),
        }
    }

    /// Whether springs that are parameters of the model are what the law describes.
    fn is_in_the_model(&self, law: Law) -> bool {
        let of_law = match law.name {
            name if name == laws::JOINT_COMPLIANCE.name => "joint.",
            name if name == laws::BASE_COMPLIANCE.name => "base.",
            _ => return false,
        };
        let mut parameters = self.parameters.iter();
        parameters.any(|one| one.spring_rad_per_nm.is_some() && one.name.starts_with(of_law))
    }
}

impl From<&LawCriticalValues> for SearchLevels {
    fn from(critical: &LawCriticalValues) -> Self {
        let laws = critical.laws.values.iter().map(|(family, limit)| {
            let (law, wide_search) = *family;
            let level = critical.laws.levels.get(family).copied();
            LawLevel {
                physics: law,
                unit: unit(law).map(Into::into),
                wide_search,
                share: level.map(|level| level / LAW_LEVEL),
                level,
                gain_limit: *limit,
            }
        });
        Self {
            laws_level: LAW_LEVEL,
            laws: laws.collect(),
            unexplained_level: UNEXPLAINED_LEVEL,
            unexplained_gain_limit: critical.of_unexplained(),
            draws: NULL_SAMPLES,
        }
    }
}
