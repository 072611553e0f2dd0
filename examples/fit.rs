//! Fits the beam factors of a robot to a session, and tests the fit on poses that it has not seen.

use std::error::Error;
use std::fmt::Write;
use std::path::Path;

use stiffbench::analysis::{Data, FitData, FitSettings, ModelChoice, OpenSettings};
use stiffbench::stiffness::Method;

/// A simulated session that comes with the program; its `session.toml` names the robot.
const SESSION: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/data/sessions/demo");

#[expect(clippy::print_stdout, reason = "an example prints its result")]
fn main() -> Result<(), Box<dyn Error>> {
    print!("{}", report()?);
    Ok(())
}

/// What the example prints.
pub(crate) fn report() -> Result<String, Box<dyn Error>> {
    let data = Data::open(Path::new(SESSION), &OpenSettings::default())?;
    let data = FitData::new(data, &ModelChoice::default(), Method::Regression)?;
    let settings = FitSettings {
        train: Some(["P1", "P3", "P4"].map(str::to_owned).to_vec()),
        ..FitSettings::default()
    };
    let fit = data.fit(&settings, &|| ())?;
    let mut text = String::new();
    for factor in &fit.estimates {
        let value = factor.value;
        match factor.interval_95 {
            Some([lower, upper]) => {
                writeln!(
                    text,
                    "{}: {value:.4}, 95 % {lower:.4} to {upper:.4}",
                    factor.name
                )?;
            }
            None => writeln!(
                text,
                "{}: {value:.4}, {}",
                factor.name,
                factor.status.word()
            )?,
        }
    }
    if let Some(error) = fit.max_error_percent() {
        writeln!(text, "largest error of a predicted stiffness: {error:.1} %")?;
    }
    Ok(text)
}
