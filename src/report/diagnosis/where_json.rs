//! What programs are told of where the model without effects fails.

use serde_json::{Value, json};

use crate::mismatch::{ExplainedShare, Location, Spot, StratumTest};

use super::{finite, um};
use crate::analysis::DiagnosisReport;

/// Strata that noise does not explain, with where they sit.
pub(super) fn where_json(report: &DiagnosisReport) -> Value {
    let locations = report.located.locations();
    json!(locations.iter().map(location_json).collect::<Vec<_>>())
}

/// One place where a model fails.
pub(super) fn location_json(location: &Location) -> Value {
    json!({
        "stratum": location.stratum.name(),
        "pose": location.pose.as_ref().map(crate::test_point::PoseId::as_str),
        "direction": location.direction.map(|direction| direction.to_string()),
        "p_family": finite(location.p_family),
        "size_um": um(location.size_m),
    })
}

/// All tests of strata, and what could not be tested.
pub(super) fn strata_json(report: &DiagnosisReport) -> Value {
    let tests = report.located.tests.iter().map(test_json);
    let untested = report.located.untested.iter().map(|one| {
        json!({ "contrast": one.contrast.name(), "stratum": one.contrast.stratum().name(), "reason": one.why })
    });
    json!({ "tests": tests.collect::<Vec<_>>(), "untested": untested.collect::<Vec<_>>() })
}

fn test_json(test: &StratumTest) -> Value {
    json!({
        "stratum": test.stratum.name(),
        "contrast": test.contrast.name(),
        "statistic": finite(test.statistic),
        "dof": test.dof.map(finite),
        "p": finite(test.p),
        "p_family": finite(test.p_family),
        "size_um": um(test.size_m),
        "share": finite(test.share),
        "spots": test.spots.iter().map(spot_json).collect::<Vec<_>>(),
    })
}

fn spot_json(spot: &Spot) -> Value {
    json!({
        "pose": spot.pose.as_ref().map(crate::test_point::PoseId::as_str),
        "direction": spot.direction.map(|direction| direction.to_string()),
        "repeat": spot.reading.map(|(repeat, _)| repeat),
        "step": spot.reading.map(|(_, step)| step),
        "p_family": finite(spot.p_family),
        "size_um": um(spot.size_m),
        "share": finite(spot.share),
    })
}

/// Which parts of the structure carry the misfit.
pub(super) fn components_json(report: &DiagnosisReport) -> Value {
    let all = |one: &[ExplainedShare]| one.iter().map(share_json).collect::<Vec<_>>();
    json!({
        "slopes": all(&report.located.slope_components),
        "shapes": all(&report.located.shape_components),
    })
}

fn share_json(one: &ExplainedShare) -> Value {
    let name = |component: &crate::mismatch::SuspectComponent| json!({ "place": component.place.to_json(), "property": component.property });
    let mut value = name(&one.component);
    value["alike"] = json!(one.alike.iter().map(name).collect::<Vec<_>>());
    value["share"] = finite(one.share);
    value["p"] = finite(one.p);
    value["p_left"] = finite(one.p_left);
    value["size"] = one.size.map_or(Value::Null, finite);
    value["possible"] = json!(one.possible);
    value
}
