//! Limits of the procedure: what is beyond a warning limit is flagged, what is beyond a hard one is asked about, and each reading keeps its verdict.

use crate::support::{Rig, short};
use stiffbench_measurement::procedure::LimitVerdict;
use stiffbench_session::SessionEnd;

#[test]
fn a_reading_keeps_its_verdict_beside_the_value() {
    let mut procedure = short(false);
    // Along x the end gives way by 5 um/N: about 0, 50 and 100 um.
    procedure.limits.displacement_warn_m = Some(30e-6);
    procedure.limits.displacement_hard_m = Some(80e-6);
    let mut rig = Rig::start(&procedure);
    rig.answer(&[("limit", "accept")]);
    assert_eq!(rig.run(), Some(SessionEnd::Complete));
    let readings = &rig.machine.state().readings;
    for (step, verdict, flag) in [
        (0, LimitVerdict::Pass, ""),
        (1, LimitVerdict::Warn, "beyond the warning limit of 30.0 um"),
        (2, LimitVerdict::Fail, "limit: accepted by the operator"),
    ] {
        for kept in readings.iter().filter(|kept| kept.taken.step == step) {
            let checked = kept.taken.limits.as_ref().unwrap();
            assert_eq!(checked.verdict, verdict, "{checked:?}");
            assert!(kept.flag().contains(flag), "{}", kept.flag());
        }
    }
    let asked = rig.asked.iter().filter(|prompt| prompt.id == "limit");
    assert_eq!(
        asked.count(),
        2,
        "once for each reading beyond the hard limit"
    );
}
