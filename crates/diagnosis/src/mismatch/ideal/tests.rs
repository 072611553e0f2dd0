use stiffbench_beams::physics::laws;

use super::*;
use stiffbench_numeric::statistics::normal_upper_tail;

/// A search along the first readings, one law for each, at a common limit.
fn along_readings(laws: &[(Law, Vec<Vec<f32>>)], limit: f64) -> IdealSearch {
    let mut ideal = IdealSearch {
        candidates: Vec::new(),
        vectors: Vec::new(),
        length: 4,
    };
    for (law, vectors) in laws {
        ideal.candidates.push(Searched {
            law: *law,
            place: Place::Structure,
            wide: false,
            values: 1,
            limit,
            shapes: vec![UnitShape {
                vector: ideal.vectors.len() / 4,
                vectors: vectors.len(),
                sizes: [0.0, f64::INFINITY],
            }],
        });
        ideal.vectors.extend(vectors.iter().flatten());
    }
    ideal
}

fn share(sessions: &[IdealSession], holds: impl Fn(&IdealSession) -> bool) -> f64 {
    sessions.iter().filter(|session| holds(session)).count() as f64 / sessions.len() as f64
}

/// Four standard errors of a share of this many sessions.
const SESSIONS: usize = 40_000;
const NEAR: f64 = 4.0 * 0.5 / 200.0;

#[test]
fn an_effect_of_one_shape_is_found_with_normal_power() {
    let ideal = along_readings(&[(laws::CREEP, vec![vec![1.0, 0.0, 0.0, 0.0]])], 9.0);
    for size in [2.0, 3.0, 4.5] {
        let sessions = ideal.sessions((laws::CREEP, &Place::Structure), size, SESSIONS, 5);
        assert_eq!(sessions.len(), SESSIONS);
        let found = share(&sessions, |session| session.found);
        assert!(
            (found - normal_upper_tail(3.0 - size)).abs() < NEAR,
            "{size}: {found}"
        );
        assert!(sessions.iter().all(|s| s.named && s.farthest_apart == 0.0));
    }
}

#[test]
fn the_error_rate_between_two_effects_is_the_normal_tail_of_half_their_distance() {
    // At 60 degrees, 4 standard errors long: 4 apart along the line between them, and 4 sin 60 from the nearest of the other's sizes.
    let (cosine, sine) = (0.5, 0.75_f32.sqrt());
    let laws = [
        (laws::CREEP, vec![vec![1.0, 0.0, 0.0, 0.0]]),
        (laws::SETTING_IN, vec![vec![cosine, sine, 0.0, 0.0]]),
    ];
    let ideal = along_readings(&laws, 6.0);
    let sessions = ideal.sessions((laws::CREEP, &Place::Structure), 4.0, SESSIONS, 6);
    let wrong = share(&sessions, |session| session.likeliest_apart > 0.0);
    // The difference of the two products has mean 4 (1 - cos) = 2 and variance 2 (1 - cos) = 1; both are positive nearly always.
    assert!((wrong - normal_upper_tail(2.0)).abs() < NEAR, "{wrong}");
    let far = 4.0 * 0.75_f64.sqrt();
    let other = sessions
        .iter()
        .map(|s| s.likeliest_apart)
        .fold(0.0, f64::max);
    assert!((other - far).abs() < 1e-5, "{other} {far}");
    // Naming both where they are near each other, the truth is missed less often.
    assert!(share(&sessions, |session| !session.named) < wrong);
}

#[test]
fn a_phase_makes_two_directions_one_effect() {
    let vectors = vec![vec![1.0, 0.0, 0.0, 0.0], vec![0.0, 1.0, 0.0, 0.0]];
    let ideal = along_readings(&[(laws::GAUGE_PERIODIC, vectors)], 9.0);
    // Without an effect the squared length is exponential: passes 9 with a chance of exp(-9/2).
    let none = ideal.sessions((laws::GAUGE_PERIODIC, &Place::Structure), 0.0, SESSIONS, 7);
    let found = share(&none, |session| session.found);
    assert!((found - (-4.5_f64).exp()).abs() < NEAR / 2.0, "{found}");
}

#[test]
fn a_law_of_fixed_size_is_compared_with_an_effect_of_that_size() {
    let mut ideal = along_readings(&[(laws::LOOSE_MEMBER, vec![vec![1.0, 0.0, 0.0, 0.0]])], 9.0);
    let left =
        |ideal: &IdealSearch, effect: [f32; 4]| ideal.left_by(&ideal.candidates[0], &effect, 4.0);
    let along = [0.6, 0.8, 0.0, 0.0];
    let against = [-1.0, 0.0, 0.0, 0.0];
    // With any size what lies across is left, 4 times 0.8; with three standard errors 0.6 of them too much; what points the other way adds.
    assert!((left(&ideal, along) - 3.2).abs() < 1e-6);
    assert!((left(&ideal, against) - 4.0).abs() < 1e-6);
    ideal.candidates[0].shapes[0].sizes = [3.0, 3.0];
    assert!((left(&ideal, along) - 3.2_f64.hypot(0.6)).abs() < 1e-6);
    assert!((left(&ideal, against) - 7.0).abs() < 1e-6);
}

#[test]
fn what_is_not_searched_has_no_sessions() {
    let ideal = along_readings(&[(laws::CREEP, vec![vec![1.0, 0.0, 0.0, 0.0]])], 9.0);
    assert!(
        ideal
            .sessions((laws::SETTING_IN, &Place::Structure), 4.0, 10, 8)
            .is_empty()
    );
}
