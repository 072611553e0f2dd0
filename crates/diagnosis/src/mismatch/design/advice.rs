//! Measurements that no load plan can replace.

use super::bench::LawAtPlace;

/// The measurement that tells two apart where no load plan does, in words and the minutes that it takes: the check of the one that is checked
/// most directly.
pub(super) fn advice(first: &LawAtPlace, second: &LawAtPlace) -> Option<(String, f64)> {
    let checks = [first, second].into_iter();
    let checks = checks.filter_map(|suspect| Some((suspect.law.check?, &suspect.place)));
    let (check, place) = checks.min_by_key(|(check, _)| check.rank)?;
    Some(((check.text)(place), check.minutes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiffbench_beams::physics::{Place, laws};
    use stiffbench_units_and_text::test_point::Direction;

    #[test]
    fn the_most_direct_check_is_advised() {
        let gauge = LawAtPlace {
            law: laws::FORCE_GAUGE_NONLINEARITY,
            place: Place::ForceGauge,
        };
        let joint = LawAtPlace {
            law: laws::JOINT_NONLINEARITY,
            place: Place::Joint("A4".to_owned()),
        };
        let stand = LawAtPlace {
            law: laws::GAUGE_STAND_COMPLIANCE,
            place: Place::Direction(Direction::Y),
        };
        let text = |a: &LawAtPlace, b: &LawAtPlace| advice(a, b).map(|(text, _)| text);
        assert!(text(&joint, &gauge).is_some_and(|t| t.contains("known weights")));
        assert!(text(&joint, &stand).is_some_and(|t| t.contains("second dial gauge")));
        assert!(text(&joint, &joint).is_some_and(|t| t.contains("across joint A4")));
        let creep = LawAtPlace {
            law: laws::CREEP,
            place: Place::Structure,
        };
        assert!(advice(&creep, &creep).is_none());
    }
}
