//! Measurements that no load plan can replace.

use stiffbench_beams::physics::{Law, Place};

use super::Suspect;

/// A check in words and the minutes it takes.
pub(super) struct Advice {
    pub(super) text: String,
    pub(super) minutes: f64,
}

/// The check that settles a law by itself, if there is one besides loading the robot.
fn check(suspect: &Suspect) -> Option<(u8, String, f64)> {
    let (rank, text, minutes) = match (suspect.law, &suspect.place) {
        (Law::ForceGaugeNonlinearity, _) => (
            0,
            "hang known weights on the force gauge, ten steps over its range, three times".to_owned(),
            20.0,
        ),
        (Law::GaugePeriodic, _) => (
            0,
            "run the dial gauge over gauge blocks in steps of a tenth of a millimetre, or move its zero by 0.3 mm and repeat one cell"
                .to_owned(),
            25.0,
        ),
        (Law::DriftPerKelvin | Law::DriftPerSecond, _) => (
            1,
            "leave the gauges on the unloaded robot for half an hour beside a thermometer, a reading a minute".to_owned(),
            30.0,
        ),
        (Law::GaugeStandCompliance, Place::Direction(direction)) => (
            1,
            format!(
                "set a second dial gauge on the floor against the stand of the first and load the robot in {direction}: the stand must not move"
            ),
            20.0,
        ),
        (Law::BaseCompliance, Place::Axis(axis)) => (
            1,
            format!("set two dial gauges on the floor against the base, a known distance apart, and read its rocking about {axis} under the largest load"),
            25.0,
        ),
        (Law::LoadMisalignment, Place::Toward { direction, toward }) => (
            2,
            format!("read a gauge in {toward} too while loading in {direction}, then turn the force gauge by half a turn and repeat"),
            25.0,
        ),
        (Law::LooseMember, Place::Element(element)) => (
            2,
            format!("look at and tighten both ends of {element}, or take it off, and repeat the stiffest cell"),
            30.0,
        ),
        (Law::SettingIn, _) => (
            3,
            "load and release the robot ten times before the gauge is zeroed, then repeat one cell".to_owned(),
            20.0,
        ),
        (Law::Slip, _) => (3, "repeat the same run".to_owned(), 10.0),
        (law, Place::Joint(joint)) if law.is_of_a_joint() => (
            4,
            format!("set a dial gauge across joint {joint}, from one of its bodies to the other, and load and unload once"),
            25.0,
        ),
        _ => return None,
    };
    Some((rank, text, minutes))
}

/// The measurement that tells two apart where no load plan does: the check of the one that is checked most directly.
pub(super) fn advice(first: &Suspect, second: &Suspect) -> Option<Advice> {
    let mut checks: Vec<(u8, String, f64)> =
        [first, second].into_iter().filter_map(check).collect();
    checks.sort_by_key(|(rank, ..)| *rank);
    let (_, text, minutes) = checks.into_iter().next()?;
    Some(Advice { text, minutes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiffbench_units_and_text::test_point::Direction;

    #[test]
    fn the_most_direct_check_is_advised() {
        let gauge = Suspect {
            law: Law::ForceGaugeNonlinearity,
            place: Place::ForceGauge,
        };
        let joint = Suspect {
            law: Law::JointNonlinearity,
            place: Place::Joint("A4".to_owned()),
        };
        let stand = Suspect {
            law: Law::GaugeStandCompliance,
            place: Place::Direction(Direction::Y),
        };
        let text = |a: &Suspect, b: &Suspect| advice(a, b).map(|advice| advice.text);
        assert!(text(&joint, &gauge).is_some_and(|t| t.contains("known weights")));
        assert!(text(&joint, &stand).is_some_and(|t| t.contains("second dial gauge")));
        assert!(text(&joint, &joint).is_some_and(|t| t.contains("across joint A4")));
        let creep = Suspect {
            law: Law::Creep,
            place: Place::Structure,
        };
        assert!(advice(&creep, &creep).is_none());
    }
}
