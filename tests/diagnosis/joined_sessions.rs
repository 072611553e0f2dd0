//! Two sessions of one arm with one effect: together they determine its size better than either alone.

use serde_json::Value;
use tempfile::TempDir;

use crate::support::Json;
use crate::support::tables::{Table, json};

const TRUTH: f64 = 3e-6;

/// Size of the spring of joint S2 that is found, and half its 95 % interval.
fn size(diagnosis: &Value) -> (f64, f64) {
    let mut findings = diagnosis["findings"].list().iter();
    let own = findings.find(|one| one["place"]["joint"] == "S2");
    let own = own.unwrap_or_else(|| panic!("{}", diagnosis["headline"]));
    let size = own["parameters"].as_object().unwrap().values().next();
    let size = size.unwrap();
    let [low, high] = [0, 1].map(|end| size["ci95"][end].number());
    (size["value"].number(), 0.5 * (high - low))
}

#[test]
fn together_two_sessions_determine_an_effect_better_than_each() {
    let desk = TempDir::new().unwrap();
    let spring = format!("joint-compliance@S2:c={TRUTH}rad/(N*m)");
    let sessions = [
        ("first", "--poses P1,P2,P3 --seed 3"),
        ("second", "--poses P2,P3,P4 --seed 4 --reading-sd-um 9"),
    ];
    let [first, second] = sessions.map(|(name, options)| {
        let options = format!("--robot serial-arm --procedure sweeps {options}");
        let file = desk.path().join(format!("{name}.csv"));
        let table = Table::simulated(&options, &[&spring]);
        std::fs::write(&file, table.text()).unwrap();
        file.display().to_string()
    });
    let diagnosed =
        |files: &str| json(&format!("diagnose {files} --robot serial-arm"), &[])["data"].take();
    let both = diagnosed(&format!("{first} {second}"));
    assert_eq!(both["verdict"], "explained");
    let (value, half) = size(&both);
    assert!(
        (value - TRUTH).abs() < 4.0 * half / 1.96,
        "{value} ± {half}"
    );
    let each = [first, second].map(|file| size(&diagnosed(&file)).1);
    assert!(
        each.iter().all(|alone| half < 0.98 * alone),
        "{half} {each:?}"
    );
    let sd = |session: usize| both["sessions"][session]["reading_sd_um"].number();
    assert!((2.5..3.8).contains(&sd(0)), "{}", sd(0));
    assert!((8.0..10.5).contains(&sd(1)), "{}", sd(1));
}
