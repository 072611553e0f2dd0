use stiffbench_beams::physics::laws;
use stiffbench_diagnosis::mismatch::SearchOptions;
use stiffbench_diagnosis::search::LAW_LEVEL;
use stiffbench_numeric::statistics::normal_upper_tail;
use stiffbench_units_and_text::source_text::SourceText;

use super::*;
use crate::prove::session::{SessionTexts, ValidationSession};
use crate::prove::trial_bench::{NoiseKind, TrialBench};

/// A law along some vectors, of any positive size.
fn along(law: Law, units: Vec<Vec<f64>>, critical_value: f64) -> WhiteLaw {
    WhiteLaw {
        law,
        place: Place::Structure,
        wide: false,
        critical_value,
        shapes: vec![WhiteLawShape {
            units,
            sizes: [0.0, f64::INFINITY],
        }],
    }
}

/// A search along the first readings, one law for each, at a common critical value.
fn along_readings(laws: &[(Law, Vec<Vec<f64>>)], critical_value: f64) -> IdealSearch {
    let laws = laws.iter();
    IdealSearch::new(
        laws.map(|(law, units)| along(*law, units.clone(), critical_value))
            .collect(),
    )
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
    let (cosine, sine) = (0.5, 0.75_f64.sqrt());
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
    let mut law = along(laws::LOOSE_MEMBER, vec![vec![1.0, 0.0, 0.0, 0.0]], 9.0);
    let left = |law: &WhiteLaw, effect: [f64; 4]| left_by(law, &effect, 4.0);
    let across = [0.6, 0.8, 0.0, 0.0];
    let against = [-1.0, 0.0, 0.0, 0.0];
    // With any size what lies across is left, 4 times 0.8; with three standard errors 0.6 of them too much; what points the other way adds.
    assert!((left(&law, across) - 3.2).abs() < 1e-6);
    assert!((left(&law, against) - 4.0).abs() < 1e-6);
    law.shapes[0].sizes = [3.0, 3.0];
    assert!((left(&law, across) - 3.2_f64.hypot(0.6)).abs() < 1e-6);
    assert!((left(&law, against) - 7.0).abs() < 1e-6);
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

/// Null samples and sessions of the observer are two ways to the same chances: over few vectors, and over all of them.
#[test]
fn with_known_noise_the_false_alarm_rate_is_the_level_of_the_laws() {
    const SESSIONS: usize = 8000;
    let text = |path: &str| stiffbench_test_files::text(&format!("data/concealed/{path}"));
    let session = ValidationSession::read(&SessionTexts {
        id: "011ef44b".to_owned(),
        header: SourceText::new("session.toml", text("sessions/011ef44b/session.toml")),
        readings: text("sessions/011ef44b/readings.csv").to_owned(),
        robot: SourceText::new("robot", text("robots/serial-arm-more-poses.toml")),
    })
    .unwrap();
    let options = SearchOptions::default();
    let bench = TrialBench::new(&session, NoiseKind::Normal, &options, 0, 77).unwrap();
    let ideal = bench.ideal().unwrap();
    let run = &bench.plan.runs[bench.plan.runs.len() / 2];
    let cell = &bench.plan.cells[run.cell];
    let slip = Place::Run {
        pose: bench.plan.poses[cell.pose].clone(),
        direction: (cell.axis()).into(),
        repeat: run.repeat,
        step: 7,
        gauge: None,
    };
    let found = |size: f64| {
        let sessions = ideal.sessions((laws::SLIP, &slip), size, SESSIONS, 3);
        assert_eq!(sessions.len(), SESSIONS);
        share(&sessions, |session| session.found)
    };
    // Four standard errors of the share of the sessions, and of the critical values, which 10 000 samples determine.
    let alarms = found(0.0);
    let near = 4.0 * (LAW_LEVEL * (1.0 / SESSIONS as f64 + 1.0 / 10_000.0)).sqrt();
    assert!((alarms - LAW_LEVEL).abs() < near, "{alarms}");
    // The slip itself passes its critical value in 80 %; with what noise adds elsewhere and at the steps beside it a little more is found.
    let limit = bench.critical.laws.of((laws::SLIP, false)).sqrt();
    let seen = found(limit + 0.84);
    assert!((0.78..0.87).contains(&seen), "{seen}");
    // The same seed gives the same sessions, whatever the number of threads.
    let again = || ideal.sessions((laws::SLIP, &slip), 5.0, 100, 9);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    assert_eq!(pool.install(again), again());
}
