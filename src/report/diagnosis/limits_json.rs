//! What programs are told of limits and noise.

use serde_json::{Value, json};

use crate::mismatch::{DetectionLimit, LawCriticalValues};
use crate::physics::{Law, ParameterSpec, Place};
use crate::search::constants::{LAW_LEVEL, NULL_SAMPLES, UNEXPLAINED_LEVEL};

use super::testable::untestable;
use super::{finite, um};
use crate::analysis::DiagnosisReport;

/// Size of each law and place that these readings would have shown, or the reason why there is none.
pub(super) fn detection_limits_json(report: &DiagnosisReport) -> Vec<Value> {
    let entry = |law: Law, place: Option<&Place>| {
        json!({
            "physics": law.name,
            "place": place.map(Place::to_json),
            "size_80": null,
            "unit": law.parameters.first().map(ParameterSpec::unit),
        })
    };
    let add = |value: &mut Value, limit: &DetectionLimit| {
        value["size_80"] = limit.size_80.map_or(Value::Null, finite);
        value["end_effect_um"] = limit.end_effect_m.map_or(Value::Null, um);
        value["upper_95"] = limit.upper_95.map_or(Value::Null, finite);
    };
    let known = report.diagnosis.detection_limits.iter();
    let known = known.filter(|limit| limit.size_80.is_some()).map(|limit| {
        let mut value = entry(limit.law, Some(&limit.place));
        add(&mut value, limit);
        value
    });
    let unknown = untestable(report).into_iter().map(|one| {
        let mut value = entry(one.law, one.place.as_ref());
        if let Some(limit) = one.limit {
            add(&mut value, limit);
        }
        value["reason"] = json!(one.reason);
        value["remedy"] = json!(one.remedy);
        value
    });
    known.chain(unknown).collect()
}

/// How the level is split between the laws, and the limits that follow.
pub(super) fn levels_json(critical: &LawCriticalValues) -> Value {
    let laws = critical.laws.values.iter().map(|(family, limit)| {
        let (law, wide) = *family;
        json!({
            "physics": law.name,
            "unit": law.parameters.first().map(ParameterSpec::unit),
            "wide_search": wide,
            "share": critical.laws.levels.get(family).map_or(Value::Null, |level| finite(level / LAW_LEVEL)),
            "level": critical.laws.levels.get(family).copied().map_or(Value::Null, finite),
            "gain_limit": finite(*limit),
        })
    });
    json!({
        "laws_level": LAW_LEVEL,
        "laws": laws.collect::<Vec<_>>(),
        "left_over_level": UNEXPLAINED_LEVEL,
        "left_over_gain_limit": finite(critical.of_unexplained()),
        "draws": NULL_SAMPLES,
    })
}
