//! Long recordings with fewer readings.

use stiffbench_measurement::specimen::{SpecimenOptions, SpecimenTable, read_specimen};

/// Readings of one way of a triangle of 0 to 250 µm.
const ONE_WAY: usize = 250;

fn triangle(readings: usize) -> SpecimenTable {
    let path = |k: usize| (k % (2 * ONE_WAY)).min(2 * ONE_WAY - k % (2 * ONE_WAY));
    let rows = (0..readings).map(|k| format!("{},{}\n", path(k), 2 * path(k)));
    let text = format!("d_um,F_N\n{}", rows.collect::<String>());
    let options = SpecimenOptions {
        force_column: Some("F_N".to_owned()),
        displacement_column: "d_um".to_owned(),
        ..SpecimenOptions::default()
    };
    read_specimen(&[("pull.csv", text.as_bytes())], &options).unwrap()
}

#[test]
fn of_a_long_recording_every_kth_reading_is_used_and_each_turn() {
    let table = triangle(2001);
    let thinned = table.clone().thinned(300);
    // Every 7th, the turns at 250, 500 … 1750 unless they are among them (1750 is), and the last.
    let lines: Vec<u32> = thinned.readings.iter().map(|one| one.line - 2).collect();
    let turns = [250, 500, 750, 1000, 1250, 1500];
    for line in turns.into_iter().chain([0, 7, 2000]) {
        assert!(lines.contains(&line), "{line}");
    }
    assert_eq!(lines.len(), 286 + turns.len() + 1);
    let said = thinned.assumptions.last().unwrap();
    assert!(said.starts_with("293 of 2001 readings were used: every 7th of each run"));
    // What stays is as it was.
    for kept in &thinned.readings {
        assert!(table.readings.contains(kept));
    }
}

#[test]
fn a_short_recording_stays_as_it_is() {
    let table = triangle(300);
    assert_eq!(table.clone().thinned(300), table);
    assert_eq!(table.clone().thinned(100_000), table);
}
