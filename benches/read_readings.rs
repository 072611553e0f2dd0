//! Reading a table of a million readings, all columns, from memory.
//!
//! The peer is `benches/peers/read_csv.py` (csv module, NumPy, pandas) on a table of the same columns.

#![expect(
    clippy::unwrap_used,
    reason = "a benchmark stops at what is not as it must be"
)]

use std::fmt::Write as _;
use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use stiffbench::readings::read_readings;

/// Rows of the table.
const ROWS: usize = 1_000_000;

/// A table as a long session writes it: runs of 15 steps up and down in many poses.
fn table() -> String {
    let mut text = String::from(
        "session,seq,utc,t_s,pose,direction,branch,step,target_N,repeat,attempt,force_N,force_raw,displacement_um,displacement_raw,\
         hold_s,temp_degC,status,flag,note\n",
    );
    for row in 0..ROWS {
        let (run, step) = (row / 15, row % 15);
        let level = if step < 8 { step } else { 14 - step };
        let branch = if step < 8 { "loading" } else { "unloading" };
        let (repeat, cell) = (run % 5 + 1, run / 5);
        let (pose, direction) = (cell / 3, ["x", "y", "z"][cell % 3]);
        let force = -10.0 * level as f64 - (row % 7) as f64 * 0.1;
        let displacement = force * (3.0 + (pose % 11) as f64) + (row % 5) as f64;
        writeln!(
            text,
            "s1,{row},2026-11-20T08:00:00Z,{}.5,Q{pose},{direction},{branch},{step},{},{repeat},1,{force:.1},{force:.1},{displacement:.0},\
             {displacement:.0},5.0,21.3,accepted,,",
            row * 12,
            -10.0 * level as f64
        )
        .unwrap();
    }
    text
}

fn read(criterion: &mut Criterion) {
    let text = table();
    let mut group = criterion.benchmark_group("read_readings");
    group
        .sample_size(10)
        .measurement_time(Duration::from_secs(15))
        .throughput(Throughput::Elements(ROWS as u64));
    group.bench_function("one_million_rows", |bencher| {
        bencher.iter(|| {
            read_readings("table", black_box(text.as_bytes()))
                .unwrap()
                .readings
                .len()
        });
    });
    group.finish();
}

criterion_group!(benches, read);
criterion_main!(benches);
