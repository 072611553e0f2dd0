//! Standard errors of the laws on a real baseline, beside those of an idealised bench.
//!
//! The idealised bench knows sizes of noise and shapes of effects, and has three factors with random patterns over its cells in place of a
//! structure. Its powers are upper limits; what a robot's own factors imitate, and what its joints do to each other, only a robot shows.

use schemars::JsonSchema;
use serde::Serialize;

use stiffbench_beams::physics::{Law, laws};
use stiffbench_diagnosis::mismatch::{DesignReport, LawDesign};
use stiffbench_units_and_text::quantity::METRES_PER_MICROMETRE;

/// Laws with their standard errors on the idealised bench, µm at the largest load: four poses, three directions, five repeats, loading and
/// unloading, a mean compliance of 20 µm/N, readings to 6 µm on a gauge of 10 µm, zeros to 5 µm, slopes of runs to 0.5 %.
pub const IDEALISED_UM: [(Law, f64); 9] = [
    (laws::JOINT_BACKLASH, 0.65),
    (laws::JOINT_FRICTION, 0.24),
    (laws::JOINT_COMPLIANCE, 2.0),
    (laws::JOINT_NONLINEARITY, 2.0),
    (laws::LOAD_MISALIGNMENT, 2.8),
    (laws::FORCE_GAUGE_NONLINEARITY, 2.3),
    (laws::CREEP, 3.0),
    (laws::DRIFT_PER_SECOND, 1.3),
    (laws::SETTING_IN, 3.1),
];

/// A law's standard errors as changes of a reading, on the idealised bench and under plans of real ones.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct IdealisedErrors {
    /// The law.
    pub physics: Law,
    /// Standard error on the idealised bench, µm.
    pub idealised_um: f64,
    /// Under each plan.
    pub plans: Vec<ErrorsOfPlan>,
}

/// A law's standard errors under one plan.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ErrorsOfPlan {
    /// The mechanism.
    pub bench: String,
    /// Places that show the law.
    pub places: usize,
    /// Smallest, middle and largest over these places, µm; `null` without such a place.
    pub standard_error_um: Option<[f64; 3]>,
}

/// Holds the standard errors of plans, each with the name of its bench, against the idealised ones.
#[must_use]
pub fn beside_idealised(plans: &[(String, DesignReport)]) -> Vec<IdealisedErrors> {
    let row = |&(law, idealised_um): &(Law, f64)| IdealisedErrors {
        physics: law,
        idealised_um,
        plans: plans
            .iter()
            .map(|(bench, plan)| ErrorsOfPlan::new(bench, law, &plan.laws))
            .collect(),
    };
    IDEALISED_UM.iter().map(row).collect()
}

impl ErrorsOfPlan {
    fn new(bench: &str, law: Law, designs: &[LawDesign]) -> Self {
        let own = designs.iter().filter(|design| design.suspect.law == law);
        let errors = own.map(|design| design.standard_error_m / METRES_PER_MICROMETRE);
        let mut errors: Vec<f64> = errors.collect();
        errors.sort_by(f64::total_cmp);
        let middle = errors.get(errors.len() / 2);
        let ends = errors.first().zip(errors.last());
        Self {
            bench: bench.to_owned(),
            places: errors.len(),
            standard_error_um: ends
                .zip(middle)
                .map(|((least, most), middle)| [*least, *middle, *most]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiffbench_beams::physics::{Place, laws};
    use stiffbench_diagnosis::mismatch::LawAtPlace;

    #[test]
    fn a_law_has_its_smallest_middle_and_largest_error_or_none() {
        let design = |joint: &str, standard_error_m| LawDesign {
            suspect: LawAtPlace {
                law: laws::JOINT_BACKLASH,
                place: Place::Joint(joint.to_owned()),
            },
            size_80: None,
            unit: None,
            end_effect_80_um: 1e6,
            standard_error_m,
            nearest: Vec::new(),
        };
        let plan = DesignReport {
            procedure: "plan".to_owned(),
            readings: 900,
            minutes: 1.0,
            laws: vec![design("A", 3e-6), design("B", 1e-6), design("C", 2e-6)],
            inseparable: Vec::new(),
            unseen: Vec::new(),
        };
        let rows = beside_idealised(&[("bench".to_owned(), plan)]);
        let found = &rows[0].plans[0];
        let [least, middle, most] = found.standard_error_um.unwrap();
        assert_eq!((found.places, found.bench.as_str()), (3, "bench"));
        for (found, expected) in [(least, 1.0), (middle, 2.0), (most, 3.0)] {
            assert!((found - expected).abs() < 1e-12);
        }
        let mut others = rows[1..].iter().flat_map(|row| &row.plans);
        assert!(others.all(|plan| plan.places == 0 && plan.standard_error_um.is_none()));
    }
}
