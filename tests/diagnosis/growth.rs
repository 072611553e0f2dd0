//! Time and memory of a diagnosis as the number of readings grows:
//! `cargo test --release --test stiffbench -- --ignored --nocapture time_and_memory`.

use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::support::tables::Table;

/// How often the memory of the program is looked at.
const LOOK: Duration = Duration::from_millis(5);

/// Largest memory of a process so far, MB, as Linux counts it.
fn peak_mb(process: u32) -> Option<f64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes / 1024.0)
}

/// Seconds and memory of a diagnosis, by a process of its own: other tests run in this one.
fn diagnosed(table: &Table, model: &str) -> (f64, Option<f64>) {
    let desk = TempDir::new().unwrap();
    std::fs::write(desk.path().join("session.csv"), table.text()).unwrap();
    let start = Instant::now();
    let mut program = Command::new(env!("CARGO_BIN_EXE_stiffbench"))
        .current_dir(&desk)
        .args(["diagnose", "session.csv", "--json"])
        .args(model.split_whitespace())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut memory = None;
    let ended = loop {
        memory = peak_mb(program.id()).or(memory);
        if let Some(ended) = program.try_wait().unwrap() {
            break ended;
        }
        sleep(LOOK);
    };
    assert!(ended.success());
    (start.elapsed().as_secs_f64(), memory)
}

#[test]
#[ignore = "half a minute; `just nightly` runs it"]
fn time_and_memory_grow_with_the_readings() {
    let mut seconds = Vec::new();
    let mut memory = Vec::new();
    let model = "--robot hp-robot --mechanism F --factors m_fsd";
    for (repeats, readings) in [(13, 2340), (25, 4500), (50, 9000)] {
        let options = format!("{model} --procedure load-unload --repeats {repeats} --seed 7");
        let table = Table::simulated(&options, &["joint-compliance@A3:c=2urad/(N*m)"]);
        assert_eq!(table.len(), readings);
        let (of_this, peak) = diagnosed(&table, model);
        seconds.push(of_this);
        memory.extend(peak);
        println!("{readings} readings: {of_this:.2} s, {memory:.0?} MB");
    }
    // Twice the readings take about twice as long; three times leaves room for a busy machine.
    assert!(seconds[2] < 3.0 * seconds[1], "{seconds:?}");
    if let [_, half, whole] = memory[..] {
        assert!(whole < 300.0, "{memory:?}");
        assert!(whole < 2.2 * half, "{memory:?}");
    }
}
