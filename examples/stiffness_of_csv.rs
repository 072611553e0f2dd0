//! Turns a CSV file of readings into stiffness with uncertainty. It needs no robot.

use std::error::Error;
use std::fmt::Write;
use std::path::Path;

use stiffbench::analysis::{LoadedSession, OpenSettings};
use stiffbench::stiffness::{Branches, Method};

/// A simulated session that comes with the program.
const READINGS: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/data/sessions/demo/readings.csv"
);

#[expect(clippy::print_stdout, reason = "an example prints its result")]
fn main() -> Result<(), Box<dyn Error>> {
    print!("{}", report()?);
    Ok(())
}

/// What the example prints.
pub(crate) fn report() -> Result<String, Box<dyn Error>> {
    let session = LoadedSession::open(Path::new(READINGS), &OpenSettings::default())?;
    let table = session.stiffness(Branches::LoadingOnly)?;
    let mut text = format!("{} readings\n", session.table.readings.len());
    for row in &table.cells {
        match row.by(Method::Regression) {
            Ok(found) => {
                // From N/m to N/mm.
                let k = found.estimate.value * 1e-3;
                let u = found
                    .estimate
                    .expanded_95()
                    .map(|u| format!("{:.2}", u * 1e-3));
                let u = u.unwrap_or_else(|| "unknown".to_owned());
                writeln!(text, "{}: {k:.2} N/mm, U = {u} N/mm", row.cell)?;
            }
            Err(reason) => writeln!(text, "{}: {reason}", row.cell)?,
        }
    }
    Ok(text)
}
