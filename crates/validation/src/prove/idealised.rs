//! Standard errors of the laws on a real baseline, beside those of an idealised bench.
//!
//! The idealised bench knows sizes of noise and shapes of effects, and has three factors with random patterns over its cells in place of a
//! structure. Its powers are upper limits; what a robot's own factors imitate, and what its joints do to each other, only a robot shows.

use stiffbench_beams::physics::{Law, laws};
use stiffbench_diagnosis::mismatch::{DesignReport, LawDesign};

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

/// Standard errors of a law at its places under a plan: the smallest, the one in the middle, the largest, as change of a reading, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaceErrors {
    /// Places that show the law.
    pub places: usize,
    /// Smallest, middle, largest.
    pub error_m: [f64; 3],
}

/// A law on the idealised bench and under plans of real ones.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorRow {
    /// The law.
    pub law: Law,
    /// Standard error on the idealised bench, m.
    pub idealised_m: f64,
    /// For each plan; `None` where no place shows the law.
    pub plans: Vec<Option<PlaceErrors>>,
}

/// Holds the standard errors of plans against the idealised ones.
#[must_use]
pub fn beside_idealised(plans: &[DesignReport]) -> Vec<ErrorRow> {
    IDEALISED_UM
        .iter()
        .map(|&(law, idealised_um)| ErrorRow {
            law,
            idealised_m: 1e-6 * idealised_um,
            plans: plans
                .iter()
                .map(|plan| at_places(law, &plan.laws))
                .collect(),
        })
        .collect()
}

fn at_places(law: Law, designs: &[LawDesign]) -> Option<PlaceErrors> {
    let mut errors: Vec<f64> = designs
        .iter()
        .filter(|design| design.suspect.law == law)
        .map(|design| design.standard_error_m)
        .collect();
    errors.sort_by(f64::total_cmp);
    let (first, last) = (*errors.first()?, *errors.last()?);
    Some(PlaceErrors {
        places: errors.len(),
        error_m: [first, errors[errors.len() / 2], last],
    })
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
        let rows = beside_idealised(&[plan]);
        let found = rows[0].plans[0].unwrap();
        assert_eq!((found.places, found.error_m), (3, [1e-6, 2e-6, 3e-6]));
        assert!(rows[1..].iter().all(|row| row.plans == [None]));
        assert!((rows[0].idealised_m - 0.65e-6).abs() < 1e-12);
    }
}
