//! The hard limits of the procedure: a reading beyond one is asked about.

use crate::event::TakenReading;
use stiffbench_gauges::Channel;
use stiffbench_measurement::procedure::LimitVerdict;

use super::Machine;
use super::plausibility::CaptureCheck;

impl Machine {
    pub(super) fn beyond_a_hard_limit(&self, taken: &TakenReading) -> Option<CaptureCheck> {
        let others_m = taken.gauges.iter().map(|gauge| gauge.displacement_m);
        let displacements_m = others_m.chain([taken.displacement_m]);
        let limits = &self.plan.procedure.limits;
        let (verdict, exceeded) = limits.verdict(taken.force_n, displacements_m);
        let text = exceeded.filter(|_| verdict == LimitVerdict::Fail)?;
        Some(CaptureCheck {
            rule: "limit",
            channel: Channel::Force,
            text: format!("Release the load if robot or gauges are in danger: {text}."),
            may_pass: false,
            still: None,
        })
    }
}
