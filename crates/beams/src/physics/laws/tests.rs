use proptest::prelude::*;

use super::*;
use crate::physics::action::{Driven, LawAction, RotationLaw, Values};

/// A joint driven by a moment against a loop.
pub(in crate::physics) fn at(moment_nm: f64, stiffness_nm_per_rad: f64, before_rad: f64) -> Driven {
    Driven {
        moment_nm,
        stiffness_nm_per_rad,
        before_rad,
    }
}

fn twist_law(law: Law) -> &'static dyn RotationLaw {
    let LawAction::Joint(law) = law.action else {
        panic!("{law} is no law of a joint")
    };
    law
}

#[test]
fn laws_of_one_name_differ_in_place_or_unit_and_rows_are_unique() {
    for (place, law) in LAWS.iter().enumerate() {
        assert!(!law.name.is_empty() && law.parameters.len() <= crate::physics::MOST_PARAMETERS);
        for other in &LAWS[..place] {
            assert_ne!(law.row, other.row);
            let units = |law: &Law| {
                law.parameters
                    .iter()
                    .map(|parameter| (parameter.name, parameter.unit()))
                    .collect::<Vec<_>>()
            };
            assert!(
                law.name != other.name
                    || law.place_kind != other.place_kind
                    || units(law) != units(other),
                "{law}"
            );
        }
        assert!(
            law.words.explanation.ends_with('.') && !(law.words.phrase)("there", &[]).is_empty()
        );
        let mut simpler = law.contains.iter();
        let exist = simpler.all(|row| LAWS.iter().any(|other| other.row == *row));
        assert!(exist, "{law} contains a law that does not exist");
    }
}

#[test]
fn shapes_are_plausible_and_combinations_in_proportion_to_their_first_value() {
    let scale = crate::physics::PlaceScale {
        force_n: 70.0,
        force_range_n: [-70.0, 0.0],
        displacement_m: 1e-3,
        time_s: 200.0,
        warming_k: 2.0,
        has_clock: true,
        has_holds: true,
        has_repeats: true,
        compliance: 1e-5,
        moment_nm: 20.0,
        loop_nm_per_rad: 0.0,
    };
    let closed = crate::physics::PlaceScale {
        loop_nm_per_rad: 2e5,
        ..scale
    };
    for law in LAWS {
        for scale in [scale, closed] {
            let wide = law.search.wide_shapes.map(|shapes| shapes(&scale));
            for shape in (law.search.shapes)(&scale)
                .into_iter()
                .chain(wide.into_iter().flatten())
            {
                for (place, parameter) in law.parameters.iter().enumerate() {
                    let ratio = if parameter.is_ratio() {
                        shape.values[0]
                    } else {
                        1.0
                    };
                    let value = shape.values[place] / ratio;
                    let [low, high] = (parameter.plausible.bounds)(&scale, &shape.values);
                    assert!(
                        low <= value && value <= high,
                        "{law} {} = {value}: {low} to {high}",
                        parameter.name
                    );
                }
                if let Some(combination) = law.combination {
                    let number = |share: f64| {
                        let values = [&[share * shape.values[0]], &shape.values[1..]].concat();
                        (combination.of)(&crate::physics::values_of(&values), &scale)
                    };
                    let [one, two] = [number(1.0), number(2.0)];
                    assert!(one.is_finite() && (two - 2.0 * one).abs() <= 1e-12 * one.abs());
                }
            }
        }
    }
}

#[test]
fn mistakes_have_priors_and_physics_none() {
    use crate::physics::MistakePrior;
    let two_degrees = JOINT_OFFSET.log_prior(&[2.0 * 0.0175]);
    assert!((two_degrees + 5_f64.ln()).abs() < 1e-12, "{two_degrees}");
    // Twice the section is as likely as half of it.
    let factor = |share: f64| SECTION_ERROR.log_prior(&[share]);
    assert!((factor(1.0) - factor(-0.5)).abs() < 1e-12);
    assert!(MistakePrior::Factor(0.3).log_density(-1.0).is_finite());
    assert_eq!(JOINT_COMPLIANCE.log_prior(&[1.0]), 0.0);
    assert_eq!(WRONG_MECHANISM.log_prior(&[]), 0.0);
}

proptest! {
    /// Every law's twist satisfies its own equation with τ = T - k φ.
    #[test]
    fn twists_satisfy_their_equation(
        c in 1e-6..1e-2_f64, q in -1e-4..1e-3_f64, driving in -50.0..50.0_f64, k in 0.0..1e4_f64,
    ) {
        let values: Values = [c, q, 0.0, 0.0];
        let rotation = twist_law(JOINT_COMPLIANCE).rotation_rad(&values, at(driving, k, 0.0));
        let moment = driving - k * rotation;
        prop_assert!((rotation - c * moment).abs() <= 1e-9 * (c * driving).abs());
        let rotation = twist_law(JOINT_NONLINEARITY).rotation_rad(&values, at(driving, k, 0.0));
        let moment = driving - k * rotation;
        let stop = q < 0.0 && moment.abs() >= c / (-2.0 * q) * (1.0 - 1e-6);
        let law = c * moment + q * moment * moment.abs();
        prop_assert!(stop || (rotation - law).abs() <= 1e-8 * (c * driving).abs(), "{rotation} {law}");
    }

    /// The slope of every law is that of its twist, away from its kinks.
    #[test]
    fn slopes_are_derivatives(driving in 1.0..50.0_f64, k in 1.0..1e4_f64) {
        for law in LAWS.iter().filter(|law| matches!(law.action, LawAction::Joint(_))) {
            let values = [2e-4, 0.3, 0.0, 0.0];
            let twist_law = twist_law(*law);
            let rotation = |moment| twist_law.rotation_rad(&values, at(moment, k, 0.0));
            let step = 1e-6 * driving;
            let [down, up] = [driving - step, driving + step].map(rotation);
            let slope = twist_law.slope_rad_per_nm(&values, at(driving, k, 0.0));
            let difference = (up - down) / (2.0 * step);
            let kink = [down, up].iter().any(|t| (t.abs() - 2e-4).abs() < 1e-9) || down == 0.0;
            prop_assert!(kink || (slope - difference).abs() <= 1e-4 * slope.abs() + 1e-12, "{law}: {slope} {difference}");
        }
    }
}
