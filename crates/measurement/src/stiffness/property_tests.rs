//! What holds for any readings whatever.

use proptest::prelude::*;

use super::*;
use crate::readings::Reading;
use crate::stiffness::sample::{SimulatedBench, reading};
use stiffbench_units_and_text::test_point::{Branch, Direction};

fn table(readings: &[Reading]) -> StiffnessTable {
    stiffness_table(readings, &GaugePair::default(), StiffnessOptions::default())
}

fn any_reading() -> impl Strategy<Value = Reading> {
    let number = || {
        prop_oneof![
            8 => -100.0_f64..100.0,
            1 => Just(0.0),
            1 => prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(1e300), Just(-1e-300)],
        ]
    };
    (
        (
            1_u32..4,
            0_u32..4,
            -3_i32..3,
            0_u32..3,
            0_u32..3,
            any::<bool>(),
        ),
        (number(), number(), proptest::option::of(number())),
    )
        .prop_map(
            |((repeat, step, target, run, zero, unloading), (force, displacement, time))| Reading {
                run,
                zero,
                time_s: time,
                hold_s: time,
                direction: Direction::ALL[(step % 3) as usize],
                load: None,
                branch: if unloading {
                    Branch::Unloading
                } else {
                    Branch::Loading
                },
                ..reading(
                    repeat,
                    step,
                    f64::from(target) * 10.0,
                    force,
                    displacement * 1e-5,
                )
            },
        )
}

proptest! {
    #[test]
    fn no_readings_make_it_panic_or_lose_count(readings in proptest::collection::vec(any_reading(), 0..60)) {
        let table = table(&readings);
        let used: usize = table.cells.iter().flat_map(|c| &c.loads).map(|l| l.n).sum();
        let left = &table.left_out;
        prop_assert_eq!(
            used + left.later_in_step + left.other_branch + left.not_finite.len(),
            readings.len()
        );
        prop_assert!(serde_json::to_string(&table).is_ok());
        let _ = compare(&table, &table, true);
    }

    #[test]
    fn the_unit_of_force_does_not_matter(seed in 0_u64..1000, factor in 0.1_f64..10.0) {
        let readings = SimulatedBench::paper(1, seed).readings();
        let scaled: Vec<Reading> = readings
            .iter()
            .map(|r| Reading { force_n: r.force_n * factor, target_n: r.target_n * factor, ..r.clone() })
            .collect();
        for method in [Method::PaperMean, Method::Regression] {
            let [one, other] = [&readings, &scaled].map(|r| table(r).cells[0].by(method).unwrap().estimate);
            prop_assert!((other.value / one.value / factor - 1.0).abs() < 1e-9);
            let uncertainties = other.standard_uncertainty / one.standard_uncertainty;
            prop_assert!((uncertainties / factor - 1.0).abs() < 1e-6);
        }
    }
}
