//! Diagnoses a simulated session of a robot with play in one joint: the verdict names the joint and the size of the play.

use std::error::Error;
use std::fmt::Write;

use stiffbench::analysis::{
    Data, DiagnoseSettings, DiagnosisData, LoadedSession, ModelChoice, named_procedure, resolve,
};
use stiffbench::bench::{Jack, NoiseModel, VirtualBench};

/// Play of 30 µrad in joint A3.
const PLAY: &str = "joint-backlash@A3:play=30urad,seat_moment=9N*m";

#[expect(clippy::print_stdout, reason = "an example prints its result")]
fn main() -> Result<(), Box<dyn Error>> {
    print!("{}", report()?);
    Ok(())
}

/// What the example prints.
pub(crate) fn report() -> Result<String, Box<dyn Error>> {
    let beams = ModelChoice {
        robot: Some("hp-robot".to_owned()),
        mechanism: Some("A".to_owned()),
        ..ModelChoice::default()
    };
    let mut with_play = beams.clone();
    with_play.effects = vec![PLAY.parse()?];
    let truth = resolve(&with_play, None)?;

    // Readings as they would come from a bench, with noise.
    let (mut procedure, _) = named_procedure("load-unload")?;
    procedure.poses = Some(
        truth
            .robot
            .poses
            .iter()
            .map(|pose| pose.id.clone())
            .collect(),
    );
    let (noise, jack) = (NoiseModel::default(), Jack::default());
    let bench = VirtualBench::new(&truth.robot, &truth.physics, &truth.factors, noise, jack)?;
    let session = LoadedSession::from_table("simulated", bench.run(&procedure, "simulated", 5)?)?;

    // The search knows the beams only.
    let mut data = DiagnosisData::new(&Data::Readings(vec![session]), &beams)?;
    let report = data.diagnose(DiagnoseSettings::default(), &|| ())?;
    let mut text = format!("verdict: {}\n", report.diagnosis.verdict);
    for finding in &report.diagnosis.findings {
        writeln!(text, "{}", finding.effect)?;
    }
    Ok(text)
}
